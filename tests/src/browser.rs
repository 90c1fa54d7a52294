//! A headless Chromium, driven through its DevTools protocol over a pipe: what a page says, asks for and shows.
//!
//! The protocol's own pipe (`--remote-debugging-pipe`: JSON with a NUL behind each message, on file descriptors 3 and 4)
//! needs no port and no WebSocket; `serde_json` is all that it takes.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// One browser at a time: drawing without a graphics card takes all processors.
static TURN: Mutex<()> = Mutex::new(());

/// An answer that takes longer will not come.
const PATIENCE: Duration = Duration::from_secs(60);

/// No network, no first-run pages, WebGL without a graphics card.
const FLAGS: &[&str] = &[
    "--headless",
    "--no-sandbox",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--remote-debugging-pipe",
];

/// One browser with one page.
pub struct Browser {
    child: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    session: String,
    asked: u64,
    events: Vec<Value>,
    _profile: TempDir,
    _turn: MutexGuard<'static, ()>,
}

impl Browser {
    /// Starts a browser with an empty page, once no other runs in this process.
    ///
    /// # Panics
    /// If there is none (`cargo xtask setup` installs it), or it does not answer.
    pub fn start() -> Self {
        // A test that has failed holds up no other.
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let profile = tempfile::tempdir().expect("a temporary folder");
        // The protocol's descriptors are the two that a child's pipes can be: its standard input and output.
        let mut child = Command::new("sh")
            .args(["-c", "exec chromium \"$@\" 3<&0 4>&1 0</dev/null 1>/dev/null 2>/dev/null", "sh"])
            .args(FLAGS)
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("sh starts");
        let to = child.stdin.take().expect("its input");
        let output = child.stdout.take().expect("its output");
        let (heard, from) = channel();
        std::thread::spawn(move || {
            for message in BufReader::new(output).split(0).map_while(Result::ok) {
                let Ok(value) = serde_json::from_slice(&message) else { break };
                if heard.send(value).is_err() {
                    break;
                }
            }
        });
        let session = String::new();
        let mut browser =
            Self { child, to, from, session, asked: 0, events: Vec::new(), _profile: profile, _turn: turn };
        let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }))["targetId"].clone();
        let attached = browser.call("Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        browser.session = attached["sessionId"].as_str().expect("a session").to_owned();
        let size = json!({ "width": 1280, "height": 720, "deviceScaleFactor": 1, "mobile": false });
        browser.call("Emulation.setDeviceMetricsOverride", size);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// Calls a method of the protocol; its result.
    ///
    /// # Panics
    /// If the browser refuses it or does not answer.
    pub fn call(&mut self, method: &str, params: Value) -> Value {
        self.asked += 1;
        let mut message = json!({ "id": self.asked, "method": method, "params": params });
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        self.to.write_all(message.to_string().as_bytes()).expect("the browser listens");
        self.to.write_all(&[0]).expect("the browser listens");
        loop {
            let answer = self
                .from
                .recv_timeout(PATIENCE)
                .unwrap_or_else(|_| panic!("{method}: no answer; is chromium installed?"));
            if answer["id"] == self.asked {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.events.push(answer);
        }
    }

    /// The value of an expression in the page.
    pub fn value(&mut self, expression: &str) -> Value {
        let asked = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let told = self.call("Runtime.evaluate", asked);
        assert!(told["exceptionDetails"].is_null(), "{expression}: {}", told["exceptionDetails"]);
        told["result"]["value"].clone()
    }

    /// Opens a file (with `#hash`) and waits for the page to be ready; milliseconds that the page took for it.
    pub fn open(&mut self, file: &Path, hash: &str) -> f64 {
        self.call("Page.navigate", json!({ "url": "about:blank" }));
        self.events.clear();
        self.call("Page.navigate", json!({ "url": format!("file://{}#{hash}", file.display()) }));
        self.wait_for("document.documentElement?.dataset.ready === 'true'");
        self.value("performance.getEntriesByName('ready')[0].startTime").as_f64().expect("a time")
    }

    /// Processor time that all of the browser's processes have used so far, milliseconds.
    pub fn processor_ms(&self) -> f64 {
        let entries = std::fs::read_dir("/proc").expect("/proc").filter_map(Result::ok);
        let all: Vec<Stat> = entries.filter_map(|entry| Stat::read(&entry.path())).collect();
        let mut family = vec![self.child.id()];
        let mut seen = 0;
        while let Some(parent) = family.get(seen).copied() {
            family.extend(all.iter().filter(|stat| stat.parent == parent).map(|stat| stat.process));
            seen += 1;
        }
        all.iter().filter(|stat| family.contains(&stat.process)).map(|stat| stat.ms).sum()
    }

    /// Waits until an expression is true in the page.
    ///
    /// # Panics
    /// If it never is.
    pub fn wait_for(&mut self, expression: &str) {
        let started = Instant::now();
        while self.value(expression) != true {
            assert!(started.elapsed() < PATIENCE, "never: {expression}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Presses and releases a key, named as scripts name it.
    pub fn press(&mut self, key: &str) {
        let text = if key.chars().count() == 1 { key } else { "" };
        self.call("Input.dispatchKeyEvent", json!({ "type": "keyDown", "key": key, "text": text }));
        self.call("Input.dispatchKeyEvent", json!({ "type": "keyUp", "key": key }));
    }

    /// What has happened since the page was opened, of one kind.
    pub fn events(&self, method: &str) -> Vec<&Value> {
        self.events.iter().filter(|event| event["method"] == method).map(|event| &event["params"]).collect()
    }
}

/// What the kernel says of a process.
struct Stat {
    process: u32,
    parent: u32,
    ms: f64,
}

impl Stat {
    /// Of a folder of /proc; `None` if it is none of a process, or of one that has just ended (proc(5), `stat`).
    fn read(folder: &Path) -> Option<Self> {
        let process = folder.file_name()?.to_str()?.parse().ok()?;
        let text = std::fs::read_to_string(folder.join("stat")).ok()?;
        // Behind the name, which may hold anything: state, parent, ..., and as 14th and 15th of all the times, in 10 ms.
        let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
        let ticks = |i: usize| fields.get(i)?.parse::<f64>().ok();
        Some(Self { process, parent: fields.get(1)?.parse().ok()?, ms: 10.0 * (ticks(11)? + ticks(12)?) })
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It may have gone already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
