//! `cargo xtask test`: every test there is, each where it can run, and at the end what ran where.
//!
//! A test that needs something which `cargo test` cannot give is marked `#[ignore = "..."]`; the name of its file begins
//! with the name of the [`PLACES`] where it is run. A test that is ignored and that no place takes is an error, and so is a
//! file of a place without tests.

pub mod binaries;
mod report;

use crate::setup;
use crate::vcan::{self, Options, Place};
use crate::{cargo, cross, lint};
use anyhow::{Context, bail, ensure};
use binaries::Binary;
use report::{Report, count_passed};
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Runs the ignored tests of these binaries.
type Run = fn(&[Binary]) -> anyhow::Result<Outcome>;

/// Names with which the files of ignored tests begin, and what runs them.
const PLACES: [(&str, Run); 2] = [("socketcan", with_can), ("firmware", cross::in_emulator)];

/// Time limit of all the tests with a CAN interface together.
const WITH_CAN_LIMIT: Duration = Duration::from_secs(600);

/// What came of tests that have passed.
pub struct Outcome {
    /// Where they ran.
    pub place: String,
    /// How many.
    pub passed: u32,
}

/// Lints and all tests.
pub fn run() -> anyhow::Result<()> {
    setup::everything()?;
    lint::run()?;
    let mut report = Report::default();
    // Unit and property tests with checks on, then the whole system as people run it, optimised.
    for (what, args) in [
        ("unit and property tests", &["test", "--workspace", "--exclude", "tactus-tests"][..]),
        ("whole system", &["test", "--release", "--package", "tactus-tests"][..]),
    ] {
        let started = Instant::now();
        let passed = cargo_test(args)?;
        report.add(what, "here", passed, started.elapsed());
    }
    elsewhere(&mut report)?;
    report.print();
    Ok(())
}

/// Only the tests of the [`PLACES`].
pub fn run_elsewhere() -> anyhow::Result<()> {
    setup::everything()?;
    let mut report = Report::default();
    elsewhere(&mut report)?;
    report.print();
    Ok(())
}

/// The ignored tests, each in its place.
fn elsewhere(report: &mut Report) -> anyhow::Result<()> {
    let mut all = binaries::build(&["--workspace", "--exclude", "tactus-tests"])?;
    all.extend(binaries::build(&["--release", "--package", "tactus-tests"])?);
    for binary in &all {
        let taken = PLACES.iter().any(|(name, _)| binary.name.starts_with(name));
        let ignored = binary.ignored()?;
        match ignored.first() {
            Some(test) if !taken => bail!("{}: the test {test} is ignored, and no place runs it", binary.name),
            None if taken => bail!("{}: no test in it is ignored, so none would run in its place", binary.name),
            Some(_) | None => {}
        }
    }
    for (name, place) in PLACES {
        let binaries: Vec<Binary> = all.iter().filter(|b| b.name.starts_with(name)).cloned().collect();
        ensure!(!binaries.is_empty(), "no test file whose name begins with {name}");
        let started = Instant::now();
        let outcome = place(&binaries)?;
        report.add(name, &outcome.place, outcome.passed, started.elapsed());
    }
    Ok(())
}

/// Tests with a CAN interface: one environment for all.
fn with_can(binaries: &[Binary]) -> anyhow::Result<Outcome> {
    let mut tactus = OsString::from(format!("{}=", binaries::COMMAND));
    tactus.push(binaries::command()?);
    let counts = cargo::target_folder().join("vcan-tests-passed");
    let mut command: Vec<OsString> = vec!["env".into(), tactus];
    command.push(std::env::current_exe().context("where is this program?")?.into());
    command.push("run-ignored".into());
    command.push(counts.clone().into());
    command.extend(binaries.iter().map(|binary| binary.path.clone().into()));
    let _ = std::fs::remove_file(&counts);
    let status = vcan::run(&command, Options { limit: WITH_CAN_LIMIT, quiet: false })?;
    ensure!(status == 0, "tests with a CAN interface failed (exit status {status})");
    let text = std::fs::read_to_string(&counts).context("no count of the tests with a CAN interface")?;
    let passed = text.trim().parse().context("the count of the tests with a CAN interface")?;
    Ok(Outcome { place: Place::here().name().to_owned(), passed })
}

/// Runs the ignored tests of these binaries one after the other, and writes the number of those that passed to a file.
pub fn run_ignored(counts: &PathBuf, binaries: &[PathBuf]) -> anyhow::Result<()> {
    let mut all = 0;
    let mut failed = Vec::new();
    for binary in binaries {
        let mut command = Command::new(binary);
        command.args(["--ignored", "--test-threads=1"]);
        match passing_on(&mut command, &binary.display().to_string()) {
            Ok(0) => failed.push(format!("{}: no test ran", binary.display())),
            Ok(passed) => all += passed,
            Err(error) => failed.push(error.to_string()),
        }
    }
    ensure!(failed.is_empty(), "{}", failed.join("; "));
    std::fs::write(counts, all.to_string()).context("cannot write the number of tests")
}

/// Runs cargo's tests; how many passed.
fn cargo_test(args: &[&str]) -> anyhow::Result<u32> {
    let line = format!("cargo {}", args.join(" "));
    eprintln!("xtask: {line}");
    let passed = passing_on(&mut cargo::command(args), &line)?;
    ensure!(passed > 0, "`{line}`: no test ran");
    Ok(passed)
}

/// Runs a command that runs tests, passes its output on, and counts the tests that have passed.
pub fn passing_on(command: &mut Command, line: &str) -> anyhow::Result<u32> {
    let mut child = command.stdout(Stdio::piped()).spawn().with_context(|| format!("cannot start `{line}`"))?;
    let output = child.stdout.take().context("no output")?;
    let mut passed = 0;
    for line in BufReader::new(output).lines() {
        let line = line.context("the output of tests")?;
        passed += count_passed(&line);
        println!("{line}");
    }
    let status = child.wait()?;
    ensure!(status.success(), "`{line}` failed ({status})");
    Ok(passed)
}
