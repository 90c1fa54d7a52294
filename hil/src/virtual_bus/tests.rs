use super::*;
use crate::bit_time::WireBits;
use proptest::prelude::*;
use tactus_common::cyphal::{Header, NodeId, Priority, Sender, Session, SubjectId, received_bytes};

fn frame(id: u32, data: &[u8], mtu: Mtu) -> CanFrame {
    CanFrame::new(id, data, mtu).unwrap()
}

fn drain(bus: &mut VirtualBus, index: usize) -> Vec<Received> {
    std::iter::from_fn(|| bus.endpoint(index).receive()).collect()
}

fn ids(received: &[Received]) -> Vec<u32> {
    received.iter().map(|received| received.frame.id()).collect()
}

#[test]
fn a_frame_takes_its_bits_and_arrives_at_all_others() {
    let mut bus = VirtualBus::new(3, VirtualBusConfig::FD);
    let sent = frame(0x155, &[0x55; 64], Mtu::Fd);
    bus.advance_to(1_000);
    bus.endpoint(1).send(sent).unwrap();
    let WireBits { nominal, data } = wire_bits(&sent);
    let took_ns = u64::from(nominal - 3) * 1_000 + u64::from(data) * 200;
    assert_eq!(bus.run_until_idle(), took_ns);
    assert_eq!(bus.now_ns(), 1_000 + took_ns);
    let expected = [Received { frame: sent, at_ns: 1_000 + took_ns }];
    assert_eq!([0, 1, 2].map(|index| drain(&mut bus, index)), [expected.to_vec(), vec![], expected.to_vec()]);
    let stats = bus.stats();
    assert_eq!((stats.frames, stats.bits, stats.busy_ns), (1, u64::from(nominal + data), took_ns + 3_000));
}

#[test]
fn the_lowest_identifier_wins_whoever_sends_it() {
    let mut bus = VirtualBus::new(3, VirtualBusConfig::FD);
    for (index, id) in [(0, 50), (0, 20), (1, 30), (1, 10), (1, 60)] {
        bus.endpoint(index).send(frame(id, &[index as u8], Mtu::Fd)).unwrap();
    }
    bus.run_until_idle();
    let received = drain(&mut bus, 2);
    assert_eq!(ids(&received), [10, 20, 30, 50, 60]);
    assert!(received.is_sorted_by_key(|received| received.at_ns));
    assert_eq!(bus.stats().collisions, 0);
}

#[test]
fn a_frame_on_the_wire_is_not_interrupted() {
    let mut bus = VirtualBus::new(2, VirtualBusConfig::CLASSIC);
    bus.endpoint(0).send(frame(100, &[0; 8], Mtu::Classic)).unwrap();
    bus.advance_to(1);
    bus.endpoint(0).send(frame(1, &[], Mtu::Classic)).unwrap();
    bus.run_until_idle();
    assert_eq!(ids(&drain(&mut bus, 1)), [100, 1]);
}

#[test]
fn frames_of_equal_identifier_keep_their_order_and_follow_without_gap() {
    let mut bus = VirtualBus::new(2, VirtualBusConfig::CLASSIC);
    let frames: Vec<CanFrame> = (0..5).map(|n| frame(7, &[n; 8], Mtu::Classic)).collect();
    frames.iter().for_each(|frame| bus.endpoint(0).send(*frame).unwrap());
    bus.run_until_idle();
    let received = drain(&mut bus, 1);
    assert!(received.iter().map(|received| received.frame).eq(frames.iter().copied()));
    let durations = frames.iter().map(|frame| u64::from(wire_bits(frame).total()) * 1_000);
    let ends = durations.scan(0, |end_ns, duration_ns| {
        *end_ns += duration_ns;
        Some(*end_ns - 3_000)
    });
    assert!(received.iter().map(|received| received.at_ns).eq(ends));
}

#[test]
fn time_passes_in_steps_of_any_size_with_the_same_result() {
    let run = |step_ns: u64| {
        let mut bus = VirtualBus::new(2, VirtualBusConfig::FD);
        for n in 0..20_u32 {
            bus.endpoint((n % 2) as usize).send(frame(1_000 - n, &[n as u8; 32], Mtu::Fd)).unwrap();
        }
        while bus.now_ns() < 10_000_000 {
            bus.advance_to(bus.now_ns() + step_ns);
        }
        (drain(&mut bus, 0), drain(&mut bus, 1), bus.stats())
    };
    assert_eq!(run(1_000), run(10_000_000));
    assert_eq!(run(77_777).0, run(10_000_000).0);
}

#[test]
fn time_does_not_run_backwards() {
    let mut bus = VirtualBus::new(2, VirtualBusConfig::FD);
    bus.advance_to(5_000);
    bus.advance_to(1_000);
    assert_eq!(bus.now_ns(), 5_000);
    assert_eq!(bus.run_until_idle(), 0);
}

#[test]
fn a_full_transmit_queue_hands_the_frame_back() {
    let mut bus = VirtualBus::new(2, VirtualBusConfig { transmit_frames: 3, ..VirtualBusConfig::FD });
    let sent: Vec<_> = (0..5).map(|n| bus.endpoint(0).send(frame(n, &[], Mtu::Fd))).collect();
    assert!(sent[..3].iter().all(Result::is_ok));
    assert_eq!(sent[4], Err(Rejected { frame: frame(4, &[], Mtu::Fd), reason: Refusal::Full }));
    let stats = bus.endpoint_stats(0);
    assert_eq!((stats.accepted, stats.rejected, stats.transmit_high_water), (3, 2, 3));
    bus.run_until_idle();
    assert!(bus.endpoint(0).send(frame(4, &[], Mtu::Fd)).is_ok());
}

#[test]
fn a_full_receive_queue_loses_the_new_frame_and_counts_it() {
    let mut bus = VirtualBus::new(2, VirtualBusConfig { receive_frames: 3, ..VirtualBusConfig::FD });
    (0..5).for_each(|n| bus.endpoint(0).send(frame(n, &[], Mtu::Fd)).unwrap());
    bus.run_until_idle();
    assert_eq!(ids(&drain(&mut bus, 1)), [0, 1, 2]);
    let stats = bus.endpoint_stats(1);
    assert_eq!((stats.received, stats.overrun, stats.receive_high_water), (3, 2, 3));
}

#[test]
fn a_classic_bus_refuses_fd_frames() {
    let mut bus = VirtualBus::new(2, VirtualBusConfig::CLASSIC);
    let sent = bus.endpoint(0).send(frame(1, &[1], Mtu::Fd));
    assert_eq!(sent.map_err(|rejected| rejected.reason), Err(Refusal::Format));
    assert_eq!(bus.endpoint(0).mtu(), Mtu::Classic);
}

#[test]
fn two_endpoints_with_one_identifier_are_reported() {
    let mut bus = VirtualBus::new(3, VirtualBusConfig::FD);
    bus.endpoint(1).send(frame(5, &[1], Mtu::Fd)).unwrap();
    bus.endpoint(0).send(frame(5, &[0], Mtu::Fd)).unwrap();
    bus.run_until_idle();
    assert_eq!(bus.stats().collisions, 1);
    assert_eq!(drain(&mut bus, 2).iter().map(|received| received.frame.data()[0]).collect::<Vec<_>>(), [0, 1]);
}

#[test]
fn short_and_long_identifiers_share_the_wire_by_their_upper_bits_and_are_not_confused() {
    let mut bus = VirtualBus::new(3, VirtualBusConfig::CLASSIC);
    let short = |id| CanFrame::new_base(id, &[1], Mtu::Classic).unwrap();
    let long = |id| frame(id, &[2], Mtu::Classic);
    let expected = [long(0x403 << 18 | 7), short(0x404), long(0x404 << 18), short(0x405), short(0x563)];
    for (index, n) in [(0, 4), (0, 2), (1, 3), (1, 0), (0, 1)] {
        bus.endpoint(index).send(expected[n]).unwrap();
    }
    // The same number at another length is no collision.
    bus.endpoint(1).send(long(0x563)).unwrap();
    bus.run_until_idle();
    let received: Vec<CanFrame> = drain(&mut bus, 2).iter().map(|received| received.frame).collect();
    assert_eq!(received[0], long(0x563), "its upper eleven bits are zero");
    assert_eq!(received[1..], expected);
    assert_eq!(bus.stats().collisions, 0);
}

#[test]
fn load_is_the_share_of_busy_time_in_the_busiest_100_ms() {
    let mut bus = VirtualBus::new(2, VirtualBusConfig::FD);
    let sent = frame(0x155, &[0x55; 64], Mtu::Fd);
    let share = wire_bits(&sent).duration_ns(BitRates::M1_5) as f64 / 2e6;
    for tick in 0..200 {
        bus.advance_to(tick * 2_000_000);
        bus.endpoint(0).send(sent).unwrap();
        bus.run_until_idle();
    }
    assert!((bus.stats().load_max - share).abs() < 1e-3, "{} {share}", bus.stats().load_max);
}

fn with_faults(faults: Faults) -> (Vec<Received>, BusStats, EndpointStats) {
    let mut bus = VirtualBus::new(2, VirtualBusConfig { faults, receive_frames: 100_000, ..VirtualBusConfig::FD });
    for n in 0..20_000_u32 {
        bus.endpoint(0).send(frame(9, &n.to_le_bytes(), Mtu::Fd)).unwrap();
        bus.run_until_idle();
    }
    (drain(&mut bus, 1), bus.stats(), bus.endpoint_stats(1))
}

#[test]
fn faults_come_as_often_as_asked_for_and_the_same_by_the_same_seed() {
    let faults = Faults { loss_ppm: 10_000, seed: 3, ..Faults::NONE };
    let (received, _, stats) = with_faults(faults);
    assert_eq!(received.len() as u64 + stats.lost, 20_000);
    assert!((150..250).contains(&stats.lost), "{}", stats.lost);
    assert_eq!(with_faults(faults).0, received);
    assert_ne!(with_faults(Faults { seed: 4, ..faults }).0, received);
}

#[test]
fn damaged_frames_cost_time_and_doubled_frames_arrive_twice_but_none_is_lost() {
    let value = |received: &Received| u32::from_le_bytes(received.frame.data().try_into().unwrap());
    let (plain, plain_stats, _) = with_faults(Faults::NONE);
    let (damaged, stats, _) = with_faults(Faults { damage_ppm: 100_000, seed: 1, ..Faults::NONE });
    assert!(damaged.iter().map(value).eq(plain.iter().map(value)));
    assert!((2_000..2_500).contains(&stats.repeated), "{}", stats.repeated);
    assert!(stats.busy_ns > plain_stats.busy_ns * 11 / 10);
    let (mut doubled, stats, _) = with_faults(Faults { double_ppm: 100_000, seed: 1, ..Faults::NONE });
    assert_eq!(doubled.len() as u64, 20_000 + stats.repeated);
    doubled.dedup_by_key(|received| value(received));
    assert!(doubled.iter().map(value).eq(0..20_000));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn transfers_survive_doubled_and_damaged_frames_and_lost_ones_never_corrupt(
        seed in any::<u64>(), mtu in prop_oneof![Just(Mtu::Classic), Just(Mtu::Fd)], loss_ppm in prop_oneof![Just(0), Just(50_000)],
    ) {
        let (source, subject) = (NodeId::new(1).unwrap(), SubjectId::new(77).unwrap());
        let base = if mtu == Mtu::Fd { VirtualBusConfig::FD } else { VirtualBusConfig::CLASSIC };
        let faults = Faults { loss_ppm, damage_ppm: 50_000, double_ppm: 50_000, seed };
        let mut bus = VirtualBus::new(2, VirtualBusConfig { faults, ..base });
        let mut sender = Sender::new(source, [subject]);
        let mut session = Session::<{ received_bytes(600, Mtu::Fd) }>::new(subject, source, 20_000_000);
        for n in 0..50_usize {
            let payload: Vec<u8> = (0..n * 12).map(|at| (at ^ n) as u8).collect();
            for frame in sender.send(subject, Priority::Nominal, &payload, mtu).unwrap() {
                bus.endpoint(0).send(frame).unwrap();
            }
            bus.run_until_idle();
            let mut delivered = 0;
            while let Some(Received { frame, at_ns }) = bus.endpoint(1).receive() {
                let header = Header::parse(frame.id()).unwrap();
                if let Ok(Some(transfer)) = session.accept(&header, frame.data(), at_ns) {
                    delivered += 1;
                    prop_assert!(transfer.payload.starts_with(&payload), "transfer {}", n);
                }
            }
            prop_assert!(delivered == 1 || loss_ppm > 0 && delivered == 0, "transfer {}: {}", n, delivered);
        }
    }
}
