//! Separating axes: the best so far, and those that a prism offers against any convex body.

use super::Separation;
use super::placed::Placed;
use nalgebra::Vector3;

/// Squared sine of the angle between two edges below which their cross product is no axis: the face axes then bound
/// the separation to within a few micrometres, and the cross product would be all rounding error.
pub(super) const PARALLEL_SINE_SQ: f32 = 1e-4;

/// More than the rounding error of a separation, in metres and relative to it, for a link within metres of the object.
pub(super) const ROUNDING: f32 = 1e-5;

/// A convex body, by how far it reaches.
pub(super) trait Body {
    /// How far it reaches along `axis` from its origin, metres times the length of the axis.
    fn reach_m(&self, axis: &Vector3<f32>) -> f32;

    /// A point of it that is the farthest along the unit vector `normal`, metres.
    fn farthest_m(&self, normal: &Vector3<f32>) -> Vector3<f32>;
}

/// Where an axis comes from: what turns with the link and what stays with the object.
#[derive(Clone, Copy)]
pub(super) enum AxisKind {
    /// Fixed in the object: a face, say.
    Object,
    /// A face of the prism: turns with the link.
    Link,
    /// `of_object` of any length, times a unit edge of the prism, times this sign, and then brought to unit length.
    Edges { of_object: Vector3<f32>, of_link: Vector3<f32>, sign: f32 },
}

/// The best axis so far.
pub(super) struct Best {
    pub distance_m: f32,
    pub normal: Vector3<f32>,
    pub kind: AxisKind,
}

impl Best {
    /// None yet.
    pub fn none() -> Self {
        Self { distance_m: f32::NEG_INFINITY, normal: Vector3::z(), kind: AxisKind::Object }
    }

    /// Is it certain that `scaled / sqrt(length_sq)` is no better, whatever the rounding? Without root and division,
    /// which most axes then do not need.
    pub fn surpasses(&self, scaled: f32, length_sq: f32) -> bool {
        let bar = self.distance_m - ROUNDING * (1.0 + libm::fabsf(self.distance_m));
        let (bar_sq, scaled_sq) = (bar * bar * length_sq, scaled * scaled);
        if bar >= 0.0 { scaled <= 0.0 || scaled_sq < bar_sq } else { scaled < 0.0 && scaled_sq > bar_sq }
    }

    pub fn offer(&mut self, distance_m: f32, normal: Vector3<f32>, kind: AxisKind) {
        if distance_m > self.distance_m {
            *self = Self { distance_m, normal, kind };
        }
    }

    /// The faces of the prism against any body.
    pub fn offer_prism_faces(&mut self, body: &impl Body, placed: &Placed) {
        for (outward, on_face) in placed.faces() {
            let normal = -outward;
            self.offer(normal.dot(&on_face) - body.reach_m(&normal), normal, AxisKind::Link);
        }
    }

    /// Edges of the two polygons against edges along one of these of the object's axes. Of the two signs of a cross product
    /// only the one that points out of the edge's side face can have the edge as its support, and then the edge is the
    /// support on the upper or the lower polygon, as the axis rises or falls: no search for the supporting corner.
    pub fn offer_cap_edges(&mut self, body: &impl Body, edges: &[usize], placed: &Placed) {
        for (side, corner) in placed.sides() {
            for &of_object in edges {
                let cross = cross_with_axis(of_object, &side.along);
                let length_sq = cross.norm_squared();
                if length_sq < PARALLEL_SINE_SQ {
                    continue;
                }
                let sign = if cross.dot(&side.outward) > 0.0 { -1.0 } else { 1.0 };
                let towards = cross * sign;
                let lowest = placed.lowest_on_side_m(&towards, corner);
                if self.surpasses(lowest - body.reach_m(&towards), length_sq) {
                    continue;
                }
                let length = libm::sqrtf(length_sq);
                let normal = cross * (sign / length);
                let distance_m = placed.lowest_on_side_m(&normal, corner) - body.reach_m(&normal);
                let of_object = unit_axis(of_object);
                self.offer(distance_m, normal, AxisKind::Edges { of_object, of_link: side.along, sign });
            }
        }
    }

    /// Edges of the prism along its own axis against edges along one of these of the object's axes, for a body that
    /// reaches as far to one side as to the other.
    pub fn offer_side_edges(&mut self, body: &impl Body, edges: &[usize], placed: &Placed) {
        let of_link = placed.axes[2];
        for &of_object in edges {
            let cross = cross_with_axis(of_object, &of_link);
            let length_sq = cross.norm_squared();
            if length_sq < PARALLEL_SINE_SQ {
                continue;
            }
            let normal = cross / libm::sqrtf(length_sq);
            let (low, high) = placed.extent(&normal);
            let reach_m = body.reach_m(&normal);
            let of_object = unit_axis(of_object);
            self.offer(low - reach_m, normal, AxisKind::Edges { of_object, of_link, sign: 1.0 });
            self.offer(-high - reach_m, -normal, AxisKind::Edges { of_object, of_link, sign: -1.0 });
        }
    }

    /// The separation, if it is less than `limit_m`.
    pub fn finish_below(&self, body: &impl Body, placed: &Placed, limit_m: f32) -> Option<Separation> {
        (self.distance_m < limit_m && self.distance_m.is_finite()).then(|| self.finish(body, placed))
    }

    /// The separation along the winning axis.
    pub fn finish(&self, body: &impl Body, placed: &Placed) -> Separation {
        self.finish_at(&placed.lowest_corner(&self.normal), &body.farthest_m(&self.normal))
    }

    /// Gradient and witness of the winning axis `n`. With `a`, `b` the supporting points of link and object,
    /// `distance = n . (a - b)`, so `d distance = n . da + dn . (a - b)`: exact whichever features support.
    pub fn finish_at(&self, on_link: &Vector3<f32>, on_object: &Vector3<f32>) -> Separation {
        let n = self.normal;
        let (yaw_slope, witness) = match self.kind {
            AxisKind::Object => (n.dot(&turn(on_link)), *on_link),
            AxisKind::Link => (n.dot(&turn(on_object)), *on_object),
            AxisKind::Edges { of_object, of_link, sign } => {
                let length = of_object.cross(&of_link).norm();
                let turned = of_object.cross(&turn(&of_link)) * (sign / length);
                let axis_rate = turned - n * n.dot(&turned);
                (n.dot(&turn(on_link)) + axis_rate.dot(&(on_link - on_object)), *on_link)
            }
        };
        Separation {
            distance_m: self.distance_m,
            normal_object: n,
            witness_object_m: witness,
            gradient_object: [-n.x, -n.y, yaw_slope],
        }
    }
}

/// The unit vector along the object's axis of this index.
fn unit_axis(axis: usize) -> Vector3<f32> {
    match axis {
        0 => Vector3::x(),
        1 => Vector3::y(),
        _ => Vector3::z(),
    }
}

/// `e x v` for the unit vector `e` along the object's axis of this index.
pub(super) fn cross_with_axis(axis: usize, v: &Vector3<f32>) -> Vector3<f32> {
    match axis {
        0 => Vector3::new(0.0, -v.z, v.y),
        1 => Vector3::new(v.z, 0.0, -v.x),
        _ => Vector3::new(-v.y, v.x, 0.0),
    }
}

/// Motion of a point that goes with the link, seen from the object, as the object turns by +1 rad about its z axis.
fn turn(p: &Vector3<f32>) -> Vector3<f32> {
    Vector3::new(p.y, -p.x, 0.0)
}
