//! Decoding of the one large message straight into the place where it stays.
//!
//! A decoder that returns a value passes its kilobytes over the stack at every layer; here only one knot at a time does.

use super::{PlanAnswer, RefusalReason};
use crate::limits::KNOTS_MAX;
use crate::trajectory::{Knot, Trajectory};
use heapless::Vec;
use postcard::{Error, take_from_bytes};

/// Bytes of one knot: postcard writes an `f32` as it is.
const KNOT_BYTES: usize = size_of::<Knot>();

impl PlanAnswer {
    /// Tick from which an encoded answer is to be used: its first field.
    ///
    /// # Errors
    /// The bytes are no answer.
    pub fn effective_of(bytes: &[u8]) -> Result<u32, Error> {
        take_from_bytes(bytes).map(|(effective, _)| effective)
    }

    /// Decodes as [`crate::link::decode`] does, into `slot`.
    ///
    /// # Errors
    /// The bytes are no answer; `slot` is as before.
    pub fn decode_into(bytes: &[u8], slot: &mut Option<Self>) -> Result<(), Error> {
        let ((effective, request, variant), rest): ((u32, u16, u32), _) = take_from_bytes(bytes)?;
        match variant {
            0 => {
                let ((trajectory_request, count), rest): ((u16, u32), _) = take_from_bytes(rest)?;
                // Everything that can be wrong is seen before the slot is touched.
                let count = usize::try_from(count).ok().filter(|n| *n <= KNOTS_MAX).ok_or(Error::SerdeDeCustom)?;
                let (knots, rest) = rest.split_at_checked(count * KNOT_BYTES).ok_or(Error::DeserializeUnexpectedEnd)?;
                let guarded_from = *rest.first().ok_or(Error::DeserializeUnexpectedEnd)?;
                let trajectory = Trajectory { request: trajectory_request, knots: Vec::new(), guarded_from };
                let answer = slot.insert(Self { effective, request, result: Ok(trajectory) });
                if let Ok(trajectory) = &mut answer.result {
                    for bytes in knots.chunks_exact(KNOT_BYTES) {
                        let _ = trajectory.knots.push(take_from_bytes(bytes)?.0);
                    }
                }
            }
            1 => {
                let (reason, _): (RefusalReason, _) = take_from_bytes(rest)?;
                *slot = Some(Self { effective, request, result: Err(reason) });
            }
            _ => return Err(Error::SerdeDeCustom),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::{ARM_JOINTS, PAYLOAD_BYTES_MAX};
    use crate::link;
    use proptest::prelude::*;

    fn answer(effective: u32, request: u16, knots: usize, refused: bool) -> PlanAnswer {
        let knot = |i: usize| Knot { t_s: i as f32, q_rad: [0.1 * i as f32; ARM_JOINTS], ..Knot::default() };
        let knots = (0..knots).map(knot).collect();
        let result =
            if refused { Err(RefusalReason::NoPath) } else { Ok(Trajectory { request, knots, guarded_from: 2 }) };
        PlanAnswer { effective, request, result }
    }

    proptest! {
        #[test]
        fn what_comes_out_is_what_the_decoder_by_value_gives_whatever_the_bytes(
            effective: u32, request: u16, knots in 0..=KNOTS_MAX, refused: bool, cut in 0_usize..120,
            spoilt in proptest::option::of((0_usize..14, any::<u8>())),
        ) {
            let mut buffer = [0; PAYLOAD_BYTES_MAX];
            let answer = answer(effective, request, knots, refused);
            let used = link::encode(&answer, &mut buffer).unwrap().len();
            if let Some((at, byte)) = spoilt {
                buffer[at] = byte;
            }
            let bytes = &buffer[..used.saturating_sub(cut)];
            let before = Some(super::tests::answer(7, 7, 3, false));
            let mut slot = before.clone();
            let result = PlanAnswer::decode_into(bytes, &mut slot);
            match link::decode::<PlanAnswer>(bytes) {
                Ok(by_value) => {
                    prop_assert_eq!(result, Ok(()));
                    // A NaN is not equal to itself: compare as encoded.
                    let mut again = [0; PAYLOAD_BYTES_MAX];
                    let mut expected = [0; PAYLOAD_BYTES_MAX];
                    prop_assert_eq!(
                        link::encode(&slot.unwrap(), &mut again).unwrap(),
                        link::encode(&by_value, &mut expected).unwrap()
                    );
                    prop_assert_eq!(PlanAnswer::effective_of(bytes), Ok(by_value.effective));
                }
                Err(_) => {
                    prop_assert!(result.is_err());
                    prop_assert_eq!(slot, before);
                }
            }
        }
    }
}
