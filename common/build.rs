//! Turns the robot's description (`models/`) into constant tables for the `no_std` side.
//!
//! A description that is damaged, or that the closed-form kinematics does not fit, stops the build with one line:
//! which file, which element, what was expected.

#[path = "build/arm.rs"]
mod arm;
#[path = "build/generate.rs"]
mod generate;
#[path = "build/hand.rs"]
mod hand;
#[path = "build/model.rs"]
mod model;
#[path = "build/settings.rs"]
mod settings;
#[path = "build/spatial.rs"]
mod spatial;

use std::path::{Path, PathBuf};
use std::{env, fs, process};

/// Reads a text file of the model, with an error that names it.
fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{}: cannot be read: {e}", path.display()))
}

/// Generates `$OUT_DIR/robot_tables.rs`.
fn run() -> Result<(), String> {
    let models = PathBuf::from("models");
    let urdf = read(&models.join("wam7_bh280.urdf"))?;
    let settings = read(&models.join("wam7_bh280.toml"))?;
    let tables = generate::tables(&urdf, &settings, &|file| read(&models.join(file)))?;
    let out = env::var("OUT_DIR").map_err(|e| format!("OUT_DIR: {e}; expected to be set by cargo"))?;
    let path = Path::new(&out).join("robot_tables.rs");
    fs::write(&path, tables).map_err(|e| format!("{}: cannot be written: {e}", path.display()))
}

fn main() {
    println!("cargo::rerun-if-changed=models");
    println!("cargo::rerun-if-changed=build");
    println!("cargo::rerun-if-changed=build.rs");
    if let Err(message) = run() {
        println!("cargo::error={message}");
        process::exit(1);
    }
}
