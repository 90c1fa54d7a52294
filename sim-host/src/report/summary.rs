//! The summary JSON of one mission: a contract with tools outside this repository.

use crate::method::MethodOptions;
use crate::mission::{MissionOptions, MissionReport};
use anyhow::Context;
use serde::Serialize;
use std::path::Path;
use tactus_common::pose::PlanarPose;
use tactus_hil::say;

/// A pose as the summary shows it: metres and radians.
#[derive(Serialize, Clone, Copy, Debug)]
pub struct Pose {
    x: f32,
    y: f32,
    z: f32,
    phi: f32,
}

impl Pose {
    fn new(pose: &PlanarPose, z: f32) -> Self {
        Self { x: pose.x_m, y: pose.y_m, z, phi: pose.phi_rad }
    }
}

/// Bus figures.
#[derive(Serialize, Clone, Copy, Debug)]
pub struct Bus {
    frames: u64,
    load_max: f32,
    lost: u64,
    /// Error frames and frames of others.
    foreign: u64,
    /// Times at which it was down.
    downs: u64,
}

/// Wall time from readings to command, microseconds.
#[derive(Serialize, Clone, Copy, Debug)]
pub struct RoundTrip {
    min: f32,
    median: f32,
    p99: f32,
    max: f32,
}

/// How the pose was found.
#[derive(Serialize, Clone, Debug)]
pub struct MethodUsed {
    error: String,
    optimizer: String,
    predictor: String,
    gradient: String,
    damping: f32,
    instants: u8,
    /// 0 = the method's own default.
    evaluations_max: u16,
    sensors: String,
}

impl MethodUsed {
    /// As it was told.
    pub fn of(options: &MethodOptions) -> Self {
        let method = &options.method;
        Self {
            error: method.error.to_string(),
            optimizer: method.optimizer.to_string(),
            predictor: method.predictor.to_string(),
            gradient: method.gradient.to_string(),
            damping: method.damping,
            instants: method.instants,
            evaluations_max: method.evaluations_max,
            sensors: options.sensors.name().to_owned(),
        }
    }
}

/// The summary of one mission.
#[derive(Serialize, Clone, Debug)]
pub struct Summary {
    outcome: String,
    seed: u64,
    /// `null` if the controller reported no end.
    digest: Option<String>,
    /// Ticks that the digest covers.
    digest_ticks: Option<u32>,
    method: MethodUsed,
    true_pose: Pose,
    guess: Pose,
    believed_pose: Pose,
    /// Standard deviations of the belief that led to the grasp: x, y (metres), phi (radians).
    believed_sd: [f32; 3],
    final_object_pose: Pose,
    goal_pose: Pose,
    position_error_m: f32,
    yaw_error_rad: f32,
    goal_position_error_m: f32,
    goal_yaw_error_rad: f32,
    /// The farthest that any other free body was pushed, metres.
    others_shift_m: f32,
    trials: u32,
    evaluations: u32,
    update_time_s: f64,
    sim_time_s: f64,
    wall_time_s: f64,
    deadline_misses: u32,
    /// Tick at which the drives let go for want of commands.
    released_tick: Option<u32>,
    round_trip_us: RoundTrip,
    bus: Bus,
}

impl Summary {
    /// The summary of a mission.
    pub fn of(options: &MissionOptions, report: &MissionReport) -> Self {
        let z = options.scenario.rest_height_m();
        Self {
            outcome: report.outcome_text(),
            seed: options.seed,
            digest: report.digest_text(),
            digest_ticks: report.digest.map(|d| d.ticks),
            method: MethodUsed::of(&options.method),
            true_pose: Pose::new(&options.truth, z),
            guess: Pose::new(&options.guess, z),
            believed_pose: Pose::new(&report.believed, z),
            believed_sd: report.believed_sd(),
            final_object_pose: Pose::new(&report.final_pose, report.final_z_m),
            goal_pose: Pose::new(&options.scenario.goal(&options.truth), z),
            position_error_m: report.position_error_m,
            yaw_error_rad: report.yaw_error_rad,
            goal_position_error_m: report.goal_position_error_m,
            goal_yaw_error_rad: report.goal_yaw_error_rad,
            others_shift_m: report.others_shift_m,
            trials: report.trials,
            evaluations: report.evaluations,
            update_time_s: report.update_time_s(),
            sim_time_s: report.sim_time_s,
            wall_time_s: report.wall_time_s,
            deadline_misses: report.deadline_misses,
            released_tick: report.released,
            round_trip_us: RoundTrip {
                min: report.answers.min_us,
                median: report.answers.median_us,
                p99: report.answers.p99_us,
                max: report.answers.max_us,
            },
            bus: Bus {
                frames: report.wire.frames,
                load_max: report.wire.load_max,
                lost: report.wire.lost,
                foreign: report.wire.foreign,
                downs: report.wire.downs,
            },
        }
    }

    /// Writes it to a file, or to standard output for `-`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        write_json(self, path)
    }
}

/// Writes `value` as JSON to a file, or to standard output for `-`.
///
/// # Errors
/// The file cannot be written.
pub fn write_json<T: Serialize>(value: &T, path: &Path) -> anyhow::Result<()> {
    let text = serde_json::to_string_pretty(value)?;
    if path.as_os_str() == "-" {
        say::line(text)?;
        return Ok(());
    }
    std::fs::write(path, text + "\n").with_context(|| format!("--summary {}", path.display()))
}
