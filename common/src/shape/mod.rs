//! Convex bodies and the signed separation between a hand link and an object.
//!
//! * [`Prism`]: the collision shape of a hand link. [`ObjectShape`]: the list of object shapes.
//! * [`Separation`]: signed distance with its exact gradient over the object's planar pose.
//! * [`cuboid`]: the separation of a box from a prism. A further shape is one more file and one more arm.

pub mod cuboid;
pub mod object;
pub mod prism;
pub mod separation;

pub use object::ObjectShape;
pub use prism::{PRISM_CORNERS_MAX, Prism};
pub use separation::Separation;
