//! Conjugate gradients: `d_{k+1} = -g_{k+1} + beta_k d_k`, restarted in cycles with a step of steepest descent.
//!
//! `beta` by Polak & Ribiere (1969; Nikandrova 2011, eq. 7), never negative (Powell 1984), or by Fletcher & Reeves
//! (1964; eq. 8 with the numerator `g_{k+1}' g_{k+1}`). A cycle has as many steps as there are free components; it also
//! ends where a component reaches or leaves its bound, since directions then live in another space, and where a line
//! leads nowhere.

use super::descent::{Descent, Direction, Heading, Slope};
use super::line::{Bracketed, GoldenSection};
use super::search::{Point, Search};
use nalgebra::Vector3;

/// A rule for `beta`.
pub trait Rule {
    /// `beta` from the gradient here and the one before.
    fn beta(gradient: &Point, before: &Point) -> f32;
}

/// Polak and Ribiere's rule.
#[derive(Clone, Copy, Debug, Default)]
pub struct PolakRibiere;

impl Rule for PolakRibiere {
    fn beta(gradient: &Point, before: &Point) -> f32 {
        ((gradient - before).dot(gradient) / before.norm_squared()).max(0.0)
    }
}

/// Fletcher and Reeves' rule.
#[derive(Clone, Copy, Debug, Default)]
pub struct FletcherReeves;

impl Rule for FletcherReeves {
    fn beta(gradient: &Point, before: &Point) -> f32 {
        gradient.norm_squared() / before.norm_squared()
    }
}

/// Conjugate directions.
#[derive(Clone, Copy, Debug)]
pub struct Conjugate<R> {
    /// Steps since the cycle began.
    age: usize,
    gradient: Point,
    direction: Point,
    held: [bool; 3],
    rule: core::marker::PhantomData<R>,
}

impl<R: Rule> Direction for Conjugate<R> {
    fn new(_free: usize) -> Self {
        let rule = core::marker::PhantomData;
        Self { age: 0, gradient: Vector3::zeros(), direction: Vector3::zeros(), held: [false; 3], rule }
    }

    fn choose(&mut self, slope: &Slope) -> Heading {
        let steepest = -slope.gradient;
        let is_cycle_over = self.age == 0 || self.age >= slope.free || self.held != slope.held;
        let mut direction = steepest;
        if !is_cycle_over {
            direction += self.direction * R::beta(&slope.gradient, &self.gradient);
        }
        let is_descent = direction.dot(&slope.gradient) < 0.0;
        if is_cycle_over || !is_descent {
            self.age = 0;
            direction = steepest;
        }
        self.age += 1;
        self.gradient = slope.gradient;
        self.direction = direction;
        self.held = slope.held;
        Heading { direction, is_whole_step: false }
    }

    fn restart(&mut self) -> bool {
        let was_conjugate = self.age > 1;
        self.age = 0;
        was_conjugate
    }
}

/// Conjugate gradients by Polak and Ribiere, with bracketing and golden sections.
pub type ConjugateGradientsPr = Search<Descent<Conjugate<PolakRibiere>, Bracketed<GoldenSection>>>;
/// Conjugate gradients by Fletcher and Reeves, with bracketing and golden sections.
pub type ConjugateGradientsFr = Search<Descent<Conjugate<FletcherReeves>, Bracketed<GoldenSection>>>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_rules_agree_where_gradients_are_orthogonal_and_differ_where_they_are_not() {
        let before = Vector3::new(1.0, 0.0, 0.0);
        let across = Vector3::new(0.0, 0.5, 0.0);
        assert_eq!(PolakRibiere::beta(&across, &before), FletcherReeves::beta(&across, &before));
        let along = Vector3::new(0.8, 0.0, 0.0);
        assert_eq!(PolakRibiere::beta(&along, &before), 0.0);
        assert!((FletcherReeves::beta(&along, &before) - 0.64).abs() < 1e-6);
    }

    #[test]
    fn a_cycle_is_as_long_as_there_are_components_and_begins_steepest() {
        let slope = |gradient: Point| Slope {
            point: Vector3::zeros(),
            free: 2,
            gradient,
            curvature: None,
            held: [false, false, true],
        };
        let mut rule = Conjugate::<FletcherReeves>::new(2);
        let first = Vector3::new(1.0, 0.0, 0.0);
        let second = Vector3::new(0.0, 0.5, 0.0);
        assert_eq!(rule.choose(&slope(first)).direction, -first);
        assert_eq!(rule.choose(&slope(second)).direction, -second - first * 0.25);
        assert_eq!(rule.choose(&slope(first)).direction, -first);
    }
}
