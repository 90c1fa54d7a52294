//! The TOML beside the URDF: what URDF cannot say.

use rapier3d::prelude::Vector;
use serde::Deserialize;

/// `[arm]` of the TOML.
#[derive(Clone, Debug, Deserialize)]
pub struct Arm {
    /// Link that stands on the floor.
    pub base: String,
    /// The seven joints.
    pub joints: [String; 7],
    /// Motor turns per joint turn.
    pub transmission: [f32; 7],
    /// Rotor inertia seen at the joint, kg m^2.
    pub rotor_inertia_kg_m2: [f32; 7],
    /// Encoder counts per motor turn.
    pub encoder_counts_per_motor_turn: f32,
    /// Motor angles = rows . joint angles.
    pub motor_from_joint: [[f64; 7]; 7],
    /// Proportional gains of Barrett's position loop, N m/rad.
    pub position_loop_kp_nm_rad: [f32; 7],
    /// Derivative gains of the same, N m s/rad.
    pub position_loop_kd_nms_rad: [f32; 7],
}

/// `[collision]` of the TOML.
#[derive(Clone, Debug, Deserialize)]
pub struct Collision {
    /// Pairs of links that touch by construction.
    pub ignore: Vec<[String; 2]>,
}

/// `[hand.drive]` of the TOML.
#[derive(Clone, Debug, Deserialize)]
pub struct Drive {
    /// Motor turns per turn of the inner link.
    pub gear_inner: f32,
    /// Motor turns per turn of the spread.
    pub gear_spread: f32,
    /// Secondary encoder turns per turn of the inner link.
    pub gear_secondary: f32,
    /// Counts per motor turn.
    pub motor_counts_per_turn: f32,
    /// Counts per turn of the secondary encoder.
    pub secondary_counts_per_turn: f32,
    /// Peak torque of a finger motor, N m.
    pub motor_torque_peak_nm: f32,
    /// Torque of the spread at the joint, N m.
    pub spread_torque_nm: f32,
    /// Torque of the inner link at which the clutch lets go, N m.
    pub breakaway_torque_nm: f32,
    /// Speed of a finger's inner link, rad/s.
    pub finger_speed_rad_s: f32,
    /// Speed of the spread, rad/s.
    pub spread_speed_rad_s: f32,
    /// Acceleration of a finger, rad/s^2.
    pub finger_acceleration_rad_s2: f32,
}

/// `[hand.tip_torque]` of the TOML.
#[derive(Clone, Debug, Deserialize)]
pub struct TipTorque {
    /// Range, +- N m.
    pub range_nm: f32,
    /// One count, N m.
    pub resolution_nm: f32,
}

/// `[hand]` of the TOML.
#[derive(Clone, Debug, Deserialize)]
pub struct Hand {
    /// Fixed joint between flange and palm.
    pub mount_joint: String,
    /// The nine links, in the order of a contact matrix.
    pub links: [String; 9],
    /// Spread joints of F1 and F2.
    pub spread_joints: [String; 2],
    /// Inner joints of F1, F2, F3.
    pub inner_joints: [String; 3],
    /// Distal joints of F1, F2, F3.
    pub tip_joints: [String; 3],
    /// Motors and gears.
    pub drive: Drive,
    /// Strain gauges.
    pub tip_torque: TipTorque,
}

/// One row of cells on a fingertip: x, y of the centre and length along the surface (mm), tilt (degrees).
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct TipRow {
    x: f32,
    y: f32,
    length: f32,
    tilt: f32,
}

/// `[tactile.fingertip]` of the TOML.
#[derive(Clone, Debug, Deserialize)]
pub struct TipPad {
    rows_mm_deg: [TipRow; 8],
    columns_z_mm: [f32; 3],
    cell_width_mm: f32,
}

/// `[tactile.palm]` of the TOML.
#[derive(Clone, Debug, Deserialize)]
pub struct PalmPad {
    z_mm: f32,
    rows_x_mm: [f32; 4],
    row_cells: [usize; 4],
    pitch_y_mm: f32,
    cell_mm: [f32; 2],
}

/// `[tactile]` of the TOML.
#[derive(Clone, Debug, Deserialize)]
pub struct Tactile {
    /// Largest pressure, N/cm^2.
    pub full_scale_n_cm2: f32,
    /// One count, N/cm^2.
    pub step_n_cm2: f32,
    /// Cells of a fingertip.
    pub fingertip: TipPad,
    /// Cells of the palm.
    pub palm: PalmPad,
}

/// One tactile cell, in its link's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Centre, metres.
    pub centre_m: Vector,
    /// Outward normal.
    pub normal: Vector,
    /// Area, m^2.
    pub area_m2: f32,
}

impl Tactile {
    /// The cells of pad 0..2 (a fingertip, tip frame) or 3 (the palm, hand frame), in the model's order.
    pub fn cells(&self, pad: usize) -> Vec<Cell> {
        let mut cells = Vec::new();
        if pad < 3 {
            for row in &self.fingertip.rows_mm_deg {
                let (s, c) = libm::sincosf(row.tilt.to_radians());
                for z in &self.fingertip.columns_z_mm {
                    cells.push(Cell {
                        centre_m: Vector::new(row.x, row.y, *z) * 1e-3,
                        normal: Vector::new(s, c, 0.0),
                        area_m2: row.length * self.fingertip.cell_width_mm * 1e-6,
                    });
                }
            }
        } else {
            for (x, count) in self.palm.rows_x_mm.iter().zip(self.palm.row_cells) {
                for k in 0..count {
                    let y = (k as f32 - (count as f32 - 1.0) / 2.0) * self.palm.pitch_y_mm;
                    cells.push(Cell {
                        centre_m: Vector::new(*x, y, self.palm.z_mm) * 1e-3,
                        normal: Vector::Z,
                        area_m2: self.palm.cell_mm[0] * self.palm.cell_mm[1] * 1e-6,
                    });
                }
            }
        }
        cells
    }
}

/// The TOML beside the URDF.
#[derive(Clone, Debug, Deserialize)]
pub struct Extra {
    /// The arm's drives.
    pub arm: Arm,
    /// Pairs never checked.
    pub collision: Collision,
    /// The hand.
    pub hand: Hand,
    /// The pads.
    pub tactile: Tactile,
}
