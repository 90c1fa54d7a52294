//! What both ends of the Tactus wire agree on.
//!
//! * [`limits`]: every capacity, period and timeout, and the relations between them.
//! * [`robot`]: the Barrett WAM and BarrettHand: tables from the URDF, kinematics, dynamics, inverse kinematics.
//! * [`shape`]: convex bodies and the signed separation between them, with gradient.
//! * [`pose`]: the planar pose of an object on a table, and the interval it is known to lie in.
//! * [`reading`]: one tick of sensor readings and one tick of commands, in SI units.
//! * [`trajectory`]: motion of the arm as timed knots, sampling and checking.
//! * [`method`]: how the pose is to be found, by [`name`].
//! * [`random`]: random numbers that a seed repeats everywhere.
//! * [`message`]: what crosses the wire. [`cyphal`]: how it crosses CAN, in fixed memory, as [`can`] frames; [`slcan`]: these as
//!   text on a serial line.
//! * [`puck`]: Barrett's own CAN protocol, the way to the real arm and hand.
//!
//! `no_std`, no heap, `f32` through `libm` only, so that the same inputs give the same bits on every target.
#![no_std]
#![forbid(unsafe_code)]

pub mod can;
pub mod cyphal;
pub mod limits;
pub mod link;
pub mod message;
pub mod method;
pub mod name;
pub mod pose;
pub mod puck;
pub mod random;
pub mod reading;
pub mod robot;
pub mod shape;
pub mod slcan;
pub mod trajectory;
