//! The firmware image of the emulated board, running in QEMU, its serial line a socket.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Where `cargo xtask cross` leaves the image of the emulated board.
pub fn image() -> PathBuf {
    let here = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../target");
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(here, PathBuf::from).join("firmware/mps2-an386.elf")
}

/// Where the tests leave what the image measured of itself, for `cargo xtask cross`.
pub fn measurements() -> PathBuf {
    image().with_extension("measured")
}

/// A line that the image told its emulator: `tactus: KIND name=value ...`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Told {
    /// What it is about.
    pub kind: String,
    /// Its values by name.
    pub values: BTreeMap<String, String>,
}

impl Told {
    /// `None` for a line of another form.
    pub fn read(line: &str) -> Option<Self> {
        let mut words = line.trim().strip_prefix("tactus: ")?.split(' ');
        let kind = words.next()?.to_owned();
        let values = words.map(|w| w.split_once('=').map(|(k, v)| (k.to_owned(), v.to_owned())));
        Some(Self { kind, values: values.collect::<Option<_>>()? })
    }

    /// A whole number.
    ///
    /// # Panics
    /// If there is none of this name.
    pub fn number(&self, name: &str) -> u64 {
        self.values.get(name).and_then(|v| v.parse().ok()).unwrap_or_else(|| panic!("no number {name} in {self:?}"))
    }
}

/// A running emulator; ends with its value.
#[derive(Debug)]
pub struct Emulator {
    child: Child,
    lines: Receiver<String>,
    socket: PathBuf,
}

impl Emulator {
    /// Starts the image. Its time follows the instructions it executes (one a nanosecond), so that counts of its clock
    /// are counts of instructions, the same in every run.
    ///
    /// # Panics
    /// If there is no image or no emulator: the message says what to do.
    pub fn start(image: &Path, name: &str) -> Self {
        assert!(image.exists(), "{}: missing; build it with: cargo xtask cross", image.display());
        let socket = std::env::temp_dir().join(format!("tactus-{name}-{}.sock", std::process::id()));
        let _ = std::fs::remove_file(&socket);
        let mut child = Command::new("qemu-system-arm")
            .args(["-M", "mps2-an386", "-cpu", "cortex-m4", "-display", "none", "-monitor", "none"])
            .args(["-semihosting-config", "enable=on,target=native", "-icount", "shift=0"])
            .args(["-serial", &format!("unix:{},server=on,wait=off", socket.display())])
            .arg("-kernel")
            .arg(image)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("qemu-system-arm: missing; Debian package qemu-system-arm");
        let (sender, lines) = channel();
        let (out, err) = (child.stdout.take().expect("piped"), child.stderr.take().expect("piped"));
        let streams: [Box<dyn BufRead + Send>; 2] = [Box::new(BufReader::new(out)), Box::new(BufReader::new(err))];
        for stream in streams {
            let sender = sender.clone();
            std::thread::spawn(move || {
                stream.lines().map_while(Result::ok).take_while(|line| sender.send(line.clone()).is_ok()).count()
            });
        }
        let emulator = Self { child, lines, socket };
        emulator.wait_for_socket();
        emulator
    }

    fn wait_for_socket(&self) {
        let begun = Instant::now();
        while !self.socket.exists() {
            assert!(
                begun.elapsed() < Duration::from_secs(20),
                "the emulator made no socket: {:?}",
                self.lines.try_recv()
            );
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// The serial line.
    pub fn socket(&self) -> &Path {
        &self.socket
    }

    /// The next line of this kind that the image tells.
    ///
    /// # Panics
    /// If none comes in time.
    pub fn told(&self, kind: &str, within: Duration) -> Told {
        let begun = Instant::now();
        let mut others = Vec::new();
        loop {
            let left = within.saturating_sub(begun.elapsed());
            match self.lines.recv_timeout(left) {
                Ok(line) => match Told::read(&line) {
                    Some(told) if told.kind == kind => return told,
                    _ => others.push(line),
                },
                Err(error) => panic!("the image told no {kind}: {error}; but: {others:?}"),
            }
        }
    }

    /// Everything that it says until it ends by itself, and how it ended.
    ///
    /// # Panics
    /// If it does not end in time.
    pub fn end(&mut self, within: Duration) -> (Vec<String>, ExitStatus) {
        let begun = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("a child can be asked") {
                return (self.lines.iter().collect(), status);
            }
            assert!(begun.elapsed() < within, "the emulator goes on");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_file(&self.socket);
    }
}
