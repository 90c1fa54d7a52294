//! The `tactus` command, built and run as people do.

use serde_json::Value;
use std::path::PathBuf;
use std::process::Command as Process;
use std::sync::OnceLock;

/// How the command is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// As `cargo build` does.
    Debug,
    /// As `cargo build --release` does.
    Release,
}

/// The variable that names the release profile's command where cargo is not to be asked (`cargo xtask test` sets it).
const BUILT: &str = "TACTUS_TESTS_COMMAND";

/// The command of this profile, built once in a process.
///
/// # Panics
/// If it cannot be built.
pub fn path(profile: Profile) -> PathBuf {
    static DEBUG: OnceLock<PathBuf> = OnceLock::new();
    static RELEASE: OnceLock<PathBuf> = OnceLock::new();
    let (built, args): (_, &[&str]) = match profile {
        // What `cargo xtask test` has built for the unit tests, with the same features: nothing is built twice. The one
        // program alone: `xtask` itself is running.
        Profile::Debug => (&DEBUG, &["--workspace", "--exclude", "tactus-tests", "--tests", "--bin", "tactus"]),
        Profile::Release => (&RELEASE, &["--release", "--package", "tactus-sim-host", "--bin", "tactus"]),
    };
    let found = || std::env::var_os(BUILT).filter(|_| profile == Profile::Release).map(PathBuf::from);
    built.get_or_init(|| found().unwrap_or_else(|| build(args))).clone()
}

/// Builds it and asks cargo where it is.
fn build(selection: &[&str]) -> PathBuf {
    let output = Process::new(env!("CARGO"))
        .args(["build", "--message-format", "json"])
        .args(selection)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "cargo build: {}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines()
        .filter_map(|line| serde_json::from_str::<Value>(line).ok())
        .filter(|message| message["target"]["name"] == "tactus" && message["profile"]["test"] == false)
        .find_map(|message| message["executable"].as_str().map(PathBuf::from))
        .expect("cargo names the executable")
}

/// The command of this profile with arguments, ready to run.
pub fn tactus(profile: Profile, args: &[&str]) -> assert_cmd::Command {
    let mut command = assert_cmd::Command::new(path(profile));
    command.args(args);
    command
}

/// What a run of the command came to.
#[derive(Clone, Debug)]
pub struct Ran {
    /// Exit status.
    pub status: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

/// Runs the command of the release profile to its end.
///
/// # Panics
/// If it was killed by a signal.
pub fn run(args: &[&str]) -> Ran {
    run_in(Profile::Release, args)
}

/// Runs the command of a profile to its end.
///
/// # Panics
/// If it was killed by a signal.
pub fn run_in(profile: Profile, args: &[&str]) -> Ran {
    let output = tactus(profile, args).output().expect("the command starts");
    Ran {
        status: output.status.code().expect("no signal"),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// The summary of one mission of this seed, from standard output.
///
/// # Panics
/// If the output is not JSON.
pub fn summary(profile: Profile, args: &[&str]) -> (Value, Ran) {
    let ran = run_in(profile, &[args, &["--summary", "-"]].concat());
    let value = serde_json::from_str(&ran.stdout)
        .unwrap_or_else(|error| panic!("--summary - of {args:?}: {error}\n{}\n{}", ran.stdout, ran.stderr));
    (value, ran)
}
