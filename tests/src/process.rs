//! Programs that run beside a test, watched line by line, and killed with it.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// How often a program is looked at.
const LOOK: Duration = Duration::from_millis(5);

/// A program under way.
pub struct Process {
    name: String,
    child: Child,
    lines: Arc<Mutex<Vec<String>>>,
    readers: Vec<std::thread::JoinHandle<()>>,
}

impl Process {
    /// Starts a program.
    ///
    /// # Panics
    /// If it cannot be started.
    pub fn start<P: AsRef<OsStr>>(program: P, args: &[&str]) -> Self {
        let mut command = Command::new(&program);
        command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let name = format!("{} {}", program.as_ref().to_string_lossy(), args.join(" "));
        let mut child = command.spawn().unwrap_or_else(|error| panic!("{name}: {error}"));
        let lines = Arc::new(Mutex::new(Vec::new()));
        let outputs: [Option<Box<dyn Read + Send>>; 2] = [
            child.stdout.take().map(|output| Box::new(output) as Box<dyn Read + Send>),
            child.stderr.take().map(|output| Box::new(output) as Box<dyn Read + Send>),
        ];
        let readers = outputs
            .into_iter()
            .flatten()
            .map(|output| {
                let lines = Arc::clone(&lines);
                std::thread::spawn(move || {
                    for line in BufReader::new(output).lines().map_while(Result::ok) {
                        lines.lock().expect("no test panics while it holds this").push(line);
                    }
                })
            })
            .collect();
        Self { name, child, lines, readers }
    }

    /// What it has printed, both outputs.
    pub fn lines(&self) -> Vec<String> {
        self.lines.lock().expect("no test panics while it holds this").clone()
    }

    /// Waits for a line that holds `text`, the `n`-th (from 1).
    ///
    /// # Panics
    /// If it does not come in time.
    pub fn wait_for_nth(&mut self, text: &str, n: usize, limit: Duration) -> String {
        let started = Instant::now();
        loop {
            if let Some(line) = self.lines().iter().filter(|line| line.contains(text)).nth(n - 1) {
                return line.clone();
            }
            let over = started.elapsed() >= limit;
            assert!(
                !over,
                "{}: no \"{text}\" ({n}) within {limit:?}; it said:\n{}",
                self.name,
                self.lines().join("\n")
            );
            std::thread::sleep(LOOK);
        }
    }

    /// Waits for a line that holds `text`.
    ///
    /// # Panics
    /// If it does not come in time.
    pub fn wait_for(&mut self, text: &str, limit: Duration) -> String {
        self.wait_for_nth(text, 1, limit)
    }

    /// Has it ended?
    pub fn has_ended(&mut self) -> bool {
        self.child.try_wait().is_ok_and(|status| status.is_some())
    }

    /// Waits for its end; its status and all that it printed.
    ///
    /// # Panics
    /// If it does not end in time.
    pub fn end(mut self, limit: Duration) -> (ExitStatus, Vec<String>) {
        let started = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().expect("it is our child") {
                break status;
            }
            let over = started.elapsed() >= limit;
            assert!(!over, "{} did not end within {limit:?}; it said:\n{}", self.name, self.lines().join("\n"));
            std::thread::sleep(LOOK);
        };
        for reader in self.readers.drain(..) {
            let _ = reader.join();
        }
        (status, self.lines())
    }

    /// Kills it, as `kill -9` does.
    pub fn kill(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    /// Sends it a signal, by name.
    ///
    /// # Panics
    /// If there is no `kill`.
    pub fn signal(&self, name: &str) {
        let (name, id) = (format!("-{name}"), self.child.id().to_string());
        Command::new("kill").args([&name, &id]).status().expect("there is kill");
    }

    /// Asks it to end, as Ctrl-C does, and waits for that.
    ///
    /// # Panics
    /// If there is no `kill`, or it does not end in time.
    pub fn interrupt(&mut self, limit: Duration) {
        self.signal("INT");
        let started = Instant::now();
        while !self.has_ended() {
            assert!(started.elapsed() < limit, "{} does not end", self.name);
            std::thread::sleep(LOOK);
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.kill();
    }
}
