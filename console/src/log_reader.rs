//! Reads a log front to back, one record at a time, and trusts nothing in it.
//!
//! Lengths are limited before anything is allocated, each chunk's checksum is compared before its records are
//! looked at, and the records are parsed here, within the bytes that are there. A file that stops short (the
//! coordinator was killed, the disk was full) is read to its last whole record.

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::BTreeMap;
use std::io::Read;
use thiserror::Error;

/// The longest record, and the longest chunk once unpacked, that is looked at.
pub const RECORD_BYTES_MAX: usize = 128 << 20;

/// One thing that stands in a log.
#[derive(Debug)]
pub(crate) enum Entry<'a> {
    /// A named list of facts.
    Metadata { name: &'a str, facts: BTreeMap<&'a str, &'a str> },
    /// A file within the file.
    Attachment { name: &'a str, data: &'a [u8] },
    /// A message.
    Message { topic: &'a str, schema: &'a str, log_time_ns: u64, data: &'a [u8] },
}

/// How a log ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    /// In good order.
    Whole,
    /// Somewhere in the middle.
    Cut,
}

/// Why a log cannot be read.
#[derive(Debug, Error)]
pub enum LogError {
    /// The file cannot be opened or read.
    #[error("cannot be read")]
    Io(#[from] std::io::Error),
    /// It is something else.
    #[error("is not an MCAP file")]
    NotMcap,
    /// Bytes were changed after they were written.
    #[error("is damaged: {0}; `mcap recover` may save the rest")]
    Damaged(String),
    /// It is an MCAP file, and no log of ours.
    #[error("is not a log of oxplow: {0}")]
    Foreign(String),
}

/// Calls `visit` for everything that stands in a log, in the order of the file.
pub(crate) fn read_log<E: From<LogError>>(
    mut source: impl Read,
    mut visit: impl FnMut(Entry<'_>) -> Result<(), E>,
) -> Result<Ending, E> {
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_record_length_limit(RECORD_BYTES_MAX),
    );
    let mut contents = Contents::default();
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let read = source.read(reader.insert(wanted)).map_err(LogError::Io)?;
                reader.notify_read(read);
            }
            Ok(LinearReadEvent::Record { opcode: op::FOOTER, .. }) => return Ok(Ending::Whole),
            Ok(LinearReadEvent::Record { opcode, data }) => contents.take(opcode, data, &mut visit)?,
            Err(mcap::McapError::UnexpectedEof | mcap::McapError::UnexpectedEoc) => return Ok(Ending::Cut),
            Err(mcap::McapError::BadMagic) => return Err(LogError::NotMcap.into()),
            Err(error) => return Err(LogError::Damaged(error.to_string()).into()),
        }
    }
    Ok(Ending::Cut)
}

/// What was said so far about schemas and topics.
#[derive(Default)]
struct Contents {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
}

struct Channel {
    topic: String,
    schema: String,
}

impl Contents {
    fn take<E: From<LogError>>(
        &mut self,
        opcode: u8,
        data: &[u8],
        visit: &mut impl FnMut(Entry<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut fields = Fields(data);
        let broken = || LogError::Damaged(format!("a record of kind {opcode} is shorter than it says"));
        match opcode {
            op::SCHEMA => self.schema(&mut fields).ok_or_else(broken)?,
            op::CHANNEL => self.channel(&mut fields).ok_or_else(broken)?,
            op::MESSAGE => {
                let (channel, log_time_ns) = message_head(&mut fields).ok_or_else(broken)?;
                let unknown = || LogError::Damaged(format!("a message of the unknown channel {channel}"));
                let Channel { topic, schema } = self.channels.get(&channel).ok_or_else(unknown)?;
                visit(Entry::Message { topic, schema, log_time_ns, data: fields.0 })?;
            }
            op::METADATA => visit(metadata(&mut fields).ok_or_else(broken)?)?,
            op::ATTACHMENT => visit(attachment(&mut fields).ok_or_else(broken)?)?,
            _ => {}
        }
        Ok(())
    }

    fn schema(&mut self, fields: &mut Fields<'_>) -> Option<()> {
        let id = fields.u16()?;
        let name = fields.text()?.to_owned();
        self.schemas.insert(id, name);
        Some(())
    }

    fn channel(&mut self, fields: &mut Fields<'_>) -> Option<()> {
        let id = fields.u16()?;
        let schema = self.schemas.get(&fields.u16()?).cloned().unwrap_or_default();
        let topic = fields.text()?.to_owned();
        self.channels.insert(id, Channel { topic, schema });
        Some(())
    }
}

fn message_head(fields: &mut Fields<'_>) -> Option<(u16, u64)> {
    let channel = fields.u16()?;
    let _sequence = fields.u32()?;
    let log_time_ns = fields.u64()?;
    let _publish_time_ns = fields.u64()?;
    Some((channel, log_time_ns))
}

fn metadata<'a>(fields: &mut Fields<'a>) -> Option<Entry<'a>> {
    let name = fields.text()?;
    let length = fields.u32()? as usize;
    let mut pairs = Fields(fields.bytes(length)?);
    let mut facts = BTreeMap::new();
    while !pairs.0.is_empty() {
        facts.insert(pairs.text()?, pairs.text()?);
    }
    Some(Entry::Metadata { name, facts })
}

fn attachment<'a>(fields: &mut Fields<'a>) -> Option<Entry<'a>> {
    let _times = (fields.u64()?, fields.u64()?);
    let name = fields.text()?;
    let _media_type = fields.text()?;
    let length = usize::try_from(fields.u64()?).ok()?;
    Some(Entry::Attachment { name, data: fields.bytes(length)? })
}

/// The fields of a record, from the front; `None` when they reach over its end.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes(&mut self, length: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.bytes(N)?.try_into().ok()
    }

    fn u16(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(self.array()?))
    }

    fn u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.array()?))
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.array()?))
    }

    fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()? as usize;
        std::str::from_utf8(self.bytes(length)?).ok()
    }
}
