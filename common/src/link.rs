//! Messages to bytes and back, and where they travel: the same steps on both ends of the wire.

use crate::cyphal::{NodeId, Priority, SubjectId};
use crate::message::{Digest, Message, node};
use postcard::ser_flavors::Flavor;
use serde::de::DeserializeOwned;

/// Longest encoded message but [`crate::message::Setup`] and [`crate::message::PlanAnswer`], bytes: what the controller
/// sends it encodes on its stack.
pub const SMALL_BYTES: usize = 256;
/// Longest encoded [`crate::message::Setup`], bytes: five hulls, and what else it holds.
pub const SETUP_BYTES: usize = 2_304;

/// The subject of a message.
pub const fn subject<M: Message>() -> SubjectId {
    const {
        match SubjectId::new(M::SUBJECT) {
            Some(subject) => subject,
            None => panic!("a subject has 13 bits"),
        }
    }
}

/// The priority of a message.
pub const fn priority<M: Message>() -> Priority {
    const { Priority::ALL[M::PRIORITY as usize] }
}

const fn node_id(value: u8) -> NodeId {
    match NodeId::new(value) {
        Some(id) => id,
        None => panic!("a node id has 7 bits"),
    }
}

/// The world, or the robot's gateway, as a source of frames.
pub const WORLD: NodeId = node_id(node::WORLD);
/// The controller as a source of frames.
pub const CONTROLLER: NodeId = node_id(node::CONTROLLER);

/// Encodes a message (postcard).
///
/// # Errors
/// The buffer is too small.
pub fn encode<'b, M: Message>(message: &M, buffer: &'b mut [u8]) -> Result<&'b [u8], postcard::Error> {
    postcard::to_slice(message, buffer).map(|used| &*used)
}

/// Adds an encoded message to a digest, byte for byte: no buffer, however long it is.
///
/// # Errors
/// The message cannot be encoded; the bytes before the failure are in the digest then.
pub fn digest<M: Message>(message: &M, digest: &mut Digest) -> Result<(), postcard::Error> {
    postcard::serialize_with_flavor(message, IntoDigest(digest))
}

/// Where encoded bytes go: into a digest.
struct IntoDigest<'d>(&'d mut Digest);

impl Flavor for IntoDigest<'_> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.0.add(byte);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

/// Decodes a message. Zero bytes that CAN FD padded at the end are ignored.
///
/// # Errors
/// The bytes are not such a message.
pub fn decode<M: DeserializeOwned>(bytes: &[u8]) -> Result<M, postcard::Error> {
    postcard::take_from_bytes(bytes).map(|(message, _padding)| message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::PAYLOAD_BYTES_MAX;
    use crate::message::{Event, EventKind, Outcome, Phase, PlanAnswer, RefusalReason, Status};
    use crate::pose::PlanarPose;
    use crate::trajectory::{Knot, Trajectory};
    use proptest::prelude::*;

    fn status(tick: u32, x_m: f32) -> Status {
        let belief = PlanarPose::new(x_m, -x_m, 0.5);
        Status { tick, phase: Phase::Grasp, belief, covariance: [x_m; 6], evidence: 7, touches: 3 }
    }

    proptest! {
        #[test]
        fn a_message_comes_back_whole_also_with_the_zeros_that_can_fd_pads(tick: u32, x_m in -1.0_f32..1.0, padding in 0_usize..16) {
            let mut buffer = [0; SMALL_BYTES + 16];
            let used = encode(&status(tick, x_m), &mut buffer).unwrap().len();
            prop_assert_eq!(decode::<Status>(&buffer[..used + padding]).unwrap(), status(tick, x_m));
        }

        #[test]
        fn a_message_cut_short_anywhere_is_refused(tick: u32, cut in 1_usize..40) {
            let mut buffer = [0; SMALL_BYTES];
            let used = encode(&status(tick, 0.3), &mut buffer).unwrap().len();
            prop_assert!(decode::<Status>(&buffer[..used - cut]).is_err());
        }

        #[test]
        fn a_trajectory_comes_back_whole_whatever_its_length(knots in 0_usize..=crate::limits::KNOTS_MAX, effective: u32) {
            let knot = Knot { t_s: 0.1, q_rad: [1.5; 7], ..Knot::default() };
            let knots = core::iter::repeat_n(knot, knots).collect();
            let result = Ok(Trajectory { request: 300, knots, guarded_from: 2 });
            let answer = PlanAnswer { effective, request: 300, result };
            let mut buffer = [0; PAYLOAD_BYTES_MAX];
            let used = encode(&answer, &mut buffer).unwrap().len();
            prop_assert_eq!(decode::<PlanAnswer>(&buffer[..used]).unwrap(), answer);
        }
    }

    #[test]
    fn the_digest_of_a_message_is_that_of_its_bytes() {
        let (mut streamed, mut of_bytes) = (Digest::default(), Digest::default());
        for tick in [0, 1, 300, u32::MAX] {
            let mut buffer = [0; SMALL_BYTES];
            of_bytes.update(encode(&status(tick, 0.3), &mut buffer).unwrap());
            digest(&status(tick, 0.3), &mut streamed).unwrap();
            assert_eq!(streamed, of_bytes);
        }
    }

    #[test]
    fn a_buffer_that_is_too_small_is_an_error_and_no_half_message() {
        let mut buffer = [0; 20];
        assert!(encode(&status(1, 0.1), &mut buffer).is_err());
    }

    #[test]
    fn an_unknown_variant_is_refused() {
        let mut buffer = [0; SMALL_BYTES];
        let event = Event { tick: 0, kind: EventKind::Finished(Outcome::Transported) };
        let used = encode(&event, &mut buffer).unwrap().len();
        assert_eq!(decode::<Event>(&buffer[..used]).unwrap(), event);
        buffer[1] = 99;
        assert!(decode::<Event>(&buffer[..used]).is_err());
        let mut refusal = [0, 1, 1, RefusalReason::NonFinite as u8 + 1];
        assert!(decode::<PlanAnswer>(&refusal).is_err());
        refusal[3] -= 1;
        assert!(decode::<PlanAnswer>(&refusal).is_ok());
    }
}
