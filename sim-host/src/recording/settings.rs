//! The settings of a run, as the recording's attachment `settings.json` holds them.

use super::sample::Planar;
use crate::mission::MissionOptions;
use crate::report::summary::MethodUsed;
use crate::scenario::Scenario;
use serde::Serialize;

/// What a run was told to do; of the truth in it the controller knows nothing.
#[derive(Clone, Debug, Serialize)]
pub struct Settings<'a> {
    seed: u64,
    scenario: &'a Scenario,
    /// Where the object truly stands at the start.
    true_pose: Planar,
    /// Where it should stand in the end.
    goal: Planar,
    /// What the controller is told.
    guess: Planar,
    /// Half widths of what it is told about the guess's error: metres, metres, radians.
    interval: Planar,
    trials_max: u8,
    reality: &'static str,
    method: MethodUsed,
}

impl<'a> Settings<'a> {
    /// The settings of a mission.
    pub fn of(options: &'a MissionOptions) -> Self {
        let interval = options.interval;
        Self {
            seed: options.seed,
            scenario: &options.scenario,
            true_pose: options.truth.into(),
            goal: options.scenario.goal(&options.truth).into(),
            guess: options.guess.into(),
            interval: Planar { x_m: interval.x_m, y_m: interval.y_m, phi_rad: interval.phi_rad },
            trials_max: options.trials_max,
            reality: options.reality.name(),
            method: MethodUsed::of(&options.method),
        }
    }
}
