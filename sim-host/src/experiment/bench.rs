//! Benchmarks: rates and medians, no timed tests. What they print, `cargo xtask bench` sets beside other figures.

use crate::mental::{Closing, MentalModel, RolloutInput};
use crate::method::MethodOptions;
use crate::mission::{self, MissionOptions, Reality};
use crate::observer::Nobody;
use crate::scenario::Scenario;
use crate::world::{HandStart, Mismatch, Scene, World};
use anyhow::anyhow;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::time::Instant;
use tactus_common::limits::TICK_S;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::reading::{HandCommand, JointCommands};

/// Ticks of one round of a world.
const WORLD_TICKS: u32 = 1000;
/// Rounds of a world.
const WORLD_ROUNDS: u64 = 9;
/// Rollouts of one round.
const ROLLOUTS: u32 = 51;
/// Rounds of two threads.
const PAIR_ROUNDS: usize = 5;

/// The middle of the measured values.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// How much is done in a second, by one thread and by two that share nothing. Measured in turn, so that what else the
/// machine does bears on both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// By one thread.
    pub one: f64,
    /// By two threads, together.
    pub two: f64,
}

impl Rates {
    /// The fastest of a few rounds, for what else the machine does only adds: `work`, which does `count` things, on what
    /// `prepare` makes of the round's number.
    fn of<T: Send>(
        count: u32,
        prepare: impl Fn(u64) -> anyhow::Result<T>,
        work: impl Fn(&mut T) -> anyhow::Result<()> + Sync,
    ) -> anyhow::Result<Self> {
        let (mut one, mut two) = (0.0_f64, 0.0_f64);
        for round in 0..PAIR_ROUNDS as u64 {
            let mut mine = prepare(round)?;
            let started = Instant::now();
            work(&mut mine)?;
            one = one.max(f64::from(count) / started.elapsed().as_secs_f64());
            let (mut mine, mut other) = (prepare(round)?, prepare(round)?);
            let started = Instant::now();
            std::thread::scope(|scope| {
                let running = scope.spawn(|| work(&mut other));
                work(&mut mine)?;
                running.join().map_err(|_| anyhow!("a thread broke down"))?
            })?;
            two = two.max(f64::from(2 * count) / started.elapsed().as_secs_f64());
        }
        Ok(Self { one, two })
    }

    /// What the second thread brings: 2 at best.
    pub fn gain(&self) -> f64 {
        self.two / self.one
    }
}

/// The world of a seed.
fn world(seed: u64) -> anyhow::Result<World> {
    Ok(World::new(&Scene::default(), &Mismatch::from_seed(seed), seed)?)
}

/// Runs a world with all sensors for [`WORLD_TICKS`], the hand closing and opening.
fn run_world(world: &mut World) -> anyhow::Result<()> {
    for tick in 0..WORLD_TICKS {
        let target = if tick < WORLD_TICKS / 2 { 1.0 } else { 0.2 };
        let mut commands = JointCommands::idle(tick);
        commands.hand = [HandCommand::Position(target); 4];
        commands.arm_tau_nm = [0.0, -10.0, 0.0, 5.0, 0.0, 0.5, 0.0];
        world.tick(&commands)?;
    }
    Ok(())
}

/// World ticks of 2 ms, all sensors, in a second.
///
/// # Errors
/// A world cannot be built or diverges.
pub fn world_ticks() -> anyhow::Result<Rates> {
    Rates::of(WORLD_TICKS, world, run_world)
}

/// Prints and returns how much faster than real time a world is.
fn world_speed() -> anyhow::Result<f64> {
    let mut speeds = Vec::new();
    for round in 0..WORLD_ROUNDS {
        let mut world = world(round)?;
        let started = Instant::now();
        run_world(&mut world)?;
        speeds.push(f64::from(WORLD_TICKS) * f64::from(TICK_S) / started.elapsed().as_secs_f64());
    }
    let (count, speed) = (speeds.len(), median(speeds));
    println!("world: {speed:.1} x real time (median of {count} runs of 2 s, one thread, all sensors)");
    Ok(speed)
}

/// Touch `index` of a round, each at another pose of the object.
fn touch(index: u32) -> RolloutInput {
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f32::consts::PI);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), core::f32::consts::FRAC_PI_2);
    let shift = index as f32 / 50.0 - 0.5;
    RolloutInput {
        world_from_hand: Isometry3::from_parts(Translation3::new(0.2, -0.1, 0.325), turn * down),
        start: HandStart { inner_rad: [0.6; 3], spread_rad: 0.0 },
        closing: Closing::Together,
        speed_rad_s: [0.5; 3],
        stop_at_rad: 2.0,
        ticks: 300,
        object: PlanarPose::new(0.2, -0.1 + 0.02 * shift, 0.2 * shift),
        half_extents_m: [0.1, 0.05, 0.1],
    }
}

/// Mental rollouts of a touch in a second.
///
/// # Errors
/// The model cannot be built, or a rollout diverges.
pub fn rollouts() -> anyhow::Result<Rates> {
    let roll_out = |mental: &mut MentalModel| {
        for index in 0..ROLLOUTS {
            mental.rollout(&touch(index))?;
        }
        Ok(())
    };
    Rates::of(ROLLOUTS, |_| Ok(MentalModel::new()?), roll_out)
}

/// Rolls touches out at several poses; prints and returns what one costs, milliseconds.
fn rollout_ms() -> anyhow::Result<f64> {
    let mental = MentalModel::new()?;
    let (mut times_ms, mut ticks) = (Vec::new(), Vec::new());
    for index in 0..ROLLOUTS {
        let started = Instant::now();
        ticks.push(mental.rollout(&touch(index))?.samples.len() as f64);
        times_ms.push(started.elapsed().as_secs_f64() * 1e3);
    }
    let (count, cost_ms) = (times_ms.len(), median(times_ms));
    println!("rollout: {cost_ms:.1} ms (median of {count}), {:.0} ticks of closing", median(ticks));
    Ok(cost_ms)
}

/// Carries missions out; prints and returns what one update of the belief costs on the host, milliseconds.
fn update_ms() -> anyhow::Result<f64> {
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
        let report = mission::run(&options, &mut Nobody)?;
        times_ms.extend(report.update_times_s.iter().map(|t| t * 1e3));
    }
    let (count, cost_ms) = (times_ms.len(), median(times_ms));
    println!("pose update: {cost_ms:.2} ms (median of {count} updates in 5 missions)");
    Ok(cost_ms)
}

/// What the README quotes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medians {
    /// Simulated time of a world by its wall time.
    pub world_speed: f64,
    /// A mental rollout of a touch, milliseconds.
    pub rollout_ms: f64,
    /// A pose update in a mission, milliseconds.
    pub update_ms: f64,
}

/// What the README quotes, printed one line each and returned.
///
/// # Errors
/// Something could not be simulated.
pub fn medians() -> anyhow::Result<Medians> {
    Ok(Medians { world_speed: world_speed()?, rollout_ms: rollout_ms()?, update_ms: update_ms()? })
}

/// `tactus bench`.
///
/// # Errors
/// As [`medians`].
pub fn run() -> anyhow::Result<()> {
    medians().map(|_| ())
}
