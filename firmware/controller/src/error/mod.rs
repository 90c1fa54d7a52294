//! Error functions: how badly a hypothesised pose explains what was felt.

pub mod contact;
pub mod geometric;

pub use geometric::{Geometric, GeometricConfig};

use nalgebra::{Matrix3, Vector3};
use tactus_common::pose::PlanarPose;

/// What an error function says about one pose. Counts as one evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    /// The error; 0 = everything is explained. Never negative, may be infinite where nothing can be said.
    pub error: f32,
    /// Slope and curvature, if the error function has them.
    pub slope: Option<Slope>,
}

/// Gauss-Newton model of an error that is a sum of weighted squares `error = sum w r^2`, over `(x, y, phi)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// `J' W r`: half the gradient, per metre, metre, radian.
    pub half_gradient: Vector3<f32>,
    /// `J' W J`: half the curvature, and the information (inverse covariance) about the pose if residuals are in
    /// standard deviations.
    pub information: Matrix3<f32>,
}

impl Evaluation {
    /// `true` if every number is finite.
    pub fn is_finite(&self) -> bool {
        let slope_finite = match &self.slope {
            Some(s) => s.half_gradient.iter().chain(s.information.iter()).all(|v| v.is_finite()),
            None => true,
        };
        self.error.is_finite() && slope_finite
    }
}

/// An error over the planar pose of the object.
pub trait ErrorFunction {
    /// The error at `pose`. The work is bounded by the amount of evidence.
    fn evaluate(&self, pose: &PlanarPose) -> Evaluation;
}
