//! The robot as the world needs it, read from the URDF and the TOML beside it (`common/models`).
//!
//! Own reader on `urdf-rs`: it keeps what a physics engine needs (inertials, convex collision shapes, axes, limits,
//! damping) and drops the rest. Every number comes from those files; what no source states is in
//! [`super::assumed`] and says so.

use super::error::WorldError;
use rapier3d::prelude::{MassProperties, Pose, Rotation, SharedShape, Vector};
use serde::Deserialize;
use std::collections::BTreeMap;
use tactus_common::robot::source::{TOML, URDF, mesh};

/// One link: mass and convex collision shapes, in the link's frame.
#[derive(Clone)]
pub struct LinkModel {
    /// Name in the URDF.
    pub name: String,
    /// Mass, kg.
    pub mass_kg: f32,
    /// Mass, centre of mass and inertia.
    pub mass_properties: MassProperties,
    /// Collision shapes and their poses in the link's frame.
    pub shapes: Vec<(Pose, SharedShape)>,
}

/// One revolute joint.
#[derive(Clone, Debug)]
pub struct JointModel {
    /// Name in the URDF.
    pub name: String,
    /// Parent link.
    pub parent: String,
    /// Child link.
    pub child: String,
    /// Child-from-parent origin at angle 0.
    pub origin: Pose,
    /// Axis in the child's frame, unit length.
    pub axis: Vector,
    /// Range, radians.
    pub range_rad: [f32; 2],
    /// Viscous damping, N m s/rad.
    pub damping_nms_rad: f32,
    /// Largest torque, N m.
    pub effort_nm: f32,
}

/// `[mount]` of the TOML.
#[derive(Clone, Debug, Deserialize)]
pub struct Mount {
    /// World x of the axis of J1, metres.
    pub x_m: f32,
    /// World y, metres.
    pub y_m: f32,
    /// Height of the base's bottom face, metres.
    pub z_m: f32,
    /// Yaw of the base, radians.
    pub yaw_rad: f32,
}

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
    /// Where the arm stands.
    pub mount: Mount,
    /// The arm's drives.
    pub arm: Arm,
    /// Pairs never checked.
    pub collision: Collision,
    /// The hand.
    pub hand: Hand,
    /// The pads.
    pub tactile: Tactile,
}

/// The whole robot.
#[derive(Clone)]
pub struct RobotModel {
    /// Links by name.
    pub links: BTreeMap<String, LinkModel>,
    /// Revolute joints by name.
    pub joints: BTreeMap<String, JointModel>,
    /// Palm-from-link-7 pose of the hand's mounting.
    pub mount: Pose,
    /// What the URDF cannot say.
    pub extra: Extra,
}

fn model_error(text: impl core::fmt::Display) -> WorldError {
    WorldError::Model(text.to_string())
}

impl RobotModel {
    /// The robot description that this program was built with.
    pub fn shipped() -> Result<Self, WorldError> {
        Self::parse(URDF, TOML, |name| mesh(name).map(str::to_owned))
    }

    /// Reads a description; `mesh` finds the text of a mesh file by its name.
    pub fn parse(urdf: &str, toml: &str, mesh: impl Fn(&str) -> Option<String>) -> Result<Self, WorldError> {
        let robot = urdf_rs::read_from_string(urdf).map_err(model_error)?;
        let extra: Extra = toml::from_str(toml).map_err(|e| model_error(e.message()))?;
        let mut links = BTreeMap::new();
        for link in &robot.links {
            links.insert(link.name.clone(), read_link(link, &mesh)?);
        }
        let mut joints = BTreeMap::new();
        let mut mount = None;
        for joint in &robot.joints {
            for link in [&joint.parent.link, &joint.child.link] {
                if !links.contains_key(link) {
                    return Err(model_error(format!("joint `{}` names the link `{link}`, which is not there", joint.name)));
                }
            }
            match joint.joint_type {
                urdf_rs::JointType::Revolute => {
                    joints.insert(joint.name.clone(), read_joint(joint)?);
                }
                urdf_rs::JointType::Fixed if joint.name == extra.hand.mount_joint => mount = Some(pose(&joint.origin)),
                ref other => {
                    return Err(model_error(format!("joint `{}` is {other:?}; only revolute joints are known", joint.name)));
                }
            }
        }
        let mount = mount.ok_or_else(|| model_error(format!("the fixed joint `{}` is missing", extra.hand.mount_joint)))?;
        let model = Self { links, joints, mount, extra };
        let hand = &model.extra.hand;
        let wanted = model.extra.arm.joints.iter().chain(&hand.spread_joints).chain(&hand.inner_joints).chain(&hand.tip_joints);
        for name in wanted {
            model.joint(name)?;
        }
        for pad in 0..4 {
            let count = model.extra.tactile.cells(pad).len();
            if count != tactus_common::limits::PAD_CELLS {
                return Err(model_error(format!("pad {pad} has {count} cells, expected 24")));
            }
        }
        for name in hand.links.iter().chain([&model.extra.arm.base]) {
            model.link(name)?;
        }
        Ok(model)
    }

    /// A link by name.
    pub fn link(&self, name: &str) -> Result<&LinkModel, WorldError> {
        self.links.get(name).ok_or_else(|| model_error(format!("the link `{name}` is missing")))
    }

    /// A joint by name.
    pub fn joint(&self, name: &str) -> Result<&JointModel, WorldError> {
        self.joints.get(name).ok_or_else(|| model_error(format!("the joint `{name}` is missing")))
    }

    /// `true` if the two links are neighbours or listed as touching by construction.
    pub fn touch_by_construction(&self, a: &str, b: &str) -> bool {
        a == b
            || self.joints.values().any(|j| (j.parent == a && j.child == b) || (j.parent == b && j.child == a))
            || self.extra.collision.ignore.iter().any(|[p, q]| (p == a && q == b) || (p == b && q == a))
    }
}

fn vector(v: &urdf_rs::Vec3) -> Vector {
    Vector::new(v.0[0] as f32, v.0[1] as f32, v.0[2] as f32)
}

/// URDF's fixed-axis roll, pitch, yaw; computed in f64 and rounded once, so that a quarter turn is one.
fn pose(origin: &urdf_rs::Pose) -> Pose {
    let [roll, pitch, yaw] = origin.rpy.0.map(|a| a / 2.0);
    let (sr, cr) = libm::sincos(roll);
    let (sp, cp) = libm::sincos(pitch);
    let (sy, cy) = libm::sincos(yaw);
    let rotation = Rotation::from_xyzw(
        (sr * cp * cy - cr * sp * sy) as f32,
        (cr * sp * cy + sr * cp * sy) as f32,
        (cr * cp * sy - sr * sp * cy) as f32,
        (cr * cp * cy + sr * sp * sy) as f32,
    );
    Pose::from_parts(vector(&origin.xyz), rotation.normalize())
}

fn read_link(link: &urdf_rs::Link, mesh: &impl Fn(&str) -> Option<String>) -> Result<LinkModel, WorldError> {
    let bad = |what: &str| model_error(format!("link `{}`: {what}", link.name));
    let inertial = &link.inertial;
    let mass_kg = inertial.mass.value as f32;
    if !(mass_kg > 0.0 && mass_kg.is_finite()) {
        return Err(bad("its mass must be positive"));
    }
    let i = &inertial.inertia;
    let tensor = nalgebra::Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
    if !tensor.iter().all(|x| x.is_finite()) || nalgebra::Cholesky::new(tensor).is_none() {
        return Err(bad("its inertia is not positive definite"));
    }
    let frame = pose(&inertial.origin);
    let columns = tensor.map(|x| x as f32);
    let matrix = rapier3d::math::Matrix::from_cols_array(&columns.as_slice().try_into().expect("nine elements"));
    let about_com = MassProperties::with_inertia_matrix(Vector::ZERO, mass_kg, matrix);
    let mut shapes = Vec::new();
    for collision in &link.collision {
        let at = pose(&collision.origin);
        match &collision.geometry {
            urdf_rs::Geometry::Box { size } => {
                let half = vector(size) * 0.5;
                shapes.push((at, SharedShape::cuboid(half.x, half.y, half.z)));
            }
            urdf_rs::Geometry::Cylinder { radius, length } => {
                // URDF's cylinder stands along z, rapier's along y.
                let turn = Pose::from_rotation(Rotation::from_rotation_arc(Vector::Y, Vector::Z));
                shapes.push((at * turn, SharedShape::cylinder(*length as f32 * 0.5, *radius as f32)));
            }
            urdf_rs::Geometry::Mesh { filename, .. } => {
                let text = mesh(filename).ok_or_else(|| bad(&format!("mesh `{filename}` is missing")))?;
                let points = obj_vertices(&text).ok_or_else(|| bad(&format!("mesh `{filename}` cannot be read")))?;
                let hull = SharedShape::convex_hull(&points).ok_or_else(|| bad(&format!("mesh `{filename}` has no hull")))?;
                shapes.push((at, hull));
            }
            other => return Err(bad(&format!("collision shape {other:?} is not known"))),
        }
    }
    Ok(LinkModel { name: link.name.clone(), mass_kg, mass_properties: about_com.transform_by(&frame), shapes })
}

fn obj_vertices(text: &str) -> Option<Vec<Vector>> {
    let mut points = Vec::new();
    for line in text.lines().filter_map(|l| l.strip_prefix("v ")) {
        let mut numbers = line.split_whitespace().map(str::parse::<f32>);
        let (x, y, z) = (numbers.next()?.ok()?, numbers.next()?.ok()?, numbers.next()?.ok()?);
        points.push(Vector::new(x, y, z));
    }
    (points.len() >= 4).then_some(points)
}

fn read_joint(joint: &urdf_rs::Joint) -> Result<JointModel, WorldError> {
    let axis = vector(&joint.axis.xyz);
    let sound = axis.length() > 0.5 && joint.limit.lower < joint.limit.upper; // false for NaN
    if !sound {
        return Err(model_error(format!("joint `{}`: it needs an axis and a range", joint.name)));
    }
    Ok(JointModel {
        name: joint.name.clone(),
        parent: joint.parent.link.clone(),
        child: joint.child.link.clone(),
        origin: pose(&joint.origin),
        axis: axis.normalize(),
        range_rad: [joint.limit.lower as f32, joint.limit.upper as f32],
        damping_nms_rad: joint.dynamics.as_ref().map_or(0.0, |d| d.damping as f32),
        effort_nm: joint.limit.effort as f32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shipped_model_weighs_what_the_sources_say() {
        let model = RobotModel::shipped().unwrap();
        let hand_kg: f32 = model.extra.hand.links.iter().map(|l| model.link(l).unwrap().mass_kg).sum();
        assert!((hand_kg - 1.202).abs() < 0.001, "hand {hand_kg} kg");
        assert_eq!(model.joints.len(), 15);
    }

    #[test]
    fn a_damaged_description_is_refused_with_its_place() {
        let mesh = |name: &str| mesh(name).map(str::to_owned);
        let cut = RobotModel::parse(&URDF[..URDF.len() / 2], TOML, mesh);
        assert!(matches!(cut, Err(WorldError::Model(_))));
        let renamed = URDF.replace("name=\"wam_joint4\"", "name=\"elbow\"");
        let message = RobotModel::parse(&renamed, TOML, mesh).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains("wam_joint4"), "{message}");
        let weightless = URDF.replace("<mass value=\"0.60858\"/>", "<mass value=\"-1\"/>");
        let message = RobotModel::parse(&weightless, TOML, mesh).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains("hand_palm"), "{message}");
        assert!(RobotModel::parse(URDF, TOML, |_| None).is_err());
    }
}
