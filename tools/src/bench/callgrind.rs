//! Instructions of a program's parts, counted by callgrind.
//!
//! The program does each part inside a function `measured`; callgrind counts there only and writes a dump at each of its
//! ends. So the n-th dump belongs to the n-th line that the program prints.

use crate::setup;
use anyhow::{Context, ensure};
use std::path::Path;
use std::process::{Command, Stdio};

/// The function, by the name that callgrind shows.
const MEASURED: &str = "update::measured";

/// What one part took.
#[derive(Clone, Debug, PartialEq)]
pub struct Count {
    /// What was done.
    pub what: String,
    /// Instructions, all times together.
    pub instructions: u64,
    /// How often it was done.
    pub times: u32,
}

impl Count {
    /// Instructions of one time.
    pub fn each(&self) -> f64 {
        self.instructions as f64 / f64::from(self.times.max(1))
    }
}

/// Counts the parts of `program`; dumps go to `folder`.
pub fn count(program: &Path, folder: &Path) -> anyhow::Result<Vec<Count>> {
    let valgrind =
        setup::program("valgrind").context("missing: valgrind; install it with: apt-get install valgrind")?;
    let dump = folder.join("callgrind.out");
    eprintln!("xtask: counting instructions of {}", program.display());
    let told = Command::new(valgrind)
        .arg("--tool=callgrind")
        .arg(format!("--callgrind-out-file={}", dump.display()))
        .arg("--combine-dumps=yes")
        .arg("--collect-atstart=no")
        .arg(format!("--toggle-collect={MEASURED}"))
        .arg(format!("--dump-after={MEASURED}"))
        .arg(program)
        .arg("--count")
        .stdin(Stdio::null())
        .output()
        .context("cannot start valgrind")?;
    let complaint = String::from_utf8_lossy(&told.stderr);
    let last = complaint.lines().last().unwrap_or_default();
    ensure!(told.status.success(), "{} --count under callgrind failed ({}): {last}", program.display(), told.status);
    let text = std::fs::read_to_string(&dump).with_context(|| format!("{}: callgrind left nothing", dump.display()))?;
    parts(&String::from_utf8_lossy(&told.stdout), &text)
}

/// Brings what the program says together with what callgrind counted.
fn parts(said: &str, dumps: &str) -> anyhow::Result<Vec<Count>> {
    let totals: Vec<u64> = dumps
        .lines()
        .filter_map(|line| line.strip_prefix("totals:"))
        .filter_map(|number| number.trim().parse().ok())
        .filter(|number| *number > 0)
        .collect();
    let said: Vec<(&str, u32)> =
        said.lines().filter_map(|line| line.split_once('\t')).filter_map(|(w, n)| Some((w, n.parse().ok()?))).collect();
    ensure!(
        !said.is_empty() && said.len() == totals.len(),
        "callgrind counted {} parts, the program did {}; expected as many, each inside {MEASURED}",
        totals.len(),
        said.len()
    );
    let count =
        |((what, times), instructions): ((&str, u32), u64)| Count { what: what.to_owned(), instructions, times };
    Ok(said.into_iter().zip(totals).map(count).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const DUMPS: &str = "part: 1\nevents: Ir\ntotals: 600\n\npart: 2\ntotals: 90\n\npart: 3\ntotals: 0\n";

    #[test]
    fn the_nth_dump_is_that_of_the_nth_line_and_the_empty_one_of_the_end_is_none() {
        let counts = parts("evaluation\t6\nupdate\t3\n", DUMPS).expect("two and two");
        assert_eq!(counts[0], Count { what: "evaluation".into(), instructions: 600, times: 6 });
        assert_eq!((counts[1].what.as_str(), counts[1].each()), ("update", 30.0));
    }

    #[test]
    fn a_part_that_was_not_counted_is_an_error() {
        assert!(parts("evaluation\t6\n", DUMPS).is_err());
        assert!(parts("a\t6\nb\t3\nc\t1\n", DUMPS).is_err());
        assert!(parts("", "").is_err());
    }
}
