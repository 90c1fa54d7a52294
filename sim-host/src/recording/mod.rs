//! All of a run in one file: an MCAP log that Foxglove, Rerun and every other reader of that format can show, with
//! Foxglove's standard types where there is one and JSON with a schema elsewhere (`docs/recording.md`).
//!
//! * [`channel`]: the list of channels. [`sample`]: their JSON types. [`scene`], [`solid`], `points`: pictures.
//! * [`Recorder`] watches a run and writes it; [`Log`] reads a recording, also one that was cut off. [`Contents`]: what is
//!   in it. [`export`]: its numbers as tables.

pub mod channel;
mod columns;
mod contents;
pub mod convert;
mod json;
mod log;
mod points;
mod protobuf;
mod recorder;
pub mod sample;
pub mod scene;
mod settings;
mod sink;
pub mod solid;
mod tables;

pub use channel::{Channel, Content};
pub use contents::Contents;
pub use log::{Attachment, Ending, Entry, Log, Message};
pub use recorder::Recorder;
pub use tables::{Exported, export};

/// Name of the attachment with the run's settings (JSON), written before the first tick.
pub const SETTINGS: &str = "settings.json";
/// Name of the attachment with the run's summary (JSON, as `--summary` writes it), written after the last tick.
pub const SUMMARY: &str = "summary.json";
/// Name of the metadata record with the run's seed, scene and program, written before the first tick.
pub const RUN: &str = "tactus.run";
/// Name of the metadata record with what the run came to, written after the last tick.
pub const RESULT: &str = "tactus.result";
