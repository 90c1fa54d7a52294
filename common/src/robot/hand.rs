//! The hand: its nine links, how the motors move them, where they are.
//!
//! Hand frame: origin on the mounting plane, z out of the palm, F3 at -x, F1 at y = -0.025, F2 at y = +0.025, both
//! pointing to +x at spread 0. Finger links: x along the link, y towards the gripping side, positive angles close.

use super::tables::{
    FINGER_LIMIT, GEAR_DISTAL_ABSOLUTE, GEAR_DISTAL_ENGAGED, GEAR_INNER, HAND_PRISMS, INNER_ORIGINS, SPREAD_ORIGINS,
    TIP_LIMIT, TIP_ORIGINS,
};
use crate::limits::{FINGERS, HAND_LINKS, HAND_MOTORS};
use crate::shape::Prism;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

/// A link of the hand that can touch something; the order is that of the contact matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum HandLink {
    /// Palm, with the fixed knuckle of F3.
    Palm,
    /// Knuckle of finger 1.
    F1Knuckle,
    /// Inner link of finger 1.
    F1Inner,
    /// Tip of finger 1.
    F1Tip,
    /// Knuckle of finger 2.
    F2Knuckle,
    /// Inner link of finger 2.
    F2Inner,
    /// Tip of finger 2.
    F2Tip,
    /// Inner link of finger 3.
    F3Inner,
    /// Tip of finger 3.
    F3Tip,
}

impl HandLink {
    /// Every link, in order.
    pub const ALL: [Self; HAND_LINKS] = [
        Self::Palm,
        Self::F1Knuckle,
        Self::F1Inner,
        Self::F1Tip,
        Self::F2Knuckle,
        Self::F2Inner,
        Self::F2Tip,
        Self::F3Inner,
        Self::F3Tip,
    ];
    /// The knuckles of F1, F2; that of F3 is part of the palm.
    pub const KNUCKLES: [Option<Self>; FINGERS] = [Some(Self::F1Knuckle), Some(Self::F2Knuckle), None];
    /// The inner links of F1, F2, F3.
    pub const INNERS: [Self; FINGERS] = [Self::F1Inner, Self::F2Inner, Self::F3Inner];
    /// The tips of F1, F2, F3.
    pub const TIPS: [Self; FINGERS] = [Self::F1Tip, Self::F2Tip, Self::F3Tip];

    /// Position in [`HandLink::ALL`], 0..9.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The link at a position in [`HandLink::ALL`].
    pub fn from_index(index: usize) -> Option<Self> {
        Self::ALL.get(index).copied()
    }

    /// The finger it belongs to: 0, 1, 2 = F1, F2, F3; `None` for the palm.
    pub const fn finger(self) -> Option<usize> {
        match self {
            Self::Palm => None,
            Self::F1Knuckle | Self::F1Inner | Self::F1Tip => Some(0),
            Self::F2Knuckle | Self::F2Inner | Self::F2Tip => Some(1),
            Self::F3Inner | Self::F3Tip => Some(2),
        }
    }

    /// The link's name in the URDF.
    pub const fn urdf_name(self) -> &'static str {
        match self {
            Self::Palm => "hand_palm",
            Self::F1Knuckle => "finger1_knuckle",
            Self::F1Inner => "finger1_inner",
            Self::F1Tip => "finger1_tip",
            Self::F2Knuckle => "finger2_knuckle",
            Self::F2Inner => "finger2_inner",
            Self::F2Tip => "finger2_tip",
            Self::F3Inner => "finger3_inner",
            Self::F3Tip => "finger3_tip",
        }
    }
}

/// The collision shape of a link, in the link's own frame.
pub fn hand_prism(link: HandLink) -> &'static Prism {
    static SHARED: [Prism; HAND_LINKS] = HAND_PRISMS;
    &SHARED[link.index()]
}

/// Tip angle per inner-link angle while the TorqueSwitch is engaged: 1/3.
pub const ENGAGED_RATIO: f32 = GEAR_INNER / GEAR_DISTAL_ENGAGED;
/// Tip angle against the palm per motor angle (motor angle = inner angle while engaged): 4/3.
pub const ABSOLUTE_RATIO: f32 = GEAR_INNER / GEAR_DISTAL_ABSOLUTE;

/// The joint angles of the hand, radians, positive = closing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HandAngles {
    /// Inner links F1, F2, F3; 0 = in the palm's plane, pointing outwards.
    pub inner_rad: [f32; FINGERS],
    /// Tips F1, F2, F3 against their inner links; 0 = fully open (bent by 40 degrees, which the model adds).
    pub distal_rad: [f32; FINGERS],
    /// Spread; 0 = F1 and F2 opposite F3, pi = beside it. F1 turns about the hand's -z, F2 about +z.
    pub spread_rad: f32,
}

impl HandAngles {
    /// The angles that encoder readings imply: the motor turns the tip against the palm by 4/3 of its angle at the
    /// inner link, whether the TorqueSwitch is engaged or broken away (facts 2.4), so tip = 4/3 motor - inner.
    ///
    /// `motor_q_rad`: F1 F2 F3 spread, as in [`crate::reading::JointReadings`]; `inner_q_rad`: secondary encoders.
    pub fn from_readings(motor_q_rad: &[f32; HAND_MOTORS], inner_q_rad: &[f32; FINGERS]) -> Self {
        let mut distal_rad = [0.0; FINGERS];
        for (finger, distal) in distal_rad.iter_mut().enumerate() {
            *distal = ABSOLUTE_RATIO * motor_q_rad[finger] - inner_q_rad[finger];
        }
        Self { inner_rad: *inner_q_rad, distal_rad, spread_rad: motor_q_rad[3] }
    }

    /// The angles with every TorqueSwitch engaged: tip = inner / 3.
    pub fn engaged(inner_rad: [f32; FINGERS], spread_rad: f32) -> Self {
        Self { inner_rad, distal_rad: inner_rad.map(|q| ENGAGED_RATIO * q), spread_rad }
    }

    /// `true` if every angle is within its limits and none is NaN.
    pub fn within_limits(&self) -> bool {
        self.inner_rad.iter().all(|q| FINGER_LIMIT.contains(*q))
            && self.distal_rad.iter().all(|q| TIP_LIMIT.contains(*q))
            && super::tables::SPREAD_LIMIT.contains(self.spread_rad)
    }
}

/// Rotation about a link's z axis by a joint angle in radians.
fn about_z(angle_rad: f32) -> UnitQuaternion<f32> {
    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle_rad)
}

/// Rotation of a knuckle about its spread axis: F1 about its own -y, F2 about +y.
fn about_spread(finger: usize, angle_rad: f32) -> UnitQuaternion<f32> {
    let signed = if finger == 0 { -angle_rad } else { angle_rad };
    UnitQuaternion::from_axis_angle(&Vector3::y_axis(), signed)
}

/// World-from-link poses of all links, in the order of [`HandLink::ALL`].
pub fn link_poses(world_from_hand: &Isometry3<f32>, angles: &HandAngles) -> [Isometry3<f32>; HAND_LINKS] {
    let mut poses = [*world_from_hand; HAND_LINKS];
    for finger in 0..FINGERS {
        let knuckle = knuckle_pose(world_from_hand, finger, angles.spread_rad);
        if let Some(link) = HandLink::KNUCKLES[finger] {
            poses[link.index()] = knuckle;
        }
        let (inner_rad, distal_rad) = (angles.inner_rad[finger], angles.distal_rad[finger]);
        if let Some([inner, tip]) = finger_poses(&knuckle, finger, inner_rad, distal_rad) {
            poses[HandLink::INNERS[finger].index()] = inner;
            poses[HandLink::TIPS[finger].index()] = tip;
        }
    }
    poses
}

/// Pose of a finger's knuckle, which closing does not move; F3 has none that turns, its place is taken by the palm.
pub fn knuckle_pose(world_from_hand: &Isometry3<f32>, finger: usize, spread_rad: f32) -> Isometry3<f32> {
    match SPREAD_ORIGINS.get(finger) {
        Some(origin) => world_from_hand * origin.isometry() * about_spread(finger, spread_rad),
        None => *world_from_hand,
    }
}

/// Poses of a finger's inner link and tip, on its knuckle; `None` if there is no such finger.
pub fn finger_poses(
    knuckle: &Isometry3<f32>,
    finger: usize,
    inner_rad: f32,
    distal_rad: f32,
) -> Option<[Isometry3<f32>; 2]> {
    let (inner_origin, tip_origin) = INNER_ORIGINS.get(finger).zip(TIP_ORIGINS.get(finger))?;
    let inner = knuckle * inner_origin.isometry() * about_z(inner_rad);
    Some([inner, inner * tip_origin.isometry() * about_z(distal_rad)])
}

#[cfg(test)]
mod tests;
