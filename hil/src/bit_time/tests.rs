use super::*;
use proptest::prelude::*;
use tactus_common::can::{BASE_ID_MAX, ID_MAX};

fn frame(id: u32, data: &[u8], mtu: Mtu) -> CanFrame {
    CanFrame::new(id, data, mtu).unwrap()
}

/// The frame as a string of bits, built field by field from the standard: slow and plain.
mod plain {
    use super::*;

    fn push(bits: &mut Vec<bool>, value: u32, count: u32) {
        bits.extend((0..count).rev().map(|n| value >> n & 1 == 1));
    }

    /// Start of frame to data.
    fn head(frame: &CanFrame) -> Vec<bool> {
        let mut bits = vec![false];
        if frame.id_bits() == IdBits::Extended {
            push(&mut bits, frame.id() >> 18, 11);
            push(&mut bits, 0b11, 2); // SRR, IDE
            push(&mut bits, frame.id() & 0x3_ffff, 18);
            match frame.mtu() {
                Mtu::Classic => push(&mut bits, 0b000, 3),  // RTR, r1, r0
                Mtu::Fd => push(&mut bits, 0b0_1_0_1_0, 5), // RRS, FDF, res, BRS, ESI
            }
        } else {
            push(&mut bits, frame.id(), 11);
            match frame.mtu() {
                Mtu::Classic => push(&mut bits, 0b000, 3),    // RTR, IDE, r0
                Mtu::Fd => push(&mut bits, 0b0_0_1_0_1_0, 6), // RRS, IDE, FDF, res, BRS, ESI
            }
        }
        push(&mut bits, u32::from(frame.dlc()), 4);
        frame.data().iter().for_each(|byte| push(&mut bits, u32::from(*byte), 8));
        bits
    }

    /// The shift register of Bosch's CAN specification 2.0, section 3.1.1 "CRC sequence".
    pub fn crc_15(bits: &[bool]) -> u32 {
        bits.iter().fold(0, |register, bit| {
            let next = *bit != (register >> 14 & 1 == 1);
            let shifted = register << 1 & 0x7fff;
            if next { shifted ^ 0x4599 } else { shifted }
        })
    }

    /// Inserts stuff bits; a stuff bit counts in the run that follows it.
    fn stuff(bits: &[bool]) -> Vec<bool> {
        let mut stuffed: Vec<bool> = Vec::new();
        let mut run = 0;
        for bit in bits {
            run = if stuffed.last() == Some(bit) { run + 1 } else { 1 };
            stuffed.push(*bit);
            if run == 5 {
                stuffed.push(!bit);
                run = 1;
            }
        }
        stuffed
    }

    pub fn length(frame: &CanFrame) -> usize {
        let mut bits = head(frame);
        let trailer = 1 + 2 + 7 + 3; // CRC delimiter, ACK, end of frame, intermission
        match frame.mtu() {
            Mtu::Classic => {
                let crc = crc_15(&bits);
                push(&mut bits, crc, 15);
                stuff(&bits).len() + trailer
            }
            Mtu::Fd => {
                let mut stuffed = stuff(&bits);
                if let Some([rest @ .., _]) = stuffed.last_chunk::<6>()
                    && rest.iter().all(|bit| *bit == rest[0])
                    && stuffed.last() != Some(&rest[0])
                {
                    // Ends in five equal bits and a stuff bit, in whose place comes a fixed one.
                    stuffed.pop();
                }
                let crc_field = if frame.data().len() <= 16 { 4 + 17 + 6 } else { 4 + 21 + 7 };
                stuffed.len() + crc_field + trailer
            }
        }
    }
}

#[test]
fn crc_15_matches_the_published_check_value() {
    // Catalogue of parametrised CRC algorithms, CRC-15/CAN: "123456789" gives 0x059E.
    assert_eq!(CRC_15.checksum(b"123456789"), 0x059e);
    let bits: Vec<bool> = b"123456789".iter().flat_map(|byte| (0..8).rev().map(move |n| byte >> n & 1 == 1)).collect();
    assert_eq!(plain::crc_15(&bits), 0x059e);
}

#[test]
fn worst_lengths_are_the_published_ones() {
    // Linux commit 80a2fbce456e "can: length: refactor frame lengths definition to add size in bits", its table.
    let worst = |bytes, mtu, id| wire_bits_worst(bytes, mtu, id).total();
    assert_eq!(worst(8, Mtu::Classic, IdBits::Base), 135);
    assert_eq!(worst(8, Mtu::Classic, IdBits::Extended), 160);
    assert_eq!(worst(64, Mtu::Fd, IdBits::Base), 712);
    assert_eq!(worst(64, Mtu::Fd, IdBits::Extended), 736);
    // Davis et al. 2007: 55 + 10 n for 11 bits, 80 + 10 n for 29 bits.
    for n in 0..=8 {
        assert_eq!(worst(n, Mtu::Classic, IdBits::Base), 55 + 10 * n as u32);
        assert_eq!(worst(n, Mtu::Classic, IdBits::Extended), 80 + 10 * n as u32);
    }
}

#[test]
fn unstuffed_lengths_are_the_published_ones() {
    // Alternating identifier and data bits: hardly a stuff bit. Same table: 131 and 598 without stuffing.
    let id = 0x1555_5555;
    let classic =
        (0..=255).map(|n| wire_bits(&frame(id, &[0x55, 0xaa, 0x55, 0xaa, 0x55, 0xaa, 0x55, n], Mtu::Classic)).total());
    assert_eq!(classic.min(), Some(131));
    let fd = wire_bits(&frame(id, &[0x55; 64], Mtu::Fd));
    assert_eq!((fd.nominal, fd.data, fd.total()), (48, 550, 598));
    // 1/5 Mbit/s: 48 us + 110 us.
    assert_eq!(fd.duration_ns(BitRates::M1_5), 158_000);
}

#[test]
fn all_zero_fd_frames_have_the_stuff_bits_counted_by_hand() {
    // Start of frame and 11 zeros: 2 stuff bits; 11; 18 zeros and RRS: 3; 1 0 1; ESI and a length code of 0: five zeros,
    // whose stuff bit the fixed one replaces.
    let empty = wire_bits(&frame(0, &[], Mtu::Fd));
    assert_eq!((empty.nominal, empty.data), (36 + 5 + 12, 5 + 27 + 1));
    // ESI 0, length code 1000, 64 zeros: 67 zeros after the one, 13 stuff bits.
    let eight = wire_bits(&frame(0, &[0; 8], Mtu::Fd));
    assert_eq!((eight.nominal, eight.data), (36 + 5 + 12, 5 + 64 + 13 + 27 + 1));
    // Length code 1111, 512 zeros: 102 stuff bits; CRC 21 from 20 data bytes on.
    let full = wire_bits(&frame(0, &[0; 64], Mtu::Fd));
    assert_eq!((full.nominal, full.data), (36 + 5 + 12, 5 + 512 + 102 + 32 + 1));
    assert_eq!(fd_crc_field_bits(16), 27);
    assert_eq!(fd_crc_field_bits(20), 32);
}

#[test]
fn the_all_zero_classic_frame_has_the_stuff_bits_counted_by_hand() {
    // Start of frame and 11 zeros: 2; 11; 18 zeros, RTR, r1, r0, length code 0000: 25 zeros, 5 stuff bits, the last of
    // them before the CRC. The CRC of these 39 bits, of which SRR and IDE alone are ones, is 100011000010000: no run of
    // five, not with the stuff bit (a one) before it either.
    let bits: Vec<bool> = (0..39).map(|n| n == 12 || n == 13).collect();
    assert_eq!(plain::crc_15(&bits), 0b100_0110_0001_0000);
    assert_eq!(wire_bits(&frame(0, &[], Mtu::Classic)).total(), 39 + 15 + 7 + 13);
}

#[test]
fn a_short_identifier_saves_twenty_bits() {
    // Alternating bits again, 8 data bytes: 111 without stuffing (Davis et al. 2007: g + 8 n + 13 with g = 34).
    let short = (0..=255).map(|n| {
        wire_bits(&CanFrame::new_base(0x555, &[0x55, 0xaa, 0x55, 0xaa, 0x55, 0xaa, 0x55, n], Mtu::Classic).unwrap())
    });
    assert_eq!(short.map(WireBits::total).min(), Some(111));
    // GET STAT of puck 11, 00B#05: 0 00000001011 000 0001 00000101 and the CRC of these 27 bits, 101101000001100. Stuff
    // bits: after the first five zeros, after RTR, IDE, r0 and two of the length code, after five of the data, and one
    // in the CRC.
    let get = CanFrame::new_base(0x00b, &[0x05], Mtu::Classic).unwrap();
    assert_eq!(wire_bits(&get).total(), 27 + 15 + 4 + 13);
}

proptest! {
    #[test]
    fn length_equals_that_of_the_plain_bit_string(
        id in prop_oneof![0..=ID_MAX, (0..29_u32).prop_map(|n| 1 << n), Just(0), Just(ID_MAX)],
        bytes in proptest::collection::vec(prop_oneof![any::<u8>(), Just(0), Just(0xff), Just(0xf8), Just(0x07), Just(0xc1)], 64),
        code in 0..16_usize,
    ) {
        let len = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64][code];
        let short_id = id as u16 & BASE_ID_MAX;
        for (mtu, id_bits) in Mtu::ALL.map(|mtu| [(mtu, IdBits::Base), (mtu, IdBits::Extended)]).into_iter().flatten() {
            let len = len.min(mtu.bytes());
            let frame = match id_bits {
                IdBits::Base => CanFrame::new_base(short_id, &bytes[..len], mtu).unwrap(),
                IdBits::Extended => frame(id, &bytes[..len], mtu),
            };
            let exact = wire_bits(&frame);
            prop_assert_eq!(exact.total() as usize, plain::length(&frame), "{:?}", frame);
            let worst = wire_bits_worst(len, mtu, id_bits);
            prop_assert!(exact.nominal <= worst.nominal && exact.total() <= worst.total());
            prop_assert!(exact.duration_ns(BitRates::M1_5) <= worst.duration_ns(BitRates::M1_5));
        }
    }
}

#[test]
fn data_that_changes_every_four_bits_comes_within_two_bits_of_the_worst_case() {
    // The length code 1111 and a one make five; then four zeros after the stuff bit 0 make five, and so on.
    let stuff = wire_bits(&frame(0, &[0b1000_0111; 64], Mtu::Fd)).data - (5 + 512 + 32 + 1);
    assert_eq!(stuff, 1 + 511 / 4);
    assert_eq!(wire_bits_worst(64, Mtu::Fd, IdBits::Extended).data - (5 + 512 + 32 + 1), stuff + 2);
}
