//! Watches a run and writes it.

use super::channel::Content;
use super::convert::{quaternion, timestamp, vector};
use super::sample::{
    BeliefError, Bus, Command, Contact, ControllerLost, End, Foretold, Joints, LinkContacts, LinkForces, ObjectTruth,
    Pad, Pads, PhaseBegun, Refusal, Slip, Status, Tactile, Touch, Update,
};
use super::settings::Settings;
use super::sink::Sink;
use super::{RESULT, RUN, SETTINGS, SUMMARY, scene};
use crate::method::Sensors;
use crate::mission::{MissionOptions, MissionReport, planar};
use crate::observer::{Observer, Seen};
use crate::report::progress::{describe, lost_text};
use crate::report::summary::Summary;
use crate::world::PAD_LINKS;
use crate::world::view::{Body, Kind};
use anyhow::Context;
use foxglove::messages::{FrameTransform, FrameTransforms, JointState, JointStates, Log, log};
use nalgebra::Isometry3;
use std::path::{Path, PathBuf};
use tactus_common::limits::PADS;
use tactus_common::message::{DigestReport, Event, EventKind, Outcome, SCHEMA_VERSION};
use tactus_common::pose::PlanarPose;

/// Ticks between two samples of what is written at 50 Hz.
const PICTURE_TICKS: u32 = 10;
/// Ticks between two samples of what is written at 10 Hz, besides what the controller says at its own times.
const SLOW_TICKS: u32 = 50;
/// Ticks after which all that was written so far is in the file: 1 s.
const FLUSH_TICKS: u32 = 500;
/// The arm's joints.
const ARM_JOINTS: [&str; 7] =
    ["wam_joint1", "wam_joint2", "wam_joint3", "wam_joint4", "wam_joint5", "wam_joint6", "wam_joint7"];
/// The fingers' inner joints.
const INNER_JOINTS: [&str; 3] = ["finger1_inner_joint", "finger2_inner_joint", "finger3_inner_joint"];
/// The joints that the spread motor moves.
const SPREAD_JOINTS: [&str; 2] = ["finger1_spread", "finger2_spread"];

/// Writes what it sees to a file.
pub struct Recorder {
    path: PathBuf,
    sink: Sink,
    /// Empty before the first tick.
    bodies: Vec<Body>,
    /// What the controller last said that it believes.
    believed: Option<PlanarPose>,
    /// The world tells which links touch.
    ideal_sensors: bool,
    /// Which did when that was last written.
    links: Option<u16>,
    /// Forces on the hand were shown last time.
    touched: bool,
    /// The last tick seen.
    tick: u32,
}

impl Recorder {
    /// A new recording of a mission that is about to begin.
    ///
    /// # Errors
    /// The file cannot be written; the message names it.
    pub fn create(path: &Path, options: &MissionOptions) -> anyhow::Result<Self> {
        let named = || format!("--record {}", path.display());
        let mut sink = Sink::create(path).with_context(named)?;
        begin(&mut sink, options).with_context(named)?;
        Ok(Self {
            path: path.to_owned(),
            sink,
            bodies: Vec::new(),
            believed: None,
            ideal_sensors: options.method.sensors == Sensors::Ideal,
            links: None,
            touched: false,
            tick: 0,
        })
    }

    /// Ends the recording with what the mission came to.
    ///
    /// # Errors
    /// The file cannot be written; the message names it.
    pub fn finish(mut self, options: &MissionOptions, report: &MissionReport) -> anyhow::Result<()> {
        let named = format!("--record {}", self.path.display());
        end(&mut self.sink, self.tick, options, report).and_then(|()| self.sink.finish()).context(named)
    }

    fn write(&mut self, seen: &Seen) -> anyhow::Result<()> {
        let tick = seen.tick;
        self.tick = tick;
        if self.bodies.is_empty() {
            self.bodies = seen.world.bodies();
            self.sink.write(tick, &Content::Bodies(scene::bodies(tick, &self.bodies)?))?;
            for body in &self.bodies {
                self.sink.write(tick, &Content::Points(scene::body_points(tick, body)?))?;
            }
            self.sink.write(tick, &Content::Pads(self.pads(seen)))?;
        }
        self.sink.write(tick, &Content::Joints(Joints::from(&seen.world.readings())))?;
        if let Some(image) = seen.world.tactile() {
            self.sink.write(tick, &Content::Tactile(Tactile::from(&image)))?;
        }
        let links = self.ideal_sensors.then(|| seen.world.link_contacts());
        if let Some(links) = links.filter(|_| links != self.links) {
            self.sink.write(tick, &Content::LinkContacts(LinkContacts::new(tick, links)))?;
        }
        self.links = links;
        self.write_heard(seen)?;
        if tick.is_multiple_of(PICTURE_TICKS) {
            self.write_picture(seen)?;
        }
        if tick.is_multiple_of(SLOW_TICKS) {
            self.sink.write(tick, &Content::Bus(Bus::new(tick, &seen.wire.stats())))?;
        }
        if tick.is_multiple_of(FLUSH_TICKS) || !seen.heard.events.is_empty() && ends(&seen.heard.events) {
            self.sink.flush()?;
        }
        Ok(())
    }

    /// Where the tactile cells are.
    fn pads(&self, seen: &Seen) -> Pads {
        let hand: Vec<&Body> = self.bodies.iter().filter(|body| body.kind == Kind::Hand).collect();
        let pad = |pad: usize| Pad::new(pad, &hand[PAD_LINKS[pad]].name, seen.world.pad_cells(pad));
        Pads { tick: seen.tick, pads: (0..PADS).map(pad).collect() }
    }

    /// What the controller said.
    fn write_heard(&mut self, seen: &Seen) -> anyhow::Result<()> {
        let tick = seen.tick;
        if let Some(lost) = &seen.lost {
            self.sink.write(tick, &Content::Lost(ControllerLost::new(tick, lost)))?;
            self.sink.write(tick, &line(tick, log::Level::Error, lost_text(lost)))?;
        }
        for event in &seen.heard.events {
            self.sink.write(tick, &content(event, seen.heard.digest))?;
            if let Some(text) = describe(event) {
                self.sink.write(tick, &line(tick, level(event), text))?;
            }
        }
        if let Some(status) = &seen.heard.status {
            if self.believed.is_none() {
                self.sink.write(tick, &Content::Points(scene::believed_points(tick, seen.setup)?))?;
            }
            self.believed = Some(status.belief);
            self.sink.write(tick, &Content::Status(Status::from(status)))?;
            self.sink.write(tick, &Content::Belief(scene::belief(seen.setup, status)?))?;
            let truth = planar(&seen.world.object_pose());
            let symmetry_rad = seen.setup.shape.yaw_symmetry_rad();
            self.sink.write(
                tick,
                &Content::BeliefError(BeliefError {
                    tick,
                    position_m: status.belief.distance_m(&truth),
                    yaw_rad: status.belief.turn_from_rad(&truth, symmetry_rad),
                }),
            )?;
        }
        if let Some(command) = &seen.heard.command {
            self.sink.write(tick, &Content::Command(Command::from(command)))?;
        }
        Ok(())
    }

    /// What a viewer shows many times a second.
    fn write_picture(&mut self, seen: &Seen) -> anyhow::Result<()> {
        let tick = seen.tick;
        self.sink.write(tick, &Content::Transforms(self.transforms(seen)))?;
        self.sink.write(tick, &Content::JointStates(joint_states(seen)))?;
        let truth = ObjectTruth::new(tick, &seen.setup.shape, &seen.world.object_pose());
        self.sink.write(tick, &Content::ObjectTruth(truth))?;
        let force_n = seen.world.link_forces_n();
        self.sink.write(tick, &Content::LinkForces(LinkForces { tick, force_n }))?;
        let forces = seen.world.hand_forces();
        // Once more after the last contact, so that its arrows go.
        if self.touched || !forces.is_empty() {
            self.sink.write(tick, &Content::Contacts(scene::contacts(tick, &forces)))?;
        }
        self.touched = !forces.is_empty();
        Ok(())
    }

    fn transforms(&self, seen: &Seen) -> FrameTransforms {
        let transform = |child: &str, pose: &Isometry3<f32>| FrameTransform {
            timestamp: Some(timestamp(seen.tick)),
            parent_frame_id: scene::WORLD.to_owned(),
            child_frame_id: child.to_owned(),
            translation: Some(vector(pose.translation.vector.into())),
            rotation: Some(quaternion(&pose.rotation)),
        };
        let bodies = self.bodies.iter().map(|body| transform(&body.name, &seen.world.pose_of(body)));
        let z_m = seen.setup.shape.rest_height_m();
        let believed = self.believed.iter().map(|pose| transform(scene::BELIEVED, &pose.isometry(z_m)));
        FrameTransforms { transforms: bodies.chain(believed).collect() }
    }
}

impl Observer for Recorder {
    fn see(&mut self, seen: &Seen) -> anyhow::Result<()> {
        self.write(seen).with_context(|| format!("--record {}", self.path.display()))
    }
}

/// What is known before the first tick.
fn begin(sink: &mut Sink, options: &MissionOptions) -> anyhow::Result<()> {
    let texts = [
        ("seed", options.seed.to_string()),
        ("scene", options.scenario.name.clone()),
        ("reality", options.reality.name().to_owned()),
        ("program", concat!("tactus ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("message_version", format!("{SCHEMA_VERSION:016x}")),
    ];
    sink.describe(RUN, texts.map(|(key, text)| (key.to_owned(), text)).into())?;
    sink.attach(0, SETTINGS, serde_json::to_string_pretty(&Settings::of(options))?)?;
    sink.flush()
}

/// What is known after the last tick.
fn end(sink: &mut Sink, tick: u32, options: &MissionOptions, report: &MissionReport) -> anyhow::Result<()> {
    let summary = Summary::of(options, report);
    sink.attach(tick, SUMMARY, serde_json::to_string_pretty(&summary)?)?;
    let texts = [
        ("outcome", report.outcome_text()),
        ("digest", report.digest_text().unwrap_or_default()),
        ("digest_ticks", report.digest.map(|d| d.ticks.to_string()).unwrap_or_default()),
        ("touches", report.trials.to_string()),
    ];
    sink.describe(RESULT, texts.map(|(key, text)| (key.to_owned(), text)).into())
}

/// One line of `/log`.
fn line(tick: u32, level: log::Level, text: String) -> Content {
    Content::Log(Log {
        timestamp: Some(timestamp(tick)),
        level: level.into(),
        message: text.trim_start().to_owned(),
        name: "tactus".to_owned(),
        ..Log::default()
    })
}

fn level(event: &Event) -> log::Level {
    match event.kind {
        EventKind::Finished(Outcome::Fault(_)) => log::Level::Error,
        EventKind::Finished(Outcome::Failed(_))
        | EventKind::Refused(_)
        | EventKind::Confirmed(false)
        | EventKind::Slip { .. } => log::Level::Warning,
        _ => log::Level::Info,
    }
}

/// Is the end of the mission among these?
fn ends(events: &[Event]) -> bool {
    events.iter().any(|event| matches!(event.kind, EventKind::Finished(_)))
}

/// An event as a message of its channel.
fn content(event: &Event, digest: Option<DigestReport>) -> Content {
    let tick = event.tick;
    match event.kind {
        EventKind::Phase(phase) => Content::Phase(PhaseBegun::new(tick, phase)),
        EventKind::Touch { candidate, information_nats } => Content::Touch(Touch { tick, candidate, information_nats }),
        EventKind::Contact { finger, inner_rad, descending } => {
            Content::Contact(Contact { tick, finger, inner_rad, descending })
        }
        EventKind::Updated { belief, covariance, evaluations, modes, confident } => Content::Update(Update {
            tick,
            belief: belief.into(),
            covariance: covariance.into(),
            evaluations,
            modes,
            confident,
        }),
        EventKind::Confirmed(agrees) => Content::Foretold(Foretold { tick, agrees }),
        EventKind::Refused(reason) => Content::Refusal(Refusal::new(tick, reason)),
        EventKind::Slip { finger, sureness, grip_nm } => Content::Slip(Slip { tick, finger, sureness, grip_nm }),
        EventKind::Finished(outcome) => Content::End(End::new(tick, outcome, digest)),
    }
}

/// Measured angles; torques as commanded (arm) and as made (hand).
fn joint_states(seen: &Seen) -> JointStates {
    let readings = seen.world.readings();
    let state = |name: &str, q_rad: f32, torque_nm: Option<f32>| JointState {
        name: name.to_owned(),
        position: Some(q_rad.into()),
        effort: torque_nm.map(f64::from),
        ..JointState::default()
    };
    let arm_tau_nm = seen.heard.command.map(|command| command.arm_tau_nm);
    let arm = (0..7).map(|i| state(ARM_JOINTS[i], readings.arm_q_rad[i], arm_tau_nm.map(|tau_nm| tau_nm[i])));
    let inner = (0..3).map(|f| state(INNER_JOINTS[f], readings.inner_q_rad[f], Some(readings.effort_nm[f])));
    let spread = SPREAD_JOINTS.map(|name| state(name, readings.motor_q_rad[3], Some(readings.effort_nm[3])));
    JointStates { timestamp: Some(timestamp(seen.tick)), joints: arm.chain(inner).chain(spread).collect() }
}
