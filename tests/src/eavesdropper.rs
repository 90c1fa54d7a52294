//! Someone who only listens: puts the messages of both ends together from their frames, and computes the digest of the
//! mission from them, as `docs/protocol.md` defines it, without any code of the node.

use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, NodeId, Session, received_bytes};
use tactus_common::limits::{PADS, PAYLOAD_BYTES_MAX};
use tactus_common::link::{self, CONTROLLER, SETUP_BYTES, SMALL_BYTES, WORLD, subject};
use tactus_common::message::{
    Command, Digest, DigestReport, Event, EventKind, Hello, Message, Outcome, Phase, PlanAnswer, PlanRequest,
    RolloutRequest, RolloutResult, SensorFrame, Setup, Status, TactileSlice,
};

const SMALL: usize = received_bytes(SMALL_BYTES, Mtu::Fd);
const LARGE: usize = received_bytes(PAYLOAD_BYTES_MAX, Mtu::Fd);

/// The listener's time is the count of frames. The longest transfer has 606 of CAN 2.0; a node that was started anew needs
/// longer than this.
const TIMEOUT_FRAMES: u64 = 1_000;

/// What was overheard of a mission.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Overheard {
    /// Digest of the mission from its messages.
    pub digest: u64,
    /// Ticks that it covers.
    pub ticks: u32,
    /// What the controller reported.
    pub reported: Option<(u64, u32)>,
    /// Frames that no session could use, and messages that did not decode.
    pub bad: u32,
    /// Frames with identifiers of neither end.
    pub foreign: u32,
}

/// Listens to frames in the order of the wire.
pub struct Eavesdropper {
    setup: Session<{ received_bytes(SETUP_BYTES, Mtu::Fd) }>,
    sensors: Session<SMALL>,
    tactile: Session<SMALL>,
    plan: Session<LARGE>,
    rollout: Session<SMALL>,
    command: Session<SMALL>,
    plan_request: Session<SMALL>,
    rollout_request: Session<SMALL>,
    status: Session<SMALL>,
    event: Session<SMALL>,
    report: Session<SMALL>,
    hello: Session<SMALL>,
    frames: u64,
    waiting: Waiting,
    tick: Option<u32>,
    /// The bytes of this tick's inputs, once it has begun.
    inputs: Vec<u8>,
    command_said: Option<Vec<u8>>,
    said: Vec<(u16, Vec<u8>)>,
    closed_with_the_end: bool,
    digest: Digest,
    finished: Option<Outcome>,
    phase: Option<Phase>,
    overheard: Overheard,
}

/// What the world has said that has not taken effect.
#[derive(Default)]
struct Waiting {
    setup: Option<Setup>,
    images: [Option<TactileSlice>; PADS],
    plan: Option<PlanAnswer>,
    rollout: Option<RolloutResult>,
}

fn from<M: Message, const BYTES: usize>(source: NodeId) -> Session<BYTES> {
    Session::new(subject::<M>(), source, TIMEOUT_FRAMES)
}

/// The bytes of a message.
fn bytes<M: Message>(message: &M) -> Vec<u8> {
    let mut buffer = vec![0; PAYLOAD_BYTES_MAX];
    link::encode(message, &mut buffer).expect("it was decoded from fewer bytes").to_vec()
}

impl Default for Eavesdropper {
    fn default() -> Self {
        Self {
            setup: from::<Setup, _>(WORLD),
            sensors: from::<SensorFrame, _>(WORLD),
            tactile: from::<TactileSlice, _>(WORLD),
            plan: from::<PlanAnswer, _>(WORLD),
            rollout: from::<RolloutResult, _>(WORLD),
            command: from::<Command, _>(CONTROLLER),
            plan_request: from::<PlanRequest, _>(CONTROLLER),
            rollout_request: from::<RolloutRequest, _>(CONTROLLER),
            status: from::<Status, _>(CONTROLLER),
            event: from::<Event, _>(CONTROLLER),
            report: from::<DigestReport, _>(CONTROLLER),
            hello: from::<Hello, _>(CONTROLLER),
            frames: 0,
            waiting: Waiting::default(),
            tick: None,
            inputs: Vec::new(),
            command_said: None,
            said: Vec::new(),
            closed_with_the_end: false,
            digest: Digest::default(),
            finished: None,
            phase: None,
            overheard: Overheard::default(),
        }
    }
}

impl Eavesdropper {
    /// Listens to all of these.
    pub fn listen(frames: &[CanFrame]) -> Overheard {
        let mut listener = Self::default();
        frames.iter().for_each(|frame| listener.hear(frame));
        listener.close();
        listener.overheard()
    }

    /// What was overheard so far.
    pub fn overheard(&self) -> Overheard {
        Overheard { digest: self.digest.0, ..self.overheard }
    }

    /// Phase of the mission, as last told.
    pub fn phase(&self) -> Option<Phase> {
        self.phase
    }

    /// Tick of the mission, as last told.
    pub fn tick(&self) -> Option<u32> {
        self.tick
    }

    /// How the mission ended.
    pub fn finished(&self) -> Option<Outcome> {
        self.finished
    }

    /// Hears one frame.
    pub fn hear(&mut self, frame: &CanFrame) {
        self.frames += 1;
        let Ok(header) = Header::of(frame) else {
            self.overheard.foreign += 1;
            return;
        };
        let (data, now) = (frame.data(), self.frames);
        macro_rules! heard {
            ($session:ident, $type:ty) => {
                match self.$session.accept(&header, data, now) {
                    Ok(Some(transfer)) => match link::decode::<$type>(transfer.payload) {
                        Ok(message) => Some(message),
                        Err(_) => {
                            self.overheard.bad += 1;
                            None
                        }
                    },
                    Ok(None) => None,
                    Err(_) => {
                        self.overheard.bad += 1;
                        None
                    }
                }
            };
        }
        if let Some(setup) = heard!(setup, Setup) {
            self.waiting = Waiting { setup: Some(setup), ..Waiting::default() };
            self.digest = Digest::default();
            (self.tick, self.finished, self.command_said, self.closed_with_the_end) = (None, None, None, false);
            (self.overheard.ticks, self.overheard.reported) = (0, None);
        }
        if let Some(image) = heard!(tactile, TactileSlice)
            && let Some(unpacked) = image.unpack()
        {
            self.waiting.images[usize::from(unpacked.pad)] = Some(image);
        }
        if let Some(plan) = heard!(plan, PlanAnswer) {
            self.waiting.plan = Some(plan);
        }
        if let Some(rollout) = heard!(rollout, RolloutResult) {
            self.waiting.rollout = Some(rollout);
        }
        if let Some(sensors) = heard!(sensors, SensorFrame) {
            self.begin(&sensors);
        }
        if let Some(request) = heard!(plan_request, PlanRequest) {
            self.said.push((PlanRequest::SUBJECT, bytes(&request)));
        }
        if let Some(request) = heard!(rollout_request, RolloutRequest) {
            self.said.push((RolloutRequest::SUBJECT, bytes(&request)));
        }
        if let Some(status) = heard!(status, Status) {
            self.phase = Some(status.phase);
            self.said.push((Status::SUBJECT, bytes(&status)));
        }
        if let Some(event) = heard!(event, Event) {
            match event.kind {
                EventKind::Finished(outcome) => self.finished = Some(outcome),
                EventKind::Phase(phase) => self.phase = Some(phase),
                _ => {}
            }
            self.said.push((Event::SUBJECT, bytes(&event)));
        }
        if let Some(report) = heard!(report, DigestReport) {
            self.overheard.reported = Some((u64::from_le_bytes(report.digest), report.ticks));
        }
        if let Some(command) = heard!(command, Command) {
            // Readings that were sent twice are answered twice, the second time perhaps after the next ones.
            if command.unpack().map(|command| command.tick) == self.tick {
                self.command_said.get_or_insert_with(|| bytes(&command));
            }
        }
        let _ = heard!(hello, Hello);
    }

    /// Readings of a new tick: what takes effect with them, in order of subject.
    fn begin(&mut self, sensors: &SensorFrame) {
        let tick = sensors.unpack().tick;
        // Asked once more about the same tick, the controller does not tick again.
        if self.tick == Some(tick) {
            return;
        }
        self.close();
        self.said.clear();
        self.tick = Some(tick);
        self.inputs = bytes(sensors);
        let waiting = &mut self.waiting;
        if let Some(setup) = waiting.setup.take() {
            self.inputs.extend(bytes(&setup));
        }
        for slot in &mut waiting.images {
            if let Some(image) = slot.take_if(|image| image.effective() <= tick) {
                self.inputs.extend(bytes(&image));
            }
        }
        if let Some(plan) = waiting.plan.take_if(|plan| plan.effective <= tick) {
            self.inputs.extend(bytes(&plan));
        }
        if let Some(rollout) = waiting.rollout.take_if(|rollout| rollout.effective <= tick) {
            self.inputs.extend(bytes(&rollout));
        }
    }

    /// All of a tick has been said: the command first, whenever it came, then the rest in order of subject.
    fn close(&mut self) {
        let Some(command) = self.command_said.take() else { return };
        if self.closed_with_the_end {
            return;
        }
        self.digest.update(&self.inputs);
        self.digest.update(&command);
        self.said.sort_by_key(|(subject, _)| *subject);
        self.said.iter().for_each(|(_, said)| self.digest.update(said));
        self.overheard.ticks += 1;
        self.closed_with_the_end = self.finished.is_some();
    }
}
