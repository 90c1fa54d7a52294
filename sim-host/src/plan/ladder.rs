//! Which posture to be in at each pose along a line: the cheapest way through a ladder of inverse-kinematic solutions.

use super::Joints;
use nalgebra::Isometry3;
use tactus_common::pose::wrap_turn;
use tactus_common::robot::ARM_LIMITS;
use tactus_common::robot::inverse::{self, Unreachable};

/// Swivel angles tried at every pose, 10 degrees apart.
pub const SWIVELS: usize = 36;
/// Angle between two swivels tried, radians.
const SWIVEL_STEP_RAD: f32 = core::f32::consts::TAU / SWIVELS as f32;
/// Largest change of a joint from one rung to the next, radians: more means that the arm changes its branch or passes a singularity.
const JOINT_STEP_MAX_RAD: f32 = 0.7;
/// Distance to joint limits that postures on a line must keep, radians.
const LIMIT_MARGIN_RAD: f32 = 0.02;
/// Distance to the wrist's and the shoulder's singularities (q6 = 0, q2 = 0) that they must keep, radians.
const SINGULAR_MARGIN_RAD: f32 = 0.04;

/// One posture that reaches a pose.
#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Swivel angle, radians in [-pi, pi).
    pub swivel_rad: f32,
    /// Joint angles, radians.
    pub q_rad: Joints,
    /// How unpleasant the posture is, in seconds of motion that one would spend to avoid it.
    pub cost_s: f32,
}

/// All postures for a pose, ordered by swivel.
#[derive(Clone, Debug)]
pub struct Rung {
    /// The postures.
    pub nodes: Vec<Node>,
    /// Whether the arm is long enough, whatever its joint limits.
    pub reached: bool,
}

impl Rung {
    /// The postures of a grid of swivel angles, those too close to a limit or a singularity left out.
    pub fn at(world_from_hand: &Isometry3<f32>) -> Self {
        let mut rung = Self { nodes: Vec::new(), reached: false };
        for k in 0..SWIVELS {
            let swivel_rad = wrap_turn(SWIVEL_STEP_RAD * k as f32);
            let solutions = match inverse::solve(world_from_hand, swivel_rad) {
                Ok(solutions) => solutions,
                Err(why) => {
                    rung.reached |= matches!(why, Unreachable::JointLimits { .. });
                    continue;
                }
            };
            rung.reached = true;
            rung.nodes.extend(
                solutions.iter().filter_map(|q| Some(Node { swivel_rad, q_rad: *q, cost_s: posture_cost_s(q)? })),
            );
        }
        rung
    }

    /// The posture that the arm is in, and no other.
    pub fn only(q_rad: &Joints, swivel_rad: f32) -> Self {
        Self { nodes: vec![Node { swivel_rad, q_rad: *q_rad, cost_s: 0.0 }], reached: true }
    }
}

/// Time that the slowest joint needs at full speed from one posture to the other, and a little for all the others.
pub fn travel_time_s(from: &Joints, to: &Joints) -> f32 {
    let (mut longest, mut sum) = (0.0_f32, 0.0_f32);
    for j in 0..7 {
        let time = (from[j] - to[j]).abs() / ARM_LIMITS[j].velocity_rad_s;
        longest = longest.max(time);
        sum += time;
    }
    longest + 0.1 * sum
}

/// Grows as 1/distance towards joint limits and singularities; `None` within the margins.
fn posture_cost_s(q_rad: &Joints) -> Option<f32> {
    let mut cost = 0.0;
    for (q, limit) in q_rad.iter().zip(&ARM_LIMITS) {
        let margin = (q - limit.lower_rad).min(limit.upper_rad - q);
        if margin < LIMIT_MARGIN_RAD {
            return None;
        }
        cost += 0.02 / margin;
    }
    for q in [q_rad[1], q_rad[5]] {
        let margin = libm::sinf(q).abs();
        if margin < SINGULAR_MARGIN_RAD {
            return None;
        }
        cost += 0.02 / margin;
    }
    Some(cost)
}

/// Cheapest continuation from every posture on every rung.
pub struct Ladder {
    rungs: Vec<Rung>,
    /// Cost to the last rung and the posture on the next one; infinite where there is no way.
    onward: Vec<Vec<(f32, usize)>>,
}

impl Ladder {
    /// Solves the ladder from its last rung to the first (dynamic programming). Swivels of neighbouring rungs differ by at most one and a half steps.
    pub fn solve(rungs: Vec<Rung>) -> Self {
        let mut onward: Vec<Vec<(f32, usize)>> =
            rungs.iter().map(|rung| vec![(f32::INFINITY, 0); rung.nodes.len()]).collect();
        for r in (0..rungs.len()).rev() {
            for i in 0..rungs[r].nodes.len() {
                let node = &rungs[r].nodes[i];
                let mut best = if r + 1 == rungs.len() { (0.0, 0) } else { (f32::INFINITY, 0) };
                if let Some(next) = rungs.get(r + 1) {
                    for (k, to) in next.nodes.iter().enumerate() {
                        let so_far = onward[r + 1][k].0;
                        if so_far < best.0
                            && let Some(step) = step_cost_s(node, to)
                            && so_far + step < best.0
                        {
                            best = (so_far + step, k);
                        }
                    }
                }
                onward[r][i] = (best.0 + node.cost_s, best.1);
            }
        }
        Self { rungs, onward }
    }

    /// Postures on the first rung from which the last can be reached, with the cost of doing so.
    pub fn starts(&self) -> impl Iterator<Item = (usize, &Node, f32)> {
        let first = self.rungs.first().map(|rung| rung.nodes.as_slice()).unwrap_or_default();
        first.iter().enumerate().map(|(i, node)| (i, node, self.onward[0][i].0)).filter(|(_, _, cost)| cost.is_finite())
    }

    /// The postures on all rungs, from posture `start` of the first.
    pub fn way(&self, start: usize) -> Vec<Node> {
        let mut way = Vec::with_capacity(self.rungs.len());
        let mut i = start;
        for (rung, onward) in self.rungs.iter().zip(&self.onward) {
            way.push(rung.nodes[i]);
            i = onward[i].1;
        }
        way
    }

    /// Whether the arm is too short (or too long) for some pose on the way.
    pub fn is_out_of_reach(&self) -> bool {
        self.rungs.iter().any(|rung| !rung.reached)
    }
}

/// Cost of going from one posture to another on the next rung; `None` if they do not belong together.
fn step_cost_s(from: &Node, to: &Node) -> Option<f32> {
    let turn = wrap_turn(to.swivel_rad - from.swivel_rad).abs();
    if turn > 1.5 * SWIVEL_STEP_RAD || from.q_rad.iter().zip(&to.q_rad).any(|(a, b)| (a - b).abs() > JOINT_STEP_MAX_RAD)
    {
        return None;
    }
    // A sign that changes means that the singularity was passed between the rungs.
    if from.q_rad[1] * to.q_rad[1] < 0.0 || from.q_rad[5] * to.q_rad[5] < 0.0 {
        return None;
    }
    // The square evens the speed out: the slowest place sets the pace of the whole line.
    let time_s = travel_time_s(&from.q_rad, &to.q_rad);
    Some(time_s + 10.0 * time_s * time_s + 0.1 * turn)
}
