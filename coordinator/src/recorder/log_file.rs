//! The MCAP file itself: schemas, topics, messages; every setting that decides about its bytes stands here.

use foxglove::Schema;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, McapError, WriteOptions, Writer};
use prost::Message;
use protocol::{LOG_EPOCH_NS, Timestamp};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;
use thiserror::Error;

const CHUNK_BYTES: u64 = 1 << 20;

/// Why a log cannot be written.
#[derive(Debug, Error)]
#[error("the log cannot be written: {0}; what was written before stays readable")]
pub struct RecordError(#[from] McapError);

/// Number of a topic in one file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TopicId(u16);

/// An MCAP file that is being written.
pub(super) struct LogFile<W: Write> {
    writer: Writer<NoSeek<W>>,
    now: Timestamp,
    buffer: Vec<u8>,
    written: Vec<u32>,
}

impl<W: Write> LogFile<W> {
    pub(super) fn new(writer: W) -> Result<Self, RecordError> {
        let writer = WriteOptions::new()
            .library(concat!("oxplow ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_level(1)
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            .disable_seeking(true)
            .create(NoSeek::new(writer))?;
        Ok(Self { writer, now: Timestamp::ZERO, buffer: Vec::new(), written: Vec::new() })
    }

    /// Sets the time of what is written next; never goes back, so that times rise along each topic.
    pub(super) fn set_now(&mut self, now: Timestamp) {
        self.now = self.now.max(now);
    }

    pub(super) fn now(&self) -> Timestamp {
        self.now
    }

    /// The present moment as viewers show it.
    pub(super) fn stamp(&self) -> foxglove::messages::Timestamp {
        let nanos = self.log_time();
        foxglove::messages::Timestamp::new((nanos / 1_000_000_000) as u32, (nanos % 1_000_000_000) as u32)
    }

    fn log_time(&self) -> u64 {
        LOG_EPOCH_NS.saturating_add(self.now.as_nanos())
    }

    pub(super) fn add_topic(&mut self, topic: &str, schema: &Schema) -> Result<TopicId, RecordError> {
        let encoding = if schema.encoding == "protobuf" { "protobuf" } else { "cdr" };
        let schema = self.writer.add_schema(&schema.name, &schema.encoding, &schema.data)?;
        let id = self.writer.add_channel(schema, topic, encoding, &BTreeMap::new())?;
        if self.written.len() <= usize::from(id) {
            self.written.resize(usize::from(id) + 1, 0);
        }
        Ok(TopicId(id))
    }

    pub(super) fn write(&mut self, topic: TopicId, message: &impl Message) -> Result<(), RecordError> {
        let mut buffer = std::mem::take(&mut self.buffer);
        buffer.clear();
        message.encode_raw(&mut buffer);
        let written = self.write_bytes(topic, &buffer);
        self.buffer = buffer;
        written
    }

    pub(super) fn write_bytes(&mut self, topic: TopicId, bytes: &[u8]) -> Result<(), RecordError> {
        let time = self.log_time();
        let sequence = &mut self.written[usize::from(topic.0)];
        *sequence = sequence.wrapping_add(1);
        let header =
            MessageHeader { channel_id: topic.0, sequence: *sequence, log_time: time, publish_time: time };
        Ok(self.writer.write_to_known_channel(&header, bytes)?)
    }

    pub(super) fn write_metadata(
        &mut self,
        name: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<(), RecordError> {
        Ok(self.writer.write_metadata(&Metadata { name: name.to_owned(), metadata })?)
    }

    pub(super) fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), RecordError> {
        let time = self.log_time();
        Ok(self.writer.attach(&Attachment {
            log_time: time,
            create_time: time,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: Cow::Borrowed(data),
        })?)
    }

    pub(super) fn flush(&mut self) -> Result<(), RecordError> {
        Ok(self.writer.flush()?)
    }

    pub(super) fn finish(mut self) -> Result<W, RecordError> {
        self.writer.finish()?;
        let mut inner = self.writer.into_inner().into_inner();
        inner.flush().map_err(McapError::from)?;
        Ok(inner)
    }
}
