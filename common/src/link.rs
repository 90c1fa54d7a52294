//! Messages to bytes and back: the same two steps on both ends of the wire.

use crate::message::Message;
use serde::de::DeserializeOwned;

/// Longest encoded message that a node sends from its stack, bytes: every message but [`crate::message::PlanAnswer`].
pub const SMALL_BYTES: usize = 256;

/// Encodes a message (postcard).
///
/// # Errors
/// The buffer is too small.
pub fn encode<'b, M: Message>(message: &M, buffer: &'b mut [u8]) -> Result<&'b [u8], postcard::Error> {
    postcard::to_slice(message, buffer).map(|used| &*used)
}

/// Decodes a message. Zero bytes that CAN FD padded at the end are ignored.
///
/// # Errors
/// The bytes are not such a message.
pub fn decode<M: DeserializeOwned>(bytes: &[u8]) -> Result<M, postcard::Error> {
    postcard::take_from_bytes(bytes).map(|(message, _padding)| message)
}
