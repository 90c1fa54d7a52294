//! Finding a way round: RRT-Connect in joint space, then shortcuts. Bounded and a pure function of its seed.

use super::Joints;
use super::scene::{Rules, Scene, between, travel_m};
use rand_core::Rng;
use rand_pcg::Pcg32;
use tactus_common::robot::ARM_LIMITS;
use tactus_common::robot::hand::HandAngles;

/// Samples drawn before the search gives up.
const SAMPLES_MAX: usize = 500;
/// Nodes of both trees together before the search gives up.
const NODES_MAX: usize = 3_000;
/// Longest new branch, in metres of [`travel_m`].
const BRANCH_M: f32 = 0.3;
/// Attempts to cut a corner.
const SHORTCUTS: usize = 60;

/// A scene with fixed hand and rules.
pub struct Space<'a> {
    /// The robot.
    pub scene: &'a Scene,
    /// How the fingers stand during the motion.
    pub angles: &'a HandAngles,
    /// What counts as a collision.
    pub rules: &'a Rules,
    /// Collisions are looked for in steps of at most this motion of any point, metres.
    pub step_m: f32,
}

/// A tree of postures: each with the index of its parent (the root is its own).
struct Tree(Vec<(Joints, usize)>);

enum Growth {
    Reached(usize),
    Advanced(usize),
    Trapped,
}

impl Space<'_> {
    /// Whether the straight motion between two postures is free.
    pub fn clear(&self, from: &Joints, to: &Joints) -> bool {
        self.scene.segment_hit(from, to, self.angles, self.rules, self.step_m).is_none()
    }

    /// A free polyline from `start` to `goal`, shortened; `None` if the bounded search finds none.
    pub fn connect(&self, start: &Joints, goal: &Joints, seed: u64) -> Option<Vec<Joints>> {
        let mut random = Pcg32::new(seed, 0x7ac7);
        let mut trees = [Tree(vec![(*start, 0)]), Tree(vec![(*goal, 0)])];
        for sample in 0..SAMPLES_MAX {
            let (near, far) = (sample % 2, 1 - sample % 2);
            let target = self.draw(start, goal, &mut random);
            let grown = match self.extend(&mut trees[near], &target) {
                Growth::Reached(i) | Growth::Advanced(i) => i,
                Growth::Trapped => continue,
            };
            let meeting = trees[near].0[grown].0;
            let mut other = self.extend(&mut trees[far], &meeting);
            while let Growth::Advanced(_) = other {
                if trees[0].0.len() + trees[1].0.len() > NODES_MAX {
                    return None;
                }
                other = self.extend(&mut trees[far], &meeting);
            }
            if let Growth::Reached(end) = other {
                let (at_start, at_goal) = if near == 0 { (grown, end) } else { (end, grown) };
                let mut path = trees[0].to_root(at_start);
                path.reverse();
                path.extend(trees[1].to_root(at_goal).into_iter().skip(1));
                return Some(self.shortened(path, &mut random));
            }
        }
        None
    }

    /// A posture: mostly from the neighbourhood of start and goal, every third from the whole range.
    fn draw(&self, start: &Joints, goal: &Joints, random: &mut Pcg32) -> Joints {
        let wide = random.next_u32().is_multiple_of(3);
        core::array::from_fn(|j| {
            let limit = &ARM_LIMITS[j];
            let (low, high) = if wide {
                (limit.lower_rad, limit.upper_rad)
            } else {
                ((start[j].min(goal[j]) - 0.5).max(limit.lower_rad), (start[j].max(goal[j]) + 0.5).min(limit.upper_rad))
            };
            low + unit(random) * (high - low)
        })
    }

    /// Grows a tree from its nearest node towards `target` by at most [`BRANCH_M`].
    fn extend(&self, tree: &mut Tree, target: &Joints) -> Growth {
        let nearest = tree.nearest(target);
        let from = tree.0[nearest].0;
        let distance = travel_m(&from, target);
        let (to, reached) =
            if distance <= BRANCH_M { (*target, true) } else { (between(&from, target, BRANCH_M / distance), false) };
        if !self.clear(&from, &to) {
            return Growth::Trapped;
        }
        tree.0.push((to, nearest));
        let last = tree.0.len() - 1;
        if reached { Growth::Reached(last) } else { Growth::Advanced(last) }
    }

    /// Replaces random stretches of the path by straight motions where those are free.
    fn shortened(&self, mut path: Vec<Joints>, random: &mut Pcg32) -> Vec<Joints> {
        for _ in 0..SHORTCUTS {
            if path.len() < 3 {
                break;
            }
            let segments = (path.len() - 1) as f32;
            let (a, b) = (unit(random) * segments, unit(random) * segments);
            let (a, b) = (a.min(b), a.max(b));
            let (i, k) = (a as usize, (b as usize).min(path.len() - 2));
            if i == k {
                continue;
            }
            let from = between(&path[i], &path[i + 1], a - i as f32);
            let to = between(&path[k], &path[k + 1], b - k as f32);
            if self.clear(&from, &to) {
                path.splice(i + 1..=k, [from, to]);
            }
        }
        // Corners that can be left out altogether: cutting leaves slivers.
        let mut i = 1;
        while i + 1 < path.len() {
            if self.clear(&path[i - 1], &path[i + 1]) {
                path.remove(i);
            } else {
                i += 1;
            }
        }
        path
    }
}

impl Tree {
    fn nearest(&self, target: &Joints) -> usize {
        let mut best = (f32::INFINITY, 0);
        for (i, (q, _)) in self.0.iter().enumerate() {
            let distance = travel_m(q, target);
            if distance < best.0 {
                best = (distance, i);
            }
        }
        best.1
    }

    fn to_root(&self, from: usize) -> Vec<Joints> {
        let mut path = vec![self.0[from].0];
        let mut i = from;
        while i != 0 {
            i = self.0[i].1;
            path.push(self.0[i].0);
        }
        path
    }
}

/// Uniform in [0, 1).
fn unit(random: &mut Pcg32) -> f32 {
    (random.next_u32() >> 8) as f32 / 16_777_216.0
}
