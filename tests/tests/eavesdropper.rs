//! Promise: the digest can be computed from the wire alone, as the protocol page defines it.

use std::cell::RefCell;
use std::rc::Rc;
use tactus_common::can::CanFrame;
use tactus_tests::eavesdropper::Eavesdropper;
use tactus_tests::recording::{options, run_tampered};

#[test]
fn who_listens_to_a_mission_finds_its_digest_and_who_missed_a_bit_does_not() {
    let wire: Rc<RefCell<Vec<CanFrame>>> = Rc::default();
    let heard = Rc::clone(&wire);
    let report = run_tampered(&options(1), move |passing, arrived| {
        heard.borrow_mut().push(passing.frame);
        arrived.push(passing.frame);
    });
    let reported = report.digest.map(|report| (u64::from_le_bytes(report.digest), report.ticks));
    let mut wire = wire.take();
    let overheard = Eavesdropper::listen(&wire);
    assert_eq!((overheard.bad, overheard.foreign), (0, 0));
    assert_eq!(overheard.reported, reported);
    assert_eq!(Some((overheard.digest, overheard.ticks)), reported);

    let middle = &mut wire[10_000];
    let mut data = middle.data().to_vec();
    data[7] ^= 1;
    *middle = CanFrame::new(middle.id(), &data, middle.mtu()).unwrap();
    let other = Eavesdropper::listen(&wire);
    assert_ne!((other.digest, other.bad), (overheard.digest, 0));
}
