//! Starting a command, watching over it and leaving nothing of it behind.

use super::{TIMED_OUT, script};
use crate::setup::{self, program};
use anyhow::Context;
use std::ffi::OsString;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How often a command is looked after.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Exit status after Ctrl-C: 128 + SIGINT.
const INTERRUPTED: u8 = 130;

/// Runs a command on the machine's own kernel, with an interface in a network namespace of its own.
pub fn own_kernel(command: &[OsString], limit: Duration) -> anyhow::Result<u8> {
    let mut line = enclosed(&["--net", "--mount-proc"]);
    line.arg("/bin/sh").arg("-c").arg(script::ON_OWN_KERNEL).arg("sh").args(command);
    let mut child = line.spawn().context("cannot start unshare")?;
    match watch(&mut child, limit, || false)? {
        Ended::Exited(status) => Ok(status_byte(status)),
        Ended::TimedOut => Ok(TIMED_OUT),
        Ended::Interrupted => Ok(INTERRUPTED),
        Ended::Enough => Ok(0),
    }
}

/// How a command came to its end.
#[derive(Clone, Copy, Debug)]
pub enum Ended {
    /// By itself.
    Exited(ExitStatus),
    /// Killed: it was no longer needed.
    Enough,
    /// Killed: its time was over.
    TimedOut,
    /// Killed: so were we, or the user pressed Ctrl-C.
    Interrupted,
}

impl Ended {
    /// The exit status of a command that we had to kill.
    pub fn killed_status(self) -> Option<u8> {
        match self {
            Self::Exited(_) | Self::Enough => None,
            Self::TimedOut => Some(TIMED_OUT),
            Self::Interrupted => Some(INTERRUPTED),
        }
    }
}

/// `unshare` with process numbers of its own and these options more; the program is to follow. All that the program
/// starts is killed with it, and it is killed with us, whatever becomes of us.
pub fn enclosed(more: &[&str]) -> Command {
    // setpriv lets unshare die with us; --kill-child lets the first process of the namespace die with unshare; and with
    // the first process of a namespace of process numbers the kernel kills all the others.
    let mut line = Command::new(program("setpriv").unwrap_or_else(|| "setpriv".into()));
    line.args(["--pdeathsig", "KILL", "--", "unshare", "--pid", "--fork", "--kill-child=KILL"]).args(more);
    if !setup::is_root() {
        line.arg("--map-root-user");
    }
    // A group of its own: Ctrl-C reaches us, and we see to the rest.
    line.process_group(0).stdin(Stdio::null());
    line
}

/// Waits for the end of `child`, and kills it when its time is over, when we are told to end, or when `look` says that
/// it has done enough.
pub fn watch(child: &mut Child, limit: Duration, mut look: impl FnMut() -> bool) -> anyhow::Result<Ended> {
    let interrupted = interrupted();
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait().context("cannot wait for the command")? {
            return Ok(Ended::Exited(status));
        }
        let ended = if look() {
            Ended::Enough
        } else if interrupted.load(Ordering::Relaxed) {
            Ended::Interrupted
        } else if started.elapsed() >= limit {
            eprintln!("xtask vcan: killed after {} s (--timeout)", limit.as_secs());
            Ended::TimedOut
        } else {
            std::thread::sleep(LOOK_EVERY);
            continue;
        };
        child.kill().context("cannot kill the command")?;
        child.wait().context("cannot wait for the command")?;
        return Ok(ended);
    }
}

/// Becomes true when this process is told to end.
fn interrupted() -> &'static AtomicBool {
    static TOLD: AtomicBool = AtomicBool::new(false);
    static HANDLER: OnceLock<bool> = OnceLock::new();
    // Without the handler the default action ends us, and the command ends with us.
    HANDLER.get_or_init(|| ctrlc::set_handler(|| TOLD.store(true, Ordering::Relaxed)).is_ok());
    &TOLD
}

/// An exit status as shells count it.
fn status_byte(status: ExitStatus) -> u8 {
    let code = status.code().or_else(|| status.signal().map(|signal| 128 + signal));
    code.and_then(|code| u8::try_from(code).ok()).unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sh(script: &str) -> Child {
        Command::new("sh").args(["-c", script]).spawn().unwrap()
    }

    #[test]
    fn a_command_ends_by_itself_or_by_the_limit() {
        let ended = watch(&mut sh("exit 7"), Duration::from_secs(10), || false).unwrap();
        assert!(matches!(ended, Ended::Exited(status) if status_byte(status) == 7), "{ended:?}");
        let ended = watch(&mut sh("sleep 10"), Duration::from_millis(50), || false).unwrap();
        assert_eq!(ended.killed_status(), Some(TIMED_OUT));
        let ended = watch(&mut sh("sleep 10"), Duration::from_secs(10), || true).unwrap();
        assert!(matches!(ended, Ended::Enough), "{ended:?}");
    }

    #[test]
    fn death_by_a_signal_counts_as_128_and_its_number() {
        let ended = watch(&mut sh("kill -9 $$"), Duration::from_secs(10), || false).unwrap();
        assert!(matches!(ended, Ended::Exited(status) if status_byte(status) == 137), "{ended:?}");
    }
}
