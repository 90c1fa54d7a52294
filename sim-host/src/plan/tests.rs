//! What the planner promises, checked on the trajectories that it returns.

mod obstacles;
mod report;
mod witness;

use super::*;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand_core::Rng;
use rand_pcg::Pcg32;
use std::f32::consts::{FRAC_PI_2, PI};
use tactus_common::pose::PlanarPose;
use tactus_common::robot::hand::HandAngles;
use tactus_common::robot::{MOUNT, inverse, source};
use tactus_common::shape::ObjectShape;

/// Hand frame above the table when the palm's face is 46 mm above the box's top.
const TOUCH_Z_M: f32 = 0.325;
const APPROACH_M: f32 = 0.08;
const HALF_M: [f32; 3] = [0.1, 0.05, 0.1];

fn planner() -> Planner {
    Planner::new(&urdf_rs::read_from_string(source::URDF).unwrap(), PlannerConfig::default(), &MOUNT, &[]).unwrap()
}

/// Hand pointing straight down, its x axis at `yaw_rad` from the world's.
fn down(x_m: f32, y_m: f32, z_m: f32, yaw_rad: f32) -> Isometry3<f32> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad)
        * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI);
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
    ObjectEstimate::with_sigma(&ObjectShape::Cuboid { half_extents_m: HALF_M }, pose, 0.1, [0.01, 0.01], 0.1)
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

#[test]
fn a_motion_that_takes_too_many_knots_is_followed_less_closely_within_bounds() {
    let bends = |at: usize| home().map(|q| q + 0.01 * libm::sinf(1.3 * at as f32));
    let curve = Curve::through(&(0..24).map(bends).collect::<Vec<_>>(), 0.01).unwrap();
    let query = touch(home(), PlanarPose::new(0.2, -0.1, 0.3), 0.3);
    let part = |tolerance_rad| {
        let pace = Pace { speed_max: 0.05, velocity_scale: 1.0, acceleration_scale: 1.0, tolerance_rad };
        [Part { curve: curve.clone(), pace }]
    };
    let closest =
        (0..20).map(|k| 1e-6 * f64::from(1 << k)).find(|t| assemble(&query, &part(*t), false, 1.0).is_ok()).unwrap();
    assert!(closest > 1e-6, "the knots suffice for anything");
    for (laxity, planned) in [(2.0, true), (4.0, true), (8.0, false)] {
        let result = timed(&query, &part(closest / laxity), false);
        assert_eq!(result.err(), (!planned).then_some(PlanRefusal::TooManyKnots), "{laxity}");
    }
}

#[test]
fn a_robot_that_stands_elsewhere_moves_its_joints_as_one_at_its_mount() {
    let elsewhere = PlanarPose::new(1.3, 0.4, -2.0);
    let robot = urdf_rs::read_from_string(source::URDF).unwrap();
    let obstacle = Obstacle { shape: ObjectShape::Sphere { radius_m: 0.06 }, pose: PlanarPose::new(-0.05, -0.25, 0.0) };
    let world_from_mount = elsewhere.compose(&MOUNT.inverse());
    let seen = Obstacle { pose: world_from_mount.compose(&obstacle.pose), ..obstacle };
    let at_mount = Planner::new(&robot, PlannerConfig::default(), &MOUNT, &[obstacle]).unwrap();
    let there = Planner::new(&robot, PlannerConfig::default(), &elsewhere, &[seen]).unwrap();
    let query = touch(home(), PlanarPose::new(0.2, -0.1, 0.3), 0.3);
    let expected = at_mount.plan(&query).unwrap();
    let planned = there.plan(&query.seen_from(&world_from_mount)).unwrap();
    let end = |trajectory: &Trajectory| trajectory.knots.last().unwrap().q_rad;
    for (a, b) in end(&planned).iter().zip(end(&expected)) {
        assert!((a - b).abs() < 1e-3, "{planned:?} {expected:?}");
    }
    assert!((planned.duration() - expected.duration()).abs() < 0.05);
    // Told to the wrong robot, the same place is out of reach.
    assert!(there.plan(&query).is_err());
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

/// A transport of the box by -0.5 m in x from the posture at which a grasp ended.
fn transport(grasped_q_rad: Joints, pose: PlanarPose) -> PlanQuery {
    let from = arm::hand_pose(&grasped_q_rad);
    let mut to = from;
    to.translation.vector.x -= 0.5;
    PlanQuery {
        purpose: Purpose::Transport,
        goal_world_from_hand: to,
        approach_height_m: 0.06,
        hand_angles: HandAngles::engaged([0.6; 3], 0.0),
        ..touch(grasped_q_rad, pose, 0.0)
    }
}

/// The posture in which a trajectory ends.
fn end(trajectory: &Trajectory) -> Joints {
    trajectory.sample(f32::MAX).unwrap().q_rad
}

/// Instants of a trajectory, `step_s` apart, the end included.
fn instants(trajectory: &Trajectory, step_s: f32) -> impl Iterator<Item = f32> + use<> {
    let (duration, count) = (trajectory.duration(), (trajectory.duration() / step_s) as u32 + 1);
    (0..=count).map(move |k| duration * k as f32 / count as f32)
}

/// Every 2 ms within the joint limits, and it starts where it should.
fn assert_feasible(trajectory: &Trajectory, start: &Joints) {
    assert_eq!(trajectory.check(&ARM_LIMITS), Ok(()));
    assert_eq!(&trajectory.knots[0].q_rad, start, "starts at the given posture to the bit");
    for t in instants(trajectory, 0.002) {
        let s = trajectory.sample(t).unwrap();
        for (j, limit) in ARM_LIMITS.iter().enumerate() {
            assert!((limit.lower_rad..=limit.upper_rad).contains(&s.q_rad[j]), "J{} at {t}", j + 1);
            assert!(s.qd_rad_s[j].abs() <= limit.velocity_rad_s, "J{} at {t}", j + 1);
        }
    }
}

/// From `from_s` to the end the hand follows the straight line between its poses there, within 1 mm and 0.5 degrees, at most at `speed_m_s`.
fn assert_straight(trajectory: &Trajectory, from_s: f32, speed_m_s: f32) {
    let pose = |t: f32| arm::hand_pose(&trajectory.sample(t).unwrap().q_rad);
    let (a, b) = (pose(from_s), pose(trajectory.duration()));
    let line = (b.translation.vector - a.translation.vector).normalize();
    let mut before = (from_s, a);
    for t in instants(trajectory, 0.01).filter(|t| *t > from_s) {
        let p = pose(t);
        let off = p.translation.vector - a.translation.vector;
        assert!((off - line * off.dot(&line)).norm() < 1e-3, "off the line at {t}");
        assert!(p.rotation.angle_to(&a.rotation) < 0.5_f32.to_radians(), "turned at {t}");
        let speed = (p.translation.vector - before.1.translation.vector).norm() / (t - before.0);
        assert!(speed < 1.02 * speed_m_s, "{speed} m/s at {t}");
        before = (t, p);
    }
}

#[test]
fn two_hundred_random_touches_are_found_free_straight_and_within_limits() {
    let (planner, solids) = (planner(), witness::solids());
    let mut random = Random::new(11);
    let mut q = home();
    let mut solved = 0;
    for _ in 0..200 {
        let pose = PlanarPose::new(random.within(0.0, 0.3), random.within(-0.2, 0.0), random.within(-PI, PI));
        let query = touch(q, pose, random.within(-PI, PI));
        let Ok(t) = planner.plan(&query) else { continue };
        solved += 1;
        assert_feasible(&t, &q);
        let guarded_s = t.guarded_from_s().unwrap();
        let reached = arm::hand_pose(&end(&t));
        assert!((reached.translation.vector - query.goal_world_from_hand.translation.vector).norm() < 1e-4);
        assert!(reached.rotation.angle_to(&query.goal_world_from_hand.rotation) < 1e-3);
        assert_straight(&t, guarded_s, 0.06);
        let estimate = query.object.unwrap();
        let block = estimate.pose.isometry(estimate.z_m);
        let grown: [f32; 3] = core::array::from_fn(|i| HALF_M[i] + estimate.inflation_m[i]);
        for at in instants(&t, 0.04) {
            // An escape upwards may start within the inflation, never within the object.
            let escaping = at < 0.6;
            let half_m = if at >= guarded_s || escaping { HALF_M } else { grown };
            let complaint =
                witness::complaint(&solids, &t.sample(at).unwrap().q_rad, &query.hand_angles, Some((&block, half_m)));
            assert_eq!(complaint, None, "at {at} of {} s, {pose:?}", t.duration());
        }
        // A contact stops the arm somewhere on the line, and not quite on it.
        let stopped =
            t.sample(random.within(guarded_s, t.duration())).unwrap().q_rad.map(|q| q + random.within(-0.01, 0.01));
        let retreat = planner.plan(&PlanQuery { purpose: Purpose::Retreat, start_q_rad: stopped, ..query }).unwrap();
        assert_straight(&retreat, 0.0, 0.25);
        assert_eq!(retreat.guarded_from_s(), None);
        q = end(&retreat);
    }
    assert!(solved >= 196, "{solved} of 200 solved");
}

#[test]
fn a_transport_keeps_the_hand_upright_and_ends_half_a_metre_on() {
    let (planner, solids) = (planner(), witness::solids());
    let mut random = Random::new(12);
    let mut solved = 0;
    for _ in 0..40 {
        let pose = PlanarPose::new(random.within(0.0, 0.3), random.within(-0.2, 0.0), random.within(-0.78, 0.78));
        let mut grasp = touch(home(), pose, pose.phi_rad + FRAC_PI_2 * (random.within(0.0, 3.99) as u8) as f32);
        grasp.purpose = Purpose::Grasp;
        let mut next = grasp.goal_world_from_hand;
        next.translation.vector.x -= 0.5;
        grasp.next_world_from_hand = Some(next);
        let grasped = end(&planner.plan(&grasp).unwrap());
        let query = transport(grasped, pose);
        let Ok(t) = planner.plan(&query) else { continue };
        solved += 1;
        assert_feasible(&t, &grasped);
        assert_straight(&t, t.guarded_from_s().unwrap(), 0.06);
        let (a, b) = (arm::hand_pose(&grasped), arm::hand_pose(&end(&t)));
        let moved = b.translation.vector - a.translation.vector;
        assert!((moved - Vector3::new(-0.5, 0.0, 0.0)).norm() < 2e-4, "{moved}");
        for at in instants(&t, 0.04) {
            let q = t.sample(at).unwrap().q_rad;
            let hand = arm::hand_pose(&q);
            let tilt = witness::angle_between(&(hand.rotation * Vector3::z()), &-Vector3::z());
            assert!(tilt < 2.0_f32.to_radians(), "tilt {tilt} at {at}");
            assert!(hand.rotation.angle_to(&a.rotation) < 2.0_f32.to_radians());
            assert_eq!(witness::complaint(&solids, &q, &query.hand_angles, None), None, "at {at}");
            // The load: above the table by the lift while it moves over, and out of the arm.
            let load = hand * a.inverse() * pose.isometry(0.1);
            if (load.translation.x - pose.x_m).abs() > 0.01 && (load.translation.x - pose.x_m + 0.5).abs() > 0.01 {
                assert!(load.translation.z > 0.155, "load at z {} at {at}", load.translation.z);
            }
        }
    }
    assert!(solved >= 39, "{solved} of 40 solved");
}

#[test]
fn whatever_the_witness_sees_the_scene_sees_too() {
    let (planner, solids) = (planner(), witness::solids());
    let mut random = Random::new(13);
    let (mut hits, mut blind) = ([0; 3], 0);
    for _ in 0..1500 {
        let q: Joints = core::array::from_fn(|j| random.within(ARM_LIMITS[j].lower_rad, ARM_LIMITS[j].upper_rad));
        let angles = HandAngles::engaged(core::array::from_fn(|_| random.within(0.0, 2.4)), random.within(0.0, PI));
        // A box near the hand.
        let near = arm::hand_pose(&q).translation.vector;
        let pose = PlanarPose::new(
            near.x + random.within(-0.3, 0.3),
            near.y + random.within(-0.3, 0.3),
            random.within(-PI, PI),
        );
        let estimate = ObjectEstimate { z_m: near.z + random.within(-0.3, 0.3), ..object(pose) };
        let rules = Rules {
            table_margin_m: 0.0,
            self_margin_m: 0.0,
            object: Some(estimate.block(0.0)),
            fingers_may_touch: false,
            carried: None,
            obstacles: scene::Clearance { margin_m: 0.0, of_fingers: true },
        };
        let block = pose.isometry(estimate.z_m);
        match planner.scene().hit(&q, &angles, &rules) {
            Some(scene::Hit::Table) => hits[0] += 1,
            Some(scene::Hit::Object) => hits[1] += 1,
            Some(scene::Hit::Itself) => hits[2] += 1,
            Some(scene::Hit::Obstacle) => panic!("there is no obstacle"),
            None => assert_eq!(witness::complaint(&solids, &q, &angles, Some((&block, HALF_M))), None, "{q:?}"),
        }
        let grown =
            Rules { table_margin_m: 0.01, self_margin_m: 0.01, object: Some(estimate.block(0.01)), ..rules.clone() };
        // A miss by a centimetre or more is no hit: the scene does not cry wolf.
        let clear = witness::complaint(&solids, &q, &angles, Some((&block, HALF_M.map(|h| h + 0.02)))).is_none();
        let lowest_clear = planner.scene().hit(&q, &angles, &grown) != Some(scene::Hit::Table);
        blind +=
            usize::from(clear && lowest_clear && planner.scene().hit(&q, &angles, &rules) == Some(scene::Hit::Object));
    }
    assert!(hits.iter().all(|h| *h > 20), "table, object, itself: {hits:?}");
    assert!(blind == 0, "{blind} false alarms");
}

#[test]
fn home_is_reached_without_a_guarded_part() {
    let planner = planner();
    let q = end(&planner.plan(&touch(home(), PlanarPose::new(0.2, -0.1, 0.0), 0.0)).unwrap());
    let query = PlanQuery {
        purpose: Purpose::Home,
        goal_world_from_hand: arm::hand_pose(&home()),
        ..touch(q, PlanarPose::new(0.2, -0.1, 0.0), 0.0)
    };
    let t = planner.plan(&query).unwrap();
    assert_feasible(&t, &q);
    assert_eq!(t.guarded_from_s(), None);
    let (reached, wanted) = (arm::hand_pose(&end(&t)), query.goal_world_from_hand);
    assert!((reached.translation.vector - wanted.translation.vector).norm() < 1e-4);
}

#[test]
fn a_way_round_the_box_is_found_when_the_straight_motion_is_blocked() {
    let (planner, solids) = (planner(), witness::solids());
    let pose = PlanarPose::new(0.1, -0.1, FRAC_PI_2);
    let mut searched = 0;
    for (from, to) in [(-0.22, 0.42), (0.42, -0.22)] {
        let start = inverse::solve(&down(from, -0.1, 0.2, 0.0), 0.0).unwrap()[0];
        let mut query = touch(start, pose, 0.0);
        query.goal_world_from_hand = down(to, -0.1, 0.2, 0.0);
        query.approach_height_m = 0.0;
        let t = planner.plan(&query).unwrap();
        assert_feasible(&t, &start);
        // Straight across at this height the hand would go through the box.
        let straight = scene::between(&start, &end(&t), 0.5);
        let block = pose.isometry(0.1);
        let inflation = query.object.unwrap().inflation_m;
        let grown: [f32; 3] = core::array::from_fn(|i| HALF_M[i] + inflation[i]);
        searched +=
            usize::from(witness::complaint(&solids, &straight, &query.hand_angles, Some((&block, HALF_M))).is_some());
        for at in instants(&t, 0.01) {
            let q = t.sample(at).unwrap().q_rad;
            assert_eq!(witness::complaint(&solids, &q, &query.hand_angles, Some((&block, grown))), None, "at {at}");
        }
    }
    assert_eq!(searched, 2);
}

#[test]
fn nothing_to_do_is_a_trajectory_of_no_duration() {
    let query = touch(home(), PlanarPose::new(0.2, -0.1, 0.0), 0.0);
    let t = planner().plan(&PlanQuery { purpose: Purpose::Retreat, approach_height_m: 0.0, ..query }).unwrap();
    assert_eq!((t.duration(), end(&t)), (0.0, home()));
}

#[test]
fn each_refusal_has_its_reason() {
    let planner = planner();
    let pose = PlanarPose::new(0.2, -0.1, 0.0);
    let good = touch(home(), pose, 0.0);
    assert!(planner.plan(&good).is_ok());
    let refused = |spoil: &dyn Fn(&mut PlanQuery)| {
        let mut query = good;
        spoil(&mut query);
        planner.plan(&query).unwrap_err()
    };
    assert_eq!(refused(&|q| q.goal_world_from_hand = down(2.0, -0.1, 0.3, 0.0)), PlanRefusal::OutOfReach);
    assert_eq!(refused(&|q| q.goal_world_from_hand = down(0.2, -0.1, 0.02, 0.0)), PlanRefusal::GoalInCollision);
    // Palm up, close to the base: the wrist would have to be below the table.
    assert!(matches!(
        refused(&|q| q.goal_world_from_hand = Isometry3::translation(-0.05, -0.45, 0.3)),
        PlanRefusal::NoInverseKinematics | PlanRefusal::OutOfReach | PlanRefusal::GoalInCollision
    ));
    assert_eq!(refused(&|q| q.start_q_rad = [0.0, 1.9, 0.0, 1.0, 0.0, 0.0, 0.0]), PlanRefusal::StartInCollision);
    let inside_the_box = PlanarPose::new(-0.05, -0.2, 0.0);
    assert_eq!(
        refused(&|q| q.object = Some(ObjectEstimate { z_m: 0.4, ..object(inside_the_box) })),
        PlanRefusal::StartInCollision
    );
    assert_eq!(refused(&|q| q.start_q_rad[3] = f32::NAN), PlanRefusal::NonFinite);
    assert_eq!(refused(&|q| q.goal_world_from_hand.translation.x = f32::INFINITY), PlanRefusal::NonFinite);
    assert_eq!(refused(&|q| q.approach_height_m = -0.1), PlanRefusal::NonFinite);
    assert_eq!(refused(&|q| q.object = Some(object(PlanarPose::new(f32::NAN, 0.0, 0.0)))), PlanRefusal::NonFinite);
    assert_eq!(refused(&|q| q.hand_angles.spread_rad = f32::NAN), PlanRefusal::NonFinite);
    // The object is taken to be so high that the hand cannot get above it.
    let tower =
        ObjectEstimate { shape: ObjectShape::Cuboid { half_extents_m: [0.1, 0.1, 0.6] }, z_m: 0.6, ..object(pose) };
    assert_eq!(refused(&|q| q.object = Some(tower)), PlanRefusal::GoalInCollision);
}

#[test]
fn the_same_query_gives_the_same_bits() {
    let pose = PlanarPose::new(0.1, -0.1, FRAC_PI_2);
    let start = inverse::solve(&down(-0.22, -0.1, 0.2, 0.0), 0.0).unwrap()[0];
    let mut searching = touch(start, pose, 0.0);
    searching.goal_world_from_hand = down(0.42, -0.1, 0.2, 0.0);
    for query in [touch(home(), PlanarPose::new(0.2, -0.1, 0.3), 1.0), searching] {
        let bits = |t: Trajectory| -> Vec<u32> {
            let numbers = |k: &Knot| [[k.t_s; 7], k.q_rad, k.qd_rad_s, k.qdd_rad_s2].concat();
            t.knots.iter().flat_map(numbers).map(f32::to_bits).collect()
        };
        // Two planners: nothing learnt from one query leaks into the next.
        let (a, b) = (planner(), planner());
        let first = bits(a.plan(&query).unwrap());
        let _ = b.plan(&touch(home(), pose, 0.4));
        assert_eq!(first, bits(b.plan(&query).unwrap()));
        assert_eq!(first, bits(a.plan(&query).unwrap()));
    }
}

#[test]
fn a_description_without_an_arm_is_refused_by_name() {
    let mut robot = urdf_rs::read_from_string(source::URDF).unwrap();
    robot.links.retain(|link| link.name != "wam_link4");
    assert_eq!(
        Planner::new(&robot, PlannerConfig::default(), &MOUNT, &[]).err(),
        Some(ModelError::NoLink("wam_link4".to_owned()))
    );
}
