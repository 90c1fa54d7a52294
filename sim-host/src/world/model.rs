//! The robot as the world needs it, read from the URDF and the TOML beside it (`common/models`).
//!
//! Own reader on `urdf-rs`: it keeps what a physics engine needs (inertials, convex collision shapes, axes, limits,
//! damping) and drops the rest. Every number comes from those files; what no source states is in
//! [`super::hand::assumed`] and says so.

use super::error::WorldError;
use rapier3d::prelude::{MassProperties, Pose, Rotation, SharedShape, Vector};
use std::collections::BTreeMap;
use tactus_common::robot::source::{TOML, URDF, mesh};

mod settings;
pub use settings::{Arm, Cell, Collision, Drive, Extra, Hand, PalmPad, Tactile, TipPad, TipRow, TipTorque};

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
                    return Err(model_error(format!(
                        "joint `{}` names the link `{link}`, which is not there",
                        joint.name
                    )));
                }
            }
            match joint.joint_type {
                urdf_rs::JointType::Revolute => {
                    joints.insert(joint.name.clone(), read_joint(joint)?);
                }
                urdf_rs::JointType::Fixed if joint.name == extra.hand.mount_joint => mount = Some(pose(&joint.origin)),
                ref other => {
                    return Err(model_error(format!(
                        "joint `{}` is {other:?}; only revolute joints are known",
                        joint.name
                    )));
                }
            }
        }
        let mount =
            mount.ok_or_else(|| model_error(format!("the fixed joint `{}` is missing", extra.hand.mount_joint)))?;
        let model = Self { links, joints, mount, extra };
        let hand = &model.extra.hand;
        let wanted =
            model.extra.arm.joints.iter().chain(&hand.spread_joints).chain(&hand.inner_joints).chain(&hand.tip_joints);
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
                let hull =
                    SharedShape::convex_hull(&points).ok_or_else(|| bad(&format!("mesh `{filename}` has no hull")))?;
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
