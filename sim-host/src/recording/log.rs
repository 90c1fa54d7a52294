//! Reads a recording from its beginning, in a bounded amount of memory. One that was cut off is read up to the cut.

use super::channel::{Channel, Content};
use anyhow::{Context, bail};
use mcap::McapError;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// No record of a recording comes near this size; a longer one is damage.
const RECORD_BYTES_MAX: usize = 64 << 20;

/// Where a message comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Topic.
    pub topic: String,
    /// Name of its schema.
    pub schema: String,
    /// How its messages are encoded.
    pub encoding: String,
    /// The channel, if it is one of Tactus's own.
    pub channel: Option<Channel>,
}

/// A message.
#[derive(Clone, Debug)]
pub struct Message {
    /// Where it comes from.
    pub source: Rc<Source>,
    /// Robot time, nanoseconds since the start of the run.
    pub time_ns: u64,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

impl Message {
    /// Robot time, seconds since the start of the run.
    pub fn time_s(&self) -> f64 {
        self.time_ns as f64 * 1e-9
    }

    /// What it says; `None` if its channel is none of Tactus's own.
    ///
    /// # Errors
    /// Its bytes are none of its channel's.
    pub fn content(&self) -> anyhow::Result<Option<Content>> {
        let decode = |channel: Channel| {
            channel.decode(&self.bytes).with_context(|| format!("{} at {:.3} s", self.source.topic, self.time_s()))
        };
        self.source.channel.map(decode).transpose()
    }
}

/// A file within the recording.
#[derive(Clone, Debug)]
pub struct Attachment {
    /// Name.
    pub name: String,
    /// Media type.
    pub media_type: String,
    /// Content.
    pub bytes: Vec<u8>,
}

/// One thing in a recording.
#[derive(Clone, Debug)]
pub enum Entry {
    /// A message.
    Message(Message),
    /// A file.
    Attachment(Attachment),
    /// Named texts.
    Metadata {
        /// Name of the record.
        name: String,
        /// The texts by their names.
        texts: BTreeMap<String, String>,
    },
}

/// How a recording ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// As it should.
    Whole,
    /// It breaks off, or is damaged, after what was read; why.
    Cut(String),
}

/// A recording being read.
pub struct Log {
    path: PathBuf,
    file: File,
    reader: LinearReader,
    schemas: BTreeMap<u16, String>,
    sources: BTreeMap<u16, Rc<Source>>,
    ending: Option<Ending>,
}

impl Log {
    /// Opens a recording at its beginning.
    ///
    /// # Errors
    /// The file cannot be read, or is no MCAP file.
    pub fn open(path: &Path) -> anyhow::Result<Self> {
        let mut file = File::open(path).with_context(|| path.display().to_string())?;
        let mut start = [0; mcap::MAGIC.len()];
        let expected = || format!("{}: not a recording; expected an MCAP file", path.display());
        match file.read_exact(&mut start) {
            Err(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
                return Err(error).with_context(|| path.display().to_string());
            }
            Ok(()) if start == mcap::MAGIC => {}
            _ => bail!(expected()),
        }
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(RECORD_BYTES_MAX);
        Ok(Self {
            path: path.to_owned(),
            file,
            reader: LinearReader::new_with_options(options),
            schemas: BTreeMap::new(),
            sources: BTreeMap::new(),
            ending: None,
        })
    }

    /// The next thing; `None` at the end, which [`Self::ending`] then describes.
    ///
    /// # Errors
    /// The file cannot be read on.
    pub fn next_entry(&mut self) -> anyhow::Result<Option<Entry>> {
        while self.ending.is_none() {
            let event = match self.reader.next_event() {
                None => {
                    self.ending = Some(Ending::Whole);
                    break;
                }
                Some(Err(error)) => {
                    self.ending = Some(Ending::Cut(cause(&error)));
                    break;
                }
                Some(Ok(event)) => event,
            };
            match event {
                LinearReadEvent::ReadRequest(wanted) => {
                    let got = self.file.read(self.reader.insert(wanted));
                    self.reader.notify_read(got.with_context(|| self.path.display().to_string())?);
                }
                LinearReadEvent::Record { data, opcode } => {
                    let parsed = mcap::parse_record(opcode, data).map(Record::into_owned);
                    match parsed {
                        Ok(record) => {
                            if let Some(entry) = self.take(record) {
                                return Ok(Some(entry));
                            }
                        }
                        Err(error) => self.ending = Some(Ending::Cut(cause(&error))),
                    }
                }
            }
        }
        Ok(None)
    }

    /// How the recording ends; `None` before that was reached.
    pub fn ending(&self) -> Option<&Ending> {
        self.ending.as_ref()
    }

    /// Where messages come from, as far as was read.
    pub fn sources(&self) -> impl Iterator<Item = &Rc<Source>> {
        self.sources.values()
    }

    /// Keeps what later records refer to; what is for the caller is given back.
    fn take(&mut self, record: Record<'static>) -> Option<Entry> {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
                None
            }
            Record::Channel(channel) => {
                let schema = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let source = source(channel.topic, schema, channel.message_encoding);
                self.sources.entry(channel.id).or_insert_with(|| Rc::new(source));
                None
            }
            Record::Message { header, data } => {
                let Some(source) = self.sources.get(&header.channel_id).cloned() else {
                    self.ending =
                        Some(Ending::Cut(format!("a message of channel {}, which is none", header.channel_id)));
                    return None;
                };
                Some(Entry::Message(Message { source, time_ns: header.log_time, bytes: data.into_owned() }))
            }
            Record::Attachment { header, data, .. } => Some(Entry::Attachment(Attachment {
                name: header.name,
                media_type: header.media_type,
                bytes: data.into_owned(),
            })),
            Record::Metadata(metadata) => Some(Entry::Metadata { name: metadata.name, texts: metadata.metadata }),
            _ => None,
        }
    }
}

impl Iterator for Log {
    type Item = anyhow::Result<Entry>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_entry().transpose()
    }
}

fn source(topic: String, schema: String, encoding: String) -> Source {
    // Another program's channel may bear the same name.
    let channel =
        Channel::of_topic(&topic).filter(|channel| channel.encoding() == encoding && channel.schema_name() == schema);
    Source { topic, schema, encoding, channel }
}

/// Why nothing more can be read.
fn cause(error: &McapError) -> String {
    match error {
        McapError::UnexpectedEof | McapError::BadMagic | McapError::BadFooter => "it ends within a record".to_owned(),
        other => format!("damaged: {other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::sample::{Foretold, LinkForces};
    use crate::recording::sink::Sink;

    /// A recording of so many messages, a chunk every ten.
    fn recording(path: &Path, messages: u32) {
        let mut sink = Sink::create(path).unwrap();
        sink.describe("tactus.run", BTreeMap::from([("seed".to_owned(), "7".to_owned())])).unwrap();
        for tick in 0..messages {
            sink.write(tick, &message(tick)).unwrap();
            if tick % 10 == 9 {
                sink.flush().unwrap();
            }
        }
        sink.attach(messages, "summary.json", "{}".to_owned()).unwrap();
        sink.finish().unwrap();
    }

    fn message(tick: u32) -> Content {
        if tick.is_multiple_of(3) {
            Content::Foretold(Foretold { tick, agrees: tick.is_multiple_of(2) })
        } else {
            Content::LinkForces(LinkForces { tick, force_n: [tick as f32 * 0.1; 9] })
        }
    }

    /// What can be read of these bytes: messages, attachments, ending.
    fn read(folder: &Path, bytes: &[u8]) -> anyhow::Result<(Vec<Content>, usize, Ending)> {
        let path = folder.join("cut.mcap");
        std::fs::write(&path, bytes)?;
        let mut log = Log::open(&path)?;
        let (mut messages, mut attachments) = (Vec::new(), 0);
        while let Some(entry) = log.next_entry()? {
            match entry {
                Entry::Message(message) => messages.extend(message.content()?),
                Entry::Attachment(_) => attachments += 1,
                Entry::Metadata { .. } => {}
            }
        }
        Ok((messages, attachments, log.ending().cloned().expect("it was read to its end")))
    }

    #[test]
    fn what_was_written_is_read_and_after_a_cut_anywhere_what_comes_before_it() {
        let folder = tempfile::tempdir().unwrap();
        let whole = folder.path().join("whole.mcap");
        recording(&whole, 100);
        let bytes = std::fs::read(&whole).unwrap();
        let expected: Vec<Content> = (0..100).map(message).collect();
        assert_eq!(read(folder.path(), &bytes).unwrap(), (expected.clone(), 1, Ending::Whole));
        let mut before = 0;
        for cut in (mcap::MAGIC.len()..bytes.len()).step_by(43).chain([bytes.len() - 1]) {
            let (messages, _, ending) = read(folder.path(), &bytes[..cut]).unwrap();
            assert_eq!(ending, Ending::Cut("it ends within a record".to_owned()), "cut at {cut} of {}", bytes.len());
            assert_eq!(messages, expected[..messages.len()], "cut at {cut}");
            assert!(messages.len() % 10 == 0 && messages.len() >= before, "cut at {cut}: {}", messages.len());
            before = messages.len();
        }
        assert_eq!(before, 100);
    }

    #[test]
    fn of_a_damaged_recording_no_message_is_read_that_was_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let whole = folder.path().join("whole.mcap");
        recording(&whole, 100);
        let bytes = std::fs::read(&whole).unwrap();
        // Channels and schemas are repeated in the index at the end; the messages lie before it.
        let expected: Vec<Content> = (0..100).map(message).collect();
        let mut damaged = 0;
        for place in (mcap::MAGIC.len()..bytes.len()).step_by(97) {
            let mut bytes = bytes.clone();
            bytes[place] ^= 0x10;
            let Ok((messages, _, ending)) = read(folder.path(), &bytes) else { continue };
            assert!(messages.iter().all(|message| expected.contains(message)), "damaged at {place}");
            damaged += usize::from(ending != Ending::Whole);
        }
        assert!(damaged > 20, "{damaged}");
    }

    #[test]
    fn what_is_no_recording_is_refused_in_one_line_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        for bytes in [&b""[..], b"\x89MCA", b"tick,x_m\n0,0.1\n0,0.1\n"] {
            let message = format!("{:#}", read(folder.path(), bytes).unwrap_err());
            assert!(message.contains("cut.mcap: not a recording; expected an MCAP file"), "{message}");
            assert_eq!(message.lines().count(), 1);
        }
    }
}
