//! The world's end of the wire: sensors out, command in, one tick on; plans and rollouts in between.

use crate::advisor::{Advisor, Question, Reply};
use crate::desk::Desk;
use crate::mission::planar;
use crate::observer::{Observer, Seen};
use crate::post::{Heard, Post};
use crate::wire::{Wire, WireStats};
use crate::world::World;
use std::time::{Duration, Instant};
use tactus_common::limits::{SILENCE_TICKS_MAX, TICK_US};
use tactus_common::message::{
    DigestReport, Event, EventKind, LinkContact, Message, Outcome, Phase, SensorFrame, Setup, TactileSlice,
};
use tactus_common::pose::PlanarPose;
use tactus_common::reading::JointCommands;
use tactus_common::shape::ObjectShape;
use tactus_hil::choice::Pace;

/// Length of a tick.
const TICK: Duration = Duration::from_micros(TICK_US as u64);
/// Ticks after which a mission is called off: 180 s.
const TICKS_MAX: u32 = 90_000;
/// Ticks that go on after the end, for the object to come to rest: 0.5 s.
const REST_TICKS: u32 = 250;
/// Ticks that go on after the controller was lost, for the drives to let go and the arm to come down: 2 s.
const ABANDONED_TICKS: u32 = 1_000;
/// So often a tick's readings are sent again within the world's patience, if there is no answer; lockstep on a live bus:
/// every 50 ms on a CAN bus.
const REPEATS: u32 = 40;
/// Ticks by which the controller must have taken its set-up, and how often it is sent again.
const SETUP_TICKS: u32 = 50;
const SETUPS_MAX: u32 = 3;
/// In real time an answer takes effect this much later than it is sent, so that it has arrived: 50 ms.
const ANSWER_TICKS: u32 = 25;

/// The controller stopped answering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost {
    /// First tick without a command.
    pub tick: u32,
    /// The phase in which the mission was.
    pub phase: Phase,
}

/// What a mission came to, as seen from the world's end of the wire.
#[derive(Clone, Debug, Default)]
pub struct HostEnd {
    /// How it ended.
    pub outcome: Option<Outcome>,
    /// The controller stopped answering.
    pub lost: Option<Lost>,
    /// Tick at which the drives let go for want of commands.
    pub released: Option<u32>,
    /// Digest of the mission and the ticks it covers, as the controller reported them with the end.
    pub digest: Option<DigestReport>,
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
    /// Wall time of the controller's answers during each update of its belief, seconds.
    pub update_times_s: Vec<f64>,
    /// Wall time of each answer, microseconds.
    pub answer_times_us: Vec<f32>,
    /// Ticks.
    pub ticks: u32,
    /// What the wire carried.
    pub wire: WireStats,
    /// Ticks for which no command came.
    pub deadline_misses: u32,
}

/// What the drives do with commands, and without: as motor controllers do, they go on with the last one for a
/// while, and then let go.
struct Drives {
    last: JointCommands,
    missed: u32,
    missed_in_all: u32,
}

impl Drives {
    /// The command to act on at `tick`.
    fn follow(&mut self, heard: Option<JointCommands>, tick: u32) -> JointCommands {
        match heard {
            Some(commands) => {
                self.last = commands;
                self.missed = 0;
            }
            None => {
                self.missed += 1;
                self.missed_in_all += 1;
            }
        }
        if self.has_let_go() { JointCommands::idle(tick) } else { self.last }
    }

    fn has_let_go(&self) -> bool {
        self.missed >= SILENCE_TICKS_MAX
    }
}

/// A world and an advisor at one end of a wire; the controller at the other.
pub struct Host {
    world: World,
    desk: Desk,
    setup: Setup,
    setups: u32,
    /// The world tells which links touch.
    ideal_sensors: bool,
    pace: Pace,
    post: Post,
    drives: Drives,
    phase: Phase,
    /// Wall time of the update under way, seconds.
    updating_s: f64,
    started: Instant,
    /// Ticks that go on after the end; `None` before it.
    left: Option<u32>,
    end: HostEnd,
}

impl Host {
    /// A mission about to begin.
    ///
    /// # Errors
    /// The planner cannot use the robot description.
    pub fn new(world: World, setup: Setup, pace: Pace) -> anyhow::Result<Self> {
        Ok(Self {
            world,
            desk: Desk::new(Advisor::new(setup.shape, &setup.robot_base, setup.obstacles.iter().flatten())?),
            setup,
            setups: 1,
            ideal_sensors: false,
            pace,
            post: Post::default(),
            drives: Drives { last: JointCommands::idle(0), missed: 0, missed_in_all: 0 },
            phase: Phase::Initialise,
            updating_s: 0.0,
            started: Instant::now(),
            left: None,
            end: HostEnd::default(),
        })
    }

    /// The world has one contact sensor for each link of the hand, which the real hand lacks, and tells what they feel.
    pub fn with_ideal_sensors(mut self) -> Self {
        self.ideal_sensors = true;
        self
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The object's shape, as the controller is told it.
    pub fn shape(&self) -> ObjectShape {
        self.setup.shape
    }

    /// Runs the mission to its end, with the controller at the other end of `wire`, which waits for one.
    ///
    /// # Errors
    /// The simulation broke down, the bus did, or `observer` cannot go on.
    pub fn run(&mut self, wire: &mut dyn Wire, observer: &mut dyn Observer) -> anyhow::Result<HostEnd> {
        self.begin(wire)?;
        while self.tick(wire, observer)? {}
        Ok(self.finish(wire))
    }

    /// Tells the controller its mission: before the first [`Self::tick`].
    ///
    /// # Errors
    /// The bus broke down.
    pub fn begin(&mut self, wire: &mut dyn Wire) -> anyhow::Result<()> {
        self.started = Instant::now();
        let setup = self.setup;
        self.send(wire, &setup)
    }

    /// One tick of the world and its controller; `false` once the mission is over and the object has come to rest.
    ///
    /// # Errors
    /// The simulation broke down, the bus did, or `observer` cannot go on.
    pub fn tick(&mut self, wire: &mut dyn Wire, observer: &mut dyn Observer) -> anyhow::Result<bool> {
        let tick = self.end.ticks;
        // What takes effect at a tick must have arrived before that tick's readings.
        wire.settle();
        let due = self.started + TICK * (tick + 1);
        let mut heard = Heard::default();
        let mut lost = None;
        if self.end.lost.is_none() {
            heard = self.exchange(wire, tick, due)?;
            lost = self.end.lost;
        }
        self.take(&mut heard);
        let (world, setup) = (&self.world, &self.setup);
        observer.see(&Seen { tick, world, setup, heard: &heard, lost, wire: &*wire })?;
        self.call_again(wire, &heard, tick)?;
        self.left = match self.left {
            None if self.end.lost.is_some() => Some(ABANDONED_TICKS),
            None if self.end.outcome.is_some() => Some(REST_TICKS),
            Some(0) => return Ok(false),
            left => left.map(|left| left - 1),
        };
        self.advise(wire, &heard, tick)?;
        let commands = self.drives.follow(heard.command, tick);
        if self.drives.has_let_go() {
            self.end.released.get_or_insert(tick);
        }
        if self.pace == Pace::Realtime {
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
        self.world.tick(&commands)?;
        self.end.ticks = tick + 1;
        Ok(self.end.ticks < TICKS_MAX)
    }

    /// What the mission came to, after its last tick.
    pub fn finish(&mut self, wire: &mut dyn Wire) -> HostEnd {
        wire.settle();
        self.end.wire = wire.stats();
        self.end.deadline_misses = self.drives.missed_in_all;
        self.end.clone()
    }

    /// What the mission has come to so far.
    pub fn so_far(&self) -> &HostEnd {
        &self.end
    }

    /// One tick's readings to the controller, what it says back to here.
    fn exchange(&mut self, wire: &mut dyn Wire, tick: u32, due: Instant) -> anyhow::Result<Heard> {
        if let Some(image) = self.world.tactile() {
            // Where the wire sends by priority, it follows the readings of this tick: it takes effect at the next.
            self.send(wire, &TactileSlice::pack(&image, tick + 1))?;
        }
        if self.ideal_sensors {
            self.send(wire, &LinkContact::pack(self.world.link_contacts(), tick, tick + 1))?;
        }
        let frame = SensorFrame::pack(&self.world.readings());
        self.send(wire, &frame)?;
        wire.begin_period(tick);
        let mut heard = Heard::default();
        let asked = Instant::now();
        loop {
            let until = match self.pace {
                Pace::Realtime => due,
                Pace::Lockstep => Instant::now() + wire.patience() / REPEATS,
            };
            let answered = wire.answer(tick, until, &mut |frame| self.post.hear(frame, tick, &mut heard))?;
            if answered.complete || self.pace == Pace::Realtime || asked.elapsed() >= wire.patience() {
                self.time(answered.took);
                break;
            }
            // Readings or command were lost on the way: the controller answers the same again.
            self.send(wire, &frame)?;
        }
        let waited_in_vain = heard.command.is_none() && asked.elapsed() >= wire.patience();
        let silent_for = TICK * self.drives.missed;
        if !wire.patience().is_zero() && (waited_in_vain || silent_for >= wire.patience()) {
            self.end.lost = Some(Lost { tick: tick - self.drives.missed, phase: self.phase });
        }
        Ok(heard)
    }

    fn time(&mut self, took: Duration) {
        self.end.answer_times_us.push(took.as_secs_f32() * 1e6);
        if self.phase == Phase::Update {
            self.updating_s += took.as_secs_f64();
        }
    }

    /// Keeps what the controller told of itself; ends that repeat are dropped.
    fn take(&mut self, heard: &mut Heard) {
        let digest = heard.digest;
        heard.events.retain(|event| {
            let repeats = matches!(event.kind, EventKind::Finished(_)) && self.end.outcome.is_some();
            if !repeats {
                self.note(event, digest);
            }
            !repeats
        });
    }

    /// A controller that has not begun its mission has not got its set-up: here it is again.
    fn call_again(&mut self, wire: &mut dyn Wire, heard: &Heard, tick: u32) -> anyhow::Result<()> {
        let idle = heard.status.is_some_and(|status| status.phase == Phase::Initialise);
        if idle && tick >= SETUP_TICKS && self.setups < SETUPS_MAX {
            self.setups += 1;
            let setup = self.setup;
            self.send(wire, &setup)?;
        }
        Ok(())
    }

    /// Answers questions: in lockstep before the next tick, else when the answer is ready.
    fn advise(&mut self, wire: &mut dyn Wire, heard: &Heard, tick: u32) -> anyhow::Result<()> {
        let questions = heard.plan.map(Question::Plan).into_iter().chain(heard.rollout.map(Question::Rollout));
        questions.for_each(|question| self.desk.ask(question));
        match self.pace {
            Pace::Lockstep => {
                while self.desk.has_questions() {
                    let (desk, mut reply) = (&mut self.desk, None);
                    wire.busy(&mut || reply = desk.answer_now(tick + 1));
                    let Some(reply) = reply else { break };
                    self.reply(wire, &reply)?;
                }
            }
            Pace::Realtime => {
                if let Some(reply) = self.desk.poll(tick + ANSWER_TICKS) {
                    self.reply(wire, &reply)?;
                }
            }
        }
        Ok(())
    }

    fn reply(&mut self, wire: &mut dyn Wire, reply: &Reply) -> anyhow::Result<()> {
        match reply {
            Reply::Plan(answer) => self.send(wire, answer.as_ref()),
            Reply::Rollout(result) => self.send(wire, result),
        }
    }

    /// Puts a message on the bus.
    fn send<M: Message>(&mut self, wire: &mut dyn Wire, message: &M) -> anyhow::Result<()> {
        self.post.send(message, wire.mtu(), |frame| wire.send(frame))
    }

    /// Keeps what the report needs.
    fn note(&mut self, event: &Event, digest: Option<DigestReport>) {
        match event.kind {
            EventKind::Touch { .. } => self.end.trials += 1,
            EventKind::Updated { belief, covariance, evaluations, .. } => {
                self.end.update_times_s.push(std::mem::take(&mut self.updating_s));
                self.end.evaluations += u32::from(evaluations);
                self.end.believed = belief;
                self.end.covariance = covariance;
                self.end.truth_then = planar(&self.world.object_pose());
            }
            EventKind::Finished(outcome) => {
                self.end.outcome = Some(outcome);
                self.end.digest = digest;
            }
            EventKind::Phase(phase) => self.phase = phase,
            EventKind::Contact { .. } | EventKind::Confirmed(_) | EventKind::Refused(_) | EventKind::Slip { .. } => {}
        }
    }
}
