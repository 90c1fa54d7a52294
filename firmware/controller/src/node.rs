//! The controller as a node on a CAN bus: frames in, ticks, frames out. No clock, no socket, no heap.

mod pending;

use crate::controller::{Controller, Inputs, Outputs};
use pending::Pending;
use tactus_common::can::{CanFrame, Mtu};
use tactus_common::cyphal::{Header, Sender, Session, received_bytes};
use tactus_common::limits::{OBSTACLES_MAX, PAYLOAD_BYTES_MAX};
use tactus_common::link::{self, CONTROLLER, SETUP_BYTES, SMALL_BYTES, WORLD, priority, subject};
use tactus_common::message::{
    Command, Digest, DigestReport, Event, EventKind, Heartbeat, Hello, LinkContact, Message, Phase, PlanAnswer,
    PlanRequest, RolloutRequest, RolloutResult, SCHEMA_VERSION, SensorFrame, Setup, Status, TactileSlice,
};
use tactus_common::method::Method;
use tactus_common::pose::{Interval, PlanarPose};
use tactus_common::shape::ObjectShape;

/// Ticks after which the transfer number of a periodic subject starts afresh: below 16 of its periods, so that a gap
/// never makes fresh transfers look old.
const PERIODIC_TIMEOUT_TICKS: u64 = 15;
/// The same for answers, which may take long: a full trajectory needs 0.1 s on an idle classic bus.
const ANSWER_TIMEOUT_TICKS: u64 = 500;
/// Ticks between two heartbeats: 1 Hz.
const HEARTBEAT_PERIOD_TICKS: u32 = 500;
/// Ticks after which the end of a mission is told again, for a world that has missed it: 10 Hz.
const END_PERIOD_TICKS: u32 = 50;
/// How far from the present tick a transfer's tick may lie, 2 s. What names another tick is not of this mission: a frame
/// of somebody else under one of our identifiers, most likely.
const REACH_TICKS: u32 = 1_000;
const SMALL_RX_BYTES: usize = received_bytes(SMALL_BYTES, Mtu::Fd);
const SETUP_RX_BYTES: usize = received_bytes(SETUP_BYTES, Mtu::Fd);
const LINK_RX_BYTES: usize = received_bytes(LinkContact::WIRE_LEN, Mtu::Fd);
const LARGE_RX_BYTES: usize = received_bytes(PAYLOAD_BYTES_MAX, Mtu::Fd);

/// Frames and messages that were no use, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NodeStats {
    /// Ids that are no message of this system.
    pub foreign_frames: u32,
    /// Frames that a session refused.
    pub bad_frames: u32,
    /// Whole transfers that did not decode.
    pub bad_payloads: u32,
    /// Transfers whose tick lies too far from the present one, and set-ups of another version during a mission.
    pub implausible: u32,
    /// Transfers that came after the tick at which they should have taken effect.
    pub late: u32,
    /// Transfers that never arrived whole, as later ones of their subject show.
    pub missed: u32,
    /// Frames that bear this node's own id: another node of that id is on the bus.
    pub twins: u32,
}

/// What became of a frame that belongs to one of our subjects.
enum Verdict {
    /// It is part of a transfer, or completed one that is of use.
    Used,
    /// The session refused it.
    BadFrame,
    /// It completed a transfer that does not decode.
    BadPayload,
    /// It completed a transfer that cannot be meant for the mission under way.
    Implausible,
}

impl NodeStats {
    fn count(&mut self, verdict: &Verdict) {
        let counter = match verdict {
            Verdict::Used => return,
            Verdict::BadFrame => &mut self.bad_frames,
            Verdict::BadPayload => &mut self.bad_payloads,
            Verdict::Implausible => &mut self.implausible,
        };
        *counter = counter.saturating_add(1);
    }
}

/// How a mission ended: what is told again and again, unhashed.
#[derive(Clone, Copy, Debug)]
struct End {
    event: Event,
    report: DigestReport,
}

/// The controller with its end of the wire.
#[derive(Clone, Debug)]
pub struct Node {
    controller: Controller,
    mtu: Mtu,
    sender: Sender<8>,
    setup: Session<SETUP_RX_BYTES>,
    sensors: Session<SMALL_RX_BYTES>,
    tactile: Session<SMALL_RX_BYTES>,
    links: Session<LINK_RX_BYTES>,
    plan: Session<LARGE_RX_BYTES>,
    rollout: Session<SMALL_RX_BYTES>,
    pending: Pending,
    digest: Digest,
    ticks: u32,
    now: u32,
    /// Ticks since the start, missions before this one included: the time of the sessions, which must not run back.
    clock: u64,
    end: Option<End>,
    /// The answer to the last sensor message, for a world that has missed it.
    answer: Option<Command>,
    foreign_version: Option<u64>,
    stats: NodeStats,
}

/// A session for the world's messages of one kind.
fn session<M: Message, const BYTES: usize>(timeout_ticks: u64) -> Session<BYTES> {
    Session::new(subject::<M>(), WORLD, timeout_ticks)
}

impl Node {
    /// A controller node that sends frames of this format; it receives both.
    pub fn new(mtu: Mtu) -> Self {
        Self {
            controller: Controller::default(),
            mtu,
            sender: Sender::new(
                CONTROLLER,
                [
                    subject::<Command>(),
                    subject::<PlanRequest>(),
                    subject::<RolloutRequest>(),
                    subject::<Status>(),
                    subject::<Event>(),
                    subject::<DigestReport>(),
                    subject::<Hello>(),
                    subject::<Heartbeat>(),
                ],
            ),
            setup: session::<Setup, _>(ANSWER_TIMEOUT_TICKS),
            sensors: session::<SensorFrame, _>(PERIODIC_TIMEOUT_TICKS),
            tactile: session::<TactileSlice, _>(PERIODIC_TIMEOUT_TICKS),
            links: session::<LinkContact, _>(PERIODIC_TIMEOUT_TICKS),
            plan: session::<PlanAnswer, _>(ANSWER_TIMEOUT_TICKS),
            rollout: session::<RolloutResult, _>(ANSWER_TIMEOUT_TICKS),
            pending: Pending::default(),
            digest: Digest::default(),
            ticks: 0,
            now: 0,
            clock: 0,
            end: None,
            answer: None,
            foreign_version: None,
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
        let sessions = [
            self.setup.stats(),
            self.sensors.stats(),
            self.tactile.stats(),
            self.links.stats(),
            self.plan.stats(),
            self.rollout.stats(),
        ];
        let missed = sessions.iter().fold(0_u32, |sum, session| sum.saturating_add(session.missed));
        NodeStats { missed, ..self.stats }
    }

    /// No mission is under way: none has begun, or it has ended.
    pub fn is_free(&self) -> bool {
        self.ticks == 0 || self.end.is_some()
    }

    /// The end of the mission, as it was reported to the world: how, after how many ticks, with which digest.
    pub fn end(&self) -> Option<(EventKind, DigestReport)> {
        self.end.map(|end| (end.event.kind, end.report))
    }

    /// Schema version of the last set-up, if it was another than ours.
    pub fn foreign_version(&self) -> Option<u64> {
        self.foreign_version
    }

    /// Says that this node is on the bus, and no more: a node of the same id will answer.
    pub fn beat(&mut self, uptime_s: u32, send: &mut dyn FnMut(CanFrame)) {
        self.transmit(&self.heartbeat(uptime_s), send);
    }

    /// Says that this node is there and ready for a mission, with its version; for once a second of the caller's clock
    /// while no mission is under way. `uptime_s`: seconds since the caller's start.
    pub fn announce(&mut self, uptime_s: u32, send: &mut dyn FnMut(CanFrame)) {
        self.beat(uptime_s, send);
        self.transmit(&Hello { schema_version: SCHEMA_VERSION.to_le_bytes() }, send);
    }

    /// The world has been silent for longer than any of its transfers may take: whatever comes next is new.
    pub fn forget_world(&mut self) {
        self.setup.forget();
        self.forget_transfers();
    }

    /// Takes a frame from the bus. Where it completes a sensor message, the controller ticks and what it says is
    /// given to `send`, frame by frame. `true` if it ticked. A function of its own, so that its stack is not that of the caller's
    /// start as well.
    #[inline(never)]
    pub fn receive(&mut self, frame: &CanFrame, send: &mut dyn FnMut(CanFrame)) -> bool {
        let Ok(header) = Header::of(frame) else {
            self.stats.foreign_frames = self.stats.foreign_frames.saturating_add(1);
            return false;
        };
        if header.source == CONTROLLER {
            self.stats.twins = self.stats.twins.saturating_add(1);
            return false;
        }
        let Some(sensors) = self.accept(&header, frame.data()) else { return false };
        let readings = sensors.unpack();
        // A second message for a tick that is over must not be taken for new; but who asks again about the last one has
        // missed the answer.
        if self.ticks > 0 && readings.tick <= self.now {
            self.stats.late = self.stats.late.saturating_add(1);
            if let Some(answer) = self.answer.filter(|_| readings.tick == self.now) {
                self.transmit(&answer, send);
            }
            return false;
        }
        if !is_near(readings.tick, self.now) {
            self.stats.count(&Verdict::Implausible);
            return false;
        }
        self.now = readings.tick;
        self.clock += 1;
        self.ticks = self.ticks.saturating_add(1);
        self.hash(&sensors);
        let due = self.pending.due(self.now);
        due.hash(&mut self.digest);
        self.stats.late = self.stats.late.saturating_add(due.late(self.now));
        let inputs = Inputs {
            setup: due.setup,
            readings: Some(readings),
            images: due.images.map(|image| image.map(|(_, image)| *image)),
            links: due.links(),
            plan: due.plan,
            rollout: due.rollout,
        };
        let outputs = self.controller.tick(self.now, &inputs);
        self.pending.forget_until(self.now);
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

    /// Puts a frame where it belongs; a sensor message is returned. A function of its own, so that the stack which it takes
    /// to decode a set-up is free again before the tick.
    #[inline(never)]
    fn accept(&mut self, header: &Header, data: &[u8]) -> Option<SensorFrame> {
        let (clock, tick) = (self.clock, self.now);
        let mut sensors = None;
        macro_rules! take {
            ($session:ident, $payload:ident => $verdict:expr) => {
                let verdict = match self.$session.accept(header, data, clock) {
                    Ok(Some(transfer)) => {
                        let $payload = transfer.payload;
                        $verdict
                    }
                    Ok(None) => Verdict::Used,
                    Err(_) => Verdict::BadFrame,
                };
                self.stats.count(&verdict);
            };
        }
        take!(sensors, payload => match link::decode(payload) {
            Ok(frame) => {
                sensors = Some(frame);
                Verdict::Used
            }
            Err(_) => Verdict::BadPayload,
        });
        take!(tactile, payload => match link::decode::<TactileSlice>(payload).map(|m| (m.effective(), m.unpack())) {
            Ok((effective, Some(image))) if is_near(effective, tick) => {
                if let Some(slot) = self.pending.images.get_mut(usize::from(image.pad)) {
                    *slot = Some((effective, image));
                }
                Verdict::Used
            }
            Ok((_, Some(_))) => Verdict::Implausible,
            Ok((_, None)) | Err(_) => Verdict::BadPayload,
        });
        take!(links, payload => match link::decode::<LinkContact>(payload) {
            Ok(links) if is_near(links.effective(), tick) => {
                self.pending.put_links(links);
                Verdict::Used
            }
            Ok(_) => Verdict::Implausible,
            Err(_) => Verdict::BadPayload,
        });
        take!(setup, payload => match setup_of(payload) {
            Some((_, Some(_))) if !self.is_free() => Verdict::Implausible,
            Some((setup, foreign_version)) => {
                self.foreign_version = foreign_version;
                self.begin_afresh();
                self.pending.setup = Some(setup);
                Verdict::Used
            }
            None => Verdict::BadPayload,
        });
        // A set-up counts whatever its number: its sender may have been started anew, and a number that noise has left
        // must not make it look old. One that comes twice is no harm: during a mission none is taken.
        self.setup.forget_last();
        take!(plan, payload => match PlanAnswer::effective_of(payload) {
            Ok(effective) if !is_near(effective, tick) => Verdict::Implausible,
            Ok(_) => match PlanAnswer::decode_into(payload, &mut self.pending.plan) {
                Ok(()) => Verdict::Used,
                Err(_) => Verdict::BadPayload,
            },
            Err(_) => Verdict::BadPayload,
        });
        take!(rollout, payload => match link::decode::<RolloutResult>(payload) {
            Ok(result) if is_near(result.effective, tick) => {
                self.pending.rollout = Some(result);
                Verdict::Used
            }
            Ok(_) => Verdict::Implausible,
            Err(_) => Verdict::BadPayload,
        });
        sensors
    }

    /// A new mission, perhaps of a world that was started anew: its ticks and transfer numbers may begin at 0 again,
    /// and its digest is its own, whatever was before.
    fn begin_afresh(&mut self) {
        self.forget_transfers();
        self.digest = Digest::default();
        (self.ticks, self.now, self.end, self.answer) = (0, 0, None, None);
    }

    /// Transfers under way, numbers of those before, and what waits for its tick, all but the set-up's.
    fn forget_transfers(&mut self) {
        self.sensors.forget();
        self.tactile.forget();
        self.links.forget();
        self.plan.forget();
        self.rollout.forget();
        self.pending.forget();
    }

    /// Adds a message to the digest.
    fn hash<M: Message>(&mut self, message: &M) {
        // Encoding into a digest cannot run out of room.
        let _ = link::digest(message, &mut self.digest);
    }

    /// Hashes what a tick brought in order of subject. The command leaves last: who has it has everything of its tick.
    fn speak(&mut self, outputs: &Outputs, send: &mut dyn FnMut(CanFrame)) {
        let command = Command::pack(&outputs.commands);
        self.hash(&command);
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
        self.report_end(outputs, send);
        if self.now.is_multiple_of(HEARTBEAT_PERIOD_TICKS) {
            self.transmit(&self.heartbeat(self.now / HEARTBEAT_PERIOD_TICKS), send);
        }
        self.answer = Some(command);
        self.transmit(&command, send);
    }

    /// The digest at the end of the mission; from then on, end and digest again at their period.
    fn report_end(&mut self, outputs: &Outputs, send: &mut dyn FnMut(CanFrame)) {
        let finished = outputs.events.iter().find(|event| matches!(event.kind, EventKind::Finished(_)));
        match (&mut self.end, finished) {
            (None, Some(event)) => {
                let report = DigestReport { ticks: self.ticks, digest: self.digest.0.to_le_bytes() };
                self.end = Some(End { event: *event, report });
                self.transmit(&report, send);
            }
            // A fault after the end; the digest is that of the mission.
            (Some(end), Some(event)) => end.event = *event,
            (Some(End { event, report }), None) if self.now.is_multiple_of(END_PERIOD_TICKS) => {
                let (event, report) = (Event { tick: self.now, ..*event }, *report);
                self.transmit(&event, send);
                self.transmit(&report, send);
            }
            (_, None) => {}
        }
    }

    fn heartbeat(&self, uptime_s: u32) -> Heartbeat {
        let phase = self.controller.phase();
        Heartbeat {
            uptime_s: uptime_s.to_le_bytes(),
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

/// Can a transfer that names tick `tick` be meant for the mission under way, which is at tick `now`?
fn is_near(tick: u32, now: u32) -> bool {
    tick.abs_diff(now) <= REACH_TICKS
}

/// A set-up, with its schema version if that is not ours: then nothing else in it can be relied upon, and what stands
/// for it holds the version alone. `None` for bytes that are no set-up of any version.
fn setup_of(payload: &[u8]) -> Option<(Setup, Option<u64>)> {
    let schema_version = *payload.first_chunk::<8>()?;
    let version = u64::from_le_bytes(schema_version);
    if version == SCHEMA_VERSION {
        return link::decode(payload).ok().map(|setup| (setup, None));
    }
    let setup = Setup {
        schema_version,
        shape: ObjectShape::Cuboid { half_extents_m: [0.0; 3] },
        guess: PlanarPose::default(),
        interval: Interval::default(),
        obstacles: [None; OBSTACLES_MAX],
        displacement_m: [0.0; 2],
        mass_kg: 0.0,
        trials_max: 0,
        robot_base: PlanarPose::default(),
        method: Method::DEFAULT,
    };
    Some((setup, Some(version)))
}

#[cfg(test)]
mod tests;
