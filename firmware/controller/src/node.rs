//! The controller as a node on a CAN bus: frames in, ticks, frames out. No clock, no socket, no heap.

use crate::controller::{Controller, Inputs, Outputs};
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, NodeId, Priority, Sender, Session, SubjectId, received_bytes};
use tactus_common::limits::{PADS, PAYLOAD_BYTES_MAX};
use tactus_common::link::{self, SMALL_BYTES};
use tactus_common::message::{
    Command, Digest, DigestReport, Event, Heartbeat, Message, Phase, PlanAnswer, PlanRequest, RolloutRequest,
    RolloutResult, SensorFrame, Setup, Status, TactileSlice, node,
};
use tactus_common::reading::TactileImage;

/// Ticks after which the transfer number of a periodic subject starts afresh: below 16 of its periods, so that a gap
/// never makes fresh transfers look old.
const PERIODIC_TIMEOUT_TICKS: u64 = 15;
/// The same for answers, which may take long: a full trajectory needs 0.1 s on an idle classic bus.
const ANSWER_TIMEOUT_TICKS: u64 = 500;
/// Ticks between two heartbeats: 1 Hz.
const HEARTBEAT_PERIOD_TICKS: u32 = 500;
const SMALL_RX_BYTES: usize = received_bytes(SMALL_BYTES, Mtu::Fd);
const LARGE_RX_BYTES: usize = received_bytes(PAYLOAD_BYTES_MAX, Mtu::Fd);

const fn subject<M: Message>() -> SubjectId {
    match SubjectId::new(M::SUBJECT) {
        Some(subject) => subject,
        None => panic!("a subject has 13 bits"),
    }
}

const fn id(value: u8) -> NodeId {
    match NodeId::new(value) {
        Some(id) => id,
        None => panic!("a node id has 7 bits"),
    }
}

fn priority<M: Message>() -> Priority {
    Priority::ALL.get(usize::from(M::PRIORITY)).copied().unwrap_or(Priority::Nominal)
}

/// Frames and messages that were no use, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NodeStats {
    /// Ids that are no message of this system.
    pub foreign_frames: u32,
    /// Frames that a session refused.
    pub bad_frames: u32,
    /// Whole transfers that did not decode.
    pub bad_payloads: u32,
    /// Transfers that came after the tick at which they should have taken effect.
    pub late: u32,
    /// Transfers that never arrived whole, as later ones of their subject show.
    pub missed: u32,
}

/// What waits for the tick at which it takes effect.
#[derive(Clone, Debug, Default)]
struct Pending {
    setup: Option<Setup>,
    images: [Option<(u32, TactileImage)>; PADS],
    plan: Option<PlanAnswer>,
    rollout: Option<RolloutResult>,
}

/// The controller with its end of the wire.
#[derive(Clone, Debug)]
pub struct Node {
    controller: Controller,
    mtu: Mtu,
    sender: Sender<7>,
    setup: Session<SMALL_RX_BYTES>,
    sensors: Session<SMALL_RX_BYTES>,
    tactile: Session<SMALL_RX_BYTES>,
    plan: Session<LARGE_RX_BYTES>,
    rollout: Session<SMALL_RX_BYTES>,
    pending: Pending,
    digest: Digest,
    ticks: u32,
    now: u32,
    /// Ticks since the start, missions before this one included: the time of the sessions, which must not run back.
    clock: u64,
    reported: bool,
    stats: NodeStats,
}

/// A session for the world's messages of one kind.
fn session<M: Message, const BYTES: usize>(timeout_ticks: u64) -> Session<BYTES> {
    Session::new(subject::<M>(), id(node::WORLD), timeout_ticks)
}

impl Node {
    /// A controller node that sends frames of this format; it receives both.
    pub fn new(mtu: Mtu) -> Self {
        Self {
            controller: Controller::default(),
            mtu,
            sender: Sender::new(
                id(node::CONTROLLER),
                [
                    subject::<Command>(),
                    subject::<PlanRequest>(),
                    subject::<RolloutRequest>(),
                    subject::<Status>(),
                    subject::<Event>(),
                    subject::<DigestReport>(),
                    subject::<Heartbeat>(),
                ],
            ),
            setup: session::<Setup, _>(ANSWER_TIMEOUT_TICKS),
            sensors: session::<SensorFrame, _>(PERIODIC_TIMEOUT_TICKS),
            tactile: session::<TactileSlice, _>(PERIODIC_TIMEOUT_TICKS),
            plan: session::<PlanAnswer, _>(ANSWER_TIMEOUT_TICKS),
            rollout: session::<RolloutResult, _>(ANSWER_TIMEOUT_TICKS),
            pending: Pending::default(),
            digest: Digest::default(),
            ticks: 0,
            now: 0,
            clock: 0,
            reported: false,
            stats: NodeStats::default(),
        }
    }

    /// The controller.
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// Digest of every input and output so far.
    pub fn digest(&self) -> Digest {
        self.digest
    }

    /// Counts of what was no use.
    pub fn stats(&self) -> NodeStats {
        let sessions =
            [self.setup.stats(), self.sensors.stats(), self.tactile.stats(), self.plan.stats(), self.rollout.stats()];
        let missed = sessions.iter().fold(0_u32, |sum, session| sum.saturating_add(session.missed));
        NodeStats { missed, ..self.stats }
    }

    /// Takes a frame from the bus. Where it completes a sensor message, the controller ticks and what it says is
    /// given to `send`, frame by frame. `true` if it ticked.
    pub fn receive(&mut self, frame: &CanFrame, send: &mut dyn FnMut(CanFrame)) -> bool {
        let Ok(header) = Header::of(frame) else {
            self.stats.foreign_frames = self.stats.foreign_frames.saturating_add(1);
            return false;
        };
        let readings = match self.accept(&header, frame.data()) {
            Ok(readings) => readings,
            Err(()) => return false,
        };
        let Some(sensors) = readings else { return false };
        let readings = sensors.unpack();
        // A second message for a tick that is over must not be taken for new.
        if self.ticks > 0 && readings.tick <= self.now {
            self.stats.late = self.stats.late.saturating_add(1);
            return false;
        }
        self.now = readings.tick;
        self.clock += 1;
        self.hash_inputs(&sensors);
        let pending = self.take_effective();
        let inputs = Inputs {
            setup: pending.setup.as_ref(),
            readings: Some(readings),
            images: pending.images.map(|i| i.map(|(_, image)| image)),
            plan: pending.plan.as_ref(),
            rollout: pending.rollout.as_ref(),
        };
        let outputs = self.controller.tick(self.now, &inputs);
        self.speak(&outputs, send);
        true
    }

    /// A tick for which no sensor message came: the caller's clock says that it is due.
    pub fn silent_tick(&mut self, send: &mut dyn FnMut(CanFrame)) {
        self.now = self.now.saturating_add(1);
        self.clock += 1;
        let outputs = self.controller.tick(self.now, &Inputs::default());
        self.speak(&outputs, send);
    }

    /// Puts a frame where it belongs; a sensor message is returned.
    fn accept(&mut self, header: &Header, data: &[u8]) -> Result<Option<SensorFrame>, ()> {
        let now = self.clock;
        let mut payload_ok = true;
        let mut sensors = None;
        macro_rules! take {
            ($session:ident, $type:ty, $use:expr) => {
                match self.$session.accept(header, data, now) {
                    Ok(Some(transfer)) => match link::decode::<$type>(transfer.payload) {
                        Ok(message) => $use(message),
                        Err(_) => payload_ok = false,
                    },
                    Ok(None) => {}
                    Err(_) => {
                        self.stats.bad_frames = self.stats.bad_frames.saturating_add(1);
                        return Err(());
                    }
                }
            };
        }
        take!(sensors, SensorFrame, |m| sensors = Some(m));
        take!(tactile, TactileSlice, |m: TactileSlice| match m.unpack() {
            Some(image) => {
                if let Some(slot) = self.pending.images.get_mut(usize::from(image.pad)) {
                    *slot = Some((m.effective(), image));
                }
            }
            None => payload_ok = false,
        });
        take!(setup, Setup, |m| {
            self.begin_afresh();
            self.pending.setup = Some(m);
        });
        take!(plan, PlanAnswer, |m| self.pending.plan = Some(m));
        take!(rollout, RolloutResult, |m| self.pending.rollout = Some(m));
        if !payload_ok {
            self.stats.bad_payloads = self.stats.bad_payloads.saturating_add(1);
            return Err(());
        }
        Ok(sensors)
    }

    /// A new mission, perhaps of a world that was started anew: its ticks and transfer numbers may begin at 0 again,
    /// and its digest is its own, whatever was before.
    fn begin_afresh(&mut self) {
        self.sensors = session::<SensorFrame, _>(PERIODIC_TIMEOUT_TICKS);
        self.tactile = session::<TactileSlice, _>(PERIODIC_TIMEOUT_TICKS);
        self.plan = session::<PlanAnswer, _>(ANSWER_TIMEOUT_TICKS);
        self.rollout = session::<RolloutResult, _>(ANSWER_TIMEOUT_TICKS);
        self.pending = Pending::default();
        self.digest = Digest::default();
        (self.ticks, self.now, self.reported) = (0, 0, false);
    }

    /// What takes effect at this tick, taken out of what waits, and hashed in order of subject.
    fn take_effective(&mut self) -> Pending {
        let now = self.now;
        let due = |effective: u32| effective <= now;
        let mut taken = Pending { setup: self.pending.setup.take(), ..Pending::default() };
        for (slot, out) in self.pending.images.iter_mut().zip(&mut taken.images) {
            if slot.is_some_and(|(effective, _)| due(effective)) {
                *out = slot.take();
            }
        }
        if self.pending.plan.as_ref().is_some_and(|p| due(p.effective)) {
            taken.plan = self.pending.plan.take();
        }
        if self.pending.rollout.as_ref().is_some_and(|r| due(r.effective)) {
            taken.rollout = self.pending.rollout.take();
        }
        self.count_late(&taken);
        if let Some(setup) = &taken.setup {
            self.hash(setup);
        }
        for (effective, image) in taken.images.iter().flatten() {
            self.hash(&TactileSlice::pack(image, *effective));
        }
        if let Some(plan) = &taken.plan {
            self.hash(plan);
        }
        if let Some(rollout) = &taken.rollout {
            self.hash(rollout);
        }
        taken
    }

    fn count_late(&mut self, taken: &Pending) {
        let plan = taken.plan.as_ref().map(|p| p.effective);
        let rollout = taken.rollout.as_ref().map(|r| r.effective);
        let images = taken.images.iter().flatten().map(|(effective, _)| *effective);
        let late = plan.into_iter().chain(rollout).chain(images).filter(|e| *e < self.now).count();
        self.stats.late = self.stats.late.saturating_add(late as u32);
    }

    fn hash_inputs(&mut self, sensors: &SensorFrame) {
        self.ticks = self.ticks.saturating_add(1);
        self.hash(sensors);
    }

    /// Adds a message to the digest.
    fn hash<M: Message>(&mut self, message: &M) {
        // Encoding into a digest cannot run out of room.
        let _ = link::digest(message, &mut self.digest);
    }

    /// Sends what a tick brought, in order of subject.
    fn speak(&mut self, outputs: &Outputs, send: &mut dyn FnMut(CanFrame)) {
        self.publish(&Command::pack(&outputs.commands), send);
        if let Some(request) = &outputs.plan_request {
            self.publish(request, send);
        }
        if let Some(request) = &outputs.rollout_request {
            self.publish(request, send);
        }
        if let Some(status) = &outputs.status {
            self.publish(status, send);
        }
        for event in &outputs.events {
            self.publish(event, send);
        }
        if !self.reported && self.controller.outcome().is_some() {
            self.reported = true;
            let report = DigestReport { ticks: self.ticks, digest: self.digest.0.to_le_bytes() };
            self.transmit(&report, send);
        }
        if self.now.is_multiple_of(HEARTBEAT_PERIOD_TICKS) {
            self.transmit(&self.heartbeat(), send);
        }
    }

    fn heartbeat(&self) -> Heartbeat {
        let phase = self.controller.phase();
        Heartbeat {
            uptime_s: (self.now / HEARTBEAT_PERIOD_TICKS).to_le_bytes(),
            health: if phase == Phase::Fault { 3 } else { 0 },
            mode: u8::from(phase == Phase::Initialise),
            vendor: phase as u8,
        }
    }

    /// Hashes and sends a message.
    fn publish<M: Message>(&mut self, message: &M, send: &mut dyn FnMut(CanFrame)) {
        self.hash(message);
        self.transmit(message, send);
    }

    /// Sends a message.
    fn transmit<M: Message>(&mut self, message: &M, send: &mut dyn FnMut(CanFrame)) {
        let mut buffer = [0; SMALL_BYTES];
        if let Ok(bytes) = link::encode(message, &mut buffer)
            && let Ok(frames) = self.sender.send(subject::<M>(), priority::<M>(), bytes, self.mtu)
        {
            frames.for_each(send);
        }
    }
}

#[cfg(test)]
mod tests;
