//! The examples of the Cyphal Specification v1.0, section 4.2.3 "Examples", byte by byte.

use super::{TIMEOUT, feed, node, subject};
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, HeaderError, Priority, Sender, Session};

fn bytes(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}

fn example(id: u32, mtu: Mtu, data: &[&str]) -> Vec<CanFrame> {
    data.iter().map(|data| CanFrame::new(id, &bytes(data), mtu).unwrap()).collect()
}

#[test]
fn heartbeats_of_node_42() {
    let expected = example(
        0x107d_552a,
        Mtu::Classic,
        &["00 00 00 00 00 01 A1 E0", "01 00 00 00 00 01 A1 E1", "02 00 00 00 00 01 A1 E2", "03 00 00 00 00 01 A1 E3"],
    );
    let mut sender = Sender::new(node(42), [subject(7509)]);
    let sent: Vec<CanFrame> = (0..4)
        .flat_map(|uptime| {
            let payload = [uptime, 0, 0, 0, 0, 1, 0xa1];
            sender.send(subject(7509), Priority::Nominal, &payload, Mtu::Classic).unwrap().collect::<Vec<_>>()
        })
        .collect();
    assert_eq!(sent, expected);

    let mut session = Session::<7>::new(subject(7509), node(42), TIMEOUT);
    let (transfers, errors) = feed(&mut session, &expected, 0);
    assert_eq!(transfers, [0, 1, 2, 3].map(|uptime| vec![uptime, 0, 0, 0, 0, 1, 0xa1]));
    assert_eq!(errors, []);
}

#[test]
fn string_with_one_byte_of_padding() {
    // Anonymous in the specification, which we neither send nor take: the data field is compared alone.
    let expected = bytes("0C 00 48 65 6C 6C 6F 20 77 6F 72 6C 64 21 00 E0");
    let mut sender = Sender::new(node(0x75), [subject(4919)]);
    let payload = b"\x0c\x00Hello world!";
    let sent: Vec<CanFrame> = sender.send(subject(4919), Priority::Nominal, payload, Mtu::Fd).unwrap().collect();
    assert_eq!(sent.len(), 1);
    assert_eq!(sent[0].data(), expected);
    assert_eq!(sent[0].id(), 0x1013_3775 | 0b11 << 21);

    let mut session = Session::<15>::new(subject(4919), node(0x75), TIMEOUT);
    assert_eq!(feed(&mut session, &sent, 0).0, [b"\x0c\x00Hello world!\x00"]);
    let anonymous = CanFrame::new(0x1113_3775, &expected, Mtu::Fd).unwrap();
    assert_eq!(Header::parse(anonymous.id()), Err(HeaderError::Anonymous));
}

#[test]
fn node_info_response_whose_crc_is_split_over_two_frames() {
    // A service response in the specification (identifier 126BBDAA): its data fields under a message's identifier.
    let data = [
        "01 00 00 00 01 00 00 A1",
        "00 00 00 00 00 00 00 01",
        "00 00 00 00 00 00 00 21",
        "00 00 00 00 00 00 00 01",
        "00 00 24 6F 72 67 2E 21",
        "75 61 76 63 61 6E 2E 01",
        "70 79 75 61 76 63 61 21",
        "6E 2E 64 65 6D 6F 2E 01",
        "62 61 73 69 63 5F 75 21",
        "73 61 67 65 00 00 9A 01",
        "E7 61",
    ];
    assert_eq!(Header::parse(0x126b_bdaa), Err(HeaderError::Service));
    let header = Header { priority: Priority::Nominal, subject: subject(430), source: node(42) };
    let expected = example(header.id(), Mtu::Classic, &data);
    // All content bytes but the last two (9A E7), which are the CRC.
    let content: Vec<u8> = data.iter().flat_map(|frame| bytes(frame).split_last().unwrap().1.to_vec()).collect();
    let payload = &content[..content.len() - 2];

    let mut sender = Sender::new(node(42), [subject(430)]);
    let mut transfer =
        || -> Vec<CanFrame> { sender.send(subject(430), Priority::Nominal, payload, Mtu::Classic).unwrap().collect() };
    assert_ne!(transfer(), expected, "the first transfer has transfer-ID 0");
    assert_eq!(transfer(), expected, "the example has transfer-ID 1");

    let mut session = Session::<80>::new(subject(430), node(42), TIMEOUT);
    assert_eq!(feed(&mut session, &expected, 0), (vec![payload.to_vec()], vec![]));
}

#[test]
fn array_of_92_numbers_in_two_fd_frames() {
    let first = "5C 00 00 01 02 03 04 05 06 07 08 09 0A 0B 0C 0D 0E 0F 10 11 12 13 14 15 16 17 18 19 1A 1B 1C 1D 1E 1F 20 \
                 21 22 23 24 25 26 27 28 29 2A 2B 2C 2D 2E 2F 30 31 32 33 34 35 36 37 38 39 3A 3B 3C A0";
    let last = "3D 3E 3F 40 41 42 43 44 45 46 47 48 49 4A 4B 4C 4D 4E 4F 50 51 52 53 54 55 56 57 58 59 5A 5B \
                00 00 00 00 00 00 00 00 00 00 00 00 00 00 BC 19 40";
    let header = Header { priority: Priority::Nominal, subject: subject(4919), source: node(59) };
    // The specification prints 1013373B, with the reserved bits 22 and 21 as zeros; they shall be sent as ones.
    assert_eq!(header.id() & !(0b11 << 21), 0x1013_373b);
    let expected = example(header.id(), Mtu::Fd, &[first, last]);
    let payload: Vec<u8> = [92, 0].into_iter().chain(0..92).collect();

    let mut sender = Sender::new(node(59), [subject(4919)]);
    let sent: Vec<CanFrame> = sender.send(subject(4919), Priority::Nominal, &payload, Mtu::Fd).unwrap().collect();
    assert_eq!(sent, expected);

    let mut session = Session::<108>::new(subject(4919), node(59), TIMEOUT);
    let as_printed = example(0x1013_373b, Mtu::Fd, &[first, last]);
    let (transfers, errors) = feed(&mut session, &as_printed, 0);
    assert_eq!(transfers, [payload.iter().copied().chain([0; 14]).collect::<Vec<u8>>()]);
    assert_eq!(errors, []);
}
