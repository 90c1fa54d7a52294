//! SLCAN: CAN frames as lines of ASCII on a serial line, as Lawicel's adapters and Linux's `slcan` speak it.
//!
//! A line ends with a carriage return. `tIIILDD..` is a data frame with an 11-bit identifier, `TIIIIIIIILDD..` one with
//! 29 bits: identifier, one digit of length, two hexadecimal digits a byte; four digits of a time stamp may follow.
//! `r`, `R` are remote frames, which nobody here sends. `O`, `C`, `Sn` open the channel, close it, and set its bit rate
//! (`S8` = 1 Mbit/s); an adapter answers a lone carriage return, or a bell where it refuses. There is no checksum: what
//! guards the content is the transfer CRC of [`crate::cyphal`] and the line's own strictness. CAN 2.0 only.

use crate::can::{CanFrame, FrameError, IdBits, Mtu};
use heapless::Vec;

/// Longest line that carries a frame, its end included: `T`, 8 digits, length, 8 bytes, carriage return.
pub const LINE_BYTES_MAX: usize = 27;
/// Longest line that is understood, its end not included: a frame with a time stamp.
const CONTENT_BYTES_MAX: usize = LINE_BYTES_MAX - 1 + STAMP_DIGITS;
const STAMP_DIGITS: usize = 4;
const END: u8 = b'\r';
const BELL: u8 = 0x07;

/// A line to be sent, its end included.
pub type Encoded = Vec<u8, LINE_BYTES_MAX>;

/// What a host tells an adapter, beside frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Join the bus.
    Open,
    /// Leave it.
    Close,
    /// Bit rate by number, 0..=8: 10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s.
    Speed(u8),
}

impl Command {
    /// What `slcand -o -s8` sends to begin: leave the bus if on it, 1 Mbit/s, join.
    pub const BEGIN: [Self; 3] = [Self::Close, Self::Speed(8), Self::Open];

    /// The line.
    pub fn encode(self) -> Encoded {
        let mut line = Encoded::new();
        let _ = match self {
            Self::Open => line.push(b'O'),
            Self::Close => line.push(b'C'),
            Self::Speed(number) => line.push(b'S').and_then(|()| line.push(b'0' + number.min(8))),
        };
        let _ = line.push(END);
        line
    }
}

/// What one line said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// A data frame, always CAN 2.0.
    Frame(CanFrame),
    /// A command.
    Command(Command),
    /// The adapter did what it was told (an empty line).
    Done,
    /// The adapter refused (a bell).
    Refused,
    /// A line that is no use here: a remote frame, another command, an adapter's receipt, text.
    Other,
    /// A line that begins as a frame and is none, or one that is too long for anything.
    Damaged,
}

/// The answer to a command that was carried out.
pub const DONE: [u8; 1] = [END];

/// A frame as a line.
///
/// # Errors
/// [`FrameError::Length`] for a CAN FD frame: SLCAN has none.
pub fn encode(frame: &CanFrame) -> Result<Encoded, FrameError> {
    if frame.is_fd() {
        return Err(FrameError::Length);
    }
    let (kind, digits) = match frame.id_bits() {
        IdBits::Base => (b't', 3),
        IdBits::Extended => (b'T', 8),
    };
    let mut line = Encoded::new();
    let mut put = |byte: u8| {
        // A CAN 2.0 frame has at most eight bytes, so the line has room: it is made for the longest.
        let _ = line.push(byte);
    };
    put(kind);
    for place in (0..digits).rev() {
        put(digit((frame.id() >> (4 * place)) as u8));
    }
    put(digit(frame.dlc()));
    for byte in frame.data() {
        put(digit(byte >> 4));
        put(digit(*byte));
    }
    put(END);
    Ok(line)
}

/// The lower four bits as a hexadecimal digit, upper case as Linux writes it.
fn digit(value: u8) -> u8 {
    match value & 0xf {
        ten @ 10.. => b'A' + (ten - 10),
        low => b'0' + low,
    }
}

fn value(digit: u8) -> Option<u8> {
    match digit {
        b'0'..=b'9' => Some(digit - b'0'),
        b'a'..=b'f' => Some(digit - b'a' + 10),
        b'A'..=b'F' => Some(digit - b'A' + 10),
        _ => None,
    }
}

/// Makes lines of bytes. Survives anything: what is no line of ours costs at most the line that it is in.
#[derive(Clone, Debug, Default)]
pub struct Parser {
    line: Vec<u8, CONTENT_BYTES_MAX>,
    /// The line has outgrown anything sensible; its bytes are dropped up to its end.
    overlong: bool,
}

impl Parser {
    /// At the beginning of a line.
    pub const fn new() -> Self {
        Self { line: Vec::new(), overlong: false }
    }

    /// Takes a byte; where it ends a line, what that line said.
    pub fn feed(&mut self, byte: u8) -> Option<Line> {
        let said = match byte {
            END if self.overlong => Line::Damaged,
            END => read(&self.line),
            // What stands before a bell was cut short.
            BELL => Line::Refused,
            b'\n' => return None,
            _ => {
                self.overlong |= self.line.push(byte).is_err();
                return None;
            }
        };
        self.line.clear();
        self.overlong = false;
        Some(said)
    }
}

/// What the content of a line says.
fn read(line: &[u8]) -> Line {
    let Some((kind, rest)) = line.split_first() else { return Line::Done };
    let frame = match (kind, rest) {
        (b't', rest) => read_frame(rest, 3, IdBits::Base),
        (b'T', rest) => read_frame(rest, 8, IdBits::Extended),
        (b'O', []) => return Line::Command(Command::Open),
        (b'C', []) => return Line::Command(Command::Close),
        (b'S', [number @ b'0'..=b'8']) => return Line::Command(Command::Speed(number - b'0')),
        _ => return Line::Other,
    };
    frame.map_or(Line::Damaged, Line::Frame)
}

/// A frame from what follows its first letter.
fn read_frame(rest: &[u8], id_digits: usize, id_bits: IdBits) -> Option<CanFrame> {
    let (id, rest) = rest.split_at_checked(id_digits)?;
    let id = id.iter().try_fold(0_u32, |id, &digit| Some(id << 4 | u32::from(value(digit)?)))?;
    let (&length, rest) = rest.split_first()?;
    let length = usize::from(value(length)?);
    let (digits, stamp) = rest.split_at_checked(2 * length)?;
    let stamped = stamp.len() == STAMP_DIGITS && stamp.iter().all(|&digit| value(digit).is_some());
    if !stamp.is_empty() && !stamped {
        return None;
    }
    let mut bytes = Vec::<u8, 8>::new();
    for pair in digits.chunks_exact(2) {
        let &[high, low] = pair else { return None };
        bytes.push(value(high)? << 4 | value(low)?).ok()?;
    }
    match id_bits {
        IdBits::Base => CanFrame::new_base(u16::try_from(id).ok()?, &bytes, Mtu::Classic).ok(),
        IdBits::Extended => CanFrame::new(id, &bytes, Mtu::Classic).ok(),
    }
}

#[cfg(test)]
mod tests;
