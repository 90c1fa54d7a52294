//! How the pose is to be found: part of what a mission is told, by name.
//!
//! The lists of names are the controller's (`error`, `optimise::method`, `predict`, `optimise::options`), so that a new
//! optimiser or error changes nothing here.

use crate::name::Name;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Which error is minimised, by which optimiser, with which parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Method {
    /// Error function.
    pub error: Name,
    /// Optimiser.
    pub optimizer: Name,
    /// What foretells the readings, for the errors that compare contacts.
    pub predictor: Name,
    /// Where slopes come from, for the optimisers that use one.
    pub gradient: Name,
    /// Damping constant `a` of the weighted errors in instants (Nikandrova 2011, eq. 22), greater than 0.
    pub damping: f32,
    /// Time instants of the contact matrices that are compared, 1 to [`crate::message::ROLLOUT_INSTANTS`].
    pub instants: u8,
    /// Most evaluations of the error in one update; 0 = as many as the optimiser takes by itself.
    pub evaluations_max: u16,
}

impl Method {
    /// The method unless told otherwise.
    pub const DEFAULT: Self = Self {
        error: literal("geometric"),
        optimizer: literal("levenberg-marquardt"),
        predictor: literal("kinematic"),
        gradient: literal("analytic"),
        damping: 4.0,
        instants: 16,
        evaluations_max: 0,
    };
}

impl Default for Method {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// For constants alone: one that is no name does not compile.
const fn literal(text: &str) -> Name {
    match Name::new(text) {
        Some(name) => name,
        None => panic!("not a name"),
    }
}
