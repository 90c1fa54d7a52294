//! What happens to frames on the way: nothing wrong may come out, and nothing old as new.

use super::{BUFFER, PAYLOAD_BYTES_MAX, TIMEOUT, feed, frames, node, padded, sender, session, subject};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, Priority, RxError, Sender, Session};

/// The same cases in every run: a 16-bit CRC lets one damaged transfer in 65536 through, whoever looks for long finds it.
fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(2_026), failure_persistence: None, ..ProptestConfig::default() }
}

fn mtus() -> impl Strategy<Value = Mtu> {
    prop_oneof![Just(Mtu::Classic), Just(Mtu::Fd)]
}

fn payloads(lengths: core::ops::RangeInclusive<usize>) -> impl Strategy<Value = Vec<u8>> {
    let random = proptest::collection::vec(any::<u8>(), lengths.clone());
    // Uniform content is the hard case: all chunks look alike.
    let uniform = (prop_oneof![Just(0), Just(0xff), any::<u8>()], lengths).prop_map(|(byte, len)| vec![byte; len]);
    prop_oneof![random, uniform]
}

#[test]
fn payload_of_every_length_comes_out_as_it_went_in() {
    let payload: Vec<u8> = (0..PAYLOAD_BYTES_MAX).map(|n| (n * 7 % 251) as u8).collect();
    for mtu in Mtu::ALL {
        let (mut sender, mut session) = (sender(), session());
        // Every length up to a few frames of either format, then lengths that fall on all remainders.
        for len in (0..=400).chain((401..=PAYLOAD_BYTES_MAX).step_by(13)).chain([PAYLOAD_BYTES_MAX]) {
            let sent = frames(&mut sender, &payload[..len], mtu);
            let (transfers, errors) = feed(&mut session, &sent, 0);
            assert_eq!((transfers, errors), (vec![padded(&payload[..len], mtu)], vec![]), "{len} bytes, {mtu:?}");
        }
        let stats = session.stats();
        assert_eq!((stats.errors(), stats.given_up, stats.missed), (0, 0, 0));
    }
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn any_payload_comes_out_as_it_went_in(payload in payloads(0..=PAYLOAD_BYTES_MAX), mtu in mtus()) {
        let sent = frames(&mut sender(), &payload, mtu);
        prop_assert_eq!(feed(&mut session(), &sent, 0), (vec![padded(&payload, mtu)], vec![]));
    }

    #[test]
    fn a_dropped_frame_drops_its_transfer_and_no_other(
        payload in payloads(8..=900), next in payloads(0..=900), mtu in mtus(), which in any::<prop::sample::Index>(),
    ) {
        let (mut sender, mut session) = (sender(), session());
        let mut sent = frames(&mut sender, &payload, mtu);
        sent.remove(which.index(sent.len()));
        prop_assert_eq!(feed(&mut session, &sent, 0).0, Vec::<Vec<u8>>::new());
        let sent = frames(&mut sender, &next, mtu);
        prop_assert_eq!(feed(&mut session, &sent, 0), (vec![padded(&next, mtu)], vec![]));
    }

    #[test]
    fn a_repeated_frame_changes_nothing(
        payload in payloads(0..=900), mtu in mtus(), which in any::<prop::sample::Index>(),
    ) {
        let mut sent = frames(&mut sender(), &payload, mtu);
        let at = which.index(sent.len());
        sent.insert(at, sent[at]);
        let mut session = session();
        let (transfers, errors) = feed(&mut session, &sent, 0);
        prop_assert_eq!(transfers, vec![padded(&payload, mtu)]);
        prop_assert!(errors.iter().all(|error| *error == RxError::Duplicate), "{:?}", errors);
    }

    #[test]
    fn a_frame_that_comes_late_never_makes_a_wrong_payload(
        payload in payloads(0..=900), next in payloads(0..=900), mtu in mtus(),
        from in any::<prop::sample::Index>(), to in any::<prop::sample::Index>(),
    ) {
        let mut sender = sender();
        let mut sent = frames(&mut sender, &payload, mtu);
        sent.extend(frames(&mut sender, &next, mtu));
        let frame = sent.remove(from.index(sent.len()));
        sent.insert(to.index(sent.len() + 1), frame);
        let right = [padded(&payload, mtu), padded(&next, mtu)];
        let (transfers, _) = feed(&mut session(), &sent, 0);
        // In the order sent, each at most once.
        let mut expected = right.iter();
        for transfer in &transfers {
            prop_assert!(expected.any(|right| right == transfer), "{} transfers", transfers.len());
        }
    }

    #[test]
    fn a_flipped_bit_in_a_long_transfer_never_makes_a_wrong_payload(
        payload in payloads(64..=900), mtu in mtus(), which in any::<prop::sample::Index>(), bit in any::<prop::sample::Index>(),
    ) {
        let mut sent = frames(&mut sender(), &payload, mtu);
        let at = which.index(sent.len());
        let mut data = sent[at].data().to_vec();
        let bit = bit.index(data.len() * 8);
        data[bit / 8] ^= 1 << (bit % 8);
        sent[at] = CanFrame::new(sent[at].id(), &data, mtu).unwrap();
        for transfer in feed(&mut session(), &sent, 0).0 {
            // A flipped end-of-transfer bit can make a single-frame transfer out of the first frame: CAN's own CRC is
            // what guards frames. Anything longer than a frame is guarded here.
            prop_assert!(transfer == padded(&payload, mtu) || transfer.len() < mtu.bytes(), "{} bytes", transfer.len());
        }
    }

    #[test]
    fn any_bytes_under_any_identifier_are_survived(
        noise in proptest::collection::vec((any::<u32>(), proptest::collection::vec(any::<u8>(), 0..70), 0_u64..3_000), 0..200),
        payload in payloads(0..=300), mtu in mtus(),
    ) {
        // Small enough to overflow.
        let mut small = Session::<100>::new(subject(1234), node(42), TIMEOUT);
        let header = Header { priority: Priority::Nominal, subject: subject(1234), source: node(42) };
        let mut delivered = 0;
        for (id, data, now) in &noise {
            // Most identifiers are foreign: half of the frames get ours.
            let header = if id % 2 == 0 { Ok(header) } else { Header::parse(*id) };
            let Ok(header) = header else { continue };
            if let Ok(Some(transfer)) = small.accept(&header, data, *now) {
                delivered += 1;
                prop_assert!(transfer.payload.len() <= 100);
            }
        }
        prop_assert_eq!(small.stats().transfers, delivered);
        // And it still works, once what it believes to be newer has timed out.
        let sent = frames(&mut sender(), &payload, mtu);
        let expected = padded(&payload, mtu);
        let fits = expected.len() <= 100;
        let (transfers, errors) = feed(&mut small, &sent, 10_000);
        prop_assert_eq!(transfers.first(), fits.then_some(&expected));
        prop_assert_eq!(errors.contains(&RxError::Oversize), !fits);
    }
}

/// Three-frame transfers of classic CAN, told apart by their content.
fn transfer(sender: &mut Sender<1>, content: u8) -> Vec<CanFrame> {
    let sent = frames(sender, &[content, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, content], Mtu::Classic);
    assert_eq!(sent.len(), 3);
    sent
}

#[test]
fn transfers_of_other_subjects_and_sources_may_come_in_between() {
    let mut mine = sender();
    let mut other_subject = Sender::new(node(42), [subject(1235)]);
    let mut other_source = Sender::new(node(43), [subject(1234)]);
    let long = [3; 40];
    let a = transfer(&mut mine, 1);
    let b: Vec<_> = other_subject.send(subject(1235), Priority::Fast, &long, Mtu::Classic).unwrap().collect();
    let c: Vec<_> = other_source.send(subject(1234), Priority::Nominal, &long, Mtu::Classic).unwrap().collect();
    let mixed: Vec<_> = (0..3).flat_map(|n| [b[n], a[n], c[n]]).chain(b[3..].to_vec()).chain(c[3..].to_vec()).collect();

    let mut sessions = [
        Session::<64>::new(subject(1234), node(42), TIMEOUT),
        Session::<64>::new(subject(1235), node(42), TIMEOUT),
        Session::<64>::new(subject(1234), node(43), TIMEOUT),
    ];
    let lengths =
        sessions.each_mut().map(|session| feed(session, &mixed, 0).0.iter().map(Vec::len).collect::<Vec<_>>());
    assert_eq!(lengths, [vec![16], vec![40], vec![40]]);
    assert!(sessions.iter().all(|session| session.stats().errors() == 0));
}

#[test]
fn a_repeated_or_overtaken_transfer_is_not_delivered_as_new() {
    let (mut sender, mut session) = (sender(), session());
    let sent: Vec<_> = (0..4).map(|n| frames(&mut sender, &[n], Mtu::Fd)).collect();
    let mut give = |n: usize| feed(&mut session, &sent[n], 0);
    assert_eq!(give(0), (vec![vec![0]], vec![]));
    assert_eq!(give(0), (vec![], vec![RxError::Duplicate]));
    assert_eq!(give(3), (vec![vec![3]], vec![]));
    assert_eq!(give(1), (vec![], vec![RxError::Stale]));
    assert_eq!(give(2), (vec![], vec![RxError::Stale]));
    assert_eq!((session.stats().missed, session.stats().stale, session.stats().duplicate), (2, 2, 1));
}

#[test]
fn a_source_that_restarts_is_heard_after_the_timeout() {
    let mut session = session();
    let mut old = sender();
    for _ in 0..20 {
        feed(&mut session, &frames(&mut old, &[1], Mtu::Fd), 0);
    }
    let mut restarted = sender();
    assert_eq!(feed(&mut session, &frames(&mut restarted, &[2], Mtu::Fd), TIMEOUT).0, [[2]; 1], "19 -> 0 is 13 ahead");
    let mut restarted = sender();
    assert_eq!(feed(&mut session, &frames(&mut restarted, &[3], Mtu::Fd), 2 * TIMEOUT).1, [RxError::Duplicate]);
    let mut restarted = sender();
    assert_eq!(feed(&mut session, &frames(&mut restarted, &[4], Mtu::Fd), 2 * TIMEOUT + 1).0, [[4]; 1]);
}

#[test]
fn a_transfer_that_takes_too_long_is_given_up() {
    let (mut sender, mut session) = (sender(), session());
    let sent = transfer(&mut sender, 1);
    assert_eq!(feed(&mut session, &sent[..2], 0), (vec![], vec![]));
    assert_eq!(feed(&mut session, &sent[2..], TIMEOUT + 1), (vec![], vec![RxError::Timeout]));
    assert_eq!(session.stats().given_up, 1);
    // The start frame decides: the next transfer is taken.
    assert_eq!(feed(&mut session, &transfer(&mut sender, 2), TIMEOUT + 2).0.len(), 1);
}

#[test]
fn a_transfer_that_begins_ends_the_one_under_way() {
    let (mut sender, mut session) = (sender(), session());
    let (first, second) = (transfer(&mut sender, 1), transfer(&mut sender, 2));
    feed(&mut session, &first[..2], 0);
    let (transfers, errors) = feed(&mut session, &second, 0);
    assert_eq!((transfers.len(), transfers[0][0], errors), (1, 2, vec![]));
    assert_eq!(feed(&mut session, &first[2..], 0), (vec![], vec![RxError::NoStart]));
    assert_eq!((session.stats().given_up, session.stats().missed), (1, 0));
}

#[test]
fn a_missing_frame_is_noticed_at_the_next_one() {
    let (mut sender, mut session) = (sender(), session());
    let sent = frames(&mut sender, &(0..40).collect::<Vec<u8>>(), Mtu::Classic);
    feed(&mut session, &sent[..2], 0);
    assert_eq!(feed(&mut session, &sent[3..4], 0), (vec![], vec![RxError::FrameLost]));
    assert_eq!(feed(&mut session, &sent[4..], 0), (vec![], vec![RxError::NoStart; 2]));
    assert_eq!((session.stats().frame_lost, session.stats().given_up), (1, 1));
}

#[test]
fn a_first_frame_repeated_at_once_is_no_new_transfer_but_later_it_is() {
    let (mut sender, mut session) = (sender(), session());
    let sent = transfer(&mut sender, 1);
    feed(&mut session, &[sent[0], sent[0], sent[1]], 0);
    assert_eq!(session.stats().given_up, 0);
    feed(&mut session, &sent[..1], 0);
    assert_eq!(session.stats().given_up, 1);
    assert_eq!(feed(&mut session, &sent[1..], 0).0.len(), 1, "a node that restarted sends all of it once more");
}

#[test]
fn a_transfer_beyond_the_buffer_is_an_error_and_the_next_one_is_taken() {
    for mtu in Mtu::ALL {
        let mut session = Session::<40>::new(subject(1234), node(42), TIMEOUT);
        let mut sender = sender();
        for len in [41, 64, 200, BUFFER] {
            let (transfers, errors) = feed(&mut session, &frames(&mut sender, &vec![1; len], mtu), 0);
            assert!(transfers.is_empty() && errors.contains(&RxError::Oversize), "{len} bytes, {mtu:?}");
            let (transfers, errors) = feed(&mut session, &frames(&mut sender, &[2; 31], mtu), 0);
            assert_eq!((transfers, errors), (vec![vec![2; 31]], vec![]), "after {len} bytes, {mtu:?}");
        }
        assert_eq!(session.stats().oversize, 4);
    }
}

#[test]
fn malformed_frames_are_refused_by_name() {
    let header = Header { priority: Priority::Nominal, subject: subject(1234), source: node(42) };
    let mut session = session();
    let mut error = |data: &[u8]| session.accept(&header, data, 0).err();
    assert_eq!(error(&[]), Some(RxError::Empty));
    assert_eq!(error(&[1, 2, 0xc0]), Some(RxError::Malformed), "start without toggle is UAVCAN v0");
    assert_eq!(error(&[1, 2, 0xa0]), Some(RxError::Malformed), "first of several frames, but not full");
    assert_eq!(error(&[1, 2, 0x40]), Some(RxError::NoStart));
    assert_eq!(error(&[1, 2, 3, 4, 5, 6, 7, 0xa0]), None);
    assert_eq!(error(&[1, 2, 3, 4, 5, 6, 0x00]), Some(RxError::Malformed), "middle frame, but not full");
    assert_eq!(error(&[1, 2, 0x40]), Some(RxError::NoStart), "the transfer was given up");
    assert_eq!(error(&[1, 2, 3, 4, 5, 6, 7, 0xa0]), None);
    assert_eq!(error(&[1, 0x40]), Some(RxError::Crc));
    let stats = session.stats();
    assert_eq!((stats.frames, stats.malformed, stats.no_start, stats.crc, stats.given_up), (9, 4, 2, 1, 2));
    assert_eq!(stats.errors(), 7);
}

#[test]
fn memory_of_a_session_is_its_buffer_and_little_more() {
    // The buffer, 12 counters, the transfer under way, the last delivered one.
    let overhead = size_of::<Session<128>>() - 128;
    assert!(overhead <= 144, "{overhead} bytes");
    assert_eq!(size_of::<Session<4_408>>() - 4_408, overhead);
    assert!(size_of::<Sender<12>>() <= 52);
}
