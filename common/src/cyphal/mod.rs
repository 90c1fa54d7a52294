//! Cyphal/CAN 1.0 transport of messages, in fixed memory.
//!
//! Transfers of any length are cut into CAN frames ([`Sender`], [`Frames`]) and put together again ([`Session`],
//! one per subject and source that a node listens to). The standard is the Cyphal Specification v1.0, section 4.2
//! "Cyphal/CAN" (<https://opencyphal.org/specification>); every frame here can be read by its tools.
//!
//! ```text
//! identifier  28..26 priority   25 service = 0   24 anonymous   23 0   22..21 11   20..8 subject   7 0   6..0 source
//! tail byte   7 start of transfer   6 end of transfer   5 toggle   4..0 transfer-ID (counts each transfer, mod 32)
//! ```
//!
//! A payload that fits one frame is sent as payload, zero padding up to a length that CAN FD has, tail byte. A longer
//! one fills frame after frame; padding and a CRC-16 over payload and padding precede the last tail byte.
//!
//! Not here: services and anonymous nodes, which our protocol does without. Their frames are told apart and counted.
//!
//! ```
//! use tactus_common::can::Mtu;
//! use tactus_common::cyphal::{Header, NodeId, Priority, Sender, Session, SubjectId};
//!
//! const WORLD: NodeId = NodeId::new(10).expect("below 128");
//! const READINGS: SubjectId = SubjectId::new(1000).expect("below 8192");
//! let mut sender = Sender::new(WORLD, [READINGS]);
//! let mut session = Session::<128>::new(READINGS, WORLD, 40_000);
//!
//! let mut received = false;
//! for frame in sender.send(READINGS, Priority::Fast, &[7; 100], Mtu::Fd).unwrap() {
//!     let header = Header::parse(frame.id()).unwrap();
//!     if let Some(transfer) = session.accept(&header, frame.data(), 0).unwrap() {
//!         // 108 bytes: CAN FD has no frame for the last 39 and CRC, so 8 zeros follow.
//!         received = transfer.payload.starts_with(&[7; 100]);
//!     }
//! }
//! assert!(received);
//! ```

mod frames;
mod header;
mod sender;
mod session;
mod stats;
mod tail;

pub use frames::{Frames, frame_lengths, received_bytes};
pub use header::{Header, HeaderError, NodeId, Priority, SubjectId};
pub use sender::{SendError, Sender};
pub use session::{Session, Transfer};
pub use stats::{RxError, RxStats};
pub use tail::{TRANSFER_ID_MODULO, TailByte};

/// Transfer CRC: CRC-16/CCITT-FALSE (specification, appendix "CRC-16/CCITT-FALSE"), which the catalogue of CRCs lists
/// as CRC-16/IBM-3740.
static TRANSFER_CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740);

/// Value of the transfer CRC before the first byte.
const CRC_INITIAL: u16 = 0xffff;

/// Bytes that the transfer CRC takes at the end of a multi-frame transfer.
const CRC_BYTES: usize = 2;

/// The transfer CRC over more bytes, from its value `so_far`.
fn crc_extend(so_far: u16, bytes: &[u8]) -> u16 {
    let mut digest = TRANSFER_CRC.digest_with_initial(so_far);
    digest.update(bytes);
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transfer_crc_matches_the_published_check_value() {
        // Specification, appendix "CRC-16/CCITT-FALSE": "123456789" gives 0x29B1, and the CRC over data and CRC is 0.
        assert_eq!(crc_extend(CRC_INITIAL, b"123456789"), 0x29b1);
        assert_eq!(crc_extend(crc_extend(CRC_INITIAL, b"1234"), b"56789"), 0x29b1);
        assert_eq!(crc_extend(CRC_INITIAL, b"123456789\x29\xb1"), 0);
    }
}
