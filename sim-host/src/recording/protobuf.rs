//! Messages of Foxglove's standard types, in protobuf.

use super::channel::Schema;
use foxglove::{Decode, Encode};

/// The encoding's name.
pub const ENCODING: &str = "protobuf";

/// A type's name in recordings: that of Foxglove's own schemas.
pub fn schema_name<T: Encode>() -> String {
    T::get_schema().map(|schema| schema.name).unwrap_or_default()
}

/// A type's schema: all that its messages are made of.
pub fn schema<T: Encode>() -> Schema {
    let schema = T::get_schema();
    Schema {
        name: schema_name::<T>(),
        encoding: "protobuf",
        data: schema.map(|s| s.data.into_owned()).unwrap_or_default(),
    }
}

/// Appends a message.
///
/// # Errors
/// Memory is exhausted.
pub fn encode<T: Encode>(message: &T, bytes: &mut Vec<u8>) -> anyhow::Result<()> {
    message.encode(bytes).map_err(|error| anyhow::anyhow!("{error}"))
}

/// The message in these bytes.
///
/// # Errors
/// There is none.
pub fn decode<T: Decode>(bytes: &[u8]) -> anyhow::Result<T> {
    T::decode(bytes).map_err(|error| anyhow::anyhow!("{error}"))
}
