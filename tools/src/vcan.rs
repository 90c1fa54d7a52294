//! A CAN interface for any command, on any machine.

use crate::setup::program;
use std::process::{Command, Stdio};

/// Can this machine's own kernel make a virtual CAN interface for us? Tried in a network namespace of its own.
pub fn own_kernel_has_can() -> bool {
    let (Some(unshare), Some(ip)) = (program("unshare"), program("ip")) else { return false };
    let mut command = Command::new(unshare);
    command.arg("--map-root-user").arg("--net").arg(ip).args(["link", "add", "dev", "vcan0", "type", "vcan"]);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}
