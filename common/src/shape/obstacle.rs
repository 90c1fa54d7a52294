//! What stands on the table besides the object.

use super::ObjectShape;
use crate::pose::PlanarPose;
use nalgebra::Isometry3;
use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// A body that stands on the table where it is known to stand, and that is not the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Obstacle {
    /// What it is.
    pub shape: ObjectShape,
    /// Where it stands, world frame.
    pub pose: PlanarPose,
}

impl Obstacle {
    /// World-from-obstacle transform.
    pub fn isometry(&self) -> Isometry3<f32> {
        self.pose.isometry(self.shape.rest_height_m())
    }
}
