//! Promise: the bus has room. Design section 3: CAN FD (1/5 Mbit/s) carries 500 Hz with at most 80 % periodic load in the
//! worst case of bit stuffing; classic CAN (1 Mbit/s) carries 250 Hz in real time.

use tactus_common::can::Mtu;
use tactus_common::limits::{KNOTS_MAX, OBSTACLES_MAX, PAD_CELLS, PADS, PAYLOAD_BYTES_MAX, TICK_US};
use tactus_common::link::{self, SETUP_BYTES, SMALL_BYTES};
use tactus_common::message::{
    Command, Event, EventKind, Heartbeat, Message, Phase, PlanAnswer, PlanRequest, Purpose, RolloutRequest,
    RolloutResult, SensorFrame, Setup, Status, TactileSlice,
};
use tactus_common::method::Method;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::reading::{HandCommand, JointCommands, JointReadings, TactileImage, Validity};
use tactus_common::shape::ObjectShape;
use tactus_common::trajectory::{Knot, Trajectory};
use tactus_hil::bit_time::BitRates;
use tactus_hil::bus_load::{Periodic, transfer_cost, worst_load};

/// Images of one pad, a second.
const PAD_HZ: u32 = 40;

/// Encoded length.
fn bytes<M: Message>(message: &M) -> usize {
    link::encode(message, &mut [0; PAYLOAD_BYTES_MAX]).expect("fits the largest payload").len()
}

fn pose() -> PlanarPose {
    PlanarPose::new(f32::MAX, f32::MAX, f32::MAX)
}

fn sensor_frame() -> SensorFrame {
    SensorFrame::pack(&JointReadings {
        tick: u32::MAX,
        arm_q_rad: [-3.0; 7],
        motor_q_rad: [2.4; 4],
        inner_q_rad: [2.4; 3],
        effort_nm: [-30.0; 4],
        tip_torque_nm: [1.6; 3],
        valid: Validity::ALL,
    })
}

fn command() -> Command {
    Command::pack(&JointCommands { tick: u32::MAX, arm_tau_nm: [-100.0; 7], hand: [HandCommand::Torque(8.0); 4] })
}

fn tactile() -> TactileSlice {
    TactileSlice::pack(&TactileImage { pad: 3, stamp: u32::MAX, pressure_n_cm2: [15.9; PAD_CELLS] }, u32::MAX)
}

fn status() -> Status {
    Status { tick: u32::MAX, phase: Phase::Fault, belief: pose(), covariance: [1.0; 6], evidence: 255, touches: 255 }
}

fn heartbeat() -> Heartbeat {
    Heartbeat { uptime_s: [255; 4], health: 3, mode: 1, vendor: 255 }
}

/// The longest event.
fn event() -> Event {
    let kind = EventKind::Updated {
        belief: pose(),
        covariance: [1.0; 6],
        evaluations: u16::MAX,
        modes: u8::MAX,
        confident: true,
    };
    Event { tick: u32::MAX, kind }
}

fn plan_request() -> PlanRequest {
    PlanRequest {
        request: u16::MAX,
        purpose: Purpose::Retreat,
        touch: u8::MAX,
        start_q_rad: [1.0; 7],
        placement: Default::default(),
        preshape: Default::default(),
        displacement_m: [1.0; 2],
        belief: pose(),
        covariance: [1.0; 6],
    }
}

fn rollout_request() -> RolloutRequest {
    RolloutRequest {
        request: u16::MAX,
        pose: pose(),
        arm_q_rad: [1.0; 7],
        preshape: Default::default(),
        closing_rad_s: [1.0; 3],
        ticks: u16::MAX,
    }
}

fn full_answer() -> PlanAnswer {
    let knot = Knot { t_s: 29.0, q_rad: [3.0; 7], qd_rad_s: [-1.0; 7], qdd_rad_s2: [1.0; 7] };
    let mut trajectory = Trajectory { request: u16::MAX, guarded_from: u8::MAX, ..Trajectory::default() };
    for _ in 0..KNOTS_MAX {
        trajectory.knots.push(knot).expect("a trajectory holds that many knots");
    }
    PlanAnswer { effective: u32::MAX, request: u16::MAX, result: Ok(trajectory) }
}

/// What travels all the time, with a tick of `tick_us`.
fn periodic(tick_us: u32) -> [Periodic; 5] {
    let images = u32::try_from(PADS).expect("few pads") * PAD_HZ;
    [
        Periodic { name: "SensorFrame", payload_bytes: bytes(&sensor_frame()), period_us: tick_us },
        Periodic { name: "Command", payload_bytes: bytes(&command()), period_us: tick_us },
        Periodic { name: "TactileSlice", payload_bytes: bytes(&tactile()), period_us: 1_000_000 / images },
        Periodic { name: "Status", payload_bytes: bytes(&status()), period_us: 100_000 },
        Periodic { name: "Heartbeat", payload_bytes: bytes(&heartbeat()), period_us: 1_000_000 },
    ]
}

/// Prints a table; the whole load.
fn load(title: &str, mtu: Mtu, tick_us: u32) -> f64 {
    let messages = periodic(tick_us);
    println!("{title}");
    for message in &messages {
        let cost = transfer_cost(message.payload_bytes, mtu, BitRates::M1_5);
        println!(
            "  {:<12} {:>4} bytes, {:>2} frames, {:>7.1} us, every {:>7} us: {:>5.1} %",
            message.name,
            message.payload_bytes,
            cost.frames,
            cost.worst_ns as f64 / 1e3,
            message.period_us,
            message.worst_load(mtu, BitRates::M1_5) * 100.0
        );
    }
    let load = worst_load(&messages, mtu, BitRates::M1_5);
    println!("  together {:.1} %", load * 100.0);
    load
}

#[test]
fn messages_of_every_tick_have_the_lengths_that_the_design_counts_with() {
    assert_eq!(bytes(&sensor_frame()), 63);
    assert_eq!(bytes(&command()), 34);
    assert_eq!(bytes(&heartbeat()), 7);
    // The length does not depend on the data.
    let zero = JointReadings {
        tick: 0,
        arm_q_rad: [0.0; 7],
        motor_q_rad: [0.0; 4],
        inner_q_rad: [0.0; 3],
        effort_nm: [0.0; 4],
        tip_torque_nm: [0.0; 3],
        valid: Validity::NONE,
    };
    assert_eq!(bytes(&SensorFrame::pack(&zero)), 63);
    assert_eq!(bytes(&Command::pack(&JointCommands::idle(0))), 34);
    let dark = TactileImage { pad: 0, stamp: 0, pressure_n_cm2: [0.0; PAD_CELLS] };
    assert_eq!(bytes(&TactileSlice::pack(&dark, 0)), bytes(&tactile()));
}

#[test]
fn fd_carries_500_hz_with_at_most_80_percent_load() {
    let load = load("CAN FD 1/5 Mbit/s, 500 Hz, worst stuffing:", Mtu::Fd, TICK_US);
    assert!(load <= 0.80, "{load}");
}

#[test]
fn classic_carries_250_hz_in_real_time() {
    let load = load("Classic CAN 1 Mbit/s, 250 Hz, worst stuffing:", Mtu::Classic, 4_000);
    assert!(load < 1.0, "{load}");
}

#[test]
fn a_burst_of_answers_requests_and_events_is_over_before_the_silence_limit() {
    // A full trajectory, both requests and the eight events of one tick share what the periodic messages leave.
    let free = 1.0 - worst_load(&periodic(TICK_US), Mtu::Fd, BitRates::M1_5);
    let burst = [
        ("PlanAnswer", bytes(&full_answer()), 1),
        ("PlanRequest", bytes(&plan_request()), 1),
        ("RolloutRequest", bytes(&rollout_request()), 1),
        ("Event", bytes(&event()), 8),
    ];
    let mut worst_ms = 0.0;
    for (name, payload_bytes, count) in burst {
        let cost = transfer_cost(payload_bytes, Mtu::Fd, BitRates::M1_5);
        let ms = f64::from(count) * cost.worst_ns as f64 / 1e6;
        println!("  {count} x {name:<15} {payload_bytes:>4} bytes, {:>2} frames, {ms:.2} ms", cost.frames);
        worst_ms += ms;
    }
    println!("  together {:.1} ms beside the periodic messages", worst_ms / free);
    assert!(worst_ms / free < 40.0, "{worst_ms} ms of {free}");
}

#[test]
fn the_longest_messages_fit_their_buffers() {
    let answer = bytes(&full_answer());
    println!("a trajectory of {KNOTS_MAX} knots: {answer} of {PAYLOAD_BYTES_MAX} bytes");
    assert!(answer <= PAYLOAD_BYTES_MAX);
    let widest = f32::MAX;
    let setup = Setup {
        schema_version: [255; 8],
        shape: ObjectShape::Cuboid { half_extents_m: [widest; 3] },
        guess: pose(),
        interval: Interval { x_m: widest, y_m: widest, phi_rad: widest },
        obstacles: [None; OBSTACLES_MAX],
        displacement_m: [widest; 2],
        mass_kg: widest,
        trials_max: 255,
        robot_base: pose(),
        method: Method { evaluations_max: u16::MAX, ..Method::DEFAULT },
    };
    let rollout = RolloutResult {
        effective: u32::MAX,
        request: u16::MAX,
        onset_inner_rad: [Some(widest); 3],
        contacts: [u16::MAX; 16],
    };
    for (name, length, most) in [
        ("Setup", bytes(&setup), SETUP_BYTES),
        ("RolloutResult", bytes(&rollout), SMALL_BYTES),
        ("PlanRequest", bytes(&plan_request()), SMALL_BYTES),
        ("RolloutRequest", bytes(&rollout_request()), SMALL_BYTES),
        ("Status", bytes(&status()), SMALL_BYTES),
        ("Event", bytes(&event()), SMALL_BYTES),
    ] {
        println!("{name}: {length} bytes");
        assert!(length <= most, "{name}: {length}");
    }
}
