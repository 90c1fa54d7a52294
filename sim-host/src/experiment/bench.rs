//! Benchmarks that print medians; no timed tests.

use crate::world::{Mismatch, Scene, World};
use std::time::Instant;
use tactus_common::limits::TICK_S;
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
    println!("world: {:.1} x real time (median of {} runs of 2 s, one thread, all sensors)", median(speeds.clone()), speeds.len());
}

/// Every bench, one line each.
///
/// # Errors
/// None at present: what cannot be measured says so in its line.
pub fn run() -> anyhow::Result<()> {
    bench_world();
    Ok(())
}
