use super::*;
use proptest::prelude::*;

extern crate std;
use std::string::String;
use std::vec::Vec as Many;

fn feed(parser: &mut Parser, bytes: &[u8]) -> Many<Line> {
    bytes.iter().filter_map(|&byte| parser.feed(byte)).collect()
}

fn lines(bytes: &[u8]) -> Many<Line> {
    feed(&mut Parser::new(), bytes)
}

fn text(frame: &CanFrame) -> String {
    String::from_utf8(encode(frame).unwrap().to_vec()).unwrap()
}

fn frames() -> impl Strategy<Value = CanFrame> {
    (any::<bool>(), any::<u32>(), prop::collection::vec(any::<u8>(), 0..=8)).prop_map(|(base, id, data)| {
        if base {
            CanFrame::new_base(id as u16 & crate::can::BASE_ID_MAX, &data, Mtu::Classic).unwrap()
        } else {
            CanFrame::new(id & crate::can::ID_MAX, &data, Mtu::Classic).unwrap()
        }
    })
}

#[test]
fn lines_are_written_as_the_adapter_s_manual_shows_them() {
    // Lawicel CANUSB manual: t10021133 = identifier 100, bytes 11 33; T0000010021133 = the same with 29 bits.
    let base = CanFrame::new_base(0x100, &[0x11, 0x33], Mtu::Classic).unwrap();
    let extended = CanFrame::new(0x100, &[0x11, 0x33], Mtu::Classic).unwrap();
    assert_eq!(text(&base), "t10021133\r");
    assert_eq!(text(&extended), "T0000010021133\r");
    assert_eq!(lines(b"t10021133\rT0000010021133\r"), [Line::Frame(base), Line::Frame(extended)]);
    let longest = CanFrame::new(0x1fff_ffff, &[0xab; 8], Mtu::Classic).unwrap();
    assert_eq!(text(&longest), "T1FFFFFFF8ABABABABABABABAB\r");
    assert_eq!(text(&longest).len(), LINE_BYTES_MAX);
}

#[test]
fn a_channel_is_opened_with_the_lines_that_slcand_sends() {
    let sent: Many<u8> = Command::BEGIN.iter().flat_map(|command| command.encode()).collect();
    assert_eq!(sent, b"C\rS8\rO\r");
    assert_eq!(lines(&sent), Command::BEGIN.map(Line::Command));
    assert_eq!(lines(&DONE), [Line::Done]);
    assert_eq!(lines(b"\x07"), [Line::Refused]);
    for number in 0..=8 {
        assert_eq!(lines(&Command::Speed(number).encode()), [Line::Command(Command::Speed(number))]);
    }
}

#[test]
fn lower_case_digits_time_stamps_and_line_feeds_are_understood() {
    let frame = CanFrame::new(0x1ab, &[0xcd], Mtu::Classic).unwrap();
    for line in ["T000001ab1cd\r", "T000001AB1CD1234\r", "T000001aB1Cd\r\n"] {
        assert_eq!(lines(line.as_bytes()), [Line::Frame(frame)], "{line:?}");
    }
}

#[test]
fn what_is_no_use_is_told_from_what_is_damaged() {
    for line in ["r1230\r", "R000001230\r", "z\r", "Z\r", "V1013\r", "S9\r", "S\r", "OO\r", "panicked at x.rs:1\r"] {
        assert_eq!(lines(line.as_bytes()), [Line::Other], "{line:?}");
    }
    for line in [
        "t\r",
        "t12\r",
        "t123\r",
        "t1231\r",
        "t12311\r",
        "t1231112\r",
        "t1230123\r",
        "t123012345\r",
        "t1239112233445566778899\r",
        "t8000\r",
        "tx230\r",
        "T200000000\r",
        "T0000000019\r",
        "t1231-1\r",
        "t12\x001\r",
    ] {
        assert_eq!(lines(line.as_bytes()), [Line::Damaged], "{line:?}");
    }
}

#[test]
fn a_can_fd_frame_is_refused_and_not_cut() {
    let frame = CanFrame::new(1, &[0; 12], Mtu::Fd).unwrap();
    assert_eq!(encode(&frame), Err(FrameError::Length));
    let short = CanFrame::new(1, &[0; 2], Mtu::Fd).unwrap();
    assert_eq!(encode(&short), Err(FrameError::Length), "a CAN FD frame of two bytes is not a CAN 2.0 frame");
}

proptest! {
    #[test]
    fn every_frame_comes_back_as_it_was(frame in frames()) {
        prop_assert_eq!(lines(&encode(&frame).unwrap()), [Line::Frame(frame)]);
    }

    #[test]
    fn after_any_garbage_the_line_after_the_next_end_is_whole(garbage: Many<u8>, frame in frames()) {
        let mut parser = Parser::new();
        feed(&mut parser, &garbage);
        parser.feed(END);
        prop_assert_eq!(feed(&mut parser, &encode(&frame).unwrap()), [Line::Frame(frame)]);
    }

    #[test]
    fn garbage_of_the_protocol_s_own_letters_gives_one_line_an_end_and_only_frames_that_can_be_sent(
        bytes in prop::collection::vec(prop::sample::select(&b"tTrRSOC0123456789abcdefABCDEF\r\x07\n"[..]), 0..400),
    ) {
        let ends = bytes.iter().filter(|&&byte| byte == END || byte == BELL).count();
        let said = lines(&bytes);
        prop_assert_eq!(said.len(), ends);
        for line in said {
            if let Line::Frame(frame) = line {
                prop_assert_eq!(lines(&encode(&frame).unwrap()), [Line::Frame(frame)]);
            }
        }
    }

    #[test]
    fn a_line_with_one_byte_lost_or_doubled_is_never_another_frame_of_the_same_length(frame in frames(), at: usize) {
        // There is no checksum, but the length is said twice: by its digit and by the line's end. A doubled digit in
        // the identifier or the data cannot pass; one that makes the length digit slip must not match by chance of
        // fewer than two digits.
        let whole = encode(&frame).unwrap();
        let at = at % (whole.len() - 1);
        let mut lost = whole.to_vec();
        lost.remove(at);
        for line in lines(&lost) {
            if let Line::Frame(other) = line {
                prop_assert_ne!(other.data().len(), frame.data().len());
            }
        }
    }

    #[test]
    fn an_overlong_line_costs_itself_only(excess in 0_usize..200, frame in frames()) {
        let mut bytes = std::vec![b'T'; CONTENT_BYTES_MAX + 1 + excess];
        bytes.push(END);
        bytes.extend(encode(&frame).unwrap());
        prop_assert_eq!(lines(&bytes), [Line::Damaged, Line::Frame(frame)]);
    }
}
