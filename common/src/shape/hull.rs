//! A convex polyhedron of bounded size, and ([`separation_below`]) its separation from a prism.

mod separation;

pub use separation::separation_below;

use core::f32::consts::TAU;
use core::fmt;
use heapless::Vec;
use nalgebra::Vector3;
use postcard_schema::{Schema, schema::NamedType};
use serde::{Deserialize, Serialize};

/// Most corners of a hull.
pub const HULL_CORNERS_MAX: usize = 24;
/// Most faces of a hull.
pub const HULL_FACES_MAX: usize = 24;
/// Most edges of a hull.
pub const HULL_EDGES_MAX: usize = 44;
/// Each edge belongs to two faces.
const SLOTS_MAX: usize = 2 * HULL_EDGES_MAX;
/// Bytes of all faces on the wire: for each the number of its corners, then their indices.
pub const HULL_FACE_BYTES_MAX: usize = SLOTS_MAX + HULL_FACES_MAX;

/// How far a corner may lie beside the plane of a face of its, or above that of another one, metres: files round.
pub const HULL_FLATNESS_M: f32 = 1e-4;
/// How far a corner may lie from another one's place after a turn that leaves the hull as it is, metres.
pub const HULL_SYMMETRY_TOLERANCE_M: f32 = 2e-4;
/// Twice the area of a face below which it has no normal, square metres.
const AREA_MIN_M2: f32 = 1e-8;

/// A closed convex polyhedron of at most [`HULL_CORNERS_MAX`] corners, [`HULL_FACES_MAX`] faces and
/// [`HULL_EDGES_MAX`] edges, its origin inside. What separations need again and again is worked out once.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(from = "HullOnWire", into = "HullOnWire")]
pub struct Hull {
    /// The first `corner_count` are used; object frame, metres.
    corners_m: [[f32; 3]; HULL_CORNERS_MAX],
    corner_count: u8,
    /// Of each face the unit normal outwards and the distance of its plane from the origin, metres.
    planes: [[f32; 4]; HULL_FACES_MAX],
    face_count: u8,
    /// The first slot after those of each face.
    ends: [u8; HULL_FACES_MAX],
    /// The faces' corners, anticlockwise seen from outside, face after face.
    slots: [u8; SLOTS_MAX],
    /// Of each slot the face on the other side of the edge from its corner to the next one of its face.
    across: [u8; SLOTS_MAX],
    /// Half the extents of the bounding box about the origin, metres.
    half_extents_m: [f32; 3],
    /// Lowest and highest corner, metres.
    z_m: [f32; 2],
    yaw_symmetry_rad: f32,
}

/// Why corners and faces are no [`Hull`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HullFault {
    /// More than [`HULL_CORNERS_MAX`] corners, or fewer than four.
    Corners,
    /// More than [`HULL_FACES_MAX`] faces, or fewer than four.
    Faces,
    /// More than [`HULL_EDGES_MAX`] edges.
    Edges,
    /// A coordinate of this corner is no finite number.
    NotFinite {
        /// Index of the corner.
        corner: u8,
    },
    /// This face has fewer than three corners, names one that there is not, or has no area.
    BadFace {
        /// Index of the face.
        face: u8,
    },
    /// An edge of this face does not belong to exactly one other face that runs along it the other way, or the faces are
    /// more than one surface, or a corner belongs to none.
    NotClosed {
        /// Index of the face; 0 for the hull as a whole.
        face: u8,
    },
    /// A corner lies outside the plane of this face, or one of the face's own does not lie in it, by more than
    /// [`HULL_FLATNESS_M`].
    NotConvex {
        /// Index of the face.
        face: u8,
        /// Index of the corner.
        corner: u8,
    },
    /// The origin is not inside of this face: the face is seen from within, or the origin is not the centroid.
    OriginOutside {
        /// Index of the face.
        face: u8,
    },
}

impl fmt::Display for HullFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Corners => write!(f, "a hull has 4 to {HULL_CORNERS_MAX} corners"),
            Self::Faces => write!(f, "a hull has 4 to {HULL_FACES_MAX} faces"),
            Self::Edges => write!(f, "a hull has at most {HULL_EDGES_MAX} edges"),
            Self::NotFinite { corner } => write!(f, "corner {corner}: a coordinate is no finite number"),
            Self::BadFace { face } => write!(f, "face {face}: expected three or more corners that span an area"),
            Self::NotClosed { face } => {
                write!(f, "face {face}: not closed; expected each edge to belong to two faces of one surface")
            }
            Self::NotConvex { face, corner } => {
                write!(f, "corner {corner} is beside or outside face {face}; expected a convex body with flat faces")
            }
            Self::OriginOutside { face } => {
                write!(f, "the origin is not inside of face {face}; expected corners anticlockwise seen from outside")
            }
        }
    }
}

impl core::error::Error for HullFault {}

impl Hull {
    /// What stands for bytes that are no hull: without corners, and not valid.
    const NONE: Self = Self {
        corners_m: [[0.0; 3]; HULL_CORNERS_MAX],
        corner_count: 0,
        planes: [[0.0; 4]; HULL_FACES_MAX],
        face_count: 0,
        ends: [0; HULL_FACES_MAX],
        slots: [0; SLOTS_MAX],
        across: [0; SLOTS_MAX],
        half_extents_m: [0.0; 3],
        z_m: [0.0; 2],
        yaw_symmetry_rad: TAU,
    };

    /// A hull with these corners (metres, about the centroid, z up) and faces: indices of corners, anticlockwise seen
    /// from outside.
    ///
    /// # Errors
    /// These are no closed convex polyhedron within the bounds, or the origin is not inside.
    pub fn new<'f>(corners_m: &[[f32; 3]], faces: impl IntoIterator<Item = &'f [u8]>) -> Result<Self, HullFault> {
        let mut hull = Self::NONE;
        hull.take_corners(corners_m)?;
        hull.take_faces(faces)?;
        hull.close()?;
        hull.span()?;
        hull.measure();
        Ok(hull)
    }

    /// An upright prism over a regular polygon of so many sides, a corner of it on the x axis: the distance of its corners
    /// from its axis and half its height, metres.
    ///
    /// # Errors
    /// As [`Self::new`]: too few or too many sides, or lengths that make no body.
    pub fn regular_prism(sides: u8, radius_m: f32, half_height_m: f32) -> Result<Self, HullFault> {
        const MOST: u8 = HULL_CORNERS_MAX as u8 / 2;
        if !(3..=MOST).contains(&sides) {
            return Err(HullFault::Corners);
        }
        let corner = |i: u8| {
            let (s, c) = libm::sincosf(TAU * f32::from(i % sides) / f32::from(sides));
            [radius_m * c, radius_m * s, if i < sides { -half_height_m } else { half_height_m }]
        };
        let corners_m: Vec<[f32; 3], HULL_CORNERS_MAX> = gathered((0..2 * sides).map(corner));
        let side = |i: u8| [i, (i + 1) % sides, (i + 1) % sides + sides, i + sides];
        let around: Vec<[u8; 4], { MOST as usize }> = gathered((0..sides).map(side));
        let lower: Vec<u8, { MOST as usize }> = gathered((0..sides).rev());
        let upper: Vec<u8, { MOST as usize }> = gathered(sides..2 * sides);
        let ends = [lower.as_slice(), upper.as_slice()];
        Self::new(&corners_m, around.iter().map(<[u8; 4]>::as_slice).chain(ends))
    }

    /// The corners, metres.
    pub fn corners_m(&self) -> &[[f32; 3]] {
        self.corners_m.get(..usize::from(self.corner_count)).unwrap_or(&[])
    }

    /// The faces: indices of corners, anticlockwise seen from outside.
    pub fn faces(&self) -> impl Iterator<Item = &[u8]> {
        self.ranges().map(|(from, to)| self.slots.get(from..to).unwrap_or(&[]))
    }

    /// Unit normals of the faces, outwards, each with the distance of the face's plane from the origin, metres.
    pub fn planes(&self) -> impl Iterator<Item = (Vector3<f32>, f32)> {
        self.planes
            .iter()
            .take(usize::from(self.face_count))
            .map(|[x, y, z, offset_m]| (Vector3::new(*x, *y, *z), *offset_m))
    }

    /// Number of edges: Euler's formula.
    pub const fn edge_count(&self) -> usize {
        (self.corner_count as usize + self.face_count as usize).saturating_sub(2)
    }

    /// Half the extents of the smallest box about the origin that holds it, metres.
    pub fn half_extents_m(&self) -> [f32; 3] {
        self.half_extents_m
    }

    /// Heights of the lowest and the highest corner over the origin, metres.
    pub fn z_m(&self) -> [f32; 2] {
        self.z_m
    }

    /// Smallest turn about the vertical through the origin that puts every corner where one was, within
    /// [`HULL_SYMMETRY_TOLERANCE_M`], radians; a whole turn if no smaller one does.
    pub fn yaw_symmetry_rad(&self) -> f32 {
        self.yaw_symmetry_rad
    }

    /// `false` for what came over the wire and is no hull.
    pub fn is_valid(&self) -> bool {
        self.corner_count > 0
    }

    /// Separation of a point (object frame, metres) from the hull: the largest over the planes of its faces, metres.
    pub fn point_separation_m(&self, p: &Vector3<f32>) -> f32 {
        let mut largest_m = f32::MIN;
        for (normal, offset_m) in self.planes() {
            largest_m = largest_m.max(normal.dot(p) - offset_m);
        }
        largest_m
    }

    /// First slot and the slot after the last one of each face.
    fn ranges(&self) -> impl Iterator<Item = (usize, usize)> {
        let starts = core::iter::once(&0).chain(&self.ends);
        let ranges = starts.zip(&self.ends).take(usize::from(self.face_count));
        ranges.map(|(from, to)| (usize::from(*from), usize::from(*to)))
    }

    fn corner(&self, index: u8) -> Option<Vector3<f32>> {
        self.corners_m().get(usize::from(index)).copied().map(Vector3::from)
    }

    fn normal(&self, face: usize) -> Option<Vector3<f32>> {
        self.planes.get(face).map(|[x, y, z, _]| Vector3::new(*x, *y, *z))
    }

    fn take_corners(&mut self, corners_m: &[[f32; 3]]) -> Result<(), HullFault> {
        let places = self.corners_m.get_mut(..corners_m.len()).ok_or(HullFault::Corners)?;
        if corners_m.len() < 4 {
            return Err(HullFault::Corners);
        }
        for (index, (place, corner)) in (0..).zip(places.iter_mut().zip(corners_m)) {
            if !corner.iter().all(|c| c.is_finite()) {
                return Err(HullFault::NotFinite { corner: index });
            }
            *place = *corner;
        }
        self.corner_count = corners_m.len() as u8;
        Ok(())
    }

    fn take_faces<'f>(&mut self, faces: impl IntoIterator<Item = &'f [u8]>) -> Result<(), HullFault> {
        let mut used = 0_usize;
        for corners in faces {
            let face = self.face_count;
            if corners.len() < 3 || corners.iter().any(|corner| *corner >= self.corner_count) {
                return Err(HullFault::BadFace { face });
            }
            let end = self.ends.get_mut(usize::from(face)).ok_or(HullFault::Faces)?;
            let places = self.slots.get_mut(used..used + corners.len()).ok_or(HullFault::Edges)?;
            places.copy_from_slice(corners);
            used += corners.len();
            *end = used as u8;
            self.face_count += 1;
        }
        if self.face_count < 4 { Err(HullFault::Faces) } else { Ok(()) }
    }

    /// Finds for each edge the face on its other side.
    fn close(&mut self) -> Result<(), HullFault> {
        let mut across = [0; SLOTS_MAX];
        let (mut slot_count, mut used) = (0, 0_u32);
        for (face, from, to) in self.edges_of_faces() {
            let mut others = self.edges_of_faces().filter(|(_, a, b)| (*a, *b) == (to, from));
            let again = self.edges_of_faces().filter(|(_, a, b)| (*a, *b) == (from, to)).count();
            match (others.next(), others.next()) {
                (Some((other, _, _)), None) if again == 1 && other != face => {
                    if let Some(place) = across.get_mut(slot_count) {
                        *place = other;
                    }
                }
                _ => return Err(HullFault::NotClosed { face }),
            }
            used |= 1 << from;
            slot_count += 1;
        }
        self.across = across;
        // Euler: corners - edges + faces = 2 for one closed surface without holes.
        let surfaces = 2 * (usize::from(self.corner_count) + usize::from(self.face_count)) == slot_count + 4;
        let all = used.count_ones() == u32::from(self.corner_count);
        if surfaces && all { Ok(()) } else { Err(HullFault::NotClosed { face: 0 }) }
    }

    /// Face, first and second corner of every edge of every face.
    fn edges_of_faces(&self) -> impl Iterator<Item = (u8, u8, u8)> {
        (0..).zip(self.faces()).flat_map(|(face, corners)| {
            let next = corners.iter().skip(1).chain(corners.first());
            corners.iter().zip(next).map(move |(from, to)| (face, *from, *to))
        })
    }

    /// Works out the planes, and looks whether all corners are where those of a convex body are.
    fn span(&mut self) -> Result<(), HullFault> {
        let mut planes = self.planes;
        for (face, (plane, corners)) in (0..).zip(planes.iter_mut().zip(self.faces())) {
            // Newell: the sum of the cross products along the boundary is twice the area, whatever the corners.
            let mut area = Vector3::zeros();
            for (_, from, to) in self.edges_of_faces().filter(|(of, _, _)| *of == face) {
                if let (Some(a), Some(b)) = (self.corner(from), self.corner(to)) {
                    area += a.cross(&b);
                }
            }
            let length = area.norm();
            if !(length > AREA_MIN_M2 && length.is_finite()) {
                return Err(HullFault::BadFace { face });
            }
            let normal = area / length;
            let heights = || self.corners_m().iter().map(|corner| normal.dot(&Vector3::from(*corner)));
            let own = |corner: u8| corners.contains(&corner);
            let mut lowest_own_m = f32::MAX;
            for (corner, height_m) in (0_u8..).zip(heights()) {
                if own(corner) {
                    lowest_own_m = lowest_own_m.min(height_m);
                }
            }
            for (corner, height_m) in (0_u8..).zip(heights()) {
                if height_m > lowest_own_m + HULL_FLATNESS_M {
                    return Err(HullFault::NotConvex { face, corner });
                }
            }
            if lowest_own_m < HULL_FLATNESS_M {
                return Err(HullFault::OriginOutside { face });
            }
            // The plane is put where no corner is above it: no separation along its normal is too large then.
            let offset_m = heights().fold(lowest_own_m, f32::max);
            *plane = [normal.x, normal.y, normal.z, offset_m];
        }
        self.planes = planes;
        Ok(())
    }

    fn measure(&mut self) {
        let (mut half, mut z_m) = ([0.0_f32; 3], [f32::MAX, f32::MIN]);
        for corner in self.corners_m() {
            for (half, coordinate) in half.iter_mut().zip(corner) {
                *half = half.max(libm::fabsf(*coordinate));
            }
            z_m = [z_m[0].min(corner[2]), z_m[1].max(corner[2])];
        }
        let symmetry_rad =
            (2..=HULL_CORNERS_MAX as u8).rev().map(|n| TAU / f32::from(n)).find(|turn| self.repeats_after(*turn));
        (self.half_extents_m, self.z_m) = (half, z_m);
        self.yaw_symmetry_rad = symmetry_rad.unwrap_or(TAU);
    }

    /// Does this turn about the vertical put every corner where one was?
    fn repeats_after(&self, turn_rad: f32) -> bool {
        let (s, c) = libm::sincosf(turn_rad);
        self.corners_m().iter().all(|[x, y, z]| {
            let turned = Vector3::new(c * x - s * y, s * x + c * y, *z);
            let apart_sq = |other: &[f32; 3]| (Vector3::from(*other) - turned).norm_squared();
            let tolerance_sq = HULL_SYMMETRY_TOLERANCE_M * HULL_SYMMETRY_TOLERANCE_M;
            self.corners_m().iter().any(|other| apart_sq(other) < tolerance_sq)
        })
    }
}

impl fmt::Debug for Hull {
    /// The corners; the rest follows from them.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Hull").field("corners_m", &self.corners_m()).finish_non_exhaustive()
    }
}

impl Schema for Hull {
    const SCHEMA: &'static NamedType = HullOnWire::SCHEMA;
}

/// A hull as it is sent: what it was made from.
#[derive(Clone, Debug, Serialize, Deserialize, Schema)]
struct HullOnWire {
    corners_m: Vec<[f32; 3], HULL_CORNERS_MAX>,
    /// For each face the number of its corners, then their indices.
    faces: Vec<u8, HULL_FACE_BYTES_MAX>,
}

impl From<Hull> for HullOnWire {
    fn from(hull: Hull) -> Self {
        let mut faces = Vec::new();
        for corners in hull.faces() {
            // There is room for the faces of every hull.
            let _ = faces.push(corners.len() as u8);
            let _ = faces.extend_from_slice(corners);
        }
        Self { corners_m: gathered(hull.corners_m().iter().copied()), faces }
    }
}

/// What there is room for; `collect` would panic at what there is not.
fn gathered<T, const N: usize>(items: impl IntoIterator<Item = T>) -> Vec<T, N> {
    let mut list = Vec::new();
    for item in items.into_iter().take(N) {
        let _ = list.push(item);
    }
    list
}

impl From<HullOnWire> for Hull {
    /// Bytes that are no hull give one that is not valid, and which a set-up is refused for.
    fn from(wire: HullOnWire) -> Self {
        let mut rest = wire.faces.as_slice();
        let faces = core::iter::from_fn(move || {
            let (count, after) = rest.split_first()?;
            // One that is cut short is told as a face without corners.
            let (corners, after) = after.split_at_checked(usize::from(*count)).unwrap_or((&[], &[]));
            rest = after;
            Some(corners)
        });
        Self::new(&wire.corners_m, faces).unwrap_or(Self::NONE)
    }
}

#[cfg(test)]
mod tests;
