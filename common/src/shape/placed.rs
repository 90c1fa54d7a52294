//! A prism placed in an object's frame, and what a separating-axis test asks of it.

use super::{PRISM_CORNERS_MAX, Prism};
use nalgebra::{Isometry3, Vector3};

/// One side of the polygon, from its corner to the next.
#[derive(Clone, Copy)]
pub(super) struct Side {
    /// Unit vector along the side, object frame.
    pub along: Vector3<f32>,
    /// Unit normal out of the prism, object frame.
    pub outward: Vector3<f32>,
}

/// The prism's polygon placed in the object's frame.
pub(super) struct Placed<'p> {
    /// Corners at the height of the link frame's z = 0, metres; the first `count` are used.
    base_m: [Vector3<f32>; PRISM_CORNERS_MAX],
    count: usize,
    /// Unit axes of the link frame.
    pub axes: [Vector3<f32>; 3],
    pub prism: &'p Prism,
}

impl<'p> Placed<'p> {
    /// `None` if the pose is not finite or the prism has no corner.
    pub fn new(object_from_link: &Isometry3<f32>, prism: &'p Prism) -> Option<Self> {
        let rotation = object_from_link.rotation.to_rotation_matrix();
        let m = rotation.matrix();
        let axes = [m.column(0).into_owned(), m.column(1).into_owned(), m.column(2).into_owned()];
        let origin = object_from_link.translation.vector;
        let count = prism.corners_m.len().min(PRISM_CORNERS_MAX);
        let mut placed = Self { base_m: [origin; PRISM_CORNERS_MAX], count, axes, prism };
        for (base, from) in placed.base_m.iter_mut().zip(prism.corners_m) {
            *base = origin + axes[0] * from[0] + axes[1] * from[1];
        }
        // `min` and `max` pass over a NaN, so one is caught here, where it would enter.
        let sum = placed.base_m[0].sum() + placed.axes[2].sum();
        (count > 0 && sum.is_finite()).then_some(placed)
    }

    /// The sides, each with the corner that it starts from. Anticlockwise corners: the outside is to the right of a side.
    pub fn sides(&self) -> impl Iterator<Item = (Side, &Vector3<f32>)> {
        let [ax, ay, _] = self.axes;
        let side = move |[x, y]: &[f32; 2]| Side { along: ax * *x + ay * *y, outward: ax * *y - ay * *x };
        self.prism.sides().iter().map(side).zip(self.base())
    }

    /// The faces: unit normal outwards, and a point on the face.
    pub fn faces(&self) -> impl Iterator<Item = (Vector3<f32>, Vector3<f32>)> {
        let up = self.axes[2];
        let caps = [(up, self.base_m[0] + up * self.prism.z_m[1]), (-up, self.base_m[0] + up * self.prism.z_m[0])];
        self.sides().map(|(side, corner)| (side.outward, *corner)).chain(caps)
    }

    /// The corners of both polygons.
    pub fn corners(&self) -> impl Iterator<Item = Vector3<f32>> {
        let up = self.axes[2];
        self.base().iter().flat_map(move |base| self.prism.z_m.map(|z_m| base + up * z_m))
    }

    fn base(&self) -> &[Vector3<f32>] {
        self.base_m.get(..self.count).unwrap_or(&[])
    }

    /// Smallest and largest coordinate of the prism along `axis`.
    pub fn extent(&self, axis: &Vector3<f32>) -> (f32, f32) {
        let (mut low, mut high) = (f32::MAX, f32::MIN);
        for corner in self.base() {
            include(corner.dot(axis), &mut low, &mut high);
        }
        self.raised(low, high, axis.dot(&self.axes[2]))
    }

    /// As [`Self::extent`], for all three axes of the object at once.
    pub fn extents(&self) -> [(f32, f32); 3] {
        let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
        for corner in self.base() {
            for ((d, low), high) in corner.iter().zip(&mut low).zip(&mut high) {
                include(*d, low, high);
            }
        }
        core::array::from_fn(|axis| self.raised(low[axis], high[axis], self.axes[2][axis]))
    }

    /// The extent of the prism from that of its polygon, along an axis on which the prism's own has the coordinate `rise`.
    fn raised(&self, low: f32, high: f32, rise: f32) -> (f32, f32) {
        let (a, b) = (rise * self.prism.z_m[0], rise * self.prism.z_m[1]);
        (low + a.min(b), high + a.max(b))
    }

    /// Smallest coordinate along `axis`, which need not be a unit vector.
    pub fn lowest_m(&self, axis: &Vector3<f32>) -> f32 {
        let mut low = f32::MAX;
        for corner in self.base() {
            let d = corner.dot(axis);
            if d < low {
                low = d;
            }
        }
        let rise = axis.dot(&self.axes[2]);
        low + rise * if rise > 0.0 { self.prism.z_m[0] } else { self.prism.z_m[1] }
    }

    /// The same along an axis at a right angle to a side that points against its outward normal: that side then has the
    /// lowest points, on the lower polygon where the axis rises and on the upper one where it falls. `corner`: the
    /// side's.
    pub fn lowest_on_side_m(&self, axis: &Vector3<f32>, corner: &Vector3<f32>) -> f32 {
        let rise = axis.dot(&self.axes[2]);
        axis.dot(corner) + if rise > 0.0 { rise * self.prism.z_m[0] } else { rise * self.prism.z_m[1] }
    }

    /// The corner of the prism that is the farthest against `normal`.
    pub fn lowest_corner(&self, normal: &Vector3<f32>) -> Vector3<f32> {
        let mut lowest = (f32::MAX, self.axes[0]);
        for corner in self.base() {
            let d = corner.dot(normal);
            if d < lowest.0 {
                lowest = (d, *corner);
            }
        }
        let z_m = if normal.dot(&self.axes[2]) > 0.0 { self.prism.z_m[0] } else { self.prism.z_m[1] };
        lowest.1 + self.axes[2] * z_m
    }
}

/// Widens `low..high` to include `d`. Plain comparisons: `min` and `max` cost twice as much where no instruction does them.
fn include(d: f32, low: &mut f32, high: &mut f32) {
    if d < *low {
        *low = d;
    }
    if d > *high {
        *high = d;
    }
}
