//! Scenes: what stands where. Files in TOML (`docs/scenes.md`), some of them held by the program.
//!
//! * [`mod@format`]: the fields as they are written; [`schema`]: for editors. [`built_in`]: the scenes that the program holds.
//! * [`shape`], [`mesh`], [`polyhedron`]: shapes from numbers and from mesh files.
//! * `check`: which numbers make sense. [`mistake`]: what is wrong, with its line. [`account`]: what a scene is, in words.

pub mod account;
pub mod built_in;
mod check;
pub mod format;
pub mod mesh;
pub mod mistake;
pub mod polyhedron;
pub mod schema;
pub mod shape;

use crate::mental::MentalModel;
use crate::solid::Solid;
use crate::world::model::RobotModel;
use crate::world::{Mismatch, Scene, Standing, World, WorldError};
use anyhow::Context;
use format::{MismatchScales, NoiseScales, Region, SceneFile};
use mistake::Mistake;
use rapier3d::parry::query;
use rapier3d::prelude::Pose;
use serde::Serialize;
use std::path::{Path, PathBuf};
use tactus_common::limits::OBSTACLES_MAX;
use tactus_common::pose::PlanarPose;
use tactus_common::robot::{MOUNT, source};
use tactus_common::shape::{ObjectShape, Obstacle};

/// Largest scene file that is read, bytes.
const SCENE_BYTES_MAX: u64 = 1 << 18;

/// A scene, checked.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scenario {
    /// Name, for reports.
    pub name: String,
    /// What is special about it, one line.
    pub summary: String,
    /// The table; its top is at z = 0 with its centre at the origin.
    pub table: Table,
    /// The object to carry.
    pub object: Object,
    /// What else stands on the table.
    pub others: Vec<Standing>,
    /// Displacement of the object from where it stands, world x and y, metres.
    pub displacement_m: [f32; 2],
    /// Scales of the sensors' noise.
    pub noise: NoiseScales,
    /// Scales of what reality differs by from the model.
    pub mismatch: MismatchScales,
    /// Where batches draw true poses from.
    pub trials: Region,
    /// Where the robot's base stands.
    pub robot_base: PlanarPose,
    /// A robot description (URDF) for the world to use instead of the built-in one. The controller keeps its own.
    pub robot_urdf: Option<PathBuf>,
}

/// A rectangular table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Table {
    /// Extent along x, y and downwards, metres.
    pub size_m: [f32; 3],
    /// Coulomb friction coefficient between table and object.
    pub friction: f32,
}

/// The object to carry.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Object {
    /// Its shape.
    pub shape: ObjectShape,
    /// Mass, kilograms.
    pub mass_kg: f32,
    /// Coulomb friction coefficient between object and hand.
    pub friction: f32,
    /// True pose unless told otherwise: x, y in metres, phi in radians.
    pub true_pose: [f32; 3],
    /// What the controller is told unless told otherwise.
    pub guess: Option<[f32; 3]>,
    /// Half widths of the interval that the controller is told unless told otherwise.
    pub interval: Option<[f32; 3]>,
}

impl Scenario {
    /// The scene of the published experiment, the default.
    pub fn thesis_box() -> Self {
        Self::parse(built_in::ALL[0].text, Path::new("")).expect("the built-in scenes are checked by a test")
    }

    /// The scene of a name that the program knows, or of a file.
    ///
    /// # Errors
    /// There is neither, or the file is not such TOML, or holds values that make no sense: one line with line, column
    /// and field, without the file's name.
    pub fn load(name_or_file: &Path) -> anyhow::Result<Self> {
        if let Some(scene) = name_or_file.to_str().and_then(built_in::find) {
            return Self::parse(scene.text, Path::new(""));
        }
        let text = read(name_or_file)?;
        // A path in a scene is meant from where the scene is.
        Self::parse(&text, name_or_file.parent().unwrap_or(Path::new("")))
    }

    /// The scene that a file's text says; paths in it are meant from `folder`.
    fn parse(text: &str, folder: &Path) -> anyhow::Result<Self> {
        let file: SceneFile = toml::from_str(text).map_err(|e: toml::de::Error| {
            let what = e.message().replace('\n', "; ");
            match e.span() {
                Some(span) => anyhow::anyhow!("{}: {what}", mistake::place(text, span.start)),
                None => anyhow::anyhow!("{what}"),
            }
        })?;
        let located = |mistake: Mistake| mistake.located(text);
        let scenario = Self::resolve(file, folder).map_err(located)?;
        scenario.check_stands().map_err(|unsound| match unsound {
            Unsound::Scene(mistake) => located(mistake),
            Unsound::Robot(error) => error,
        })?;
        Ok(scenario)
    }

    /// The scene that these fields describe.
    fn resolve(file: SceneFile, folder: &Path) -> Result<Self, Mistake> {
        check::numbers(&file)?;
        let object = &file.object;
        let shape = shape::resolve("object", object.shape.as_ref(), object.size_m.as_ref(), folder)?;
        let others = others(&file, folder)?;
        let [x, y, phi] = object.true_pose;
        let scenario = Self {
            name: check::one_line("name", file.name)?,
            summary: check::one_line("summary", file.summary)?,
            table: Table { size_m: file.table.size_m, friction: file.table.friction },
            object: Object {
                shape,
                mass_kg: object.mass_kg,
                friction: object.friction,
                true_pose: [x, y, phi],
                guess: object.guess,
                interval: object.interval,
            },
            others,
            displacement_m: file.displacement_m,
            noise: file.noise,
            mismatch: file.mismatch,
            trials: file.trials,
            robot_base: PlanarPose::from_array(file.robot_base_pose),
            robot_urdf: file.robot_urdf.map(|urdf| folder.join(urdf)),
        };
        scenario.check_places()?;
        Ok(scenario)
    }

    /// Everything stands over the table.
    fn check_places(&self) -> Result<(), Mistake> {
        let on_table =
            |field: &str, pose: &PlanarPose| self.off_table(pose).map_or(Ok(()), |told| Err(Mistake::new(field, told)));
        on_table("object.true_pose", &self.true_pose())?;
        if let Some(guess) = self.guess() {
            on_table("object.guess", &guess)?;
        }
        for other in &self.others {
            on_table(&format!("{}.pose", other.name), &other.pose)?;
        }
        let Region { x_m, y_m, .. } = self.trials;
        for k in [0, 1] {
            on_table("trials.x_m", &PlanarPose::new(x_m[k], 0.0, 0.0))?;
            on_table("trials.y_m", &PlanarPose::new(0.0, y_m[k], 0.0))?;
        }
        Ok(())
    }

    /// Nothing stands in anything else, nor in the robot, while the object is where the scene says.
    fn check_stands(&self) -> Result<(), Unsound> {
        let model = self.robot_model().map_err(Unsound::Robot)?;
        match World::with_model(&model, &self.world_scene(&self.true_pose()), &Mismatch::none(), 0) {
            Ok(_) => Ok(()),
            Err(WorldError::Interpenetration { a, b, depth_m }) => {
                let other = self.others.iter().find(|other| [&a, &b].contains(&&other.name));
                let is_robots = [&a, &b].iter().any(|name| model.link(name).is_ok());
                let field = match other {
                    _ if is_robots && self.robot_base != MOUNT => "robot_base_pose".to_owned(),
                    Some(other) => format!("{}.pose", other.name),
                    None => "object.true_pose".to_owned(),
                };
                Err(Unsound::Scene(Mistake::new(field, WorldError::Interpenetration { a, b, depth_m }.to_string())))
            }
            Err(error) => Err(Unsound::Robot(error.into())),
        }
    }

    /// The true pose unless told otherwise.
    pub fn true_pose(&self) -> PlanarPose {
        PlanarPose::from_array(self.object.true_pose)
    }

    /// What the controller is told unless told otherwise, if the scene says so.
    pub fn guess(&self) -> Option<PlanarPose> {
        self.object.guess.map(PlanarPose::from_array)
    }

    /// The object's shape.
    pub fn shape(&self) -> ObjectShape {
        self.object.shape
    }

    /// What stands on the table beside the object, as planner and mental world know it.
    pub fn known_obstacles(&self) -> Vec<Obstacle> {
        self.others.iter().map(|other| Obstacle { shape: other.shape, pose: other.pose }).collect()
    }

    /// A mental world with what stands on the table beside the object.
    ///
    /// # Errors
    /// The robot description cannot be used.
    pub fn mental_model(&self) -> anyhow::Result<MentalModel> {
        Ok(MentalModel::new()?.among(&self.known_obstacles()).with_robot_at(&self.robot_base))
    }

    /// The same as the controller is told it.
    pub fn obstacles(&self) -> [Option<Obstacle>; OBSTACLES_MAX] {
        let mut known = self.known_obstacles().into_iter();
        core::array::from_fn(|_| known.next())
    }

    /// Whether the object, standing at `pose`, keeps `room_m` from everything else on the table.
    pub fn stands_free(&self, pose: &PlanarPose, room_m: f32) -> bool {
        let Some(object) = Solid::new(&self.object.shape) else { return false };
        let stands = |solid: &Solid, pose: &PlanarPose| Pose::from(pose.isometry(solid.rest_height_m)) * solid.in_body;
        let at = stands(&object, pose);
        self.others.iter().filter_map(|other| Some((other, Solid::new(&other.shape)?))).all(|(other, solid)| {
            let apart = query::distance(&at, &*object.shape, &stands(&solid, &other.pose), &*solid.shape);
            apart.is_ok_and(|d| d.distance > room_m)
        })
    }

    /// The height of the object's frame (its centroid) while it stands, metres.
    pub fn rest_height_m(&self) -> f32 {
        self.shape().rest_height_m()
    }

    /// The true pose displaced to the goal.
    pub fn goal(&self, truth: &PlanarPose) -> PlanarPose {
        PlanarPose::new(truth.x_m + self.displacement_m[0], truth.y_m + self.displacement_m[1], truth.phi_rad)
    }

    /// The scene as the world takes it, the object truly at `truth`.
    pub fn world_scene(&self, truth: &PlanarPose) -> Scene {
        Scene {
            table_half_m: [self.table.size_m[0] / 2.0, self.table.size_m[1] / 2.0],
            shape: self.shape(),
            mass_kg: self.object.mass_kg,
            table_friction: self.table.friction,
            pad_friction: self.object.friction,
            object: *truth,
            others: self.others.clone(),
            robot_base: self.robot_base,
            ..Scene::default()
        }
    }

    /// The robot description that the world uses.
    ///
    /// # Errors
    /// The file cannot be read or is not a robot that the world can build; the message names it.
    pub fn robot_model(&self) -> anyhow::Result<RobotModel> {
        let Some(path) = &self.robot_urdf else { return Ok(RobotModel::shipped()?) };
        let named = || format!("robot_urdf {}", path.display());
        let urdf = std::fs::read_to_string(path).with_context(named)?;
        let mesh = |name: &str| source::mesh(name).map(str::to_owned);
        RobotModel::parse(&urdf, source::TOML, mesh).with_context(named)
    }

    /// Refuses a pose whose centre is not over the table.
    ///
    /// # Errors
    /// One line that names `what`, the pose and the table's extent.
    pub fn check_on_table(&self, what: &str, pose: &PlanarPose) -> anyhow::Result<()> {
        match self.off_table(pose) {
            Some(told) => Err(anyhow::anyhow!("{what} {told}")),
            None => Ok(()),
        }
    }

    /// What is wrong with a pose whose centre is not over the table.
    fn off_table(&self, pose: &PlanarPose) -> Option<String> {
        let [half_x, half_y] = [self.table.size_m[0] / 2.0, self.table.size_m[1] / 2.0];
        let on_table = pose.is_finite() && pose.x_m.abs() <= half_x && pose.y_m.abs() <= half_y;
        (!on_table).then(|| {
            format!(
                "{},{},{}: off the table; expected x within +-{half_x} m and y within +-{half_y} m",
                pose.x_m, pose.y_m, pose.phi_rad
            )
        })
    }
}

/// Why a scene cannot be simulated.
enum Unsound {
    /// The scene's own fault.
    Scene(Mistake),
    /// The robot description's.
    Robot(anyhow::Error),
}

/// The text of a scene file.
fn read(path: &Path) -> anyhow::Result<String> {
    // A name without an ending that is no file is meant as one of the built-in scenes perhaps.
    let hint = || {
        if path.extension().is_none() && !path.exists() {
            format!("; built in are {}", built_in::names())
        } else {
            String::new()
        }
    };
    let bytes = mesh::read_bounded(path, SCENE_BYTES_MAX).map_err(|told| anyhow::anyhow!("{told}{}", hint()))?;
    String::from_utf8(bytes).map_err(|e| anyhow::anyhow!("not a text: {}", e.utf8_error()))
}

/// What stands on the table beside the object: the free bodies, then the fixed ones.
fn others(file: &SceneFile, folder: &Path) -> Result<Vec<Standing>, Mistake> {
    let mut others = Vec::new();
    for (index, free) in file.objects.iter().enumerate() {
        let name = format!("objects[{index}]");
        check::within(&format!("{name}.mass_kg"), &[free.mass_kg], [0.01, 10.0], "kg")?;
        check::finite(&format!("{name}.pose"), &free.pose)?;
        let shape = shape::resolve(&name, free.shape.as_ref(), free.size_m.as_ref(), folder)?;
        others.push(Standing { name, shape, pose: PlanarPose::from_array(free.pose), free_kg: Some(free.mass_kg) });
    }
    for (index, fixed) in file.obstacles.iter().enumerate() {
        let name = format!("obstacles[{index}]");
        check::finite(&format!("{name}.pose"), &fixed.pose)?;
        let shape = shape::resolve(&name, fixed.shape.as_ref(), fixed.size_m.as_ref(), folder)?;
        others.push(Standing { name, shape, pose: PlanarPose::from_array(fixed.pose), free_kg: None });
    }
    if let Some(extra) = others.get(OBSTACLES_MAX) {
        let told = format!("{} objects and obstacles; expected at most {OBSTACLES_MAX}", others.len());
        return Err(Mistake::new(extra.name.clone(), told));
    }
    Ok(others)
}

#[cfg(test)]
mod tests;
