//! Convex bodies and the signed separation between a hand link and an object.
//!
//! * [`Prism`]: the collision shape of a hand link. [`ObjectShape`]: the list of object shapes.
//! * [`Separation`]: signed distance with its exact gradient over the object's planar pose.
//! * [`cuboid`], [`cylinder`], [`sphere`], [`capsule`], [`hull`]: the shapes, each with its separation from a prism. A
//!   further shape is one more file and one more arm.
//! * [`Obstacle`]: a shape that stands where it is known to stand.

mod axis;
pub mod capsule;
pub mod cuboid;
pub mod cylinder;
pub mod hull;
mod nearest;
pub mod object;
pub mod obstacle;
mod placed;
pub mod prism;
pub mod separation;
pub mod sphere;

pub use hull::{Hull, HullFault};
pub use object::ObjectShape;
pub use obstacle::Obstacle;
pub use prism::{PRISM_CORNERS_MAX, Prism};
pub use separation::Separation;

#[cfg(test)]
mod tests;
