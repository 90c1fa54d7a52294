//! The controller as a process of its own, started and stopped by this one.

use anyhow::{Context, ensure};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use tactus_common::can::Mtu;
use tactus_hil::bus_name::BusName;
use tactus_hil::choice::{CanFormat, Pace, name};

/// Name of the program.
const PROGRAM: &str = "tactus-controller";

/// A running controller; it ends with this value.
pub struct ControllerProcess {
    child: Child,
}

impl ControllerProcess {
    /// Starts the controller on a bus, for one mission.
    ///
    /// # Errors
    /// The program is not beside this one, or does not start.
    pub fn start(bus: &BusName, mtu: Mtu, pace: Pace) -> anyhow::Result<Self> {
        let program = path()?;
        let (format, pace) = (name(&CanFormat::from(mtu)), name(&pace));
        let child = Command::new(&program)
            .args(["--bus", &bus.to_string(), "--can", &format, "--pace", &pace, "--once", "--quiet"])
            .stdin(Stdio::null())
            .spawn()
            .with_context(|| format!("cannot start {}", program.display()))?;
        Ok(Self { child })
    }

    /// Its process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Sees that it has not ended already; then it has said why.
    ///
    /// # Errors
    /// It has ended.
    pub fn check(&mut self) -> anyhow::Result<()> {
        let ended = self.child.try_wait().context(PROGRAM)?;
        ensure!(ended.is_none(), "{PROGRAM} ended before the mission began ({})", ended.unwrap_or_default());
        Ok(())
    }
}

impl Drop for ControllerProcess {
    fn drop(&mut self) {
        // It ends by itself after its mission, and must not outlive one that was broken off.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn path() -> anyhow::Result<PathBuf> {
    let here = std::env::current_exe().context("where is this program?")?;
    let beside = here.with_file_name(format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX));
    ensure!(
        beside.is_file(),
        "no {PROGRAM} in {}; expected beside tactus (cargo build --release builds both)",
        beside.parent().unwrap_or(&beside).display()
    );
    Ok(beside)
}
