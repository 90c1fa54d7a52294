//! The file that a recording goes to.

use super::channel::{Channel, Content};
use super::convert::time_ns;
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
    /// Numbers in the file and messages so far, in the order of [`Channel::ALL`].
    channels: Vec<(u16, u32)>,
    bytes: Vec<u8>,
}

impl Sink {
    /// A new file with all channels and no message.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn create(path: &Path) -> anyhow::Result<Self> {
        let mut writer = WriteOptions::new()
            .library(concat!("tactus ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Lz4))
            .chunk_size(Some(CHUNK_BYTES))
            // A chunk is written as a whole, with its lengths: a file that breaks off has no chunk that claims to be empty.
            .disable_seeking(true)
            .create(BufWriter::new(File::create(path)?))?;
        let mut channels = Vec::new();
        for channel in Channel::ALL {
            let schema = channel.schema();
            let schema_id = writer.add_schema(&schema.name, schema.encoding, &schema.data)?;
            let about = [("description", channel.what()), ("rate", channel.rate())];
            let about = about.map(|(key, text)| (key.to_owned(), text.to_owned()));
            let id = writer.add_channel(schema_id, channel.topic(), channel.encoding(), &BTreeMap::from(about))?;
            channels.push((id, 0));
        }
        Ok(Self { writer, channels, bytes: Vec::new() })
    }

    /// Writes a message of this tick.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&mut self, tick: u32, content: &Content) -> anyhow::Result<()> {
        self.bytes.clear();
        content.encode(&mut self.bytes)?;
        let (channel_id, count) = &mut self.channels[content.channel() as usize];
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
