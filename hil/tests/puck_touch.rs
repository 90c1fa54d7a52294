//! Promise: the mission needs no change for the real arm. The controller runs through Barrett's puck protocol on a classic
//! CAN bus of 1 Mbit/s with exact bit times, against pucks whose robot is as simple as can be: rigid-body dynamics with
//! damping for the arm, fingers that stop at the box.

use nalgebra::Isometry3;
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::limits::{FINGERS, HAND_MOTORS, SILENCE_TICKS_MAX, TICK_S, TICK_US};
use tactus_common::message::{EventKind, FaultReason, Outcome, Phase, PlanAnswer, RolloutResult};
use tactus_common::pose::PlanarPose;
use tactus_common::puck::property::motor;
use tactus_common::puck::{Address, Command, Group, Node};
use tactus_common::reading::HandCommand;
use tactus_common::robot::arm;
use tactus_common::robot::hand::HandAngles;
use tactus_common::robot::tables::{ARM_DAMPING_NMS_RAD, FINGER_LIMIT, SPREAD_LIMIT};
use tactus_controller::controller::{Controller, Inputs};
use tactus_controller::onset::Felt;
use tactus_controller::puck_driver::startup::{StartState, Startup};
use tactus_controller::puck_driver::{Calibration, PuckDriver, PuckStats};
use tactus_controller::testing::{ArmSim, BOX, TRUTH, cuts, home, plan, rollout, setup};
use tactus_hil::bit_time::{BitRates, IdBits, wire_bits, wire_bits_worst};
use tactus_hil::bus::Bus;
use tactus_hil::puck_responder::{PuckResponder, RobotState};
use tactus_hil::virtual_bus::{VirtualBus, VirtualBusConfig};

/// Endpoints of the bus.
const HOST: usize = 0;
const ROBOT: usize = 1;
const TICK_NS: u64 = TICK_US as u64 * 1_000;
/// How often the nodes look at the bus, nanoseconds: a puck answers within this.
const LOOK_NS: u64 = 10_000;
/// Time for answers, nanoseconds from the beginning of the tick; then the controller goes on with what there is.
const ANSWERS_NS: u64 = 1_500_000;
/// Speed of a finger that moves to a position or pushes, rad/s.
const DRIVE_RAD_S: f32 = 2.0;
/// The object is felt this much before a link would cut into it, radians of the inner link.
const PROBE_RAD: f32 = 1e-3;
/// Torque of a fingertip that touches, newton-metres.
const TOUCH_NM: f32 = 0.2;
/// A motor goes on by this much when its inner link has stopped, radians.
const BEND_RAD: f32 = 2e-3;

/// By what this robot feels.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Feels {
    /// The fingertips' strain gauges; its links do not bend.
    Gauges,
    /// The bend between motor and inner link; its gauges are dead.
    Bend,
}

/// Arm, hand and box.
struct Robot {
    feels: Feels,
    arm: ArmSim,
    motor_q_rad: [f32; HAND_MOTORS],
    inner_q_rad: [f32; FINGERS],
    felt: Felt,
    object: Option<PlanarPose>,
    /// The box in the hand's frame while it is held.
    held: Option<Isometry3<f32>>,
}

impl Robot {
    fn new(feels: Feels) -> Self {
        Self {
            feels,
            arm: ArmSim::at(home()),
            motor_q_rad: [0.0; HAND_MOTORS],
            inner_q_rad: [0.0; FINGERS],
            felt: Felt::default(),
            object: Some(TRUTH),
            held: None,
        }
    }

    fn cuts(&self, inner_rad: [f32; FINGERS]) -> Felt {
        let angles = HandAngles::engaged(inner_rad, self.motor_q_rad[3]);
        self.object.map_or(Felt::default(), |o| cuts(&arm::hand_pose(&self.arm.q_rad), &angles, &o, &BOX))
    }

    /// One tick under these torques and hand commands.
    fn step(&mut self, tau_nm: &[f64; 7], commands: &[HandCommand; HAND_MOTORS]) {
        let mut tau = tau_nm.map(|t| t as f32);
        for (j, tau) in tau.iter_mut().enumerate() {
            *tau -= ARM_DAMPING_NMS_RAD[j] * self.arm.qd_rad_s[j];
        }
        self.arm.step(&tau, if self.held.is_some() { setup().mass_kg } else { 0.0 });
        self.carry(commands);
        if self.held.is_none() {
            (0..HAND_MOTORS).for_each(|m| self.drive(m, commands[m]));
            self.felt = self.cuts(self.inner_q_rad.map(|q| q + PROBE_RAD));
        }
    }

    fn drive(&mut self, m: usize, command: HandCommand) {
        let step = DRIVE_RAD_S * TICK_S;
        let change = match command {
            HandCommand::Idle => 0.0,
            HandCommand::Position(target) => (target - self.motor_q_rad[m]).clamp(-step, step),
            HandCommand::Velocity(speed) => speed * TICK_S,
            HandCommand::Torque(torque) => step.copysign(torque),
        };
        let limit = if m < FINGERS { FINGER_LIMIT } else { SPREAD_LIMIT };
        let motor = (self.motor_q_rad[m] + change).clamp(limit.lower_rad, limit.upper_rad);
        if m >= FINGERS {
            self.motor_q_rad[m] = motor;
            return;
        }
        // A link that bent follows its motor's way back only once that is straight again.
        let mut inner = self.inner_q_rad;
        inner[m] = if change < 0.0 { motor.min(inner[m]) } else { motor.max(inner[m]) };
        let stopped = change > 0.0 && self.cuts(inner).fingers[m];
        if !stopped {
            self.inner_q_rad[m] = inner[m];
            self.motor_q_rad[m] = motor;
        } else if self.feels == Feels::Bend {
            self.motor_q_rad[m] = motor.min(self.inner_q_rad[m] + BEND_RAD);
        }
    }

    /// Fingers on both sides that push hold the box.
    fn carry(&mut self, commands: &[HandCommand; HAND_MOTORS]) {
        let world_from_hand = arm::hand_pose(&self.arm.q_rad);
        let pushes = |f: usize| matches!(commands[f], HandCommand::Torque(t) if t > 0.0) && self.felt.fingers[f];
        match (pushes(2) && (pushes(0) || pushes(1)), self.held, self.object) {
            (true, None, Some(object)) => {
                self.held = Some(world_from_hand.inverse() * object.isometry(BOX.rest_height_m()));
            }
            (true, Some(hand_from_object), _) => {
                let now = world_from_hand * hand_from_object;
                let (_, _, phi_rad) = now.rotation.euler_angles();
                self.object = Some(PlanarPose::new(now.translation.x, now.translation.y, phi_rad));
            }
            _ => self.held = None,
        }
    }

    fn state(&self) -> RobotState {
        let tip = |felt| if felt && self.feels == Feels::Gauges { f64::from(TOUCH_NM) } else { 0.0 };
        RobotState {
            arm_q_rad: self.arm.q_rad.map(f64::from),
            motor_q_rad: self.motor_q_rad.map(f64::from),
            inner_q_rad: self.inner_q_rad.map(f64::from),
            tip_torque_nm: self.felt.fingers.map(tip),
            ..RobotState::default()
        }
    }
}

/// What the wire carried in the busiest ticks.
#[derive(Clone, Copy, Debug, Default)]
struct Load {
    /// Busy time of the busiest tick, nanoseconds.
    busiest_ns: u64,
    /// Frames of that tick.
    busiest_frames: u64,
    /// Latest time within a tick at which all answers were there.
    answered_ns: u64,
    /// Latest time within a tick at which the controller's torques had arrived.
    torques_ns: u64,
}

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
    /// Which of the pucks' frames never arrive.
    loses: Box<dyn FnMut(&CanFrame) -> bool>,
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
        let before = self.bus.stats();
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
        let after = self.bus.stats();
        if after.busy_ns - before.busy_ns > self.load.busiest_ns {
            self.load.busiest_ns = after.busy_ns - before.busy_ns;
            self.load.busiest_frames = after.frames - before.frames;
        }
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
    assert!(rig.load.busiest_ns <= TICK_NS && rig.load.answered_ns < ANSWERS_NS);
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
    let cases: [(Box<dyn FnMut(&CanFrame) -> bool>, FaultReason, u32); 3] = [
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
