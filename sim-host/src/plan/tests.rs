//! What the planner promises, checked on the trajectories that it returns.

use super::*;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand_core::Rng;
use rand_pcg::Pcg32;
use std::f32::consts::{FRAC_PI_2, PI};
use tactus_common::pose::PlanarPose;
use tactus_common::robot::hand::HandAngles;
use tactus_common::robot::{inverse, source};

/// Hand frame above the table when the palm's face is 46 mm above the box's top.
const TOUCH_Z_M: f32 = 0.325;
const APPROACH_M: f32 = 0.08;
const HALF_M: [f32; 3] = [0.1, 0.05, 0.1];

fn planner() -> Planner {
    Planner::new(&urdf_rs::read_from_string(source::URDF).unwrap(), PlannerConfig::default()).unwrap()
}

/// Hand pointing straight down, its x axis at `yaw_rad` from the world's.
fn down(x_m: f32, y_m: f32, z_m: f32, yaw_rad: f32) -> Isometry3<f32> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad) * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
    Isometry3::from_parts(Translation3::new(x_m, y_m, z_m), turn)
}

fn open_hand() -> HandAngles {
    HandAngles::engaged([0.3; 3], 0.0)
}

/// A posture high above the middle of the table, hand down.
fn home() -> Joints {
    let pose = down(-0.05, -0.2, 0.5, FRAC_PI_2);
    inverse::solve(&pose, 0.0).unwrap()[0]
}

fn object(pose: PlanarPose) -> ObjectEstimate {
    ObjectEstimate::with_sigma(HALF_M, pose, 0.1, [0.01, 0.01], 0.1)
}

fn touch(start_q_rad: Joints, pose: PlanarPose, hand_yaw_rad: f32) -> PlanQuery {
    PlanQuery {
        request: 5,
        purpose: Purpose::Touch,
        start_q_rad,
        hand_angles: open_hand(),
        goal_world_from_hand: down(pose.x_m, pose.y_m, TOUCH_Z_M, hand_yaw_rad),
        approach_height_m: APPROACH_M,
        object: Some(object(pose)),
        next_world_from_hand: None,
    }
}

struct Random(Pcg32);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, 1))
    }
    fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.0.next_u32() >> 8) as f32 / 16_777_216.0
    }
}

#[test]
#[ignore = "report for people: cargo test -p tactus-sim-host --release plan -- --ignored --nocapture"]
fn report_shares_and_times() {
    let mut planner = planner();
    let mut random = Random::new(3);
    let mut q = home();
    let (mut times, mut durations, mut solved) = (Vec::new(), Vec::new(), 0);
    for _ in 0..200 {
        let pose = PlanarPose::new(random.within(0.0, 0.3), random.within(-0.2, 0.0), random.within(-PI, PI));
        let query = touch(q, pose, random.within(-PI, PI));
        let clock = std::time::Instant::now();
        let answer = planner.plan(&query);
        times.push(clock.elapsed().as_secs_f32() * 1e3);
        match answer {
            Ok(t) => {
                solved += 1;
                durations.push(t.duration());
                let touched = t.sample(99.0).unwrap().q_rad;
                let retreat = PlanQuery { purpose: Purpose::Retreat, start_q_rad: touched, ..query };
                match planner.plan(&retreat) {
                    Ok(t) => q = t.sample(99.0).unwrap().q_rad,
                    Err(e) => println!("retreat: {e} {touched:?} {} pre {:?}", inverse::swivel(&touched), t.knots.iter().map(|k| k.q_rad).collect::<Vec<_>>()),
                }
            }
            Err(e) => println!("{pose:?} {e} {query:?}"),
        }
    }
    times.sort_by(f32::total_cmp);
    durations.sort_by(f32::total_cmp);
    println!("touch: solved {solved}/200, plan ms median {} p90 {} max {}", times[100], times[180], times[199]);
    println!("duration s: median {} max {}", durations[durations.len() / 2], durations[durations.len() - 1]);
}

#[test]
#[ignore]
fn debug_home() {
    let planner = planner();
    let q = home();
    println!("{q:?} {:?}", arm::hand_pose(&q));
    let rules = Rules { table_margin_m: 0.0, self_margin_m: 0.002, object: None, fingers_may_touch: true, carried: None };
    println!("{:?}", planner.scene.hit(&q, &open_hand(), &rules));
    planner.scene.explain(&q, &open_hand(), &rules);
}
