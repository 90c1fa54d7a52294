use super::*;
use tactus_common::cyphal::{NodeId, Sender};
use tactus_common::link::{self, CONTROLLER, priority, subject};
use tactus_common::message::{
    Command, EventKind, FaultReason, Heartbeat, Hello, Message, Outcome, SensorFrame, Setup, TactileSlice,
};
use tactus_common::reading::TactileImage;
use tactus_controller::testing::{home, readings, setup};

extern crate std;
use std::vec::Vec;

/// A shell with a world that the test speaks for.
struct Bench {
    shell: Shell,
    world: Sender<3>,
    said: Vec<CanFrame>,
}

impl Bench {
    fn new() -> Self {
        let world = Sender::new(WORLD, [subject::<Setup>(), subject::<SensorFrame>(), subject::<TactileSlice>()]);
        Self { shell: Shell::new(Mtu::Classic), world, said: Vec::new() }
    }

    /// The world says this at this time.
    fn tell<M: Message>(&mut self, now_ms: u32, message: &M) -> bool {
        let mut buffer = [0; link::SMALL_BYTES];
        let bytes = link::encode(message, &mut buffer).unwrap();
        let frames = self.world.send(subject::<M>(), priority::<M>(), bytes, Mtu::Classic).unwrap();
        let (shell, said) = (&mut self.shell, &mut self.said);
        frames.fold(false, |ticked, frame| ticked | shell.receive(now_ms, &frame, &mut |frame| said.push(frame)))
    }

    /// A mission under way: its first tick has passed at this time.
    fn begin(&mut self, now_ms: u32) {
        assert!(!self.tell(now_ms, &setup()));
        assert!(self.tell(now_ms, &SensorFrame::pack(&readings(0, home()))));
        assert_ne!(self.shell.node().controller().phase(), Phase::Fault);
        assert!(!self.shell.node().is_free());
    }

    /// Nothing comes at this time; how many of these messages are sent.
    fn idle<M: Message>(&mut self, now_ms: u32) -> usize {
        self.said.clear();
        let said = &mut self.said;
        self.shell.idle(now_ms, &mut |frame| said.push(frame));
        let of_kind = |frame: &&CanFrame| {
            let header = Header::of(frame).unwrap();
            // The first frame of a transfer says so in its last byte.
            header.source == CONTROLLER
                && header.subject == subject::<M>()
                && frame.data().last().is_some_and(|b| b & 0x80 != 0)
        };
        self.said.iter().filter(of_kind).count()
    }

    fn outcome(&self) -> Option<EventKind> {
        self.shell.node().end().map(|(kind, _)| kind)
    }
}

const SILENT: EventKind = EventKind::Finished(Outcome::Fault(FaultReason::HostSilent));

#[test]
fn without_a_mission_it_announces_itself_at_once_and_then_once_a_second() {
    let mut bench = Bench::new();
    let counts: Vec<usize> = (0..3_500).map(|ms| bench.idle::<Heartbeat>(ms)).collect();
    let when: Vec<usize> = (0..3_500).filter(|&ms| counts[ms] > 0).collect();
    assert_eq!(when, [0, 1_000, 2_000, 3_000]);
    assert_eq!(counts.iter().sum::<usize>(), 4);
    assert_eq!(bench.idle::<Hello>(4_000), 1);
}

#[test]
fn during_a_mission_it_does_not_announce_itself_and_after_its_end_it_does_again() {
    let mut bench = Bench::new();
    assert_eq!(bench.idle::<Hello>(0), 1);
    bench.begin(500);
    assert_eq!(bench.idle::<Hello>(1_000), 0);
    assert_eq!(bench.idle::<Hello>(2_000), 0);
    assert_eq!(bench.idle::<Hello>(3_000), 1, "the world has been given up");
}

#[test]
fn two_seconds_of_silence_in_a_mission_make_it_safe_and_then_it_sends_no_more_commands() {
    let mut bench = Bench::new();
    bench.begin(100);
    assert_eq!(bench.idle::<Command>(100 + SILENCE_MS - 1), 0);
    assert_eq!(bench.outcome(), None);
    assert_eq!(bench.idle::<Command>(100 + SILENCE_MS), SILENCE_TICKS_MAX as usize);
    assert_eq!(bench.outcome(), Some(SILENT));
    assert_eq!(bench.shell.node().controller().phase(), Phase::Fault);
    for ms in 1..10_000 {
        assert_eq!(bench.idle::<Command>(100 + SILENCE_MS + ms), 0);
    }
}

#[test]
fn whatever_the_world_says_keeps_the_mission_alive_and_what_others_say_does_not() {
    let image = TactileSlice::pack(&TactileImage { pad: 0, stamp: 0, pressure_n_cm2: [0.0; 24] }, 1);
    let mut bench = Bench::new();
    bench.begin(0);
    for ms in (1_900..20_000).step_by(1_900) {
        bench.tell(ms, &image);
        bench.idle::<Command>(ms + 1_899);
    }
    assert_eq!(bench.outcome(), None);
    let other = Header { priority: priority::<Setup>(), subject: subject::<Setup>(), source: NodeId::new(99).unwrap() };
    for ms in 19_000..21_500 {
        let foreign = CanFrame::new(other.id(), &[0xe0], Mtu::Classic).unwrap();
        bench.shell.receive(ms, &foreign, &mut |_| {});
        bench.idle::<Command>(ms);
    }
    assert_eq!(bench.outcome(), Some(SILENT));
}

#[test]
fn a_new_world_finds_it_ready_after_the_old_one_fell_silent() {
    let mut bench = Bench::new();
    bench.begin(0);
    bench.idle::<Command>(SILENCE_MS);
    assert_eq!(bench.outcome(), Some(SILENT));
    // Its transfer numbers begin anew.
    bench.world = Bench::new().world;
    bench.begin(50_000);
    assert_eq!(bench.outcome(), None);
}

#[test]
fn the_board_s_milliseconds_may_wrap_in_a_mission() {
    let mut bench = Bench::new();
    bench.begin(u32::MAX - 500);
    assert_eq!(bench.idle::<Command>(700), 0);
    assert_eq!(bench.outcome(), None);
    bench.idle::<Command>(1_499);
    assert_eq!(bench.outcome(), Some(SILENT));
}
