//! Messages to bytes and back: the only place that names the codec.

use prost::Message;
use thiserror::Error;

/// The descriptor set of all messages, for logs whose readers decode by it.
pub const DESCRIPTORS: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/oxplow.v1.descriptors.bin"));

/// The longest message that is looked at.
pub const MESSAGE_BYTES_MAX: usize = 1 << 20;

/// Why bytes are no message.
#[derive(Debug, Error, PartialEq)]
pub enum DecodeError {
    /// Longer than any message of ours.
    #[error("{0} bytes; at most {MESSAGE_BYTES_MAX} are read")]
    TooLong(usize),
    /// Not this message.
    #[error("not a valid message: {0}")]
    Malformed(String),
}

/// The bytes of a message.
pub fn encode(message: &impl Message) -> Vec<u8> {
    message.encode_to_vec()
}

/// Reads a message. Never panics, whatever the bytes.
///
/// # Errors
///
/// [`DecodeError`].
pub fn decode<M: Message + Default>(bytes: &[u8]) -> Result<M, DecodeError> {
    if bytes.len() > MESSAGE_BYTES_MAX {
        return Err(DecodeError::TooLong(bytes.len()));
    }
    M::decode(bytes).map_err(|error| DecodeError::Malformed(error.to_string()))
}
