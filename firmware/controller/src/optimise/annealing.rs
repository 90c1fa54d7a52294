//! Simulated annealing: random steps that may lead uphill, the less the colder it is.
//!
//! Corana, Marchesi, Martini & Ridella (1987), "Minimizing multimodal functions of continuous variables with the
//! simulated annealing algorithm", section 2: one component at a time, acceptance by Metropolis, step lengths adapted so
//! that half of the steps are accepted, and each temperature begins at the best point. What differs:
//! * Corana's schedule takes 10^5 evaluations and more; here the temperature falls to `COOLED` of the first within the
//!   budget, in `SWEEPS_MIN` steps (which makes each 0.8 of the one before; Corana's is 0.85) if the budget has sweeps
//!   of `CYCLES` cycles for so many, in fewer otherwise.
//! * The first temperature, which Corana leaves to the user, is the mean change of the error in a first sweep where every
//!   step is accepted (after White 1984).
//! * A component that a step would take out of the box is drawn evenly over it (Goffe, Ferrier & Rogers 1994).

use super::StopReason;
use super::search::{Next, Point, Sample, Search, Setup, Strategy};
use nalgebra::Vector3;
use tactus_common::random::Random;

/// Cycles over the components between two adaptations of the steps (Corana: 20).
const CYCLES: u16 = 5;
/// Temperatures, at least, if the budget allows.
const SWEEPS_MIN: u16 = 40;
/// The last temperature beside the first.
const COOLED: f32 = 1e-4;
/// How fast steps adapt (Corana's `c`).
const ADAPTATION: f32 = 2.0;
/// The longest step: half of the box.
const STEP_MAX: f32 = 1.0;
/// Temperatures in a row that bring nothing and end the search (Corana's `N_epsilon`).
const IDLE_MAX: u8 = 4;
/// Temperatures without any change of the error that end it: a quarter of the budget.
const FLAT_MAX: u8 = (SWEEPS_MIN / 4) as u8;

/// The annealing. About 170 bytes.
#[derive(Clone, Debug)]
pub struct Corana {
    free: usize,
    step_min: f32,
    random: Random,
    here: (Point, f32),
    best: (Point, f32),
    has_begun: bool,
    /// Longest step of each component, and how often one was accepted in this sweep.
    reach: Point,
    accepted: [u16; 3],
    axis: usize,
    cycle: u16,
    sweep: u16,
    sweeps_per_temperature: u16,
    /// `None` during the first sweep, which sets it.
    temperature: Option<f32>,
    cooling: f32,
    /// Sum and count of the changes in the first sweep.
    changes: (f32, u16),
    best_before: f32,
    idle: u8,
    varies: bool,
}

impl Strategy for Corana {
    fn new(setup: &Setup) -> Self {
        let moves_per_sweep = (CYCLES * setup.free.min(3) as u16).max(1);
        let sweeps = (setup.options.evaluations_max / moves_per_sweep).max(2);
        let sweeps_per_temperature = (sweeps / SWEEPS_MIN).max(1);
        let temperatures = (sweeps / sweeps_per_temperature).max(2) - 1;
        Self {
            free: setup.free,
            step_min: setup.options.step_min,
            random: Random::new(setup.options.seed),
            here: (setup.start, f32::INFINITY),
            best: (setup.start, f32::INFINITY),
            has_begun: false,
            reach: Vector3::repeat(STEP_MAX),
            accepted: [0; 3],
            axis: 0,
            cycle: 0,
            sweep: 0,
            sweeps_per_temperature,
            temperature: None,
            cooling: libm::powf(COOLED, 1.0 / f32::from(temperatures)),
            changes: (0.0, 0),
            best_before: f32::INFINITY,
            idle: 0,
            varies: false,
        }
    }

    fn next(&mut self, sample: &Sample) -> Next {
        if !self.has_begun {
            self.has_begun = true;
            self.here = (sample.point, sample.error);
            self.best = self.here;
            return Next::Try(self.propose());
        }
        self.varies |= sample.error != self.here.1;
        if self.is_accepted(sample.error) {
            self.here = (sample.point, sample.error);
            self.accepted[self.axis] += 1;
            if sample.error < self.best.1 {
                self.best = self.here;
            }
        }
        match self.advance() {
            Some(reason) => Next::Stop(reason),
            None => Next::Try(self.propose()),
        }
    }
}

impl Corana {
    /// A step of one component from here.
    fn propose(&mut self) -> Point {
        let mut point = self.here.0;
        let value = point[self.axis] + self.reach[self.axis] * self.random.symmetric();
        point[self.axis] = if (-1.0..=1.0).contains(&value) { value } else { self.random.symmetric() };
        point
    }

    fn is_accepted(&mut self, error: f32) -> bool {
        if error <= self.here.1 || !self.here.1.is_finite() {
            return true;
        }
        if !error.is_finite() {
            return false;
        }
        let rise = error - self.here.1;
        match self.temperature {
            None => {
                self.changes.0 += rise;
                self.changes.1 += 1;
                true
            }
            Some(temperature) => self.random.unit() < libm::expf(-rise / temperature.max(f32::MIN_POSITIVE)),
        }
    }

    /// Counts components, cycles, sweeps and temperatures; why to stop, if to stop.
    fn advance(&mut self) -> Option<StopReason> {
        self.axis += 1;
        if self.axis < self.free {
            return None;
        }
        self.axis = 0;
        self.cycle += 1;
        if self.cycle < CYCLES {
            return None;
        }
        self.cycle = 0;
        self.sweep += 1;
        if self.temperature.is_some() {
            self.adapt();
        }
        self.accepted = [0; 3];
        let is_first = self.temperature.is_none();
        if !is_first && self.sweep < self.sweeps_per_temperature {
            return None;
        }
        self.sweep = 0;
        self.cool()
    }

    /// Steps that are accepted too often become longer, others shorter.
    fn adapt(&mut self) {
        for axis in 0..self.free {
            let share = f32::from(self.accepted[axis]) / f32::from(CYCLES);
            let factor = if share > 0.6 {
                1.0 + ADAPTATION * (share - 0.6) / 0.4
            } else if share < 0.4 {
                1.0 / (1.0 + ADAPTATION * (0.4 - share) / 0.4)
            } else {
                1.0
            };
            self.reach[axis] = (self.reach[axis] * factor).min(STEP_MAX);
        }
    }

    fn cool(&mut self) -> Option<StopReason> {
        self.temperature = Some(match self.temperature {
            Some(temperature) => temperature * self.cooling,
            None => self.changes.0 / f32::from(self.changes.1.max(1)),
        });
        self.here = self.best;
        let gained = self.best.1 < self.best_before - 1e-6 * libm::fabsf(self.best_before);
        self.best_before = self.best.1;
        self.idle = if gained { 0 } else { self.idle.saturating_add(1) };
        if !self.varies {
            return (self.idle >= FLAT_MAX).then_some(StopReason::Flat);
        }
        if self.idle < IDLE_MAX {
            return None;
        }
        // Idle while it is warm means nothing: only short steps show that there is nothing more to gain.
        let longest = self.reach.rows(0, self.free).amax();
        (longest < self.step_min).then_some(StopReason::Converged)
    }
}

/// Simulated annealing.
pub type Annealing = Search<Corana>;
