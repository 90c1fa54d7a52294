//! Measurements that the world is physics. Each prints what it measured (`cargo test -- --nocapture physics`).

use super::super::hand::HandStart;
use super::*;
use tactus_common::pose::PlanarPose;

fn frictionless(scene: &Scene) -> World {
    let world = World::new(scene, &Mismatch::none(), 0).unwrap();
    let mut world = world;
    world.robot.make_frictionless(&mut world.physics, false);
    world
}

/// Robot energy, joules: kinetic (rotors included) and potential.
fn energy_j(world: &World) -> (f64, f64) {
    (world.robot.kinetic_energy_j(&world.physics), world.robot.potential_energy_j(&world.physics))
}

#[test]
fn an_undamped_swinging_arm_keeps_its_energy() {
    // Released from an outstretched pose with the object out of the way; the hand's joints are held by their drives.
    for start in [[0.3, 1.2, 0.2, 0.6, 0.0, 0.3, 0.0], [0.0, 1.9, 0.5, 1.0, 0.4, -0.5, 0.2]] {
        let scene = Scene { arm_start_rad: start, object: PlanarPose::new(-0.7, 0.4, 0.0), ..Scene::default() };
        let mut world = frictionless(&scene);
        world.physics.gravity = Vector::new(0.0, 0.0, -9.81);
        // Limits off and no contacts: a free swing.
        world.free_the_arm();
        let (k0, p0) = energy_j(&world);
        let (mut lowest_p, mut most_k) = (p0, k0);
        let (mut gain, mut last) = (0.0_f64, k0 + p0);
        for _ in 0..5000 {
            for _ in 0..STEPS_PER_TICK {
                world.step(&[0.0; 7], &[HandCommand::Position(0.0); 4]);
            }
            let (k, p) = energy_j(&world);
            lowest_p = lowest_p.min(p);
            most_k = most_k.max(k);
            gain = gain.max(k + p - (k0 + p0));
            last = k + p;
        }
        let swing = p0 - lowest_p;
        let loss = (k0 + p0) - last;
        println!(
            "start {start:?}: swing {swing:.2} J, most kinetic {most_k:.2} J, after 10 s lost {loss:.4} J = {:.3} %, highest gain {:.4} %",
            100.0 * loss / swing,
            100.0 * gain / swing
        );
        assert!(loss <= 0.03 * swing, "lost {:.2} %", 100.0 * loss / swing);
        assert!(gain <= 0.001 * swing, "gained {:.3} %", 100.0 * gain / swing);
    }
}
