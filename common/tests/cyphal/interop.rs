//! Agreement with canadensis (`canadensis_can`), an independent implementation of Cyphal/CAN, in both directions.

use super::{BUFFER, TIMEOUT, frames, padded, sender, session, subject};
use canadensis_can::driver::{ReceiveDriver, TransmitDriver};
use canadensis_can::{CanNodeId, CanReceiver, CanTransmitter, CanTransport, Mtu as TheirMtu};
use canadensis_core::subscription::Subscription;
use canadensis_core::time::{Clock, MicrosecondDuration32, Microseconds32};
use canadensis_core::transfer::{Header, MessageHeader, Transfer};
use canadensis_core::transport::{Receiver, Transmitter};
use canadensis_core::{OutOfMemoryError, Priority, SubjectId, nb};
use core::convert::Infallible;
use std::collections::VecDeque;
use tactus_common::can::{CanFrame, Mtu};

struct Zero;

impl Clock for Zero {
    fn now(&mut self) -> Microseconds32 {
        Microseconds32::from_ticks(0)
    }
}

/// A wire: frames go in at one end and come out at the other.
#[derive(Default)]
struct Wire(VecDeque<canadensis_can::Frame>);

impl TransmitDriver<Zero> for Wire {
    type Error = Infallible;

    fn try_reserve(&mut self, _: usize) -> Result<(), OutOfMemoryError> {
        Ok(())
    }

    fn transmit(
        &mut self,
        frame: canadensis_can::Frame,
        _: &mut Zero,
    ) -> nb::Result<Option<canadensis_can::Frame>, Infallible> {
        self.0.push_back(frame);
        Ok(None)
    }

    fn flush(&mut self, _: &mut Zero) -> nb::Result<(), Infallible> {
        Ok(())
    }
}

impl ReceiveDriver<Zero> for Wire {
    type Error = Infallible;

    fn receive(&mut self, _: &mut Zero) -> nb::Result<canadensis_can::Frame, Infallible> {
        self.0.pop_front().ok_or(nb::Error::WouldBlock)
    }

    fn apply_filters<S: IntoIterator<Item = Subscription>>(&mut self, _: Option<CanNodeId>, _: S) {}

    fn apply_accept_all(&mut self) {}
}

fn their_mtu(mtu: Mtu) -> TheirMtu {
    match mtu {
        Mtu::Classic => TheirMtu::Can8,
        Mtu::Fd => TheirMtu::CanFd64,
    }
}

fn ours(frame: &canadensis_can::Frame, mtu: Mtu) -> CanFrame {
    CanFrame::new(frame.id().into(), frame.data(), mtu).unwrap()
}

fn theirs(frame: &CanFrame) -> canadensis_can::Frame {
    canadensis_can::Frame::new(Microseconds32::from_ticks(0), frame.id().try_into().unwrap(), frame.data())
}

fn payload_lengths() -> impl Iterator<Item = usize> {
    (0..=300).chain([900, 1_023, 2_500, 4_399, 4_400])
}

#[test]
fn they_cut_transfers_into_the_same_frames() {
    for mtu in Mtu::ALL {
        let mut our_sender = sender();
        let mut transmitter = CanTransmitter::<Zero, Wire>::new(their_mtu(mtu));
        for (n, len) in payload_lengths().enumerate() {
            let payload: Vec<u8> = (0..len).map(|at| (at * 31 + n) as u8).collect();
            let header: Header<CanTransport> = Header::Message(MessageHeader {
                timestamp: Microseconds32::from_ticks(0),
                transfer_id: ((n % 32) as u8).try_into().unwrap(),
                priority: Priority::Nominal,
                subject: SubjectId::try_from(1234).unwrap(),
                source: Some(42_u8.try_into().unwrap()),
            });
            let mut wire = Wire::default();
            let transfer = Transfer { header, loopback: false, payload: &payload[..] };
            transmitter.push(transfer, &mut Zero, &mut wire).unwrap();
            let sent_by_them: Vec<CanFrame> = wire.0.iter().map(|frame| ours(frame, mtu)).collect();
            let sent_by_us = frames(&mut our_sender, &payload, mtu);
            assert_eq!(sent_by_us, sent_by_them, "{len} bytes, {mtu:?}");
            let (transfers, errors) = super::feed(&mut session(), &sent_by_them, 0);
            assert_eq!((transfers, errors), (vec![padded(&payload, mtu)], vec![]));
        }
    }
}

#[test]
fn they_understand_what_we_send() {
    for mtu in Mtu::ALL {
        let mut our_sender = sender();
        let mut wire = Wire::default();
        let mut receiver = CanReceiver::<Zero, Wire>::new(1_u8.try_into().unwrap());
        let id = SubjectId::try_from(subject(1234).get()).unwrap();
        let timeout = MicrosecondDuration32::from_ticks(TIMEOUT as u32);
        receiver.subscribe_message(id, BUFFER, timeout, &mut wire).unwrap();
        for len in payload_lengths() {
            let payload: Vec<u8> = (0..len).map(|at| (at * 17 + len) as u8).collect();
            wire.0.extend(frames(&mut our_sender, &payload, mtu).iter().map(theirs));
            let transfer = receiver.receive(&mut Zero, &mut wire).unwrap().expect("a whole transfer");
            assert_eq!(transfer.payload, padded(&payload, mtu), "{len} bytes, {mtu:?}");
            let Header::Message(header) = transfer.header else { panic!("not a message") };
            assert_eq!((u16::from(header.subject), header.source.map(u8::from)), (1234, Some(42)));
        }
    }
}
