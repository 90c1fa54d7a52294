//! Felt touches: what the links of the hand told while it closed, as the published errors compare it (Nikandrova 2011).
//!
//! The contact matrix is taken over the progress of the closing: row i is what touches when the closing has lasted
//! `(i + 1) / 16` of the time that a finger takes from its opened angle to [`CLOSED_RAD`] if it meets nothing; what has
//! touched once counts as touching until the hand opens. A prediction is brought into the same form, whatever it comes
//! from: a finger touches from the row whose progress reaches its onset angle on, since it stops there.

use crate::error::contact::{Closing, ContactMatrix};
use crate::evidence::TOUCHES_MAX;
use crate::mission::closing::CLOSING_RAD_S;
use crate::predict::{FingerPrediction, Prediction};
use crate::touch::{CLOSED_RAD, TouchPlan};
use heapless::Vec;
use nalgebra::Isometry3;
use tactus_common::limits::{ARM_JOINTS, FINGERS, TICK_S};
use tactus_common::message::{ROLLOUT_INSTANTS, RolloutRequest, RolloutResult};
use tactus_common::pose::PlanarPose;
use tactus_common::robot::HandLink;

/// Ticks in which a rollout sweeps a whole closing, 3 s: two thirds of the real time. Faster fingers push the box before
/// they stop: in 0.6 s by up to 20 mm, in 1.2 s by up to 8 mm, and they then touch it with two links where one does.
const SWEEP_TICKS: u16 = 1_500;
/// The sweep's speed is this much higher than its length asks for: the drives take time to reach it.
const SWEEP_RESERVE: f32 = 1.1;

/// One touch as the links of the hand felt it.
#[derive(Clone, Debug, PartialEq)]
pub struct FeltTouch {
    /// What was tried.
    pub plan: TouchPlan,
    /// World-from-hand transform as measured before the closing, or after the landing.
    pub world_from_hand: Isometry3<f32>,
    /// Arm angles then, radians.
    pub arm_q_rad: [f32; ARM_JOINTS],
    /// The hand came down on something, and no finger closed: every row is what touched there.
    pub landed: bool,
    /// What was felt, in [`ROLLOUT_INSTANTS`] rows; angles as measured at the end.
    pub felt: Closing,
}

impl FeltTouch {
    /// Seconds that the slowest closing finger takes to [`CLOSED_RAD`] if it meets nothing; 0 if none closes.
    fn closing_s(plan: &TouchPlan) -> f32 {
        let ways =
            plan.preopen_rad.iter().zip(plan.closes).map(|(from, closes)| if closes { CLOSED_RAD - from } else { 0.0 });
        ways.fold(0.0, f32::max) / CLOSING_RAD_S
    }

    /// Does this finger close?
    fn closes(&self, finger: usize) -> bool {
        !self.landed && self.plan.closes.get(finger) == Some(&true)
    }

    /// Inner angle at which a finger ends that touches nothing, radians.
    fn end_rad(&self, finger: usize) -> f32 {
        if self.closes(finger) { CLOSED_RAD } else { self.opened_rad(finger) }
    }

    fn opened_rad(&self, finger: usize) -> f32 {
        self.plan.preopen_rad.get(finger).copied().unwrap_or(0.0)
    }

    /// The touch as it was carried out: after a landing no finger closes.
    pub fn carried_out(&self) -> TouchPlan {
        let closes = self.plan.closes.map(|closes| closes && !self.landed);
        TouchPlan { closes, ..self.plan }
    }

    /// The first row in which a finger touches that does so at `inner_rad`; beyond the last one: none.
    fn row(&self, finger: usize, inner_rad: f32) -> usize {
        let whole_s = Self::closing_s(&self.plan);
        if whole_s <= 0.0 {
            return 0;
        }
        let progress = (inner_rad - self.opened_rad(finger)).max(0.0) / (CLOSING_RAD_S * whole_s);
        // Half a thousandth of a row for rounding: what touches at the very end is in the last row.
        libm::ceilf(progress * ROLLOUT_INSTANTS as f32 - 5e-4).max(1.0) as usize - 1
    }

    /// What the kinematic predictor foretells, as a closing. A finger that comes down on the object touches with its tip
    /// from the start and stays where it is.
    pub fn foretold(&self, prediction: &Prediction) -> Closing {
        let mut summary = Summary::default();
        for (finger, felt) in prediction.iter().enumerate() {
            let tip = HandLink::TIPS.get(finger).map_or(0, |tip| 1 << tip.index());
            match felt {
                FingerPrediction::Landed => summary.touch(finger, 0, tip, self.opened_rad(finger)),
                FingerPrediction::Contact { inner_rad, link, .. } if *inner_rad <= CLOSED_RAD => {
                    summary.touch(finger, self.row(finger, *inner_rad), 1 << link.index(), *inner_rad);
                }
                FingerPrediction::Contact { .. } | FingerPrediction::Nothing => {
                    summary.miss(finger, self.end_rad(finger));
                }
            }
        }
        summary.closing()
    }

    /// The question what this touch would have felt like with the object at `pose`.
    pub fn question(&self, pose: &PlanarPose) -> RolloutRequest {
        let rad_s = CLOSING_RAD_S * Self::closing_s(&self.plan) / (f32::from(SWEEP_TICKS) * TICK_S) * SWEEP_RESERVE;
        let mut closing_rad_s = [0.0; FINGERS];
        for (finger, speed) in closing_rad_s.iter_mut().enumerate() {
            *speed = if self.closes(finger) { rad_s } else { 0.0 };
        }
        RolloutRequest {
            request: 0,
            pose: *pose,
            arm_q_rad: self.arm_q_rad,
            preshape: self.plan.preshape(),
            closing_rad_s,
            ticks: SWEEP_TICKS,
        }
    }

    /// What the mental world foretells in answer to [`Self::question`], as a closing. Its fingers take time to reach their
    /// speed, so that their onset angles say in which row they touch, and the rows only with which links.
    pub fn rolled_out(&self, result: &RolloutResult) -> Closing {
        let ever = result.contacts.iter().fold(0, |all, row| all | row);
        let mut summary = Summary { palm: ever & (1 << HandLink::Palm.index()), ..Summary::default() };
        for (finger, onset) in result.onset_inner_rad.iter().enumerate() {
            let links = of_finger(finger) & ever;
            match onset {
                Some(inner_rad) if *inner_rad <= CLOSED_RAD => {
                    let tip = HandLink::TIPS.get(finger).map_or(0, |tip| 1 << tip.index());
                    let links = if links == 0 { tip } else { links };
                    summary.touch(finger, self.row(finger, *inner_rad), links, *inner_rad);
                }
                Some(_) | None => summary.miss(finger, self.end_rad(finger)),
            }
        }
        summary.closing()
    }
}

/// The bits of a finger's links.
fn of_finger(finger: usize) -> u16 {
    let links = HandLink::ALL.iter().filter(|link| link.finger() == Some(finger));
    links.fold(0, |bits, link| bits | 1 << link.index())
}

/// A closing in short: each finger touches with these links from this row on.
#[derive(Clone, Copy, Debug, Default)]
struct Summary {
    palm: u16,
    from: [(usize, u16); FINGERS],
    inner_rad: [f32; FINGERS],
}

impl Summary {
    fn touch(&mut self, finger: usize, row: usize, links: u16, inner_rad: f32) {
        if let (Some(from), Some(end_rad)) = (self.from.get_mut(finger), self.inner_rad.get_mut(finger)) {
            (*from, *end_rad) = ((row, links), inner_rad);
        }
    }

    fn miss(&mut self, finger: usize, end_rad: f32) {
        self.touch(finger, 0, 0, end_rad);
    }

    fn closing(&self) -> Closing {
        let row = |i| self.from.iter().filter(|(from, _)| *from <= i).fold(self.palm, |row, (_, links)| row | links);
        Closing { contacts: ContactMatrix::new((0..ROLLOUT_INSTANTS).map(row)), inner_rad: self.inner_rad }
    }
}

/// The felt touches of a mission, the newest last, and the one under way. About 1.6 KiB.
#[derive(Clone, Debug, Default)]
pub struct FeltTouches {
    touches: Vec<FeltTouch, TOUCHES_MAX>,
    /// The closing under way.
    recording: Option<Recording>,
}

/// A closing under way.
#[derive(Clone, Debug)]
struct Recording {
    touch: FeltTouch,
    ticks: u32,
    /// Ticks of the whole closing.
    ticks_max: u32,
    /// What the sensors have told so far; `None` as long as they have told nothing.
    links: Option<u16>,
}

impl FeltTouches {
    /// The touches, oldest first.
    pub fn touches(&self) -> &[FeltTouch] {
        &self.touches
    }

    /// Forgets everything.
    pub(crate) fn forget(&mut self) {
        self.touches.clear();
        self.recording = None;
    }

    /// The hand stands below, the fingers begin to close.
    pub(crate) fn begin(&mut self, plan: &TouchPlan, world_from_hand: &Isometry3<f32>, arm_q_rad: [f32; ARM_JOINTS]) {
        let touch = FeltTouch {
            plan: *plan,
            world_from_hand: *world_from_hand,
            arm_q_rad,
            landed: false,
            felt: Closing::default(),
        };
        let ticks_max = libm::roundf(FeltTouch::closing_s(plan) / TICK_S) as u32;
        self.recording = Some(Recording { touch, ticks: 0, ticks_max, links: None });
    }

    /// One tick of the closing.
    pub(crate) fn feel(&mut self, links: Option<u16>) {
        let Some(recording) = &mut self.recording else { return };
        // A finger that touches stands still from then on, so its contact stays, even if the force sinks below what the
        // sensor notices: it was light, and worm gear and box give.
        recording.links = match (recording.links, links) {
            (Some(before), Some(now)) => Some(before | now),
            (before, now) => now.or(before),
        };
        recording.ticks += 1;
        let contacts = &mut recording.touch.felt.contacts;
        let next = contacts.rows().len() as u32 + 1;
        if recording.ticks * ROLLOUT_INSTANTS as u32 >= next * recording.ticks_max {
            contacts.push(recording.links.unwrap_or(0));
        }
    }

    /// The fingers stand: rows that have not come are as the last tick was.
    pub(crate) fn end(&mut self, inner_rad: [f32; FINGERS]) {
        let Some(Recording { mut touch, links: Some(links), .. }) = self.recording.take() else { return };
        for _ in touch.felt.contacts.rows().len()..ROLLOUT_INSTANTS {
            touch.felt.contacts.push(links);
        }
        touch.felt.inner_rad = inner_rad;
        self.keep(touch);
    }

    /// The touch under way is not kept: not all that it felt was the object.
    pub(crate) fn discard(&mut self) {
        self.recording = None;
    }

    /// The hand has come down on something: nothing closes. Nothing is kept without sensors that tell.
    pub(crate) fn landed(
        &mut self,
        plan: &TouchPlan,
        world_from_hand: &Isometry3<f32>,
        arm_q_rad: [f32; ARM_JOINTS],
        inner_rad: [f32; FINGERS],
        links: Option<u16>,
    ) {
        self.recording = None;
        let Some(links) = links else { return };
        let felt = Closing { contacts: ContactMatrix::new([links; ROLLOUT_INSTANTS]), inner_rad };
        self.keep(FeltTouch { plan: *plan, world_from_hand: *world_from_hand, arm_q_rad, landed: true, felt });
    }

    fn keep(&mut self, touch: FeltTouch) {
        if self.touches.is_full() {
            self.touches.remove(0);
        }
        let _ = self.touches.push(touch);
    }
}

#[cfg(test)]
mod tests;
