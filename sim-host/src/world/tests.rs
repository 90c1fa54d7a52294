//! Tests of the whole world that are not physics measurements (those are in `tests/physics.rs`).

use super::*;
use tactus_common::shape::ObjectShape;

mod physics;

fn idle_run(world: &mut World, ticks: u32) {
    for _ in 0..ticks {
        let now = world.now();
        world.tick(&JointCommands::idle(now)).unwrap();
    }
}

#[test]
fn the_same_seed_gives_the_same_digest_and_another_seed_does_not() {
    let run = |seed| {
        let mut world = World::new(&Scene::default(), &Mismatch::from_seed(seed), seed).unwrap();
        idle_run(&mut world, 40);
        world.state_digest()
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
}

#[test]
fn a_restored_world_goes_on_bit_for_bit() {
    let mut world = World::new(&Scene::default(), &Mismatch::from_seed(2), 2).unwrap();
    idle_run(&mut world, 30);
    let snapshot = world.snapshot().unwrap();
    idle_run(&mut world, 60);
    let (digest, readings) = (world.state_digest(), world.readings());
    world.restore(&snapshot).unwrap();
    assert_eq!(world.now(), 30);
    idle_run(&mut world, 60);
    assert_eq!(world.state_digest(), digest);
    assert_eq!(world.readings(), readings);
}

#[test]
fn overlapping_bodies_are_refused_by_name() {
    let hand = World::new(&Scene::default(), &Mismatch::none(), 0).unwrap().hand_pose().translation.vector;
    let scene = Scene {
        object: tactus_common::pose::PlanarPose::new(hand.x, hand.y, 0.0),
        shape: ObjectShape::Cuboid { half_extents_m: [0.1, 0.05, 0.25] },
        ..Scene::default()
    };
    let error = World::new(&scene, &Mismatch::none(), 0).err().unwrap();
    assert!(matches!(error, WorldError::Interpenetration { depth_m, .. } if depth_m > 0.001), "{error}");
    assert!(error.to_string().contains("object"), "{error}");
}

#[test]
fn a_scene_that_makes_no_sense_is_refused() {
    let off = Scene { object: tactus_common::pose::PlanarPose::new(2.0, 0.0, 0.0), ..Scene::default() };
    let nan = Scene { object: tactus_common::pose::PlanarPose::new(f32::NAN, 0.0, 0.0), ..Scene::default() };
    let bent = Scene { arm_start_rad: [9.0; 7], ..Scene::default() };
    for scene in [off, nan, bent] {
        assert!(matches!(World::new(&scene, &Mismatch::none(), 0).err(), Some(WorldError::Scene { .. })));
    }
}

#[test]
fn a_command_that_is_not_finite_is_refused_and_the_world_stands() {
    let mut world = World::new(&Scene::default(), &Mismatch::none(), 0).unwrap();
    let before = world.state_digest();
    let mut commands = JointCommands::idle(0);
    commands.arm_tau_nm[2] = f32::NAN;
    assert_eq!(world.tick(&commands), Err(WorldError::Command { drive: "the arm", tick: 0 }));
    commands = JointCommands::idle(0);
    commands.hand[1] = HandCommand::Velocity(f32::INFINITY);
    assert_eq!(world.tick(&commands), Err(WorldError::Command { drive: "the hand", tick: 0 }));
    assert_eq!(world.state_digest(), before);
}

#[test]
fn the_world_and_the_controllers_tables_agree_on_the_robot() {
    use tactus_common::robot::{self, hand::HandAngles};
    let start = HandStart { inner_rad: [0.4, 0.9, 1.3], spread_rad: 0.7 };
    let scene = Scene { arm_start_rad: [0.3, 0.6, -0.4, 1.4, 0.5, 0.7, -0.8], hand_start: start, ..Scene::default() };
    let world = World::new(&scene, &Mismatch::none(), 0).unwrap();
    let hand = robot::arm::hand_pose(&scene.arm_start_rad);
    let links = robot::hand::link_poses(&hand, &HandAngles::engaged(start.inner_rad, start.spread_rad));
    for (index, (ours, theirs)) in world.hand_link_poses().iter().zip(&links).enumerate() {
        let apart_m = (ours.translation.vector - theirs.translation.vector).norm();
        assert!(
            apart_m < 2e-6 && ours.rotation.angle_to(&theirs.rotation) < 1e-5,
            "{}: {apart_m} m",
            HAND_LINK_NAMES[index]
        );
    }
    let model = RobotModel::shipped().unwrap();
    for pad in 0..PADS {
        let theirs = if pad < 3 { &robot::FINGERTIP_TAXELS } else { &robot::PALM_TAXELS };
        for (ours, theirs) in model.extra.tactile.cells(pad).iter().zip(theirs) {
            for k in 0..3 {
                assert!((ours.centre_m[k] - theirs.centre_m[k]).abs() < 1e-7, "{ours:?} {theirs:?}");
                assert!((ours.normal[k] - theirs.normal[k]).abs() < 1e-6, "{ours:?} {theirs:?}");
            }
            assert!((ours.area_m2 - theirs.area_m2).abs() < 1e-9);
        }
    }
    // The collision shapes reach exactly as far as the prisms of the tables, in every direction.
    for (index, link) in world.robot.hand_links.iter().enumerate() {
        let prism = robot::hand_prism(robot::HandLink::ALL[index]);
        let shape = world.physics.colliders.get(link.collider).unwrap().shape();
        let aabb = shape.compute_local_aabb();
        let [low, high] = prism.z_m;
        assert!((aabb.mins.z - low).abs() < 1e-6 && (aabb.maxs.z - high).abs() < 1e-6, "{}", HAND_LINK_NAMES[index]);
        let support = shape.as_support_map().unwrap();
        for step in 0..720 {
            let (sin, cos) = libm::sincosf(step as f32 * core::f32::consts::TAU / 720.0);
            let direction = Vector::new(cos, sin, 0.0);
            let ours = support.local_support_point(direction).dot(direction);
            let theirs = prism.corners_m.iter().map(|c| c[0] * cos + c[1] * sin).fold(f32::MIN, f32::max);
            assert!((ours - theirs).abs() < 1e-6, "{}: {} m off at {step}", HAND_LINK_NAMES[index], ours - theirs);
        }
    }
}

/// Bodies of every shape, each standing on the table.
fn shapes() -> [ObjectShape; 5] {
    let prism = crate::scenario::Scenario::load(std::path::Path::new("hexagonal-prism")).unwrap();
    [
        ObjectShape::THESIS_BOX,
        ObjectShape::Cylinder { radius_m: 0.04, half_height_m: 0.1 },
        ObjectShape::Sphere { radius_m: 0.05 },
        ObjectShape::Capsule { radius_m: 0.04, half_length_m: 0.05 },
        prism.shape(),
    ]
}

#[test]
fn a_body_of_any_shape_stands_still_where_it_was_put() {
    for shape in shapes() {
        for seed in [1, 2] {
            let scene = Scene { shape, ..Scene::default() };
            let mut world = World::new(&scene, &Mismatch::from_seed(seed), seed).unwrap();
            let before = world.object_pose();
            idle_run(&mut world, 150);
            let after = world.object_pose();
            let shift_m = (after.translation.vector - before.translation.vector).norm();
            assert!(shift_m < 2e-4, "{shape:?}: {shift_m} m");
            assert!(after.rotation.angle_to(&before.rotation) < 2e-3, "{shape:?}");
        }
    }
}

#[test]
fn mass_and_inertia_are_those_of_the_shape() {
    let inertia = |shape: ObjectShape| {
        let world = World::new(&Scene { shape, mass_kg: 0.5, ..Scene::default() }, &Mismatch::none(), 0).unwrap();
        let body = world.physics.bodies.get(world.object).unwrap();
        assert!((body.mass() - 0.5).abs() < 1e-6);
        let inverse = body.mass_properties().effective_world_inv_inertia;
        [Vector::X, Vector::Y, Vector::Z].map(|axis| 1.0 / (inverse * axis).dot(axis))
    };
    let near = |found: [f32; 3], expected: [f32; 3]| {
        assert!(found.iter().zip(expected).all(|(f, e)| (f / e - 1.0).abs() < 2e-3), "{found:?} {expected:?}");
    };
    near(inertia(ObjectShape::Sphere { radius_m: 0.05 }), [0.4 * 0.5 * 0.0025; 3]);
    let across = 0.5 * (3.0 * 0.0016 + 0.04) / 12.0;
    near(inertia(ObjectShape::Cylinder { radius_m: 0.04, half_height_m: 0.1 }), [across, across, 0.5 * 0.5 * 0.0016]);
    // A regular hexagon of inradius r has the polar second moment 5/9 r^2 of its area, half of that about each axis.
    let polar = 0.5 * (5.0 / 9.0) * 0.05 * 0.05;
    let across = 0.5 * polar + 0.5 * 0.15 * 0.15 / 12.0;
    near(inertia(shapes()[4]), [across, across, polar]);
}

#[test]
fn a_rolling_ball_comes_to_rest_where_the_law_of_rolling_friction_has_it() {
    let (radius_m, speed_m_s) = (0.05, 0.1);
    let scene = Scene { shape: ObjectShape::Sphere { radius_m }, ..Scene::default() };
    let mut world = World::new(&scene, &Mismatch::none(), 0).unwrap();
    idle_run(&mut world, 20);
    let from = world.object_pose().translation.vector;
    let body = world.physics.bodies.get_mut(world.object).unwrap();
    body.set_linvel(Vector::new(-speed_m_s, 0.0, 0.0), true);
    body.set_angvel(Vector::new(0.0, -speed_m_s / radius_m, 0.0), true);
    idle_run(&mut world, 900);
    let way_m = (world.object_pose().translation.vector - from).norm();
    // (m + I / r^2) a = c m g with I = 2/5 m r^2.
    let expected_m = speed_m_s * speed_m_s / (2.0 * rolling::ROLLING_RESISTANCE * 9.81 / 1.4);
    assert!((way_m / expected_m - 1.0).abs() < 0.15, "{way_m} m, expected {expected_m} m");
    let body = world.physics.bodies.get(world.object).unwrap();
    assert!(body.linvel().length() < 1e-3, "it stands");
}

#[test]
fn what_stands_beside_the_object_is_checked_and_named_and_free_things_can_be_pushed() {
    let other = |x_m: f32, free_kg| Standing {
        name: "obstacles[0]".into(),
        shape: ObjectShape::Cylinder { radius_m: 0.05, half_height_m: 0.1 },
        pose: tactus_common::pose::PlanarPose::new(x_m, -0.1, 0.0),
        free_kg,
    };
    let with = |other| World::new(&Scene { others: vec![other], ..Scene::default() }, &Mismatch::none(), 0);
    let error = with(other(0.33, None)).err().unwrap().to_string();
    assert!(error.contains("`object` and `obstacles[0]` overlap by 20.0 mm"), "{error}");
    for (free_kg, moves) in [(None, false), (Some(0.3), true)] {
        let mut world = with(other(0.36, free_kg)).unwrap();
        idle_run(&mut world, 20);
        assert!(world.others_shift_m() < 1e-4);
        let object = world.physics.bodies.get_mut(world.object).unwrap();
        object.set_linvel(Vector::new(0.8, 0.0, 0.0), true);
        idle_run(&mut world, 150);
        assert_eq!(world.others_shift_m() > 1e-3, moves, "{} m", world.others_shift_m());
        // What is fixed stops the box.
        assert!(moves || world.object_pose().translation.x < 0.215, "{}", world.object_pose().translation.x);
    }
}
