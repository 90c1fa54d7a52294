//! What is in a recording, in short.

use super::log::{Ending, Entry, Log, Source};
use super::{Content, RESULT, RUN};
use anyhow::Context;
use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// What is in a recording.
#[derive(Clone, Debug)]
pub struct Contents {
    /// The file.
    pub path: PathBuf,
    /// Its size, bytes.
    pub bytes: u64,
    /// How it ends.
    pub ending: Ending,
    /// What was known before the first tick; `None` if it is no recording of Tactus's.
    pub run: Option<BTreeMap<String, String>>,
    /// What was known after the last tick; `None` if the run did not come to its end, or the recording did not.
    pub result: Option<BTreeMap<String, String>>,
    /// First and last time of a message, seconds of robot time.
    pub time_s: Option<[f64; 2]>,
    /// When each phase began, seconds of robot time.
    pub phases: Vec<(f64, String)>,
    /// Channels with the number of their messages, in the order of the file.
    pub channels: Vec<(Rc<Source>, u64)>,
}

impl Contents {
    /// Reads a recording to its end.
    ///
    /// # Errors
    /// The file cannot be read, is no MCAP file, or holds a message that is none of its channel's.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let bytes = std::fs::metadata(path).with_context(|| path.display().to_string())?.len();
        let mut log = Log::open(path)?;
        let mut counts: BTreeMap<String, u64> = BTreeMap::new();
        let (mut run, mut result, mut phases) = (None, None, Vec::new());
        let mut time_s: Option<[f64; 2]> = None;
        while let Some(entry) = log.next_entry()? {
            match entry {
                Entry::Message(message) => {
                    *counts.entry(message.source.topic.clone()).or_default() += 1;
                    let now_s = message.time_s();
                    time_s = Some(time_s.map_or([now_s; 2], |[first, last]| [first.min(now_s), last.max(now_s)]));
                    if message.source.channel == Some(super::Channel::Phase)
                        && let Some(Content::Phase(phase)) =
                            message.content().with_context(|| path.display().to_string())?
                    {
                        phases.push((now_s, phase.phase));
                    }
                }
                Entry::Metadata { name, texts } if name == RUN => run = Some(texts),
                Entry::Metadata { name, texts } if name == RESULT => result = Some(texts),
                Entry::Metadata { .. } | Entry::Attachment(_) => {}
            }
        }
        let count = |source: &Rc<Source>| counts.get(&source.topic).copied().unwrap_or(0);
        let channels = log.sources().map(|source| (source.clone(), count(source))).collect();
        let ending = log.ending().cloned().unwrap_or(Ending::Whole);
        Ok(Self { path: path.to_owned(), bytes, ending, run, result, time_s, phases, channels })
    }
}

/// A text of a metadata record.
fn text<'a>(texts: &'a BTreeMap<String, String>, name: &str) -> &'a str {
    texts.get(name).map(String::as_str).filter(|text| !text.is_empty()).unwrap_or("none")
}

impl Display for Contents {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let [first_s, last_s] = self.time_s.unwrap_or_default();
        let messages: u64 = self.channels.iter().map(|(_, count)| count).sum();
        writeln!(f, "{}: {:.1} MB, {messages} messages", self.path.display(), self.bytes as f64 * 1e-6)?;
        match &self.ending {
            Ending::Whole => writeln!(f, "whole: {first_s:.3} s to {last_s:.3} s of robot time")?,
            Ending::Cut(why) => {
                writeln!(f, "cut off: {why}; readable from {first_s:.3} s to {last_s:.3} s of robot time")?
            }
        }
        match &self.run {
            Some(run) => writeln!(
                f,
                "seed {}, scene `{}`, reality {}, recorded by {}",
                text(run, "seed"),
                text(run, "scene"),
                text(run, "reality"),
                text(run, "program")
            )?,
            None => writeln!(f, "no settings of a run in it: not recorded by tactus")?,
        }
        match &self.result {
            Some(result) => writeln!(
                f,
                "outcome {}; {} touches; digest {} over {} ticks",
                text(result, "outcome"),
                text(result, "touches"),
                text(result, "digest"),
                text(result, "digest_ticks")
            )?,
            None => writeln!(f, "no outcome in it: the recording ends before the run did")?,
        }
        if !self.phases.is_empty() {
            writeln!(f, "\nphases")?;
        }
        for (begun_s, phase) in &self.phases {
            writeln!(f, "{begun_s:9.3} s  {phase}")?;
        }
        writeln!(f, "\nmessages  channel")?;
        for (source, count) in &self.channels {
            writeln!(f, "{count:8}  {:24}  {} ({})", source.topic, source.schema, source.encoding)?;
        }
        Ok(())
    }
}
