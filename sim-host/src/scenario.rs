//! Scenes: what stands where, as TOML files with the built-in one as an example.

use crate::world::Scene;
use crate::world::model::RobotModel;
use anyhow::Context;
use serde::{Deserialize, Serialize};
use std::path::Path;
use tactus_common::pose::PlanarPose;
use tactus_common::robot::source;
use tactus_common::shape::ObjectShape;

/// The built-in scene: the thesis's box (Nikandrova 2011) on its table.
const THESIS_BOX: &str = include_str!("../scenarios/thesis_box.toml");

/// A scene, checked.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name, for reports.
    pub name: String,
    /// The table; its top is at z = 0 with its centre at the origin.
    pub table: Table,
    /// The object to carry: a box.
    pub object: Object,
    /// Displacement of the object from where it stands, world x and y, metres.
    pub displacement_m: [f32; 2],
    /// A robot description (URDF) for the world to use instead of the built-in one. The controller keeps its own.
    #[serde(default)]
    pub robot_urdf: Option<std::path::PathBuf>,
}

/// A rectangular table.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Extent along x, y and downwards, metres.
    pub size_m: [f32; 3],
    /// Coulomb friction coefficient between table and object.
    pub friction: f32,
}

/// A box.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Extent along its x, y and z, metres.
    pub size_m: [f32; 3],
    /// Mass, kilograms.
    pub mass_kg: f32,
    /// Coulomb friction coefficient between object and hand.
    pub friction: f32,
    /// True pose unless told otherwise: x, y in metres, phi in radians.
    pub true_pose: [f32; 3],
}

impl Scenario {
    /// The built-in scene.
    pub fn thesis_box() -> Self {
        Self::parse(THESIS_BOX).expect("the built-in scene is checked by a test")
    }

    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// The file cannot be read, is not such TOML, or holds values that make no sense; the message names file and field.
    pub fn load(path: &Path) -> anyhow::Result<Self> {
        let text = std::fs::read_to_string(path).with_context(|| format!("--scenario {}", path.display()))?;
        let mut scenario = Self::parse(&text).with_context(|| format!("--scenario {}", path.display()))?;
        // A path in a scene is meant from where the scene is.
        if let (Some(urdf), Some(folder)) = (&mut scenario.robot_urdf, path.parent()) {
            *urdf = folder.join(&urdf);
        }
        Ok(scenario)
    }

    fn parse(text: &str) -> anyhow::Result<Self> {
        let scenario: Self = toml::from_str(text).map_err(|e: toml::de::Error| {
            let line = e.span().map_or(0, |s| text[..s.start].lines().count().max(1));
            anyhow::anyhow!("line {line}: {}", e.message().replace('\n', "; "))
        })?;
        let positive = |name: &str, values: &[f32]| {
            anyhow::ensure!(
                values.iter().all(|v| v.is_finite() && *v > 0.0),
                "{name} = {values:?}: expected finite numbers above zero"
            );
            Ok(())
        };
        positive("table.size_m", &scenario.table.size_m)?;
        positive("table.friction", &[scenario.table.friction])?;
        positive("object.size_m", &scenario.object.size_m)?;
        positive("object.mass_kg", &[scenario.object.mass_kg])?;
        positive("object.friction", &[scenario.object.friction])?;
        anyhow::ensure!(
            scenario.object.true_pose.iter().chain(&scenario.displacement_m).all(|v| v.is_finite()),
            "object.true_pose and displacement_m: expected finite numbers"
        );
        scenario.check_on_table("object.true_pose", &scenario.true_pose())?;
        Ok(scenario)
    }

    /// The true pose unless told otherwise.
    pub fn true_pose(&self) -> PlanarPose {
        PlanarPose::from_array(self.object.true_pose)
    }

    /// The object's shape.
    pub fn shape(&self) -> ObjectShape {
        ObjectShape::Cuboid { half_extents_m: self.object.size_m.map(|s| s / 2.0) }
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
            half_extents_m: self.shape().half_extents_m(),
            mass_kg: self.object.mass_kg,
            table_friction: self.table.friction,
            pad_friction: self.object.friction,
            object: *truth,
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
        let [half_x, half_y] = [self.table.size_m[0] / 2.0, self.table.size_m[1] / 2.0];
        anyhow::ensure!(
            pose.is_finite() && pose.x_m.abs() <= half_x && pose.y_m.abs() <= half_y,
            "{what} {},{},{}: off the table; expected x within +-{half_x} m and y within +-{half_y} m",
            pose.x_m,
            pose.y_m,
            pose.phi_rad
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_scene_is_sound() {
        let scene = Scenario::thesis_box();
        assert_eq!(scene.object.size_m, [0.2, 0.1, 0.2]);
    }

    #[test]
    fn a_bad_scene_is_refused_by_field_and_line() {
        for (from, to, expected) in [
            ("mass_kg = 0.6", "mass_kg = -1", "object.mass_kg"),
            ("mass_kg = 0.6", "mass_kg = nan", "object.mass_kg"),
            ("mass_kg = 0.6", "mass_kg = \"heavy\"", "line "),
            ("mass_kg = 0.6", "mass = 0.6", "unknown field"),
            ("true_pose = [0.2,", "true_pose = [2.0,", "off the table"),
        ] {
            let text = THESIS_BOX.replace(from, to);
            assert_ne!(text, THESIS_BOX, "{from}");
            let message = format!("{:#}", Scenario::parse(&text).unwrap_err());
            assert!(message.contains(expected), "{message}");
            assert_eq!(message.lines().count(), 1, "{message}");
        }
    }
}
