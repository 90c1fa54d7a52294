//! One tick: look, decide, plan, act. Read this first.

use crate::control::JointControl;
use crate::executor::Executor;
use crate::mission::{Mission, Tools};
use crate::onset::{Felt, Onset};
use crate::supervisor::{Mode, Supervisor};
use heapless::Vec;
use tactus_common::limits::{HAND_MOTORS, PADS};
use tactus_common::message::{
    Event, EventKind, Outcome, Phase, PlanAnswer, PlanRequest, RolloutRequest, RolloutResult, Setup, Status,
};
use tactus_common::reading::{HandCommand, JointCommands, JointReadings, TactileImage, Validity};
use tactus_common::trajectory::Sample;

/// Ticks between two status messages: 10 Hz.
const STATUS_PERIOD_TICKS: u32 = 50;
/// Most events of one tick; more are counted as lost.
pub const EVENTS_MAX: usize = 8;

/// What came in since the last tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inputs<'a> {
    /// A mission to carry out.
    pub setup: Option<&'a Setup>,
    /// Joint readings; `None` if no sensor message came.
    pub readings: Option<JointReadings>,
    /// New images of the pads, by pad.
    pub images: [Option<TactileImage>; PADS],
    /// Which hand links touch, bit i = link i, where the world has a sensor for that; `None` if it has none.
    pub links: Option<u16>,
    /// The planner's answer.
    pub plan: Option<&'a PlanAnswer>,
    /// The mental world's answer.
    pub rollout: Option<&'a RolloutResult>,
}

/// What goes out after a tick.
#[derive(Clone, Debug)]
pub struct Outputs {
    /// Joint commands.
    pub commands: JointCommands,
    /// A question to the planner.
    pub plan_request: Option<PlanRequest>,
    /// A question to the mental world.
    pub rollout_request: Option<RolloutRequest>,
    /// Status, ten times a second.
    pub status: Option<Status>,
    /// What happened.
    pub events: Vec<Event, EVENTS_MAX>,
}

impl Outputs {
    pub(crate) fn idle(tick: u32) -> Self {
        Self {
            commands: JointCommands::idle(tick),
            plan_request: None,
            rollout_request: None,
            status: None,
            events: Vec::new(),
        }
    }

    /// Notes that something happened; one too many in a tick is dropped.
    pub fn event(&mut self, kind: EventKind) {
        let _ = self.events.push(Event { tick: self.commands.tick, kind });
    }
}

/// The controller: everything that decides, in one fixed-size value without clock, bus or heap.
#[derive(Clone, Debug, Default)]
pub struct Controller {
    supervisor: Supervisor,
    control: JointControl,
    executor: Executor,
    /// The executor has a reference to hold or to follow: the arm's angles have been measured.
    has_reference: bool,
    onset: Onset,
    mission: Mission,
    last_good: Option<JointReadings>,
    hand: HandHold,
    held: bool,
    reported: Option<Outcome>,
}

/// The hand commands of the tick before.
#[derive(Clone, Copy, Debug)]
struct HandHold([HandCommand; HAND_MOTORS]);

impl Default for HandHold {
    fn default() -> Self {
        Self([HandCommand::Idle; HAND_MOTORS])
    }
}

impl Controller {
    /// Phase of the mission.
    pub fn phase(&self) -> Phase {
        if self.supervisor.mode() == Mode::Run { self.mission.phase() } else { Phase::Fault }
    }

    /// The reference that the arm follows, once there is one.
    pub fn reference(&self) -> Option<&Sample> {
        self.has_reference.then(|| self.executor.reference())
    }

    /// The mission: what it was told and what it believes.
    pub fn mission(&self) -> &Mission {
        &self.mission
    }

    /// How the mission ended, if it did.
    pub fn outcome(&self) -> Option<Outcome> {
        match self.supervisor.fault() {
            Some(reason) => Some(Outcome::Fault(reason)),
            None => self.mission.outcome(),
        }
    }

    /// One tick of 2 ms. `now` is the tick of the readings, or the caller's count where none came.
    pub fn tick(&mut self, now: u32, inputs: &Inputs) -> Outputs {
        let mut out = Outputs::idle(now);
        // A new mission finds the controller as if it had just been started.
        if inputs.setup.is_some() {
            self.forget();
        }
        // Look.
        let readings = inputs.readings.map(admit);
        let measured = readings.filter(|r| r.valid.arm() && r.valid.hand());
        if let Some(readings) = &measured {
            self.control.observe(readings.tick, &readings.arm_q_rad);
            self.last_good = Some(*readings);
        }
        let felt = match &measured {
            Some(readings) => self.onset.feel(readings, &inputs.images),
            None => Felt::default(),
        };
        let mission_fault = inputs.setup.and_then(|setup| self.mission.begin(setup).err());
        // Decide.
        let q_ref_rad = self.reference().map(|reference| reference.q_rad);
        let mode = self.supervisor.assess(
            readings.as_ref(),
            self.control.velocity_rad_s(),
            q_ref_rad.as_ref(),
            mission_fault.or(self.mission.fault()),
        );
        // Plan and act.
        match (mode, self.last_good) {
            (Mode::Run, Some(readings)) => {
                if measured.is_some() {
                    self.run(&readings, felt, inputs, &mut out);
                }
                self.act(&readings, &mut out);
            }
            (Mode::Hold, Some(readings)) => {
                self.hold(&readings);
                self.act(&readings, &mut out);
            }
            (Mode::Limp, _) | (_, None) => {}
        }
        self.report(now, &mut out);
        out
    }

    /// Forgets everything, in place: a new value would pass over the stack.
    fn forget(&mut self) {
        self.supervisor = Supervisor::default();
        self.control = JointControl::default();
        self.has_reference = false;
        self.onset = Onset::default();
        self.mission.forget();
        self.last_good = None;
        self.hand = HandHold::default();
        self.held = false;
        self.reported = None;
    }

    /// The first reference is where the arm stands.
    fn ensure_reference(&mut self, readings: &JointReadings) {
        if !self.has_reference {
            self.has_reference = true;
            self.executor.hold(readings.arm_q_rad);
        }
    }

    /// The mission's step.
    fn run(&mut self, readings: &JointReadings, felt: Felt, inputs: &Inputs, out: &mut Outputs) {
        self.ensure_reference(readings);
        let mut tools = Tools {
            robot_base: self.mission.robot_base(),
            readings,
            felt,
            images: &inputs.images,
            links: inputs.links,
            plan: inputs.plan,
            rollout: inputs.rollout,
            executor: &mut self.executor,
            onset: &mut self.onset,
            hand: &mut self.hand.0,
            out,
        };
        self.mission.step(&mut tools);
        self.executor.tick();
    }

    /// The safe state with known angles: the arm where it is, fingers still.
    fn hold(&mut self, readings: &JointReadings) {
        self.ensure_reference(readings);
        if !self.held {
            self.held = true;
            self.executor.hold(readings.arm_q_rad);
        }
        // A finger that presses with a wanted torque goes on doing so: letting go would drop the object.
        for motor in &mut self.hand.0 {
            if !matches!(motor, HandCommand::Torque(_)) {
                *motor = HandCommand::Velocity(0.0);
            }
        }
    }

    /// Torques for the present reference.
    fn act(&mut self, readings: &JointReadings, out: &mut Outputs) {
        if self.has_reference {
            let payload_kg = self.mission.payload_kg();
            let reference = self.executor.reference();
            out.commands.arm_tau_nm = self.control.torques(&readings.arm_q_rad, reference, payload_kg);
            out.commands.hand = self.hand.0;
        }
    }

    /// Status at its period; the end of the mission once, and a fault after it once more.
    fn report(&mut self, now: u32, out: &mut Outputs) {
        if let Some(outcome) = self.outcome()
            && self.reported != Some(outcome)
        {
            self.reported = Some(outcome);
            if let Outcome::Fault(_) = outcome {
                out.event(EventKind::Phase(Phase::Fault));
            }
            out.event(EventKind::Finished(outcome));
        }
        if now.is_multiple_of(STATUS_PERIOD_TICKS) {
            out.status = Some(self.mission.status(now, self.phase()));
        }
    }
}

/// Readings with a value that is not a finite number count as not measured: beyond this point every value is finite.
fn admit(readings: JointReadings) -> JointReadings {
    if readings.is_finite() { readings } else { JointReadings { valid: Validity::NONE, ..readings } }
}

#[cfg(test)]
mod tests;
