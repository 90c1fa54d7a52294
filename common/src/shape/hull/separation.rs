//! Signed separation of a hull from a prism by a separating-axis test: that of two convex polyhedra, as for the box.
//!
//! Of the many pairs of edges only those give an axis whose arcs on the sphere of normals cross (Gregorius, *The separating
//! axis test between convex polyhedra*, GDC 2013). Seen from the link, all of the prism's arcs between its two ends are
//! meridians, in the order of the polygon's sides. The polygon's lowest corner above a face of the hull thus tells between
//! which two meridians the face's normal lies, and the arc of an edge crosses those between its two faces' and no others: no
//! search for pairs. The crossing is the axis, both edges are its supports, and most axes need no root.
//!
//! All is worked out in the link's frame, where the polygon is level; the axis that wins is turned back.
//!
//! Cost for a prism of `n` corners and a hull of `F` faces, `E` edges and `V` corners: `F (4 n + 35)` for the hull's faces,
//! `V (n + 20)` for the prism's, where most sides end at a corner or two, `20 E` for the arcs, and 40 for each of the about
//! `n sqrt(E)` crossings: 6 kflop for a fingertip and a prism of twelve sides.

use super::{HULL_CORNERS_MAX, HULL_FACES_MAX, Hull};
use crate::shape::axis::{self, AxisKind, ROUNDING};
use crate::shape::{PRISM_CORNERS_MAX, Prism, Separation};
use heapless::Vec;
use nalgebra::{Isometry3, Vector3};

/// Squared length of a crossing below which it is no axis: the product of the squared sines of the angles between the faces
/// and between the edges.
const CROSSING_SQ_MIN: f32 = 1e-6;
/// A point that far above a plane counts as below it, metres.
const ROUNDING_M: f32 = 1e-7;

/// A face of the hull, link frame.
#[derive(Clone, Copy)]
struct Face {
    /// Unit normal outwards.
    normal: Vector3<f32>,
    /// Height of the link's origin above the face's plane, metres.
    origin_m: f32,
    /// Index of the corner of the polygon that is the lowest above the face.
    lowest: usize,
}

/// What the best axis so far is at a right angle to. Indices of corners of the hull are its own.
#[derive(Clone, Copy)]
enum Features {
    /// A face of the hull, of this index.
    Face(usize),
    /// A face of the prism; the corner of the hull that is the nearest to it.
    PrismFace { nearest: usize },
    /// The edge of the hull from the slot's corner to the next one of the face, and the edge of the prism along this unit
    /// vector through this point (link frame).
    Edges { face: usize, slot: usize, along: Vector3<f32>, on_link: Vector3<f32> },
}

/// The best axis so far, link frame.
struct Best {
    distance_m: f32,
    /// `bar * |bar|`, where `bar` is less than the distance by more than rounding.
    bar_sq: f32,
    /// Unit vector from the hull to the prism.
    axis: Vector3<f32>,
    of: Features,
}

impl Best {
    fn offer(&mut self, distance_m: f32, axis: Vector3<f32>, of: Features) {
        if distance_m > self.distance_m {
            let bar = distance_m - ROUNDING * (1.0 + libm::fabsf(distance_m));
            *self = Self { distance_m, bar_sq: bar * libm::fabsf(bar), axis, of };
        }
    }

    /// Is it certain that `scaled / sqrt(length_sq)` is no better, whatever the rounding? Without root and division, which
    /// most axes then do not need.
    fn surpasses(&self, scaled: f32, length_sq: f32) -> bool {
        scaled * libm::fabsf(scaled) < self.bar_sq * length_sq
    }
}

/// An edge of the hull with its faces and a corner on it, link frame.
struct Edge<'f> {
    a: &'f Face,
    b: &'f Face,
    corner_m: Vector3<f32>,
    face: usize,
    slot: usize,
}

/// The hull and the prism, seen from the link.
struct Pair<'h> {
    hull: &'h Hull,
    /// Unit axes of the link frame, and its origin: object frame.
    axes: [Vector3<f32>; 3],
    origin_m: Vector3<f32>,
    /// The prism's polygon: its corners, and unit vectors from each to the next.
    corners_m: &'static [[f32; 2]],
    sides: &'h [[f32; 2]],
    z_m: [f32; 2],
}

/// Signed separation of the prism from the hull, or `None` as soon as it is certain to be `limit_m` or more, or if the pose is
/// not finite or one of the two has no corner. See [`Separation`].
#[inline(never)]
pub fn separation_below(
    hull: &Hull,
    object_from_link: &Isometry3<f32>,
    prism: &Prism,
    limit_m: f32,
) -> Option<Separation> {
    let pair = Pair::new(hull, object_from_link, prism)?;
    let mut faces = Vec::new();
    let mut best = pair.best_of_faces(&mut faces)?;
    if best.distance_m >= limit_m {
        return None;
    }
    if !pair.is_opposite_face(&faces, &best) {
        let corners = pair.offer_prism_faces(&mut best);
        if best.distance_m >= limit_m {
            return None;
        }
        pair.offer_edges(&faces, &corners, &mut best);
        if !(best.distance_m < limit_m && best.distance_m.is_finite()) {
            return None;
        }
    }
    pair.finish(&faces, &best)
}

type Faces = Vec<Face, HULL_FACES_MAX>;
type Corners = Vec<Vector3<f32>, HULL_CORNERS_MAX>;

impl<'h> Pair<'h> {
    /// `None` if the pose is not finite or the prism has no corner.
    fn new(hull: &'h Hull, object_from_link: &Isometry3<f32>, prism: &'h Prism) -> Option<Self> {
        let rotation = object_from_link.rotation.to_rotation_matrix();
        let m = rotation.matrix();
        let axes = [m.column(0).into_owned(), m.column(1).into_owned(), m.column(2).into_owned()];
        let origin_m = object_from_link.translation.vector;
        let count = prism.corners_m.len().min(PRISM_CORNERS_MAX);
        let (corners_m, sides) = (prism.corners_m.get(..count)?, prism.sides());
        // Comparisons pass over a NaN, so one is caught here, where it would enter.
        let sum = origin_m.sum() + axes[0].sum() + axes[1].sum() + axes[2].sum();
        let pair = Self { hull, axes, origin_m, corners_m, sides, z_m: prism.z_m };
        (count > 0 && sum.is_finite()).then_some(pair)
    }

    /// A direction of the object frame in the link frame.
    fn to_link(&self, v: &Vector3<f32>) -> Vector3<f32> {
        let [x, y, z] = &self.axes;
        Vector3::new(x.dot(v), y.dot(v), z.dot(v))
    }

    /// A direction of the link frame in the object frame.
    fn to_object(&self, v: &Vector3<f32>) -> Vector3<f32> {
        let [x, y, z] = &self.axes;
        x * v.x + y * v.y + z * v.z
    }

    /// Height of the prism's end that is the lower one along an axis of this rise, metres.
    fn lower_end_m(&self, rise: f32) -> f32 {
        if rise > 0.0 { self.z_m[0] } else { self.z_m[1] }
    }

    /// The corner of the prism that is the lowest above the face.
    fn lowest_m(&self, face: &Face) -> Option<Vector3<f32>> {
        let [x, y] = self.corners_m.get(face.lowest)?;
        Some(Vector3::new(*x, *y, self.lower_end_m(face.normal.z)))
    }

    /// The hull's faces, and the best of their normals. `None` if there are none.
    fn best_of_faces(&self, faces: &mut Faces) -> Option<Best> {
        let none = f32::NEG_INFINITY;
        let mut best = Best { distance_m: none, bar_sq: none, axis: Vector3::z(), of: Features::Face(0) };
        for (index, (normal, offset_m)) in self.hull.planes().enumerate() {
            let origin_m = normal.dot(&self.origin_m) - offset_m;
            let normal = self.to_link(&normal);
            let mut lowest = (f32::MAX, 0);
            for (corner, [x, y]) in self.corners_m.iter().enumerate() {
                let d = x * normal.x + y * normal.y;
                if d < lowest.0 {
                    lowest = (d, corner);
                }
            }
            let distance_m = lowest.0 + normal.z * self.lower_end_m(normal.z) + origin_m;
            best.offer(distance_m, normal, Features::Face(index));
            let _ = faces.push(Face { normal, origin_m, lowest: self.by_slopes(lowest.1, &normal) });
        }
        (!faces.is_empty()).then_some(best)
    }

    /// The lowest corner by the slopes of its sides, where rounding has made its neighbour the lowest.
    fn by_slopes(&self, corner: usize, normal: &Vector3<f32>) -> usize {
        let before = if corner == 0 { self.sides.len() - 1 } else { corner - 1 };
        let slope = |side: usize| self.sides.get(side).map_or(0.0, |[x, y]| x * normal.x + y * normal.y);
        if slope(before) > 0.0 {
            before
        } else if slope(corner) < 0.0 {
            self.next(corner)
        } else {
            corner
        }
    }

    fn next(&self, corner: usize) -> usize {
        if corner + 1 < self.sides.len() { corner + 1 } else { 0 }
    }

    /// Is the prism's nearest corner straight above the face that separates best? Then the bodies are that far apart, and no
    /// axis separates them by more.
    fn is_opposite_face(&self, faces: &Faces, best: &Best) -> bool {
        let Features::Face(index) = best.of else { return false };
        let Some(corner) = faces.get(index).and_then(|face| self.lowest_m(face)) else { return false };
        if !(best.distance_m > 0.0 && best.distance_m.is_finite()) {
            return false;
        }
        let foot = corner - best.axis * best.distance_m;
        faces.iter().all(|face| face.normal.dot(&foot) + face.origin_m <= ROUNDING_M)
    }

    /// Offers the prism's faces. Returns the hull's corners in the link frame, metres.
    fn offer_prism_faces(&self, best: &mut Best) -> Corners {
        let mut corners = Corners::new();
        let (mut low, mut high) = ((f32::MAX, 0), (f32::MIN, 0));
        for (index, corner) in self.hull.corners_m().iter().enumerate() {
            let corner = self.to_link(&(Vector3::from(*corner) - self.origin_m));
            if corner.z < low.0 {
                low = (corner.z, index);
            }
            if corner.z > high.0 {
                high = (corner.z, index);
            }
            let _ = corners.push(corner);
        }
        best.offer(low.0 - self.z_m[1], -Vector3::z(), Features::PrismFace { nearest: low.1 });
        best.offer(self.z_m[0] - high.0, Vector3::z(), Features::PrismFace { nearest: high.1 });
        for ([along_x, along_y], [x, y]) in self.sides.iter().zip(self.corners_m) {
            let side_m = along_y * x - along_x * y;
            if let Some((lowest_m, nearest)) = lowest_above(&corners, *along_x, *along_y, side_m + best.distance_m) {
                let axis = Vector3::new(-along_y, *along_x, 0.0);
                best.offer(lowest_m - side_m, axis, Features::PrismFace { nearest });
            }
        }
        corners
    }

    /// Offers the axes at a right angle to an edge of the prism and to one of the hull.
    fn offer_edges(&self, faces: &Faces, corners: &Corners, best: &mut Best) {
        let hull = self.hull;
        for (face, (a, (from, to))) in faces.iter().zip(hull.ranges()).enumerate() {
            let across = hull.across.get(from..to).unwrap_or(&[]).iter();
            let slots = hull.slots.get(from..to).unwrap_or(&[]).iter();
            for (slot, (other, corner)) in across.zip(slots).enumerate() {
                // Each edge once.
                if usize::from(*other) <= face {
                    continue;
                }
                let (Some(b), Some(corner_m)) = (faces.get(usize::from(*other)), corners.get(usize::from(*corner)))
                else {
                    continue;
                };
                let edge = Edge { a, b, corner_m: *corner_m, face, slot };
                self.offer_crossings(&edge, best);
                if a.normal.z * b.normal.z < 0.0 {
                    self.offer_level(&edge, best);
                }
            }
        }
    }

    /// The edge of the hull against the edges of both polygons that it crosses: as the normal turns from one face to the
    /// other, the polygon's lowest corner goes along these.
    fn offer_crossings(&self, edge: &Edge, best: &mut Best) {
        let (a, b) = (&edge.a.normal, &edge.b.normal);
        let anticlockwise = a.x * b.y - a.y * b.x > 0.0;
        let ends = (edge.a.lowest, edge.b.lowest);
        let (mut at, last) = if anticlockwise { ends } else { (ends.1, ends.0) };
        for _ in 0..PRISM_CORNERS_MAX {
            if at == last {
                break;
            }
            let (Some([x, y]), Some(corner)) = (self.sides.get(at), self.corners_m.get(at)) else { break };
            at = self.next(at);
            // How much the faces rise along the side: where the crossing is.
            let (rise_a, rise_b) = (a.x * x + a.y * y, b.x * x + b.y * y);
            if rise_a * rise_b >= 0.0 {
                continue;
            }
            let axis = a * libm::fabsf(rise_b) + b * libm::fabsf(rise_a);
            // Out of the side? Then the other half of its great circle is crossed.
            if axis.x * y - axis.y * x >= 0.0 {
                continue;
            }
            let on_link = Vector3::new(corner[0], corner[1], self.lower_end_m(axis.z));
            offer(edge, &axis, &on_link, || Vector3::new(*x, *y, 0.0), best);
        }
    }

    /// The edge of the hull against the edges of the prism along its own axis.
    fn offer_level(&self, edge: &Edge, best: &mut Best) {
        let (a, b) = (&edge.a.normal, &edge.b.normal);
        let (weight_a, weight_b) = (libm::fabsf(b.z), libm::fabsf(a.z));
        let axis = Vector3::new(a.x * weight_a + b.x * weight_b, a.y * weight_a + b.y * weight_b, 0.0);
        let (length_sq, hull_m) = (axis.norm_squared(), axis.dot(&edge.corner_m));
        let mut lowest = (f32::MAX, Vector3::zeros());
        // Most axes fall to the first corner, which is the lowest one above a face of the edge.
        let (before, from) = self.corners_m.split_at_checked(edge.a.lowest).unwrap_or((&[], self.corners_m));
        for [x, y] in from.iter().chain(before) {
            let d = x * axis.x + y * axis.y;
            if d < lowest.0 {
                if best.surpasses(d - hull_m, length_sq) {
                    return;
                }
                lowest = (d, Vector3::new(*x, *y, edge.corner_m.z));
            }
        }
        offer(edge, &axis, &lowest.1, Vector3::z, best);
    }

    /// The separation along the best axis, object frame.
    fn finish(&self, faces: &Faces, best: &Best) -> Option<Separation> {
        let hull = self.hull;
        let in_object_m = |on_link: &Vector3<f32>| self.to_object(on_link) + self.origin_m;
        let turned = self.to_object(&best.axis);
        let (normal, kind, on_link, on_object) = match best.of {
            Features::Face(index) => {
                let (normal, on_link) = (hull.normal(index)?, in_object_m(&self.lowest_m(faces.get(index)?)?));
                (normal, AxisKind::Object, on_link, on_link - normal * best.distance_m)
            }
            Features::PrismFace { nearest } => {
                let on_object = Vector3::from(*hull.corners_m().get(nearest)?);
                (turned, AxisKind::Link, on_object + turned * best.distance_m, on_object)
            }
            Features::Edges { face, slot, along, on_link } => {
                let corners = hull.faces().nth(face)?;
                let from = hull.corner(*corners.get(slot)?)?;
                let to = hull.corner(*corners.get(slot + 1).or(corners.first())?)?;
                let (of_object, of_link) = (to - from, self.to_object(&along));
                let sign = if of_object.cross(&of_link).dot(&turned) > 0.0 { 1.0 } else { -1.0 };
                (turned, AxisKind::Edges { of_object, of_link, sign }, in_object_m(&on_link), from)
            }
        };
        Some(axis::Best { distance_m: best.distance_m, normal, kind }.finish_at(&on_link, &on_object))
    }
}

/// The lowest of the corners above a side along this unit vector, and its index: times the side's normal outwards, metres.
/// `None` if it is not above `bar_m`.
fn lowest_above(corners: &Corners, along_x: f32, along_y: f32, bar_m: f32) -> Option<(f32, usize)> {
    let mut lowest = (f32::MAX, 0);
    for (index, corner) in corners.iter().enumerate() {
        let d = along_y * corner.x - along_x * corner.y;
        if d < lowest.0 {
            if d <= bar_m {
                return None;
            }
            lowest = (d, index);
        }
    }
    Some(lowest)
}

/// Offers an axis of any length along which the edge has the hull's largest coordinate and the point `on_link` the prism's
/// smallest, on an edge of this direction.
fn offer(
    edge: &Edge,
    axis: &Vector3<f32>,
    on_link: &Vector3<f32>,
    along: impl FnOnce() -> Vector3<f32>,
    best: &mut Best,
) {
    let length_sq = axis.norm_squared();
    let scaled = (on_link - edge.corner_m).dot(axis);
    if length_sq < CROSSING_SQ_MIN || best.surpasses(scaled, length_sq) {
        return;
    }
    let length = libm::sqrtf(length_sq);
    let of = Features::Edges { face: edge.face, slot: edge.slot, along: along(), on_link: *on_link };
    best.offer(scaled / length, axis / length, of);
}
