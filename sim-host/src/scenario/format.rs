//! The format of a scene file, as it is written: TOML, its JSON schema made from these types.
//!
//! Lengths in metres, masses in kilograms, angles in radians. The world's frame has its origin on the table's top, in
//! its middle, z up; poses are `[x, y, phi]`.

use schemars::JsonSchema;
use serde::Deserialize;
use std::f32::consts::FRAC_PI_4;
use std::path::PathBuf;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::robot::MOUNT;

/// A scene: what stands where on the table, which object is to be carried and how far.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Tactus scene")]
pub struct SceneFile {
    /// Name, for reports.
    #[serde(default = "unnamed")]
    pub name: String,
    /// What is special about the scene, one line.
    #[serde(default)]
    pub summary: String,
    /// Where the object goes, from where it stands: world x and y, metres.
    #[serde(default = "half_a_metre")]
    pub displacement_m: [f32; 2],
    /// The table; its top is at z = 0 with its centre at the origin.
    #[serde(default)]
    pub table: TableFile,
    /// The object to find and to carry.
    pub object: ObjectFile,
    /// Further bodies that stand free on the table and can be pushed; with the obstacles at most four.
    #[serde(default)]
    pub objects: Vec<FreeFile>,
    /// Bodies that are fixed to the table; with the further objects at most four.
    #[serde(default)]
    pub obstacles: Vec<FixedFile>,
    /// Scales of the sensors' noise: 1 as measured or assumed for the real hand, 0 none.
    #[serde(default)]
    pub noise: NoiseScales,
    /// Scales of what reality differs by from the model: 1 as by default, 0 not at all.
    #[serde(default)]
    pub mismatch: MismatchScales,
    /// Where `tactus trials` draws true poses from.
    #[serde(default)]
    pub trials: Region,
    /// A robot description (URDF) for the world to use instead of the built-in one, a path from the scene file's
    /// folder. Controller and planner keep their own.
    #[serde(default)]
    pub robot_urdf: Option<PathBuf>,
    /// Where the robot's base stands, on the table's level: x, y in metres, yaw in radians of its frame, whose +x the arm
    /// faces.
    #[serde(default = "mount")]
    pub robot_base_pose: [f32; 3],
}

/// A rectangular table.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TableFile {
    /// Extent along x, y and downwards, metres.
    pub size_m: [f32; 3],
    /// Coulomb friction coefficient between table and what stands on it; also of obstacles.
    pub friction: f32,
}

/// The object to find and to carry. Its shape is `shape`, or `size_m` alone for a box.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObjectFile {
    /// The shape.
    #[serde(default)]
    pub shape: Option<ShapeFile>,
    /// In place of `shape`: a box with these edges along its x, y and z, metres.
    #[serde(default)]
    pub size_m: Option<[f32; 3]>,
    /// Mass, kilograms, 0.01 to 10.
    pub mass_kg: f32,
    /// Coulomb friction coefficient between object and the hand's pads.
    #[serde(default = "rubber")]
    pub friction: f32,
    /// Where it truly stands: x, y in metres, phi in radians.
    pub true_pose: [f32; 3],
    /// Where the controller is told that it stands [default: drawn by seed around the true pose].
    #[serde(default)]
    pub guess: Option<[f32; 3]>,
    /// Half widths of the interval about the guess in which the controller is told that the truth lies
    /// [default: 0.05 m, 0.05 m, 0.35 rad].
    #[serde(default)]
    pub interval: Option<[f32; 3]>,
}

/// A further body that stands free on the table.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeFile {
    /// The shape.
    #[serde(default)]
    pub shape: Option<ShapeFile>,
    /// In place of `shape`: a box with these edges along its x, y and z, metres.
    #[serde(default)]
    pub size_m: Option<[f32; 3]>,
    /// Mass, kilograms, 0.01 to 10.
    pub mass_kg: f32,
    /// Where it stands: x, y in metres, phi in radians.
    pub pose: [f32; 3],
}

/// A body that is fixed to the table.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedFile {
    /// The shape.
    #[serde(default)]
    pub shape: Option<ShapeFile>,
    /// In place of `shape`: a box with these edges along its x, y and z, metres.
    #[serde(default)]
    pub size_m: Option<[f32; 3]>,
    /// Where it stands: x, y in metres, phi in radians.
    pub pose: [f32; 3],
}

/// The shape of a body that stands on the table.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub enum ShapeFile {
    /// A rectangular box.
    Box {
        /// Edges along its x, y and z, metres.
        size_m: [f32; 3],
    },
    /// A cylinder that stands upright.
    Cylinder {
        /// Radius, metres.
        radius_m: f32,
        /// Height, metres.
        height_m: f32,
    },
    /// A ball.
    Sphere {
        /// Radius, metres.
        radius_m: f32,
    },
    /// A cylinder with round ends that lies along its x axis.
    Capsule {
        /// Radius, metres.
        radius_m: f32,
        /// Length from end to end, metres; more than twice the radius.
        length_m: f32,
    },
    /// A convex solid from a mesh, standing as the file has it, z up.
    Mesh {
        /// A Wavefront OBJ or an STL file, a path from the scene file's folder; `built-in:NAME` is one that the
        /// program holds.
        file: PathBuf,
        /// Metres that one unit of the file stands for: 0.001 for millimetres.
        #[serde(default = "metres")]
        scale: f32,
    },
}

/// Scales of the sensors' noise, 0 to 10.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseScales {
    /// On the noise of the tactile cells.
    pub tactile: f32,
    /// On the noise of the fingertips' torque gauges.
    pub tip_torque: f32,
    /// On the noise of the motors' efforts.
    pub effort: f32,
}

/// Scales of what reality differs by from the model, 0 to 2.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MismatchScales {
    /// On the change of friction (table and pads, +-30 % by seed).
    pub friction: f32,
    /// On the change of the object's mass (+-20 %).
    pub mass: f32,
    /// On the change of the object's dimensions (+-1 mm each).
    pub size: f32,
    /// On the change of the robot's masses (+-5 %), damping (+-30 %), dry friction (+-50 %) and clutches (+-20 %).
    pub robot: f32,
    /// On the change of the sensors' thresholds, gains (+-10 %) and offsets (+-3 mN m).
    pub sensors: f32,
    /// On the delay of commands (one tick), rounded to whole ticks.
    pub latency: f32,
}

/// Where `tactus trials` draws true poses from, each component uniformly; poses at which the object would not stand free
/// are drawn again.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Region {
    /// Least and largest x, metres.
    pub x_m: [f32; 2],
    /// Least and largest y, metres.
    pub y_m: [f32; 2],
    /// Least and largest yaw, radians.
    pub phi_rad: [f32; 2],
}

impl Default for TableFile {
    /// The thesis's table.
    fn default() -> Self {
        Self { size_m: [1.83, 0.61, 0.035], friction: 0.3 }
    }
}

impl NoiseScales {
    /// The hand's own noise.
    pub const ONE: Self = Self { tactile: 1.0, tip_torque: 1.0, effort: 1.0 };
}

impl Default for NoiseScales {
    fn default() -> Self {
        Self::ONE
    }
}

impl MismatchScales {
    /// Reality as it differs by default.
    pub const ONE: Self = Self { friction: 1.0, mass: 1.0, size: 1.0, robot: 1.0, sensors: 1.0, latency: 1.0 };
}

impl Default for MismatchScales {
    fn default() -> Self {
        Self::ONE
    }
}

impl Default for Region {
    fn default() -> Self {
        Self { x_m: [0.0, 0.3], y_m: [-0.2, 0.0], phi_rad: [-FRAC_PI_4, FRAC_PI_4] }
    }
}

impl Region {
    /// Its middle.
    pub fn centre(&self) -> PlanarPose {
        let middle = |[least, largest]: [f32; 2]| 0.5 * (least + largest);
        PlanarPose::new(middle(self.x_m), middle(self.y_m), middle(self.phi_rad))
    }

    /// How far it reaches from its middle.
    pub fn half_width(&self) -> Interval {
        let half = |[least, largest]: [f32; 2]| 0.5 * (largest - least);
        Interval { x_m: half(self.x_m), y_m: half(self.y_m), phi_rad: half(self.phi_rad) }
    }
}

fn unnamed() -> String {
    "unnamed scene".to_owned()
}

/// The published task: 0.5 m along the world's -x.
const fn half_a_metre() -> [f32; 2] {
    [-0.5, 0.0]
}

/// Rubber pads on a box of cardboard or plastic.
fn mount() -> [f32; 3] {
    MOUNT.to_array()
}

const fn rubber() -> f32 {
    0.8
}

const fn metres() -> f32 {
    1.0
}
