//! Gradient and curvature by differences, one evaluation at a time.
//!
//! Second differences on the points `c`, `c +- h_i e_i` and `c + h_i e_i + h_j e_j` (Abramowitz & Stegun 1964,
//! 25.3.23 and 25.3.26 in its one-sided form): 2, 5 or 9 evaluations for 1, 2 or 3 components, one more next to a
//! bound, where the stencil is moved inwards and its quadratic is then read at the point itself.

use super::differences::usable;
use super::search::{Model, Point};
use nalgebra::{Matrix3, Vector3};

/// Points of a stencil besides its start: the middle, two on each axis, one for each pair.
const POINTS_MAX: usize = 10;
/// Times that a matrix is made more convex before it is given up.
const SHIFTS_MAX: usize = 24;

/// A stencil in the making. About 100 bytes.
#[derive(Clone, Copy, Debug)]
pub struct Stencil {
    at: Point,
    middle: Point,
    steps: Point,
    free: u8,
    two_sided: bool,
    /// Index of the point being evaluated; 0 is the middle.
    index: u8,
    errors: [f32; POINTS_MAX],
}

impl Stencil {
    /// The model at `at`, where the error is `error`. The gradient is taken from the upper sides only unless `two_sided`.
    pub fn new(at: &Point, error: f32, steps: &Point, free: usize, two_sided: bool) -> Self {
        let steps = usable(steps);
        let middle = at.zip_map(&steps, |value, step| value.max(step - 1.0).min(1.0 - step));
        let mut errors = [f32::INFINITY; POINTS_MAX];
        errors[0] = error;
        let is_moved = (middle - at).rows(0, free.min(3)).amax() > 0.0;
        Self { at: *at, middle, steps, free: free as u8, two_sided, index: u8::from(!is_moved), errors }
    }

    /// Free components; the compiler sees that they are 3 at most.
    fn free(&self) -> usize {
        usize::from(self.free).min(3)
    }

    /// The point to be evaluated next.
    pub fn ask(&self) -> Point {
        let (free, index) = (self.free(), usize::from(self.index));
        let mut point = self.middle;
        for axis in free..3 {
            point[axis] = 0.0;
        }
        if (1..=2 * free).contains(&index) {
            let axis = (index - 1) / 2;
            point[axis] += if index % 2 == 1 { self.steps[axis] } else { -self.steps[axis] };
        } else if index > 0
            && let Some((i, j)) = PAIRS.get(index - 1 - 2 * free)
        {
            point[*i] += self.steps[*i];
            point[*j] += self.steps[*j];
        }
        point
    }

    /// The error there; the model, and whether the error was the same at every point, when all is known.
    pub fn tell(&mut self, error: f32) -> Option<(Model, bool)> {
        let free = self.free();
        let count = 1 + 2 * free + free * free.saturating_sub(1) / 2;
        if let Some(slot) = self.errors.get_mut(usize::from(self.index)) {
            *slot = error;
        }
        self.index += 1;
        (usize::from(self.index) >= count)
            .then(|| (self.model(), self.errors.iter().take(count).all(|e| *e == self.errors[0])))
    }

    fn model(&self) -> Model {
        let free = self.free();
        let mut model = Model { gradient: Vector3::zeros(), curvature: Matrix3::zeros() };
        let base = self.errors[0];
        for axis in 0..free {
            let h = self.steps[axis];
            let (up, down) = (self.errors[2 * axis + 1], self.errors[2 * axis + 2]);
            let (rise, fall) = ((up - base) / h, (base - down) / h);
            model.gradient[axis] = match (rise.is_finite(), fall.is_finite()) {
                (true, true) if self.two_sided => 0.5 * (rise + fall),
                (true, _) => rise,
                (false, true) => fall,
                (false, false) => 0.0,
            };
            model.curvature[(axis, axis)] = finite((rise - fall) / h);
        }
        for (pair, (i, j)) in PAIRS.iter().enumerate().take(free * free.saturating_sub(1) / 2) {
            let (up_i, up_j) = (self.errors[2 * i + 1], self.errors[2 * j + 1]);
            let both = self.errors[1 + 2 * free + pair];
            let cross = finite((both - up_i - up_j + base) / (self.steps[*i] * self.steps[*j]));
            model.curvature[(*i, *j)] = cross;
            model.curvature[(*j, *i)] = cross;
        }
        let mut offset = self.at - self.middle;
        for axis in free..3 {
            offset[axis] = 0.0;
        }
        model.gradient += model.curvature * offset;
        model
    }
}

/// The pairs of components in the order of the stencil; the first is the only one of two components.
const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

/// `curvature` plus the least multiple of the identity, among growing ones, that makes it safely positive definite;
/// `None` if its numbers are beyond that (Nocedal & Wright 2006, algorithm 3.3).
pub fn made_convex(curvature: &Matrix3<f32>) -> Option<Matrix3<f32>> {
    let scale = curvature.norm();
    if !scale.is_finite() || scale == 0.0 {
        return None;
    }
    let least = (0..3).fold(f32::INFINITY, |least, axis| least.min(curvature[(axis, axis)]));
    // f32 resolves a condition number of about 1e5.
    let floor = 1e-5 * scale;
    let mut shift = if least > 0.0 { 0.0 } else { floor - least };
    for _ in 0..SHIFTS_MAX {
        let shifted = curvature + Matrix3::identity() * shift;
        if let Some(root) = shifted.cholesky()
            && (0..3).all(|axis| root.l_dirty()[(axis, axis)] * root.l_dirty()[(axis, axis)] > 0.1 * floor)
        {
            return Some(shifted);
        }
        shift = (2.0 * shift).max(floor);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quadratic(p: &Point) -> f32 {
        1.0 + p.x - 2.0 * p.y + 3.0 * p.x * p.x + p.y * p.y + 2.0 * p.z * p.z + p.x * p.y - 0.5 * p.y * p.z
    }

    fn model(at: Point, free: usize, error: impl Fn(&Point) -> f32) -> (Model, bool, usize) {
        let mut stencil = Stencil::new(&at, error(&at), &Vector3::repeat(0.05), free, true);
        for count in 1..12 {
            let point = stencil.ask();
            assert!(point.amax() <= 1.0, "{point}");
            if let Some((model, is_flat)) = stencil.tell(error(&point)) {
                return (model, is_flat, count);
            }
        }
        panic!("no end");
    }

    #[test]
    fn a_quadratic_is_known_exactly_also_in_a_corner() {
        for (at, evaluations) in
            [(Vector3::new(0.2, -0.3, 0.4), 9), (Vector3::new(1.0, -1.0, 0.4), 10), (Vector3::new(1.0, 1.0, -1.0), 10)]
        {
            let (model, is_flat, count) = model(at, 3, quadratic);
            let gradient =
                Vector3::new(1.0 + 6.0 * at.x + at.y, -2.0 + 2.0 * at.y + at.x - 0.5 * at.z, 4.0 * at.z - 0.5 * at.y);
            let curvature = Matrix3::new(6.0, 1.0, 0.0, 1.0, 2.0, -0.5, 0.0, -0.5, 4.0);
            assert!((model.gradient - gradient).amax() < 5e-3, "{} {gradient}", model.gradient);
            assert!((model.curvature - curvature).amax() < 5e-3, "{}", model.curvature);
            assert_eq!((count, is_flat), (evaluations, false));
        }
    }

    #[test]
    fn fewer_components_need_fewer_evaluations_and_leave_the_others_alone() {
        let (two, _, count) = model(Vector3::new(0.2, -0.3, 0.0), 2, quadratic);
        assert_eq!((count, two.gradient.z, two.curvature[(2, 2)]), (5, 0.0, 0.0));
        let (one, _, count) = model(Vector3::new(1.0, 0.0, 0.0), 1, quadratic);
        assert_eq!((count, one.curvature[(1, 1)]), (3, 0.0));
        assert!((one.gradient.x - 7.0).abs() < 1e-3);
    }

    #[test]
    fn a_plateau_is_named_and_a_cliff_gives_numbers() {
        assert!(model(Vector3::zeros(), 3, |_| 2.0).1);
        let (model, _, _) = model(Vector3::zeros(), 3, |p| if p.x > 0.0 { f32::INFINITY } else { -p.x });
        assert!(model.gradient.iter().chain(model.curvature.iter()).all(|v| v.is_finite()), "{model:?}");
        assert!((model.gradient.x + 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_saddle_is_made_convex_and_a_bowl_is_left_as_it_is() {
        let bowl = Matrix3::new(6.0, 1.0, 0.0, 1.0, 2.0, -0.5, 0.0, -0.5, 4.0);
        assert_eq!(made_convex(&bowl), Some(bowl));
        let saddle = Matrix3::new(1.0, 3.0, 0.0, 3.0, 1.0, 0.0, 0.0, 0.0, -1.0);
        assert!(made_convex(&saddle).expect("shifted").cholesky().is_some());
        assert_eq!(made_convex(&Matrix3::repeat(f32::NAN)), None);
    }
}
