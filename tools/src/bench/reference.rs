//! `firmware/instructions.toml`: what a pose update took when it was last looked at.

use super::callgrind::Count;
use super::machine;
use crate::cargo;
use anyhow::{Context, bail, ensure};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Share by which a count may rise before it is a regression.
const TOLERANCE: f64 = 0.05;

/// The head of the file.
const HEAD: &str = "\
# Instructions on the host, counted by callgrind: means over 30 seeded problems (tests/src/problems.rs); searches with at
# most 100 evaluations. They depend on the compiler, so `cargo xtask bench --check` holds only what the same compiler has
# built against them; `cargo xtask bench --accept` writes them anew.

";

/// The file.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reference {
    /// The compiler: release and host.
    rustc: String,
    /// Share by which a count may rise.
    tolerance: f64,
    /// Instructions of one time, by what was done.
    instructions: BTreeMap<String, f64>,
}

impl Reference {
    fn path() -> PathBuf {
        cargo::root().join("firmware/instructions.toml")
    }

    /// Reads it.
    ///
    /// # Errors
    /// One line: what is wrong with the file.
    pub fn read() -> anyhow::Result<Self> {
        let path = Self::path();
        let text = std::fs::read_to_string(&path).with_context(|| {
            format!("{}: cannot be read; expected counts, as `cargo xtask bench --accept` writes them", path.display())
        })?;
        toml::from_str(&text).with_context(|| format!("{}: not as expected", path.display()))
    }

    /// These counts, made here.
    ///
    /// # Errors
    /// The compiler does not say what it is.
    pub fn of(counts: &[Count]) -> anyhow::Result<Self> {
        let instructions = counts.iter().map(|count| (count.what.clone(), count.each().round())).collect();
        Ok(Self { rustc: machine::rustc()?, tolerance: TOLERANCE, instructions })
    }

    /// Writes it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self) -> anyhow::Result<()> {
        let path = Self::path();
        let text = format!("{HEAD}{}", toml::to_string(self)?);
        std::fs::write(&path, text).with_context(|| format!("{}: cannot be written", path.display()))?;
        println!("written: {}", path.display());
        Ok(())
    }

    /// With which compiler the reference was made.
    pub fn made_with(&self) -> String {
        format!("reference made with rustc {}", self.rustc)
    }

    /// Instructions of one time, if there is a reference for it.
    pub fn of_what(&self, what: &str) -> Option<f64> {
        self.instructions.get(what).copied()
    }

    /// Holds counts against it.
    ///
    /// # Errors
    /// One line: another compiler, something not counted, or what has become dearer.
    pub fn check(&self, counts: &[Count]) -> anyhow::Result<()> {
        let here = machine::rustc()?;
        ensure!(
            here == self.rustc,
            "firmware/instructions.toml was made with rustc {}, this is {here}: counts of two compilers do not compare; \
             look at them, then `cargo xtask bench --accept`",
            self.rustc
        );
        self.compare(counts)
    }

    fn compare(&self, counts: &[Count]) -> anyhow::Result<()> {
        let mut dearer = Vec::new();
        for (what, before) in &self.instructions {
            let Some(count) = counts.iter().find(|count| count.what == *what) else {
                bail!("firmware/instructions.toml: {what} was not counted; expected it among the bench's contenders");
            };
            let rise = count.each() / before - 1.0;
            if rise > self.tolerance {
                dearer.push(format!("{what}: {:.0} instructions, {:+.1} %", count.each(), rise * 100.0));
            }
        }
        let unknown = counts.iter().find(|count| !self.instructions.contains_key(&count.what));
        if let Some(count) = unknown {
            bail!("firmware/instructions.toml: no {}; `cargo xtask bench --accept` adds it", count.what);
        }
        ensure!(
            dearer.is_empty(),
            "dearer than firmware/instructions.toml by more than {:.0} %: {}",
            self.tolerance * 100.0,
            dearer.join("; ")
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(what: &str, each: u64) -> Count {
        Count { what: what.to_owned(), instructions: 10 * each, times: 10 }
    }

    #[test]
    fn a_rise_beyond_the_tolerance_fails_and_names_itself() {
        let reference = Reference::of(&[counted("update", 1000), counted("error", 100)]).expect("rustc is here");
        let told = |update, error| reference.compare(&[counted("update", update), counted("error", error)]);
        assert!(told(1049, 100).is_ok());
        assert!(told(500, 100).is_ok(), "less is no regression");
        let complaint = told(1051, 100).expect_err("too much").to_string();
        assert!(complaint.contains("update: 1051 instructions, +5.1 %"), "{complaint}");
        assert!(!complaint.contains("error"), "{complaint}");
    }

    #[test]
    fn what_is_not_counted_or_has_no_reference_is_an_error() {
        let reference = Reference::of(&[counted("update", 1000)]).expect("rustc is here");
        assert!(reference.compare(&[counted("error", 100)]).is_err());
        assert!(reference.compare(&[counted("update", 1000), counted("error", 100)]).is_err());
    }

    #[test]
    fn another_compiler_is_said_to_be_another() {
        let mut reference = Reference::of(&[counted("update", 1000)]).expect("rustc is here");
        assert!(reference.check(&[counted("update", 1000)]).is_ok());
        reference.rustc = "1.0.0".to_owned();
        let complaint = reference.check(&[counted("update", 1000)]).expect_err("not comparable").to_string();
        assert!(complaint.contains("1.0.0") && complaint.contains("--accept"), "{complaint}");
    }

    #[test]
    fn what_is_written_can_be_read() {
        let reference = Reference::of(&[counted("update", 1000)]).expect("rustc is here");
        let text = format!("{HEAD}{}", toml::to_string(&reference).expect("plain"));
        let read: Reference = toml::from_str(&text).expect("as written");
        assert_eq!(read.of_what("update"), Some(1000.0));
    }
}
