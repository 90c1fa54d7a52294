//! One mission from its options to its report: draws what the seed decides, runs it, judges the end.

use crate::hooks::Hooks;
use crate::host::{Host, HostEnd, Lost};
use crate::method::{MethodOptions, Sensors};
use crate::observer::Observer;
use crate::scenario::Scenario;
use crate::wire::{InProcess, Wire, WireStats};
use crate::world::{Mismatch, World};
use nalgebra::{Isometry3, Matrix2, Vector2, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use std::time::Instant;
use tactus_common::can::Mtu;
use tactus_common::limits::TICK_US;
use tactus_common::message::{DigestReport, FailureReason, Outcome, SCHEMA_VERSION, Setup};
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::shape::ObjectShape;
use tactus_hil::choice::Pace;

/// The outcome of a mission that did its job.
pub const TRANSPORTED: &str = "transported";
/// Half widths of the default guess's error: metres, metres, radians.
pub const DEFAULT_OFFSET: [f32; 3] = [0.05, 0.05, 0.35];
/// How near its goal the object must stand: 15 mm and 5 degrees.
const GOAL_POSITION_M: f32 = 0.015;
const GOAL_YAW_RAD: f32 = 5.0 * std::f32::consts::PI / 180.0;
/// How far it may lean: a box that stands does not lean at all.
const GOAL_TILT_RAD: f32 = 5.0 * std::f32::consts::PI / 180.0;
/// 99 % of a normal distribution in two dimensions lie within this squared Mahalanobis distance.
const CHI_SQUARED_2_99: f32 = 9.21;
/// Truth outside the 99 % region by more than this is "confidently wrong", metres.
const CONFIDENTLY_WRONG_M: f32 = 3e-3;

/// How the simulated reality relates to what the controller and its mental world believe of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Reality {
    /// Friction, masses, sizes and sensors differ by seed, and sensors are noisy.
    #[default]
    Mismatched,
    /// Every number is the nominal one, and no sensor is noisy: to tell errors of a method from those of a model.
    Nominal,
}

impl Reality {
    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mismatched => "mismatched",
            Self::Nominal => "nominal",
        }
    }

    /// Its numbers for a seed, on the scene's scales.
    pub fn mismatch(self, scenario: &Scenario, seed: u64) -> Mismatch {
        match self {
            Self::Mismatched => Mismatch::from_seed(seed).scaled(&scenario.noise, &scenario.mismatch),
            Self::Nominal => Mismatch::none(),
        }
    }
}

/// What to do.
#[derive(Clone, Debug)]
pub struct MissionOptions {
    /// The scene.
    pub scenario: Scenario,
    /// Seed of noise and mismatch.
    pub seed: u64,
    /// Where the object truly stands.
    pub truth: PlanarPose,
    /// What the controller is told.
    pub guess: PlanarPose,
    /// What the controller is told about the guess's error.
    pub interval: Interval,
    /// Most touches.
    pub trials_max: u8,
    /// How reality differs from the model.
    pub reality: Reality,
    /// How the pose is to be found, and with which sensors.
    pub method: MethodOptions,
}

/// What came of it.
#[derive(Clone, Debug)]
pub struct MissionReport {
    /// How the controller says that it ended; `None` if it did not end in time.
    pub outcome: Option<Outcome>,
    /// The controller stopped answering before the end.
    pub lost: Option<Lost>,
    /// Tick at which the drives let go for want of commands.
    pub released: Option<u32>,
    /// Digest of the controller's inputs and outputs, and the ticks it covers; `None` if it reported no end.
    pub digest: Option<DigestReport>,
    /// Belief at the update that led to the grasp (the last one, if none did).
    pub believed: PlanarPose,
    /// Its covariance: xx, xy, xphi, yy, yphi, phiphi.
    pub covariance: [f32; 6],
    /// Distance of the belief from the truth at that moment, metres.
    pub position_error_m: f32,
    /// The same in yaw, radians, modulo the object's symmetry.
    pub yaw_error_rad: f32,
    /// Distance by which the truth lay outside the belief's 99 % region, metres; 0 inside.
    pub outside_99_m: f32,
    /// Where the object stands in the end.
    pub final_pose: PlanarPose,
    /// Height of its frame, metres.
    pub final_z_m: f32,
    /// How far it leans, radians.
    pub final_tilt_rad: f32,
    /// The farthest that any other free body was pushed, metres.
    pub others_shift_m: f32,
    /// Distance from the goal, metres.
    pub goal_position_error_m: f32,
    /// The same in yaw, radians.
    pub goal_yaw_error_rad: f32,
    /// Touches.
    pub trials: u32,
    /// Error evaluations of all updates.
    pub evaluations: u32,
    /// Wall time of the controller's ticks in each update of its belief, seconds.
    pub update_times_s: Vec<f64>,
    /// Robot time, seconds.
    pub sim_time_s: f64,
    /// Wall time, seconds.
    pub wall_time_s: f64,
    /// Wall time of the controller's answers to each tick.
    pub answers: AnswerTimes,
    /// What the wire carried.
    pub wire: WireStats,
    /// Ticks for which no command came.
    pub deadline_misses: u32,
}

/// Wall time from readings to command, microseconds: of the controller alone within this process, of the round trip
/// on a bus outside.
#[derive(Clone, Copy, Debug, Default)]
pub struct AnswerTimes {
    /// Shortest.
    pub min_us: f32,
    /// Median.
    pub median_us: f32,
    /// 99 of 100 are shorter.
    pub p99_us: f32,
    /// Longest.
    pub max_us: f32,
}

impl AnswerTimes {
    fn of(times_us: &[f32]) -> Self {
        let mut sorted = times_us.to_vec();
        sorted.sort_by(f32::total_cmp);
        let at = |share: f32| {
            let last = sorted.len().saturating_sub(1);
            sorted.get((last as f32 * share) as usize).copied().unwrap_or(0.0)
        };
        Self { min_us: at(0.0), median_us: at(0.5), p99_us: at(0.99), max_us: at(1.0) }
    }
}

impl MissionReport {
    /// The digest in hexadecimal digits.
    pub fn digest_text(&self) -> Option<String> {
        self.digest.map(|report| format!("{:016x}", u64::from_le_bytes(report.digest)))
    }

    /// Standard deviations of the belief: x, y (metres), phi (radians).
    pub fn believed_sd(&self) -> [f32; 3] {
        [0, 3, 5].map(|i| libm::sqrtf(self.covariance[i].max(0.0)))
    }

    /// Wall time of all updates, seconds.
    pub fn update_time_s(&self) -> f64 {
        // A sum of no values would be -0.
        self.update_times_s.iter().fold(0.0, |sum, time| sum + time)
    }

    /// Does the object stand at its goal, and did the controller put it there?
    pub fn transported(&self) -> bool {
        self.outcome == Some(Outcome::Transported)
            && self.goal_position_error_m <= GOAL_POSITION_M
            && self.goal_yaw_error_rad <= GOAL_YAW_RAD
            && self.final_tilt_rad <= GOAL_TILT_RAD
    }

    /// Was the truth outside the belief's 99 % region by more than 3 mm?
    pub fn confidently_wrong(&self) -> bool {
        self.outside_99_m > CONFIDENTLY_WRONG_M
    }

    /// "transported", or why not.
    pub fn outcome_text(&self) -> String {
        match self.outcome {
            Some(Outcome::Transported) if self.transported() => TRANSPORTED.to_owned(),
            Some(Outcome::Transported) if self.final_tilt_rad > GOAL_TILT_RAD => "toppled".to_owned(),
            Some(Outcome::Transported) => "misplaced".to_owned(),
            Some(Outcome::Failed(FailureReason::NoPlan(reason))) => format!("no plan: {reason:?}"),
            Some(Outcome::Failed(reason)) => format!("{reason:?}"),
            Some(Outcome::Fault(reason)) => format!("fault: {reason:?}"),
            None if self.lost.is_some() => "controller lost".to_owned(),
            None => "out of time".to_owned(),
        }
    }

    /// 0 done, 3 the task failed, 4 fault.
    pub fn exit_status(&self) -> u8 {
        match self.outcome {
            Some(Outcome::Fault(_)) => 4,
            None if self.lost.is_some() => 4,
            _ if self.transported() => 0,
            _ => 3,
        }
    }
}

/// Independent streams of random numbers of one seed.
#[derive(Clone, Copy, Debug)]
pub enum Stream {
    /// The true pose in a batch.
    Truth = 11,
    /// The guess.
    Guess = 12,
}

/// A pose uniform over `centre +- half width`.
pub fn draw_around(centre: &PlanarPose, half_width: &Interval, seed: u64, stream: Stream) -> PlanarPose {
    let mut rng = Pcg32::seed_from_u64(seed ^ ((stream as u64) << 56));
    // 24 bits fill an f32's mantissa: uniform over [-1, 1).
    let mut unit = || (rng.next_u32() >> 8) as f32 / 8_388_608.0 - 1.0;
    PlanarPose::new(
        centre.x_m + half_width.x_m * unit(),
        centre.y_m + half_width.y_m * unit(),
        centre.phi_rad + half_width.phi_rad * unit(),
    )
}

/// The guess of a seed: truth plus a uniform error.
pub fn guess_around(truth: &PlanarPose, offset: &Interval, seed: u64) -> PlanarPose {
    draw_around(truth, offset, seed, Stream::Guess)
}

/// Yaw of a body, radians.
fn yaw_rad(pose: &Isometry3<f32>) -> f32 {
    let x = pose.rotation * Vector3::x();
    libm::atan2f(x.y, x.x)
}

/// How far a body of this shape leans, radians. However a ball has rolled it does not lean, nor does a capsule about its
/// own axis.
pub fn tilt_rad(shape: &ObjectShape, pose: &Isometry3<f32>) -> f32 {
    match shape {
        ObjectShape::Sphere { .. } => 0.0,
        ObjectShape::Capsule { .. } => libm::asinf((pose.rotation * Vector3::x()).z.clamp(-1.0, 1.0)).abs(),
        ObjectShape::Cuboid { .. } | ObjectShape::Cylinder { .. } | ObjectShape::Convex(_) => {
            libm::acosf((pose.rotation * Vector3::z()).z.clamp(-1.0, 1.0))
        }
    }
}

/// The planar part of a body's pose.
pub fn planar(pose: &Isometry3<f32>) -> PlanarPose {
    PlanarPose::new(pose.translation.x, pose.translation.y, yaw_rad(pose))
}

/// Distance by which `truth` lies outside the 99 % ellipse of (x, y) about `believed`, along the line between them.
fn outside_99_m(believed: &PlanarPose, covariance: &[f32; 6], truth: &PlanarPose) -> f32 {
    let off = Vector2::new(truth.x_m - believed.x_m, truth.y_m - believed.y_m);
    // A component that is known exactly has no variance; 0.1 mm keeps the matrix invertible.
    let floor = 1e-8;
    let c = Matrix2::new(covariance[0] + floor, covariance[1], covariance[1], covariance[3] + floor);
    let Some(inverse) = c.try_inverse() else { return 0.0 };
    let squared = (off.transpose() * inverse * off)[(0, 0)];
    if squared <= CHI_SQUARED_2_99 { 0.0 } else { off.norm() * (1.0 - libm::sqrtf(CHI_SQUARED_2_99 / squared)) }
}

/// Carries out a mission in a world of its own, with the controller in this process.
///
/// # Errors
/// The scene cannot be simulated, or the simulation broke down: never the task's failure, which is a report.
pub fn run(options: &MissionOptions, observer: &mut dyn Observer) -> anyhow::Result<MissionReport> {
    run_hooked(options, observer, Hooks::NONE)
}

/// How the world and its controller are connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Connection {
    /// What makes the ticks come.
    pub pace: Pace,
    /// Format of the frames.
    pub mtu: Mtu,
}

impl Default for Connection {
    fn default() -> Self {
        Self { pace: Pace::Lockstep, mtu: Mtu::Fd }
    }
}

/// [`run`] with someone at the wire.
///
/// # Errors
/// As [`run`].
pub fn run_hooked(
    options: &MissionOptions,
    observer: &mut dyn Observer,
    hooks: Hooks,
) -> anyhow::Result<MissionReport> {
    let connection = Connection::default();
    run_on(options, connection.pace, &mut InProcess::new(connection.mtu, hooks), observer)
}

/// Carries out a mission in a world of its own, with the controller at the other end of `wire`.
///
/// # Errors
/// As [`run`]; or the bus broke down.
pub fn run_on(
    options: &MissionOptions,
    pace: Pace,
    wire: &mut dyn Wire,
    observer: &mut dyn Observer,
) -> anyhow::Result<MissionReport> {
    let started = Instant::now();
    let mut host = prepare(options, pace)?;
    let end = host.run(wire, observer)?;
    Ok(judge(options, &end, &host, started))
}

/// The world and the advisor of a mission that is about to begin.
///
/// # Errors
/// The scene cannot be simulated.
pub fn prepare(options: &MissionOptions, pace: Pace) -> anyhow::Result<Host> {
    let scene = options.scenario.world_scene(&options.truth);
    let mismatch = options.reality.mismatch(&options.scenario, options.seed);
    let model = options.scenario.robot_model()?;
    let world = World::with_model(&model, &scene, &mismatch, options.seed)?;
    let setup = Setup {
        schema_version: SCHEMA_VERSION.to_le_bytes(),
        shape: options.scenario.shape(),
        guess: options.guess,
        interval: options.interval,
        obstacles: options.scenario.obstacles(),
        displacement_m: options.scenario.displacement_m,
        mass_kg: options.scenario.object.mass_kg,
        trials_max: options.trials_max,
        robot_base: options.scenario.robot_base,
        method: options.method.method,
    };
    let host = Host::new(world, setup, pace)?;
    Ok(if options.method.sensors == Sensors::Ideal { host.with_ideal_sensors() } else { host })
}

/// What a mission came to that was prepared at `started`.
pub fn judge(options: &MissionOptions, end: &HostEnd, host: &Host, started: Instant) -> MissionReport {
    let world = host.world();
    let symmetry_rad = host.shape().yaw_symmetry_rad();
    let pose = world.object_pose();
    let final_tilt_rad = tilt_rad(&host.shape(), &pose);
    let final_pose = planar(&pose);
    let goal = options.scenario.goal(&options.truth);
    MissionReport {
        outcome: end.outcome,
        lost: end.lost,
        released: end.released,
        digest: end.digest,
        believed: end.believed,
        covariance: end.covariance,
        position_error_m: end.believed.distance_m(&end.truth_then),
        yaw_error_rad: end.believed.turn_from_rad(&end.truth_then, symmetry_rad).abs(),
        outside_99_m: outside_99_m(&end.believed, &end.covariance, &end.truth_then),
        final_pose,
        final_z_m: pose.translation.z,
        final_tilt_rad,
        others_shift_m: world.others_shift_m(),
        goal_position_error_m: final_pose.distance_m(&goal),
        goal_yaw_error_rad: final_pose.turn_from_rad(&goal, symmetry_rad).abs(),
        trials: end.trials,
        evaluations: end.evaluations,
        update_times_s: end.update_times_s.clone(),
        sim_time_s: f64::from(end.ticks) * f64::from(TICK_US) * 1e-6,
        wall_time_s: started.elapsed().as_secs_f64(),
        answers: AnswerTimes::of(&end.answer_times_us),
        wire: end.wire,
        deadline_misses: end.deadline_misses,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_truth_inside_the_region_is_not_outside_and_one_far_off_is_by_the_difference() {
        let believed = PlanarPose::new(0.2, -0.1, 0.0);
        let covariance = [1e-6, 0.0, 0.0, 1e-6, 0.0, 1e-4];
        assert_eq!(outside_99_m(&believed, &covariance, &PlanarPose::new(0.202, -0.1, 0.0)), 0.0);
        let far = outside_99_m(&believed, &covariance, &PlanarPose::new(0.21, -0.1, 0.0));
        assert!((far - (0.010 - 0.00305)).abs() < 1e-4, "{far}");
    }

    #[test]
    fn a_ball_never_leans_a_capsule_not_about_its_axis_and_a_box_as_its_vertical_does() {
        let turned = |x_rad: f32, y_rad: f32| Isometry3::rotation(Vector3::new(x_rad, y_rad, 0.0));
        let capsule = ObjectShape::Capsule { radius_m: 0.03, half_length_m: 0.05 };
        assert_eq!(tilt_rad(&ObjectShape::Sphere { radius_m: 0.05 }, &turned(1.0, 0.5)), 0.0);
        assert!(tilt_rad(&capsule, &turned(1.0, 0.0)) < 1e-6);
        assert!((tilt_rad(&capsule, &turned(0.0, 0.3)) - 0.3).abs() < 1e-6);
        assert!((tilt_rad(&ObjectShape::THESIS_BOX, &turned(0.3, 0.0)) - 0.3).abs() < 1e-4);
    }

    #[test]
    fn draws_stay_within_their_interval_and_repeat_by_seed() {
        let width = Interval { x_m: 0.05, y_m: 0.02, phi_rad: 0.35 };
        let centre = PlanarPose::new(0.2, -0.1, 0.1);
        for seed in 0..500 {
            let p = guess_around(&centre, &width, seed);
            assert!((p.x_m - 0.2).abs() <= 0.05 && (p.y_m + 0.1).abs() <= 0.02 && (p.phi_rad - 0.1).abs() <= 0.35);
            assert_eq!(p, guess_around(&centre, &width, seed));
        }
    }
}
