//! What the mission asks of the host, and what it does with the answers.

use super::enquiry::{Enquiry, HostSlow};
use super::grasp::{GraspPlan, HALF_CLOSED_RAD, grasp_plan};
use super::{Doing, Mission, Tools, obstructed, recover};
use tactus_common::limits::FINGERS;
use tactus_common::message::{EventKind, FailureReason, FaultReason, PlanRequest, Preshape, Purpose, RefusalReason};
use tactus_common::pose::PlanarPose;
use tactus_common::robot::hand::HandAngles;

impl Mission {
    /// A plan request with what every one holds.
    pub(super) fn request(&self, purpose: Purpose, tools: &Tools) -> PlanRequest {
        Enquiry::plan_request(purpose, &self.knowledge, tools.executor)
    }

    pub(super) fn ask(&mut self, request: PlanRequest, tools: &mut Tools) {
        self.enquiry.ask_planner(request, tools.out);
    }

    /// Asks for the way to the touch of this rank; `refusal` is why the one before was none.
    pub(super) fn ask_touch(&mut self, rank: u8, refusal: RefusalReason, tools: &mut Tools) -> Doing {
        let Some(touch) = self.chooser.ranked().get(usize::from(rank)) else {
            return self.fail(FailureReason::NoPlan(refusal));
        };
        let (placement, preshape) = (touch.plan.placement(), touch.plan.preshape());
        let request = PlanRequest { touch: touch.plan.id, placement, preshape, ..self.request(Purpose::Touch, tools) };
        self.ask(request, tools);
        Doing::AskingTouch { rank }
    }

    /// Asks for the way to this grasp; `refusal` is why the one before was none.
    pub(super) fn ask_grasp(&mut self, variant: u8, refusal: RefusalReason, tools: &mut Tools) -> Doing {
        let Some(plan) = self.grasp_of_rank(variant) else {
            return self.fail(FailureReason::NoPlan(refusal));
        };
        let displacement_m = self.knowledge.displacement_m();
        let (placement, preshape) = (plan.placement, plan.preshape);
        let request = self.request(Purpose::Grasp, tools);
        self.ask(PlanRequest { placement, preshape, displacement_m, ..request }, tools);
        Doing::AskingGrasp { variant, plan }
    }

    /// The grasps with those last in which the hand would meet an obstacle, open or half closed.
    fn grasp_of_rank(&self, rank: u8) -> Option<GraspPlan> {
        let know = &self.knowledge;
        let (shape, obstacles) = (&know.setup.shape, || know.setup.obstacles.iter().flatten());
        let is_obstructed = |plan: &GraspPlan| {
            let world_from_hand = plan.placement.world_from_hand(&know.belief.pose(), shape);
            [plan.preshape.inner_rad, [HALF_CLOSED_RAD; FINGERS]].into_iter().any(|inner_rad| {
                let angles = HandAngles::engaged(inner_rad, plan.preshape.spread_rad);
                obstructed::meets(obstacles(), &world_from_hand, &angles)
            })
        };
        let all = || (0..).map_while(|variant| grasp_plan(variant, shape));
        if obstacles().next().is_none() {
            return all().nth(usize::from(rank));
        }
        let clear = all().filter(|plan| !is_obstructed(plan));
        clear.chain(all().filter(is_obstructed)).nth(usize::from(rank))
    }

    /// The object is held: asks for the way to its goal.
    pub(super) fn ask_transport(&mut self, preshape: Preshape, tools: &mut Tools) -> Doing {
        self.payload_kg = 0.0;
        let displacement_m = self.knowledge.displacement_m();
        let believed = self.knowledge.belief.pose();
        self.knowledge.goal.get_or_insert(PlanarPose::new(
            believed.x_m + displacement_m[0],
            believed.y_m + displacement_m[1],
            believed.phi_rad,
        ));
        self.yaw_in_hand_rad = recover::hand_yaw_rad(tools) - believed.phi_rad;
        let request = self.request(Purpose::Transport, tools);
        self.ask(PlanRequest { preshape, displacement_m, ..request }, tools);
        Doing::AskingTransport
    }

    /// The planner's answer, if it has come: the trajectory is loaded, or the reason why there is none has been told.
    pub(super) fn plan(&mut self, tools: &mut Tools) -> Option<Result<(), RefusalReason>> {
        let answer = match self.enquiry.plan(tools) {
            Ok(answer) => answer?,
            Err(HostSlow) => {
                self.fault = Some(FaultReason::HostSlow);
                return None;
            }
        };
        if let Err(reason) = answer
            && !matches!(self.doing, Doing::AskingRetreat)
        {
            tools.out.event(EventKind::Refused(reason));
        }
        Some(answer)
    }

    /// Asks what the last touch would have felt like at the new belief.
    pub(super) fn ask_mental_world(&mut self, tools: &mut Tools) -> Doing {
        match self.last.question(self.knowledge.belief.pose()) {
            Some(request) => {
                self.enquiry.ask_mental_world(request, tools.out);
                Doing::Confirming
            }
            None => self.ask_grasp(0, RefusalReason::NoPath, tools),
        }
    }

    /// Compares what the mental world foretells with what was felt.
    pub(super) fn confirm(&mut self, tools: &mut Tools) -> Option<Doing> {
        let foretold = match self.enquiry.rollout(tools) {
            Ok(foretold) => foretold?,
            Err(HostSlow) => return self.stop(FaultReason::HostSlow),
        };
        let agrees = self.last.agrees(&foretold);
        tools.out.event(EventKind::Confirmed(agrees));
        let go_on = agrees || self.touches >= self.knowledge.setup.trials_max;
        Some(if go_on { self.ask_grasp(0, RefusalReason::NoPath, tools) } else { self.choose() })
    }
}
