//! The map between poses and the unit box of their free components.

use super::Bounds;
use super::search::{Model, Point};
use crate::error::Slope;
use nalgebra::{Matrix3, Vector3};
use tactus_common::pose::PlanarPose;

/// Unit box over the free components: component `i` of a point is the distance from the middle of the region in
/// half widths, -1..1, of the `i`-th component that is not fixed; the components beyond the free ones are 0.
#[derive(Clone, Copy, Debug, Default)]
pub struct Chart {
    bounds: Bounds,
    /// Holds the fixed components.
    fixed: [f32; 3],
    axes: [u8; 3],
    free: u8,
}

impl Chart {
    /// The chart of `bounds`; a component that is fixed stays where `start` is within them.
    pub fn new(bounds: &Bounds, start: &PlanarPose) -> Self {
        let mut chart = Self { bounds: *bounds, fixed: bounds.clamp(start).to_array(), axes: [0; 3], free: 0 };
        for axis in 0..3 {
            let half = bounds.half_width(axis);
            // A width that no number fits into any more is none.
            if half.is_finite() && bounds.lower[axis] + half > bounds.lower[axis] {
                chart.axes[usize::from(chart.free)] = axis as u8;
                chart.free += 1;
            }
        }
        chart
    }

    /// Components that are free.
    pub fn free(&self) -> usize {
        usize::from(self.free)
    }

    /// The pose at `point`, never outside the bounds.
    pub fn pose(&self, point: &Point) -> PlanarPose {
        let mut pose = self.fixed;
        for (axis, value) in self.axes().zip(point.iter()) {
            pose[axis] = self.middle(axis) + self.bounds.half_width(axis) * value;
        }
        self.bounds.clamp(&PlanarPose::from_array(pose))
    }

    /// The point at `pose`, brought into the box.
    pub fn point(&self, pose: &PlanarPose) -> Point {
        let pose = pose.to_array();
        let mut point = Vector3::zeros();
        for (axis, value) in self.axes().zip(point.iter_mut()) {
            *value = (pose[axis] - self.middle(axis)) / self.bounds.half_width(axis);
        }
        into_box(&point)
    }

    /// Distances per component (metres, metres, radians) in half widths, without sign.
    pub fn lengths(&self, distances: [f32; 3]) -> Point {
        let mut lengths = Vector3::zeros();
        for (axis, value) in self.axes().zip(lengths.iter_mut()) {
            *value = libm::fabsf(distances[axis]) / self.bounds.half_width(axis);
        }
        lengths
    }

    /// A slope per metre and radian as one per half width.
    pub fn model(&self, slope: &Slope) -> Model {
        let mut model = Model { gradient: Vector3::zeros(), curvature: Matrix3::zeros() };
        for (i, row) in self.axes().enumerate() {
            let half = self.bounds.half_width(row);
            model.gradient[i] = 2.0 * slope.half_gradient[row] * half;
            for (j, column) in self.axes().enumerate() {
                model.curvature[(i, j)] =
                    2.0 * slope.information[(row, column)] * half * self.bounds.half_width(column);
            }
        }
        model
    }

    /// The inverse of [`Self::model`]; nothing is known about fixed components.
    pub fn slope(&self, model: &Model) -> Slope {
        let mut slope = Slope { half_gradient: Vector3::zeros(), information: Matrix3::zeros() };
        for (i, row) in self.axes().enumerate() {
            let half = self.bounds.half_width(row);
            slope.half_gradient[row] = 0.5 * model.gradient[i] / half;
            for (j, column) in self.axes().enumerate() {
                slope.information[(row, column)] =
                    0.5 * model.curvature[(i, j)] / (half * self.bounds.half_width(column));
            }
        }
        slope
    }

    fn axes(&self) -> impl Iterator<Item = usize> {
        // Each is below 3 already; said here, no place that uses one needs to look.
        self.axes.into_iter().take(self.free()).map(|axis| usize::from(axis).min(2))
    }

    fn middle(&self, axis: usize) -> f32 {
        0.5 * (self.bounds.lower[axis] + self.bounds.upper[axis])
    }
}

/// The nearest point of the unit box; what is no number becomes a corner's.
pub fn into_box(point: &Point) -> Point {
    point.map(|value| within(value, -1.0, 1.0))
}

/// `value` brought between `low` and `high`; `low` if it is no number, where the library's `clamp` would pass it on.
pub fn within(value: f32, low: f32, high: f32) -> f32 {
    value.max(low).min(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tactus_common::pose::Interval;

    fn chart(x_m: f32, y_m: f32, phi_rad: f32) -> Chart {
        let guess = PlanarPose::new(0.2, -0.1, 0.3);
        Chart::new(&Bounds::new(&guess, &Interval { x_m, y_m, phi_rad }), &guess)
    }

    #[test]
    fn fixed_components_leave_the_box_and_keep_their_value() {
        let chart = chart(0.1, 0.0, 0.5);
        assert_eq!(chart.free(), 2);
        let pose = chart.pose(&Vector3::new(1.0, -1.0, 7.0));
        assert_eq!(pose.y_m, -0.1);
        assert!((pose.x_m - 0.3).abs() < 1e-6 && (pose.phi_rad + 0.2).abs() < 1e-6, "{pose:?}");
        let back = chart.point(&pose);
        assert!((back - Vector3::new(1.0, -1.0, 0.0)).norm() < 1e-5, "{back}");
    }

    #[test]
    fn a_width_below_the_resolution_of_the_numbers_is_none() {
        assert_eq!(chart(1e-9, 0.0, f32::NAN).free(), 0);
        assert_eq!(chart(f32::INFINITY, 0.1, 0.0).free(), 1);
    }

    #[test]
    fn slopes_go_there_and_back() {
        let chart = chart(0.1, 0.0, 0.5);
        let slope = Slope {
            half_gradient: Vector3::new(1.0, 0.0, -2.0),
            information: Matrix3::new(4.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 3.0),
        };
        let model = chart.model(&slope);
        assert!((model.gradient - Vector3::new(0.2, -2.0, 0.0)).norm() < 1e-6, "{}", model.gradient);
        assert!((model.curvature[(0, 1)] - 0.1).abs() < 1e-6, "{}", model.curvature);
        let back = chart.slope(&model);
        assert!((back.half_gradient - slope.half_gradient).norm() < 1e-5);
        assert!((back.information - slope.information).norm() < 1e-5);
    }
}
