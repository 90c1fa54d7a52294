//! A command in user-mode Linux: a kernel that runs as a program, with the machine's files as its root.

use super::{process, script};
use crate::setup::program;
use anyhow::{Context, bail};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Memory of the guest, MiB. Taken as it is touched, from a file without a name.
const MEMORY_MIB: u64 = 1536;

/// Stands for the missing environment of a command.
const ENDED_EARLY: &str = "user-mode Linux ended before the command did";

/// Runs a command to its end; returns its exit status.
pub fn run(command: &[OsString], limit: Duration) -> anyhow::Result<u8> {
    let job = Job::new()?;
    let here = std::env::current_dir().context("the working directory is gone")?;
    let environment: Vec<_> = std::env::vars_os().collect();
    job.write("init", 0o700, &script::init(&job.folder, &here, &environment, command))?;
    for name in ["stdout", "stderr"] {
        job.write(name, 0o600, b"")?;
    }
    let ended = boot(&job, limit)?;
    let status = fs::read_to_string(job.path("status")).ok().and_then(|text| text.trim().parse().ok());
    match (ended.killed_status(), status) {
        // What it had finished before the limit counts.
        (_, Some(status)) => Ok(status),
        (Some(killed), None) => Ok(killed),
        (None, None) => {
            let console = fs::read_to_string(job.path("console")).unwrap_or_default();
            let last: Vec<&str> = console.lines().take(20).collect();
            bail!("{ENDED_EARLY}; it said:\n{}", last.join("\n"))
        }
    }
}

/// Boots the guest and passes on what the command writes, until the command has ended.
fn boot(job: &Job, limit: Duration) -> anyhow::Result<process::Ended> {
    let kernel = program("linux.uml").context("no linux.uml (package user-mode-linux)")?;
    let console = File::create(job.path("console")).context("cannot write the guest's console")?;
    let mut line = process::enclosed(&[]);
    line.arg(kernel)
        .arg(format!("mem={MEMORY_MIB}M"))
        .args(["rootfstype=hostfs", "rw", "quiet", "con=null", "con0=null,fd:1", "umid=guest", "panic=-1"])
        .arg(format!("init={}", job.path("init").display()))
        .arg(format!("uml_dir={}/", job.folder.display()))
        .env("LD_PRELOAD", job.preload()?)
        .env("TMPDIR", memory_folder())
        .stdout(console.try_clone().context("cannot write the guest's console")?)
        .stderr(console);
    let mut child = line.spawn().context("cannot start setpriv")?;
    let mut tails =
        [Tail::new(job.path("stdout"), std::io::stdout()), Tail::new(job.path("stderr"), std::io::stderr())];
    let status = job.path("status");
    let ended = process::watch(&mut child, limit, || {
        for tail in &mut tails {
            tail.pass_on();
        }
        // Powering off would take the guest another half a second; all its writing is done.
        status.exists()
    })?;
    for tail in &mut tails {
        tail.pass_on();
    }
    Ok(ended)
}

/// A folder for the guest's memory: one in memory, if that is large enough and programs may be mapped from it.
fn memory_folder() -> PathBuf {
    let wanted = MEMORY_MIB << 20;
    let fits = |folder: &Path| {
        rustix::fs::statvfs(folder).is_ok_and(|stat| {
            stat.f_bavail * stat.f_frsize >= wanted && !stat.f_flag.contains(rustix::fs::StatVfsMountFlags::NOEXEC)
        })
    };
    let shared = PathBuf::from("/dev/shm");
    if fits(&shared) { shared } else { std::env::temp_dir() }
}

/// A folder for one run, which goes with it.
struct Job {
    folder: PathBuf,
}

impl Job {
    fn new() -> anyhow::Result<Self> {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_nanos());
        // The kernel's command line, which names it, splits at blanks.
        let parent = std::env::temp_dir();
        let parent = if parent.to_string_lossy().contains(char::is_whitespace) { "/tmp".into() } else { parent };
        let folder = parent.join(format!("tactus-vcan-{}-{now}", std::process::id()));
        fs::DirBuilder::new()
            .mode(0o700)
            .create(&folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        Ok(Self { folder })
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    fn write(&self, name: &str, mode: u32, bytes: &[u8]) -> anyhow::Result<()> {
        let mut options = fs::OpenOptions::new();
        let file = options.write(true).create_new(true).mode(mode).open(self.path(name));
        file.and_then(|mut file| file.write_all(bytes)).with_context(|| format!("cannot write {name}"))
    }

    /// Compiles the library that the kernel needs on CPUs with a large state; where it is not needed it does nothing.
    fn preload(&self) -> anyhow::Result<PathBuf> {
        self.write("xstate.c", 0o600, include_bytes!("xstate.c"))?;
        let library = self.path("xstate.so");
        let built = Command::new("cc")
            .args(["-O2", "-shared", "-fPIC", "-o"])
            .arg(&library)
            .arg(self.path("xstate.c"))
            .arg("-ldl")
            .stdin(Stdio::null())
            .output()
            .context("no C compiler `cc` (package gcc)")?;
        if !built.status.success() {
            bail!("cc failed: {}", String::from_utf8_lossy(&built.stderr).trim());
        }
        Ok(library)
    }
}

impl Drop for Job {
    fn drop(&mut self) {
        // Nothing depends on it: what stays behind is small and in the folder for such.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// Passes on what is appended to a file.
struct Tail {
    path: PathBuf,
    file: Option<File>,
    to: Box<dyn Write>,
}

impl Tail {
    fn new(path: PathBuf, to: impl Write + 'static) -> Self {
        Self { path, file: None, to: Box::new(to) }
    }

    fn pass_on(&mut self) {
        if self.file.is_none() {
            self.file = File::open(&self.path).ok();
        }
        let mut bytes = Vec::new();
        let read = self.file.as_mut().map(|file| file.read_to_end(&mut bytes));
        if matches!(read, Some(Ok(1..))) {
            // Who closed our output does not want to read it.
            let _ = self.to.write_all(&bytes).and_then(|()| self.to.flush());
        }
    }
}
