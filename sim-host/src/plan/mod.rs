//! Motion planning: from a request to a collision-free, timed trajectory, or a typed refusal.
//!
//! * [`scene`], [`body`]: what the robot may not run into.
//! * [`ladder`], [`stroke`]: straight motions of the hand, by the cheapest way through the inverse-kinematic solutions.
//! * [`search`]: a way round obstacles (RRT-Connect) where the straight motion in joint space is not free.
//! * [`curve`], [`timing`]: smooth paths, and how fast they can be followed.
//!
//! A plan is a pure function of its query: no clock, no shared random state, `libm` functions only.

pub mod approach;
pub mod body;
pub mod curve;
pub mod ladder;
pub mod query;
pub mod scene;
pub mod search;
pub mod stroke;
pub mod timing;

pub use body::ModelError;
pub use query::{ObjectEstimate, PlanQuery, PlanRefusal, PlannerConfig, Purpose};

use crate::solid::Solid;
use curve::Curve;
use ladder::{Ladder, Node, Rung};
use rapier3d::parry::math::Pose;
use scene::{Clearance, Load, Rules, Scene};
use stroke::Stroke;
use tactus_common::limits::ARM_JOINTS;
use tactus_common::pose::PlanarPose;
use tactus_common::robot::{ARM_LIMITS, MOUNT, arm, inverse};
use tactus_common::shape::Obstacle;
use tactus_common::trajectory::{Knot, Trajectory};
use timing::{Pace, knots_along};

/// Angles of the arm's joints, radians.
pub type Joints = [f32; ARM_JOINTS];

/// How many times as far as usual the quintics between knots may stray, one after the other until a trajectory holds the knots.
const LAXITIES: [f64; 3] = [1.0, 2.0, 4.0];

/// Plans motions of one robot.
pub struct Planner {
    scene: Scene,
    config: PlannerConfig,
    robot_base: PlanarPose,
    /// From the world to the frame in which the base stands at [`MOUNT`], where all planning is done; `None` if they are one.
    mount_from_world: Option<PlanarPose>,
}

/// One rest-to-rest part of a motion.
struct Part {
    curve: Curve,
    pace: Pace,
}

impl Planner {
    /// A planner for the robot that `robot` describes, its base at `robot_base`, with these obstacles on the table.
    ///
    /// # Errors
    /// [`ModelError`] if links are missing or have shapes that cannot be used.
    pub fn new<'o>(
        robot: &urdf_rs::Robot,
        config: PlannerConfig,
        robot_base: &PlanarPose,
        obstacles: impl IntoIterator<Item = &'o Obstacle>,
    ) -> Result<Self, ModelError> {
        // The table is level and taken for endless: a turn and a shift of everything on it change nothing.
        let mount_from_world = (*robot_base != MOUNT).then(|| MOUNT.compose(&robot_base.inverse()));
        let seen = |obstacle: &Obstacle| match &mount_from_world {
            Some(frame) => Obstacle { pose: frame.compose(&obstacle.pose), ..*obstacle },
            None => *obstacle,
        };
        let obstacles: Vec<Obstacle> = obstacles.into_iter().map(seen).collect();
        Ok(Self { scene: Scene::new(robot, &obstacles)?, config, robot_base: *robot_base, mount_from_world })
    }

    /// Where the robot's base stands in the world.
    pub fn robot_base(&self) -> &PlanarPose {
        &self.robot_base
    }

    /// The collision scene, in the frame in which the base stands at [`MOUNT`].
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// A trajectory that does what `query` asks for, from rest to rest and within the limits of [`Trajectory::check`].
    ///
    /// # Errors
    /// [`PlanRefusal`]: why there is none. The planner keeps no state, so the same query always has the same answer.
    pub fn plan(&self, query: &PlanQuery) -> Result<Trajectory, PlanRefusal> {
        if !query.is_usable() {
            return Err(PlanRefusal::NonFinite);
        }
        let query = &match &self.mount_from_world {
            Some(frame) => query.seen_from(frame),
            None => *query,
        };
        let angles = &query.hand_angles;
        if self.scene.hit(&query.start_q_rad, angles, &self.start_rules(query)).is_some() {
            return Err(PlanRefusal::StartInCollision);
        }
        let (parts, guarded) = match query.purpose {
            Purpose::Touch | Purpose::Grasp => (self.approach(query)?, true),
            Purpose::Home => (self.approach(query)?, false),
            Purpose::Retreat => (self.retreat(query)?, false),
            Purpose::Transport => (self.transport(query)?, true),
        };
        timed(query, &parts, guarded)
    }

    /// Straight up by the approach height.
    fn retreat(&self, query: &PlanQuery) -> Result<Vec<Part>, PlanRefusal> {
        let from = arm::hand_pose(&query.start_q_rad);
        let stroke = Stroke { from, to: raised(&from, query.approach_height_m) };
        let pace = self.line_pace(self.config.retreat_speed_m_s, self.config.acceleration_scale);
        self.strokes(query, &[(stroke, pace, self.start_rules(query))])
    }

    /// Up, over, down, the hand's orientation turning evenly from the start's to the goal's.
    fn transport(&self, query: &PlanQuery) -> Result<Vec<Part>, PlanRefusal> {
        let [up, over, down] =
            carry_strokes(&arm::hand_pose(&query.start_q_rad), &query.goal_world_from_hand, query.approach_height_m);
        let lifting = Rules { object: None, ..self.start_rules(query) };
        let carried = query.object.and_then(|object| {
            let Solid { in_body, shape, .. } = Solid::new(&object.shape)?;
            let hand_from_world = Pose::from(arm::hand_pose(&query.start_q_rad)).inverse();
            let pose = hand_from_world * Pose::from(object.pose.isometry(object.z_m)) * in_body;
            Some(Load::new(pose, shape))
        });
        let lowered = carried.clone().map(Load::at_the_table);
        let lowering = Rules { object: None, carried: lowered, ..self.line_rules(query) };
        // Half the lift is left as room for a load that hangs askew.
        let margin = self.config.table_margin_m.min(0.5 * query.approach_height_m);
        let aloft = Rules { table_margin_m: margin, object: None, carried, ..self.travel_rules(query) };
        let gentle = self.config.carry_acceleration_scale;
        self.strokes(
            query,
            &[
                (up, self.line_pace(self.config.retreat_speed_m_s, gentle), lifting),
                (over, self.line_pace(self.config.carry_speed_m_s, gentle), aloft),
                (down, self.line_pace(self.config.guarded_speed_m_s, gentle), lowering),
            ],
        )
    }

    /// Consecutive strokes from the query's start posture, each at its own pace and under its own rules.
    fn strokes(&self, query: &PlanQuery, strokes: &[(Stroke, Pace, Rules)]) -> Result<Vec<Part>, PlanRefusal> {
        let start = &query.start_q_rad;
        let mut rungs = vec![Rung::only(start, inverse::swivel(start))];
        rungs.extend(
            strokes
                .iter()
                .flat_map(|(stroke, _, _)| stroke.rung_poses().map(|pose| Rung::at(&pose)).collect::<Vec<_>>()),
        );
        let ladder = Ladder::solve(rungs);
        if ladder.is_out_of_reach() {
            return Err(PlanRefusal::OutOfReach);
        }
        let (first, _, _) = ladder.starts().next().ok_or(PlanRefusal::NoInverseKinematics)?;
        let way = ladder.way(first);
        let mut parts = Vec::new();
        let mut done = 0;
        for (stroke, pace, rules) in strokes {
            let nodes = &way[done..=done + stroke.rungs()];
            done += stroke.rungs();
            if stroke.length_m() < 1e-4 {
                continue;
            }
            let curve = self.stroke_curve(query, stroke, nodes, rules).ok_or(PlanRefusal::NoPath)?;
            parts.push(Part { curve, pace: *pace });
        }
        Ok(parts)
    }

    /// The curve along a stroke, if the arm can follow it and keeps the rules.
    fn stroke_curve(&self, query: &PlanQuery, stroke: &Stroke, nodes: &[Node], rules: &Rules) -> Option<Curve> {
        let postures = stroke.postures(nodes)?;
        let free = postures.iter().all(|q| self.scene.hit(q, &query.hand_angles, rules).is_none());
        free.then(|| stroke.curve(&postures)).flatten()
    }

    /// What the robot may not touch where it starts, and near where a contact is wanted: itself, the table, and with arm and palm the object as believed.
    fn start_rules(&self, query: &PlanQuery) -> Rules {
        let palm_matters = !matches!(query.purpose, Purpose::Transport | Purpose::Retreat);
        Rules {
            table_margin_m: self.config.contact_table_margin_m,
            self_margin_m: 0.2 * self.config.self_margin_m,
            object: query.object.filter(|_| palm_matters).map(|object| object.block(0.0)),
            fingers_may_touch: true,
            carried: None,
            obstacles: Clearance { margin_m: self.config.contact_obstacle_margin_m, of_fingers: false },
        }
    }

    /// What the robot keeps away from on a guarded line down: as at the start, and with the fingers from obstacles.
    fn line_rules(&self, query: &PlanQuery) -> Rules {
        let start = self.start_rules(query);
        Rules { obstacles: Clearance { of_fingers: true, ..start.obstacles }, ..start }
    }

    /// What the robot keeps away from on its way.
    fn travel_rules(&self, query: &PlanQuery) -> Rules {
        Rules {
            table_margin_m: self.config.table_margin_m,
            self_margin_m: self.config.self_margin_m,
            object: query.object.map(|object| object.inflated(self.config.object_margin_m)),
            fingers_may_touch: false,
            carried: None,
            obstacles: Clearance { margin_m: self.config.obstacle_margin_m, of_fingers: true },
        }
    }

    /// Along a Cartesian line: the curve's parameter is metres.
    fn line_pace(&self, speed_max_m_s: f32, acceleration_scale: f32) -> Pace {
        Pace {
            speed_max: f64::from(speed_max_m_s),
            velocity_scale: f64::from(self.config.velocity_scale),
            acceleration_scale: f64::from(acceleration_scale),
            tolerance_rad: 2e-4,
        }
    }
}

/// The pose `height_m` straight above.
fn raised(pose: &nalgebra::Isometry3<f32>, height_m: f32) -> nalgebra::Isometry3<f32> {
    let mut raised = *pose;
    raised.translation.vector.z += height_m;
    raised
}

/// Up, over and down from one hand pose to another, `height_m` above the higher of both.
fn carry_strokes(from: &nalgebra::Isometry3<f32>, to: &nalgebra::Isometry3<f32>, height_m: f32) -> [Stroke; 3] {
    let top_m = from.translation.z.max(to.translation.z) + height_m;
    let (above_from, above_to) = (raised(from, top_m - from.translation.z), raised(to, top_m - to.translation.z));
    [
        Stroke { from: *from, to: above_from },
        Stroke { from: above_from, to: above_to },
        Stroke { from: above_to, to: *to },
    ]
}

/// The parts as a trajectory, followed as closely as its knots allow.
fn timed(query: &PlanQuery, parts: &[Part], guarded: bool) -> Result<Trajectory, PlanRefusal> {
    let looser = |laxity: &f64| match assemble(query, parts, guarded, *laxity) {
        Err(PlanRefusal::TooManyKnots) => None,
        result => Some(result),
    };
    LAXITIES.iter().find_map(looser).unwrap_or(Err(PlanRefusal::TooManyKnots))
}

/// Times all parts one after the other, the last one guarded if `guarded`; the quintics may stray `laxity` times as far as the
/// parts say.
fn assemble(query: &PlanQuery, parts: &[Part], guarded: bool, laxity: f64) -> Result<Trajectory, PlanRefusal> {
    let mut trajectory = Trajectory { request: query.request, knots: Default::default(), guarded_from: u8::MAX };
    for (i, part) in parts.iter().enumerate() {
        let start_s = trajectory.duration();
        if guarded && i + 1 == parts.len() {
            trajectory.guarded_from = trajectory.knots.len().saturating_sub(1) as u8;
        }
        let skip = usize::from(i > 0);
        let pace = Pace { tolerance_rad: laxity * part.pace.tolerance_rad, ..part.pace };
        for knot in knots_along(&part.curve, &pace).ok_or(PlanRefusal::TooManyKnots)?.into_iter().skip(skip) {
            let knot = Knot { t_s: start_s + knot.t_s, ..knot };
            trajectory.knots.push(knot).map_err(|_| PlanRefusal::TooManyKnots)?;
        }
    }
    let start = Knot { q_rad: query.start_q_rad, ..Knot::default() };
    match trajectory.knots.first_mut() {
        // The curve gives it back within a rounding; the executor compares with what it commanded last.
        Some(first) => first.q_rad = start.q_rad,
        // Already there.
        None => trajectory.knots.push(start).map_err(|_| PlanRefusal::TooManyKnots)?,
    }
    trajectory.check(&ARM_LIMITS).map_err(PlanRefusal::Unfit)?;
    Ok(trajectory)
}

#[cfg(test)]
mod tests;
