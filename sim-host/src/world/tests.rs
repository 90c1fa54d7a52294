//! Tests of the whole world that are not physics measurements (those are in `tests/physics.rs`).

use super::*;

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
    let scene = Scene { object: tactus_common::pose::PlanarPose::new(hand.x, hand.y, 0.0), half_extents_m: [0.1, 0.05, 0.25], ..Scene::default() };
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
