//! Measurements that the world is physics. Each prints what it measured (`cargo test -- --nocapture physics`).

use super::*;
use tactus_common::pose::PlanarPose;

/// The object out of the arm's way.
fn aside() -> PlanarPose {
    PlanarPose::new(-0.7, 0.4, 0.0)
}

/// One free swing of 10 s: highest kinetic energy, energy lost at the end, most energy ever above the start (joules).
fn swing(start: [f32; 7]) -> (f64, f64, f64) {
    let scene = Scene { arm_start_rad: start, object: aside(), ..Scene::default() };
    let mut world = World::new(&scene, &Mismatch::none(), 0).unwrap();
    world.free_the_arm();
    let before_j = world.robot.potential_energy_j(&world.physics);
    let (mut most_kinetic_j, mut gain_j, mut last_j) = (0.0_f64, 0.0_f64, 0.0);
    for _ in 0..5000 * STEPS_PER_TICK {
        // Positions live at whole steps, velocities between them: the energy at a whole step takes their mean.
        let potential_j = world.robot.potential_energy_j(&world.physics);
        let (inertia, before) = world.robot.inertia_and_velocity(&world.physics);
        world.step_arm(&[0.0; 7]);
        let (_, after) = world.robot.inertia_and_velocity(&world.physics);
        let mean = (before + after) * 0.5;
        let kinetic_j = 0.5 * mean.dot(&(inertia * &mean));
        most_kinetic_j = most_kinetic_j.max(kinetic_j);
        last_j = kinetic_j + potential_j - before_j;
        gain_j = gain_j.max(last_j);
    }
    (most_kinetic_j, -last_j, gain_j)
}

#[test]
fn an_undamped_swinging_arm_keeps_its_energy() {
    // No damping, no friction, no limits, the fingers clamped. The reference is what swings: the highest kinetic energy.
    // The outstretched arm let fall from near the horizontal, straight and bent; both end in a chaotic whirl in which the
    // wrist passes ten times its rated speed.
    for start in [[0.0, 1.4, 0.0, 0.0, 0.0, 0.0, 0.0], [0.3, 1.2, 0.2, 0.6, 0.0, 0.3, 0.0]] {
        let (reference_j, loss_j, gain_j) = swing(start);
        println!(
            "swing from {start:?}: {reference_j:.2} J; after 10 s {loss_j:.4} J lost = {:.3} %, highest gain {:.4} %",
            100.0 * loss_j / reference_j,
            100.0 * gain_j / reference_j
        );
        assert!(loss_j <= 0.03 * reference_j);
        assert!(gain_j <= 0.001 * reference_j);
    }
}
