//! Questions to the host: numbered, repeated while no answer comes, and in the end given up.

use super::{Knowledge, Tools};
use crate::controller::Outputs;
use crate::executor::Executor;
use tactus_common::message::{
    HandPlacement, PlanRequest, Preshape, Purpose, RefusalReason, RolloutRequest, RolloutResult,
};
use tactus_common::trajectory::Trajectory;

/// Ticks to wait for an answer of the host: 10 s.
pub const ANSWER_TICKS_MAX: u32 = 5_000;
/// Ticks after which a question is put once more, for the case that it or its answer was lost: 3 s, so at 3, 6 and 9 s.
/// The host answers the same number the same way, and only the first answer is used.
pub const REPEAT_TICKS: u32 = 1_500;

const _: () = assert!(3 * REPEAT_TICKS < ANSWER_TICKS_MAX, "the last repeat must have time to be answered");

/// The host did not answer in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostSlow;

/// A question.
#[derive(Clone, Copy, Debug)]
enum Question {
    Plan(PlanRequest),
    Rollout(RolloutRequest),
}

impl Question {
    fn put(&self, out: &mut Outputs) {
        match self {
            Self::Plan(request) => out.plan_request = Some(*request),
            Self::Rollout(request) => out.rollout_request = Some(*request),
        }
    }
}

/// The newest question and how long it has been waiting for its answer.
#[derive(Clone, Debug, Default)]
pub struct Enquiry {
    number: u16,
    question: Option<Question>,
    waited: u32,
}

impl Enquiry {
    /// A plan request with what every one holds, to be completed and [asked](Self::ask_planner).
    pub(super) fn plan_request(purpose: Purpose, know: &Knowledge, executor: &Executor) -> PlanRequest {
        PlanRequest {
            request: 0,
            purpose,
            touch: u8::MAX,
            start_q_rad: executor.reference().q_rad,
            placement: HandPlacement::default(),
            preshape: Preshape::default(),
            displacement_m: [0.0; 2],
            belief: know.belief.pose(),
            covariance: know.covariance(),
        }
    }

    /// Asks the planner; the request gets its number here.
    pub fn ask_planner(&mut self, request: PlanRequest, out: &mut Outputs) {
        let request = PlanRequest { request: self.next_number(), ..request };
        self.ask(Question::Plan(request), out);
    }

    /// Asks the mental world; the request gets its number here.
    pub fn ask_mental_world(&mut self, request: RolloutRequest, out: &mut Outputs) {
        let request = RolloutRequest { request: self.next_number(), ..request };
        self.ask(Question::Rollout(request), out);
    }

    fn next_number(&mut self) -> u16 {
        self.number = self.number.wrapping_add(1);
        self.number
    }

    fn ask(&mut self, question: Question, out: &mut Outputs) {
        question.put(out);
        self.question = Some(question);
        self.waited = 0;
    }

    /// The planner's answer to the newest question, if it has come: the trajectory is loaded, or the reason why there
    /// is none.
    ///
    /// # Errors
    /// [`HostSlow`] if it should have come by now.
    pub(super) fn plan(&mut self, tools: &mut Tools) -> Result<Option<Result<(), RefusalReason>>, HostSlow> {
        let Some(answer) = tools.plan.filter(|a| a.request == self.number) else {
            return self.wait(tools.out).map(|()| None);
        };
        Ok(Some(match &answer.result {
            Ok(trajectory) if !self.fits(trajectory) => Err(RefusalReason::NoPath),
            // One that the executor refuses counts as no path.
            Ok(trajectory) => tools.executor.load(trajectory).map_err(|_| RefusalReason::NoPath),
            Err(reason) => Err(*reason),
        }))
    }

    /// The mental world's answer to the newest question, if it has come.
    ///
    /// # Errors
    /// [`HostSlow`] if it should have come by now.
    pub(super) fn rollout(&mut self, tools: &mut Tools) -> Result<Option<RolloutResult>, HostSlow> {
        match tools.rollout.filter(|r| r.request == self.number) {
            Some(result) => Ok(Some(*result)),
            None => self.wait(tools.out).map(|()| None),
        }
    }

    /// A touch or a grasp waits where its guarded part begins, a retreat does not: without this check, for ever.
    fn fits(&self, trajectory: &Trajectory) -> bool {
        let guarded = trajectory.guarded_from_s().is_some();
        match &self.question {
            Some(Question::Plan(request)) => match request.purpose {
                Purpose::Touch | Purpose::Grasp => guarded,
                Purpose::Retreat => !guarded,
                Purpose::Transport => true,
            },
            Some(Question::Rollout(_)) | None => true,
        }
    }

    /// One more tick without an answer.
    fn wait(&mut self, out: &mut Outputs) -> Result<(), HostSlow> {
        if self.waited >= ANSWER_TICKS_MAX {
            return Err(HostSlow);
        }
        self.waited += 1;
        if self.waited.is_multiple_of(REPEAT_TICKS)
            && let Some(question) = &self.question
        {
            question.put(out);
        }
        Ok(())
    }
}
