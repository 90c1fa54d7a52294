//! On what a bench ran: without it, times say nothing.

use crate::cargo;
use anyhow::{Context, ensure};
use serde_json::{Value, json};
use std::fmt;
use std::process::Command;

/// The machine and how busy it was at the start.
#[derive(Clone, Debug)]
pub struct Machine {
    cpu: String,
    cores: usize,
    os: String,
    rustc: String,
    load: String,
}

impl Machine {
    /// This one, now.
    ///
    /// # Errors
    /// The compiler does not say what it is.
    pub fn here() -> anyhow::Result<Self> {
        let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
        let unknown = || "unknown".to_owned();
        Ok(Self {
            cpu: value_of(&read("/proc/cpuinfo"), "model name", ':').unwrap_or_else(unknown),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            os: value_of(&read("/etc/os-release"), "PRETTY_NAME", '=').unwrap_or_else(unknown),
            rustc: rustc()?,
            load: read("/proc/loadavg").split(' ').next().map_or_else(unknown, str::to_owned),
        })
    }

    /// For the report.
    pub fn json(&self) -> Value {
        json!({ "cpu": self.cpu, "cores": self.cores, "os": self.os, "rustc": self.rustc,
            "version": env!("CARGO_PKG_VERSION"), "load": self.load })
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { cpu, cores, os, rustc, load } = self;
        write!(f, "{cpu}, {cores} cores, {os}, rustc {rustc}; load at the start: {load}")
    }
}

/// Release and host of the compiler.
///
/// # Errors
/// It does not say.
pub fn rustc() -> anyhow::Result<String> {
    let told = Command::new("rustc").arg("-vV").current_dir(cargo::root()).output().context("cannot start rustc")?;
    let text = String::from_utf8_lossy(&told.stdout).into_owned();
    ensure!(told.status.success(), "rustc -vV failed ({})", told.status);
    let of = |key| value_of(&text, key, ':').with_context(|| format!("rustc -vV says no {key}"));
    Ok(format!("{} {}", of("release")?, of("host")?))
}

/// The value of the first line `key SEPARATOR value`.
fn value_of(text: &str, key: &str, separator: char) -> Option<String> {
    text.lines()
        .filter_map(|line| line.split_once(separator))
        .find(|(name, _)| name.trim() == key)
        .map(|(_, value)| value.trim().trim_matches('"').to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_found_whatever_stands_around_them() {
        assert_eq!(value_of("a: 1\nmodel name\t: X 2000: fast\n", "model name", ':').as_deref(), Some("X 2000: fast"));
        assert_eq!(value_of("PRETTY_NAME=\"Debian 12\"\n", "PRETTY_NAME", '=').as_deref(), Some("Debian 12"));
        assert_eq!(value_of("", "a", ':'), None);
    }

    #[test]
    fn the_compiler_says_its_release_and_host() {
        let told = rustc().expect("rustc is here");
        assert_eq!(told.split(' ').count(), 2, "{told}");
    }
}
