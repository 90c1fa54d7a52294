//! Monte Carlo over seeds: true pose and offset of the guess drawn uniformly, one mission each.

use crate::method::MethodOptions;
use crate::mission::{self, MissionOptions, MissionReport};
use crate::report::summary::write_json;
use crate::scenario::Scenario;
use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_4;
use std::fmt;
use std::path::Path;
use tactus_common::pose::{Interval, PlanarPose};

/// Centre and half widths of the true poses: x in [0.0, 0.3] m, y in [-0.2, 0.0] m, phi in [-pi/4, pi/4] rad.
const TRUTH_CENTRE: PlanarPose = PlanarPose::new(0.15, -0.1, 0.0);
const TRUTH_HALF_WIDTH: Interval = Interval { x_m: 0.15, y_m: 0.1, phi_rad: FRAC_PI_4 };

/// What to carry out.
#[derive(Clone, Debug)]
pub struct TrialsOptions {
    /// The scene.
    pub scenario: Scenario,
    /// Seed of the first mission; mission i uses `seed + i`.
    pub seed: u64,
    /// Missions.
    pub count: u32,
    /// Half widths of the guess's error.
    pub offset: Interval,
    /// Most touches a mission.
    pub trials_max: u8,
    /// How the pose is to be found, and with which sensors.
    pub method: MethodOptions,
    /// Missions at a time; 0 = one per processor.
    pub jobs: usize,
    /// No progress bar.
    pub quiet: bool,
}

/// One mission's line in the CSV.
#[derive(Serialize, Clone, Debug)]
struct Row {
    seed: u64,
    true_x_m: f32,
    true_y_m: f32,
    true_phi_rad: f32,
    guess_x_m: f32,
    guess_y_m: f32,
    guess_phi_rad: f32,
    believed_x_m: f32,
    believed_y_m: f32,
    believed_phi_rad: f32,
    sd_x_m: f32,
    sd_y_m: f32,
    sd_phi_rad: f32,
    position_error_m: f32,
    yaw_error_rad: f32,
    confidently_wrong: bool,
    goal_position_error_m: f32,
    goal_yaw_error_rad: f32,
    trials: u32,
    evaluations: u32,
    outcome: String,
    digest: String,
    sim_time_s: f64,
    wall_time_s: f64,
}

impl Row {
    fn of(options: &MissionOptions, report: &MissionReport) -> Self {
        let [true_x_m, true_y_m, true_phi_rad] = options.truth.to_array();
        let [guess_x_m, guess_y_m, guess_phi_rad] = options.guess.to_array();
        let [believed_x_m, believed_y_m, believed_phi_rad] = report.believed.to_array();
        let [sd_x_m, sd_y_m, sd_phi_rad] = report.believed_sd();
        Self {
            seed: options.seed,
            true_x_m,
            true_y_m,
            true_phi_rad,
            guess_x_m,
            guess_y_m,
            guess_phi_rad,
            believed_x_m,
            believed_y_m,
            believed_phi_rad,
            sd_x_m,
            sd_y_m,
            sd_phi_rad,
            position_error_m: report.position_error_m,
            yaw_error_rad: report.yaw_error_rad,
            confidently_wrong: report.confidently_wrong(),
            goal_position_error_m: report.goal_position_error_m,
            goal_yaw_error_rad: report.goal_yaw_error_rad,
            trials: report.trials,
            evaluations: report.evaluations,
            outcome: report.outcome_text(),
            digest: report.digest_text().unwrap_or_default(),
            sim_time_s: report.sim_time_s,
            wall_time_s: report.wall_time_s,
        }
    }
}

/// The statistics of a batch.
#[derive(Serialize, Clone, Debug)]
pub struct Statistics {
    missions: usize,
    transported_share: f64,
    position_error_median_m: f32,
    position_error_p95_m: f32,
    yaw_error_median_rad: f32,
    yaw_error_p95_rad: f32,
    goal_position_error_median_m: f32,
    trials_mean: f64,
    confidently_wrong_share: f64,
    sim_time_mean_s: f64,
    wall_time_mean_s: f64,
    /// Missions by outcome.
    outcomes: BTreeMap<String, usize>,
}

impl fmt::Display for Statistics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} missions: {:.1} % transported; belief error at the grasp median {:.2} mm, {:.2} deg (95 %: {:.2} mm, {:.2} deg); \
             {:.2} touches in the mean; {:.1} % confidently wrong; put down {:.1} mm off in the median; {:.1} s robot time, {:.2} s wall time each",
            self.missions,
            self.transported_share * 100.0,
            self.position_error_median_m * 1e3,
            self.yaw_error_median_rad.to_degrees(),
            self.position_error_p95_m * 1e3,
            self.yaw_error_p95_rad.to_degrees(),
            self.trials_mean,
            self.confidently_wrong_share * 100.0,
            self.goal_position_error_median_m * 1e3,
            self.sim_time_mean_s,
            self.wall_time_mean_s,
        )?;
        for (outcome, count) in self.outcomes.iter().filter(|(o, _)| *o != mission::TRANSPORTED) {
            write!(f, "\n  {count} x {outcome}")?;
        }
        Ok(())
    }
}

/// The `p` quantile of values (0..1), by nearest rank; NaN if there are none.
fn quantile(values: impl Iterator<Item = f32>, p: f32) -> f32 {
    let mut sorted: Vec<f32> = values.filter(|v| v.is_finite()).collect();
    sorted.sort_by(f32::total_cmp);
    let rank = (p * sorted.len() as f32).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(f32::NAN)
}

impl Statistics {
    fn of(rows: &[Row]) -> Self {
        let n = rows.len() as f64;
        let mut outcomes = BTreeMap::new();
        for row in rows {
            *outcomes.entry(row.outcome.clone()).or_insert(0) += 1;
        }
        let share = |count: usize| count as f64 / n;
        Self {
            missions: rows.len(),
            transported_share: share(outcomes.get(mission::TRANSPORTED).copied().unwrap_or(0)),
            position_error_median_m: quantile(rows.iter().map(|r| r.position_error_m), 0.5),
            position_error_p95_m: quantile(rows.iter().map(|r| r.position_error_m), 0.95),
            yaw_error_median_rad: quantile(rows.iter().map(|r| r.yaw_error_rad), 0.5),
            yaw_error_p95_rad: quantile(rows.iter().map(|r| r.yaw_error_rad), 0.95),
            goal_position_error_median_m: quantile(rows.iter().map(|r| r.goal_position_error_m), 0.5),
            trials_mean: rows.iter().map(|r| f64::from(r.trials)).sum::<f64>() / n,
            confidently_wrong_share: share(rows.iter().filter(|r| r.confidently_wrong).count()),
            sim_time_mean_s: rows.iter().map(|r| r.sim_time_s).sum::<f64>() / n,
            wall_time_mean_s: rows.iter().map(|r| r.wall_time_s).sum::<f64>() / n,
            outcomes,
        }
    }

    /// Writes it as JSON to a file, or to standard output for `-`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, path: &Path) -> anyhow::Result<()> {
        write_json(self, path)
    }
}

/// The mission of index `i` of a batch.
fn mission_options(options: &TrialsOptions, i: u32) -> MissionOptions {
    let seed = options.seed.wrapping_add(u64::from(i));
    let truth = mission::draw_around(&TRUTH_CENTRE, &TRUTH_HALF_WIDTH, seed, mission::Stream::Truth);
    MissionOptions {
        scenario: options.scenario.clone(),
        seed,
        truth,
        guess: mission::guess_around(&truth, &options.offset, seed),
        interval: options.offset,
        trials_max: options.trials_max,
        method: options.method,
    }
}

/// Carries out a batch; the CSV is written in order of seed.
///
/// # Errors
/// A file cannot be written, or a scene cannot be simulated (a defect of the scene, not of a mission).
pub fn run(options: &TrialsOptions, csv: Option<&Path>) -> anyhow::Result<Statistics> {
    // Opened before the work: a bad path must not cost an hour.
    let writer =
        csv.map(|p| csv::Writer::from_path(p).with_context(|| format!("--csv {}", p.display()))).transpose()?;
    let bar = if options.quiet { ProgressBar::hidden() } else { ProgressBar::new(u64::from(options.count)) };
    bar.set_style(ProgressStyle::with_template("{bar:40} {pos}/{len} missions, {eta} left")?);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.jobs).build()?;
    let rows: Vec<Row> = pool.install(|| {
        (0..options.count)
            .into_par_iter()
            .map(|i| {
                let mission = mission_options(options, i);
                let report = mission::run(&mission, &mut |_| {}).with_context(|| format!("seed {}", mission.seed))?;
                bar.inc(1);
                Ok(Row::of(&mission, &report))
            })
            .collect::<anyhow::Result<_>>()
    })?;
    bar.finish_and_clear();
    if let Some(mut writer) = writer {
        for row in &rows {
            writer.serialize(row)?;
        }
        writer.flush()?;
    }
    Ok(Statistics::of(&rows))
}
