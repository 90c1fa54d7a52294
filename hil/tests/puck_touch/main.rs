//! Promise: the mission needs no change for the real arm. The controller runs through Barrett's puck protocol on a classic
//! CAN bus of 1 Mbit/s with exact bit times, against pucks whose robot is as simple as can be.

mod robot;

use robot::{Feels, Robot};
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::limits::{HAND_MOTORS, SILENCE_TICKS_MAX, TICK_US};
use tactus_common::message::{EventKind, FaultReason, Outcome, Phase, PlanAnswer, RolloutResult};
use tactus_common::puck::property::motor;
use tactus_common::puck::{Address, Command, Group, Node};
use tactus_common::reading::HandCommand;
use tactus_controller::controller::{Controller, Inputs};
use tactus_controller::puck_driver::startup::{StartState, Startup};
use tactus_controller::puck_driver::{Calibration, PuckDriver, PuckStats};
use tactus_controller::testing::{BOX, TRUTH, plan, rollout, setup};
use tactus_hil::bit_time::{BitRates, IdBits, wire_bits, wire_bits_worst};
use tactus_hil::bus::Bus;
use tactus_hil::puck_responder::PuckResponder;
use tactus_hil::virtual_bus::{VirtualBus, VirtualBusConfig};

/// Endpoints of the bus.
const HOST: usize = 0;
const ROBOT: usize = 1;
const TICK_NS: u64 = TICK_US as u64 * 1_000;
/// How often the nodes look at the bus, nanoseconds: a puck answers within this.
const LOOK_NS: u64 = 10_000;
/// Time for answers, nanoseconds from the beginning of the tick; then the controller goes on with what there is.
const ANSWERS_NS: u64 = 1_500_000;
/// What the wire carried, and when.
#[derive(Clone, Copy, Debug, Default)]
struct Load {
    /// Busy time of the busiest tick, nanoseconds: with positions of the hand, with gauges, with gauges and a pad.
    busiest_ns: [u64; 3],
    /// Latest time within a tick at which all answers were there.
    answered_ns: u64,
    /// Latest time within a tick at which the controller's torques had arrived.
    torques_ns: u64,
}

/// Which of the pucks' frames never arrive.
type Loses = Box<dyn FnMut(&CanFrame) -> bool>;

/// Controller, driver, bus, pucks, robot.
struct Rig {
    controller: Controller,
    driver: PuckDriver,
    bus: VirtualBus,
    pucks: PuckResponder,
    robot: Robot,
    tick: u32,
    plan: Option<PlanAnswer>,
    rollout: Option<RolloutResult>,
    events: Vec<EventKind>,
    load: Load,
    images: usize,
    loses: Loses,
}

fn post(bus: &mut VirtualBus, from: usize, frames: impl IntoIterator<Item = CanFrame>) {
    frames.into_iter().for_each(|frame| bus.endpoint(from).send(frame).expect("the queue is never full"));
}

impl Rig {
    /// Started as the real robot is, with a mission.
    fn new(feels: Feels) -> Self {
        let bus = VirtualBus::new(2, VirtualBusConfig::CLASSIC);
        let mut rig = Self {
            controller: Controller::default(),
            driver: PuckDriver::new(Calibration::default()),
            bus,
            pucks: PuckResponder::default(),
            robot: Robot::new(feels),
            tick: 0,
            plan: None,
            rollout: None,
            events: Vec::new(),
            load: Load::default(),
            images: 0,
            loses: Box::new(|_| false),
        };
        rig.start();
        rig
    }

    fn start(&mut self) {
        let mut startup = Startup::default();
        for tick in 1..1_000 {
            let mut sent = Vec::new();
            startup.tick(&mut |frame| sent.push(frame));
            post(&mut self.bus, HOST, sent);
            for look in 0..TICK_NS / LOOK_NS {
                self.bus.advance_to(tick * TICK_NS + look * LOOK_NS);
                self.answer();
                let mut sent = Vec::new();
                while let Some(received) = self.bus.endpoint(HOST).receive() {
                    startup.receive(&received.frame, &mut |frame| sent.push(frame));
                }
                post(&mut self.bus, HOST, sent);
            }
            if let StartState::Ready(calibration) = startup.state() {
                // The first tick of the mission is the next one of the bus.
                self.driver = PuckDriver::new(calibration);
                self.tick = tick as u32 + 1;
                return;
            }
        }
        panic!("{:?}", startup.state());
    }

    /// The pucks answer what has come.
    fn answer(&mut self) {
        let mut answers = Vec::new();
        while let Some(received) = self.bus.endpoint(ROBOT).receive() {
            self.pucks.receive(&received.frame, &mut |frame| answers.push(frame));
        }
        answers.retain(|frame| !(self.loses)(frame));
        post(&mut self.bus, ROBOT, answers);
    }

    fn tick(&mut self) {
        let start_ns = u64::from(self.tick) * TICK_NS;
        self.bus.advance_to(start_ns);
        let (start_tick, before_ns) = (self.tick, self.bus.stats().busy_ns);
        self.pucks.set_state(self.robot.state());
        let mut sent = Vec::new();
        self.driver.begin(self.tick, &mut |frame| sent.push(frame));
        post(&mut self.bus, HOST, sent.drain(..));
        let mut answered = false;
        for look in 0..TICK_NS / LOOK_NS {
            let now_ns = look * LOOK_NS;
            self.bus.advance_to(start_ns + now_ns);
            while let Some(received) = self.bus.endpoint(HOST).receive() {
                self.driver.receive(&received.frame);
            }
            if !answered && (self.driver.is_complete() || now_ns >= ANSWERS_NS) {
                answered = true;
                self.load.answered_ns = self.load.answered_ns.max(now_ns);
                self.think(&mut sent);
                post(&mut self.bus, HOST, sent.drain(..));
            }
            self.answer_and_time(now_ns);
        }
        self.robot.step(&self.pucks.arm_tau_nm(), &self.pucks.hand());
        self.tick += 1;
        self.bus.advance_to(start_ns + TICK_NS - 1);
        let busy_ns = self.bus.stats().busy_ns - before_ns;
        let kind = [0, 2, 0, 1][start_tick as usize % 4];
        self.load.busiest_ns[kind] = self.load.busiest_ns[kind].max(busy_ns);
    }

    /// As [`Rig::answer`], and notes when torques arrive.
    fn answer_and_time(&mut self, now_ns: u64) {
        let before = self.pucks.value(Node::ARM[6], motor::T);
        self.answer();
        if self.pucks.value(Node::ARM[6], motor::T) != before {
            self.load.torques_ns = self.load.torques_ns.max(now_ns);
        }
    }

    /// The controller's tick, exactly as a node on our own wire gives it to it.
    fn think(&mut self, sent: &mut Vec<CanFrame>) {
        let mission = setup();
        let (plan_answer, rollout_answer) = (self.plan.take(), self.rollout.take());
        let images = self.driver.take_images();
        self.images += images.iter().flatten().count();
        let begins = self.events.is_empty() && self.controller.phase() == Phase::Initialise;
        let inputs = Inputs {
            setup: begins.then_some(&mission),
            readings: self.driver.readings(),
            images,
            links: None,
            plan: plan_answer.as_ref(),
            rollout: rollout_answer.as_ref(),
        };
        let out = self.controller.tick(self.tick, &inputs);
        if let Some(request) = &out.plan_request {
            self.plan = Some(PlanAnswer { effective: 0, request: request.request, result: plan(request, &BOX) });
        }
        if let Some(request) = &out.rollout_request {
            self.rollout = Some(rollout(request, &BOX, 0));
        }
        self.events.extend(out.events.iter().map(|event| event.kind));
        self.driver.command(&out.commands, &mut |frame| sent.push(frame));
    }

    fn until(&mut self, what: &str, ticks_max: u32, done: impl Fn(&Self) -> bool) {
        for _ in 0..ticks_max {
            if done(self) {
                return;
            }
            self.tick();
        }
        panic!("{what}: {:?} {:?} {:?}", self.controller.phase(), self.controller.outcome(), self.events);
    }

    /// The first contact of a closing finger: which, and at which inner angle.
    fn contact(&self) -> Option<(usize, f32)> {
        self.events.iter().find_map(|event| match event {
            EventKind::Contact { finger, inner_rad, descending: false } => Some((usize::from(*finger), *inner_rad)),
            _ => None,
        })
    }

    /// Do the pucks make no torque and stand idle?
    fn is_limp(&self) -> bool {
        self.pucks.arm_tau_nm().iter().all(|tau| tau.abs() < 1e-6)
            && self.pucks.hand() == [HandCommand::Idle; HAND_MOTORS]
    }
}

fn touches_through_pucks(feels: Feels) {
    let mut rig = Rig::new(feels);
    rig.until("first trial", 3_000, |rig| rig.controller.phase() == Phase::Trial);
    rig.until("first contact", 20_000, |rig| rig.contact().is_some());
    // What was felt is there: this finger is at the box, and it was felt within a few ticks of 0.7 mrad each.
    let (finger, inner_rad) = rig.contact().expect("just seen");
    assert!(rig.robot.felt.fingers[finger], "{finger} feels {:?}", rig.robot.felt);
    assert!((rig.robot.inner_q_rad[finger] - inner_rad).abs() < 3e-3, "{inner_rad}");
    rig.until("update", 20_000, |rig| rig.events.contains(&EventKind::Phase(Phase::Update)));
    assert_eq!(rig.controller.outcome(), None);
    assert_eq!(rig.driver.stats(), PuckStats::default(), "nothing was lost, nothing strange came");
    assert!(rig.images > 100, "the pads came too: {}", rig.images);
}

#[test]
fn a_touch_runs_through_pucks_and_is_felt_by_the_gauges() {
    touches_through_pucks(Feels::Gauges);
}

#[test]
fn a_touch_runs_through_pucks_and_is_felt_by_motor_and_second_encoder_alone() {
    touches_through_pucks(Feels::Bend);
}

#[test]
fn a_whole_mission_runs_through_pucks_and_every_answer_is_in_time() {
    let mut rig = Rig::new(Feels::Gauges);
    rig.until("end", 60_000, |rig| rig.controller.outcome().is_some());
    assert_eq!(rig.controller.outcome(), Some(Outcome::Transported), "{:?}", rig.events);
    let object = rig.robot.object.expect("there");
    let stats = rig.bus.stats();
    println!("{} ticks, box at {object:?}", rig.tick);
    println!("{:?}, mean load {:.3}", rig.load, stats.busy_ns as f64 / rig.bus.now_ns() as f64);
    assert!((object.x_m - TRUTH.x_m + 0.5).abs() < 5e-3 && (object.y_m - TRUTH.y_m).abs() < 5e-3, "{object:?}");
    assert_eq!(rig.driver.stats(), PuckStats::default());
    assert_eq!(stats.collisions, 0);
    assert!(rig.load.busiest_ns.iter().all(|ns| *ns <= TICK_NS) && rig.load.answered_ns < ANSWERS_NS);
}

#[test]
fn an_answer_lost_now_and_then_is_bridged() {
    let mut rig = Rig::new(Feels::Gauges);
    let mut told = 0;
    rig.loses = Box::new(move |_| {
        told += 1;
        told % 199 == 0
    });
    rig.until("update", 20_000, |rig| rig.controller.phase() == Phase::Update);
    let stats = rig.driver.stats();
    assert!(rig.contact().is_some() && stats.incomplete_ticks > 50, "{stats:?}");
    assert_eq!((stats.bad, stats.foreign, stats.unasked), (0, 0, 0));
}

#[test]
fn pucks_that_fall_silent_make_the_robot_limp_with_the_reason() {
    let of_hand = |frame: &CanFrame| Address::parse(frame.id()).is_some_and(|a| a.from.hand_motor().is_some());
    let of_m3 = |frame: &CanFrame| Address::parse(frame.id()).is_some_and(|a| a.from == Node::ARM[2]);
    let cases: [(Loses, FaultReason, u32); 3] = [
        (Box::new(|_| true), FaultReason::HostSilent, SILENCE_TICKS_MAX),
        (Box::new(of_m3), FaultReason::SensorInvalid, 4),
        // Of positions and gauges one is due at once, and was told two ticks before.
        (Box::new(of_hand), FaultReason::SensorInvalid, 4),
    ];
    for (loses, reason, ticks) in cases {
        let mut rig = Rig::new(Feels::Gauges);
        rig.until("trial", 3_000, |rig| rig.controller.phase() == Phase::Trial);
        (0..500).for_each(|_| rig.tick());
        assert!(!rig.is_limp());
        rig.loses = loses;
        (1..ticks).for_each(|_| rig.tick());
        assert_eq!(rig.controller.outcome(), None, "{reason:?} too early");
        // The hand's four motors are told within two ticks.
        (0..2).for_each(|_| rig.tick());
        assert_eq!(rig.controller.outcome(), Some(Outcome::Fault(reason)));
        assert!(rig.is_limp(), "{:?} {:?}", rig.pucks.arm_tau_nm(), rig.pucks.hand());
    }
}

#[test]
fn a_flood_of_strange_frames_does_no_harm() {
    let mut rig = Rig::new(Feels::Gauges);
    let mut dice = 1_u64;
    rig.until("trial", 3_000, |rig| rig.controller.phase() == Phase::Trial);
    for _ in 0..500 {
        for _ in 0..30 {
            dice = dice.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let data = dice.to_be_bytes();
            let len = (dice >> 13) as usize % 9;
            // Anything but what a puck of this robot would say, which nobody could tell from a lie.
            let id = (dice >> 40) as u16 & 0x7ff;
            let node = id >> 5 & 0x1f;
            if id & 0x400 == 0 || !(1..=14).contains(&node) {
                rig.driver.receive(&CanFrame::new_base(id, &data[..len], Mtu::Classic).expect("fits"));
            }
            rig.driver.receive(&CanFrame::new((dice >> 20) as u32 & 0x1fff_ffff, &data, Mtu::Classic).expect("fits"));
        }
        rig.tick();
    }
    assert_eq!(rig.controller.outcome(), None);
    assert_eq!(rig.controller.phase(), Phase::Trial);
    let stats = rig.driver.stats();
    assert!(stats.foreign > 10_000 && stats.incomplete_ticks == 0, "{stats:?}");
}

/// Worst length of a puck frame, nanoseconds.
fn worst_ns(data_bytes: usize) -> u64 {
    wire_bits_worst(data_bytes, Mtu::Classic, IdBits::Base).duration_ns(BitRates::M1_5)
}

/// Length of a request, whose bits are always the same, nanoseconds.
fn exact_ns(command: Command) -> u64 {
    wire_bits(&command.frame()).duration_ns(BitRates::M1_5)
}

#[test]
fn a_cycle_fits_its_tick_even_with_the_worst_bit_stuffing() {
    let arm = exact_ns(Command::get(Group::ARM, motor::P)) + 7 * worst_ns(3) + 2 * worst_ns(8);
    let positions = exact_ns(Command::get(Group::HAND, motor::P)) + 4 * worst_ns(6);
    let gauges = exact_ns(Command::get(Group::HAND, motor::SG)) + 4 * worst_ns(4);
    // Two motors of the hand: target (32 bits at most) and mode.
    let orders = 2 * (worst_ns(6) + worst_ns(4));
    let pad = exact_ns(Command::set(Node::HAND[3], motor::TACT, 2)) + 5 * worst_ns(8);
    println!("arm {arm}, positions {positions}, gauges {gauges}, orders {orders}, pad {pad} ns");
    assert!(arm + positions + orders < TICK_NS, "even tick");
    assert!(arm + gauges + orders < TICK_NS, "odd tick");
    // A pad's tail may run into the next tick; it must not run on.
    assert!(arm + gauges + pad + arm + positions + orders < 2 * TICK_NS, "odd tick with a pad, and the next");
}
