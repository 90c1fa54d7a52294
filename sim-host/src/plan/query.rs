//! What can be asked of the planner, and its refusals.

use super::Joints;
use super::scene::Block;
use nalgebra::Isometry3;
use rapier3d::parry::math::Vector;
use tactus_common::pose::PlanarPose;
use tactus_common::robot::hand::HandAngles;
use tactus_common::shape::ObjectShape;
use tactus_common::trajectory::TrajectoryError;

/// Highest approach, metres.
const HEIGHT_MAX_M: f32 = 0.6;

/// What a motion is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Travel to above the goal, then guarded straight down.
    Touch,
    /// As [`Purpose::Touch`].
    Grasp,
    /// Straight up with the object, over, guarded straight down.
    Transport,
    /// Straight up by the approach height; the goal is ignored.
    Retreat,
    /// Travel to the goal; no approach line.
    Home,
}

/// Where the object is believed to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectEstimate {
    /// Its shape.
    pub shape: ObjectShape,
    /// Believed pose.
    pub pose: PlanarPose,
    /// Height of the object frame (its middle) above the table top, metres.
    pub z_m: f32,
    /// How much larger the object is taken to be on each side, along its axes, metres: see [`ObjectEstimate::with_sigma`].
    pub inflation_m: [f32; 3],
}

/// A request for a motion.
#[derive(Clone, Copy, Debug)]
pub struct PlanQuery {
    /// Number of the request, handed through to the trajectory.
    pub request: u16,
    /// What the motion is for.
    pub purpose: Purpose,
    /// Where the arm rests now, radians.
    pub start_q_rad: Joints,
    /// How the fingers stand during the motion.
    pub hand_angles: HandAngles,
    /// Where the hand frame shall end up, in the world.
    pub goal_world_from_hand: Isometry3<f32>,
    /// Length of the straight vertical part: the approach above the goal, the lift of a transport, the whole retreat, metres in [0, 0.6].
    pub approach_height_m: f32,
    /// The object: to be avoided on the way, or carried in a transport.
    pub object: Option<ObjectEstimate>,
    /// Where a transport is to go from the goal (hand pose), if one will follow: the posture at the goal is then chosen so that it can.
    pub next_world_from_hand: Option<Isometry3<f32>>,
}

/// Why there is no plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanRefusal {
    /// Every posture for some pose of the motion breaks a joint limit or is singular, or no posture can be kept along the line.
    #[error("no inverse kinematics within joint limits along the motion")]
    NoInverseKinematics,
    /// Some pose of the motion is too far from, or too near to the shoulder.
    #[error("out of reach")]
    OutOfReach,
    /// The robot touches the table, itself, or with arm or palm the object, where it starts.
    #[error("the start posture is in collision")]
    StartInCollision,
    /// Every posture at or above the goal is in collision.
    #[error("the goal is in collision")]
    GoalInCollision,
    /// The goal is good, but the bounded search found no way to it.
    #[error("no collision-free path found")]
    NoPath,
    /// The motion needs more knots than a trajectory holds.
    #[error("the motion needs too many knots")]
    TooManyKnots,
    /// The query holds a number that is not finite, or an approach height out of range.
    #[error("the query holds a number that is not finite or out of range")]
    NonFinite,
    /// The motion found breaks a limit of the trajectory (a start outside the joint limits, for one).
    #[error("the motion found does not pass the trajectory check: {0:?}")]
    Unfit(TrajectoryError),
}

/// Margins and speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannerConfig {
    /// Distance from the object that travel keeps, beyond its inflation, metres.
    pub object_margin_m: f32,
    /// Distance from obstacles that travel keeps, metres.
    pub obstacle_margin_m: f32,
    /// Distance from obstacles that guarded and lifting motions keep, metres.
    pub contact_obstacle_margin_m: f32,
    /// Height above the table that travel keeps, metres.
    pub table_margin_m: f32,
    /// Height above the table that guarded and lifting motions keep, metres.
    pub contact_table_margin_m: f32,
    /// Distance between parts of the robot that can meet, metres.
    pub self_margin_m: f32,
    /// Part of the joints' velocity limits that is used.
    pub velocity_scale: f32,
    /// Part of the joints' acceleration limits that is used.
    pub acceleration_scale: f32,
    /// The same with an object in the hand.
    pub carry_acceleration_scale: f32,
    /// Speed of guarded descents, m/s.
    pub guarded_speed_m_s: f32,
    /// Speed of straight upward motions, m/s.
    pub retreat_speed_m_s: f32,
    /// Speed of an object that is carried over, m/s.
    pub carry_speed_m_s: f32,
}

impl Default for PlannerConfig {
    fn default() -> Self {
        Self {
            object_margin_m: 0.01,
            obstacle_margin_m: 0.02,
            contact_obstacle_margin_m: 0.003,
            table_margin_m: 0.02,
            contact_table_margin_m: 0.002,
            self_margin_m: 0.01,
            // The rest is left to the controller for following.
            velocity_scale: 0.85,
            acceleration_scale: 0.85,
            carry_acceleration_scale: 0.5,
            guarded_speed_m_s: 0.06,
            retreat_speed_m_s: 0.25,
            carry_speed_m_s: 0.5,
        }
    }
}

impl ObjectEstimate {
    /// An estimate whose inflation is three standard deviations: `sigma_m` of the position along the object's x and y, metres, `sigma_phi_rad` of
    /// its yaw. Never more than `HALF_MAX` = 0.3 m a side: what lies beyond is the table's edge.
    pub fn with_sigma(shape: &ObjectShape, pose: PlanarPose, z_m: f32, sigma_m: [f32; 2], sigma_phi_rad: f32) -> Self {
        const HALF_MAX: f32 = 0.3;
        let turn = 3.0 * sigma_phi_rad;
        let half_extents_m = shape.half_extents_m();
        let inflation_m = [
            (3.0 * sigma_m[0] + turn * half_extents_m[1]).clamp(0.0, HALF_MAX),
            (3.0 * sigma_m[1] + turn * half_extents_m[0]).clamp(0.0, HALF_MAX),
            0.0,
        ];
        Self { shape: *shape, pose, z_m, inflation_m }
    }

    /// The bounding box of the object as believed, grown by `margin_m` on every side.
    pub(super) fn block(&self, margin_m: f32) -> Block {
        let half_m = Vector::from(self.shape.half_extents_m()) + Vector::splat(margin_m);
        Block { pose: self.pose.isometry(self.z_m).into(), half_m }
    }

    /// The space in which the object may be, and `margin_m` around it.
    pub(super) fn inflated(&self, margin_m: f32) -> Block {
        let block = self.block(margin_m);
        Block { half_m: block.half_m + Vector::from(self.inflation_m), ..block }
    }

    fn is_usable(&self) -> bool {
        self.pose.is_finite()
            && self.z_m.is_finite()
            && self.shape.is_valid()
            && self.inflation_m.iter().all(|x| x.is_finite() && *x >= 0.0)
    }
}

impl PlanQuery {
    /// The same query in another frame, given by the pose of the world in it.
    pub fn seen_from(&self, frame_from_world: &PlanarPose) -> Self {
        let moved = |pose: &Isometry3<f32>| frame_from_world.isometry(0.0) * pose;
        Self {
            goal_world_from_hand: moved(&self.goal_world_from_hand),
            next_world_from_hand: self.next_world_from_hand.as_ref().map(moved),
            object: self.object.map(|o| ObjectEstimate { pose: frame_from_world.compose(&o.pose), ..o }),
            ..*self
        }
    }

    /// Whether all numbers are finite and in range.
    pub fn is_usable(&self) -> bool {
        let finite = |pose: &Isometry3<f32>| {
            pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.is_finite())
                && (pose.rotation.coords.norm() - 1.0).abs() < 1e-3
        };
        let angles = &self.hand_angles;
        self.start_q_rad.iter().chain(&angles.inner_rad).chain(&angles.distal_rad).all(|x| x.is_finite())
            && angles.spread_rad.is_finite()
            && (0.0..=HEIGHT_MAX_M).contains(&self.approach_height_m)
            && finite(&self.goal_world_from_hand)
            && self.next_world_from_hand.as_ref().is_none_or(finite)
            && self.object.as_ref().is_none_or(ObjectEstimate::is_usable)
    }
}
