//! Error functions: how badly a hypothesised pose explains what was felt.

pub mod contact;
pub mod geometric;
pub mod published;

pub use contact::ContactError;
pub use geometric::{Geometric, GeometricConfig};
pub use published::{Published, PublishedConfig};

use nalgebra::{Matrix3, Vector3};
use tactus_common::pose::PlanarPose;

/// The error functions, by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ErrorKind {
    /// Contact mismatch (Nikandrova 2011, eq. 21).
    Contact,
    /// Weighted contact mismatch (eq. 23).
    Weighted,
    /// Weighted contact mismatch and the closed hand's angles (eq. 24).
    Modified,
    /// Distances of touching and free links from the surface: [`Geometric`].
    #[default]
    Geometric,
}

impl ErrorKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Contact, Self::Weighted, Self::Modified, Self::Geometric];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Weighted => "weighted",
            Self::Modified => "modified",
            Self::Geometric => "geometric",
        }
    }

    /// The one with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Which of the published errors it is; `None` for one that is not.
    pub const fn published(self) -> Option<ContactError> {
        match self {
            Self::Contact => Some(ContactError::Mismatch),
            Self::Weighted => Some(ContactError::Weighted),
            Self::Modified => Some(ContactError::Modified),
            Self::Geometric => None,
        }
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::PredictorKind;

    #[test]
    fn errors_and_predictors_are_found_by_their_names() {
        for kind in ErrorKind::ALL {
            assert_eq!(ErrorKind::from_name(kind.name()), Some(kind));
        }
        for kind in PredictorKind::ALL {
            assert_eq!(PredictorKind::from_name(kind.name()), Some(kind));
        }
        assert_eq!((ErrorKind::from_name("Modified"), PredictorKind::from_name("")), (None, None));
    }
}
