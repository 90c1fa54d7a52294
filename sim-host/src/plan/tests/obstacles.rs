//! What the planner promises among obstacles.

use super::*;
use tactus_common::shape::Obstacle;

/// A wall along y, 0.12 m high.
const WALL_HALF_M: [f32; 3] = [0.02, 0.15, 0.06];
const WALL: Obstacle =
    Obstacle { shape: ObjectShape::Cuboid { half_extents_m: WALL_HALF_M }, pose: PlanarPose::new(-0.1, -0.1, 0.0) };
/// A post, 0.3 m high.
const POST_HALF_M: [f32; 3] = [0.03, 0.03, 0.15];
const POST: Obstacle =
    Obstacle { shape: ObjectShape::Cuboid { half_extents_m: POST_HALF_M }, pose: PlanarPose::new(0.42, -0.1, 0.3) };

fn planner_among(obstacles: &[Obstacle]) -> Planner {
    let robot = urdf_rs::read_from_string(source::URDF).unwrap();
    Planner::new(&robot, PlannerConfig::default(), &MOUNT, obstacles).unwrap()
}

#[test]
fn touches_among_obstacles_are_found_and_keep_hand_and_arm_clear_of_them() {
    let (planner, solids) = (planner_among(&[WALL, POST]), witness::solids());
    let mut random = Random::new(21);
    let (mut q, mut solved) = (home(), 0);
    for _ in 0..60 {
        let pose = PlanarPose::new(random.within(0.1, 0.2), random.within(-0.2, 0.0), random.within(-PI, PI));
        let query = touch(q, pose, random.within(-PI, PI));
        let Ok(t) = planner.plan(&query) else { continue };
        solved += 1;
        assert_feasible(&t, &q);
        for at in instants(&t, 0.04) {
            let q = t.sample(at).unwrap().q_rad;
            for (obstacle, half_m) in [(WALL, WALL_HALF_M), (POST, POST_HALF_M)] {
                let block = obstacle.isometry();
                let complaint = witness::complaint(&solids, &q, &query.hand_angles, Some((&block, half_m)));
                assert_eq!(complaint, None, "at {at} of {} s, {pose:?}", t.duration());
            }
        }
        q = end(&planner.plan(&PlanQuery { purpose: Purpose::Retreat, start_q_rad: end(&t), ..query }).unwrap());
    }
    assert!(solved >= 45, "{solved} of 60 solved");
}

#[test]
fn a_touch_whose_descent_meets_an_obstacle_is_refused_by_its_goal() {
    // The palm comes down where the post stands.
    let planner = planner_among(&[POST]);
    let query = PlanQuery { object: None, ..touch(home(), POST.pose, 0.0) };
    assert_eq!(planner.plan(&query).err(), Some(PlanRefusal::GoalInCollision));
    assert!(planner_among(&[]).plan(&query).is_ok(), "without the post there is a way");
}

#[test]
fn a_load_is_carried_over_a_wall_high_enough_or_not_at_all() {
    let planner = planner_among(&[WALL]);
    let pose = PlanarPose::new(0.15, -0.1, 0.0);
    let grasped = end(&planner.plan(&touch(home(), pose, 0.0)).unwrap());
    let low = transport(grasped, pose);
    assert_eq!(planner.plan(&low).err(), Some(PlanRefusal::NoPath), "0.06 m is below the wall's top");
    let high = PlanQuery { approach_height_m: 0.2, ..low };
    let t = planner.plan(&high).unwrap();
    let a = arm::hand_pose(&grasped);
    for at in instants(&t, 0.02) {
        let load = arm::hand_pose(&t.sample(at).unwrap().q_rad) * a.inverse() * pose.isometry(0.1);
        let over_the_wall = (load.translation.x - WALL.pose.x_m).abs() < HALF_M[0] + WALL_HALF_M[0];
        let clear_m = load.translation.z - HALF_M[2] - 2.0 * WALL_HALF_M[2];
        assert!(!over_the_wall || clear_m > 0.015, "the load is {clear_m} m above the wall at {at}");
    }
}
