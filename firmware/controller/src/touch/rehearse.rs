//! For tests: a touch without noise, from the predictor straight into the evidence.

use super::TouchPlan;
use crate::error::contact::Closing;
use crate::evidence::{ContactKind, EvidenceStore, Toucher};
use crate::felt_touch::FeltTouch;
use crate::predict::{CLOSE_END_RAD, FingerPrediction, predict};
use tactus_common::pose::PlanarPose;
use tactus_common::robot::hand::HandAngles;
use tactus_common::shape::ObjectShape;

/// The touch `plan`, aimed at `believed`, as the links feel it on an object that stands at `truth`.
pub(crate) fn rehearse_felt(
    plan: &TouchPlan,
    believed: &PlanarPose,
    truth: &PlanarPose,
    shape: &ObjectShape,
) -> FeltTouch {
    let world_from_hand = plan.world_from_hand(believed, shape);
    let mut touch =
        FeltTouch { plan: *plan, world_from_hand, arm_q_rad: [0.0; 7], landed: false, felt: Closing::default() };
    touch.felt = touch.foretold(&predict(plan, believed, truth, shape));
    touch
}

/// Makes the touch `plan`, aimed at `believed`, on an object that stands at `truth`.
pub(crate) fn rehearse(
    store: &mut EvidenceStore,
    plan: &TouchPlan,
    believed: &PlanarPose,
    truth: &PlanarPose,
    shape: &ObjectShape,
) {
    store.begin_touch();
    let hand = plan.world_from_hand(believed, shape);
    let open = HandAngles::engaged(plan.preopen_rad, plan.spread_rad);
    store.add_free(&hand, &open, [true; 3]).expect("room");
    for (finger, felt) in predict(plan, believed, truth, shape).iter().enumerate() {
        match felt {
            FingerPrediction::Contact { inner_rad, .. } => {
                let mut inner = plan.preopen_rad;
                inner[finger] = *inner_rad;
                let angles = HandAngles::engaged(inner, plan.spread_rad);
                store.add_contact(&hand, &angles, Toucher::Finger(finger), ContactKind::Closing).expect("room");
            }
            FingerPrediction::Nothing if plan.closes[finger] => {
                store.add_free_sweep(&hand, &open, finger, CLOSE_END_RAD).expect("room");
            }
            FingerPrediction::Nothing => {}
            FingerPrediction::Landed => panic!("rehearse touches that go well"),
        }
    }
}
