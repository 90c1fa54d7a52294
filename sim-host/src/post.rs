//! The world's messages: what it sends, cut into frames, and what it hears, put together from frames.

use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, Sender, Session, received_bytes};
use tactus_common::limits::PAYLOAD_BYTES_MAX;
use tactus_common::link::{self, CONTROLLER, SMALL_BYTES, WORLD, priority, subject};
use tactus_common::message::{
    Command, DigestReport, Event, LinkContact, Message, PlanAnswer, PlanRequest, RolloutRequest, RolloutResult,
    SensorFrame, Setup, Status, TactileSlice,
};
use tactus_common::reading::JointCommands;

const SMALL_RX_BYTES: usize = received_bytes(SMALL_BYTES, Mtu::Fd);
/// Ticks after which the transfer number of a message of every tick starts afresh, as in the controller's node.
const PERIODIC_TIMEOUT_TICKS: u64 = 15;
/// The same for a message of every 50 ticks.
const STATUS_TIMEOUT_TICKS: u64 = 500;

/// What came from the controller in answer to one tick.
#[derive(Clone, Debug, Default)]
pub struct Heard {
    /// The command for the tick.
    pub command: Option<JointCommands>,
    /// A question to the planner.
    pub plan: Option<PlanRequest>,
    /// A question to the mental world.
    pub rollout: Option<RolloutRequest>,
    /// What happened.
    pub events: Vec<Event>,
    /// What the controller thinks.
    pub status: Option<Status>,
    /// The digest, with the end of the mission.
    pub digest: Option<DigestReport>,
}

/// The world's end of the transport.
pub struct Post {
    sender: Sender<6>,
    command: Session<SMALL_RX_BYTES>,
    plan: Session<SMALL_RX_BYTES>,
    rollout: Session<SMALL_RX_BYTES>,
    event: Session<SMALL_RX_BYTES>,
    status: Session<SMALL_RX_BYTES>,
    digest: Session<SMALL_RX_BYTES>,
}

impl Default for Post {
    fn default() -> Self {
        Self {
            sender: Sender::new(
                WORLD,
                [
                    subject::<Setup>(),
                    subject::<SensorFrame>(),
                    subject::<TactileSlice>(),
                    subject::<LinkContact>(),
                    subject::<PlanAnswer>(),
                    subject::<RolloutResult>(),
                ],
            ),
            command: Session::new(subject::<Command>(), CONTROLLER, PERIODIC_TIMEOUT_TICKS),
            plan: Session::new(subject::<PlanRequest>(), CONTROLLER, PERIODIC_TIMEOUT_TICKS),
            rollout: Session::new(subject::<RolloutRequest>(), CONTROLLER, PERIODIC_TIMEOUT_TICKS),
            event: Session::new(subject::<Event>(), CONTROLLER, 1),
            status: Session::new(subject::<Status>(), CONTROLLER, STATUS_TIMEOUT_TICKS),
            digest: Session::new(subject::<DigestReport>(), CONTROLLER, STATUS_TIMEOUT_TICKS),
        }
    }
}

impl Post {
    /// Gives the frames of a message to `send`, in their order.
    ///
    /// # Errors
    /// The message has no place on the wire, or `send` fails.
    pub fn send<M: Message>(
        &mut self,
        message: &M,
        mtu: Mtu,
        mut send: impl FnMut(CanFrame) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let mut buffer = [0; PAYLOAD_BYTES_MAX];
        let bytes = link::encode(message, &mut buffer)?;
        self.sender.send(subject::<M>(), priority::<M>(), bytes, mtu)?.try_for_each(&mut send)
    }

    /// Takes a frame of the controller's that came during `tick`. `true` once the command for that tick is there: the
    /// last that a tick brings. What does not decode, or is of another tick, is as good as not sent: the drives and the
    /// controller's own time limits see to it.
    pub fn hear(&mut self, frame: &CanFrame, tick: u32, heard: &mut Heard) -> bool {
        let Ok(header) = Header::of(frame) else { return false };
        let (data, now) = (frame.data(), u64::from(tick));
        if let Ok(Some(t)) = self.command.accept(&header, data, now)
            && let Some(command) = link::decode::<Command>(t.payload).ok().and_then(|c| c.unpack())
            && command.tick == tick
        {
            heard.command = Some(command);
            return true;
        }
        if let Ok(Some(t)) = self.plan.accept(&header, data, now) {
            heard.plan = link::decode(t.payload).ok();
        }
        if let Ok(Some(t)) = self.rollout.accept(&header, data, now) {
            heard.rollout = link::decode(t.payload).ok();
        }
        if let Ok(Some(t)) = self.status.accept(&header, data, now) {
            heard.status = link::decode(t.payload).ok().filter(|status: &Status| status.tick == tick);
        }
        if let Ok(Some(t)) = self.event.accept(&header, data, now) {
            heard.events.extend(link::decode::<Event>(t.payload).ok().filter(|event| event.tick == tick));
        }
        if let Ok(Some(t)) = self.digest.accept(&header, data, now) {
            heard.digest = link::decode(t.payload).ok();
        }
        false
    }
}
