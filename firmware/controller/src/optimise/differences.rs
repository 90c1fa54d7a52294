//! The gradient by differences, one evaluation at a time.
//!
//! One-sided `(E(x + dx) - E(x)) / dx` (Nikandrova 2011, eq. 19) or two-sided `(E(x + dx) - E(x - dx)) / (2 dx)`
//! (eq. 20), per component. At a bound the one-sided step goes inwards, and the two-sided one is shortened on the side
//! of the bound; a side where the error is no number is left out.

use super::chart::within;
use super::search::Point;
use nalgebra::Vector3;

/// A side shorter than this part of the step is not worth an evaluation.
const SIDE_MIN: f32 = 0.1;
/// The shortest and the longest step, in half widths: well above the numbers' resolution, and within the box.
const STEP_MIN: f32 = 1e-5;
const STEP_MAX: f32 = 0.5;

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differences {
    /// First derivatives, per half width.
    pub gradient: Point,
    /// `true` if the error was the same at every point.
    pub is_flat: bool,
}

/// A gradient in the making. About 80 bytes.
#[derive(Clone, Copy, Debug)]
pub struct Differencing {
    at: Point,
    error: f32,
    steps: Point,
    free: u8,
    two_sided: bool,
    axis: u8,
    is_second_side: bool,
    /// Offset and error on the first side.
    first: (f32, f32),
    found: Differences,
}

impl Differencing {
    /// The gradient at `at`, where the error is `error`, with `steps` over the first `free` components (at least one).
    pub fn new(at: &Point, error: f32, steps: &Point, free: usize, two_sided: bool) -> Self {
        let found = Differences { gradient: Vector3::zeros(), is_flat: true };
        Self {
            at: *at,
            error,
            steps: usable(steps),
            free: free as u8,
            two_sided,
            axis: 0,
            is_second_side: false,
            first: (0.0, error),
            found,
        }
    }

    /// The point to be evaluated next.
    pub fn ask(&self) -> Point {
        let axis = usize::from(self.axis);
        let mut point = self.at;
        if let Some(value) = point.get_mut(axis) {
            *value += self.offset(axis);
        }
        point
    }

    /// The error there; the gradient when all is known.
    pub fn tell(&mut self, error: f32) -> Option<Differences> {
        let axis = usize::from(self.axis);
        self.found.is_flat &= error == self.error;
        let side = if error.is_finite() { (self.offset(axis), error) } else { (0.0, self.error) };
        let has_second_side = self.offset(axis) > 0.0 && self.room(axis, -1.0) >= SIDE_MIN * self.steps[axis];
        if self.two_sided && has_second_side {
            self.first = side;
            self.is_second_side = true;
            return None;
        }
        let base = if self.is_second_side { self.first } else { (0.0, self.error) };
        let span = side.0 - base.0;
        self.found.gradient[axis] = if span == 0.0 { 0.0 } else { (side.1 - base.1) / span };
        self.is_second_side = false;
        self.axis += 1;
        (self.axis >= self.free).then_some(self.found)
    }

    /// The signed distance to the point being evaluated: upwards first, downwards where there is no room or second.
    fn offset(&self, axis: usize) -> f32 {
        let step = self.steps[axis];
        // One-sided differences need a whole step, two-sided ones do with a shorter side.
        let needed = if self.two_sided { SIDE_MIN } else { 1.0 };
        if self.is_second_side || self.room(axis, 1.0) < needed * step {
            -self.room(axis, -1.0).min(step)
        } else {
            self.room(axis, 1.0).min(step)
        }
    }

    /// The distance to the bound in the direction of `sign`.
    fn room(&self, axis: usize, sign: f32) -> f32 {
        1.0 - sign * self.at[axis]
    }
}

/// Steps that a difference can be made of.
pub fn usable(steps: &Point) -> Point {
    steps.map(|step| within(step, STEP_MIN, STEP_MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient(at: Point, two_sided: bool, error: impl Fn(&Point) -> f32) -> (Differences, usize) {
        let steps = Vector3::new(0.01, 0.02, 0.03);
        let mut differencing = Differencing::new(&at, error(&at), &steps, 3, two_sided);
        for count in 1..10 {
            let point = differencing.ask();
            assert!(point.amax() <= 1.0, "{point}");
            if let Some(found) = differencing.tell(error(&point)) {
                return (found, count);
            }
        }
        panic!("no end");
    }

    fn parabola(p: &Point) -> f32 {
        p.x * p.x + 2.0 * p.y + 3.0 * p.z * p.z
    }

    #[test]
    fn one_side_has_an_error_of_the_step_and_two_sides_have_none_on_a_parabola() {
        let at = Vector3::new(0.5, 0.0, -0.5);
        let (one, evaluations) = gradient(at, false, parabola);
        assert_eq!(evaluations, 3);
        // (x + h)^2 - x^2 = h (2 x + h): off by the step, times 3 for z.
        assert!((one.gradient - Vector3::new(1.01, 2.0, -2.91)).amax() < 1e-3, "{}", one.gradient);
        let (two, evaluations) = gradient(at, true, parabola);
        assert_eq!(evaluations, 6);
        assert!((two.gradient - Vector3::new(1.0, 2.0, -3.0)).amax() < 1e-3, "{}", two.gradient);
        assert!(!two.is_flat);
    }

    #[test]
    fn at_a_bound_the_difference_is_taken_inwards() {
        let at = Vector3::new(1.0, -1.0, 1.0);
        let (one, _) = gradient(at, false, parabola);
        assert!((one.gradient - Vector3::new(1.99, 2.0, 5.91)).amax() < 1e-2, "{}", one.gradient);
        let (two, evaluations) = gradient(at, true, parabola);
        assert_eq!(evaluations, 3);
        assert!((two.gradient - Vector3::new(1.99, 2.0, 5.91)).amax() < 1e-2, "{}", two.gradient);
    }

    #[test]
    fn a_side_without_a_number_is_left_out_and_a_plateau_is_named() {
        let cliff = |p: &Point| if p.x > 0.5 { f32::INFINITY } else { p.x };
        let (found, _) = gradient(Vector3::new(0.5, 0.0, 0.0), true, cliff);
        assert!((found.gradient - Vector3::new(1.0, 0.0, 0.0)).amax() < 1e-3, "{}", found.gradient);
        assert!(!found.is_flat);
        let (found, _) = gradient(Vector3::new(0.5, 0.0, 0.0), false, |_| 4.0);
        assert!(found.is_flat && found.gradient.amax() == 0.0);
    }
}
