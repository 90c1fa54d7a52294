//! Our frames and the socketcan crate's.

use socketcan::id::FdFlags;
use socketcan::{CanAnyFrame, CanDataFrame, CanFdFrame, EmbeddedFrame, ExtendedId, Id, StandardId};
use tactus_common::can::{CanFrame, IdBits, Mtu};

/// `None` for no frame that exists.
pub fn to_socketcan(frame: &CanFrame) -> Option<CanAnyFrame> {
    let id: Id = match frame.id_bits() {
        IdBits::Extended => ExtendedId::new(frame.id())?.into(),
        IdBits::Base => StandardId::new(u16::try_from(frame.id()).ok()?)?.into(),
    };
    match frame.mtu() {
        Mtu::Classic => CanDataFrame::new(id, frame.data()).map(CanAnyFrame::from),
        Mtu::Fd => CanFdFrame::with_flags(id, frame.data(), FdFlags::BRS).map(CanAnyFrame::from),
    }
}

/// `None` for what is no data frame (remote frames, error frames).
pub fn from_socketcan(frame: &CanAnyFrame) -> Option<CanFrame> {
    let (id, data, mtu) = match frame {
        CanAnyFrame::Normal(frame) => (frame.id(), frame.data(), Mtu::Classic),
        CanAnyFrame::Fd(frame) => (frame.id(), frame.data(), Mtu::Fd),
        CanAnyFrame::Remote(_) | CanAnyFrame::Error(_) => return None,
    };
    match id {
        Id::Extended(id) => CanFrame::new(id.as_raw(), data, mtu).ok(),
        Id::Standard(id) => CanFrame::new_base(id.as_raw(), data, mtu).ok(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_frame() -> impl Strategy<Value = CanFrame> {
        let data = proptest::collection::vec(any::<u8>(), 64);
        (any::<u32>(), any::<bool>(), any::<bool>(), 0..=64_usize, data).prop_map(|(id, base, fd, bytes, data)| {
            let mtu = if fd { Mtu::Fd } else { Mtu::Classic };
            let bytes = mtu.frame_bytes(bytes.min(mtu.bytes())).unwrap();
            let data = &data[..bytes];
            if base {
                CanFrame::new_base(id as u16 & 0x7ff, data, mtu).unwrap()
            } else {
                CanFrame::new(id & 0x1fff_ffff, data, mtu).unwrap()
            }
        })
    }

    proptest! {
        #[test]
        fn every_frame_survives_the_way_there_and_back(frame in any_frame()) {
            let there = to_socketcan(&frame).unwrap();
            prop_assert_eq!(from_socketcan(&there), Some(frame));
        }
    }

    #[test]
    fn long_frames_ask_for_the_fast_data_phase() {
        let frame = CanFrame::new(1, &[0; 64], Mtu::Fd).unwrap();
        assert!(matches!(to_socketcan(&frame), Some(CanAnyFrame::Fd(fd)) if fd.is_brs()));
    }
}
