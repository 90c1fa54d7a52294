//! Measurements that the world is physics. Each prints what it measured (`cargo test -- --nocapture physics`).

use super::*;
use tactus_common::pose::PlanarPose;

/// The object out of the arm's way.
fn aside() -> PlanarPose {
    PlanarPose::new(-0.75, 0.2, 0.0)
}

/// What a free swing of 10 s did.
#[derive(Debug)]
struct Swing {
    /// Highest kinetic energy: the energy that swings to and fro, joules.
    reference_j: f64,
    /// Energy missing after 10 s, joules.
    loss_j: f64,
    /// Most energy ever above the start's, joules.
    gain_j: f64,
    /// Fastest joint, rad/s.
    fastest_rad_s: f64,
}

/// Lets the arm go from rest at `start`: no damping, no friction, no limits, no contacts, the fingers clamped.
fn swing(start: [f32; 7]) -> Swing {
    let mut world = World::new(&Scene { object: aside(), ..Scene::default() }, &Mismatch::none(), 0).unwrap();
    world.free_the_arm();
    let angles: Vec<_> = world.robot.arm.iter().copied().zip(start).collect();
    world.robot.set_angles(&mut world.physics, &angles);
    let before_j = world.robot.potential_energy_j(&world.physics);
    let mut swing = Swing { reference_j: 0.0, loss_j: 0.0, gain_j: 0.0, fastest_rad_s: 0.0 };
    for _ in 0..5000 * STEPS_PER_TICK {
        // Positions live at whole steps, velocities between them: the energy at a whole step takes their mean.
        let potential_j = world.robot.potential_energy_j(&world.physics);
        let (inertia, before) = world.robot.inertia_and_velocity(&world.physics);
        world.step_arm(&[0.0; 7]);
        let (_, after) = world.robot.inertia_and_velocity(&world.physics);
        let mean = (before + after) * 0.5;
        let kinetic_j = 0.5 * mean.dot(&(inertia * &mean));
        swing.reference_j = swing.reference_j.max(kinetic_j);
        swing.loss_j = before_j - kinetic_j - potential_j;
        swing.gain_j = swing.gain_j.max(-swing.loss_j);
        swing.fastest_rad_s = swing.fastest_rad_s.max(mean.amax());
    }
    let percent = |j: f64| 100.0 * j / swing.reference_j;
    println!(
        "swing from {start:?}: {:.2} J, joints up to {:.0} rad/s; after 10 s {:.3} % lost, never more than {:.4} % gained",
        swing.reference_j,
        swing.fastest_rad_s,
        percent(swing.loss_j),
        percent(swing.gain_j)
    );
    swing
}

#[test]
fn an_undamped_swinging_arm_keeps_its_energy() {
    // From near hanging, straight and bent: swings of about the speeds that the arm is rated for, and above.
    let hanging = core::f32::consts::PI;
    for start in [
        [0.0, hanging - 0.6, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, hanging - 0.5, 0.3, 0.4, 0.0, -0.2, 0.0],
        [0.0, hanging - 1.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    ] {
        let swing = swing(start);
        assert!(swing.loss_j <= 0.03 * swing.reference_j, "{swing:?}");
        assert!(swing.gain_j <= 0.001 * swing.reference_j, "{swing:?}");
    }
}

#[test]
fn a_falling_arm_that_whirls_far_beyond_its_rated_speed_neither_explodes_nor_freezes() {
    // Let fall from above the horizontal, the arm ends in a chaotic whirl, its wrist far beyond its rated speed.
    for start in [[0.0, 1.4, 0.0, 0.0, 0.0, 0.0, 0.0], [0.3, 1.2, 0.2, 0.6, 0.0, 0.3, 0.0]] {
        let swing = swing(start);
        assert!(swing.loss_j <= 0.10 * swing.reference_j, "{swing:?}");
        assert!(swing.gain_j <= 0.02 * swing.reference_j, "{swing:?}");
    }
}

/// A nominal world without dry friction (viscous damping stays), fingers half closed as the controller's model has them.
fn half_closed(arm_start_rad: [f32; 7]) -> World {
    let half_rad = 0.5 * tactus_common::robot::FINGER_LIMIT.upper_rad;
    let scene = Scene {
        arm_start_rad,
        object: aside(),
        hand_start: HandStart { inner_rad: [half_rad; 3], spread_rad: 0.0 },
        ..Scene::default()
    };
    let world = World::new(&scene, &Mismatch::none(), 0).unwrap();
    let mut world = world;
    world.robot.make_frictionless(&mut world.physics, true);
    world
}

const UPRIGHT: [f32; 7] = [0.0; 7];
const REACHING_DOWN: [f32; 7] = [0.3, 0.9173, 0.0, 1.7133, 0.0, 0.5110, 0.4];
const STRETCHED: [f32; 7] = [-0.4, 1.1, 0.5, 0.4, -1.0, 0.7, 1.0];

#[test]
fn gravity_torques_hold_the_arm_still() {
    for (name, pose) in [("upright", UPRIGHT), ("reaching down", REACHING_DOWN), ("stretched", STRETCHED)] {
        let mut world = half_closed(pose);
        let start = world.hand_pose();
        let mut furthest_m = 0.0_f32;
        for tick in 0..1000 {
            let mut commands = JointCommands::idle(tick);
            commands.arm_tau_nm = tactus_common::robot::dynamics::gravity(&world.arm_q_rad(), 0.0);
            world.tick(&commands).unwrap();
            furthest_m = furthest_m.max((world.hand_pose().translation.vector - start.translation.vector).norm());
        }
        println!("{name}: the hand moved {:.4} mm in 2 s under gravity torques alone", furthest_m * 1e3);
        assert!(furthest_m < 1e-3, "{name}: {furthest_m} m");
    }
}

#[test]
fn torques_beyond_gravity_accelerate_the_arm_as_newton_and_euler_say() {
    for (pose, tau_nm) in
        [(REACHING_DOWN, [3.0, -4.0, 2.0, 3.0, 0.3, -0.4, 0.05]), (STRETCHED, [-5.0, 2.0, 3.0, -2.0, 0.2, 0.3, -0.06])]
    {
        let mut world = half_closed(pose);
        world.free_the_arm();
        let gravity = tactus_common::robot::dynamics::gravity(&pose, 0.0);
        let applied: [f32; 7] = core::array::from_fn(|i| gravity[i] + tau_nm[i]);
        for _ in 0..STEPS_PER_TICK {
            world.step_arm(&applied);
        }
        let states: [drive::JointState; 7] = world.robot.states(&world.physics, &world.robot.arm);
        let elapsed_s = TICK_S;
        let acceleration = states.map(|s| s.qd_rad_s / elapsed_s);
        let needed = tactus_common::robot::dynamics::inverse_dynamics(&pose, &[0.0; 7], &acceleration, 0.0);
        let mut worst = 0.0_f32;
        for i in 0..7 {
            let error = (needed[i] - applied[i]).abs() / tau_nm[i].abs();
            worst = worst.max(error);
        }
        println!("from {pose:?}: accelerations {acceleration:?} rad/s^2 explain the torques to {:.2} %", worst * 100.0);
        assert!(worst < 0.005, "{needed:?} for {applied:?}");
    }
}

/// A free box alone on the table in tilted gravity; how far it slid in 1 s, metres.
fn slide_m(angle_rad: f32) -> f32 {
    let mut world = World::new(&Scene::default(), &Mismatch::none(), 0).unwrap();
    world.free_the_arm();
    let (s, c) = libm::sincosf(angle_rad);
    world.physics.gravity = Vector::new(9.81 * s, 0.0, -9.81 * c);
    let before = world.object_pose();
    for _ in 0..500 * STEPS_PER_TICK {
        world.physics.step();
    }
    (world.object_pose().translation.vector - before.translation.vector).norm()
}

#[test]
fn a_box_slides_at_the_coulomb_angle() {
    let critical_rad = libm::atanf(0.3);
    // Half a degree to either side.
    let (below_m, above_m) = (slide_m(critical_rad - 0.0087), slide_m(critical_rad + 0.0087));
    let (s, c) = libm::sincosf(critical_rad + 0.0087);
    let expected_m = 0.5 * 9.81 * (s - 0.3 * c);
    println!(
        "half a degree below the angle of friction the box crept {:.4} mm in 1 s; half a degree above it slid {:.2} mm, Coulomb: {:.2} mm",
        below_m * 1e3,
        above_m * 1e3,
        expected_m * 1e3
    );
    assert!(below_m < 1e-4);
    assert!((above_m / expected_m - 1.0).abs() < 0.05);
}

/// Arm angles that put the hand straight down over (x, y), flange at `height_m`, hand x turned by `yaw_rad` from world x.
fn reach(x_m: f32, y_m: f32, height_m: f32, yaw_rad: f32) -> [f32; 7] {
    use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f32::consts::PI);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
    let pose = Isometry3::from_parts(Translation3::new(x_m, y_m, height_m), turn * down);
    let solutions = tactus_common::robot::inverse::solve(&pose, 0.0).unwrap();
    // The branch nearest to the arm's start, as a planner would choose.
    let start = Scene::default().arm_start_rad;
    let distance = |q: &[f32; 7]| q.iter().zip(&start).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    *solutions.iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
}

/// Barrett's own position loop with gravity compensation, as the controller will have it.
struct Holder {
    kp: [f32; 7],
    kd: [f32; 7],
    before: Option<[f32; 7]>,
}

impl Holder {
    fn new() -> Self {
        let arm = RobotModel::shipped().unwrap().extra.arm;
        Self { kp: arm.position_loop_kp_nm_rad, kd: arm.position_loop_kd_nms_rad, before: None }
    }

    /// Torques towards `q_rad` moving at `qd_rad_s`; velocity by differences of the readings.
    fn torques(&mut self, readings: &JointReadings, q_rad: &[f32; 7], qd_rad_s: &[f32; 7], qdd: &[f32; 7]) -> [f32; 7] {
        let measured = readings.arm_q_rad;
        let before = self.before.replace(measured).unwrap_or(measured);
        let feed_forward = tactus_common::robot::dynamics::inverse_dynamics(&measured, qd_rad_s, qdd, 0.0);
        core::array::from_fn(|i| {
            let velocity = (measured[i] - before[i]) / TICK_S;
            feed_forward[i] + self.kp[i] * (q_rad[i] - measured[i]) + self.kd[i] * (qd_rad_s[i] - velocity)
        })
    }
}

/// The hand over the box, fingers across its 0.1 m depth, palm 46 mm above its top.
fn over_the_box(inner_rad: f32) -> Scene {
    let q = reach(0.2, -0.1, 0.2 + 0.046 + 0.079, core::f32::consts::FRAC_PI_2);
    Scene { arm_start_rad: q, hand_start: HandStart { inner_rad: [inner_rad; 3], spread_rad: 0.0 }, ..Scene::default() }
}

#[test]
fn a_pinched_box_is_held_without_creep() {
    let scene = over_the_box(0.3);
    for (name, mismatch) in [("nominal", Mismatch::none()), ("seed 3", Mismatch::from_seed(3))] {
        let mut world = World::new(&scene, &mismatch, 1).unwrap();
        let mut holder = Holder::new();
        let mut relative = None;
        let mut creep_m = 0.0_f32;
        for tick in 0..4000 {
            let mut commands = JointCommands::idle(tick);
            // Close by torque, squeeze, then take the table away.
            let squeeze_nm = if tick < 200 { 0.5 } else { 1.0 };
            commands.hand = [
                HandCommand::Torque(squeeze_nm),
                HandCommand::Torque(squeeze_nm),
                HandCommand::Torque(squeeze_nm),
                HandCommand::Position(0.0),
            ];
            commands.arm_tau_nm = holder.torques(&world.readings(), &scene.arm_start_rad, &[0.0; 7], &[0.0; 7]);
            world.tick(&commands).unwrap();
            if tick == 1000 {
                world.remove_table();
            }
            if tick >= 1500 {
                let now = world.hand_pose().inverse() * world.object_pose();
                let start: &nalgebra::Isometry3<f32> = relative.get_or_insert(now);
                creep_m = creep_m.max((now.translation.vector - start.translation.vector).norm());
            }
        }
        println!(
            "{name}: held in the air, the box crept {:.4} mm in the hand in 5 s; forces {:?} N",
            creep_m * 1e3,
            world.link_forces_n()
        );
        assert!(creep_m < 1e-3);
        let forces_n = world.link_forces_n();
        let (front_n, back_n) = (forces_n[3] + forces_n[6], forces_n[8]);
        assert!((front_n / back_n - 1.0).abs() < 0.05, "action and reaction across the box: {front_n} and {back_n} N");
        assert!(world.object_pose().translation.z > 0.05, "the box fell");
    }
}

#[test]
fn the_arm_follows_a_smooth_move_with_the_robots_own_position_loop() {
    let (from, to) = (Scene::default().arm_start_rad, reach(0.2, -0.1, 0.325, core::f32::consts::FRAC_PI_2));
    for (name, mismatch) in [("nominal", Mismatch::none()), ("seed 7", Mismatch::from_seed(7))] {
        let mut world = World::new(&Scene::default(), &mismatch, 7).unwrap();
        let mut holder = Holder::new();
        let (mut worst_rad, mut worst_joint, mut end_m) = (0.0_f32, 0, 0.0);
        println!("{from:?} -> {to:?}");
        for tick in 0..1500 {
            // Minimum jerk over 2 s, then half a second of rest and half a second in which the end error is taken.
            let s = (tick as f32 / 1000.0).min(1.0);
            let (p, v, a) = (
                s * s * s * (10.0 - 15.0 * s + 6.0 * s * s),
                30.0 * s * s * (1.0 - s) * (1.0 - s) / 2.0,
                (60.0 * s - 180.0 * s * s + 120.0 * s * s * s) / 4.0,
            );
            let blend = |p: f32| core::array::from_fn(|i| (to[i] - from[i]) * p);
            let wanted: [f32; 7] = core::array::from_fn(|i| from[i] + (to[i] - from[i]) * p);
            let mut commands = JointCommands::idle(tick);
            commands.hand = [
                HandCommand::Position(0.25),
                HandCommand::Position(0.25),
                HandCommand::Position(0.25),
                HandCommand::Position(0.0),
            ];
            commands.arm_tau_nm = holder.torques(&world.readings(), &wanted, &blend(v), &blend(a));
            world.tick(&commands).unwrap();
            let q = world.arm_q_rad();
            for i in 0..7 {
                let error_rad = (q[i] - wanted[i]).abs();
                if error_rad > worst_rad {
                    (worst_rad, worst_joint) = (error_rad, i);
                }
            }
            if tick > 1250 {
                let there = tactus_common::robot::arm::hand_pose(&to);
                end_m = (world.hand_pose().translation.vector - there.translation.vector).norm();
            }
        }
        println!(
            "{name}: 2 s move, joint error at most {:.2} mrad (J{}), hand {:.3} mm from its goal at rest",
            worst_rad * 1e3,
            worst_joint + 1,
            end_m * 1e3
        );
        assert!(worst_rad < 0.03 && end_m < 3e-3);
    }
}

#[test]
fn a_finger_that_stops_at_first_touch_hardly_moves_the_box() {
    for seed in 0..4 {
        let mismatch = if seed == 0 { Mismatch::none() } else { Mismatch::from_seed(seed) };
        for (finger, speed) in [(2, 0.3), (0, 0.3), (2, 0.6)] {
            let scene = over_the_box(0.6);
            let mut world = World::new(&scene, &mismatch, seed).unwrap();
            let mut holder = Holder::new();
            let mut stopped: Option<u32> = None;
            let (mut most_n, mut at_stop_n, mut rest_nm) = (0.0_f32, 0.0, 0.0);
            let before = world.object_pose();
            let link = PAD_LINKS[finger];
            let mut moved_at_stop = 0.0;
            let mut free_nm = 0.0_f32;
            for tick in 0..1500 {
                let readings = world.readings();
                // The resting torque (weight of the tip, the gauge's offset) is taken while the finger moves freely.
                if tick == 60 {
                    rest_nm = readings.tip_torque_nm[finger];
                }
                if tick > 60 && most_n == 0.0 {
                    free_nm = free_nm.max((readings.tip_torque_nm[finger] - rest_nm).abs());
                }
                if tick > 60 && stopped.is_none() && readings.tip_torque_nm[finger] - rest_nm > 0.03 {
                    stopped = Some(tick);
                    at_stop_n = world.link_forces_n()[link];
                    moved_at_stop = (world.object_pose().translation.vector - before.translation.vector).norm();
                }
                let mut commands = JointCommands::idle(tick);
                commands.hand = [HandCommand::Velocity(0.0); 4];
                commands.hand[finger] = HandCommand::Velocity(if stopped.is_some() { 0.0 } else { speed });
                commands.arm_tau_nm = holder.torques(&readings, &scene.arm_start_rad, &[0.0; 7], &[0.0; 7]);
                world.tick(&commands).unwrap();
                most_n = most_n.max(world.link_forces_n()[link]);
                if stopped.is_some_and(|at| tick > at + 100) {
                    break;
                }
            }
            let after = world.object_pose();
            let moved = after.translation.vector - before.translation.vector;
            let turned = before.rotation.angle_to(&after.rotation);
            println!(
                "seed {seed}, F{} at {speed} rad/s: stopped at {stopped:?}, force then {at_stop_n:.2} N, at most {most_n:.2} N, at rest {:.2} N; box moved {:.3} mm by the stop, {:.3} mm in all, turned {:.2} mrad; moving freely the gauge strayed by {:.1} mN m",
                finger + 1,
                world.link_forces_n()[link],
                moved_at_stop * 1e3,
                moved.norm() * 1e3,
                turned * 1e3,
                free_nm * 1e3
            );
            assert!(stopped.is_some() && turned < 1e-3);
            // At 0.6 rad/s the force passes the table's friction before the finger stands: touch at half that.
            if speed < 0.5 {
                assert!(moved.norm() < 5e-4 && most_n < 4.0, "{} m, {most_n} N", moved.norm());
            }
        }
    }
}

#[test]
fn joints_stop_at_their_limits() {
    // The fingers close with nothing between them; then J4 is pushed into its upper stop with its full torque.
    let mut world = World::new(&Scene { object: aside(), ..Scene::default() }, &Mismatch::none(), 0).unwrap();
    let mut holder = Holder::new();
    let (mut j4_rad, mut inner_rad, mut tip_rad) = (0.0_f32, 0.0_f32, 0.0_f32);
    for tick in 0..2000 {
        let mut commands = JointCommands::idle(tick);
        commands.arm_tau_nm = holder.torques(&world.readings(), &Scene::default().arm_start_rad, &[0.0; 7], &[0.0; 7]);
        if tick > 1000 {
            commands.arm_tau_nm[3] = 31.2;
        }
        commands.hand = [HandCommand::Velocity(2.0); 4];
        world.tick(&commands).unwrap();
        j4_rad = j4_rad.max(world.arm_q_rad()[3]);
        inner_rad = inner_rad.max(world.state.drives.inner[0].q_rad);
        tip_rad = tip_rad.max(world.state.drives.distal[0].q_rad);
    }
    println!(
        "J4 {:.1} mrad, inner {:.1} mrad, tip {:.1} mrad beyond their stops at worst",
        (j4_rad - 3.1) * 1e3,
        (inner_rad - 2.4435) * 1e3,
        (tip_rad - 0.8378) * 1e3
    );
    assert!(j4_rad > 3.09 && j4_rad < 3.12);
    assert!(inner_rad > 2.42 && inner_rad < 2.46 && tip_rad < 0.85);
}

#[test]
fn the_pads_feel_a_squeezed_box_where_it_touches_them_and_as_hard() {
    let scene = over_the_box(0.9);
    let mut world = World::new(&scene, &Mismatch::none(), 0).unwrap();
    let mut holder = Holder::new();
    let cells = RobotModel::shipped().unwrap().extra.tactile.cells(0);
    let mut seen = 0;
    for tick in 0..600 {
        let mut commands = JointCommands::idle(tick);
        commands.hand =
            [HandCommand::Torque(0.6), HandCommand::Torque(0.6), HandCommand::Torque(0.6), HandCommand::Position(0.0)];
        commands.arm_tau_nm = holder.torques(&world.readings(), &scene.arm_start_rad, &[0.0; 7], &[0.0; 7]);
        world.tick(&commands).unwrap();
        let Some(image) = world.tactile().filter(|image| tick > 500 && image.pad < 3) else { continue };
        seen += 1;
        let link = PAD_LINKS[image.pad as usize];
        let world_from_tip = world.robot.hand_link_pose(&world.physics, link);
        // The box's face is the plane y = const nearest to the tip: the cell nearest to it feels most.
        let strongest =
            (0..PAD_CELLS).max_by(|a, b| image.pressure_n_cm2[*a].total_cmp(&image.pressure_n_cm2[*b])).unwrap();
        let gap = |cell: &model::Cell| ((world_from_tip * cell.centre_m).y - world.object_pose().translation.y).abs();
        let nearest = cells.iter().map(gap).fold(f32::MAX, f32::min);
        let gap_m = gap(&cells[strongest]) - nearest;
        let total_n: f32 = cells.iter().zip(image.pressure_n_cm2).map(|(c, p)| c.area_m2 * 1e4 * p).sum();
        let force_n = world.link_forces_n()[link];
        println!(
            "pad {}: {total_n:.2} N of {force_n:.2} N, strongest cell {strongest}, {:.2} mm farther from the face than the nearest",
            image.pad,
            gap_m * 1e3
        );
        assert!(gap_m < 1.5e-3);
        assert!((0.6..1.1).contains(&(total_n / force_n)), "{total_n} of {force_n} N");
    }
    assert!(seen >= 20, "{seen} images");
}

#[test]
fn a_box_too_heavy_for_its_grip_slides_out_at_coulombs_pace_and_the_gauges_show_it() {
    let scene = Scene { mass_kg: 1.8, pad_friction: 0.3, ..over_the_box(0.3) };
    let mut world = World::new(&scene, &Mismatch::none(), 1).unwrap();
    let mut holder = Holder::new();
    let mut slid = Vec::new();
    let (mut friction_n, mut ticks) = (0.0, 0.0);
    let (mut torque_nm, mut centres_mm) = (Vec::new(), Vec::new());
    for tick in 0..1100 {
        let mut commands = JointCommands::idle(tick);
        let squeeze_nm = if tick < 200 { 0.5 } else { 1.0 };
        commands.hand = [HandCommand::Torque(squeeze_nm); 4];
        commands.hand[3] = HandCommand::Position(0.0);
        commands.arm_tau_nm = holder.torques(&world.readings(), &scene.arm_start_rad, &[0.0; 7], &[0.0; 7]);
        world.tick(&commands).unwrap();
        if let Some(image) = world.tactile().filter(|image| image.pad == 2 && tick > 900) {
            let cells = tactus_common::robot::FINGERTIP_TAXELS.iter().zip(image.pressure_n_cm2);
            let (force, moment) = cells.fold((0.0, [0.0; 3]), |(force, moment), (cell, p)| {
                let n = p * cell.area_m2;
                (force + n, core::array::from_fn(|i| moment[i] + n * cell.centre_m[i]))
            });
            centres_mm.push((tick, moment.map(|m| (m / force * 1e4).round() / 10.0)));
        }
        if tick == 1000 {
            world.remove_table();
        }
        // Table gone and the grip's spring settled; the box still between the pads.
        if (1010..1060).contains(&tick) {
            slid.push(-world.object_pose().translation.z);
            friction_n += scene.pad_friction * world.link_forces_n().iter().sum::<f32>();
            ticks += 1.0;
        }
        if tick > 990 && tick % 20 == 0 {
            torque_nm.push((tick, world.readings().tip_torque_nm));
        }
    }
    // Second difference of heights in the world: the hand itself yields to the weight that has come onto it.
    let [first, middle, last] = [slid[0], slid[slid.len() / 2 - 1], slid[slid.len() - 2]];
    let apart_s = (slid.len() / 2 - 1) as f32 * TICK_S;
    let measured = (last - 2.0 * middle + first) / (apart_s * apart_s);
    let expected = 9.81 - friction_n / ticks / scene.mass_kg;
    println!(
        "a box of 1.8 kg slides at {measured:.2} m/s^2, Coulomb: {expected:.2}; by {:.1} mm in {:.3} s; fingertip torques {torque_nm:?} Nm; centre of \
         pressure of F3 {centres_mm:?} mm",
        (last - first) * 1e3,
        2.0 * apart_s
    );
    assert!((measured / expected - 1.0).abs() < 0.1);
    let changed_nm = (0..3).map(|f| (torque_nm[3].1[f] - torque_nm[0].1[f]).abs()).fold(0.0, f32::max);
    assert!(changed_nm > 0.02, "the gauges feel the weight come onto them: {changed_nm}");
}
