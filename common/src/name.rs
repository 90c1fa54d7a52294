//! Names on the wire: short, of fixed length, readable in a bus monitor.

use core::fmt;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Longest name, bytes.
pub const NAME_BYTES_MAX: usize = 24;

/// A name of up to [`NAME_BYTES_MAX`] printable ASCII characters without blanks; the rest is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Name([u8; NAME_BYTES_MAX]);

impl Name {
    /// This text as a name; `None` if it is empty, too long, or holds anything but printable ASCII without blanks.
    pub const fn new(text: &str) -> Option<Self> {
        let text = text.as_bytes();
        if text.is_empty() || text.len() > NAME_BYTES_MAX {
            return None;
        }
        let mut name = [0; NAME_BYTES_MAX];
        let mut i = 0;
        while i < text.len() {
            if !text[i].is_ascii_graphic() {
                return None;
            }
            name[i] = text[i];
            i += 1;
        }
        Some(Self(name))
    }

    /// The name; empty for bytes from the wire that are none.
    pub fn as_str(&self) -> &str {
        let length = self.0.iter().position(|byte| *byte == 0).unwrap_or(NAME_BYTES_MAX);
        let (text, padding) = self.0.split_at(length);
        let is_name = text.iter().all(u8::is_ascii_graphic) && padding.iter().all(|byte| *byte == 0);
        if is_name { core::str::from_utf8(text).unwrap_or("") } else { "" }
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_comes_back_as_it_was_and_what_is_none_is_refused() {
        for text in ["a", "levenberg-marquardt", "abcdefghijklmnopqrstuvwx"] {
            assert_eq!(Name::new(text).expect("a name").as_str(), text);
        }
        for text in ["", "abcdefghijklmnopqrstuvwxy", "two words", "Größe", "nul\0"] {
            assert_eq!(Name::new(text), None, "{text:?}");
        }
    }

    #[test]
    fn bytes_that_are_no_name_read_as_nothing() {
        let mut bytes = [0; NAME_BYTES_MAX];
        assert_eq!(Name(bytes).as_str(), "");
        bytes[0] = b'a';
        bytes[5] = b'b';
        assert_eq!(Name(bytes).as_str(), "", "something after the end");
        assert_eq!(Name([0xff; NAME_BYTES_MAX]).as_str(), "");
    }
}
