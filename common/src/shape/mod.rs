//! Convex bodies and the signed separation between a hand link and an object.

pub mod prism;

pub use prism::Prism;
