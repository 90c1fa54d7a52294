//! Travel to above a goal, then straight down to it.

use super::curve::Curve;
use super::ladder::{Ladder, Node, Rung, travel_time_s};
use super::scene::travel_m;
use super::search::Space;
use super::stroke::Stroke;
use super::timing::Pace;
use super::{Joints, Part, PlanQuery, PlanRefusal, Planner, Purpose, carry_strokes, raised};
use tactus_common::robot::ARM_LIMITS;

/// Motion of any point of the robot between two looks for collisions, metres. A point between them is at most half of it from one looked at,
/// which the margins cover.
const LOOK_M: f32 = 0.02;
/// Postures above the goal that are looked at.
const CANDIDATES_MAX: usize = 60;
/// Postures from which a way round is searched for.
const SEARCHES_MAX: usize = 3;
/// Time by which a free straight motion may be longer before a search for a better one is worth it, seconds.
const PATIENCE_S: f32 = 1.0;

/// A posture above the goal from which the line down to it is free.
struct Candidate {
    line: Option<Part>,
    q_rad: Joints,
    cost_s: f32,
}

impl Planner {
    /// Touch, grasp and home: an escape upwards if the start needs one, travel, the line down.
    pub(super) fn approach(&self, query: &PlanQuery) -> Result<Vec<Part>, PlanRefusal> {
        let mut parts = self.escape(query)?;
        let start = parts.last().map_or(query.start_q_rad, |part| end_of(&part.curve));
        let (ladder, rungs) = ladder_to(query)?;
        let travel_rules = self.travel_rules(query);
        let space = Space { scene: &self.scene, angles: &query.hand_angles, rules: &travel_rules, step_m: LOOK_M };

        let mut starts: Vec<(usize, Joints, f32)> =
            ladder.starts().map(|(i, node, cost)| (i, node.q_rad, cost + travel_time_s(&start, &node.q_rad))).collect();
        starts.sort_by(|a, b| a.2.total_cmp(&b.2));
        let mut blocked: Vec<Candidate> = Vec::new();
        let mut found: Option<(Vec<Joints>, Candidate)> = None;
        for (i, q_rad, cost_s) in starts.into_iter().take(CANDIDATES_MAX) {
            if blocked.first().is_some_and(|best| cost_s > best.cost_s + PATIENCE_S) {
                break;
            }
            let way = ladder.way(i);
            let Some(line) = self.line_down(query, &way[..=rungs]) else { continue };
            let candidate = Candidate { line, q_rad, cost_s };
            if space.clear(&start, &q_rad) {
                found = Some((vec![start, q_rad], candidate));
                break;
            }
            blocked.push(candidate);
        }
        if found.is_none() {
            if blocked.is_empty() {
                return Err(PlanRefusal::GoalInCollision);
            }
            found = blocked.into_iter().take(SEARCHES_MAX).find_map(|candidate| {
                let path = space.connect(&start, &candidate.q_rad, seed(query))?;
                Some((path, candidate))
            });
        }
        let (path, candidate) = found.ok_or(PlanRefusal::NoPath)?;
        parts.extend(self.travel(&space, &path));
        parts.extend(candidate.line);
        Ok(parts)
    }

    /// Straight up until travel can start, if the start is too near to the table or within the object's uncertainty.
    fn escape(&self, query: &PlanQuery) -> Result<Vec<Part>, PlanRefusal> {
        let travel_rules = self.travel_rules(query);
        let free = |q: &Joints| self.scene.hit(q, &query.hand_angles, &travel_rules).is_none();
        if free(&query.start_q_rad) {
            return Ok(Vec::new());
        }
        for height_m in [0.04, 0.08, 0.12, 0.16, 0.20, 0.25, 0.30] {
            let lift = PlanQuery { purpose: Purpose::Retreat, approach_height_m: height_m, ..*query };
            if let Ok(parts) = self.retreat(&lift)
                && parts.last().is_some_and(|part| free(&end_of(&part.curve)))
            {
                return Ok(parts);
            }
        }
        Err(PlanRefusal::StartInCollision)
    }

    /// The guarded line along the postures of `way`; the inner `None` without an approach. `None` if it is not free or the travel cannot end at its top.
    fn line_down(&self, query: &PlanQuery, way: &[Node]) -> Option<Option<Part>> {
        let first = way.first()?;
        if self.scene.hit(&first.q_rad, &query.hand_angles, &self.travel_rules(query)).is_some() {
            return None;
        }
        let Some(stroke) = line_of(query) else { return Some(None) };
        let curve = self.stroke_curve(query, &stroke, way, &self.line_rules(query))?;
        let pace = self.line_pace(self.config.guarded_speed_m_s, self.config.acceleration_scale);
        Some(Some(Part { curve, pace }))
    }

    /// Along a free polyline without stopping where its rounded form is free too, else from corner to corner.
    fn travel(&self, space: &Space<'_>, path: &[Joints]) -> Vec<Part> {
        let pace = Pace {
            speed_max: 100.0, // the joints' own limits decide
            velocity_scale: f64::from(self.config.velocity_scale),
            acceleration_scale: f64::from(self.config.acceleration_scale),
            tolerance_rad: 2e-3,
        };
        if path.len() > 2 {
            for pieces in [6, 9, 13, 18, 24, 32] {
                let curve = Curve::rounding(path, pieces, full_speed_s);
                if let Some(curve) = curve.filter(|curve| is_free(space, curve)) {
                    return vec![Part { curve, pace }];
                }
            }
        }
        path.iter()
            .zip(path.iter().skip(1))
            .filter_map(|(a, b)| Curve::rounding(&[*a, *b], 2, full_speed_s))
            .map(|curve| Part { curve, pace })
            .collect()
    }
}

/// The line down to the goal; `None` if the query has none.
fn line_of(query: &PlanQuery) -> Option<Stroke> {
    let has_line = query.purpose != Purpose::Home && query.approach_height_m >= 1e-3;
    has_line.then(|| Stroke {
        from: raised(&query.goal_world_from_hand, query.approach_height_m),
        to: query.goal_world_from_hand,
    })
}

/// The ladder down to the goal and, if a transport is to follow and can, on along it; and the number of rungs down to the goal.
fn ladder_to(query: &PlanQuery) -> Result<(Ladder, usize), PlanRefusal> {
    let goal = &query.goal_world_from_hand;
    let line = line_of(query);
    let mut rungs = vec![Rung::at(&line.map_or(*goal, |stroke| stroke.from))];
    rungs.extend(line.iter().flat_map(Stroke::rung_poses).map(|pose| Rung::at(&pose)));
    let down = rungs.len() - 1;
    if let Some(next) = &query.next_world_from_hand {
        let mut all = rungs.clone();
        for stroke in carry_strokes(goal, next, query.approach_height_m) {
            all.extend(stroke.rung_poses().map(|pose| Rung::at(&pose)));
        }
        let ladder = Ladder::solve(all);
        if ladder.starts().next().is_some() {
            return Ok((ladder, down));
        }
    }
    let ladder = Ladder::solve(rungs);
    if ladder.is_out_of_reach() {
        return Err(PlanRefusal::OutOfReach);
    }
    if ladder.starts().next().is_none() {
        return Err(PlanRefusal::NoInverseKinematics);
    }
    Ok((ladder, down))
}

/// Seconds that the slowest joint needs at full speed.
fn full_speed_s(from: &Joints, to: &Joints) -> f64 {
    (0..7).map(|j| f64::from((from[j] - to[j]).abs() / ARM_LIMITS[j].velocity_rad_s)).fold(0.0, f64::max)
}

/// Last posture of a curve.
fn end_of(curve: &Curve) -> Joints {
    curve.at(curve.length()).q.map(|x| x as f32)
}

/// Whether a curve keeps the rules of the space and the joint limits.
fn is_free(space: &Space<'_>, curve: &Curve) -> bool {
    let posture = |k: usize, n: usize| curve.at(curve.length() * k as f64 / n as f64).q.map(|x| x as f32);
    let rough: f32 = (0..64).map(|k| travel_m(&posture(k, 64), &posture(k + 1, 64))).sum();
    let steps = (rough / LOOK_M) as usize + 1;
    (0..=steps).all(|k| space.scene.hit(&posture(k, steps), space.angles, space.rules).is_none())
}

/// A number that depends on where the motion starts and ends, and on nothing else.
fn seed(query: &PlanQuery) -> u64 {
    let goal = query.goal_world_from_hand;
    let numbers = query.start_q_rad.iter().chain(goal.translation.vector.iter()).chain(goal.rotation.coords.iter());
    // FNV-1a over the bits.
    numbers.fold(0xcbf2_9ce4_8422_2325, |hash, x| (hash ^ u64::from(x.to_bits())).wrapping_mul(0x0100_0000_01b3))
}
