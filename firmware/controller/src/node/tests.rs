//! Promises of the controller as a node on the bus.

extern crate std;

use super::*;
use crate::testing::{BOX, Bench, home, plan, readings, rollout, setup};
use proptest::prelude::*;
use std::vec::Vec;
use tactus_common::cyphal::NodeId;
use tactus_common::limits::{ARM_JOINTS, PAD_CELLS};
use tactus_common::message::{EventKind, FaultReason, Outcome, RefusalReason};
use tactus_common::reading::{HandCommand, JointReadings, TactileImage};

/// A world at the other end of the wire: sends messages, hears what the node says.
struct World {
    node: Node,
    sender: Sender<6>,
    mtu: Mtu,
    heard: Heard,
    command: Session<SMALL_RX_BYTES>,
    request: Session<SMALL_RX_BYTES>,
    rollout: Session<SMALL_RX_BYTES>,
    event: Session<SMALL_RX_BYTES>,
    heartbeat: Session<SMALL_RX_BYTES>,
    digest: Session<SMALL_RX_BYTES>,
}

/// What the node has said, oldest first.
#[derive(Default)]
struct Heard {
    frames: usize,
    calls: u64,
    commands: Vec<tactus_common::reading::JointCommands>,
    requests: Vec<PlanRequest>,
    rollouts: Vec<RolloutRequest>,
    events: Vec<Event>,
    heartbeats: Vec<Heartbeat>,
    digests: Vec<DigestReport>,
}

fn from_node<M: Message, const BYTES: usize>() -> Session<BYTES> {
    Session::new(subject::<M>(), CONTROLLER, 0)
}

impl World {
    fn new(mtu: Mtu) -> Self {
        Self {
            node: Node::new(mtu),
            sender: sender(WORLD),
            mtu,
            heard: Heard::default(),
            command: from_node::<Command, _>(),
            request: from_node::<PlanRequest, _>(),
            rollout: from_node::<RolloutRequest, _>(),
            event: from_node::<Event, _>(),
            heartbeat: from_node::<Heartbeat, _>(),
            digest: from_node::<DigestReport, _>(),
        }
    }

    /// Frames of a message.
    fn frames<M: Message>(&mut self, message: &M) -> Vec<CanFrame> {
        let mut buffer = [0; PAYLOAD_BYTES_MAX];
        let bytes = link::encode(message, &mut buffer).expect("fits");
        self.raw::<M>(bytes)
    }

    /// Frames of any bytes on a message's subject.
    fn raw<M: Message>(&mut self, bytes: &[u8]) -> Vec<CanFrame> {
        self.sender.send(subject::<M>(), priority::<M>(), bytes, self.mtu).expect("sendable").collect()
    }

    /// Puts frames on the wire; how often the controller ticked.
    fn put(&mut self, frames: &[CanFrame]) -> usize {
        let mut said = Vec::new();
        let ticks = frames.iter().filter(|frame| self.node.receive(frame, &mut |f| said.push(f))).count();
        self.listen(&said);
        ticks
    }

    fn send<M: Message>(&mut self, message: &M) -> usize {
        let frames = self.frames(message);
        self.put(&frames)
    }

    fn sense(&mut self, readings: &JointReadings) -> usize {
        self.send(&SensorFrame::pack(readings))
    }

    /// A tick of a robot that stands still.
    fn stand(&mut self, tick: u32) -> usize {
        self.sense(&readings(tick, home()))
    }

    fn stand_for(&mut self, ticks: impl Iterator<Item = u32>) {
        for tick in ticks {
            self.stand(tick);
        }
    }

    fn silence(&mut self) {
        let mut said = Vec::new();
        self.node.silent_tick(&mut |f| said.push(f));
        self.listen(&said);
    }

    fn listen(&mut self, frames: &[CanFrame]) {
        self.heard.calls += 1;
        for frame in frames {
            assert_eq!(frame.mtu(), self.node.mtu);
            let header = Header::parse(frame.id()).expect("our own");
            let (data, heard) = (frame.data(), &mut self.heard);
            // A new time for every call: with timeout 0, every transfer number is new then.
            let now = heard.calls;
            macro_rules! hear {
                ($session:ident, $type:ty, $list:ident, $make:expr) => {
                    if let Ok(Some(t)) = self.$session.accept(&header, data, now) {
                        heard.$list.push($make(link::decode::<$type>(t.payload).expect("decodes")));
                    }
                };
            }
            hear!(command, Command, commands, |c: Command| c.unpack().expect("known modes"));
            hear!(request, PlanRequest, requests, |m| m);
            hear!(rollout, RolloutRequest, rollouts, |m| m);
            hear!(event, Event, events, |m| m);
            hear!(heartbeat, Heartbeat, heartbeats, |m| m);
            hear!(digest, DigestReport, digests, |m| m);
        }
        self.heard.frames += frames.len();
    }
}

fn sender(source: NodeId) -> Sender<6> {
    Sender::new(
        source,
        [
            subject::<Setup>(),
            subject::<SensorFrame>(),
            subject::<TactileSlice>(),
            subject::<PlanAnswer>(),
            subject::<RolloutResult>(),
            subject::<Heartbeat>(),
        ],
    )
}

fn image(pad: u8, stamp: u32) -> TactileImage {
    TactileImage { pad, stamp, pressure_n_cm2: [0.25; PAD_CELLS] }
}

#[test]
fn in_both_frame_formats_every_sensor_message_is_answered_by_the_command_of_its_tick() {
    for mtu in Mtu::ALL {
        let mut world = World::new(mtu);
        for tick in 0..100 {
            assert_eq!(world.stand(tick), 1, "{mtu:?} tick {tick}");
        }
        let ticks: Vec<u32> = world.heard.commands.iter().map(|c| c.tick).collect();
        assert!(ticks.iter().copied().eq(0..100), "{mtu:?} {ticks:?}");
        assert_eq!(world.node.stats(), NodeStats::default());
    }
}

#[test]
fn who_has_the_command_of_a_tick_has_all_that_the_tick_brought() {
    for mtu in Mtu::ALL {
        let mut world = World::new(mtu);
        world.send(&setup());
        let mut more = 0;
        for tick in 0..=500 {
            let mut said = Vec::new();
            for frame in world.frames(&SensorFrame::pack(&readings(tick, home()))) {
                world.node.receive(&frame, &mut |frame| said.push(frame));
            }
            let is_command = |frame: &CanFrame| Header::of(frame).expect("ours").subject == subject::<Command>();
            let first = said.iter().position(is_command).expect("a command");
            assert!(said[first..].iter().all(is_command), "tick {tick}: {said:?}");
            more += first;
        }
        assert!(more > 10, "status (each 50 ticks), events and heartbeats were among it: {more}");
    }
}

#[test]
fn a_node_understands_frames_of_the_format_that_it_does_not_send() {
    for (own, other) in [(Mtu::Fd, Mtu::Classic), (Mtu::Classic, Mtu::Fd)] {
        let mut world = World::new(own);
        world.mtu = other;
        world.send(&setup());
        assert_eq!(world.stand(0), 1);
        assert_eq!(world.heard.commands.len(), 1);
    }
}

#[test]
fn a_sensor_frame_that_comes_twice_or_late_is_not_taken_for_new() {
    for mtu in Mtu::ALL {
        let mut world = World::new(mtu);
        let first = world.frames(&SensorFrame::pack(&readings(5, home())));
        assert_eq!(world.put(&first), 1);
        assert_eq!(world.put(&first), 0, "the same transfer again");
        assert_eq!(world.stand(5), 0, "the same tick in a new transfer");
        assert_eq!(world.stand(4), 0, "an older tick in a new transfer");
        assert_eq!(world.node.stats().late, 2);
        assert_eq!(world.put(&first), 0, "the first transfer, behind newer ones");
        assert_eq!(world.stand(6), 1);
        let answered: Vec<u32> = world.heard.commands.iter().map(|c| c.tick).collect();
        assert_eq!(answered, [5, 5, 6], "who asks about the last tick again hears the same answer again");
        assert_eq!(world.heard.commands[0], world.heard.commands[1]);
    }
}

#[test]
fn what_names_a_tick_of_no_mission_under_way_is_counted_and_dropped() {
    let mut world = World::new(Mtu::Fd);
    world.send(&setup());
    world.stand_for(0..10);
    let before = world.node.digest();
    assert_eq!(world.stand(70_000), 0);
    world.send(&TactileSlice::pack(&image(0, 0), 1 << 31));
    world.send(&PlanAnswer { effective: 5_000, request: 1, result: Err(RefusalReason::NoPath) });
    world.send(&Setup { schema_version: [7; 8], ..setup() });
    let stats = NodeStats { implausible: 4, ..NodeStats::default() };
    assert_eq!((world.node.stats(), world.node.digest()), (stats, before));
    assert_eq!(world.stand(10), 1, "the mission goes on");
}

#[test]
fn a_set_up_of_another_version_whatever_else_it_holds_ends_in_a_fault_that_names_the_version() {
    for length in [8, 10, 60] {
        let mut world = World::new(Mtu::Fd);
        let frames = world.raw::<Setup>(&std::vec![3; length]);
        world.put(&frames);
        world.stand(0);
        assert_eq!(world.node.controller().outcome(), Some(Outcome::Fault(FaultReason::SchemaMismatch)));
        assert_eq!(world.node.foreign_version(), Some(u64::from_le_bytes([3; 8])));
        assert!(world.node.is_free());
    }
}

#[test]
fn a_frame_with_the_nodes_own_id_tells_of_a_twin() {
    let mut world = World::new(Mtu::Fd);
    world.sender = sender(CONTROLLER);
    world.stand(0);
    assert_eq!(world.node.stats(), NodeStats { twins: 1, ..NodeStats::default() });
}

#[test]
fn a_node_without_a_mission_says_that_it_is_there_and_in_which_version() {
    let mut said = Vec::new();
    Node::new(Mtu::Classic).announce(7, &mut |frame| said.push(frame));
    let subjects: Vec<_> = said.iter().map(|f| Header::of(f).expect("ours").subject).collect();
    assert_eq!(subjects[0], subject::<Heartbeat>());
    assert!(subjects[1..].iter().all(|s| *s == subject::<Hello>()) && said.len() > 1);
    assert_eq!(said[0].data()[..4], 7_u32.to_le_bytes());
}

#[test]
fn what_another_node_says_on_our_subjects_is_passed_over() {
    let mut world = World::new(Mtu::Fd);
    world.sender = sender(NodeId::new(77).unwrap());
    assert_eq!(world.send(&setup()) + world.stand(0), 0);
    assert_eq!((world.node.stats(), world.heard.frames), (NodeStats::default(), 0));
}

#[test]
fn identifiers_that_are_no_message_are_counted_as_foreign() {
    let mut world = World::new(Mtu::Fd);
    // Bit 25: a service.
    let service = CanFrame::new(1 << 25, &[0xe0], Mtu::Fd).expect("a frame");
    assert_eq!(world.put(&[service]), 0);
    assert_eq!(world.node.stats(), NodeStats { foreign_frames: 1, ..NodeStats::default() });
}

#[test]
fn payloads_that_do_not_decode_are_counted_and_harm_nothing() {
    let mut world = World::new(Mtu::Fd);
    let bad: [Vec<CanFrame>; 6] = [
        world.raw::<SensorFrame>(&[0; 20]),
        world.raw::<Setup>(&[0xff; 7]),
        world.raw::<PlanAnswer>(&[0xff; 40]),
        world.raw::<RolloutResult>(&[0, 0, 7]),
        world.raw::<TactileSlice>(&[1, 2, 3]),
        world.frames(&TactileSlice::pack(&image(9, 0), 0)),
    ];
    for (i, frames) in bad.iter().enumerate() {
        assert_eq!(world.put(frames), 0);
        assert_eq!(world.node.stats().bad_payloads, i as u32 + 1);
    }
    assert_eq!(world.stand(0), 1);
    assert_eq!(world.node.controller().phase(), Phase::Initialise);
}

#[test]
fn damaged_transfers_are_counted_frame_by_frame() {
    let mut world = World::new(Mtu::Classic);
    let mut frames = world.frames(&SensorFrame::pack(&readings(0, home())));
    frames.remove(3);
    assert_eq!(world.put(&frames), 0);
    assert!(world.node.stats().bad_frames > 0);
    assert_eq!(world.stand(1), 1, "the next one is whole");
}

#[test]
fn what_takes_effect_later_waits_for_its_tick() {
    let mut world = World::new(Mtu::Fd);
    world.stand(0);
    world.send(&TactileSlice::pack(&image(2, 0), 3));
    world.send(&RolloutResult { effective: 4, request: 1, onset_inner_rad: [None; 3], contacts: [0; 16] });
    world.send(&PlanAnswer { effective: 5, request: 1, result: Err(RefusalReason::NoPath) });
    for tick in 1..8 {
        let p = &world.node.pending;
        let waits = (p.images[2].is_some(), p.rollout.is_some(), p.plan.is_some());
        assert_eq!(waits, (tick <= 3, tick <= 4, tick <= 5), "before tick {tick}");
        world.stand(tick);
    }
    assert_eq!(world.node.stats().late, 0);
}

#[test]
fn what_comes_after_its_tick_is_used_and_counted_as_late() {
    let mut world = World::new(Mtu::Fd);
    world.stand(10);
    world.send(&TactileSlice::pack(&image(0, 9), 10));
    world.send(&PlanAnswer { effective: 3, request: 1, result: Err(RefusalReason::NoPath) });
    world.stand(11);
    assert_eq!(world.node.stats().late, 2);
    assert!(world.node.pending.plan.is_none() && world.node.pending.images[0].is_none());
}

#[test]
fn a_plan_begins_the_touch_at_the_very_tick_at_which_it_takes_effect() {
    let mut world = World::new(Mtu::Fd);
    world.send(&setup());
    let mut tick = 0;
    while world.heard.requests.is_empty() {
        assert_eq!(world.stand(tick), 1);
        tick += 1;
        assert!(tick < 1_000);
    }
    let request = world.heard.requests[0];
    let effective = tick + 25;
    world.send(&PlanAnswer { effective, request: request.request, result: plan(&request, &BOX) });
    for tick in tick..tick + 50 {
        world.stand(tick);
    }
    let began = world.heard.events.iter().find(|e| e.kind == EventKind::Phase(Phase::Trial));
    assert_eq!(began.map(|e| e.tick), Some(effective));
}

/// Digest after a few ticks with one of everything; `change` may alter what is sent.
fn digest(mtu: Mtu, change: impl Fn(&mut Vec<Vec<u8>>)) -> Digest {
    fn bytes<M: Message>(message: &M) -> Vec<u8> {
        let mut buffer = [0; PAYLOAD_BYTES_MAX];
        link::encode(message, &mut buffer).expect("fits").to_vec()
    }
    let mut payloads = Vec::from([
        bytes(&setup()),
        bytes(&TactileSlice::pack(&image(1, 0), 0)),
        bytes(&PlanAnswer { effective: 0, request: 9, result: Err(RefusalReason::NoPath) }),
        bytes(&RolloutResult { effective: 0, request: 9, onset_inner_rad: [Some(0.5), None, None], contacts: [3; 16] }),
        bytes(&SensorFrame::pack(&readings(1, home()))),
        bytes(&SensorFrame::pack(&readings(2, home()))),
    ]);
    change(&mut payloads);
    let mut world = World::new(mtu);
    for (i, payload) in payloads.iter().enumerate() {
        let frames = match i {
            0 => world.raw::<Setup>(payload),
            1 => world.raw::<TactileSlice>(payload),
            2 => world.raw::<PlanAnswer>(payload),
            3 => world.raw::<RolloutResult>(payload),
            _ => world.raw::<SensorFrame>(payload),
        };
        world.put(&frames);
    }
    world.node.digest()
}

#[test]
fn the_digest_does_not_depend_on_the_frame_format_nor_on_what_came_before_the_mission() {
    assert_eq!(digest(Mtu::Fd, |_| ()), digest(Mtu::Classic, |_| ()));
    let run = |world: &mut World| {
        world.send(&setup());
        world.stand_for(0..300);
        world.node.digest()
    };
    let fresh = run(&mut World::new(Mtu::Fd));
    let mut used = World::new(Mtu::Fd);
    (0..5).for_each(|_| used.silence());
    used.stand_for(0..700);
    assert_eq!(run(&mut used), fresh, "after a run without a mission");
    // A world that was started anew: its transfer numbers begin at 0 again.
    used.sender = sender(WORLD);
    (0..600).for_each(|_| used.silence());
    assert_eq!(run(&mut used), fresh, "after a mission");
}

#[test]
fn a_world_that_starts_anew_is_followed_from_its_first_tick() {
    let mut world = World::new(Mtu::Fd);
    world.send(&setup());
    world.stand_for(0..1_000);
    world.sender = sender(WORLD);
    world.send(&setup());
    for tick in 0..100 {
        assert_eq!(world.stand(tick), 1, "tick {tick}");
    }
}

#[test]
fn twenty_silent_ticks_end_in_commands_without_torque_and_a_digest_report() {
    let mut world = World::new(Mtu::Fd);
    world.send(&setup());
    world.stand_for(0..10);
    (0..20).for_each(|_| world.silence());
    let last = world.heard.commands.last().expect("commands go on");
    assert_eq!((last.tick, last.arm_tau_nm, last.hand), (29, [0.0; ARM_JOINTS], [HandCommand::Idle; 4]));
    assert_eq!(world.heard.digests.len(), 1);
    assert_eq!(world.heard.digests[0].ticks, 10, "ticks with readings");
}

#[test]
fn a_set_up_is_taken_whatever_number_noise_has_left_behind() {
    for number in 0..32 {
        let mut world = World::new(Mtu::Fd);
        let noise = (0..=number).map(|_| world.raw::<Setup>(b"noise")).next_back().expect("at least one");
        assert_eq!(world.put(&noise), 0);
        world.sender = sender(WORLD);
        world.send(&setup());
        world.stand_for(0..3);
        assert_eq!(world.node.controller().phase(), Phase::Plan, "after a transfer with number {number}");
    }
}

#[test]
fn a_heartbeat_tells_once_a_second_how_the_node_is() {
    let mut world = World::new(Mtu::Fd);
    world.send(&Setup { trials_max: 0, ..setup() });
    world.stand_for(0..=1_000);
    let beats = &world.heard.heartbeats;
    assert_eq!(beats.iter().map(|b| u32::from_le_bytes(b.uptime_s)).collect::<Vec<_>>(), [0, 1, 2]);
    assert!(beats.iter().all(|b| b.health == 3 && b.vendor == Phase::Fault as u8), "{beats:?}");
}

#[test]
fn a_whole_mission_over_frames_ends_with_a_report_of_its_digest_that_is_repeated_unchanged() {
    let mut world = World::new(Mtu::Fd);
    let mut bench = Bench::default();
    world.send(&setup());
    let mut ticks = 0;
    while world.heard.digests.is_empty() {
        let (asked, foretold) = (world.heard.requests.len(), world.heard.rollouts.len());
        assert_eq!(world.sense(&bench.readings(ticks)), 1);
        if let Some(request) = world.heard.requests.get(asked).copied() {
            world.send(&PlanAnswer { effective: ticks + 1, request: request.request, result: plan(&request, &BOX) });
        }
        if let Some(request) = world.heard.rollouts.get(foretold).copied() {
            world.send(&rollout(&request, &BOX, ticks + 1));
        }
        let commands = world.heard.commands.pop().expect("one a tick");
        let reference = world.node.controller().reference().expect("there are readings").q_rad;
        bench.step(&reference, &commands.hand);
        ticks += 1;
        assert!(ticks < 120_000, "{:?}", world.node.controller().phase());
    }
    assert_eq!(world.node.controller().outcome(), Some(Outcome::Transported));
    let finished = world.heard.events.iter().filter(|e| e.kind == EventKind::Finished(Outcome::Transported));
    assert_eq!(finished.count(), 1);
    assert_eq!(world.heard.digests[0].digest, world.node.digest().0.to_le_bytes());
    assert_eq!(world.heard.digests[0].ticks, ticks);
    assert_eq!(world.node.stats(), NodeStats::default());
    for tick in ticks..ticks + 100 {
        world.sense(&bench.readings(tick));
    }
    assert_eq!(world.heard.digests, [world.heard.digests[0]; 3], "every 50 ticks");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_changed_byte_of_any_input_changes_the_digest(which in 0_usize..6, at in any::<prop::sample::Index>(), bit in 0_u8..8) {
        // Without the zeros that CAN FD pads, which may end an integer that lost its end: that is the same message.
        let other = digest(Mtu::Classic, |payloads| {
            let at = at.index(payloads[which].len());
            payloads[which][at] ^= 1 << bit;
        });
        prop_assert_ne!(other, digest(Mtu::Classic, |_| ()));
    }

    #[test]
    fn no_frame_whatever_makes_the_node_panic(
        frames in prop::collection::vec((any::<u32>(), prop::collection::vec(any::<u8>(), 0..64), any::<bool>(), 0_u8..6), 0..80),
    ) {
        let mut node = Node::new(Mtu::Fd);
        for (bits, data, fd, kind) in &frames {
            let mtu = if *fd { Mtu::Fd } else { Mtu::Classic };
            let subject = [Setup::SUBJECT, SensorFrame::SUBJECT, TactileSlice::SUBJECT, PlanAnswer::SUBJECT, RolloutResult::SUBJECT];
            // Mostly identifiers that the node listens to.
            let id = match subject.get(usize::from(*kind)) {
                Some(subject) => 1 << 26 | 0b11 << 21 | u32::from(*subject) << 8 | u32::from(WORLD.get()),
                None => bits & tactus_common::can::ID_MAX,
            };
            let len = (0..=data.len()).rev().find(|n| mtu.frame_bytes(*n) == Some(*n)).unwrap_or(0);
            if let Ok(frame) = CanFrame::new(id, &data[..len], mtu) {
                node.receive(&frame, &mut |_| ());
            }
        }
    }
}
