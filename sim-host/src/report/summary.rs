//! The summary JSON of one mission: a contract with tools outside this repository.

use crate::mission::{MissionOptions, MissionReport};
use anyhow::Context;
use serde::Serialize;
use std::path::Path;
use tactus_common::pose::PlanarPose;

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
}

/// The summary of one mission.
#[derive(Serialize, Clone, Debug)]
pub struct Summary {
    outcome: String,
    seed: u64,
    digest: String,
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
    trials: u32,
    evaluations: u32,
    update_time_s: f64,
    sim_time_s: f64,
    wall_time_s: f64,
    deadline_misses: u32,
    bus: Bus,
}

impl Summary {
    /// The summary of a mission.
    pub fn of(options: &MissionOptions, report: &MissionReport) -> Self {
        let z = options.scenario.rest_height_m();
        Self {
            outcome: report.outcome_text(),
            seed: options.seed,
            digest: format!("{:016x}", report.digest),
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
            trials: report.trials,
            evaluations: report.evaluations,
            update_time_s: report.update_time_s(),
            sim_time_s: report.sim_time_s,
            wall_time_s: report.wall_time_s,
            deadline_misses: report.deadline_misses,
            bus: Bus { frames: report.bus_frames, load_max: report.bus_load_max, lost: report.bus_lost },
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
        println!("{text}");
        return Ok(());
    }
    std::fs::write(path, text + "\n").with_context(|| format!("--summary {}", path.display()))
}
