//! The mental world: what a touch would feel like if the object stood somewhere.

use tactus_common::message::{ROLLOUT_INSTANTS, RolloutRequest, RolloutResult};
use tactus_common::shape::ObjectShape;

/// STUB until the rollout exists.
pub fn answer(request: &RolloutRequest, _shape: &ObjectShape, effective: u32) -> anyhow::Result<RolloutResult> {
    Ok(RolloutResult { effective, request: request.request, onset_inner_rad: [None; 3], contacts: [0; ROLLOUT_INSTANTS] })
}
