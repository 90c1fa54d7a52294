//! Test binaries and programs, as cargo builds and names them.

use crate::cargo;
use anyhow::{Context, ensure};
use serde_json::Value;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// A test binary.
#[derive(Clone, Debug)]
pub struct Binary {
    /// Name of its target: of the file in `tests/`, of the package for unit tests.
    pub name: String,
    /// Where it is.
    pub path: PathBuf,
}

impl Binary {
    /// The names of its ignored tests.
    pub fn ignored(&self) -> anyhow::Result<Vec<String>> {
        let told = Command::new(&self.path)
            .args(["--ignored", "--list", "--format", "terse"])
            .output()
            .with_context(|| format!("cannot start {}", self.path.display()))?;
        ensure!(told.status.success(), "{} --list failed", self.path.display());
        let text = String::from_utf8_lossy(&told.stdout);
        Ok(text.lines().filter_map(|line| line.strip_suffix(": test")).map(str::to_owned).collect())
    }
}

/// Builds the test files of a package whose names begin with `files`.
pub fn build(package: &[&str], files: &str) -> anyhow::Result<Vec<Binary>> {
    let files = format!("{files}*");
    let args =
        [&["test", "--no-run", "--message-format", "json-render-diagnostics", "--test", &files], package].concat();
    Ok(messages(&args)?.iter().filter(|m| m["profile"]["test"] == true).filter_map(binary).collect())
}

/// The variable that tells whole-system tests where the command `tactus` is.
pub const COMMAND: &str = "TACTUS_TESTS_COMMAND";

/// Builds the programs that whole-system tests start, all beside one another; where `tactus` is.
pub fn command() -> anyhow::Result<PathBuf> {
    let args = ["build", "--release", "--package", "tactus-sim-host", "--package", "tactus-hil", "--bins"];
    let told = messages(&[&args[..], &["--message-format", "json-render-diagnostics"]].concat())?;
    let tactus = told.iter().filter_map(binary).find(|b| b.name == "tactus");
    Ok(tactus.context("cargo does not say where tactus is")?.path)
}

/// Builds the benchmark `name` of a package, optimised.
pub fn bench(package: &str, name: &str, features: &[&str]) -> anyhow::Result<Binary> {
    let features = features.join(",");
    let args = ["build", "--release", "--package", package, "--bench", name, "--features", &features];
    let told = messages(&[&args[..], &["--message-format", "json-render-diagnostics"]].concat())?;
    let found = told.iter().filter_map(binary).find(|b| b.name == name);
    found.with_context(|| format!("cargo does not say where the benchmark {name} is"))
}

/// What a message of cargo says of an executable.
fn binary(message: &Value) -> Option<Binary> {
    let path = message["executable"].as_str()?;
    Some(Binary { name: message["target"]["name"].as_str()?.to_owned(), path: path.into() })
}

/// What cargo says, while it says it to people too.
fn messages(args: &[&str]) -> anyhow::Result<Vec<Value>> {
    let line = format!("cargo {}", args.join(" "));
    let told =
        cargo::command(args).stderr(Stdio::inherit()).output().with_context(|| format!("cannot start `{line}`"))?;
    ensure!(told.status.success(), "`{line}` failed ({})", told.status);
    let text = String::from_utf8_lossy(&told.stdout);
    Ok(text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect())
}
