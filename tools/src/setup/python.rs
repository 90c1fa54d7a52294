//! A Python environment of its own below `target/`, with the packages of `tests/recording/requirements.txt`: Debian's
//! Python takes none beside its own.

use super::program;
use crate::cargo;
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The packages, pinned.
const REQUIREMENTS: &str = include_str!("../../../tests/recording/requirements.txt");
/// What must be importable.
const IMPORTS: &str = "import mcap.reader, mcap_protobuf.decoder";

/// Where the environment is.
fn folder() -> PathBuf {
    cargo::target_folder().join("python")
}

/// Sees to it that the environment is there with these very packages.
///
/// # Errors
/// One line: what could not be made or fetched, and pip's own reason.
pub fn environment() -> anyhow::Result<()> {
    let folder = folder();
    if is_ready(&folder) {
        return Ok(());
    }
    let python = program("python3").context("missing: python3; install it with: apt-get install python3")?;
    let shown = folder.display().to_string();
    step("a Python environment", Command::new(python).args(["-m", "venv", "--clear", &shown]))?;
    let requirements = cargo::root().join("tests/recording/requirements.txt");
    let mut pip = Command::new(interpreter(&folder));
    pip.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-input", "--requirement"]);
    step("the packages of tests/recording/requirements.txt from PyPI", pip.arg(requirements))?;
    std::fs::write(stamp(&folder), REQUIREMENTS).with_context(|| shown.clone())?;
    if !is_ready(&folder) {
        bail!("{shown}: the packages of tests/recording/requirements.txt are there but cannot be imported");
    }
    Ok(())
}

/// The environment's Python.
fn interpreter(folder: &Path) -> PathBuf {
    folder.join("bin/python")
}

/// Says which packages the environment was made with.
fn stamp(folder: &Path) -> PathBuf {
    folder.join("requirements.txt")
}

/// Was it made with these packages, and does it work?
fn is_ready(folder: &Path) -> bool {
    let same = std::fs::read_to_string(stamp(folder)).is_ok_and(|made_with| made_with == REQUIREMENTS);
    let mut import = Command::new(interpreter(folder));
    import.args(["-c", IMPORTS]).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    same && import.status().is_ok_and(|status| status.success())
}

/// Says what is done and does it.
fn step(what: &str, command: &mut Command) -> anyhow::Result<()> {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    let line = words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ");
    eprintln!("xtask: {line}");
    let output = command.stdin(Stdio::null()).output().with_context(|| format!("cannot install {what}: {line}"))?;
    if output.status.success() {
        return Ok(());
    }
    let said = [output.stderr, output.stdout].concat();
    let text = String::from_utf8_lossy(&said).into_owned();
    let last = || text.lines().rev().find(|line| !line.trim().is_empty());
    let why = text.lines().find(|line| line.starts_with("ERROR:")).or_else(last).unwrap_or("no reason given");
    bail!("cannot install {what}: {why}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_is_no_environment_is_not_ready() {
        assert!(!is_ready(Path::new("/no/such/folder")));
    }

    #[test]
    fn a_step_that_fails_says_in_one_line_what_and_why() {
        let script = "echo ERROR: no such package; echo more; exit 1";
        let error = step("the packages", Command::new("sh").args(["-c", script])).unwrap_err();
        assert_eq!(error.to_string(), "cannot install the packages: ERROR: no such package");
    }

    #[test]
    fn every_package_is_pinned() {
        let packages = REQUIREMENTS.lines().filter(|line| !line.starts_with('#'));
        assert!(packages.clone().all(|line| line.contains("==")));
        assert_eq!(packages.count(), 5);
    }
}
