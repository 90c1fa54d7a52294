//! What must be green before a change lands: lints and tests.

use crate::cargo;
use crate::setup::{self, need};

/// Formatting, clippy and documentation, warnings as errors.
pub fn lint() -> anyhow::Result<()> {
    need(&[setup::LINT])?;
    cargo::run(&["fmt", "--all", "--check"])?;
    cargo::run(&["clippy", "--workspace", "--all-targets", "--quiet", "--", "--deny", "warnings"])?;
    cargo::run(&["doc", "--workspace", "--no-deps", "--quiet"])
}

/// Unit and property tests with checks on, then the whole system as people run it, optimised.
pub fn test() -> anyhow::Result<()> {
    setup::everything()?;
    lint()?;
    cargo::run(&["test", "--workspace", "--exclude", "tactus-tests"])?;
    cargo::run(&["test", "--release", "--package", "tactus-tests"])
}
