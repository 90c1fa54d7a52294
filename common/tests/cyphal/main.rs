//! Cyphal/CAN transport: the specification's examples, what damage to frames may and may not do, and agreement with
//! another implementation.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

mod damage;
mod interop;
mod specification;

use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, NodeId, Priority, RxError, Sender, Session, SubjectId, received_bytes};

/// Longest payload of the tests, as long as the longest message of the project.
const PAYLOAD_BYTES_MAX: usize = 4_400;
/// A buffer for it.
const BUFFER: usize = received_bytes(PAYLOAD_BYTES_MAX, Mtu::Fd);
const TIMEOUT: u64 = 1_000;

fn subject(value: u16) -> SubjectId {
    SubjectId::new(value).unwrap()
}

fn node(value: u8) -> NodeId {
    NodeId::new(value).unwrap()
}

/// A session for subject 1234 from node 42.
fn session() -> Box<Session<BUFFER>> {
    Box::new(Session::new(subject(1234), node(42), TIMEOUT))
}

/// A sender that belongs to it.
fn sender() -> Sender<1> {
    Sender::new(node(42), [subject(1234)])
}

/// The frames of the sender's next transfer.
fn frames(sender: &mut Sender<1>, payload: &[u8], mtu: Mtu) -> Vec<CanFrame> {
    sender.send(subject(1234), Priority::Nominal, payload, mtu).unwrap().collect()
}

/// Gives frames to a session, all at time `now`; what it delivers, and its errors.
fn feed<const N: usize>(session: &mut Session<N>, frames: &[CanFrame], now: u64) -> (Vec<Vec<u8>>, Vec<RxError>) {
    let (mut transfers, mut errors) = (Vec::new(), Vec::new());
    for frame in frames {
        match Header::parse(frame.id()).map(|header| session.accept(&header, frame.data(), now)) {
            Ok(Ok(Some(transfer))) => transfers.push(transfer.payload.to_vec()),
            Ok(Err(error)) => errors.push(error),
            Ok(Ok(None)) | Err(_) => {}
        }
    }
    (transfers, errors)
}

/// What a receiver gets for a payload: the payload and its padding.
fn padded(payload: &[u8], mtu: Mtu) -> Vec<u8> {
    let mut bytes = payload.to_vec();
    bytes.resize(received_bytes(payload.len(), mtu), 0);
    bytes
}
