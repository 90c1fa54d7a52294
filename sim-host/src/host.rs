//! The world's end of the wire, in lockstep: sensors out, command in, one tick on; plans and rollouts in between.

use crate::hooks::{Hooks, To};
use crate::mental::{Closing, MentalModel, RolloutInput};
use crate::mission::{Progressed, planar};
use crate::plan::{ObjectEstimate, PlanQuery, PlanRefusal, Planner, PlannerConfig, Purpose as PlanPurpose};
use crate::world::{HandStart, World};
use std::time::Instant;
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, NodeId, Priority, Sender, Session, SubjectId, received_bytes};
use tactus_common::limits::{FINGERS, PAYLOAD_BYTES_MAX, SILENCE_TICKS_MAX};
use tactus_common::link::{self, SMALL_BYTES};
use tactus_common::message::{
    Command, Event, EventKind, Message, Outcome, Phase, PlanAnswer, PlanRequest, Purpose, ROLLOUT_INSTANTS,
    ROLLOUT_TICKS, RefusalReason, RolloutRequest, RolloutResult, SensorFrame, Setup, Status, TactileSlice, node,
};
use tactus_common::pose::PlanarPose;
use tactus_common::reading::JointCommands;
use tactus_common::robot::hand::HandAngles;
use tactus_common::robot::{FINGER_LIMIT, arm, source};
use tactus_controller::node::Node;
use tactus_hil::bus::Bus;
use tactus_hil::virtual_bus::{VirtualBus, VirtualBusConfig};

/// Ticks after which a mission is called off: 180 s.
const TICKS_MAX: u32 = 90_000;
/// Ticks that go on after the end, for the object to come to rest: 0.5 s.
const REST_TICKS: u32 = 250;
/// Height above the goal from which a touch or a grasp comes straight down, metres.
const APPROACH_M: f32 = 0.10;
/// Height to which the object is lifted, metres.
const LIFT_M: f32 = 0.06;
const SMALL_RX_BYTES: usize = received_bytes(SMALL_BYTES, Mtu::Fd);
/// Places on the virtual bus.
const WORLD: usize = 0;
const CONTROLLER: usize = 1;

/// What a mission came to, as seen from the world's end of the wire.
#[derive(Clone, Debug, Default)]
pub struct HostEnd {
    /// How it ended.
    pub outcome: Option<Outcome>,
    /// The controller's digest.
    pub digest: u64,
    /// Belief at the update that led to the grasp, or the last.
    pub believed: PlanarPose,
    /// Its covariance.
    pub covariance: [f32; 6],
    /// Where the object truly was at that moment.
    pub truth_then: PlanarPose,
    /// Touches.
    pub trials: u32,
    /// Error evaluations.
    pub evaluations: u32,
    /// Wall time of the controller's ticks in each update of its belief, seconds.
    pub update_times_s: Vec<f64>,
    /// Ticks.
    pub ticks: u32,
    /// Frames on the bus.
    pub bus_frames: u64,
    /// Highest bus load.
    pub bus_load_max: f32,
    /// Frames lost in queues.
    pub bus_lost: u64,
    /// Ticks for which no command came.
    pub deadline_misses: u32,
}

/// Subscriptions of the world.
struct Subscriptions {
    command: Session<SMALL_RX_BYTES>,
    plan: Session<SMALL_RX_BYTES>,
    rollout: Session<SMALL_RX_BYTES>,
    event: Session<SMALL_RX_BYTES>,
    status: Session<SMALL_RX_BYTES>,
}

/// What came from the controller in answer to one tick.
#[derive(Default)]
struct Heard {
    command: Option<JointCommands>,
    plan: Option<PlanRequest>,
    rollout: Option<RolloutRequest>,
    events: Vec<Event>,
    status: Option<Status>,
}

/// What the drives do with commands, and without: as motor controllers do, they go on with the last one for a
/// while, and then let go.
struct Drives {
    last: JointCommands,
    missed: u32,
    missed_in_all: u32,
}

impl Drives {
    /// The command to act on at `tick`. One that answers another tick is as good as none.
    fn follow(&mut self, heard: Option<JointCommands>, tick: u32) -> JointCommands {
        match heard.filter(|c| c.tick == tick) {
            Some(commands) => {
                self.last = commands;
                self.missed = 0;
            }
            None => {
                self.missed += 1;
                self.missed_in_all += 1;
            }
        }
        if self.missed >= SILENCE_TICKS_MAX { JointCommands::idle(tick) } else { self.last }
    }
}

/// A world, a planner and a mental world at one end of a bus; the controller at the other.
pub struct Host {
    world: World,
    planner: Planner,
    mental: MentalModel,
    setup: Setup,
    bus: VirtualBus,
    node: Node,
    sender: Sender<5>,
    subscriptions: Subscriptions,
    drives: Drives,
    hooks: Hooks,
    /// Wall time of the update under way, seconds.
    updating_s: f64,
    end: HostEnd,
}

fn subject<M: Message>() -> SubjectId {
    SubjectId::new(M::SUBJECT).expect("subjects are 13-bit constants")
}

fn priority<M: Message>() -> Priority {
    Priority::ALL[usize::from(M::PRIORITY)]
}

fn id(value: u8) -> NodeId {
    NodeId::new(value).expect("node ids are 7-bit constants")
}

impl Host {
    /// A mission about to begin, on a virtual CAN FD bus.
    ///
    /// # Errors
    /// The planner cannot use the robot description.
    pub fn new(world: World, setup: Setup) -> anyhow::Result<Self> {
        let controller = id(node::CONTROLLER);
        Ok(Self {
            world,
            planner: Planner::new(&urdf_rs::read_from_string(source::URDF)?, PlannerConfig::default())?,
            mental: MentalModel::new()?,
            setup,
            bus: VirtualBus::new(2, VirtualBusConfig::FD),
            node: Node::new(Mtu::Fd),
            sender: Sender::new(
                id(node::WORLD),
                [
                    subject::<Setup>(),
                    subject::<SensorFrame>(),
                    subject::<TactileSlice>(),
                    subject::<PlanAnswer>(),
                    subject::<RolloutResult>(),
                ],
            ),
            subscriptions: Subscriptions {
                command: Session::new(subject::<Command>(), controller, 15),
                plan: Session::new(subject::<PlanRequest>(), controller, 15),
                rollout: Session::new(subject::<RolloutRequest>(), controller, 15),
                event: Session::new(subject::<Event>(), controller, 1),
                status: Session::new(subject::<Status>(), controller, 500),
            },
            drives: Drives { last: JointCommands::idle(0), missed: 0, missed_in_all: 0 },
            hooks: Hooks::NONE,
            updating_s: 0.0,
            end: HostEnd::default(),
        })
    }

    /// With someone at the wire; before [`Host::run`].
    #[must_use]
    pub fn with_hooks(mut self, hooks: Hooks) -> Self {
        self.bus = VirtualBus::new(2, VirtualBusConfig { faults: hooks.faults, ..VirtualBusConfig::FD });
        self.hooks = hooks;
        self
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Runs the mission to its end.
    ///
    /// # Errors
    /// The simulation broke down, or a message did not get through.
    pub fn run(&mut self, show: &mut dyn FnMut(&Progressed)) -> anyhow::Result<HostEnd> {
        let setup = self.setup;
        self.send(&setup)?;
        // Whatever takes effect at a tick must have arrived before that tick's readings, on any bus: readings have the
        // higher priority, so they must not wait beside it.
        self.bus.run_until_idle();
        let mut rest = None;
        for tick in 0..TICKS_MAX {
            let heard = self.exchange(tick)?;
            for event in &heard.events {
                self.note(event);
                show(&Progressed::Event(*event));
            }
            if let Some(status) = heard.status {
                show(&Progressed::Status(status));
            }
            if self.end.outcome.is_some() {
                let left = *rest.get_or_insert(REST_TICKS);
                if left == 0 {
                    break;
                }
                rest = Some(left - 1);
            }
            if let Some(request) = &heard.plan {
                let answer = self.plan(request, tick + 1);
                self.send(&answer)?;
            }
            if let Some(request) = &heard.rollout {
                let answer = self.rollout(request, tick + 1);
                self.send(&answer)?;
            }
            self.bus.run_until_idle();
            let commands = self.drives.follow(heard.command, tick);
            self.world.tick(&commands)?;
            self.end.ticks = tick + 1;
        }
        let stats = self.bus.stats();
        self.end.bus_frames = stats.frames;
        self.end.bus_load_max = stats.load_max as f32;
        self.end.bus_lost = [WORLD, CONTROLLER]
            .map(|e| self.bus.endpoint_stats(e))
            .iter()
            .map(|s| s.rejected + s.overrun + s.lost)
            .sum();
        self.end.deadline_misses = self.drives.missed_in_all;
        self.end.digest = self.node.digest().0;
        Ok(self.end.clone())
    }

    /// One tick's readings to the controller, what it says back to here.
    fn exchange(&mut self, tick: u32) -> anyhow::Result<Heard> {
        if let Some(image) = self.world.tactile() {
            // It follows the readings of this tick on the wire, so it takes effect at the next.
            self.send(&TactileSlice::pack(&image, tick + 1))?;
        }
        let frame = SensorFrame::pack(&self.world.readings());
        self.send(&frame)?;
        // Periods begin on the bus's own clock, so that its load is that of a bus at 500 Hz.
        self.bus.advance_to(u64::from(tick) * u64::from(tactus_common::limits::TICK_US) * 1_000);
        self.bus.run_until_idle();
        self.run_controller()?;
        self.bus.run_until_idle();
        Ok(self.listen(tick))
    }

    /// Lets the controller take what has arrived, and puts what it says on the bus.
    fn run_controller(&mut self) -> anyhow::Result<()> {
        let updating = self.node.controller().phase() == Phase::Update;
        let started = Instant::now();
        let mut said: Vec<CanFrame> = Vec::new();
        let mut ticked = false;
        while let Some(received) = self.bus.endpoint(CONTROLLER).receive() {
            for frame in self.hooks.pass(self.world.now(), To::Controller, received.frame) {
                ticked |= self.node.receive(&frame, &mut |frame| said.push(frame));
            }
        }
        if !ticked {
            // The period is over and no sensor message has come.
            self.node.silent_tick(&mut |frame| said.push(frame));
        }
        if updating {
            self.updating_s += started.elapsed().as_secs_f64();
        }
        for frame in said {
            self.bus.endpoint(CONTROLLER).send(frame)?;
        }
        Ok(())
    }

    /// Takes what has arrived from the controller.
    fn listen(&mut self, tick: u32) -> Heard {
        let mut heard = Heard::default();
        let now = u64::from(tick);
        let mut frames = Vec::new();
        while let Some(received) = self.bus.endpoint(WORLD).receive() {
            frames.extend(self.hooks.pass(tick, To::World, received.frame));
        }
        for frame in &frames {
            let Ok(header) = Header::parse(frame.id()) else { continue };
            let data = frame.data();
            let s = &mut self.subscriptions;
            // What does not decode is as good as not sent: the drives and the controller's own time limits see to it.
            if let Ok(Some(t)) = s.command.accept(&header, data, now) {
                heard.command = link::decode::<Command>(t.payload).ok().and_then(|c| c.unpack());
            }
            if let Ok(Some(t)) = s.plan.accept(&header, data, now) {
                heard.plan = link::decode(t.payload).ok();
            }
            if let Ok(Some(t)) = s.rollout.accept(&header, data, now) {
                heard.rollout = link::decode(t.payload).ok();
            }
            if let Ok(Some(t)) = s.status.accept(&header, data, now) {
                heard.status = link::decode(t.payload).ok();
            }
            if let Ok(Some(t)) = s.event.accept(&header, data, now) {
                heard.events.extend(link::decode::<Event>(t.payload).ok());
            }
        }
        heard
    }

    /// Puts a message on the bus.
    fn send<M: Message>(&mut self, message: &M) -> anyhow::Result<()> {
        let mut buffer = [0; PAYLOAD_BYTES_MAX];
        let bytes = link::encode(message, &mut buffer)?;
        for frame in self.sender.send(subject::<M>(), priority::<M>(), bytes, Mtu::Fd)? {
            self.bus.endpoint(WORLD).send(frame)?;
        }
        Ok(())
    }

    /// Keeps what the report needs.
    fn note(&mut self, event: &Event) {
        match event.kind {
            EventKind::Touch { .. } => self.end.trials += 1,
            EventKind::Updated { belief, covariance, evaluations, .. } => {
                self.end.update_times_s.push(std::mem::take(&mut self.updating_s));
                self.end.evaluations += u32::from(evaluations);
                self.end.believed = belief;
                self.end.covariance = covariance;
                self.end.truth_then = planar(&self.world.object_pose());
            }
            EventKind::Finished(outcome) => self.end.outcome = Some(outcome),
            EventKind::Phase(_) | EventKind::Contact { .. } | EventKind::Confirmed(_) | EventKind::Refused(_) => {}
        }
    }

    /// Asks the planner.
    fn plan(&mut self, request: &PlanRequest, effective: u32) -> PlanAnswer {
        let shape = self.setup.shape;
        let displaced = |mut pose: nalgebra::Isometry3<f32>| {
            pose.translation.x += request.displacement_m[0];
            pose.translation.y += request.displacement_m[1];
            pose
        };
        let above = request.placement.world_from_hand(&request.belief, &shape);
        let (goal, next) = match request.purpose {
            Purpose::Touch => (above, None),
            Purpose::Grasp => (above, Some(displaced(above))),
            Purpose::Transport | Purpose::Retreat => (displaced(arm::hand_pose(&request.start_q_rad)), None),
        };
        let purpose = match request.purpose {
            Purpose::Touch => PlanPurpose::Touch,
            Purpose::Grasp => PlanPurpose::Grasp,
            Purpose::Transport => PlanPurpose::Transport,
            Purpose::Retreat => PlanPurpose::Retreat,
        };
        let approach_height_m = if request.purpose == Purpose::Transport { LIFT_M } else { APPROACH_M };
        let query = PlanQuery {
            request: request.request,
            purpose,
            start_q_rad: request.start_q_rad,
            hand_angles: HandAngles::engaged(request.preshape.inner_rad, request.preshape.spread_rad),
            goal_world_from_hand: goal,
            approach_height_m,
            object: Some(object_estimate(request, &shape)),
            next_world_from_hand: next,
        };
        let result = self.planner.plan(&query).map_err(reason);
        PlanAnswer { effective, request: request.request, result }
    }

    /// Asks the mental world. A pose that it cannot roll out (off the table, say) is answered as one at which nothing
    /// would be felt.
    fn rollout(&self, request: &RolloutRequest, effective: u32) -> RolloutResult {
        let input = RolloutInput {
            world_from_hand: arm::hand_pose(&request.arm_q_rad),
            start: HandStart { inner_rad: request.preshape.inner_rad, spread_rad: request.preshape.spread_rad },
            closing: Closing::Together,
            speed_rad_s: request.closing_rad_s,
            stop_at_rad: FINGER_LIMIT.upper_rad,
            ticks: ROLLOUT_TICKS,
            object: request.pose,
            half_extents_m: self.setup.shape.half_extents_m(),
        };
        let mut result = RolloutResult {
            effective,
            request: request.request,
            onset_inner_rad: [None; FINGERS],
            contacts: [0; ROLLOUT_INSTANTS],
        };
        if let Ok(foretold) = self.mental.rollout(&input) {
            result.onset_inner_rad = foretold.onset_rad;
            for (i, bits) in result.contacts.iter_mut().enumerate() {
                // A rollout that ends early stays as it ended.
                let at = (i + 1) * ROLLOUT_TICKS as usize / ROLLOUT_INSTANTS - 1;
                *bits = foretold.samples.get(at).or(foretold.samples.last()).map_or(0, |s| s.contacts);
            }
        }
        result
    }
}

/// The believed object, grown by its uncertainty.
fn object_estimate(request: &PlanRequest, shape: &tactus_common::shape::ObjectShape) -> ObjectEstimate {
    let [xx, xy, _, yy, _, pp] = request.covariance;
    let (s, c) = libm::sincosf(request.belief.phi_rad);
    // Variances along the object's own axes.
    let along = c * c * xx + 2.0 * s * c * xy + s * s * yy;
    let across = s * s * xx - 2.0 * s * c * xy + c * c * yy;
    let sd = |v: f32| libm::sqrtf(v.max(0.0));
    ObjectEstimate::with_sigma(
        shape.half_extents_m(),
        request.belief,
        shape.rest_height_m(),
        [sd(along), sd(across)],
        sd(pp),
    )
}

fn reason(refusal: PlanRefusal) -> RefusalReason {
    match refusal {
        PlanRefusal::NoInverseKinematics => RefusalReason::NoInverseKinematics,
        PlanRefusal::OutOfReach => RefusalReason::OutOfReach,
        PlanRefusal::StartInCollision => RefusalReason::StartInCollision,
        PlanRefusal::GoalInCollision => RefusalReason::GoalInCollision,
        PlanRefusal::NoPath | PlanRefusal::Unfit(_) => RefusalReason::NoPath,
        PlanRefusal::TooManyKnots => RefusalReason::TooManyKnots,
        PlanRefusal::NonFinite => RefusalReason::NonFinite,
    }
}
