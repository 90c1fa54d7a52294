//! What the controller may ask: the planner for a trajectory, the mental world for a touch.

use crate::mental::{Closing, MentalModel, RolloutInput};
use crate::plan::{ObjectEstimate, PlanQuery, PlanRefusal, Planner, PlannerConfig, Purpose as PlanPurpose};
use crate::world::HandStart;
use nalgebra::Isometry3;
use tactus_common::limits::{ARM_JOINTS, FINGERS};
use tactus_common::message::{
    PlanAnswer, PlanRequest, Purpose, ROLLOUT_INSTANTS, ROLLOUT_TICKS_MAX, RefusalReason, RolloutRequest, RolloutResult,
};
use tactus_common::pose::PlanarPose;
use tactus_common::robot::hand::HandAngles;
use tactus_common::robot::{FINGER_LIMIT, arm, source};
use tactus_common::shape::{ObjectShape, Obstacle};
use tactus_common::trajectory::Trajectory;
use tactus_controller::touch::TouchPlan;

/// Height above the goal from which a touch or a grasp comes straight down, metres.
const APPROACH_M: f32 = 0.10;
/// Height to which the object is lifted, metres.
const LIFT_M: f32 = 0.06;
/// Heights that are tried after that if obstacles are in the way, metres.
const HIGHER_LIFTS_M: [f32; 5] = [0.1, 0.15, 0.2, 0.27, 0.35];

/// What the controller asks.
#[derive(Clone, Copy, Debug)]
pub enum Question {
    /// For a trajectory.
    Plan(PlanRequest),
    /// What a touch would feel like.
    Rollout(RolloutRequest),
}

/// What it is answered.
#[derive(Clone, Debug)]
pub enum Reply {
    /// A trajectory, or why there is none.
    Plan(Box<PlanAnswer>),
    /// What a touch would feel like.
    Rollout(RolloutResult),
}

/// Planner and mental world, which know the robot, the object's shape and the obstacles, and nothing of the true world.
pub struct Advisor {
    planner: Planner,
    mental: MentalModel,
    shape: ObjectShape,
    /// There are obstacles, which a load may have to be lifted over.
    is_cluttered: bool,
}

impl Advisor {
    /// Ready for questions about an object of this shape among these obstacles, and a robot whose base stands at `robot_base`.
    ///
    /// # Errors
    /// The planner cannot use the robot description.
    pub fn new<'o>(
        shape: ObjectShape,
        robot_base: &PlanarPose,
        obstacles: impl IntoIterator<Item = &'o Obstacle>,
    ) -> anyhow::Result<Self> {
        let obstacles: Vec<Obstacle> = obstacles.into_iter().copied().collect();
        let robot = urdf_rs::read_from_string(source::URDF)?;
        Ok(Self {
            planner: Planner::new(&robot, PlannerConfig::default(), robot_base, &obstacles)?,
            mental: MentalModel::new()?.among(&obstacles).with_robot_at(robot_base),
            shape,
            is_cluttered: !obstacles.is_empty(),
        })
    }

    /// The answer to a question, to take effect at tick `effective`.
    pub fn answer(&mut self, question: &Question, effective: u32) -> Reply {
        match question {
            Question::Plan(request) => Reply::Plan(Box::new(self.plan(request, effective))),
            Question::Rollout(request) => Reply::Rollout(roll_out(&self.mental, &self.shape, request, effective)),
        }
    }

    /// Asks the planner.
    fn plan(&mut self, request: &PlanRequest, effective: u32) -> PlanAnswer {
        let query = query(request, &self.shape, self.planner.robot_base());
        let result = match self.planner.plan(&query) {
            Err(PlanRefusal::NoPath) if request.purpose == Purpose::Transport => {
                self.lifted(query).ok_or(PlanRefusal::NoPath)
            }
            result => result,
        };
        let result = result.map_err(reason);
        PlanAnswer { effective, request: request.request, result }
    }

    /// A transport that lifts the object higher, over obstacles; `None` if there are none, or no height is free.
    fn lifted(&self, mut query: PlanQuery) -> Option<Trajectory> {
        let heights_m: &[f32] = if self.is_cluttered { &HIGHER_LIFTS_M } else { &[] };
        for lift_m in heights_m {
            query.approach_height_m = *lift_m;
            if let Ok(trajectory) = self.planner.plan(&query) {
                return Some(trajectory);
            }
        }
        None
    }
}

/// Asks the mental world. A pose that it cannot roll out (off the table, say) is answered as one at which nothing
/// would be felt.
pub fn roll_out(mental: &MentalModel, shape: &ObjectShape, request: &RolloutRequest, effective: u32) -> RolloutResult {
    let ticks = request.ticks.min(ROLLOUT_TICKS_MAX);
    let input = RolloutInput {
        world_from_hand: mental.hand_pose(&request.arm_q_rad),
        start: HandStart { inner_rad: request.preshape.inner_rad, spread_rad: request.preshape.spread_rad },
        closing: Closing::Together,
        speed_rad_s: request.closing_rad_s,
        stop_at_rad: FINGER_LIMIT.upper_rad,
        ticks: u32::from(ticks),
        object: request.pose,
        shape: *shape,
    };
    let mut result = RolloutResult {
        effective,
        request: request.request,
        onset_inner_rad: [None; FINGERS],
        contacts: [0; ROLLOUT_INSTANTS],
    };
    if let Ok(foretold) = mental.rollout(&input) {
        result.onset_inner_rad = foretold.onset_rad;
        result.contacts = foretold.touched_by_instant(usize::from(ticks));
    }
    result
}

/// What a request asks of the planner.
fn query(request: &PlanRequest, shape: &ObjectShape, robot_base: &PlanarPose) -> PlanQuery {
    let displaced = |mut pose: Isometry3<f32>| {
        pose.translation.x += request.displacement_m[0];
        pose.translation.y += request.displacement_m[1];
        pose
    };
    let above = request.placement.world_from_hand(&request.belief, shape);
    let (goal, next) = match request.purpose {
        Purpose::Touch => (above, None),
        Purpose::Grasp => (above, Some(displaced(above))),
        Purpose::Transport | Purpose::Retreat => {
            (displaced(arm::hand_pose_from(robot_base, &request.start_q_rad)), None)
        }
    };
    let purpose = match request.purpose {
        Purpose::Touch => PlanPurpose::Touch,
        Purpose::Grasp => PlanPurpose::Grasp,
        Purpose::Transport => PlanPurpose::Transport,
        Purpose::Retreat => PlanPurpose::Retreat,
    };
    let approach_height_m = if request.purpose == Purpose::Transport { LIFT_M } else { APPROACH_M };
    PlanQuery {
        request: request.request,
        purpose,
        start_q_rad: request.start_q_rad,
        hand_angles: HandAngles::engaged(request.preshape.inner_rad, request.preshape.spread_rad),
        goal_world_from_hand: goal,
        approach_height_m,
        object: Some(object_estimate(request, shape)),
        next_world_from_hand: next,
    }
}

/// The way from `start_q_rad` (radians) to a touch of an object of `shape` that stands exactly at `believed`.
///
/// # Errors
/// Why there is none.
pub fn plan_touch(
    planner: &Planner,
    touch: &TouchPlan,
    start_q_rad: &[f32; ARM_JOINTS],
    believed: &PlanarPose,
    shape: &ObjectShape,
) -> Result<Trajectory, PlanRefusal> {
    let request = PlanRequest {
        request: 0,
        purpose: Purpose::Touch,
        touch: touch.id,
        start_q_rad: *start_q_rad,
        placement: touch.placement(),
        preshape: touch.preshape(),
        displacement_m: [0.0; 2],
        belief: *believed,
        covariance: [0.0; 6],
    };
    planner.plan(&query(&request, shape, planner.robot_base()))
}

/// The believed object, grown by its uncertainty.
fn object_estimate(request: &PlanRequest, shape: &ObjectShape) -> ObjectEstimate {
    let [xx, xy, _, yy, _, pp] = request.covariance;
    let (s, c) = libm::sincosf(request.belief.phi_rad);
    // Variances along the object's own axes.
    let along = c * c * xx + 2.0 * s * c * xy + s * s * yy;
    let across = s * s * xx - 2.0 * s * c * xy + c * c * yy;
    let sd = |v: f32| libm::sqrtf(v.max(0.0));
    ObjectEstimate::with_sigma(shape, request.belief, shape.rest_height_m(), [sd(along), sd(across)], sd(pp))
}

fn reason(refusal: PlanRefusal) -> RefusalReason {
    match refusal {
        PlanRefusal::NoInverseKinematics => RefusalReason::NoInverseKinematics,
        PlanRefusal::OutOfReach => RefusalReason::OutOfReach,
        PlanRefusal::StartInCollision => RefusalReason::StartInCollision,
        PlanRefusal::GoalInCollision => RefusalReason::GoalInCollision,
        PlanRefusal::NoPath | PlanRefusal::Unfit(_) => RefusalReason::NoPath,
        PlanRefusal::TooManyKnots => RefusalReason::TooManyKnots,
        PlanRefusal::NonFinite => RefusalReason::NonFinite,
    }
}
