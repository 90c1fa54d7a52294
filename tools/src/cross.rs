//! `cargo xtask cross`: the firmware images, and what they may take (`firmware/budget.toml`).
//!
//! Size and panic sites are read from the linked image; stack and instructions are measured by the image itself while
//! it does the whole main job in an emulator (the test file `firmware`), where one count of its clock is worth a fixed
//! number of instructions.

mod budget;
mod image;
mod library;
mod panics;
mod toolchain;

use crate::cargo;
use crate::setup::{self, need};
use crate::tests::binaries::{self, Binary};
use crate::tests::passing_on;
use anyhow::{Context, bail, ensure};
use budget::{Budget, Limits, Measured};
use image::Image;
use std::path::PathBuf;
use std::process::Command;

/// Folders in `firmware/boards`, each an image of this name.
const BOARDS: &[&str] = &["mps2-an386", "nucleo-g474re"];
/// The board that the emulator has, whose image measures itself.
const EMULATED: &str = "mps2-an386";

/// Builds every image and holds it against its budget; unless `no_run`, the main job in the emulator included.
pub fn run(no_run: bool) -> anyhow::Result<()> {
    if no_run {
        let budget = Budget::read()?;
        for image in images(&budget)? {
            println!("{}", table(&image, budget.limits(&image.name)?, None));
        }
        return Ok(());
    }
    let binaries = binaries::build(&["--release", "--package", "tactus-tests"], "firmware")?;
    in_emulator(&binaries).map(drop)
}

/// The same as a place where tests run: those of the image.
pub fn in_emulator(binaries: &[Binary]) -> anyhow::Result<(String, u32)> {
    need(&[setup::EMULATOR])?;
    let budget = Budget::read()?;
    let images = images(&budget)?;
    let measurements = folder().join(format!("{EMULATED}.measured"));
    let _ = std::fs::remove_file(&measurements);
    let tactus = binaries::command()?;
    let mut passed = 0;
    for binary in binaries {
        let mut command = Command::new(&binary.path);
        command.args(["--ignored", "--test-threads=1"]).env(binaries::COMMAND, &tactus);
        passed += passing_on(&mut command, &binary.path.display().to_string())?;
    }
    ensure!(passed > 0, "no test of the image ran");
    let measured = Measured::read(&measurements)?;
    let limits = budget.limits(EMULATED)?;
    for image in &images {
        println!("{}", table(image, budget.limits(&image.name)?, (image.name == EMULATED).then_some(&measured)));
    }
    let image = images.iter().find(|image| image.name == EMULATED).context("the emulated board has an image")?;
    measured.check(image, limits)?;
    Ok(("in QEMU, mps2-an386 (Cortex-M4F)".to_owned(), passed))
}

/// Builds all images, and the library for C.
fn images(budget: &Budget) -> anyhow::Result<Vec<Image>> {
    library::check()?;
    BOARDS.iter().map(|board| build(board, budget)).collect()
}

/// Where images are put.
fn folder() -> PathBuf {
    cargo::target_folder().join("firmware")
}

/// Builds a board's image and checks what can be checked without running it.
fn build(board: &str, budget: &Budget) -> anyhow::Result<Image> {
    let built = toolchain::build(board)?;
    let path = folder().join(format!("{board}.elf"));
    std::fs::copy(&built, &path).with_context(|| format!("{}: cannot be copied", built.display()))?;
    let image = Image::read(board, &path)?;
    let limits = budget.limits(board)?;
    ensure!(image.allocators.is_empty(), "{board}: the image holds an allocator: {}", image.allocators.join(", "));
    for (what, bytes, most) in [("flash", image.flash, limits.flash_bytes), ("RAM", image.ram(), limits.ram_bytes)] {
        ensure!(bytes <= most, "{board}: {what}: {bytes} bytes; firmware/budget.toml allows {most}");
    }
    let unexplained = budget.unexplained(&image.panics);
    if !unexplained.is_empty() {
        bail!(
            "{board}: panic sites that firmware/budget.toml does not explain (remove them, or say there why input cannot \
             reach them):\n  {}",
            unexplained.join("\n  ")
        );
    }
    println!("{board}: {} panic sites remain in the image, each with its reason:", image.panics.values().sum::<u32>());
    for line in budget.explained(&image.panics) {
        println!("  {line}");
    }
    Ok(image)
}

/// The figures that the README quotes.
fn table(image: &Image, limits: &Limits, measured: Option<&Measured>) -> String {
    let mut rows = vec![
        ("flash, bytes (code, constants, initial values)", image.flash, Some(limits.flash_bytes)),
        ("static RAM, bytes", image.static_ram, None),
        ("reserved for the stack, bytes", image.stack, None),
        ("RAM, bytes (both)", image.ram(), Some(limits.ram_bytes)),
    ];
    if let Some(m) = measured {
        rows.push((
            "worst stack, bytes (painted stack, whole main job, interrupts included)",
            m.stack,
            Some(image.stack),
        ));
        rows.push(("worst tick, instructions (-icount; whole main job)", m.worst_tick, limits.tick_instructions));
        rows.push(("mean tick, instructions", m.mean_tick, None));
        rows.push(("ticks", m.ticks, None));
    }
    let mut text = format!("{} ({})\n", image.name, toolchain::described());
    for (what, value, most) in rows {
        let most = most.map_or(String::new(), |most| format!(" of {most}"));
        text += &format!("  {value:>8}{most:<11} {what}\n");
    }
    if let Some(m) = measured {
        text += &format!("  digest {}\n", m.digest);
    }
    text
}
