//! Which numbers of a scene file make sense, each by itself.

use super::format::{MismatchScales, NoiseScales, Region, SceneFile};
use super::mistake::Mistake;

/// Refuses a field whose value makes no sense, whatever the others are. Shapes are checked where they are made.
pub fn numbers(file: &SceneFile) -> Result<(), Mistake> {
    within("robot_base_pose", &file.robot_base_pose, [-10.0, 10.0], "m and rad")?;
    positive("table.size_m", &file.table.size_m, 10.0)?;
    positive("table.friction", &[file.table.friction], 3.0)?;
    let object = &file.object;
    within("object.mass_kg", &[object.mass_kg], [0.01, 10.0], "kg")?;
    positive("object.friction", &[object.friction], 3.0)?;
    finite("object.true_pose", &object.true_pose)?;
    if let Some(guess) = &object.guess {
        finite("object.guess", guess)?;
    }
    if let Some(interval) = &object.interval {
        within("object.interval", interval, [0.0, 10.0], "m and rad")?;
    }
    finite("displacement_m", &file.displacement_m)?;
    let NoiseScales { tactile, tip_torque, effort } = file.noise;
    for (field, scale) in [("noise.tactile", tactile), ("noise.tip_torque", tip_torque), ("noise.effort", effort)] {
        within(field, &[scale], [0.0, 10.0], "")?;
    }
    let MismatchScales { friction, mass, size, robot, sensors, latency } = file.mismatch;
    for (field, scale) in [
        ("mismatch.friction", friction),
        ("mismatch.mass", mass),
        ("mismatch.size", size),
        ("mismatch.robot", robot),
        ("mismatch.sensors", sensors),
        ("mismatch.latency", latency),
    ] {
        within(field, &[scale], [0.0, 2.0], "")?;
    }
    let Region { x_m, y_m, phi_rad } = file.trials;
    for (field, range) in [("trials.x_m", x_m), ("trials.y_m", y_m), ("trials.phi_rad", phi_rad)] {
        if !(range.iter().all(|v| v.is_finite()) && range[0] <= range[1]) {
            return Err(Mistake::new(field, format!("{range:?}: expected two finite numbers, the smaller first")));
        }
    }
    Ok(())
}

/// Refuses values outside `min..=max`.
pub fn within(field: &str, values: &[f32], [min, max]: [f32; 2], unit: &str) -> Result<(), Mistake> {
    let Some(bad) = values.iter().find(|v| !(min..=max).contains(*v)) else { return Ok(()) };
    let above = if min > 0.0 { " above zero" } else { "" };
    Err(Mistake::new(field, format!("{bad}: expected a finite number{above}, from {min} to {max} {unit}").trim_end()))
}

/// Refuses values that are not above zero, or above `max`.
fn positive(field: &str, values: &[f32], max: f32) -> Result<(), Mistake> {
    let Some(bad) = values.iter().find(|v| !(**v > 0.0 && **v <= max)) else { return Ok(()) };
    Err(Mistake::new(field, format!("{bad}: expected a finite number above zero, at most {max}")))
}

/// Refuses values that are not finite.
pub fn finite(field: &str, values: &[f32]) -> Result<(), Mistake> {
    let Some(bad) = values.iter().find(|v| !v.is_finite()) else { return Ok(()) };
    Err(Mistake::new(field, format!("{bad}: expected a finite number")))
}

/// Refuses what would not be one line of a list.
pub fn one_line(field: &str, text: String) -> Result<String, Mistake> {
    if text.chars().any(char::is_control) || text.chars().count() > 200 {
        return Err(Mistake::new(field, "expected one line of at most 200 characters"));
    }
    Ok(text)
}
