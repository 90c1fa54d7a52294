//! The file that a recording goes to.

use super::channel::{Channel, Content};
use super::convert::time_ns;
use anyhow::Context;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// A chunk is closed at this size, if a flush does not close it before.
const CHUNK_BYTES: u64 = 1 << 20;

/// An MCAP file being written.
pub struct Sink {
    writer: Writer<BufWriter<File>>,
    /// Numbers in the file and messages so far, by topic; none before the first message.
    channels: BTreeMap<String, (u16, u32)>,
    bytes: Vec<u8>,
}

impl Sink {
    /// A new file with nothing in it.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn create(path: &Path) -> anyhow::Result<Self> {
        let writer = WriteOptions::new()
            .library(concat!("tactus ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Lz4))
            .chunk_size(Some(CHUNK_BYTES))
            // A chunk is written as a whole, with its lengths: a file that breaks off has no chunk that claims to be empty.
            .disable_seeking(true)
            .create(BufWriter::new(File::create(path)?))?;
        Ok(Self { writer, channels: BTreeMap::new(), bytes: Vec::new() })
    }

    /// Lists a channel in the file.
    fn add(&mut self, channel: Channel, topic: &str) -> anyhow::Result<()> {
        let schema = channel.schema();
        let schema_id = self.writer.add_schema(&schema.name, schema.encoding, &schema.data)?;
        let about = [("description", channel.what()), ("rate", channel.rate())];
        let about = about.map(|(key, text)| (key.to_owned(), text.to_owned()));
        let id = self.writer.add_channel(schema_id, topic, channel.encoding(), &BTreeMap::from(about))?;
        self.channels.insert(topic.to_owned(), (id, 0));
        Ok(())
    }

    /// Writes a message of this tick; with the first one goes the list of all channels but those of frames.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&mut self, tick: u32, content: &Content) -> anyhow::Result<()> {
        if self.channels.is_empty() {
            // Not earlier: metadata and attachments end a chunk, and older readers refuse one that holds channels alone.
            for channel in Channel::ALL.iter().filter(|channel| !channel.is_of_frame()) {
                self.add(*channel, channel.topic())?;
            }
        }
        let topic = content.topic();
        if !self.channels.contains_key(&*topic) {
            self.add(content.channel(), &topic)?;
        }
        self.bytes.clear();
        content.encode(&mut self.bytes)?;
        let (channel_id, count) = self.channels.get_mut(&*topic).context(topic)?;
        let (log_time, sequence) = (time_ns(tick), *count);
        *count += 1;
        let header = MessageHeader { channel_id: *channel_id, sequence, log_time, publish_time: log_time };
        Ok(self.writer.write_to_known_channel(&header, &self.bytes)?)
    }

    /// Writes a JSON file into the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn attach(&mut self, tick: u32, name: &str, text: String) -> anyhow::Result<()> {
        Ok(self.writer.attach(&mcap::Attachment {
            log_time: time_ns(tick),
            create_time: time_ns(tick),
            name: name.to_owned(),
            media_type: "application/json".to_owned(),
            data: Cow::Owned(text.into_bytes()),
        })?)
    }

    /// Writes named texts.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn describe(&mut self, name: &str, texts: BTreeMap<String, String>) -> anyhow::Result<()> {
        Ok(self.writer.write_metadata(&mcap::records::Metadata { name: name.to_owned(), metadata: texts })?)
    }

    /// All that was written so far is in the file, and readable if nothing follows.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn flush(&mut self) -> anyhow::Result<()> {
        Ok(self.writer.flush()?)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self) -> anyhow::Result<()> {
        self.writer.finish()?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::sample::Foretold;

    #[test]
    fn every_chunk_holds_messages_and_every_channel_is_listed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("chunks.mcap");
        let mut sink = Sink::create(&path).unwrap();
        sink.describe("before", BTreeMap::new()).unwrap();
        sink.attach(0, "before.json", "{}".to_owned()).unwrap();
        sink.flush().unwrap();
        for tick in 0..3 {
            sink.write(tick, &Content::Foretold(Foretold { tick, agrees: true })).unwrap();
            sink.flush().unwrap();
        }
        sink.attach(3, "after.json", "{}".to_owned()).unwrap();
        sink.describe("after", BTreeMap::new()).unwrap();
        sink.finish().unwrap();
        let summary = mcap::Summary::read(&std::fs::read(&path).unwrap()).unwrap().unwrap();
        assert_eq!(summary.chunk_indexes.len(), 3);
        assert!(summary.chunk_indexes.iter().all(|chunk| !chunk.message_index_offsets.is_empty()));
        let listed: Vec<&str> = summary.channels.values().map(|channel| channel.topic.as_str()).collect();
        let expected = Channel::ALL.iter().filter(|channel| !channel.is_of_frame());
        assert!(expected.clone().all(|channel| listed.contains(&channel.topic())), "{listed:?}");
        assert_eq!(listed.len(), expected.count());
    }
}
