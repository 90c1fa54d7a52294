//! `cargo xtask bench`: what a pose update costs, in time beside other crates, and in instructions beside a reference.
//!
//! Times on a shared machine say little; instructions repeat. So the times are printed as ratios of one run, and the
//! instructions are held against `firmware/instructions.toml`: `--check` does that alone, in a few seconds.

mod callgrind;
mod machine;
mod reference;

use crate::cargo;
use crate::setup::{self, need};
use crate::tests::binaries::{self, Binary};
use anyhow::{Context, ensure};
use callgrind::Count;
use reference::Reference;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The crates that ours is compared with; their versions are those of Cargo.lock.
const RIVALS: &[&str] = &["argmin", "basin", "cmaes"];
/// The feature of `tactus-tests` that brings them.
const RIVALS_FEATURE: &str = "rivals";
/// The contender that the others are set in relation to.
const DEFAULT: &str = "tactus default update";

/// What to do.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Only the instructions of ours, and fail where one is dearer than its reference allows.
    pub check: bool,
    /// Only the instructions of ours, which become the reference.
    pub accept: bool,
    /// Write everything to this file too.
    pub json: Option<PathBuf>,
}

/// Runs it.
///
/// # Errors
/// One line: what is missing, what failed, or which count has risen.
pub fn run(options: &Options) -> anyhow::Result<()> {
    need(&[setup::BENCH])?;
    if options.check || options.accept {
        return instructions_alone(options);
    }
    let folder = folder()?;
    let machine = machine::Machine::here()?;
    println!("{machine}");
    let versions = versions()?;
    println!("against {}\n", versions.join(", "));
    let bench = binaries::bench("tactus-tests", "update", &[RIVALS_FEATURE])?;
    let times = folder.join("times.json");
    let status = Command::new(&bench.path)
        .arg("--json")
        .arg(&times)
        .status()
        .with_context(|| format!("cannot start {}", bench.path.display()))?;
    ensure!(status.success(), "{} --json failed ({status})", bench.path.display());
    let counts = callgrind::count(&bench.path, &folder)?;
    let reference = Reference::read()?;
    println!("\ninstructions (callgrind), {}", reference.made_with());
    print_counts(&counts, &reference);
    if let Some(file) = &options.json {
        let mut told: Value = serde_json::from_str(&std::fs::read_to_string(&times)?)?;
        let made = json!({ "command": "cargo xtask bench", "machine": machine.json(), "crates": versions });
        merge(&mut told, &made, &counts, &reference);
        std::fs::write(file, format!("{told:#}\n"))
            .with_context(|| format!("{}: cannot be written", file.display()))?;
        println!("written: {}", file.display());
    }
    Ok(())
}

/// Counts ours, without building any other crate, and holds the counts against the reference or makes them that.
fn instructions_alone(options: &Options) -> anyhow::Result<()> {
    let Binary { path, .. } = binaries::bench("tactus-tests", "update", &[])?;
    let counts = callgrind::count(&path, &folder()?)?;
    if options.accept {
        return Reference::of(&counts)?.write();
    }
    let reference = Reference::read()?;
    print_counts(&counts, &reference);
    reference.check(&counts)
}

fn print_counts(counts: &[Count], reference: &Reference) {
    let default = counts.iter().find(|c| c.what == DEFAULT).map(Count::each);
    println!("{:36} {:>13} {:>13} {:>8} {:>10}", "", "instructions", "reference", "change", "x default");
    for count in counts {
        let before = reference.of_what(&count.what);
        println!(
            "{:36} {:>13.0} {:>13} {:>8} {:>10}",
            count.what,
            count.each(),
            before.map_or_else(|| "-".to_owned(), |b| format!("{b:.0}")),
            before.map_or_else(|| "-".to_owned(), |b| format!("{:+.1} %", percent(count.each() / b - 1.0))),
            default.map_or_else(|| "-".to_owned(), |d| format!("{:.3}", count.each() / d)),
        );
    }
}

/// A share in percent with one decimal; nothing has no sign.
fn percent(share: f64) -> f64 {
    (share * 1000.0).round() / 10.0 + 0.0
}

/// Adds the counts to what the bench has written.
fn merge(told: &mut Value, made: &Value, counts: &[Count], reference: &Reference) {
    for key in ["command", "machine", "crates"] {
        told[key] = made[key].clone();
    }
    let figures = counts.iter().map(|count| {
        let note = match reference.of_what(&count.what) {
            Some(before) => format!("callgrind; reference {before:.0}, {}", reference.made_with()),
            None => "callgrind; no reference".to_owned(),
        };
        json!({ "name": format!("instructions: {}", count.what), "value": count.each().round(),
            "unit": "instructions", "note": note })
    });
    if let Some(list) = told["figures"].as_array_mut() {
        list.extend(figures);
    }
}

/// Where the bench leaves its files.
fn folder() -> anyhow::Result<PathBuf> {
    let folder = cargo::target_folder().join("bench");
    std::fs::create_dir_all(&folder).with_context(|| format!("{}: cannot be made", folder.display()))?;
    Ok(folder)
}

/// Name and version of each crate that ours is compared with.
fn versions() -> anyhow::Result<Vec<String>> {
    versions_in(&cargo::root().join("Cargo.lock"))
}

fn versions_in(lock: &Path) -> anyhow::Result<Vec<String>> {
    let text = std::fs::read_to_string(lock).with_context(|| format!("{}: cannot be read", lock.display()))?;
    let lock: toml::Value = toml::from_str(&text).context("Cargo.lock: not as expected")?;
    let packages = lock.get("package").and_then(toml::Value::as_array).context("Cargo.lock: no packages")?;
    let version = |name: &&str| {
        let package = packages.iter().find(|p| p.get("name").and_then(toml::Value::as_str) == Some(*name));
        let version = package.and_then(|p| p.get("version")).and_then(toml::Value::as_str);
        version.map(|version| format!("{name} {version}")).with_context(|| format!("Cargo.lock: no {name}"))
    };
    RIVALS.iter().map(version).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rival_is_in_the_lock_file() {
        let versions = versions().expect("all there");
        assert_eq!(versions.len(), RIVALS.len());
        assert!(versions.iter().zip(RIVALS).all(|(line, name)| line.starts_with(name)), "{versions:?}");
    }

    #[test]
    fn counts_join_the_figures_and_say_what_they_were_before() {
        let count = |what: &str| Count { what: what.to_owned(), instructions: 3000, times: 3 };
        let reference = Reference::of(&[count("known")]).expect("rustc is here");
        let mut told = json!({ "figures": [{ "name": "first" }] });
        merge(&mut told, &json!({ "command": "c" }), &[count("known"), count("new")], &reference);
        let figures = told["figures"].as_array().expect("a list");
        assert_eq!((figures.len(), &told["command"]), (3, &json!("c")));
        assert_eq!(figures[1]["value"], 1000.0);
        assert!(figures[1]["note"].as_str().expect("text").contains("reference 1000"));
        assert_eq!(figures[2]["note"], "callgrind; no reference");
    }
}
