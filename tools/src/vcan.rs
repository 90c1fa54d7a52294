//! A CAN interface for any command, on any machine: `vcan0`, up, with room for CAN FD frames. On the machine's own
//! kernel where that has CAN; else in user-mode Linux, a kernel that runs as a program and sees the same files.

mod process;
mod script;
mod user_mode;

use crate::setup::{self, need, program};
use std::ffi::OsString;
use std::process::{Command, ExitCode, Stdio};
use std::time::Duration;

/// Where commands with a CAN interface run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// On this machine's own kernel, in a network namespace of their own.
    OwnKernel,
    /// In user-mode Linux.
    UserModeLinux,
}

impl Place {
    /// The place that this machine has.
    pub fn here() -> Self {
        if own_kernel_has_can() { Self::OwnKernel } else { Self::UserModeLinux }
    }

    /// A few words for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::OwnKernel => "on this machine's own CAN",
            Self::UserModeLinux => "in user-mode Linux: this kernel has no CAN",
        }
    }
}

/// How to run a command.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// It is killed after this.
    pub limit: Duration,
    /// Say nothing about where it runs.
    pub quiet: bool,
}

/// Exit status of a command that was killed because its time was over (as `timeout` has it).
pub const TIMED_OUT: u8 = 124;

/// Runs a command with a CAN interface; its output is ours, its exit status is returned (128 + n if signal n killed it).
///
/// # Errors
/// No such environment can be made here: what is missing, or what it said.
pub fn run(command: &[OsString], options: Options) -> anyhow::Result<u8> {
    need(&[setup::CAN])?;
    let place = Place::here();
    if !options.quiet {
        eprintln!("xtask vcan: {}", place.name());
    }
    match place {
        Place::OwnKernel => process::own_kernel(command, options.limit),
        Place::UserModeLinux => {
            need(&[setup::USER_MODE_LINUX])?;
            user_mode::run(command, options.limit)
        }
    }
}

/// [`run`] for the command line.
pub fn main(command: &[OsString], options: Options) -> ExitCode {
    match run(command, options) {
        Ok(status) => ExitCode::from(status),
        Err(error) => {
            eprintln!("xtask vcan: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Can this machine's own kernel make a virtual CAN interface for us? Tried in a network namespace of its own.
pub fn own_kernel_has_can() -> bool {
    let Some(ip) = program("ip") else { return false };
    let Some(mut command) = private_network() else { return false };
    command.arg(ip).args(["link", "add", "dev", "vcan0", "type", "vcan"]);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// `unshare` with a network of its own; the command is to follow.
fn private_network() -> Option<Command> {
    let mut command = Command::new(program("unshare")?);
    command.arg("--net");
    if !setup::is_root() {
        command.arg("--map-root-user");
    }
    Some(command)
}
