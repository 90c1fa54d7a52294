//! Newton-Raphson with backtracking: `x_{k+1} = x_k - lambda_k H^-1 g` (Nikandrova 2011, eq. 14).
//!
//! `H` by differences, or Gauss-Newton's where the error function gives it. Where `H` is not positive definite it is
//! made so by a multiple of the identity (Nocedal & Wright 2006, algorithm 3.3), so that the step leads downhill.

use super::descent::{Descent, Direction, Heading, Slope};
use super::line::Backtracking;
use super::search::{Point, Search};
use super::stencil::made_convex;

/// Newton's direction.
#[derive(Clone, Copy, Debug, Default)]
pub struct Newton;

impl Direction for Newton {
    fn new(_free: usize) -> Self {
        Self
    }

    fn wants_curvature(&self) -> bool {
        true
    }

    fn choose(&mut self, slope: &Slope) -> Heading {
        match newton_step(slope) {
            Some(direction) => Heading { direction, is_whole_step: true },
            None => Heading { direction: -slope.gradient, is_whole_step: false },
        }
    }
}

/// The step to the minimum of the quadratic that slope and curvature describe, over the components that are not held;
/// `None` if the curvature is unknown or of no use.
pub fn newton_step(slope: &Slope) -> Option<Point> {
    let curvature = slope.curvature?;
    let mut held = slope.held;
    // A component that the step would take out of the box is held too; that may turn another one outwards, hence at most
    // three rounds.
    for _ in 0..3 {
        let (mut system, mut gradient) = (curvature, slope.gradient);
        let scale = curvature.norm();
        for axis in 0..3 {
            if held[axis] {
                for other in 0..3 {
                    system[(axis, other)] = 0.0;
                    system[(other, axis)] = 0.0;
                }
                system[(axis, axis)] = scale;
                gradient[axis] = 0.0;
            }
        }
        let step = -made_convex(&system)?.cholesky()?.solve(&gradient);
        let mut crossed = false;
        for axis in 0..3 {
            if !held[axis] && slope.is_blocked(axis, step[axis]) {
                held[axis] = true;
                crossed = true;
            }
        }
        if !crossed {
            return step.iter().all(|v| v.is_finite()).then_some(step);
        }
    }
    None
}

/// Newton-Raphson with backtracking.
pub type NewtonRaphson = Search<Descent<Newton, Backtracking>>;

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    #[test]
    fn the_step_leads_to_the_minimum_of_a_quadratic_and_past_no_bound() {
        let curvature = Matrix3::new(4.0, 1.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 1.0);
        let minimum = Vector3::new(0.4, -0.3, 0.2);
        let slope = |point: Point| Slope {
            point,
            free: 3,
            gradient: curvature * (point - minimum),
            curvature: Some(curvature),
            held: [false; 3],
        };
        let inside = slope(Vector3::new(-0.5, 0.5, 0.0));
        assert!((newton_step(&inside).expect("step") - (minimum - inside.point)).amax() < 1e-5);
        // From the upper bound of x, with the minimum beyond it.
        let mut at_bound = slope(Vector3::new(1.0, 0.0, 0.0));
        at_bound.gradient = curvature * (at_bound.point - Vector3::new(1.5, 0.2, 0.2));
        let step = newton_step(&at_bound).expect("step");
        assert_eq!(step.x, 0.0);
        assert!((step.y + at_bound.gradient.y / 2.0).abs() < 1e-5 && (step.z - 0.2).abs() < 1e-5, "{step}");
    }

    #[test]
    fn on_a_saddle_the_step_leads_downhill() {
        let curvature = Matrix3::from_diagonal(&Vector3::new(1.0, -2.0, 1.0));
        let gradient = Vector3::new(0.1, 0.1, -0.1);
        let slope = Slope { point: Vector3::zeros(), free: 3, gradient, curvature: Some(curvature), held: [false; 3] };
        assert!(newton_step(&slope).expect("step").dot(&gradient) < 0.0);
    }
}
