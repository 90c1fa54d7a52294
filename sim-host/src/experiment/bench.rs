//! Benchmarks that print medians; no timed tests.

use crate::mental::{Closing, MentalModel, RolloutInput};
use crate::method::MethodOptions;
use crate::mission::{self, MissionOptions, Reality};
use crate::scenario::Scenario;
use crate::world::{HandStart, Mismatch, Scene, World};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::time::Instant;
use tactus_common::limits::TICK_S;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::reading::{HandCommand, JointCommands};

/// The middle of the measured values.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Runs the world with all sensors, hand closing and opening, and prints how much faster than real time it is.
pub fn bench_world() {
    let mut speeds = Vec::new();
    for round in 0..9 {
        let Ok(mut world) = World::new(&Scene::default(), &Mismatch::from_seed(round), round) else {
            println!("world: cannot be built");
            return;
        };
        let ticks = 1000;
        let started = Instant::now();
        for tick in 0..ticks {
            let target = if tick < ticks / 2 { 1.0 } else { 0.2 };
            let mut commands = JointCommands::idle(tick);
            commands.hand = [HandCommand::Position(target); 4];
            commands.arm_tau_nm = [0.0, -10.0, 0.0, 5.0, 0.0, 0.5, 0.0];
            if world.tick(&commands).is_err() {
                println!("world: diverged");
                return;
            }
        }
        speeds.push(f64::from(ticks) * f64::from(TICK_S) / started.elapsed().as_secs_f64());
    }
    println!(
        "world: {:.1} x real time (median of {} runs of 2 s, one thread, all sensors)",
        median(speeds.clone()),
        speeds.len()
    );
}

/// Rolls touches out at several poses and prints what one costs.
pub fn bench_rollout() {
    let Ok(mental) = MentalModel::new() else {
        println!("rollout: no model");
        return;
    };
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f32::consts::PI);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), core::f32::consts::FRAC_PI_2);
    let (mut times_ms, mut ticks) = (Vec::new(), Vec::new());
    for i in 0..51 {
        let shift = i as f32 / 50.0 - 0.5;
        let input = RolloutInput {
            world_from_hand: Isometry3::from_parts(Translation3::new(0.2, -0.1, 0.325), turn * down),
            start: HandStart { inner_rad: [0.6; 3], spread_rad: 0.0 },
            closing: Closing::Together,
            speed_rad_s: [0.5; 3],
            stop_at_rad: 2.0,
            ticks: 300,
            object: PlanarPose::new(0.2, -0.1 + 0.02 * shift, 0.2 * shift),
            half_extents_m: [0.1, 0.05, 0.1],
        };
        let started = Instant::now();
        match mental.rollout(&input) {
            Ok(outcome) => ticks.push(outcome.samples.len() as f64),
            Err(error) => println!("rollout: {error}"),
        }
        times_ms.push(started.elapsed().as_secs_f64() * 1e3);
    }
    println!(
        "rollout: {:.1} ms (median of {}), {:.0} ticks of closing",
        median(times_ms.clone()),
        times_ms.len(),
        median(ticks)
    );
}

/// Carries missions out and prints what one update of the belief costs on the host.
///
/// # Errors
/// A mission could not be simulated.
pub fn bench_update() -> anyhow::Result<()> {
    let mut times_ms = Vec::new();
    for seed in 1..=5 {
        let scenario = Scenario::thesis_box();
        let truth = scenario.true_pose();
        let [x_m, y_m, phi_rad] = mission::DEFAULT_OFFSET;
        let interval = Interval { x_m, y_m, phi_rad };
        let guess = mission::guess_around(&truth, &interval, seed);
        let options = MissionOptions {
            scenario,
            seed,
            truth,
            guess,
            interval,
            trials_max: 8,
            reality: Reality::default(),
            method: MethodOptions::default(),
        };
        let report = mission::run(&options, &mut |_| {})?;
        times_ms.extend(report.update_times_s.iter().map(|t| t * 1e3));
    }
    println!("pose update: {:.2} ms (median of {} updates in 5 missions)", median(times_ms.clone()), times_ms.len());
    Ok(())
}

/// Every bench, one line each.
///
/// # Errors
/// A mission could not be simulated.
pub fn run() -> anyhow::Result<()> {
    bench_world();
    bench_rollout();
    bench_update()
}
