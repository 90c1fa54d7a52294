//! The generated tables say what the files say, and damaged files are refused with a message that helps.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../build/arm.rs"]
mod arm;
#[path = "../build/generate.rs"]
mod generate;
#[path = "../build/hand.rs"]
mod hand;
#[path = "../build/model.rs"]
mod model;
#[path = "../build/settings.rs"]
mod settings;
#[path = "../build/spatial.rs"]
mod spatial;

use tactus_common::robot::source::{MESHES, TOML, URDF, mesh};
use tactus_common::robot::tables as t;
use tactus_common::robot::{HandLink, hand_prism};

fn loaded() -> urdf_rs::Robot {
    urdf_rs::read_from_string(URDF).unwrap()
}

fn joint<'a>(robot: &'a urdf_rs::Robot, name: &str) -> &'a urdf_rs::Joint {
    robot.joints.iter().find(|j| j.name == name).unwrap()
}

fn assert_limit(limit: &t::JointLimit, j: &urdf_rs::Joint) {
    let expected = [j.limit.lower, j.limit.upper, j.limit.velocity, j.limit.effort].map(|x| x as f32);
    assert_eq!([limit.lower_rad, limit.upper_rad, limit.velocity_rad_s, limit.torque_nm], expected, "{}", j.name);
}

fn assert_origin(origin: &t::JointOrigin, j: &urdf_rs::Joint) {
    let [r, p, y] = j.origin.rpy.0;
    let expected = nalgebra::UnitQuaternion::<f64>::from_euler_angles(r, p, y);
    assert_eq!(origin.xyz_m, j.origin.xyz.0.map(|x| x as f32), "{}", j.name);
    assert!(origin.isometry().rotation.cast::<f64>().angle_to(&expected) < 1e-6, "{}", j.name);
}

fn assert_inertial(i: &t::Inertial, link: &urdf_rs::Link) {
    let m = &link.inertial.inertia;
    assert_eq!(i.mass_kg, link.inertial.mass.value as f32, "{}", link.name);
    assert_eq!(i.com_m, link.inertial.origin.xyz.0.map(|x| x as f32), "{}", link.name);
    assert_eq!(i.inertia_kg_m2, [m.ixx, m.ixy, m.ixz, m.iyy, m.iyz, m.izz].map(|x| x as f32), "{}", link.name);
}

#[test]
fn the_arm_tables_are_those_of_the_file_loaded_at_run_time() {
    let robot = loaded();
    for i in 0..7 {
        let j = joint(&robot, &format!("wam_joint{}", i + 1));
        assert_limit(&t::ARM_LIMITS[i], j);
        assert_origin(&t::ARM_ORIGINS[i], j);
        assert_eq!(t::ARM_DAMPING_NMS_RAD[i], j.dynamics.as_ref().unwrap().damping as f32);
        assert_inertial(&t::ARM_INERTIALS[i], robot.links.iter().find(|l| l.name == j.child.link).unwrap());
    }
    assert_origin(&t::HAND_MOUNT, joint(&robot, "hand_mount"));
}

#[test]
fn the_hand_tables_are_those_of_the_file_loaded_at_run_time() {
    let robot = loaded();
    for finger in 0..3 {
        let inner = joint(&robot, &format!("finger{}_inner_joint", finger + 1));
        let tip = joint(&robot, &format!("finger{}_tip_joint", finger + 1));
        assert_limit(&t::FINGER_LIMIT, inner);
        assert_limit(&t::TIP_LIMIT, tip);
        assert_origin(&t::INNER_ORIGINS[finger], inner);
        assert_origin(&t::TIP_ORIGINS[finger], tip);
        if finger < 2 {
            let spread = joint(&robot, &format!("finger{}_spread", finger + 1));
            assert_limit(&t::SPREAD_LIMIT, spread);
            assert_origin(&t::SPREAD_ORIGINS[finger], spread);
        }
    }
    for link in HandLink::ALL {
        let found = robot.links.iter().find(|l| l.name == link.urdf_name()).unwrap();
        assert_inertial(&t::HAND_INERTIALS[link.index()], found);
        let urdf_rs::Geometry::Mesh { filename, .. } = &found.collision[0].geometry else { panic!("{}", found.name) };
        let vertices = mesh(filename).unwrap().lines().filter(|l| l.starts_with("v ")).count();
        assert_eq!(vertices, 2 * hand_prism(link).corners_m.len(), "{}", found.name);
    }
}

#[test]
fn the_settings_are_those_of_the_file_loaded_at_run_time() {
    let s: settings::Settings = toml::from_str(TOML).unwrap();
    assert_eq!(t::TRANSMISSION, s.arm.transmission.map(|x| x as f32));
    assert_eq!(t::ROTOR_INERTIA_KG_M2, s.arm.rotor_inertia_kg_m2.map(|x| x as f32));
    assert_eq!(t::MOUNT_YAW_RAD, s.mount.yaw_rad as f32);
    assert_eq!(t::GEAR_DISTAL_ABSOLUTE, 93.75);
    for (index, taxel) in t::FINGERTIP_TAXELS.iter().enumerate() {
        let row = &s.tactile.fingertip.rows_mm_deg[index / 3];
        let expected = [row.x, row.y, s.tactile.fingertip.columns_z_mm[index % 3]].map(|mm| (mm * 1e-3) as f32);
        assert_eq!(taxel.centre_m, expected, "cell {index} = 3 * row + column");
    }
}

#[test]
fn every_mesh_of_the_urdf_is_at_hand_and_closed() {
    for link in loaded().links {
        for shape in link.collision.iter().map(|c| &c.geometry).chain(link.visual.iter().map(|v| &v.geometry)) {
            if let urdf_rs::Geometry::Mesh { filename, .. } = shape {
                assert!(mesh(filename).is_some(), "{filename}");
            }
        }
    }
    for (name, text) in MESHES {
        // Closed and consistently oriented: every directed edge has its opposite exactly once.
        let mut edges = std::collections::BTreeMap::new();
        for face in text.lines().filter_map(|l| l.strip_prefix("f ")) {
            let f: Vec<usize> = face.split_whitespace().map(|w| w.parse().unwrap()).collect();
            for k in 0..f.len() {
                *edges.entry((f[k], f[(k + 1) % f.len()])).or_insert(0) += 1;
            }
        }
        assert!(edges.iter().all(|((a, b), n)| *n == 1 && edges.get(&(*b, *a)) == Some(&1)), "{name}");
    }
}

fn built(urdf: &str, toml: &str) -> Result<String, String> {
    generate::tables(urdf, toml, &|file| mesh(file).map(str::to_owned).ok_or_else(|| format!("models/{file}: missing")))
}

/// The damage must be refused, in one line that names file, place and expectation.
fn refused(urdf: &str, toml: &str, says: &[&str]) {
    let message = built(urdf, toml).expect_err("damage must be refused");
    assert!(!message.contains('\n'), "{message}");
    assert!(says.iter().all(|s| message.contains(s)), "{message} should say {says:?}");
}

fn damage(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "nothing to damage: {from}");
    text.replacen(from, to, 1)
}

#[test]
fn the_files_as_they_are_build() {
    assert!(built(URDF, TOML).unwrap().contains("pub const ARM_LIMITS"));
}

#[test]
fn a_damaged_urdf_stops_the_build_with_a_clear_message() {
    let cases: [(&str, &str, &[&str]); 10] = [
        ("</robot>", "", &["wam7_bh280.urdf", "not a readable URDF"]),
        ("joint name=\"wam_joint3\"", "joint name=\"elbow\"", &["wam_joint3", "expected one"]),
        (
            "<limit lower=\"-2.6\" upper=\"2.6\"",
            "<limit lower=\"2.6\" upper=\"-2.6\"",
            &["wam_joint1", "expected lower < upper"],
        ),
        ("xyz=\"0.045 0 0.55\"", "xyz=\"0.045 0.01 0.55\"", &["wam_joint4", "inverse kinematics expects"]),
        ("rpy=\"-1.5707963267948966 0 0\"", "rpy=\"-1.5 0 0\"", &["wam_joint2", "rpy"]),
        ("<mass value=\"10.76768767\"/>", "<mass value=\"-1\"/>", &["wam_link1", "above 0 kg"]),
        ("ixx=\"0.13488033\"", "ixx=\"-0.13488033\"", &["wam_link1", "positive definite"]),
        ("<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"0 1 0\"/>", &["finger1_spread", "axis"]),
        ("multiplier=\"0.3333333333333333\"", "multiplier=\"0.3214\"", &["finger1_tip_joint", "from the gears"]),
        ("velocity=\"1.5708\"", "velocity=\"0\"", &["wam_joint1", "above 0"]),
    ];
    for (from, to, says) in cases {
        refused(&damage(URDF, from, to), TOML, says);
    }
}

#[test]
fn a_damaged_toml_stops_the_build_with_a_clear_message() {
    let cases: [(&str, &str, &[&str]); 7] = [
        ("gear_spread = 17.5", "gear_spraed = 17.5", &["wam7_bh280.toml", "line", "gear_spraed"]),
        ("gear_distal_absolute = 93.75", "gear_distal_absolute = 90.0", &["gear_distal_absolute", "expected 93.75"]),
        ("transmission = [42.0,", "transmission = [41.0,", &["motor_from_joint", "column 0"]),
        ("transmission = [42.0, 28.25,", "transmission = [42.0,", &["line", "transmission"]),
        ("row_cells = [5, 7, 7, 5]", "row_cells = [5, 7, 7, 6]", &["row_cells", "24"]),
        ("{ x = 51.08, y = 7.19,", "{ x = 51.08, y = 9.19,", &["tactile.fingertip row 5", "off the tip's surface"]),
        ("ignore = [\n  [\"wam_link1\"", "ignore = [\n  [\"wam_lnik1\"", &["wam_lnik1", "expected one"]),
    ];
    for (from, to, says) in cases {
        refused(URDF, &damage(TOML, from, to), says);
    }
}

#[test]
fn a_damaged_mesh_stops_the_build_with_a_clear_message() {
    let with = |from: &str, to: &str| {
        let bent = damage(mesh("fingertip.obj").unwrap(), from, to);
        let read = |file: &str| Ok(if file == "fingertip.obj" { bent.clone() } else { mesh(file).unwrap().to_owned() });
        generate::tables(URDF, TOML, &read).expect_err("damage must be refused")
    };
    assert!(with("v 0 0.0095 -0.0115", "v 0 x -0.0115").contains("fingertip.obj: line"));
    assert!(with("v 0 0.0095 -0.0115", "v 0 0.0095 -0.01").contains("not a right prism"));
    let dent = damage(mesh("fingertip.obj").unwrap(), "v 0 0.0095 -0.0115", "v 0 0.001 -0.0115");
    let dent = damage(&dent, "v 0 0.0095 0.0115", "v 0 0.001 0.0115");
    let read = |file: &str| Ok(if file == "fingertip.obj" { dent.clone() } else { mesh(file).unwrap().to_owned() });
    let message = generate::tables(URDF, TOML, &read).expect_err("a dent must be refused");
    assert!(message.contains("finger1_tip") && message.contains("convex"), "{message}");
}
