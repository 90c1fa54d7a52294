//! Promise: through the C interface the controller does what it does in Rust, to the bit, over a whole mission; and
//! what a caller can do wrong is answered, not suffered.

use std::ffi::c_void;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use tactus::controller::*;
use tactus::geometry::{TactusBelief, TactusInterval, TactusPose, TactusShape};
use tactus::plan::{TactusKnot, TactusPlanAnswer, TactusRefusal};
use tactus::result::TactusResult;
use tactus::robot::{TactusCommands, TactusHandMode, TactusImage, TactusReadings};
use tactus::rollout::TactusRollout;
use tactus::setup::{TactusEnd, TactusOutcome, TactusPhase, TactusSetup};
use tactus_common::message::{Outcome, PlanAnswer, RolloutResult, Setup};
use tactus_common::reading::{HandCommand, JointReadings};
use tactus_controller::controller::{Controller, Inputs};
use tactus_controller::testing::{BOX, Bench, plan, rollout, setup};

/// A controller as C has it: memory, and a handle into it.
struct FromC {
    _memory: Box<TactusControllerMemory>,
    handle: *mut TactusController,
}

impl FromC {
    fn new() -> Self {
        let mut memory = Box::new(TactusControllerMemory { words: [0; TACTUS_CONTROLLER_WORDS] });
        let mut handle = null_mut();
        let place = (&raw mut *memory).cast::<c_void>();
        // SAFETY: the box is as large as the constant says, and lives as long as the handle.
        let created = unsafe { tactus_controller_create(place, TACTUS_CONTROLLER_SIZE, &mut handle) };
        assert_eq!(created, TactusResult::Ok);
        Self { _memory: memory, handle }
    }

    fn begin(&mut self, setup: &TactusSetup) -> TactusResult {
        // SAFETY: a live handle and a reference.
        unsafe { tactus_controller_begin(self.handle, setup) }
    }

    fn tick(&mut self, now: u32, inputs: &TactusInputs) -> (TactusResult, TactusOutputs) {
        let mut outputs = MaybeUninit::uninit();
        // SAFETY: a live handle; the test's inputs point to live values; outputs are written in every case.
        unsafe {
            let result = tactus_controller_tick(self.handle, now, inputs, outputs.as_mut_ptr());
            (result, outputs.assume_init())
        }
    }

    fn belief(&self) -> Result<TactusBelief, TactusResult> {
        let mut belief = MaybeUninit::uninit();
        // SAFETY: a live handle; the belief is read only if it was written.
        unsafe {
            match tactus_controller_belief(self.handle, belief.as_mut_ptr()) {
                TactusResult::Ok => Ok(belief.assume_init()),
                error => Err(error),
            }
        }
    }
}

fn setup_c(s: &Setup) -> TactusSetup {
    TactusSetup {
        shape: TactusShape { kind: 0, half_extents_m: s.shape.half_extents_m() },
        guess: s.guess.into(),
        interval: TactusInterval { x_m: s.interval.x_m, y_m: s.interval.y_m, phi_rad: s.interval.phi_rad },
        displacement_m: s.displacement_m,
        mass_kg: s.mass_kg,
        trials_max: s.trials_max,
    }
}

fn readings_c(r: &JointReadings) -> TactusReadings {
    TactusReadings {
        arm_q_rad: r.arm_q_rad,
        motor_q_rad: r.motor_q_rad,
        inner_q_rad: r.inner_q_rad,
        effort_nm: r.effort_nm,
        tip_torque_nm: r.tip_torque_nm,
        valid: r.valid.0,
    }
}

const NOTHING: TactusInputs =
    TactusInputs { readings: null(), images: null(), plan: null(), rollout: null(), image_count: 0 };

fn plan_c(answer: &PlanAnswer, knots: &mut Vec<TactusKnot>) -> TactusPlanAnswer {
    let trajectory = answer.result.as_ref().ok();
    *knots = trajectory.map_or(Vec::new(), |t| {
        t.knots
            .iter()
            .map(|k| TactusKnot { t_s: k.t_s, q_rad: k.q_rad, qd_rad_s: k.qd_rad_s, qdd_rad_s2: k.qdd_rad_s2 })
            .collect()
    });
    TactusPlanAnswer {
        knots: knots.as_ptr(),
        knot_count: knots.len() as u16,
        request: answer.request,
        guarded_from: trajectory.map_or(0, |t| t.guarded_from),
        refusal: answer.result.as_ref().err().map_or(TactusRefusal::None, |r| (*r).into()) as u8,
    }
}

fn rollout_c(result: &RolloutResult) -> TactusRollout {
    let mut told = TactusRollout { request: result.request, ..TactusRollout::default() };
    for (finger, onset) in result.onset_inner_rad.iter().enumerate() {
        if let Some(onset_rad) = onset {
            told.onset_inner_rad[finger] = *onset_rad;
            told.touching |= 1 << finger;
        }
    }
    told
}

#[test]
fn a_whole_mission_through_the_c_interface_is_the_mission_in_rust_to_the_bit() {
    let (mut rust, mut c) = (Controller::default(), FromC::new());
    let mut bench = Bench::default();
    let (mut answer, mut foretold) = (None::<PlanAnswer>, None::<RolloutResult>);
    assert_eq!(c.begin(&setup_c(&setup())), TactusResult::Ok);
    let mut phases = Vec::new();
    for tick in 0..120_000 {
        let (begun, readings) = (setup(), bench.readings(tick));
        let inputs = Inputs {
            setup: (tick == 0).then_some(&begun),
            readings: Some(readings),
            plan: answer.as_ref(),
            rollout: foretold.as_ref(),
            ..Inputs::default()
        };
        let said = rust.tick(tick, &inputs);

        let mut knots = Vec::new();
        let readings = readings_c(&readings);
        let answer_c = answer.as_ref().map(|a| plan_c(a, &mut knots));
        let foretold_c = foretold.as_ref().map(rollout_c);
        let inputs = TactusInputs {
            readings: &readings,
            plan: answer_c.as_ref().map_or(null(), |a| a),
            rollout: foretold_c.as_ref().map_or(null(), |r| r),
            ..NOTHING
        };
        let (result, said_c) = c.tick(tick, &inputs);

        assert_eq!(result, TactusResult::Ok, "tick {tick}");
        assert_eq!(said_c.commands.arm_tau_nm, said.commands.arm_tau_nm, "tick {tick}");
        for (told, meant) in said_c.commands.hand.iter().zip(&said.commands.hand) {
            let meant = match *meant {
                HandCommand::Idle => (TactusHandMode::Idle, 0.0),
                HandCommand::Position(q_rad) => (TactusHandMode::Position, q_rad),
                HandCommand::Velocity(qd_rad_s) => (TactusHandMode::Velocity, qd_rad_s),
                HandCommand::Torque(tau_nm) => (TactusHandMode::Torque, tau_nm),
            };
            assert_eq!((told.mode, told.value), meant, "tick {tick}");
        }
        if let Some(r) = &said.plan_request {
            let told = &said_c.plan_request;
            assert_eq!((told.request, told.touch, told.start_q_rad), (r.request, r.touch, r.start_q_rad));
            assert_eq!(told.placement.hand_in_object.phi_rad, r.placement.hand_in_object.phi_rad);
            assert_eq!(told.placement.palm_height_m, r.placement.palm_height_m);
            assert_eq!((told.preshape.inner_rad, told.covariance), (r.preshape.inner_rad, r.covariance));
        }
        assert_eq!(said_c.has_plan_request.then_some(said_c.plan_request), said.plan_request.as_ref().map(Into::into));
        let asked = said_c.has_rollout_request.then_some(said_c.rollout_request);
        assert_eq!(asked, said.rollout_request.as_ref().map(Into::into));
        assert_eq!(said_c.status_due, said.status.is_some());
        let events: Vec<_> = said.events.iter().map(Into::into).collect();
        assert_eq!(&said_c.events[..said_c.event_count as usize], &events[..], "tick {tick}");
        assert_eq!(said_c.phase, rust.phase().into());
        assert_eq!(said_c.outcome, TactusOutcome::from(rust.outcome()));
        let believed = rust.mission().belief().map(TactusBelief::from).ok_or(TactusResult::NotYet);
        assert_eq!(c.belief(), believed, "tick {tick}");
        if phases.last() != Some(&said_c.phase) {
            phases.push(said_c.phase);
        }
        if said_c.outcome.end != TactusEnd::NotYet {
            break;
        }

        answer = said.plan_request.map(|r| PlanAnswer { effective: 0, request: r.request, result: plan(&r, &BOX) });
        foretold = said.rollout_request.map(|r| rollout(&r, &BOX, 0));
        let q_rad = rust.reference().map_or(bench.q_rad, |r| r.q_rad);
        bench.step(&q_rad, &said.commands.hand);
    }
    assert_eq!(rust.outcome(), Some(Outcome::Transported));
    assert_eq!(phases.last(), Some(&TactusPhase::Done), "{phases:?}");
    assert_eq!(TactusOutcome::from(rust.outcome()).end, TactusEnd::Transported);
}

#[test]
fn a_mission_that_makes_no_sense_is_refused_before_it_begins() {
    let mut c = FromC::new();
    let good = setup_c(&setup());
    for bad in [
        TactusSetup { shape: TactusShape { kind: 7, ..good.shape }, ..good },
        TactusSetup { shape: TactusShape { half_extents_m: [0.1, 0.0, 0.1], ..good.shape }, ..good },
        TactusSetup { guess: TactusPose { x_m: f32::NAN, ..good.guess }, ..good },
        TactusSetup { interval: TactusInterval { x_m: -0.1, ..good.interval }, ..good },
        TactusSetup { mass_kg: f32::INFINITY, ..good },
        TactusSetup { trials_max: 0, ..good },
    ] {
        assert_eq!(c.begin(&bad), TactusResult::BadValue, "{bad:?}");
    }
    let readings = readings_c(&Bench::default().readings(0));
    let (result, said) = c.tick(0, &TactusInputs { readings: &readings, ..NOTHING });
    assert_eq!((result, said.phase), (TactusResult::Ok, TactusPhase::Initialise), "no mission has begun");
    assert_eq!(c.belief(), Err(TactusResult::NotYet));
}

#[test]
fn inputs_that_make_no_sense_stop_the_robot_and_leave_the_controller_as_it_was() {
    let mut c = FromC::new();
    assert_eq!(c.begin(&setup_c(&setup())), TactusResult::Ok);
    let readings = readings_c(&Bench::default().readings(0));
    let good = TactusInputs { readings: &readings, ..NOTHING };
    let image = TactusImage { stamp: 0, pressure_n_cm2: [0.0; 24], pad: 4 };
    let knot = TactusKnot::default();
    let answer = TactusPlanAnswer { knots: &knot, knot_count: 1, request: 1, guarded_from: 0, refusal: 0 };
    let too_many = TactusPlanAnswer { knot_count: 49, ..answer };
    let no_knots = TactusPlanAnswer { knots: null(), ..answer };
    let odd_refusal = TactusPlanAnswer { refusal: 8, ..answer };
    for (bad, why) in [
        (TactusInputs { image_count: 5, images: &image, ..good }, TactusResult::BadValue),
        (TactusInputs { image_count: 1, images: &image, ..good }, TactusResult::BadValue),
        (TactusInputs { image_count: 1, ..good }, TactusResult::NullPointer),
        (TactusInputs { plan: &too_many, ..good }, TactusResult::BadValue),
        (TactusInputs { plan: &no_knots, ..good }, TactusResult::NullPointer),
        (TactusInputs { plan: &odd_refusal, ..good }, TactusResult::BadValue),
        (
            TactusInputs { readings: (&raw const readings).cast::<u8>().wrapping_add(1).cast(), ..good },
            TactusResult::Misaligned,
        ),
    ] {
        let (result, said) = c.tick(0, &bad);
        assert_eq!(result, why);
        assert_eq!(said.commands, TactusCommands::default(), "no torque, hand idle");
    }
    let (result, said) = c.tick(0, &good);
    assert_eq!(
        (result, said.phase),
        (TactusResult::Ok, TactusPhase::Plan),
        "the mission begins as if nothing had been"
    );
    assert!(said.commands.arm_tau_nm[1] < -10.0, "the arm is held");
}

#[test]
fn null_pointers_and_memory_without_a_controller_are_answered() {
    let mut c = FromC::new();
    let mut handle = null_mut();
    let mut blank = Box::new(TactusControllerMemory { words: [0; TACTUS_CONTROLLER_WORDS] });
    let place = (&raw mut *blank).cast::<c_void>();
    // SAFETY: NULL is allowed everywhere, and `blank` is as large as a controller.
    unsafe {
        assert_eq!(tactus_controller_create(null_mut(), 1 << 20, &mut handle), TactusResult::NullPointer);
        assert_eq!(tactus_controller_create(place, TACTUS_CONTROLLER_SIZE, null_mut()), TactusResult::NullPointer);
        let one_less = tactus_controller_size() - 1;
        assert_eq!(tactus_controller_create(place, one_less, &mut handle), TactusResult::TooSmall);
        assert!(handle.is_null());
        assert_eq!(tactus_controller_create(place.byte_add(2), 4096, &mut handle), TactusResult::Misaligned);
        assert_eq!(tactus_controller_begin(place.cast(), null()), TactusResult::NotCreated);
        assert_eq!(tactus_controller_begin(null_mut(), null()), TactusResult::NullPointer);
        assert_eq!(tactus_controller_begin(c.handle, null()), TactusResult::NullPointer);
        assert_eq!(tactus_controller_tick(c.handle, 0, &NOTHING, null_mut()), TactusResult::NullPointer);
        let mut outputs = MaybeUninit::<TactusOutputs>::uninit();
        assert_eq!(tactus_controller_tick(c.handle, 0, null(), outputs.as_mut_ptr()), TactusResult::NullPointer);
        assert_eq!(tactus_controller_tick(place.cast(), 0, &NOTHING, outputs.as_mut_ptr()), TactusResult::NotCreated);
        assert_eq!(tactus_controller_phase(c.handle, null_mut()), TactusResult::NullPointer);
        assert_eq!(tactus_controller_outcome(null(), null_mut()), TactusResult::NullPointer);
    }
    assert_eq!(c.tick(0, &NOTHING).0, TactusResult::Ok, "and the one that was created lives");
}

#[test]
fn twenty_ticks_of_silence_make_the_robot_limp() {
    let mut c = FromC::new();
    assert_eq!(c.begin(&setup_c(&setup())), TactusResult::Ok);
    let readings = readings_c(&Bench::default().readings(0));
    c.tick(0, &TactusInputs { readings: &readings, ..NOTHING });
    for tick in 1..=20 {
        let (_, said) = c.tick(tick, &NOTHING);
        assert_eq!(said.phase == TactusPhase::Fault, tick == 20, "tick {tick}");
    }
    assert_eq!(c.tick(21, &NOTHING).1.commands, TactusCommands::default());
}
