//! The TOML beside the URDF: its schema, and what must hold between its numbers.

use serde::Deserialize;

/// Name used in messages.
pub const FILE: &str = "models/wam7_bh280.toml";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    pub mount: Mount,
    pub arm: Arm,
    pub collision: Collision,
    pub hand: Hand,
    pub tactile: Tactile,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mount {
    pub x_m: f64,
    pub y_m: f64,
    pub z_m: f64,
    pub yaw_rad: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arm {
    pub base: String,
    pub joints: [String; 7],
    pub transmission: [f64; 7],
    pub rotor_inertia_kg_m2: [f64; 7],
    pub encoder_counts_per_motor_turn: u32,
    pub torque_continuous_nm: [f64; 7],
    pub position_loop_kp_nm_rad: [f64; 7],
    pub position_loop_kd_nms_rad: [f64; 7],
    pub position_loop_limit_nm: [f64; 7],
    pub motor_from_joint: [[f64; 7]; 7],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Collision {
    pub ignore: Vec<[String; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hand {
    pub mount_joint: String,
    pub links: [String; 9],
    pub spread_joints: [String; 2],
    pub inner_joints: [String; 3],
    pub tip_joints: [String; 3],
    pub palm_face_z_m: f64,
    pub grasp_point_z_m: f64,
    pub pad_point_m: [f64; 2],
    pub tip_length_m: f64,
    pub drive: Drive,
    pub tip_torque: TipTorque,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    pub gear_inner: f64,
    pub gear_distal_engaged: f64,
    pub gear_distal_absolute: f64,
    pub gear_spread: f64,
    pub gear_secondary: f64,
    pub motor_counts_per_turn: u32,
    pub secondary_counts_per_turn: u32,
    pub motor_torque_continuous_nm: f64,
    pub motor_torque_peak_nm: f64,
    pub spread_torque_nm: f64,
    pub breakaway_torque_nm: f64,
    pub finger_speed_rad_s: f64,
    pub spread_speed_rad_s: f64,
    pub finger_acceleration_rad_s2: f64,
    pub breakaway_counts: u32,
    pub tip_load_max_kg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TipTorque {
    pub range_nm: f64,
    pub protect_nm: f64,
    pub zero_counts: u32,
    pub resolution_nm: f64,
    pub counts_max: u32,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tactile {
    pub full_scale_n_cm2: f64,
    pub step_n_cm2: f64,
    pub rate_hz_default: f64,
    pub rate_hz_max: f64,
    pub tare_samples: u32,
    pub fingertip: FingertipPad,
    pub palm: PalmPad,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FingertipPad {
    pub rows_mm_deg: [TaxelRow; 8],
    pub columns_z_mm: [f64; 3],
    pub cell_width_mm: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaxelRow {
    pub x: f64,
    pub y: f64,
    pub length: f64,
    pub tilt: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PalmPad {
    pub z_mm: f64,
    pub rows_x_mm: [f64; 4],
    pub row_cells: [u32; 4],
    pub pitch_y_mm: f64,
    pub cell_mm: [f64; 2],
}

/// Parses and checks the settings.
pub fn parse(text: &str) -> Result<Settings, String> {
    let settings: Settings = toml::from_str(text).map_err(|e| {
        let start = e.span().map_or(0, |s| s.start);
        let index = text.get(..start).map_or(0, |before| before.matches('\n').count());
        let key = text.lines().nth(index).and_then(|l| l.split('=').next()).unwrap_or("").trim();
        format!("{FILE}: line {}: `{key}`: {}", index + 1, e.message().replace('\n', " "))
    })?;
    check_arm(&settings.arm)?;
    check_drive(&settings.hand.drive)?;
    let cells: u32 = settings.tactile.palm.row_cells.iter().sum();
    if cells != 24 {
        return Err(format!("{FILE}: tactile.palm.row_cells: sum is {cells}; expected the 24 cells of a pad"));
    }
    Ok(settings)
}

/// Every entry of `values` must be a finite number above zero.
fn positive(key: &str, values: &[f64]) -> Result<(), String> {
    match values.iter().position(|v| !v.is_finite() || *v <= 0.0) {
        Some(i) => Err(format!("{FILE}: {key}[{i}] is {}; expected a number above 0", values[i])),
        None => Ok(()),
    }
}

fn check_arm(arm: &Arm) -> Result<(), String> {
    positive("arm.transmission", &arm.transmission)?;
    positive("arm.rotor_inertia_kg_m2", &arm.rotor_inertia_kg_m2)?;
    positive("arm.torque_continuous_nm", &arm.torque_continuous_nm)?;
    positive("arm.position_loop_kp_nm_rad", &arm.position_loop_kp_nm_rad)?;
    positive("arm.position_loop_kd_nms_rad", &arm.position_loop_kd_nms_rad)?;
    positive("arm.position_loop_limit_nm", &arm.position_loop_limit_nm)?;
    for joint in 0..7 {
        let largest = arm.motor_from_joint.iter().map(|row| row[joint].abs()).fold(0.0, f64::max);
        if (largest - arm.transmission[joint]).abs() > 1e-9 {
            return Err(format!(
                "{FILE}: arm.motor_from_joint: column {joint} has magnitude {largest}; expected arm.transmission[{joint}] = {}",
                arm.transmission[joint]
            ));
        }
    }
    Ok(())
}

fn check_drive(d: &Drive) -> Result<(), String> {
    let gears = [d.gear_inner, d.gear_distal_engaged, d.gear_distal_absolute, d.gear_spread, d.gear_secondary];
    positive("hand.drive.gear_*", &gears)?;
    let torques = [d.motor_torque_continuous_nm, d.motor_torque_peak_nm, d.spread_torque_nm, d.breakaway_torque_nm];
    positive("hand.drive.*_torque_*", &torques)?;
    let speeds = [d.finger_speed_rad_s, d.spread_speed_rad_s, d.finger_acceleration_rad_s2, d.tip_load_max_kg];
    positive("hand.drive.*_speed_*", &speeds)?;
    // One motor turns both links: the tip's rate against the palm is the sum of both rates.
    let sum = 1.0 / d.gear_inner + 1.0 / d.gear_distal_engaged;
    if (sum * d.gear_distal_absolute - 1.0).abs() > 1e-9 {
        return Err(format!(
            "{FILE}: hand.drive.gear_distal_absolute is {}; expected {} = 1 / (1 / gear_inner + 1 / gear_distal_engaged)",
            d.gear_distal_absolute,
            1.0 / sum
        ));
    }
    Ok(())
}
