//! Coming down guarded, as every touch and every grasp begins: travel to the place above with the fingers at their
//! preshape (a knock on the way stops it too), let vibration die, come down, stop at the first thing felt.

use super::{Knowledge, Tools, hand};
use crate::evidence::{ContactKind, Toucher};
use crate::executor::Motion;
use tactus_common::limits::FINGERS;
use tactus_common::message::{EventKind, FaultReason, Preshape};

/// Ticks for vibration to die before a guarded motion: 60 ms.
const SETTLE_TICKS: u32 = 30;

/// Most ticks that the hand stands above and waits for a finger to reach its preshape: 3 s, in which a free finger closes
/// and opens twice.
const PRESHAPE_TICKS_MAX: u32 = 1_500;

/// Where the descent is.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// Nothing done yet. The hand is free, whatever it has held or lost before: what it feels now is what nothing feels like.
    Begin,
    /// On the way to the place above; fingers to their preshape.
    Approach { waited: u32 },
    /// Stands above; lets vibration die.
    SettleAbove { left: u32 },
    /// Comes down.
    Descend,
    /// Felt something on the way down; comes to a stop.
    Landing { on_object: bool },
    /// Stands below; lets vibration die.
    SettleBelow { left: u32 },
}

/// How far the descent is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DescentEnd {
    /// It goes on.
    NotYet,
    /// A finger does not reach its preshape; the hand stands above.
    Stuck(FaultReason),
    /// The hand is down, nothing was felt, contact detection starts afresh.
    Down,
    /// Something was felt on the way; the hand stands.
    Landed {
        /// It is noted as evidence: no obstacle may have been what was felt.
        on_object: bool,
    },
}

/// A descent under way; its trajectory has just been loaded.
#[derive(Clone, Copy, Debug)]
pub struct Descent {
    preshape: Preshape,
    step: Step,
}

impl Descent {
    /// A descent with these finger angles.
    pub fn new(preshape: Preshape) -> Self {
        Self { preshape, step: Step::Begin }
    }

    /// One tick.
    pub(super) fn step(&mut self, know: &mut Knowledge, tools: &mut Tools) -> DescentEnd {
        self.step = match self.step {
            Step::Begin => {
                tools.onset.reset();
                hand::preshape(&self.preshape, tools);
                Step::Approach { waited: 0 }
            }
            Step::Approach { .. }
                if tools.executor.motion() == Motion::Travelling && tools.felt.knocked.contains(&true) =>
            {
                // The object is not where even the planner's margin allows for: stop, and take it as evidence.
                let on_object = note_landing(tools.felt.knocked, false, know, tools);
                tools.executor.stop();
                Step::Landing { on_object }
            }
            Step::Approach { waited } => {
                let shaped = hand::preshape(&self.preshape, tools);
                match tools.executor.motion() {
                    Motion::AtGuard if shaped => Step::SettleAbove { left: SETTLE_TICKS },
                    Motion::AtGuard if waited >= PRESHAPE_TICKS_MAX => {
                        return DescentEnd::Stuck(hand::astray(&self.preshape, tools.readings));
                    }
                    Motion::AtGuard => Step::Approach { waited: waited + 1 },
                    _ => Step::Approach { waited },
                }
            }
            Step::SettleAbove { left: 0 } => {
                tools.onset.reset();
                tools.executor.enter_guarded();
                Step::Descend
            }
            Step::SettleAbove { left } => Step::SettleAbove { left: left - 1 },
            Step::Descend if tools.felt.any() => {
                let on_object = note_landing(tools.felt.fingers, tools.felt.palm, know, tools);
                tools.executor.stop();
                Step::Landing { on_object }
            }
            Step::Descend if tools.executor.at_end() => Step::SettleBelow { left: SETTLE_TICKS },
            Step::Descend => Step::Descend,
            Step::Landing { on_object } if tools.executor.motion() == Motion::Holding => {
                return DescentEnd::Landed { on_object };
            }
            Step::Landing { on_object } => Step::Landing { on_object },
            // The baselines stay those of the free hand above: a finger that came to rest against the object must not
            // take that for nothing.
            Step::SettleBelow { left: 0 } => return DescentEnd::Down,
            Step::SettleBelow { left } => Step::SettleBelow { left: left - 1 },
        };
        DescentEnd::NotYet
    }
}

/// What felt something on the way down touches; the rest of the hand is free. `false` if an obstacle may have been among it.
fn note_landing(fingers: [bool; FINGERS], palm: bool, know: &mut Knowledge, tools: &mut Tools) -> bool {
    let mut on_object = true;
    let (world_from_hand, angles) = hand::measured(tools);
    // A full store drops the newest and counts it; the touch still counts with what it has.
    let _ = know.store.add_free(&world_from_hand, &angles, fingers.map(|f| !f));
    for f in (0..FINGERS).filter(|f| fingers[*f]) {
        on_object &= know.note_contact(&world_from_hand, &angles, Toucher::Finger(f), ContactKind::Landing);
        let inner_rad = angles.inner_rad[f];
        tools.out.event(EventKind::Contact { finger: f as u8, inner_rad, descending: true });
    }
    if palm {
        on_object &= know.note_contact(&world_from_hand, &angles, Toucher::Palm, ContactKind::Landing);
        tools.out.event(EventKind::Contact { finger: FINGERS as u8, inner_rad: 0.0, descending: true });
    }
    on_object
}
