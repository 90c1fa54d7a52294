//! The SocketCAN bus on a real interface of a real kernel.

use rand_core::{Rng, SeedableRng};
use std::process::Command;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::NodeId;
use tactus_hil::bus::{Bus, LiveBus, Refusal};
use tactus_hil::socketcan_bus::{IdFilter, OpenError, SocketCanBus};

/// Long enough for a frame on any machine.
const SOON: Duration = Duration::from_secs(2);

/// Long enough to see that nothing comes.
const QUIET: Duration = Duration::from_millis(50);

fn shell(line: &str) {
    let status = Command::new("sh").args(["-c", line]).status().expect("there is a shell");
    assert!(status.success(), "{line}: {status}");
}

/// An interface of this test, which goes with it.
struct Interface(&'static str);

impl Interface {
    fn new(name: &'static str, mtu: u32) -> Self {
        shell(&format!("ip link add {name} type vcan && ip link set {name} mtu {mtu} && ip link set {name} up"));
        Self(name)
    }

    fn open(&self) -> SocketCanBus {
        SocketCanBus::open(self.0, None, &[]).expect("the interface is up")
    }

    fn set(&self, state: &str) {
        shell(&format!("ip link set {} {state}", self.0));
    }
}

impl Drop for Interface {
    fn drop(&mut self) {
        shell(&format!("ip link del {}", self.0));
    }
}

fn frame(id: u32, bytes: usize, mtu: Mtu) -> CanFrame {
    let data: Vec<u8> = (0..bytes).map(|i| (i * 7 + 1) as u8).collect();
    CanFrame::new(id, &data, mtu).expect("a length of this format")
}

fn next(bus: &mut SocketCanBus) -> CanFrame {
    assert!(bus.wait(SOON), "no frame within {SOON:?}; {:?}", bus.stats());
    bus.receive().expect("wait promised one").frame
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn frames_of_every_length_and_both_formats_arrive_as_they_were_sent() {
    let interface = Interface::new("vcan1", 72);
    let (mut here, mut there) = (interface.open(), interface.open());
    assert_eq!(here.mtu(), Mtu::Fd, "an MTU of 72 is CAN FD");
    for mtu in Mtu::ALL {
        for bytes in (0..=mtu.bytes()).filter(|&n| mtu.frame_bytes(n) == Some(n)) {
            for sent in [
                frame(0x1fff_ffff, bytes, mtu),
                frame(0, bytes, mtu),
                CanFrame::new_base(0x7ff, &vec![0xa5; bytes], mtu).unwrap(),
            ] {
                here.send(sent).unwrap();
                assert_eq!(next(&mut there), sent);
            }
        }
    }
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn an_interface_for_can_2_carries_classic_frames_and_refuses_long_ones() {
    let interface = Interface::new("vcan1", 16);
    let (mut here, mut there) = (interface.open(), interface.open());
    assert_eq!(here.mtu(), Mtu::Classic);
    here.send(frame(5, 8, Mtu::Classic)).unwrap();
    assert_eq!(next(&mut there), frame(5, 8, Mtu::Classic));
    assert_eq!(here.send(frame(5, 64, Mtu::Fd)).unwrap_err().reason, Refusal::Format);
    let error = SocketCanBus::open("vcan1", Some(Mtu::Fd), &[]).unwrap_err();
    assert!(matches!(error, OpenError::Format { .. }), "{error}");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn classic_frames_can_be_asked_for_on_a_can_fd_interface() {
    let _interface = Interface::new("vcan1", 72);
    let bus = SocketCanBus::open("vcan1", Some(Mtu::Classic), &[]).unwrap();
    assert_eq!(bus.mtu(), Mtu::Classic);
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn own_frames_do_not_come_back_and_those_of_the_sending_half_neither() {
    let interface = Interface::new("vcan1", 72);
    let (mut here, mut there) = (interface.open(), interface.open());
    let mut half = here.sender().unwrap();
    here.send(frame(1, 8, Mtu::Fd)).unwrap();
    std::thread::spawn(move || half.send(frame(2, 8, Mtu::Fd)).unwrap()).join().unwrap();
    assert_eq!((next(&mut there).id(), next(&mut there).id()), (1, 2));
    assert!(!here.wait(QUIET), "{:?}", here.receive());
    assert_eq!((here.stats().sent, here.stats().received), (2, 0));
    assert_eq!((there.stats().sent, there.stats().received), (0, 2));
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn the_kernel_lets_only_frames_of_the_wanted_node_through() {
    let interface = Interface::new("vcan1", 72);
    let node = NodeId::new(20).unwrap();
    let mut picky = SocketCanBus::open("vcan1", None, &[IdFilter::from_node(node)]).unwrap();
    let mut there = interface.open();
    for source in 0..128 {
        there.send(frame(0x1064_5500 | source, 8, Mtu::Fd)).unwrap();
        there.send(CanFrame::new_base(source as u16, &[1], Mtu::Fd).unwrap()).unwrap();
    }
    // A remote frame with the wanted source, from an independent sender.
    shell("cansend vcan1 10645514#R");
    there.send(frame(0x1014, 3, Mtu::Classic)).unwrap();
    assert_eq!(next(&mut picky).id(), 0x1064_5514);
    assert_eq!(next(&mut picky).id(), 0x1014);
    assert!(!picky.wait(QUIET));
    assert_eq!(picky.stats().foreign, 0, "stopped by the kernel, not by us");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_long_burst_arrives_in_order_with_nothing_lost_and_its_times_rise() {
    let interface = Interface::new("vcan1", 72);
    let (mut here, mut there) = (interface.open(), interface.open());
    let before = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as u64;
    let count = 2000;
    for i in 0..count {
        here.send(frame(i, 64, Mtu::Fd)).unwrap();
    }
    let mut last = before;
    for i in 0..count {
        assert!(there.wait(SOON), "frame {i}: {:?}", there.stats());
        let got = there.receive().unwrap();
        assert_eq!(got.frame.id(), i);
        assert!(got.at_ns >= last, "frame {i} came before its predecessor");
        last = got.at_ns;
    }
    let after = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as u64;
    assert!(last <= after, "stamped by the kernel's wall clock");
    assert_eq!(there.stats().lost, 0);
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn a_frame_bears_the_time_of_its_arrival_not_of_its_fetching() {
    let interface = Interface::new("vcan1", 72);
    let (mut here, mut there) = (interface.open(), interface.open());
    here.send(frame(1, 8, Mtu::Fd)).unwrap();
    let sent = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_nanos() as u64;
    std::thread::sleep(QUIET);
    let fetched = there.receive().expect("it has long come");
    assert!(fetched.at_ns <= sent, "{} ns late", fetched.at_ns - sent);
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn what_the_queue_had_no_room_for_is_counted() {
    let interface = Interface::new("vcan1", 72);
    let (mut here, mut there) = (interface.open(), interface.open());
    let count = 20_000;
    for i in 0..count {
        here.send(frame(i, 64, Mtu::Fd)).unwrap();
    }
    let mut arrived = 0;
    while there.wait(QUIET) {
        arrived += u64::from(there.receive().is_some());
    }
    let stats = there.stats();
    assert!(stats.lost > 0, "no queue holds {count} frames: {stats:?}");
    assert_eq!(arrived + stats.lost, u64::from(count), "{stats:?}");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn error_frames_and_remote_frames_are_counted_and_not_handed_out() {
    let interface = Interface::new("vcan1", 72);
    let mut bus = interface.open();
    shell("cansend vcan1 20000004#0000000000000000; cansend vcan1 00000123#R; cansend vcan1 00000123#AB");
    assert_eq!(next(&mut bus), CanFrame::new(0x123, &[0xab], Mtu::Classic).unwrap());
    assert_eq!((bus.stats().errors, bus.stats().foreign), (1, 1));
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn waiting_takes_the_time_that_was_asked_for_and_no_longer_than_a_frame() {
    let interface = Interface::new("vcan1", 72);
    let (mut here, there) = (interface.open(), interface.open());
    let started = Instant::now();
    assert!(!here.wait(Duration::from_millis(80)));
    let waited = started.elapsed();
    assert!((80..1000).contains(&waited.as_millis()), "{waited:?}");
    let mut half = there.sender().unwrap();
    let started = Instant::now();
    let late = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(50));
        half.send(frame(9, 8, Mtu::Fd)).unwrap();
    });
    assert!(here.wait(Duration::from_secs(10)));
    assert!(started.elapsed() < Duration::from_secs(5), "{:?}", started.elapsed());
    late.join().unwrap();
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn an_interface_that_goes_down_is_down_and_carries_on_when_it_is_up_again() {
    let interface = Interface::new("vcan1", 72);
    let (mut here, mut there) = (interface.open(), interface.open());
    interface.set("down");
    assert_eq!(here.send(frame(1, 8, Mtu::Fd)).unwrap_err().reason, Refusal::Down);
    assert!(!here.wait(QUIET));
    assert!(!there.wait(QUIET), "a bus that is down is waited for without an error");
    assert_eq!((here.stats().downs, there.stats().downs), (1, 1));
    interface.set("up");
    here.send(frame(2, 8, Mtu::Fd)).unwrap();
    assert_eq!(next(&mut there).id(), 2);
    interface.set("down");
    assert!(!there.wait(QUIET));
    assert_eq!(there.stats().downs, 2);
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn an_interface_that_was_pulled_out_is_found_again_with_its_filters() {
    let interface = Interface::new("vcan1", 72);
    let node = NodeId::new(7).unwrap();
    let mut here = SocketCanBus::open("vcan1", None, &[IdFilter::from_node(node)]).unwrap();
    drop(interface);
    assert!(!here.wait(QUIET));
    assert_eq!(here.send(frame(1, 8, Mtu::Fd)).unwrap_err().reason, Refusal::Down);
    let interface = Interface::new("vcan1", 72);
    let mut there = interface.open();
    assert!(!here.wait(QUIET), "nothing was sent yet");
    there.send(frame(6, 8, Mtu::Fd)).unwrap();
    there.send(frame(7, 8, Mtu::Fd)).unwrap();
    assert_eq!(next(&mut here).id(), 7);
    here.send(frame(7, 8, Mtu::Fd)).unwrap();
    assert_eq!(next(&mut there).id(), 7);
    assert_eq!(here.stats().downs, 1);
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn what_cannot_be_opened_is_refused_with_what_was_expected() {
    let interface = Interface::new("vcan1", 72);
    for (name, says) in [("nosuch0", "no CAN interface nosuch0; expected"), ("lo", "lo is no CAN interface; expected")]
    {
        let error = SocketCanBus::open(name, None, &[]).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
    interface.set("down");
    let error = SocketCanBus::open("vcan1", None, &[]).unwrap_err().to_string();
    assert!(error.contains("ip link set vcan1 up"), "{error}");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn random_frames_of_an_independent_sender_do_no_harm() {
    let interface = Interface::new("vcan1", 72);
    let mut here = interface.open();
    let count = 1500;
    shell(&format!("cangen vcan1 -m -g 0 -n {count} -L r -I r"));
    let mut arrived = 0;
    while here.wait(QUIET) {
        arrived += u64::from(here.receive().is_some());
    }
    let stats = here.stats();
    assert_eq!(arrived + stats.foreign + stats.lost, count, "{stats:?}");
}

#[test]
#[ignore = "needs vcan0: cargo xtask test runs it"]
fn two_nodes_talk_from_two_threads_for_thousands_of_frames() {
    let interface = Interface::new("vcan1", 72);
    let (mut here, mut there) = (interface.open(), interface.open());
    let rounds = 3000;
    let echo = std::thread::spawn(move || {
        for _ in 0..rounds {
            let frame = next(&mut there);
            there.send(frame).unwrap();
        }
    });
    let mut random = rand_pcg::Pcg64::seed_from_u64(1);
    for _ in 0..rounds {
        let bytes = Mtu::Fd.frame_bytes(random.next_u32() as usize % 65).unwrap();
        let sent = frame(random.next_u32() >> 3, bytes, Mtu::Fd);
        here.send(sent).unwrap();
        assert_eq!(next(&mut here), sent);
    }
    echo.join().unwrap();
}
