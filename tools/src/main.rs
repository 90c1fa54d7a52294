//! `cargo xtask`: the same commands for people and for CI.

use anyhow::{Context, bail};
use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::{Command, ExitCode};
use std::time::Instant;

/// Developer commands of Tactus.
#[derive(Parser)]
#[command(name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    command: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Say what is missing for building and testing, and install it where that is possible.
    Setup,
    /// Format, lint, test: all that must be green before a change lands.
    Test,
    /// Formatting, clippy and documentation, warnings as errors.
    Lint,
    /// Print the medians that the README quotes: world speed, mental rollout, pose update.
    Bench,
}

fn main() -> ExitCode {
    let started = Instant::now();
    let (name, done) = match Cli::parse().command {
        Task::Setup => ("setup", setup()),
        Task::Test => ("test", setup().and_then(|()| lint()).and_then(|()| test())),
        Task::Lint => ("lint", setup().and_then(|()| lint())),
        Task::Bench => ("bench", cargo(&["run", "--release", "--package", "tactus-sim-host", "--", "bench"])),
    };
    match done {
        Ok(()) => {
            eprintln!("xtask {name}: passed in {:.0} s", started.elapsed().as_secs_f32());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("xtask {name}: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// The workspace's root.
fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Runs cargo with these arguments in the workspace.
fn cargo(args: &[&str]) -> anyhow::Result<()> {
    let line = format!("cargo {}", args.join(" "));
    eprintln!("xtask: {line}");
    let status = Command::new(env!("CARGO"))
        .args(args)
        .current_dir(root())
        .env("RUSTDOCFLAGS", "-D warnings")
        .status()
        .with_context(|| format!("cannot start `{line}`"))?;
    if !status.success() {
        bail!("`{line}` failed ({status})");
    }
    Ok(())
}

/// Does a cargo subcommand answer?
fn has(subcommand: &str) -> bool {
    Command::new(env!("CARGO"))
        .args([subcommand, "--version"])
        .current_dir(root())
        .output()
        .is_ok_and(|o| o.status.success())
}

/// The toolchain's parts that the other commands need.
fn setup() -> anyhow::Result<()> {
    for (subcommand, component) in [("fmt", "rustfmt"), ("clippy", "clippy")] {
        if has(subcommand) {
            continue;
        }
        eprintln!("xtask: installing the toolchain component {component}");
        let added = Command::new("rustup").args(["component", "add", component]).status();
        if !added.is_ok_and(|s| s.success()) || !has(subcommand) {
            bail!("`cargo {subcommand}` is missing; install it with: rustup component add {component}");
        }
    }
    Ok(())
}

fn lint() -> anyhow::Result<()> {
    cargo(&["fmt", "--all", "--check"])?;
    cargo(&["clippy", "--workspace", "--all-targets", "--quiet", "--", "--deny", "warnings"])?;
    cargo(&["doc", "--workspace", "--no-deps", "--quiet"])
}

/// Unit and property tests with checks on, then the whole system as people run it, optimised.
fn test() -> anyhow::Result<()> {
    cargo(&["test", "--workspace", "--exclude", "tactus-tests"])?;
    cargo(&["test", "--release", "--package", "tactus-tests"])
}
