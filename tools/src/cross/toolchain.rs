//! What builds the images: the toolchain's own library for the target where rustup has it or can fetch it, else
//! Debian's Rust, which brings the source of `core`.

use crate::cargo;
use crate::setup::{self, need, program};
use anyhow::{Context, ensure};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

const TARGET: &str = "thumbv7em-none-eabihf";
/// Patience with rustup where it may have no network.
const DOWNLOAD_LIMIT: Duration = Duration::from_secs(60);
/// Set to `debian` to build with Debian's Rust although rustup has the target.
const CHOICE: &str = "TACTUS_CROSS";

/// What builds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Toolchain {
    /// The one that built this program.
    Own,
    /// Debian's packages `rustc-web` and `rust-web-src`.
    Debian,
}

/// Has the compiler that builds everything else a library for the target?
fn own_has_target() -> bool {
    let rustc = Path::new(env!("CARGO")).with_file_name("rustc");
    let told = Command::new(rustc).args(["--print", "target-libdir", "--target", TARGET]).output();
    let Ok(told) = told else { return false };
    let folder = PathBuf::from(String::from_utf8_lossy(&told.stdout).trim());
    told.status.success()
        && std::fs::read_dir(folder).is_ok_and(|mut files| {
            files.any(|f| f.is_ok_and(|f| f.file_name().to_string_lossy().starts_with("libcore-")))
        })
}

/// Asks rustup for the target; gives up after a while.
fn fetch_target() {
    eprintln!("xtask: rustup target add {TARGET}");
    let child =
        Command::new("rustup").args(["target", "add", TARGET]).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let Ok(mut child) = child else { return };
    let begun = Instant::now();
    while begun.elapsed() < DOWNLOAD_LIMIT {
        if !matches!(child.try_wait(), Ok(None)) {
            return;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    // What came of it is seen by the caller.
    let _ = child.kill();
    let _ = child.wait();
}

/// Chooses, once.
fn choose() -> anyhow::Result<Toolchain> {
    static CHOSEN: OnceLock<Toolchain> = OnceLock::new();
    if let Some(chosen) = CHOSEN.get() {
        return Ok(*chosen);
    }
    let debian = std::env::var_os(CHOICE).is_some_and(|choice| choice == "debian");
    if !debian && !own_has_target() {
        fetch_target();
    }
    let chosen = if !debian && own_has_target() {
        Toolchain::Own
    } else {
        need(&[setup::CROSS]).with_context(|| format!("rustup cannot add {TARGET}, and Debian's Rust is not there"))?;
        Toolchain::Debian
    };
    Ok(*CHOSEN.get_or_init(|| chosen))
}

/// In a few words, for tables.
pub fn described() -> &'static str {
    match choose() {
        Ok(Toolchain::Own) => "own toolchain",
        Ok(Toolchain::Debian) => "Debian's Rust, core from source",
        Err(_) => "no toolchain",
    }
}

/// Builds the image of a board; where it is.
pub fn build(board: &str) -> anyhow::Result<PathBuf> {
    let toolchain = choose()?;
    let folder = cargo::root().join("firmware/boards").join(board);
    let (label, mut command) = match toolchain {
        Toolchain::Own => ("own", Command::new(env!("CARGO"))),
        Toolchain::Debian => ("debian", debian()?),
    };
    let target = super::folder().join(label);
    command.args(["build", "--release", "--locked", "--target", TARGET, "--target-dir"]).arg(&target);
    if toolchain == Toolchain::Debian {
        command.args(["-Z", "build-std=core"]);
    }
    eprintln!("xtask: cargo build of firmware/boards/{board} ({})", described());
    let status = command.current_dir(&folder).status().context("cannot start cargo")?;
    ensure!(status.success(), "the image of {board} was not built ({status})");
    Ok(target.join(TARGET).join("release").join(format!("tactus-{board}")))
}

/// Builds the static library for C; where it is.
pub fn library() -> anyhow::Result<PathBuf> {
    let toolchain = choose()?;
    let (label, mut command) = match toolchain {
        Toolchain::Own => ("own", Command::new(env!("CARGO"))),
        Toolchain::Debian => ("debian", debian()?),
    };
    let target = super::folder().join(label);
    command.args(["rustc", "--package", "tactus-library", "--profile", "library", "--features", "freestanding"]);
    command.args(["--crate-type", "staticlib", "--locked", "--target", TARGET, "--target-dir"]).arg(&target);
    if toolchain == Toolchain::Debian {
        command.args(["-Z", "build-std=core"]);
    }
    eprintln!("xtask: cargo rustc of firmware/library ({})", described());
    let status = command.current_dir(cargo::root()).status().context("cannot start cargo")?;
    ensure!(status.success(), "the library was not built ({status})");
    Ok(target.join(TARGET).join("library").join("libtactus.a"))
}

/// Debian's cargo with its own compiler; rustup's usually come first in the search path.
fn debian() -> anyhow::Result<Command> {
    let place = |name: &str| {
        let file = Path::new("/usr/bin").join(name);
        file.is_file().then_some(file).or_else(|| program(name)).with_context(|| format!("{name}: missing"))
    };
    let mut command = Command::new(place("cargo")?);
    command
        .env("RUSTC", place("rustc")?)
        .env("RUSTC_BOOTSTRAP", "1")
        .env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", "ld.lld")
        .env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS", "-C linker-flavor=ld.lld");
    for name in ["CARGO", "RUSTDOC", "RUSTUP_TOOLCHAIN", "RUSTUP_HOME", "RUSTC_WRAPPER", "RUSTFLAGS"] {
        command.env_remove(name);
    }
    Ok(command)
}
