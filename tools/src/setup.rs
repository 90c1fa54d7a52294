//! What the commands need from the machine: a table of things, how each is recognised and where it comes from. What is
//! missing is installed where that is possible, never silently; what cannot be installed stops the command with one line.

mod python;

use crate::{cargo, vcan};
use anyhow::bail;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::process::{Command, Stdio};

/// How a thing is recognised.
#[derive(Clone, Copy, Debug)]
pub enum Probe {
    /// A program of this name is in the search path (or where only root's search path looks).
    Program(&'static str),
    /// A file or folder of this name exists.
    File(&'static str),
    /// `cargo NAME` answers.
    Cargo(&'static str),
    /// The system's Python has this module.
    Python(&'static str),
}

/// Where a thing comes from.
#[derive(Clone, Copy, Debug)]
pub enum Source {
    /// These Debian packages.
    Debian(&'static [&'static str]),
    /// This component of the toolchain.
    Rustup(&'static str),
}

/// A thing that a command needs.
#[derive(Clone, Copy, Debug)]
pub struct Need {
    /// What for, a few words.
    pub what: &'static str,
    /// How it is recognised.
    pub probe: Probe,
    /// Where it comes from.
    pub source: Source,
}

/// One row of the tables below.
const fn row(what: &'static str, probe: Probe, source: Source) -> Need {
    Need { what, probe, source }
}

/// For formatting and lints.
pub const LINT: &[Need] = &[
    row("formatting", Probe::Cargo("fmt"), Source::Rustup("rustfmt")),
    row("lints", Probe::Cargo("clippy"), Source::Rustup("clippy")),
];

/// For a CAN interface on any machine, and for independent peers on it.
pub const CAN: &[Need] = &[
    row("network set-up", Probe::Program("ip"), Source::Debian(&["iproute2"])),
    row("CAN peers for tests", Probe::Program("candump"), Source::Debian(&["can-utils"])),
];

/// For a CAN interface where the machine's kernel has none: another kernel, run as a program.
pub const USER_MODE_LINUX: &[Need] = &[
    row("a C compiler", Probe::Program("cc"), Source::Debian(&["gcc", "libc6-dev"])),
    row("a kernel with CAN", Probe::Program("linux.uml"), Source::Debian(&["user-mode-linux"])),
    row("its CAN modules", Probe::File("/usr/lib/uml/modules"), Source::Debian(&["user-mode-linux"])),
    row("loading them", Probe::Program("insmod"), Source::Debian(&["kmod"])),
];

/// For running the firmware image.
pub const EMULATOR: &[Need] =
    &[row("the emulated board", Probe::Program("qemu-system-arm"), Source::Debian(&["qemu-system-arm"]))];

/// For reading recordings with a library that is not ours.
pub const PYTHON: &[Need] = &[
    row("an independent reader of recordings", Probe::Program("python3"), Source::Debian(&["python3"])),
    row("its environments", Probe::Python("ensurepip"), Source::Debian(&["python3-venv"])),
];

/// For counting instructions.
pub const BENCH: &[Need] = &[row("counting instructions", Probe::Program("valgrind"), Source::Debian(&["valgrind"]))];

/// For tests of pages.
pub const BROWSER: &[Need] =
    &[row("a browser for tests of pages", Probe::Program("chromium"), Source::Debian(&["chromium"]))];

/// For bundling the script of the replay page.
pub const PAGE: &[Need] = &[
    row("bundling the page's script", Probe::Program("node"), Source::Debian(&["nodejs"])),
    row("its libraries", Probe::Program("npm"), Source::Debian(&["npm"])),
];

/// For building firmware images where rustup cannot add their target.
pub const CROSS: &[Need] = &[
    row("a Rust with source", Probe::File("/usr/bin/rustc"), Source::Debian(&["rustc-web", "cargo-web"])),
    row("its cargo", Probe::File("/usr/bin/cargo"), Source::Debian(&["cargo-web"])),
    row("the source of core", Probe::File("/usr/lib/rustlib/src/rust"), Source::Debian(&["rust-web-src"])),
    row("a linker", Probe::Program("ld.lld"), Source::Debian(&["lld"])),
    row("a C linker for build scripts", Probe::Program("cc"), Source::Debian(&["gcc", "libc6-dev"])),
];

/// All that any command needs.
///
/// # Errors
/// As [`need`].
pub fn everything() -> anyhow::Result<()> {
    need(&[LINT, CAN, PYTHON, BROWSER])?;
    python::environment()?;
    if !vcan::own_kernel_has_can() {
        need(&[USER_MODE_LINUX])?;
    }
    Ok(())
}

/// Sees to it that all of these are there.
///
/// # Errors
/// One line that names what is missing and the package that holds it.
pub fn need(tables: &[&[Need]]) -> anyhow::Result<()> {
    let missing: Vec<&Need> = tables.iter().flat_map(|t| t.iter()).filter(|n| !present(n.probe)).collect();
    let mut packages: Vec<&str> = Vec::new();
    for need in &missing {
        match need.source {
            Source::Debian(names) => packages.extend(names),
            Source::Rustup(component) => {
                eprintln!("xtask: installing the toolchain component {component} ({})", need.what);
                // What comes of it is seen below.
                let _ = Command::new("rustup").args(["component", "add", component]).status();
            }
        }
    }
    if !packages.is_empty() {
        packages.sort_unstable();
        packages.dedup();
        apt_install(&packages)?;
    }
    for need in missing {
        if !present(need.probe) {
            bail!("missing: {:?} ({}); install it with: {}", need.probe, need.what, by_hand(need.source));
        }
    }
    Ok(())
}

/// The command with which a person would install it.
fn by_hand(source: Source) -> String {
    match source {
        Source::Debian(packages) => format!("apt-get install {}", packages.join(" ")),
        Source::Rustup(component) => format!("rustup component add {component}"),
    }
}

/// Is it there?
pub fn present(probe: Probe) -> bool {
    match probe {
        Probe::Program(name) => program(name).is_some(),
        Probe::File(path) => Path::new(path).exists(),
        Probe::Cargo(subcommand) => {
            cargo::command(&[subcommand, "--version"]).output().is_ok_and(|o| o.status.success())
        }
        Probe::Python(module) => program("python3").is_some_and(|python| {
            let mut import = Command::new(python);
            import.args(["-c", &format!("import {module}")]).stdout(Stdio::null()).stderr(Stdio::null());
            import.status().is_ok_and(|status| status.success())
        }),
    }
}

/// Where a program is: in the search path, or in the folders of the system's own programs, which a person's search path
/// often leaves out.
pub fn program(name: &str) -> Option<std::path::PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let own = ["/usr/local/sbin", "/usr/sbin", "/sbin", "/usr/bin", "/bin"].map(std::path::PathBuf::from);
    std::env::split_paths(&path).chain(own).map(|folder| folder.join(name)).find(|file| file.is_file())
}

/// Is this process root's?
pub fn is_root() -> bool {
    std::fs::metadata("/proc/self").is_ok_and(|own| own.uid() == 0)
}

/// Installs Debian packages; the lists of packages are fetched only if it does not work without.
fn apt_install(packages: &[&str]) -> anyhow::Result<()> {
    let names = packages.join(" ");
    if program("apt-get").is_none() {
        bail!("missing: {names} (Debian's names), and there is no apt-get here; install them by hand");
    }
    let silent = |line: &[&str]| {
        let mut command = Command::new(line[0]);
        command.args(&line[1..]).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        command.status().is_ok_and(|s| s.success())
    };
    let prefix: &[&str] = if is_root() {
        &["env", "DEBIAN_FRONTEND=noninteractive"]
    } else if silent(&["sudo", "-n", "true"]) {
        &["sudo", "-n", "env", "DEBIAN_FRONTEND=noninteractive"]
    } else {
        bail!("missing: {names}; install with (as root, which this is not): apt-get install {names}");
    };
    let install: Vec<&str> = prefix
        .iter()
        .copied()
        .chain(["apt-get", "install", "-y", "--no-install-recommends"])
        .chain(packages.iter().copied())
        .collect();
    eprintln!("xtask: {}", install.join(" "));
    if silent(&install) {
        return Ok(());
    }
    let update: Vec<&str> = prefix.iter().copied().chain(["apt-get", "update"]).collect();
    eprintln!("xtask: {}", update.join(" "));
    silent(&update);
    let told = Command::new(install[0]).args(&install[1..]).stdin(Stdio::null()).output();
    match told {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            let why = text.lines().find(|line| line.starts_with("E:")).unwrap_or("apt-get failed").to_owned();
            bail!("cannot install {names}: {why}")
        }
        Err(error) => bail!("cannot install {names}: {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_is_found_and_what_is_not_is_not() {
        assert!(present(Probe::Program("sh")));
        assert!(!present(Probe::Program("no-such-program-0")));
        assert!(present(Probe::File("/")));
        assert!(!present(Probe::File("/no/such/file")));
        assert!(!present(Probe::Python("no_such_module_0")));
    }

    #[test]
    fn the_line_for_a_person_names_the_package() {
        assert_eq!(by_hand(USER_MODE_LINUX[1].source), "apt-get install user-mode-linux");
        assert_eq!(by_hand(BENCH[0].source), "apt-get install valgrind");
        assert_eq!(by_hand(LINT[0].source), "rustup component add rustfmt");
    }
}
