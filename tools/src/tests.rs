//! `cargo xtask test`: every test there is, each where it can run, and at the end what ran where.
//!
//! A test that needs what `cargo test` cannot give is marked `#[ignore = "needs ..."]`, and the name of its file begins
//! with the name of one of the [`PLACES`], which run it. A test that needs something and that no place takes is an error,
//! and so is a file of a place without such tests. (Other ignored tests are reports for people.)

pub mod binaries;
mod needs;
mod report;

use crate::setup;
use crate::vcan::{self, Options};
use crate::{cargo, cross, lint};
use anyhow::{Context, ensure};
use binaries::Binary;
use report::{Report, count_passed};
use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What runs the tests of files whose names begin alike.
struct Place {
    /// How their names begin.
    files: &'static str,
    /// Packages that may have such files, with the profile in which they are built: the selections of the tests that run
    /// here, so that nothing is built twice with other features.
    packages: &'static [&'static [&'static str]],
    /// Runs the ignored tests of these binaries; where they ran, and how many have passed.
    run: fn(&[Binary]) -> anyhow::Result<(String, u32)>,
}

/// Unit and property tests, with checks on.
const UNITS: &[&str] = &["--workspace", "--exclude", "tactus-tests"];
/// The whole system as people run it, optimised.
const WHOLE: &[&str] = &["--release", "--package", "tactus-tests"];

/// All places.
const PLACES: &[Place] = &[
    Place { files: "socketcan", packages: &[UNITS, WHOLE], run: with_can },
    Place { files: "firmware", packages: &[WHOLE], run: cross::in_emulator },
];

/// Time limit of all the tests with a CAN interface together.
const WITH_CAN_LIMIT: Duration = Duration::from_secs(900);

/// Time limit of one seed of the soak.
const SOAK_LIMIT: Duration = Duration::from_secs(900);

/// Lints and all tests.
pub fn run() -> anyhow::Result<()> {
    setup::everything()?;
    lint::run()?;
    let mut report = Report::default();
    for (what, args) in [("unit and property tests", UNITS), ("whole system", WHOLE)] {
        let started = Instant::now();
        let passed = cargo_test(&[&["test"], args].concat())?;
        report.add(what, "here", passed, started.elapsed());
    }
    elsewhere(PLACES, &mut report)?;
    report.print();
    Ok(())
}

/// Only the tests of the place whose files' names begin so.
pub fn run_only(files: &str) -> anyhow::Result<()> {
    setup::everything()?;
    let place = PLACES.iter().position(|place| place.files == files);
    let names = PLACES.iter().map(|place| place.files).collect::<Vec<_>>().join(", ");
    let place = place.with_context(|| format!("--only {files}: expected one of {names}"))?;
    let mut report = Report::default();
    elsewhere(&PLACES[place..=place], &mut report)?;
    report.print();
    Ok(())
}

/// The tests that need something, each in its place.
fn elsewhere(places: &[Place], report: &mut Report) -> anyhow::Result<()> {
    let files: Vec<&str> = PLACES.iter().map(|place| place.files).collect();
    let homeless = needs::homeless(&cargo::root(), &files)?;
    ensure!(homeless.is_empty(), "tests that need something, in files that no place runs: {}", homeless.join(", "));
    for place in places {
        let started = Instant::now();
        let mut binaries = Vec::new();
        for package in place.packages {
            binaries.extend(binaries::build(package, place.files)?);
        }
        for binary in &binaries {
            ensure!(!binary.ignored()?.is_empty(), "{}: no test in it is ignored, so none would run", binary.name);
        }
        ensure!(!binaries.is_empty(), "no test file whose name begins with {}", place.files);
        let (where_, passed) = (place.run)(&binaries)?;
        report.add(place.files, &where_, passed, started.elapsed());
    }
    Ok(())
}

/// Tests with a CAN interface: one environment for all.
fn with_can(binaries: &[Binary]) -> anyhow::Result<(String, u32)> {
    let counts = cargo::target_folder().join("vcan-tests-passed");
    let command = in_one_go(binaries, &counts)?;
    // Left over from an earlier run; that there is none is fine.
    let _ = std::fs::remove_file(&counts);
    let status = vcan::run(&command, Options { limit: WITH_CAN_LIMIT, quiet: false })?;
    ensure!(status == 0, "tests with a CAN interface failed (exit status {status})");
    let text = std::fs::read_to_string(&counts).context("no count of the tests with a CAN interface")?;
    let passed = text.trim().parse().context("the count of the tests with a CAN interface")?;
    Ok((vcan::Place::here().name().to_owned(), passed))
}

/// The command line that runs the ignored tests of these binaries and writes their number to a file.
fn in_one_go(binaries: &[Binary], counts: &Path) -> anyhow::Result<Vec<OsString>> {
    let mut tactus = OsString::from(format!("{}=", binaries::COMMAND));
    tactus.push(binaries::command()?);
    let this = std::env::current_exe().context("where is this program?")?;
    let mut command: Vec<OsString> = vec!["env".into(), tactus, this.into(), "run-ignored".into(), counts.into()];
    command.extend(binaries.iter().map(|binary| binary.path.clone().into()));
    Ok(command)
}

/// The long repeats on a real bus: `count` seeds from `seed` on.
pub fn soak(seed: u64, count: u64) -> anyhow::Result<()> {
    let binaries = binaries::build(&["--release", "--package", "tactus-tests"], "soak")?;
    let mut command: Vec<OsString> =
        vec!["env".into(), format!("TACTUS_SOAK_SEED={seed}").into(), format!("TACTUS_SOAK_COUNT={count}").into()];
    let counts = cargo::target_folder().join("soak-passed");
    command.extend(in_one_go(&binaries, &counts)?);
    let limit = SOAK_LIMIT * u32::try_from(count).unwrap_or(u32::MAX).max(1);
    let status = vcan::run(&command, Options { limit, quiet: false })?;
    ensure!(status == 0, "soak failed (exit status {status})");
    Ok(())
}

/// Runs the ignored tests of these binaries, and writes the number of those that passed to a file.
pub fn run_ignored(counts: &Path, binaries: &[PathBuf]) -> anyhow::Result<()> {
    let passed = ignored_tests(binaries)?;
    std::fs::write(counts, passed.to_string()).context("cannot write the number of tests")
}

/// Runs the ignored tests of these binaries one after the other; how many passed.
fn ignored_tests(binaries: &[PathBuf]) -> anyhow::Result<u32> {
    let mut all = 0;
    let mut failed = Vec::new();
    for binary in binaries {
        let mut command = Command::new(binary);
        command.args(["--ignored", "--test-threads=1", "--nocapture"]);
        match passing_on(&mut command, &binary.display().to_string()) {
            Ok(0) => failed.push(format!("{}: no test ran", binary.display())),
            Ok(passed) => all += passed,
            Err(error) => failed.push(error.to_string()),
        }
    }
    ensure!(failed.is_empty(), "{}", failed.join("; "));
    Ok(all)
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
