//! The mission: which phase follows which.
//!
//! `Initialise -> Plan -> Trial -> Update -> (Plan ...) -> Grasp -> Transport -> Release -> Done`. Each phase steps in
//! place and says how far it is; [`Mission::step`] is the one function that moves between them. A fault is the
//! supervisor's matter.

mod asking;
mod carry;
pub(crate) mod closing;
mod descent;
mod enquiry;
mod foresight;
mod grasp;
mod grip;
mod hand;
mod knowledge;
mod obstructed;
mod recover;
mod tools;
mod trial;
mod withdraw;

pub use tools::Tools;

use crate::belief::{Belief, Prior, Readiness, Tolerance};
use crate::evidence::EvidenceStore;
use crate::felt_touch::FeltTouch;
use crate::slip::Slip;
use crate::touch::Chooser;
use crate::update::{Evidence, Progress, Update};
use crate::work::Work;
use carry::{Carry, CarryEnd};
use enquiry::{Enquiry, HostSlow};
use foresight::LastTouch;
use grasp::{Grasp, GraspEnd, GraspPlan};
use grip::Grip;
use knowledge::Knowledge;
use recover::{Recover, RecoverEnd};
use tactus_common::message::{
    EventKind, FailureReason, FaultReason, Outcome, Phase, Purpose, RefusalReason, Setup, Status,
};
use tactus_common::pose::PlanarPose;
use trial::{Trial, TrialEnd};

/// The belief that is good enough for a grasp when no touch is left.
const LAST_RESORT: Tolerance = Tolerance { position_m: 0.015, yaw_rad: 0.12, reduced_chi_squared: f32::INFINITY };
/// The touch of the published method: across the depth, centred; and the same with the hand turned half round, for where
/// the planner refuses it.
const PUBLISHED_TOUCHES: [u8; 2] = [0, 1];
/// Times that the object may be lost and searched for anew.
const LOSSES_MAX: u8 = 1;
/// Grasps that may fail before the mission gives up.
const GRASPS_MAX: u8 = 3;

/// What the mission is doing, with what it needs for it; what is large has a place of its own in [`Mission`], so that
/// nothing large is ever moved.
#[derive(Clone, Debug, Default)]
enum Doing {
    /// Nothing to do yet.
    #[default]
    Nothing,
    /// Ranks the touches.
    Choosing,
    /// Waits for the way to the touch of this rank.
    AskingTouch {
        rank: u8,
    },
    Touching(Trial),
    /// Fits the pose; `asked`: waits for a rollout of the mental world.
    Updating {
        asked: bool,
    },
    /// Waits for what the mental world foretells.
    Confirming,
    /// Waits for the way to the grasp of this rank.
    AskingGrasp {
        variant: u8,
        plan: GraspPlan,
    },
    Grasping(Grasp),
    AskingTransport,
    Carrying(Carry),
    /// The object was lost: stops and opens.
    Recovering(Recover),
    /// Waits for the way up, then goes it.
    AskingRetreat,
    Retreating,
    Over,
}

/// The mission's state machine.
#[derive(Clone, Debug, Default)]
pub struct Mission {
    /// A set-up has come, and `knowledge` means something.
    begun: bool,
    knowledge: Knowledge,
    chooser: Chooser,
    update: Update,
    enquiry: Enquiry,
    doing: Doing,
    phase: PhaseMark,
    last: LastTouch,
    touches: u8,
    grasps: u8,
    losses: u8,
    yaw_in_hand_rad: f32,
    inconsistent: u8,
    payload_kg: f32,
    /// Watches what is carried.
    slip: Slip,
    /// What it takes to carry the object, as far as is known.
    grip: Grip,
    outcome: Option<Outcome>,
    fault: Option<FaultReason>,
}

/// The phase last announced.
#[derive(Clone, Copy, Debug)]
struct PhaseMark(Phase);

impl Default for PhaseMark {
    fn default() -> Self {
        Self(Phase::Initialise)
    }
}

impl Mission {
    /// Takes a set-up and forgets any mission before it.
    ///
    /// # Errors
    /// [`FaultReason::SchemaMismatch`], or [`FaultReason::BadSetup`] for values that make no sense.
    pub fn begin(&mut self, setup: &Setup) -> Result<(), FaultReason> {
        self.forget();
        self.knowledge.begin(setup)?;
        self.begun = true;
        Ok(())
    }

    /// Whether a set-up makes sense, before a mission is begun with it.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn check(setup: &Setup) -> Result<(), FaultReason> {
        knowledge::check(setup)
    }

    /// As if no set-up had ever come. Field by field: the whole would be a copy of many kilobytes on the stack. What
    /// chooser and update hold is set anew whenever they begin.
    pub fn forget(&mut self) {
        self.begun = false;
        self.enquiry = Enquiry::default();
        self.doing = Doing::Nothing;
        self.phase = PhaseMark::default();
        self.last = LastTouch::default();
        (self.touches, self.grasps, self.losses, self.inconsistent) = (0, 0, 0, 0);
        (self.yaw_in_hand_rad, self.payload_kg) = (0.0, 0.0);
        self.grip = Grip::default();
        (self.outcome, self.fault) = (None, None);
    }

    /// The phase.
    pub fn phase(&self) -> Phase {
        self.phase.0
    }

    /// How the mission ended, if it did.
    pub fn outcome(&self) -> Option<Outcome> {
        self.outcome
    }

    /// A fault that the mission found.
    pub fn fault(&self) -> Option<FaultReason> {
        self.fault
    }

    /// Mass that the arm carries besides the hand, kilograms.
    pub fn payload_kg(&self) -> f32 {
        self.payload_kg
    }

    /// Where the robot's base stands.
    pub fn robot_base(&self) -> PlanarPose {
        self.knowledge.setup.robot_base
    }

    /// The believed pose.
    pub fn believed(&self) -> Option<PlanarPose> {
        self.begun.then(|| self.knowledge.belief.pose())
    }

    /// What is believed of the object's place; `None` before a mission.
    pub fn belief(&self) -> Option<&Belief> {
        self.begun.then_some(&self.knowledge.belief)
    }

    /// What was touched and what is known to be free.
    pub fn evidence(&self) -> &EvidenceStore {
        &self.knowledge.store
    }

    /// What was felt, for the published errors; the newest last. Nothing without ideal sensors.
    pub fn felt_touches(&self) -> &[FeltTouch] {
        self.knowledge.felt.touches()
    }

    /// What was known before the first touch.
    pub fn prior(&self) -> &Prior {
        &self.knowledge.prior
    }

    /// A status message.
    pub fn status(&self, tick: u32, phase: Phase) -> Status {
        let know = &self.knowledge;
        let (belief, covariance, evidence) = if self.begun {
            (know.belief.pose(), know.covariance(), know.store.contacts().len() as u8)
        } else {
            (PlanarPose::default(), [0.0; 6], 0)
        };
        Status { tick, phase, belief, covariance, evidence, touches: self.touches }
    }

    /// One tick of the mission.
    pub fn step(&mut self, tools: &mut Tools) {
        if !self.begun {
            return;
        }
        if let Some(next) = self.advance(tools) {
            self.doing = next;
        }
        self.announce(tools);
    }

    /// The transition function: what follows, or `None` if it goes on.
    fn advance(&mut self, tools: &mut Tools) -> Option<Doing> {
        let know = &mut self.knowledge;
        match &mut self.doing {
            Doing::Nothing => Some(self.choose()),
            Doing::Choosing => {
                let work = &mut Work::PER_TICK.clone();
                self.chooser.step(work)?;
                self.chooser.clear_of(&know.setup.obstacles, &know.belief.pose(), work)?;
                Some(self.ask_touch(0, RefusalReason::NoPath, tools))
            }
            Doing::AskingTouch { rank } => {
                let rank = *rank;
                Some(match self.plan(tools)? {
                    Ok(()) => self.begin_touch(rank, tools),
                    Err(reason) => self.ask_touch(rank + 1, reason, tools),
                })
            }
            Doing::Touching(trial) => match trial.step(know, tools) {
                TrialEnd::NotYet => None,
                TrialEnd::Stuck(reason) => self.stop(reason),
                TrialEnd::Over { arm_q_rad, onset_inner_rad } => {
                    self.last = LastTouch { arm_q_rad, plan: Some(*trial.plan()), onset_inner_rad };
                    Some(self.begin_update())
                }
            },
            Doing::Updating { asked } => {
                let touches = know.felt.touches();
                if *asked {
                    match self.enquiry.rollout(tools) {
                        Ok(Some(foretold)) => self.update.answer(touches, &foretold),
                        Ok(None) => return None,
                        Err(HostSlow) => return self.stop(FaultReason::HostSlow),
                    }
                }
                *asked = false;
                match self.update.step(&mut Work::PER_TICK.clone(), Evidence { store: &know.store, touches }) {
                    Progress::Running => {
                        if let Some(request) = self.update.question(touches) {
                            self.enquiry.ask_mental_world(request, tools.out);
                            *asked = true;
                        }
                        None
                    }
                    Progress::Done => Some(self.updated(tools)),
                }
            }
            Doing::Confirming => self.confirm(tools),
            Doing::AskingGrasp { variant, plan } => {
                let (variant, plan) = (*variant, *plan);
                Some(match self.plan(tools)? {
                    Ok(()) => {
                        self.knowledge.store.begin_touch();
                        Doing::Grasping(Grasp::new(plan))
                    }
                    Err(reason) => self.ask_grasp(variant + 1, reason, tools),
                })
            }
            Doing::Grasping(grasp) => match grasp.step(know, tools) {
                GraspEnd::NotYet => None,
                GraspEnd::Stuck(reason) => self.stop(reason),
                GraspEnd::Held(preshape) => Some(self.ask_transport(preshape, tools)),
                GraspEnd::Landed | GraspEnd::Missed => {
                    self.grasps += 1;
                    let again = self.grasps < GRASPS_MAX;
                    Some(if again { self.begin_update() } else { self.fail(FailureReason::GraspMissed) })
                }
            },
            Doing::AskingTransport => Some(match self.plan(tools)? {
                Ok(()) => {
                    self.slip.reset();
                    Doing::Carrying(Carry::new(tools.readings, self.knowledge.setup.mass_kg, self.grip))
                }
                Err(reason) => self.fail(FailureReason::NoPlan(reason)),
            }),
            Doing::Carrying(carry) => {
                let end = carry.step(&mut self.slip, tools);
                self.payload_kg = carry.payload_kg();
                self.grip = carry.grip();
                match end {
                    CarryEnd::NotYet => None,
                    CarryEnd::Done => {
                        self.outcome = Some(Outcome::Transported);
                        Some(Doing::Over)
                    }
                    CarryEnd::Lost => {
                        self.payload_kg = 0.0;
                        self.losses += 1;
                        Some(Doing::Recovering(Recover::default()))
                    }
                }
            }
            Doing::Recovering(recover) => match recover.step(tools) {
                RecoverEnd::NotYet => None,
                RecoverEnd::Open if self.losses > LOSSES_MAX => Some(self.fail(FailureReason::ObjectLost)),
                RecoverEnd::Open => {
                    self.ask(self.request(Purpose::Retreat, tools), tools);
                    Some(Doing::AskingRetreat)
                }
            },
            Doing::AskingRetreat => Some(match self.plan(tools)? {
                Ok(()) => Doing::Retreating,
                Err(_) => self.fail(FailureReason::ObjectLost),
            }),
            Doing::Retreating => tools.executor.at_end().then(|| {
                self.search_anew(tools);
                self.choose()
            }),
            Doing::Over => None,
        }
    }

    /// Starts to choose the next touch.
    fn choose(&mut self) -> Doing {
        let know = &self.knowledge;
        if know.method.published().is_some() {
            // The published method makes the same touch again, aimed at the new belief.
            self.chooser.begin_with(&PUBLISHED_TOUCHES, &know.prior.shape);
        } else {
            self.chooser.begin(&know.belief, &know.prior, &know.history);
        }
        Doing::Choosing
    }

    fn begin_touch(&mut self, rank: u8, tools: &mut Tools) -> Doing {
        let Some(touch) = self.chooser.ranked().get(usize::from(rank)) else {
            return self.fail(FailureReason::NoPlan(RefusalReason::NoPath));
        };
        let know = &mut self.knowledge;
        know.store.begin_touch();
        know.history.note(touch.plan.id, &know.belief.pose());
        self.touches = self.touches.saturating_add(1);
        tools.out.event(EventKind::Touch { candidate: touch.plan.id, information_nats: touch.gain });
        Doing::Touching(Trial::new(&touch.plan))
    }

    fn begin_update(&mut self) -> Doing {
        self.update.begin(&self.knowledge.prior, &self.knowledge.belief, &self.knowledge.method);
        Doing::Updating { asked: false }
    }

    /// What follows an update.
    fn updated(&mut self, tools: &mut Tools) -> Doing {
        let know = &mut self.knowledge;
        know.belief.clone_from(self.update.belief());
        let readiness = know.belief.readiness(&Tolerance::of(&know.setup.shape));
        let spent = self.touches >= know.setup.trials_max;
        let explained = self.update.explains(know.felt.touches());
        let confident = explained
            .unwrap_or_else(|| readiness == Readiness::Ready || (spent && know.belief.is_confident(&LAST_RESORT)));
        tools.out.event(EventKind::Updated {
            belief: know.belief.pose(),
            covariance: know.covariance(),
            evaluations: self.update.stats().evaluations,
            modes: self.update.stats().modes,
            confident,
        });
        if confident {
            return self.ask_mental_world(tools);
        }
        if spent {
            let nothing = readiness == Readiness::NoContact && know.store.contacts().is_empty();
            return self.fail(if nothing { FailureReason::NothingFelt } else { FailureReason::NotConfident });
        }
        if readiness == Readiness::Inconsistent {
            // The object moved, or a reading was false: what was felt longest ago is the likeliest to be wrong now.
            self.inconsistent += 1;
            if self.inconsistent >= 2 {
                know.store.forget_before(know.store.touch().saturating_sub(1));
                self.inconsistent = 0;
            }
        }
        self.choose()
    }

    /// Forgets where the object was: it lies somewhere around the place where it was lost.
    fn search_anew(&mut self, tools: &Tools) {
        let (guess, interval) = recover::search_region(tools, self.yaw_in_hand_rad);
        self.knowledge.search_anew(guess, interval);
        self.last = LastTouch::default();
    }

    fn fail(&mut self, reason: FailureReason) -> Doing {
        self.outcome = Some(Outcome::Failed(reason));
        Doing::Over
    }

    /// Something is wrong: the supervisor makes the robot safe, and what was under way stays as it is.
    fn stop(&mut self, reason: FaultReason) -> Option<Doing> {
        self.fault = Some(reason);
        None
    }

    /// Tells when the phase has changed.
    fn announce(&mut self, tools: &mut Tools) {
        let phase = match &self.doing {
            Doing::Nothing => Phase::Initialise,
            Doing::Choosing | Doing::AskingTouch { .. } | Doing::AskingRetreat => Phase::Plan,
            Doing::Recovering(_) | Doing::Retreating => Phase::Plan,
            Doing::Touching(_) => Phase::Trial,
            Doing::Updating { .. } | Doing::Confirming => Phase::Update,
            Doing::AskingGrasp { .. } | Doing::Grasping(_) | Doing::AskingTransport => Phase::Grasp,
            Doing::Carrying(carry) if carry.is_releasing() => Phase::Release,
            Doing::Carrying(_) => Phase::Transport,
            Doing::Over if self.outcome == Some(Outcome::Transported) => Phase::Done,
            Doing::Over => Phase::Failed,
        };
        if phase != self.phase.0 {
            self.phase = PhaseMark(phase);
            tools.out.event(EventKind::Phase(phase));
        }
    }
}

#[cfg(test)]
mod tests;
