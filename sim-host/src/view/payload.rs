//! What the page shows: everything that its script gets to know of a run. Metres, radians, newtons, seconds since the
//! start of the run; the world's frame has z up and its origin on the table's top. A pose is x, y, z and a quaternion x, y, z, w.

use super::packed::Packed;
use serde::Serialize;

/// A run, as the script takes it.
#[derive(Clone, Debug, Serialize)]
pub struct Payload {
    /// Length of the recording.
    pub duration_s: f32,
    /// Colours of pressures from none to most, as `#rrggbb`.
    pub colour_map: Vec<String>,
    /// Pressure of the brightest, N/cm^2.
    pub bright_n_cm2: f32,
    /// All frames that move, sampled together.
    pub frames: Frames,
    /// Which of the frames is the palm, pointing along its z.
    pub palm: usize,
    /// What is drawn, and in which frame.
    pub bodies: Vec<Body>,
    /// What the controller believes of the object.
    pub belief: Belief,
    /// Where the object is to be put: x, y, phi; the controller never sees it.
    pub goal: Option<[f32; 3]>,
    /// The tactile pads.
    pub pads: Vec<Pad>,
    /// Contact forces.
    pub contacts: Contacts,
    /// Curves over time.
    pub plots: Vec<Plot>,
    /// Phases of the mission, in order, without gaps.
    pub phases: Vec<PhaseSpan>,
    /// What happened, in order.
    pub marks: Vec<Mark>,
}

/// Poses of frames in the world.
#[derive(Clone, Debug, Serialize)]
pub struct Frames {
    /// When they were sampled.
    pub times_s: Packed,
    /// Names.
    pub names: Vec<String>,
    /// Poses of each, sample after sample; a single one if it never moves.
    pub poses: Vec<Packed>,
}

/// What a body is, which decides how it is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// A link of the arm.
    Arm,
    /// A link of the hand.
    Hand,
    /// The table.
    Table,
    /// The object, where it truly is.
    Truth,
    /// The object, where it is believed to be.
    Belief,
    /// Another body that can move.
    Loose,
    /// Another body that cannot.
    Obstacle,
}

/// Something that is drawn.
#[derive(Clone, Debug, Serialize)]
pub struct Body {
    /// Name.
    pub name: String,
    /// What it is.
    pub role: Role,
    /// Which of the frames carries it; `None`: the world.
    pub frame: Option<usize>,
    /// What it is made of.
    pub shapes: Vec<Shape>,
}

impl Body {
    /// How far it reaches from its frame's z axis, at most; what is not a box counts with its greatest width.
    pub fn reach_m(&self) -> f32 {
        let reach = |shape: &Shape| {
            let half_m = match &shape.solid {
                Solid::Box { size_m } | Solid::Cylinder { size_m, .. } | Solid::Sphere { size_m } => {
                    0.5 * size_m[0].max(size_m[1])
                }
                Solid::Mesh { reach_m, .. } => *reach_m,
            };
            shape.pose[0].abs().max(shape.pose[1].abs()) + half_m
        };
        self.shapes.iter().map(reach).fold(0.0, f32::max)
    }
}

/// A solid, placed in its body's frame.
#[derive(Clone, Debug, Serialize)]
pub struct Shape {
    /// Where.
    pub pose: [f32; 7],
    /// What.
    #[serde(flatten)]
    pub solid: Solid,
}

/// A solid about its own origin.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Solid {
    /// Edge lengths.
    Box {
        /// Along x, y, z.
        size_m: [f32; 3],
    },
    /// Along z; its ends may differ in size.
    Cylinder {
        /// Diameters along x and y, length along z.
        size_m: [f32; 3],
        /// The lower end's share of the diameters.
        bottom: f32,
        /// The upper end's.
        top: f32,
    },
    /// An ellipsoid.
    Sphere {
        /// Diameters along x, y, z.
        size_m: [f32; 3],
    },
    /// Triangles.
    Mesh {
        /// Corners, three numbers each.
        vertices_m: Packed,
        /// Three corners each; `None`: the corners as they come.
        triangles: Option<Packed>,
        /// Farthest that a corner is from the z axis.
        #[serde(skip)]
        reach_m: f32,
    },
}

/// What the controller believes of the object, in steps: each holds until the next.
#[derive(Clone, Debug, Serialize)]
pub struct Belief {
    /// From when on.
    pub times_s: Packed,
    /// x, y, z, phi of each; not numbers while nothing is believed that still holds.
    pub poses: Packed,
    /// Upper triangle of the covariance of each: xx, xy, xphi, yy, yphi, phiphi.
    pub covariances: Packed,
    /// Radius at which the yaw's uncertainty is drawn.
    pub radius_m: f32,
}

/// A tactile pad.
#[derive(Clone, Debug, Serialize)]
pub struct Pad {
    /// Name.
    pub name: String,
    /// Which of the frames carries it.
    pub frame: usize,
    /// Its cells.
    pub cells: Vec<Taxel>,
    /// When it was read.
    pub times_s: Packed,
    /// Pressures, N/cm^2: all cells of the first reading, then of the next.
    pub pressures_n_cm2: Packed,
}

/// One cell of a pad.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Taxel {
    /// Centre in the pad's frame.
    pub centre_m: [f32; 3],
    /// Outward normal.
    pub normal: [f32; 3],
    /// Direction of its first side.
    pub along: [f32; 3],
    /// Sides.
    pub size_m: [f32; 2],
    /// Where it is in the picture of the pad: column and row from its upper left corner, in cells.
    pub place: [f32; 2],
}

/// Contact forces on the hand, as arrows.
#[derive(Clone, Debug, Serialize)]
pub struct Contacts {
    /// When they were sampled.
    pub times_s: Packed,
    /// Where the forces of each sample begin, and at the end their number.
    pub starts: Packed,
    /// Points of attack in the world.
    pub points_m: Packed,
    /// Length and direction of their arrows, which end there.
    pub arrows_m: Packed,
}

/// How a plot's values are spread over its height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By their logarithms.
    Log,
}

/// Curves over time with a common axis.
#[derive(Clone, Debug, Serialize)]
pub struct Plot {
    /// What is shown.
    pub title: String,
    /// Unit of its values.
    pub unit: String,
    /// Its axis.
    pub scale: Scale,
    /// When the values were sampled.
    pub times_s: Packed,
    /// The curves.
    pub lines: Vec<Line>,
}

/// One curve.
#[derive(Clone, Debug, Serialize)]
pub struct Line {
    /// Name.
    pub name: String,
    /// Values at the plot's times.
    pub values: Packed,
}

/// A phase of the mission.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhaseSpan {
    /// Name.
    pub name: String,
    /// Begin.
    pub from_s: f32,
    /// End.
    pub to_s: f32,
}

/// What a mark on the time line stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MarkKind {
    /// A touch begins.
    Touch,
    /// Something is felt.
    Contact,
    /// The belief is corrected.
    Update,
    /// Anything else.
    Other,
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mark {
    /// When.
    pub at_s: f32,
    /// What kind of thing.
    pub kind: MarkKind,
    /// What, for people.
    pub text: String,
}
