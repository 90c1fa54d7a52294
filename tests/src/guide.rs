//! The commands of docs/guide.md, run as it says.

use crate::program::{self, Profile};
use std::path::Path;
use std::process::Command;

/// What stands before a command that needs a CAN interface.
pub const WITH_CAN: &str = "cargo xtask vcan -- ";
/// Where the guide's commands leave their files.
pub const FOLDER: &str = "target/guide";
/// Where `cargo build --release` leaves the programs.
const PROGRAMS: &str = "target/release/";

/// Every command of the guide, in its order.
pub fn commands() -> Vec<&'static str> {
    let mut commands = Vec::new();
    let mut is_in_block = false;
    for line in include_str!("../../docs/guide.md").lines() {
        match line {
            "```sh" => is_in_block = true,
            "```" => is_in_block = false,
            _ if is_in_block => commands.push(line),
            _ => {}
        }
    }
    commands
}

/// Runs a command in the root of the repository, with the programs that this test run has built.
///
/// # Panics
/// If it does not end well.
pub fn run(command: &str) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let programs = program::path(Profile::Release);
    let programs = programs.parent().expect("a program is in a folder").display();
    let line = command.replace(PROGRAMS, &format!("{programs}/"));
    let ran = Command::new("sh").args(["-c", &line]).current_dir(root).output().expect("sh runs");
    let said = String::from_utf8_lossy(&ran.stderr);
    assert!(ran.status.success(), "{command}: {:?}\n{said}", ran.status.code());
}
