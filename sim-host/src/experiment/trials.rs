//! Monte Carlo over seeds: true pose and offset of the guess drawn uniformly, one mission each.

use super::capture::{Captured, Task, carry_out};
use super::conduct::{Conditions, Experiment};
use super::observability::{Ambiguity, Class, Observed};
use super::record::{Record, quantile};
use crate::method::MethodOptions;
use crate::mission::{self, MissionOptions};
use crate::report::summary::MethodUsed;
use crate::scenario::Scenario;
use anyhow::Context;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_hil::choice::name;

/// Draws of a true pose before a scene counts as having no room for its object.
const DRAWS_MAX: u64 = 1_000;
/// Distance from everything else that a true pose must leave, metres.
const ROOM_M: f32 = 0.01;

/// What to carry out.
#[derive(Clone, Debug)]
pub struct TrialsOptions {
    /// The conditions of the missions.
    pub conditions: Conditions,
    /// Missions.
    pub count: u32,
    /// Half widths of the guess's error.
    pub offset: Interval,
    /// How far each mission is carried out.
    pub task: Task,
    /// How the pose is to be found, and with which sensors.
    pub method: MethodOptions,
}

/// One mission's line in the CSV.
#[derive(Serialize, Deserialize, Clone, Debug)]
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
    class: Class,
    ambiguity_x_m: f32,
    ambiguity_y_m: f32,
    ambiguity_phi_rad: f32,
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
    /// `judged`: what became of the last belief, if there was one.
    fn of(options: &MissionOptions, task: Task, captured: &Captured, judged: Option<(Class, Ambiguity)>) -> Self {
        let report = &captured.report;
        let is_located = task == Task::Locate && captured.last().is_some_and(|update| update.confident);
        let (class, ambiguity) = judged.unwrap_or((Class::NotObservable, Ambiguity::default()));
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
            class,
            ambiguity_x_m: ambiguity.x_m,
            ambiguity_y_m: ambiguity.y_m,
            ambiguity_phi_rad: ambiguity.phi_rad,
            goal_position_error_m: report.goal_position_error_m,
            goal_yaw_error_rad: report.goal_yaw_error_rad,
            trials: report.trials,
            evaluations: report.evaluations,
            outcome: if is_located { LOCATED.to_owned() } else { report.outcome_text() },
            digest: report.digest_text().unwrap_or_default(),
            sim_time_s: report.sim_time_s,
            wall_time_s: report.wall_time_s,
        }
    }
}

/// Outcome of a mission that was to locate the object only.
const LOCATED: &str = "located";

/// A mission's line, and what became of its belief after each touch.
#[derive(Serialize, Deserialize, Clone, Debug)]
struct Mission {
    row: Row,
    /// Touches so far, and what the belief was then; whether the evidence told the pose.
    by_touch: Vec<(u32, Class, bool)>,
}

impl Mission {
    fn of(options: &MissionOptions, task: Task, captured: &Captured) -> Self {
        let judged: Vec<(u32, (Class, Ambiguity))> = captured
            .updates
            .iter()
            .map(|update| {
                let observed = Observed::new(&update.evidence, &update.prior);
                (update.touches, observed.judge(&update.after.pose(), &update.truth))
            })
            .collect();
        let row = Row::of(options, task, captured, judged.last().map(|(_, judged)| *judged));
        let by_touch = judged
            .into_iter()
            .map(|(touches, (class, ambiguity))| (touches, class, ambiguity.is_observable()))
            .collect();
        Self { row, by_touch }
    }
}

/// Beliefs after so many touches; missions that needed fewer count as they ended.
#[derive(Serialize, Clone, Copy, Debug, Default)]
struct ByTouch {
    touches: u32,
    located: usize,
    not_observable: usize,
    wrong: usize,
    /// Missions whose evidence does not tell the pose as exactly as a grasp needs it.
    ambiguous: usize,
}

impl ByTouch {
    fn of(missions: &[Mission], touches: u32) -> Self {
        let mut counts = Self { touches, ..Self::default() };
        for mission in missions {
            match mission.by_touch.iter().rfind(|(count, ..)| *count <= touches) {
                Some((_, class, tells)) => {
                    match class {
                        Class::Located => counts.located += 1,
                        Class::NotObservable => counts.not_observable += 1,
                        Class::Wrong => counts.wrong += 1,
                    }
                    counts.ambiguous += usize::from(!tells);
                }
                None => {
                    counts.not_observable += 1;
                    counts.ambiguous += 1;
                }
            }
        }
        counts
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
    /// Beliefs within 1 mm of the truth, whatever their yaw.
    within_1mm: usize,
    /// Missions by what became of their belief.
    located: usize,
    not_observable: usize,
    wrong: usize,
    by_touch: Vec<ByTouch>,
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
        write!(
            f,
            "\n  {} within 1 mm, {} within 2 mm and 1 deg, {} not observable, {} wrong; ambiguous after each touch:",
            self.within_1mm, self.located, self.not_observable, self.wrong
        )?;
        for after in &self.by_touch {
            write!(f, " {}", after.ambiguous)?;
        }
        let expected = [mission::TRANSPORTED, LOCATED];
        for (outcome, count) in self.outcomes.iter().filter(|(o, _)| !expected.contains(&o.as_str())) {
            write!(f, "\n  {count} x {outcome}")?;
        }
        Ok(())
    }
}

impl Statistics {
    fn of(missions: &[Mission]) -> Self {
        let rows: Vec<&Row> = missions.iter().map(|mission| &mission.row).collect();
        let of_class = |class| rows.iter().filter(|row| row.class == class).count();
        let touches_max = rows.iter().map(|row| row.trials).max().unwrap_or(0);
        let n = rows.len() as f64;
        let mut outcomes = BTreeMap::new();
        for row in &rows {
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
            within_1mm: rows.iter().filter(|row| row.position_error_m <= 1e-3).count(),
            located: of_class(Class::Located),
            not_observable: of_class(Class::NotObservable),
            wrong: of_class(Class::Wrong),
            by_touch: (1..=touches_max).map(|touches| ByTouch::of(missions, touches)).collect(),
        }
    }
}

/// The true pose of a seed: uniform over the scene's region, drawn again where the object would not stand free.
///
/// # Errors
/// The region has no room for the object.
pub fn truth_of(scenario: &Scenario, seed: u64) -> anyhow::Result<PlanarPose> {
    let (centre, half_width) = (scenario.trials.centre(), scenario.trials.half_width());
    let draw = |k: u64| {
        let seed = seed ^ (k << 32);
        mission::draw_around(&centre, &half_width, seed, mission::Stream::Truth)
    };
    let found = (0..DRAWS_MAX).map(draw).find(|pose| scenario.stands_free(pose, ROOM_M));
    found.ok_or_else(|| anyhow::anyhow!("trials: no room for the object in the scene's region among its obstacles"))
}

/// The mission of index `i` of a batch.
fn mission_options(options: &TrialsOptions, i: usize) -> anyhow::Result<MissionOptions> {
    let seed = options.conditions.seed(i);
    let truth = truth_of(&options.conditions.scenario, seed)?;
    let guess = mission::guess_around(&truth, &options.offset, seed);
    Ok(options.conditions.mission(i, truth, guess, options.offset, options.method))
}

/// Carries out a batch; the CSV is written in order of seed.
///
/// # Errors
/// A file cannot be written, or a scene cannot be simulated (a defect of the scene, not of a mission).
pub fn run(options: &TrialsOptions, csv: Option<&Path>) -> anyhow::Result<(Statistics, Record)> {
    let settings = json!({
        "count": options.count, "offset": options.offset.to_array(),
        "task": name(&options.task), "method": MethodUsed::of(&options.method),
    });
    let experiment = Experiment::new("trials", &options.conditions, settings, None, csv);
    let missions: Vec<Mission> = experiment.carry_out("missions", options.count as usize, |i| {
        let mission = mission_options(options, i)?;
        let captured = carry_out(&mission, options.task).with_context(|| format!("seed {}", mission.seed))?;
        Ok(Mission::of(&mission, options.task, &captured))
    })?;
    experiment.keep(missions.iter().map(|mission| &mission.row))?;
    let statistics = Statistics::of(&missions);
    let [x_m, y_m, phi_rad] = options.offset.to_array();
    let title = format!(
        "{} missions, guesses off by up to {:.0} mm, {:.0} mm, {:.0} degrees, {} reality",
        options.count,
        x_m * 1e3,
        y_m * 1e3,
        phi_rad.to_degrees(),
        options.conditions.reality.name()
    );
    let record = experiment.record(title).with_summary(&statistics);
    Ok((statistics, record))
}
