//! The mission: which phase follows which.
//!
//! `Initialise -> Plan -> Trial -> Update -> (Plan ...) -> Grasp -> Transport -> Release -> Done`. Each phase owns its
//! state; [`Mission::step`] is the one function that moves between them. A fault is the supervisor's matter.

mod carry;
mod closing;
mod descent;
mod grasp;
mod grip;
mod hand;
mod knowledge;
mod recover;
mod trial;

use crate::belief::{Belief, Readiness, Tolerance};
use crate::controller::Outputs;
use crate::executor::Executor;
use crate::onset::{Felt, Onset};
use crate::touch::{Chooser, RankedTouches, TouchPlan};
use crate::update::{Progress, Update, UpdateConfig};
use carry::{Carry, CarryEnd};
use grasp::{Grasp, GraspEnd, grasp_plan};
use knowledge::Knowledge;
use recover::{Recover, RecoverEnd};
use tactus_common::limits::{ARM_JOINTS, FINGERS, HAND_MOTORS, PADS};
use tactus_common::message::{
    EventKind, FailureReason, FaultReason, Outcome, Phase, PlanAnswer, PlanRequest, Purpose, RefusalReason,
    RolloutRequest, RolloutResult, Setup, Status,
};
use tactus_common::pose::PlanarPose;
use tactus_common::reading::{HandCommand, JointReadings, TactileImage};
use tactus_common::trajectory::Trajectory;
use trial::{Trial, TrialEnd};

/// Error evaluations in one tick.
const EVALUATIONS_PER_TICK: u16 = 2;
/// Ticks to wait for an answer of the host: 10 s.
const ANSWER_TICKS_MAX: u32 = 5_000;
/// Half width of the belief (99 %) that is good enough for a grasp when no touch is left, metres.
const LAST_RESORT: Tolerance = Tolerance { position_m: 0.015, yaw_rad: 0.12 };
/// Difference between foretold and felt inner-link angle at onset that still confirms the belief, radians (about 3 mm).
const CONFIRM_RAD: f32 = 0.03;
/// The foretold closing begins this much before the angle at which something was felt, radians: half of what 0.6 s
/// of closing sweep.
const CONFIRM_RUN_UP_RAD: f32 = 0.1;
/// Times that the object may be lost and searched for anew.
const LOSSES_MAX: u8 = 1;
/// Grasps that may fail before the mission gives up.
const GRASPS_MAX: u8 = 3;

/// What a phase works with during one tick.
pub struct Tools<'a> {
    /// Readings of this tick.
    pub readings: &'a JointReadings,
    /// What is felt.
    pub felt: Felt,
    /// New pad images.
    pub images: &'a [Option<TactileImage>; PADS],
    /// The planner's answer.
    pub plan: Option<&'a PlanAnswer>,
    /// The mental world's answer.
    pub rollout: Option<&'a RolloutResult>,
    /// Moves the arm.
    pub executor: &'a mut Executor,
    /// Contact detection.
    pub onset: &'a mut Onset,
    /// Commands of the hand; kept from tick to tick.
    pub hand: &'a mut [HandCommand; HAND_MOTORS],
    /// What goes out.
    pub out: &'a mut Outputs,
}

/// What the mission is doing, with what it needs for it.
// Without a heap the largest state sets the size of all: no variant can be put behind a pointer.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, Default)]
enum Doing {
    /// Nothing to do yet.
    #[default]
    Nothing,
    Choosing(Chooser),
    AskingTouch {
        ranked: RankedTouches,
        index: u8,
        waited: u32,
    },
    Touching(Trial),
    Updating(Update),
    Confirming {
        waited: u32,
    },
    AskingGrasp {
        variant: u8,
        waited: u32,
    },
    Grasping(Grasp),
    AskingTransport {
        waited: u32,
    },
    Carrying(Carry),
    /// The object was lost: stops and opens.
    Recovering(Recover),
    /// Waits for the way up, then goes it.
    AskingRetreat {
        waited: u32,
    },
    Retreating,
    Over,
}

/// What the last touch felt, for the mental world to foretell.
#[derive(Clone, Copy, Debug, Default)]
struct LastTouch {
    arm_q_rad: [f32; ARM_JOINTS],
    plan: Option<TouchPlan>,
    onset_inner_rad: [Option<f32>; FINGERS],
}

/// The mission's state machine.
#[derive(Clone, Debug, Default)]
pub struct Mission {
    knowledge: Option<Knowledge>,
    doing: Doing,
    phase: PhaseMark,
    last: LastTouch,
    touches: u8,
    grasps: u8,
    losses: u8,
    yaw_in_hand_rad: f32,
    inconsistent: u8,
    requests: u16,
    asked: Option<Purpose>,
    payload_kg: f32,
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
        *self = Self::default();
        self.knowledge = Some(Knowledge::new(setup)?);
        Ok(())
    }

    /// Whether a set-up makes sense, before a mission is begun with it.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn check(setup: &Setup) -> Result<(), FaultReason> {
        knowledge::check(setup)
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

    /// The believed pose.
    pub fn believed(&self) -> Option<PlanarPose> {
        self.knowledge.as_ref().map(|k| k.belief.pose())
    }

    /// What is believed of the object's place; `None` before a mission.
    pub fn belief(&self) -> Option<&Belief> {
        self.knowledge.as_ref().map(|k| &k.belief)
    }

    /// A status message.
    pub fn status(&self, tick: u32, phase: Phase) -> Status {
        let (belief, covariance, evidence) = match &self.knowledge {
            Some(k) => (k.belief.pose(), k.covariance(), k.store.contacts().len() as u8),
            None => (PlanarPose::default(), [0.0; 6], 0),
        };
        Status { tick, phase, belief, covariance, evidence, touches: self.touches }
    }

    /// One tick of the mission.
    pub fn step(&mut self, tools: &mut Tools) {
        let Some(mut knowledge) = self.knowledge.take() else { return };
        let doing = core::mem::take(&mut self.doing);
        self.doing = self.advance(doing, &mut knowledge, tools);
        self.announce(tools);
        self.knowledge = Some(knowledge);
    }

    /// The transition function.
    fn advance(&mut self, doing: Doing, know: &mut Knowledge, tools: &mut Tools) -> Doing {
        match doing {
            Doing::Nothing => self.choose(know),
            Doing::Choosing(mut chooser) => match chooser.step() {
                None => Doing::Choosing(chooser),
                Some(ranked) => {
                    let ranked = ranked.clone();
                    self.ask_touch(ranked, 0, know, tools)
                }
            },
            Doing::AskingTouch { ranked, index, waited } => match self.answer(waited, tools) {
                Answer::Waiting => Doing::AskingTouch { ranked, index, waited: waited + 1 },
                Answer::Accepted => self.begin_touch(&ranked, index, know, tools),
                Answer::Refused(reason) => {
                    tools.out.event(EventKind::Refused(reason));
                    if usize::from(index) + 1 < ranked.len() {
                        self.ask_touch(ranked, index + 1, know, tools)
                    } else {
                        self.fail(FailureReason::NoPlan(reason))
                    }
                }
            },
            Doing::Touching(mut trial) => match trial.step(know, tools) {
                TrialEnd::NotYet => Doing::Touching(trial),
                TrialEnd::Over { arm_q_rad, onset_inner_rad } => {
                    self.last = LastTouch { arm_q_rad, plan: Some(*trial.plan()), onset_inner_rad };
                    self.begin_update(know)
                }
            },
            Doing::Updating(mut update) => match update.step(EVALUATIONS_PER_TICK, &know.store) {
                Progress::Running => Doing::Updating(update),
                Progress::Done => self.updated(&update, know, tools),
            },
            Doing::Confirming { waited } => self.confirm(waited, know, tools),
            Doing::AskingGrasp { variant, waited } => match self.answer(waited, tools) {
                Answer::Waiting => Doing::AskingGrasp { variant, waited: waited + 1 },
                Answer::Accepted => {
                    know.store.begin_touch();
                    Doing::Grasping(Grasp::new(grasp_plan(variant)))
                }
                Answer::Refused(reason) => {
                    tools.out.event(EventKind::Refused(reason));
                    if variant + 1 < grasp::VARIANTS {
                        self.ask_grasp(variant + 1, know, tools)
                    } else {
                        self.fail(FailureReason::NoPlan(reason))
                    }
                }
            },
            Doing::Grasping(mut grasp) => match grasp.step(know, tools) {
                GraspEnd::NotYet => Doing::Grasping(grasp),
                GraspEnd::Held(preshape) => {
                    self.payload_kg = 0.0;
                    let displacement_m = know.displacement_m();
                    let believed = know.belief.pose();
                    know.goal.get_or_insert(PlanarPose::new(
                        believed.x_m + displacement_m[0],
                        believed.y_m + displacement_m[1],
                        believed.phi_rad,
                    ));
                    self.yaw_in_hand_rad = recover::hand_yaw_rad(tools) - believed.phi_rad;
                    let request = self.request(Purpose::Transport, know, tools);
                    tools.out.plan_request = Some(PlanRequest { preshape, displacement_m, ..request });
                    Doing::AskingTransport { waited: 0 }
                }
                GraspEnd::Landed | GraspEnd::Missed => {
                    self.grasps += 1;
                    if self.grasps >= GRASPS_MAX {
                        self.fail(FailureReason::GraspMissed)
                    } else {
                        self.begin_update(know)
                    }
                }
            },
            Doing::AskingTransport { waited } => match self.answer(waited, tools) {
                Answer::Waiting => Doing::AskingTransport { waited: waited + 1 },
                Answer::Accepted => Doing::Carrying(Carry::new(tools.readings, know.setup.mass_kg)),
                Answer::Refused(reason) => {
                    tools.out.event(EventKind::Refused(reason));
                    self.fail(FailureReason::NoPlan(reason))
                }
            },
            Doing::Carrying(mut carry) => {
                let end = carry.step(tools);
                self.payload_kg = carry.payload_kg();
                match end {
                    CarryEnd::NotYet => Doing::Carrying(carry),
                    CarryEnd::Done => {
                        self.outcome = Some(Outcome::Transported);
                        Doing::Over
                    }
                    CarryEnd::Lost => {
                        self.payload_kg = 0.0;
                        self.losses += 1;
                        Doing::Recovering(Recover::default())
                    }
                }
            }
            Doing::Recovering(mut recover) => match recover.step(tools) {
                RecoverEnd::NotYet => Doing::Recovering(recover),
                RecoverEnd::Open if self.losses > LOSSES_MAX => self.fail(FailureReason::ObjectLost),
                RecoverEnd::Open => {
                    let request = self.request(Purpose::Retreat, know, tools);
                    tools.out.plan_request = Some(request);
                    Doing::AskingRetreat { waited: 0 }
                }
            },
            Doing::AskingRetreat { waited } => match self.answer(waited, tools) {
                Answer::Waiting => Doing::AskingRetreat { waited: waited + 1 },
                Answer::Accepted => Doing::Retreating,
                Answer::Refused(_) => self.fail(FailureReason::ObjectLost),
            },
            Doing::Retreating if tools.executor.at_end() => {
                self.search_anew(know, tools);
                self.choose(know)
            }
            Doing::Retreating => Doing::Retreating,
            Doing::Over => Doing::Over,
        }
    }

    /// Starts to choose the next touch.
    fn choose(&mut self, know: &Knowledge) -> Doing {
        Doing::Choosing(Chooser::new(&know.belief, &know.prior, &know.history))
    }

    /// A plan request with what every one holds.
    fn request(&mut self, purpose: Purpose, know: &Knowledge, tools: &Tools) -> PlanRequest {
        self.requests = self.requests.wrapping_add(1);
        self.asked = Some(purpose);
        PlanRequest {
            request: self.requests,
            purpose,
            touch: u8::MAX,
            start_q_rad: tools.executor.reference().q_rad,
            placement: Default::default(),
            preshape: Default::default(),
            displacement_m: [0.0; 2],
            belief: know.belief.pose(),
            covariance: know.covariance(),
        }
    }

    fn ask_touch(&mut self, ranked: RankedTouches, index: u8, know: &Knowledge, tools: &mut Tools) -> Doing {
        let Some(touch) = ranked.get(usize::from(index)) else {
            return self.fail(FailureReason::NoPlan(RefusalReason::NoPath));
        };
        let request = self.request(Purpose::Touch, know, tools);
        tools.out.plan_request = Some(PlanRequest {
            touch: touch.plan.id,
            placement: touch.plan.placement(),
            preshape: touch.plan.preshape(),
            ..request
        });
        Doing::AskingTouch { ranked, index, waited: 0 }
    }

    fn ask_grasp(&mut self, variant: u8, know: &Knowledge, tools: &mut Tools) -> Doing {
        let plan = grasp_plan(variant);
        let request = self.request(Purpose::Grasp, know, tools);
        tools.out.plan_request = Some(PlanRequest {
            placement: plan.placement,
            preshape: plan.preshape,
            displacement_m: know.displacement_m(),
            ..request
        });
        Doing::AskingGrasp { variant, waited: 0 }
    }

    /// The planner's answer to the newest request; an accepted trajectory is loaded.
    fn answer(&mut self, waited: u32, tools: &mut Tools) -> Answer {
        let Some(answer) = tools.plan.filter(|a| a.request == self.requests) else {
            if waited >= ANSWER_TICKS_MAX {
                self.fault = Some(FaultReason::HostSlow);
            }
            return Answer::Waiting;
        };
        // A touch or a grasp waits where its guarded part begins, a retreat does not: without this check, for ever.
        let fits = |t: &Trajectory| match self.asked {
            Some(Purpose::Touch | Purpose::Grasp) => t.guarded_from_s().is_some(),
            Some(Purpose::Retreat) => t.guarded_from_s().is_none(),
            Some(Purpose::Transport) | None => true,
        };
        match &answer.result {
            Ok(trajectory) if !fits(trajectory) => Answer::Refused(RefusalReason::NoPath),
            Ok(trajectory) => load(tools.executor, trajectory),
            Err(reason) => Answer::Refused(*reason),
        }
    }

    fn begin_touch(&mut self, ranked: &RankedTouches, index: u8, know: &mut Knowledge, tools: &mut Tools) -> Doing {
        let Some(touch) = ranked.get(usize::from(index)) else {
            return self.fail(FailureReason::NoPlan(RefusalReason::NoPath));
        };
        know.store.begin_touch();
        know.history.note(touch.plan.id, &know.belief.pose());
        self.touches += 1;
        tools.out.event(EventKind::Touch { candidate: touch.plan.id, information_nats: touch.gain });
        Doing::Touching(Trial::new(&touch.plan))
    }

    fn begin_update(&mut self, know: &Knowledge) -> Doing {
        Doing::Updating(Update::new(&know.prior, &know.belief, &UpdateConfig::default()))
    }

    /// What follows an update.
    fn updated(&mut self, update: &Update, know: &mut Knowledge, tools: &mut Tools) -> Doing {
        know.belief = update.belief().clone();
        let readiness = know.belief.readiness(&Tolerance::default());
        let spent = self.touches >= know.setup.trials_max;
        let confident = readiness == Readiness::Ready || (spent && know.belief.is_confident(&LAST_RESORT));
        tools.out.event(EventKind::Updated {
            belief: know.belief.pose(),
            covariance: know.covariance(),
            evaluations: update.stats().evaluations,
            modes: update.stats().modes,
            confident,
        });
        if confident {
            return self.ask_mental_world(know, tools);
        }
        if spent {
            let nothing = readiness == Readiness::NoContact;
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
        self.choose(know)
    }

    /// Asks what the last touch would have felt like at the new belief; without a contact there is nothing to ask.
    fn ask_mental_world(&mut self, know: &Knowledge, tools: &mut Tools) -> Doing {
        let Some(plan) = self.last.plan.filter(|_| self.last.onset_inner_rad.iter().any(Option::is_some)) else {
            return self.ask_grasp(0, know, tools);
        };
        self.requests = self.requests.wrapping_add(1);
        // The fingers that felt something close once more from shortly before: the rollout is as short as that.
        let mut preshape = plan.preshape();
        let mut closing_rad_s = [0.0; FINGERS];
        for (f, onset) in self.last.onset_inner_rad.iter().enumerate() {
            if let Some(onset_rad) = onset {
                preshape.inner_rad[f] = (onset_rad - CONFIRM_RUN_UP_RAD).max(preshape.inner_rad[f]);
                closing_rad_s[f] = closing::CLOSING_RAD_S;
            }
        }
        let pose = know.belief.pose();
        let (request, arm_q_rad) = (self.requests, self.last.arm_q_rad);
        tools.out.rollout_request = Some(RolloutRequest { request, pose, arm_q_rad, preshape, closing_rad_s });
        Doing::Confirming { waited: 0 }
    }

    /// Compares what the mental world foretells with what was felt.
    fn confirm(&mut self, waited: u32, know: &mut Knowledge, tools: &mut Tools) -> Doing {
        let Some(result) = tools.rollout.filter(|r| r.request == self.requests) else {
            if waited >= ANSWER_TICKS_MAX {
                self.fault = Some(FaultReason::HostSlow);
            }
            return Doing::Confirming { waited: waited + 1 };
        };
        let agrees = self.last.onset_inner_rad.iter().zip(&result.onset_inner_rad).all(|pair| match pair {
            (Some(felt), Some(foretold)) => (felt - foretold).abs() <= CONFIRM_RAD,
            (Some(_), None) => false,
            // Whether a finger just misses or just touches decides nothing.
            (None, _) => true,
        });
        tools.out.event(EventKind::Confirmed(agrees));
        if agrees || self.touches >= know.setup.trials_max { self.ask_grasp(0, know, tools) } else { self.choose(know) }
    }

    /// Forgets where the object was: it lies somewhere around the place where it was lost.
    fn search_anew(&mut self, know: &mut Knowledge, tools: &Tools) {
        let (guess, interval) = recover::search_region(tools, self.yaw_in_hand_rad);
        know.search_anew(guess, interval);
        self.last = LastTouch::default();
    }

    fn fail(&mut self, reason: FailureReason) -> Doing {
        self.outcome = Some(Outcome::Failed(reason));
        Doing::Over
    }

    /// Tells when the phase has changed.
    fn announce(&mut self, tools: &mut Tools) {
        let phase = match &self.doing {
            Doing::Nothing => Phase::Initialise,
            Doing::Choosing(_) | Doing::AskingTouch { .. } | Doing::AskingRetreat { .. } => Phase::Plan,
            Doing::Recovering(_) | Doing::Retreating => Phase::Plan,
            Doing::Touching(_) => Phase::Trial,
            Doing::Updating(_) | Doing::Confirming { .. } => Phase::Update,
            Doing::AskingGrasp { .. } | Doing::Grasping(_) | Doing::AskingTransport { .. } => Phase::Grasp,
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

/// What became of a plan request.
enum Answer {
    Waiting,
    Accepted,
    Refused(RefusalReason),
}

/// Loads a trajectory; one that the executor refuses counts as no path.
fn load(executor: &mut Executor, trajectory: &Trajectory) -> Answer {
    match executor.load(trajectory) {
        Ok(()) => Answer::Accepted,
        Err(_) => Answer::Refused(RefusalReason::NoPath),
    }
}

#[cfg(test)]
mod tests;
