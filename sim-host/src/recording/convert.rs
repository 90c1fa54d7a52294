//! From the world's quantities to those of Foxglove's messages.

use foxglove::messages::{Point3, Pose, Quaternion, Timestamp, Vector3};
use nalgebra::{Isometry3, UnitQuaternion};
use tactus_common::limits::TICK_US;

/// Robot time of a tick, nanoseconds: a recording begins at 0.
pub fn time_ns(tick: u32) -> u64 {
    u64::from(tick) * u64::from(TICK_US) * 1_000
}

/// Robot time of a tick.
pub fn timestamp(tick: u32) -> Timestamp {
    let ns = time_ns(tick);
    Timestamp::new((ns / 1_000_000_000) as u32, (ns % 1_000_000_000) as u32)
}

/// A vector, in the unit of its components.
pub fn vector([x, y, z]: [f32; 3]) -> Vector3 {
    Vector3 { x: x.into(), y: y.into(), z: z.into() }
}

/// A point, metres.
pub fn point([x, y, z]: [f32; 3]) -> Point3 {
    Point3 { x: x.into(), y: y.into(), z: z.into() }
}

/// A rotation.
pub fn quaternion(rotation: &UnitQuaternion<f32>) -> Quaternion {
    let [x, y, z, w] = rotation.coords.into();
    Quaternion { x: x.into(), y: y.into(), z: z.into(), w: w.into() }
}

/// A pose, metres.
pub fn pose(pose: &Isometry3<f32>) -> Pose {
    Pose { position: Some(vector(pose.translation.vector.into())), orientation: Some(quaternion(&pose.rotation)) }
}
