//! Guarded closing: fingers close until each feels something or has come too far.

use super::Tools;
use tactus_common::limits::FINGERS;
use tactus_common::reading::HandCommand;

/// Closing speed, rad/s at the inner link: 0.04 m/s at the tip, so 0.3 mm in the four ticks between contact and
/// standstill.
pub const CLOSING_RAD_S: f32 = 0.35;
/// Most ticks of a closing: 12 s.
pub const TICKS_MAX: u32 = 6_000;

/// A closing under way.
#[derive(Clone, Copy, Debug)]
pub struct Closing {
    /// Which fingers close.
    closes: [bool; FINGERS],
    /// A finger that comes this far without feeling anything has missed, radians.
    end_rad: f32,
    onset_inner_rad: [Option<f32>; FINGERS],
    ticks: u32,
}

impl Closing {
    /// A closing of these fingers, up to the inner angle `end_rad`.
    pub fn new(closes: [bool; FINGERS], end_rad: f32) -> Self {
        Self { closes, end_rad, onset_inner_rad: [None; FINGERS], ticks: 0 }
    }

    /// Inner-link angle at onset per finger, radians.
    pub fn onset_inner_rad(&self) -> [Option<f32>; FINGERS] {
        self.onset_inner_rad
    }

    /// Has something been met on both sides?
    pub fn holds(&self) -> bool {
        let [f1, f2, f3] = self.onset_inner_rad;
        f3.is_some() && (f1.is_some() || f2.is_some())
    }

    /// One tick; `onset` is called for each finger that begins to feel something, also for one that does not close.
    /// `true` once every finger stands.
    pub(super) fn step(&mut self, tools: &mut Tools, mut onset: impl FnMut(usize, f32, &mut Tools)) -> bool {
        self.ticks += 1;
        let mut all_stand = true;
        for f in 0..FINGERS {
            let inner_rad = tools.readings.inner_q_rad[f];
            if tools.felt.fingers[f] && self.onset_inner_rad[f].is_none() {
                self.onset_inner_rad[f] = Some(inner_rad);
                onset(f, inner_rad, tools);
            }
            let stands = !self.closes[f] || self.onset_inner_rad[f].is_some() || inner_rad >= self.end_rad;
            tools.hand[f] = HandCommand::Velocity(if stands { 0.0 } else { CLOSING_RAD_S });
            all_stand &= stands;
        }
        all_stand || self.ticks >= TICKS_MAX
    }
}
