//! Ranks last what would meet a known obstacle, with the object where it is believed.
//!
//! The predictor closes the fingers on the object, and then on each obstacle as if it were the object: a finger that comes down
//! on the obstacle, or meets it before the object, is in its way; so is a palm that is near it.

use super::{CANDIDATES, Chooser, RankedTouches, TouchPlan};
use crate::predict::{FingerPrediction, Prediction};
use crate::sort::insertion_sort;
use crate::work::{MATRICES, Work};
use nalgebra::Isometry3;
use tactus_common::pose::PlanarPose;
use tactus_common::robot::{HandLink, hand_prism};
use tactus_common::shape::Obstacle;

/// A finger that would meet an obstacle only this long after the object does not meet it, radians.
const AFTER_RAD: f32 = 0.05;
/// Nearer than this to an obstacle the palm is in its way, metres.
const PALM_CLEARANCE_M: f32 = 0.005;

/// How far the look at obstacles is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Clearance {
    /// Rank of the touch that is looked at.
    rank: usize,
    /// What its fingers are closed on: 0 the object, then the obstacles in their order.
    against: usize,
    /// What they would feel of the object.
    object: Prediction,
    /// By candidate.
    obstructed: [bool; CANDIDATES as usize],
}

impl Clearance {
    fn next_touch(&mut self) {
        (self.rank, self.against) = (self.rank + 1, 0);
    }
}

impl Chooser {
    /// After [`Self::step`]: puts the touches that would meet an obstacle behind the others, as far as the work allows. `Some`
    /// when all are in order; then again the same. `believed`: where the object is taken to be.
    pub fn clear_of(
        &mut self,
        obstacles: &[Option<Obstacle>],
        believed: &PlanarPose,
        work: &mut Work,
    ) -> Option<&RankedTouches> {
        if obstacles.iter().all(Option::is_none) {
            return Some(&self.ranked);
        }
        while let Some(choice) = self.ranked.get(self.clearance.rank) {
            let plan = choice.plan;
            let is_obstructed = self.is_obstructed(&plan, obstacles, believed, work)?;
            if let Some(obstructed) = self.clearance.obstructed.get_mut(usize::from(plan.id)) {
                *obstructed = is_obstructed;
            }
            self.clearance.next_touch();
        }
        let obstructed = self.clearance.obstructed;
        let is_last = |id: u8| obstructed.get(usize::from(id)) == Some(&true);
        insertion_sort(&mut self.ranked, |a, b| is_last(a.plan.id).cmp(&is_last(b.plan.id)));
        Some(&self.ranked)
    }

    /// Would one touch meet an obstacle? `None` if the work did not suffice.
    fn is_obstructed(
        &mut self,
        plan: &TouchPlan,
        obstacles: &[Option<Obstacle>],
        believed: &PlanarPose,
        work: &mut Work,
    ) -> Option<bool> {
        let world_from_hand = plan.world_from_hand(believed, &self.shape);
        loop {
            let (shape, pose) = match self.clearance.against.checked_sub(1) {
                None => (&self.shape, believed),
                Some(index) => match obstacles.get(index) {
                    Some(Some(obstacle)) => (&obstacle.shape, &obstacle.pose),
                    Some(None) => {
                        self.clearance.against += 1;
                        continue;
                    }
                    None => return Some(false),
                },
            };
            if !work.is_left_for(shape) {
                return None;
            }
            if !self.predicting {
                self.predictor.begin_at(plan, &world_from_hand, pose, shape);
                self.predicting = true;
                work.spend(MATRICES);
            }
            if !self.predictor.open(shape, work) || !self.predictor.close(shape, work) {
                return None;
            }
            self.predicting = false;
            let felt = *self.predictor.felt();
            match self.clearance.against.checked_sub(1).and_then(|index| obstacles.get(index)?.as_ref()) {
                None => self.clearance.object = felt,
                Some(obstacle) => {
                    work.spend(obstacle.shape.separation_cost());
                    if is_in_the_way(&felt, &self.clearance.object) || is_near_palm(obstacle, &world_from_hand) {
                        return Some(true);
                    }
                }
            }
            self.clearance.against += 1;
        }
    }
}

/// Would a finger meet the obstacle before the object?
fn is_in_the_way(obstacle: &Prediction, object: &Prediction) -> bool {
    obstacle.iter().zip(object).any(|pair| match pair {
        (FingerPrediction::Landed, _) => true,
        (FingerPrediction::Nothing, _) => false,
        (FingerPrediction::Contact { inner_rad, .. }, FingerPrediction::Contact { inner_rad: of_object_rad, .. }) => {
            *inner_rad < of_object_rad + AFTER_RAD
        }
        (FingerPrediction::Contact { .. }, FingerPrediction::Landed | FingerPrediction::Nothing) => true,
    })
}

fn is_near_palm(obstacle: &Obstacle, world_from_palm: &Isometry3<f32>) -> bool {
    let pose = obstacle.isometry().inverse() * world_from_palm;
    obstacle.shape.separation_below(&pose, hand_prism(HandLink::Palm), PALM_CLEARANCE_M).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::{Belief, Prior};
    use crate::touch::TouchHistory;
    use tactus_common::limits::OBSTACLES_MAX;
    use tactus_common::pose::Interval;
    use tactus_common::shape::ObjectShape;

    const AT: PlanarPose = PlanarPose { x_m: 0.2, y_m: -0.1, phi_rad: 0.3 };

    fn chooser() -> Chooser {
        let interval = Interval { x_m: 0.01, y_m: 0.01, phi_rad: 0.1 };
        let prior = Prior::new(&AT, &interval, &ObjectShape::THESIS_BOX);
        let mut chooser = Chooser::new(&Belief::from_prior(&prior), &prior, &TouchHistory::default());
        chooser.step(&mut Work::unlimited()).expect("no end of work");
        chooser
    }

    /// A post beside the object, so far along its x and y.
    fn post(x_m: f32, y_m: f32) -> [Option<Obstacle>; OBSTACLES_MAX] {
        let shape = ObjectShape::Cylinder { radius_m: 0.02, half_height_m: 0.1 };
        let mut obstacles = [None; OBSTACLES_MAX];
        obstacles[2] = Some(Obstacle { shape, pose: AT.compose(&PlanarPose::new(x_m, y_m, 0.0)) });
        obstacles
    }

    #[test]
    fn touches_across_the_depth_come_last_where_a_post_stands_beside_the_box() {
        let mut chooser = chooser();
        let before = chooser.ranked().clone();
        let obstacles = post(0.0, 0.1);
        let after = chooser.clear_of(&obstacles, &AT, &mut Work::unlimited()).expect("no end of work").clone();
        let rank = |id: u8| after.iter().position(|choice| choice.plan.id == id).expect("ranked");
        // A finger comes down between the box and the post, or on it, where the hand goes across or hooks over that side; it
        // does not where it hooks over the ends or the other side.
        let last_free = (8..12).chain([13, 15]).map(rank).max().expect("hooks");
        assert!([0, 1, 12, 14].map(rank).into_iter().min() > Some(last_free), "{after:?}");
        // Within both groups the order is as it was.
        let of = |ranked: &RankedTouches, group: core::ops::Range<u8>| -> heapless::Vec<u8, 16> {
            ranked.iter().map(|choice| choice.plan.id).filter(|id| group.contains(id)).collect()
        };
        assert_eq!(of(&after, 8..12), of(&before, 8..12));
    }

    #[test]
    fn sliced_it_is_the_same_and_a_far_post_or_none_changes_nothing() {
        let whole = chooser().clear_of(&post(0.0, 0.1), &AT, &mut Work::unlimited()).expect("no end of work").clone();
        let mut sliced = chooser();
        while sliced.clear_of(&post(0.0, 0.1), &AT, &mut Work::units(1)).is_none() {}
        assert_eq!(*sliced.ranked(), whole);
        for obstacles in [post(0.6, 0.0), [None; OBSTACLES_MAX]] {
            let (mut chooser, before) = (chooser(), chooser().ranked().clone());
            assert_eq!(chooser.clear_of(&obstacles, &AT, &mut Work::unlimited()), Some(&before));
        }
    }
}
