//! The Barrett WAM 7-DOF and BarrettHand BH8-280: tables from the URDF, kinematics, dynamics.
//!
//! Frames, symbols and signs: `docs/notation.md`. The numbers come from `common/models/` alone.
//!
//! * [`arm`]: forward kinematics and Jacobian. [`inverse`]: closed-form inverse kinematics.
//! * [`dynamics`]: recursive Newton-Euler, gravity.
//! * [`hand`]: links, couplings and poses of the hand, and their shapes.
//! * [`tables`]: everything else that the URDF and the TOML say.

pub mod arm;
pub mod dynamics;
pub mod hand;
pub mod inverse;
pub mod source;
pub mod tables;

pub use arm::{MOUNT, world_from_base};
pub use hand::{HandLink, hand_prism};
pub use tables::{
    ARM_LIMITS, FINGER_LIMIT, FINGERTIP_TAXELS, Inertial, JointLimit, JointOrigin, PALM_TAXELS, SPREAD_LIMIT,
    TIP_LIMIT, Taxel,
};
