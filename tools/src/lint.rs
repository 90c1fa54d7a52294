//! What machines can say about the text of the code.

use crate::cargo;
use crate::setup::{self, need};

/// Formatting, clippy and documentation, warnings as errors.
pub fn run() -> anyhow::Result<()> {
    need(&[setup::LINT])?;
    cargo::run(&["fmt", "--all", "--check"])?;
    cargo::run(&["clippy", "--workspace", "--all-targets", "--quiet", "--", "--deny", "warnings"])?;
    cargo::run(&["doc", "--workspace", "--no-deps", "--quiet"])
}
