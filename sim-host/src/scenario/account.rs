//! A scene in words.

use super::Scenario;
use std::fmt::Write;
use tactus_common::robot::MOUNT;
use tactus_common::shape::ObjectShape;

/// What a scene is, a few lines.
pub fn account(scenario: &Scenario) -> String {
    let Scenario { object, table, .. } = scenario;
    let mut out = String::new();
    let pose = |[x, y, phi]: [f32; 3]| format!("({x}, {y}) m, {phi} rad");
    // Writing to a String cannot fail.
    let _ = writeln!(out, "{}", scenario.name);
    if !scenario.summary.is_empty() {
        let _ = writeln!(out, "  {}", scenario.summary);
    }
    let [x, y, _] = table.size_m;
    let _ = writeln!(out, "  table       {x} x {y} m, friction {}", table.friction);
    let _ = writeln!(
        out,
        "  object      {}, {} kg, friction {} on the pads, at {}",
        describe(&object.shape),
        object.mass_kg,
        object.friction,
        pose(object.true_pose)
    );
    for other in &scenario.others {
        let kind = other.free_kg.map_or("fixed".to_owned(), |mass_kg| format!("{mass_kg} kg, free"));
        let _ = writeln!(
            out,
            "  {:<11} {}, {kind}, at {}",
            other.name,
            describe(&other.shape),
            pose(other.pose.to_array())
        );
    }
    if scenario.robot_base != MOUNT {
        let _ = writeln!(out, "  robot       its base at {}", pose(scenario.robot_base.to_array()));
    }
    let [dx, dy] = scenario.displacement_m;
    let _ = writeln!(out, "  goal        displaced by ({dx}, {dy}) m");
    if let Some(guess) = object.guess {
        let _ = writeln!(out, "  guess       {}", pose(guess));
    }
    if let Some([x, y, phi]) = object.interval {
        let _ = writeln!(out, "  interval    +-({x}, {y}) m, +-{phi} rad");
    }
    out
}

/// A shape in a few words, metres.
fn describe(shape: &ObjectShape) -> String {
    match shape {
        ObjectShape::Cuboid { half_extents_m } => {
            let [x, y, z] = half_extents_m.map(|h| 2.0 * h);
            format!("box {x} x {y} x {z} m")
        }
        ObjectShape::Cylinder { radius_m, half_height_m } => {
            format!("cylinder {} m wide, {} m high", 2.0 * radius_m, 2.0 * half_height_m)
        }
        ObjectShape::Sphere { radius_m } => format!("sphere {} m wide", 2.0 * radius_m),
        ObjectShape::Capsule { radius_m, half_length_m } => {
            format!("capsule {} m wide, {} m long", 2.0 * radius_m, 2.0 * (half_length_m + radius_m))
        }
        ObjectShape::Convex(hull) => {
            let [x, y, z] = hull.half_extents_m().map(|h| 2.0 * h);
            let (corners, faces) = (hull.corners_m().len(), hull.faces().count());
            format!("convex solid {x:.3} x {y:.3} x {z:.3} m, {corners} corners, {faces} faces")
        }
    }
}
