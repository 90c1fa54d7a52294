//! The controller's node with a wire in the test's hands.

use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, NodeId, Sender, Session};
use tactus_common::limits::PAYLOAD_BYTES_MAX;
use tactus_common::link::{self, CONTROLLER, SMALL_BYTES, WORLD, priority, subject};
use tactus_common::message::{
    Command, DigestReport, Event, EventKind, FaultReason, Message, Outcome, Phase, PlanAnswer, PlanRequest,
    RolloutRequest, RolloutResult, SensorFrame, Setup, Status, TactileSlice,
};
use tactus_common::reading::{HandCommand, JointCommands, JointReadings};
use tactus_common::robot::ARM_LIMITS;
use tactus_controller::node::Node;

/// Half a count of a torque on the wire, newton-metres.
const TORQUE_ROUNDING_NM: f32 = 1.0 / 512.0;

/// The identifier of a message from `source`.
pub fn header<M: Message>(source: NodeId) -> Header {
    Header { priority: priority::<M>(), subject: subject::<M>(), source }
}

/// What the world's end sends in one tick, in the order of sending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Told {
    /// A mission.
    pub setup: Option<Setup>,
    /// A planner's answer.
    pub plan: Option<PlanAnswer>,
    /// A rollout.
    pub rollout: Option<RolloutResult>,
    /// An image of a pad.
    pub image: Option<TactileSlice>,
    /// Joint readings: the controller ticks.
    pub sensors: Option<SensorFrame>,
}

/// What the controller said in answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Said {
    /// Joint commands.
    pub command: Option<JointCommands>,
    /// A question to the planner.
    pub plan: Option<PlanRequest>,
    /// A question to the mental world.
    pub rollout: Option<RolloutRequest>,
    /// Status.
    pub status: Option<Status>,
    /// What happened.
    pub events: Vec<Event>,
    /// The digest, once.
    pub digest: Option<DigestReport>,
}

impl Said {
    /// The joint commands, which answer every tick.
    ///
    /// # Panics
    /// If the controller did not tick.
    pub fn commands(&self) -> JointCommands {
        self.command.expect("the controller answers every tick")
    }

    /// The end of the mission, if it was announced.
    pub fn finished(&self) -> Option<Outcome> {
        self.events.iter().find_map(|event| match event.kind {
            EventKind::Finished(outcome) => Some(outcome),
            _ => None,
        })
    }

    /// The fault, if one was announced.
    pub fn fault(&self) -> Option<FaultReason> {
        match self.finished() {
            Some(Outcome::Fault(reason)) => Some(reason),
            _ => None,
        }
    }
}

/// The node and both ends of its wire. A clone goes its own way from there.
#[derive(Clone, Debug)]
pub struct Rig {
    /// The node under test.
    pub node: Node,
    sender: Sender<5>,
    command: Session<SMALL_BYTES>,
    plan: Session<SMALL_BYTES>,
    rollout: Session<SMALL_BYTES>,
    status: Session<SMALL_BYTES>,
    event: Session<SMALL_BYTES>,
    digest: Session<SMALL_BYTES>,
    /// The end that the node has told already; it repeats it.
    finished: Option<EventKind>,
    readings: Option<JointReadings>,
    tick: u32,
}

impl Default for Rig {
    fn default() -> Self {
        Self::new()
    }
}

impl Rig {
    /// A node that has just been switched on.
    pub fn new() -> Self {
        Self {
            node: Node::new(Mtu::Fd),
            sender: Sender::new(
                WORLD,
                [
                    subject::<Setup>(),
                    subject::<SensorFrame>(),
                    subject::<TactileSlice>(),
                    subject::<PlanAnswer>(),
                    subject::<RolloutResult>(),
                ],
            ),
            // The rig loses nothing, so nothing ever needs to be taken for new that looks old.
            command: Session::new(subject::<Command>(), CONTROLLER, 0),
            plan: Session::new(subject::<PlanRequest>(), CONTROLLER, 0),
            rollout: Session::new(subject::<RolloutRequest>(), CONTROLLER, 0),
            status: Session::new(subject::<Status>(), CONTROLLER, 0),
            event: Session::new(subject::<Event>(), CONTROLLER, 0),
            digest: Session::new(subject::<DigestReport>(), CONTROLLER, 0),
            finished: None,
            readings: None,
            tick: 0,
        }
    }

    /// Phase of the mission.
    pub fn phase(&self) -> Phase {
        self.node.controller().phase()
    }

    /// The tick of the newest readings or silence.
    pub fn tick(&self) -> u32 {
        self.tick
    }

    /// The newest readings.
    pub fn readings(&self) -> JointReadings {
        self.readings.expect("the rig has been told readings")
    }

    /// The frames of a message, with the next transfer number of its subject.
    pub fn frames<M: Message>(&mut self, message: &M) -> Vec<CanFrame> {
        let mut buffer = [0; PAYLOAD_BYTES_MAX];
        let bytes = link::encode(message, &mut buffer).expect("the largest message fits");
        let header = header::<M>(WORLD);
        self.sender.send(header.subject, header.priority, bytes, Mtu::Fd).expect("a subject of the world").collect()
    }

    /// Sends a message.
    pub fn send<M: Message>(&mut self, message: &M) -> Said {
        let frames = self.frames(message);
        self.deliver(&frames)
    }

    /// Puts frames on the wire as they are; what the controller says in answer.
    pub fn deliver(&mut self, frames: &[CanFrame]) -> Said {
        let mut said = Vec::new();
        for frame in frames {
            self.node.receive(frame, &mut |frame| said.push(frame));
        }
        self.hear(&said)
    }

    /// The frames of one tick.
    pub fn frames_of(&mut self, told: &Told) -> Vec<CanFrame> {
        let mut frames = Vec::new();
        told.setup.iter().for_each(|m| frames.extend(self.frames(m)));
        told.plan.iter().for_each(|m| frames.extend(self.frames(m)));
        told.rollout.iter().for_each(|m| frames.extend(self.frames(m)));
        told.image.iter().for_each(|m| frames.extend(self.frames(m)));
        told.sensors.iter().for_each(|m| frames.extend(self.frames(m)));
        frames
    }

    /// One tick of a mission.
    pub fn tell(&mut self, told: &Told) -> Said {
        let frames = self.frames_of(told);
        if told.setup.is_some() {
            self.finished = None;
        }
        if let Some(sensors) = &told.sensors {
            let readings = sensors.unpack();
            self.tick = readings.tick;
            self.readings = Some(readings);
        }
        self.deliver(&frames)
    }

    /// The next tick with the newest readings, changed by `change`.
    pub fn sense(&mut self, change: impl FnOnce(&mut JointReadings)) -> Said {
        let mut readings = self.readings();
        readings.tick = self.tick + 1;
        let kept = readings;
        change(&mut readings);
        let said = self.tell(&Told { sensors: Some(SensorFrame::pack(&readings)), ..Told::default() });
        // What was changed is a lie about one tick; the robot stands where it stood.
        self.readings = Some(kept);
        said
    }

    /// A period in which no sensor message came.
    pub fn silence(&mut self) -> Said {
        self.tick += 1;
        let mut said = Vec::new();
        self.node.silent_tick(&mut |frame| said.push(frame));
        self.hear(&said)
    }

    /// Reads what the controller said, and sees that no command is beyond the robot's limits.
    fn hear(&mut self, frames: &[CanFrame]) -> Said {
        let mut said = Said::default();
        let now = u64::from(self.tick);
        for frame in frames {
            let header = Header::parse(frame.id()).expect("the controller sends messages");
            let data = frame.data();
            if let Ok(Some(t)) = self.command.accept(&header, data, now) {
                let command: Command = link::decode(t.payload).expect("a command");
                said.command = command.unpack();
                check_command(&said.command.expect("hand modes that exist"));
            }
            if let Ok(Some(t)) = self.plan.accept(&header, data, now) {
                said.plan = Some(link::decode(t.payload).expect("a plan request"));
            }
            if let Ok(Some(t)) = self.rollout.accept(&header, data, now) {
                said.rollout = Some(link::decode(t.payload).expect("a rollout request"));
            }
            if let Ok(Some(t)) = self.status.accept(&header, data, now) {
                said.status = Some(link::decode(t.payload).expect("a status"));
            }
            if let Ok(Some(t)) = self.event.accept(&header, data, now) {
                let event: Event = link::decode(t.payload).expect("an event");
                let is_end = matches!(event.kind, EventKind::Finished(_));
                if !is_end || self.finished != Some(event.kind) {
                    said.events.push(event);
                }
                if is_end {
                    self.finished = Some(event.kind);
                }
            }
            if let Ok(Some(t)) = self.digest.accept(&header, data, now) {
                said.digest = Some(link::decode(t.payload).expect("a digest"));
            }
        }
        said
    }
}

/// Torques stay within the joints' limits, whatever happened.
fn check_command(command: &JointCommands) {
    for (joint, (tau_nm, limit)) in command.arm_tau_nm.iter().zip(&ARM_LIMITS).enumerate() {
        assert!(
            tau_nm.abs() <= limit.torque_nm + TORQUE_ROUNDING_NM,
            "tick {}: {tau_nm} Nm on J{} (limit {})",
            command.tick,
            joint + 1,
            limit.torque_nm
        );
    }
}

/// Is this the safe state without angles: no torque, hand idle?
pub fn is_limp(command: &JointCommands) -> bool {
    *command == JointCommands::idle(command.tick)
}

/// Is this the safe state with angles: the hand stands, or goes on pressing what it holds, while the arm is held?
pub fn is_hold(command: &JointCommands) -> bool {
    let still = |motor: &HandCommand| matches!(motor, HandCommand::Torque(_)) || *motor == HandCommand::Velocity(0.0);
    command.hand.iter().all(still) && command.arm_tau_nm.iter().any(|tau_nm| *tau_nm != 0.0)
}
