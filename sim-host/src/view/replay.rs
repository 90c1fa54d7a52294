//! From a recording to what the page shows.

use super::bodies;
use super::frames::Tracks;
use super::packed::Packed;
use super::page::{self, Heading};
use super::payload::{Belief, Contacts, MarkKind, Pad, Payload, Role, Scale};
use super::plots::Curves;
use super::story::Story;
use super::taxels::taxels;
use crate::recording::{Content, Ending, Entry, Log, RESULT, RUN, SETTINGS, SUMMARY, sample};
use crate::report::html::CIVIDIS;
use anyhow::{Context, ensure};
use foxglove::messages::{SceneEntity, SceneUpdate};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::path::Path;
use tactus_common::limits::PADS;

/// Ticks between two samples of torques in the plots: 10 ms.
const PLOT_TICKS: u32 = 5;
/// The yaw's uncertainty is drawn as far out as the object reaches, times this.
const WEDGE_REACH: f32 = 1.5;
/// Names of the pads.
const PAD_NAMES: [&str; PADS] = ["F1", "F2", "F3", "palm"];
/// Number of the palm's pad.
const PALM: usize = 3;
/// Least pressure of the brightest colour, N/cm^2.
const BRIGHT_MIN_N_CM2: f32 = 1.0;

/// A run as its page shows it.
pub struct Replay {
    /// What stands above the picture.
    pub heading: Heading,
    /// What the script gets to know.
    pub payload: Payload,
}

impl Replay {
    /// Reads a recording, up to where it breaks off if it does.
    ///
    /// # Errors
    /// The file cannot be read, is no recording, or nothing to be shown is in it.
    pub fn read(path: &Path) -> anyhow::Result<Self> {
        let mut log = Log::open(path)?;
        let mut gathered = Gathered::default();
        while let Some(entry) = log.next_entry()? {
            gathered.take(entry).with_context(|| path.display().to_string())?;
        }
        let cut = match log.ending() {
            Some(Ending::Cut(why)) => Some(why.as_str()),
            _ => None,
        };
        gathered.finish(cut).with_context(|| path.display().to_string())
    }

    /// Its page.
    ///
    /// # Errors
    /// As [`page::page`].
    pub fn page(&self) -> anyhow::Result<String> {
        page::page(&self.heading, &self.payload)
    }
}

/// What was read so far.
struct Gathered {
    last_s: f32,
    frames: Tracks,
    entities: BTreeMap<String, SceneEntity>,
    pads: Vec<sample::Pad>,
    images: [Images; PADS],
    belief: Beliefs,
    arrows: Arrows,
    story: Story,
    off: [Curves; 2],
    torques: [Curves; 3],
    run: BTreeMap<String, String>,
    result: BTreeMap<String, String>,
    settings: serde_json::Value,
    summary: serde_json::Value,
}

#[derive(Default)]
struct Images {
    times_s: Vec<f32>,
    pressures_n_cm2: Vec<f32>,
}

#[derive(Default)]
struct Beliefs {
    times_s: Vec<f32>,
    /// x, y, phi; none while the object is carried.
    poses: Vec<Option<[f32; 3]>>,
    covariances: Vec<f32>,
}

#[derive(Default)]
struct Arrows {
    times_s: Vec<f32>,
    starts: Vec<u32>,
    points_m: Vec<f32>,
    arrows_m: Vec<f32>,
}

impl Default for Gathered {
    fn default() -> Self {
        Self {
            last_s: 0.0,
            frames: Tracks::default(),
            entities: BTreeMap::new(),
            pads: Vec::new(),
            images: Default::default(),
            belief: Beliefs::default(),
            arrows: Arrows::default(),
            story: Story::default(),
            off: [
                Curves::new("Belief off by", "mm", Scale::Log, &["place"]),
                Curves::new("Belief off by", "°", Scale::Log, &["yaw"]),
            ],
            torques: [
                Curves::new("Arm", "N m", Scale::Linear, &["J1", "J2", "J3", "J4", "J5", "J6", "J7"]),
                Curves::new("Fingertip torque", "N m", Scale::Linear, &["F1", "F2", "F3"]),
                Curves::new("Hand effort", "N m", Scale::Linear, &["F1", "F2", "F3", "spread"]),
            ],
            run: BTreeMap::new(),
            result: BTreeMap::new(),
            settings: serde_json::Value::Null,
            summary: serde_json::Value::Null,
        }
    }
}

impl Gathered {
    fn take(&mut self, entry: Entry) -> anyhow::Result<()> {
        match entry {
            Entry::Message(message) => {
                let at_s = message.time_s() as f32;
                self.last_s = self.last_s.max(at_s);
                if let Some(content) = message.content()? {
                    self.take_content(at_s, content)?;
                }
            }
            Entry::Attachment(file) if file.name == SETTINGS => self.settings = serde_json::from_slice(&file.bytes)?,
            Entry::Attachment(file) if file.name == SUMMARY => self.summary = serde_json::from_slice(&file.bytes)?,
            Entry::Metadata { name, texts } if name == RUN => self.run = texts,
            Entry::Metadata { name, texts } if name == RESULT => self.result = texts,
            Entry::Attachment(_) | Entry::Metadata { .. } => {}
        }
        Ok(())
    }

    fn take_content(&mut self, at_s: f32, content: Content) -> anyhow::Result<()> {
        match content {
            Content::Transforms(transforms) => self.frames.take(at_s, &transforms)?,
            Content::Bodies(update) | Content::Belief(update) => self.keep(update),
            Content::Contacts(update) => self.arrows.take(at_s, &update),
            Content::Pads(pads) => self.pads = pads.pads,
            Content::Tactile(image) => self.take_image(at_s, &image),
            Content::Joints(joints) if joints.tick.is_multiple_of(PLOT_TICKS) => {
                self.torques[1].push(at_s, &joints.tip_torque_nm);
                self.torques[2].push(at_s, &joints.effort_nm);
            }
            Content::Command(command) if command.tick.is_multiple_of(PLOT_TICKS) => {
                self.torques[0].push(at_s, &command.arm_tau_nm);
            }
            Content::Status(status) => self.believe(at_s, &status.belief, &status.covariance),
            Content::BeliefError(off) if !self.story.is_carried() => {
                self.off[0].push(at_s, &[1e3 * off.position_m]);
                self.off[1].push(at_s, &[off.yaw_rad.abs().to_degrees()]);
            }
            Content::Phase(phase) => self.story.phase(at_s, &phase.phase),
            Content::Touch(_) => self.story.mark(at_s, MarkKind::Touch),
            Content::Contact(_) => self.story.mark(at_s, MarkKind::Contact),
            Content::Update(update) => {
                self.story.mark(at_s, MarkKind::Update);
                self.believe(at_s, &update.belief, &update.covariance);
            }
            Content::Log(line) => self.story.say(at_s, &line.message),
            Content::Joints(_) | Content::Command(_) | Content::BeliefError(_) => {}
            // Said by the log in words, or shown by another channel.
            Content::Points(_)
            | Content::JointStates(_)
            | Content::Foretold(_)
            | Content::Refusal(_)
            | Content::Slip(_)
            | Content::End(_) => {}
            Content::Bus(_)
            | Content::Lost(_)
            | Content::ObjectTruth(_)
            | Content::LinkForces(_)
            | Content::LinkContacts(_) => {}
        }
        Ok(())
    }

    /// Scene entities replace those of the same name.
    fn keep(&mut self, update: SceneUpdate) {
        self.entities.extend(update.entities.into_iter().map(|entity| (entity.id.clone(), entity)));
    }

    fn take_image(&mut self, at_s: f32, image: &sample::Tactile) {
        if let Some(images) = self.images.get_mut(usize::from(image.pad)) {
            images.times_s.push(at_s);
            images.pressures_n_cm2.extend(image.pressure_n_cm2);
        }
    }

    fn believe(&mut self, at_s: f32, pose: &sample::Planar, covariance: &sample::Covariance) {
        self.belief.times_s.push(at_s);
        let pose = [pose.x_m, pose.y_m, pose.phi_rad];
        self.belief.poses.push((!self.story.is_carried()).then_some(pose));
        let c = covariance;
        self.belief.covariances.extend([c.xx_m2, c.xy_m2, c.xphi_m_rad, c.yy_m2, c.yphi_m_rad, c.phiphi_rad2]);
    }

    fn finish(self, cut: Option<&str>) -> anyhow::Result<Replay> {
        let heading = self.heading(cut);
        let bodies = self.entities.values().map(|entity| bodies::body(entity, &self.frames));
        let bodies: Vec<_> = bodies.collect::<anyhow::Result<Vec<_>>>()?.into_iter().flatten().collect();
        ensure!(!bodies.is_empty(), "no bodies are in it; expected a recording of `tactus run --record`");
        let reach_m = bodies.iter().filter(|body| body.role == Role::Belief).map(|body| body.reach_m());
        let radius_m = WEDGE_REACH * reach_m.fold(0.0, f32::max);
        let palm =
            self.pads.iter().find(|pad| usize::from(pad.pad) == PALM).and_then(|pad| self.frames.find(&pad.frame_id));
        let (phases, marks) = self.story.finish(self.last_s);
        let payload = Payload {
            duration_s: self.last_s,
            colour_map: CIVIDIS.iter().map(|[r, g, b]| format!("#{r:02x}{g:02x}{b:02x}")).collect(),
            bright_n_cm2: bright_n_cm2(&self.images),
            palm: palm.context("no tactile pads are in it; expected a recording of `tactus run --record`")?,
            bodies,
            belief: self.belief.finish(self.frames.believed_z_m(), radius_m),
            goal: goal(&self.settings),
            pads: pads(&self.pads, &self.images, &self.frames)?,
            contacts: self.arrows.finish(),
            plots: self.off.into_iter().chain(self.torques).map(Curves::finish).collect(),
            frames: self.frames.finish(),
            phases,
            marks,
        };
        Ok(Replay { heading, payload })
    }

    fn heading(&self, cut: Option<&str>) -> Heading {
        let seed = self.run.get("seed").map(|seed| format!(", seed {seed}")).unwrap_or_default();
        let scene = self.run.get("scene").map(|scene| format!(": {scene}")).unwrap_or_default();
        let mm = |key: &str| self.summary[key].as_f64().map(|m| format!("{:.2} mm", 1e3 * m));
        let deg = |key: &str| self.summary[key].as_f64().map(|r| format!("{:.2}°", r.to_degrees()));
        let both = |m: &str, r: &str| mm(m).zip(deg(r)).map(|(mm, deg)| format!("{mm}, {deg}"));
        let text = |key: &str| self.result.get(key).filter(|text| !text.is_empty()).cloned();
        let facts = [
            ("outcome", text("outcome")),
            ("touches", text("touches")),
            ("grasped with a belief off by", both("position_error_m", "yaw_error_rad")),
            ("put down off by", both("goal_position_error_m", "goal_yaw_error_rad")),
            ("digest", text("digest")),
            ("ticks", text("digest_ticks")),
        ];
        Heading {
            title: format!("Tactus{scene}{seed}"),
            facts: facts.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?))).collect(),
            warning: cut.map(|why| format!("This recording ends at {:.2} s: {why}.", self.last_s)),
        }
    }
}

impl Beliefs {
    fn finish(self, z_m: f32, radius_m: f32) -> Belief {
        let pose = |pose: Option<[f32; 3]>| pose.map_or([f32::NAN; 4], |[x, y, phi]| [x, y, z_m, phi]);
        Belief {
            times_s: Packed::exact(self.times_s),
            poses: Packed::exact(self.poses.into_iter().flat_map(pose)),
            covariances: Packed::exact(self.covariances),
            radius_m,
        }
    }
}

impl Arrows {
    /// Arrows of a scene point along their own x.
    fn take(&mut self, at_s: f32, update: &SceneUpdate) {
        self.times_s.push(at_s);
        self.starts.push(self.points_m.len() as u32 / 3);
        for arrow in update.entities.iter().flat_map(|entity| &entity.arrows) {
            let [x, y, z, i, j, k, w] = bodies::pose(&arrow.pose);
            let length_m = (arrow.shaft_length + arrow.head_length) as f32;
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
            let along: Vector3<f32> = turn * Vector3::x() * length_m;
            self.points_m.extend([x + along.x, y + along.y, z + along.z]);
            self.arrows_m.extend([along.x, along.y, along.z]);
        }
    }

    fn finish(mut self) -> Contacts {
        self.starts.push(self.points_m.len() as u32 / 3);
        Contacts {
            times_s: Packed::exact(self.times_s),
            starts: Packed::counts(self.starts),
            points_m: Packed::quantised(&self.points_m),
            arrows_m: Packed::quantised(&self.arrows_m),
        }
    }
}

/// x, y, phi of the goal that the settings tell.
fn goal(settings: &serde_json::Value) -> Option<[f32; 3]> {
    let number = |key: &str| settings["goal"][key].as_f64().map(|v| v as f32);
    Some([number("x_m")?, number("y_m")?, number("phi_rad")?])
}

/// A whole number that no pressure is above, N/cm^2.
fn bright_n_cm2(images: &[Images; PADS]) -> f32 {
    images.iter().flat_map(|i| &i.pressures_n_cm2).copied().fold(BRIGHT_MIN_N_CM2, f32::max).ceil()
}

/// The pads with what they read.
fn pads(pads: &[sample::Pad], images: &[Images; PADS], frames: &Tracks) -> anyhow::Result<Vec<Pad>> {
    let pad = |pad: &sample::Pad| {
        let number = usize::from(pad.pad);
        let named = PAD_NAMES.get(number).zip(images.get(number));
        let (name, images) = named.with_context(|| format!("a pad {number} is in it; expected 0 to {}", PADS - 1))?;
        let frame = frames.find(&pad.frame_id).with_context(|| format!("no frame {} for a pad", pad.frame_id))?;
        Ok(Pad {
            name: (*name).to_owned(),
            frame,
            cells: taxels(pad),
            times_s: Packed::exact(images.times_s.iter().copied()),
            pressures_n_cm2: Packed::quantised(&images.pressures_n_cm2),
        })
    };
    pads.iter().map(pad).collect()
}
