//! `cargo xtask page`: the script of the replay page, from its sources in `sim-host/view/`. `cargo xtask picture`: the
//! picture in the README, from that page.

use crate::cargo;
use crate::setup::{self, need};
use crate::tests::binaries;
use anyhow::{Context, ensure};
use std::path::Path;
use std::process::{Command, Stdio};

/// What the picture shows, as the page's address asks for it.
const MOMENT: &str = "t=14.2&theme=light";
/// Size of the picture, pixels, and most bytes of its file.
const WINDOW: &str = "--window-size=1280,720";
const PICTURE_BYTES_MAX: u64 = 400_000;
/// A browser without network and first-run pages, and with WebGL where there is no graphics card.
const BROWSER: &[&str] = &[
    "--headless",
    "--no-sandbox",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--virtual-time-budget=5000",
    WINDOW,
];

/// Bundles the script anew, with the versions of the lock file.
///
/// # Errors
/// There is no Node, or a library cannot be had, or the sources are wrong.
pub fn script() -> anyhow::Result<()> {
    need(&[setup::PAGE])?;
    let folder = cargo::root().join("sim-host/view");
    let libraries = ["ci", "--ignore-scripts", "--no-audit", "--no-fund"];
    carry_out(Command::new("npm").args(libraries).current_dir(&folder))?;
    carry_out(Command::new("node").arg("build.mjs").current_dir(&folder))
}

/// Makes docs/replay.png from a run of this very program.
///
/// # Errors
/// A step fails, or the picture is too large.
pub fn picture() -> anyhow::Result<()> {
    need(&[setup::BROWSER])?;
    let tactus = binaries::command()?;
    let folder = cargo::target_folder().join("picture");
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let [recording, page, profile] = ["run.mcap", "run.html", "profile"].map(|name| folder.join(name));
    carry_out(Command::new(&tactus).args(["run", "--quiet", "--record"]).arg(&recording))?;
    carry_out(Command::new(&tactus).arg("view").arg(&recording).arg("--out").arg(&page))?;
    let picture = cargo::root().join("docs/replay.png");
    let mut browser = Command::new("chromium");
    browser.args(BROWSER).arg(format!("--user-data-dir={}", profile.display()));
    browser.arg(format!("--screenshot={}", picture.display())).arg(format!("file://{}#{MOMENT}", page.display()));
    carry_out(browser.stdout(Stdio::null()).stderr(Stdio::null()))?;
    check(&picture)
}

fn check(picture: &Path) -> anyhow::Result<()> {
    let bytes = std::fs::metadata(picture).with_context(|| format!("no {}", picture.display()))?.len();
    ensure!(bytes <= PICTURE_BYTES_MAX, "{}: {bytes} bytes, expected at most {PICTURE_BYTES_MAX}", picture.display());
    eprintln!("xtask: {}, {} kB", picture.display(), bytes / 1000);
    Ok(())
}

fn carry_out(command: &mut Command) -> anyhow::Result<()> {
    let name = command.get_program().to_string_lossy().into_owned();
    let status = command.status().with_context(|| format!("cannot start {name}"))?;
    ensure!(status.success(), "{name} failed ({status})");
    Ok(())
}
