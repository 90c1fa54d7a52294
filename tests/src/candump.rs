//! The log of `candump -L` (can-utils): an independent witness of what was on the bus.

use tactus_common::can::{CanFrame, Mtu};

/// The frames of a log, in its order. Lines are `(seconds) interface ID#DATA`, CAN FD `ID##FLAGS DATA` without the blank.
///
/// # Panics
/// On a line that is none of candump's.
pub fn frames(log: &str) -> Vec<CanFrame> {
    log.lines().map(|line| frame(line).unwrap_or_else(|| panic!("no line of candump -L: {line}"))).collect()
}

fn frame(line: &str) -> Option<CanFrame> {
    let mut words = line.split_whitespace();
    let (_time, _interface, frame) = (words.next()?.strip_prefix('(')?, words.next()?, words.next()?);
    let (id, rest) = frame.split_once('#')?;
    let (mtu, data) = match rest.strip_prefix('#') {
        // One digit of flags.
        Some(fd) => (Mtu::Fd, fd.get(1..)?),
        None => (Mtu::Classic, rest),
    };
    let data: Option<Vec<u8>> =
        (0..data.len()).step_by(2).map(|i| u8::from_str_radix(data.get(i..i + 2)?, 16).ok()).collect();
    let number = u32::from_str_radix(id, 16).ok()?;
    match id.len() {
        8 => CanFrame::new(number, &data?, mtu).ok(),
        3 => CanFrame::new_base(u16::try_from(number).ok()?, &data?, mtu).ok(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_both_formats_and_identifier_lengths_are_read() {
        let log = "(1700000000.123456) vcan0 1064550A#0102FF\n\
                   (1700000000.123456) vcan0 1064550A##1000102030405060708090A0B T\n\
                   (1700000000.123457) vcan0 123#\n";
        let expected = [
            CanFrame::new(0x1064_550a, &[1, 2, 0xff], Mtu::Classic).unwrap(),
            CanFrame::new(0x1064_550a, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11], Mtu::Fd).unwrap(),
            CanFrame::new_base(0x123, &[], Mtu::Classic).unwrap(),
        ];
        assert_eq!(frames(log), expected);
    }

    #[test]
    fn what_is_no_frame_is_no_frame() {
        for line in
            ["", "(1.0) vcan0", "1.0 vcan0 123#", "(1.0) vcan0 123#0", "(1.0) vcan0 12#00", "(1.0) vcan0 123#GG"]
        {
            assert_eq!(frame(line), None, "{line}");
        }
    }
}
