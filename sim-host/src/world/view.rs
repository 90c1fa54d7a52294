//! What stands where in the world, for pictures: every body, its frame and its shapes; contacts as they truly are.

use super::model::Cell;
use super::{World, contacts};
use nalgebra::{Isometry3, Point3, Vector3};
use rapier3d::prelude::*;

/// What a body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A link of the arm, named as in the URDF.
    Arm,
    /// A link of the hand, named as in the URDF.
    Hand,
    /// The table.
    Table,
    /// The object of the mission.
    Object,
    /// Another body that can move.
    Loose,
    /// Another body that cannot.
    Obstacle,
}

/// A body with its shapes; [`World::pose_of`] says where it is.
#[derive(Clone)]
pub struct Body {
    /// Unique name, of its frame too.
    pub name: String,
    /// What it is.
    pub kind: Kind,
    /// Its shapes as they truly are, posed in its frame.
    pub shapes: Vec<(Isometry3<f32>, SharedShape)>,
    handle: RigidBodyHandle,
    in_body: Pose,
}

/// A force on the hand, in the world's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandForce {
    /// Hand link, contact-matrix index.
    pub link: usize,
    /// Point of the contact, metres.
    pub point_m: Point3<f32>,
    /// Normal force on the link, newtons (points into the link).
    pub force_n: Vector3<f32>,
}

impl World {
    /// Every body: the robot's links from its root on, the table, the object, whatever else there is.
    pub fn bodies(&self) -> Vec<Body> {
        let mut bodies = self.links();
        bodies.extend(self.body_of("table", Kind::Table, self.table));
        for (handle, collider) in self.physics.colliders.iter() {
            let of_robot = self.robot.colliders.iter().any(|named| named.collider == handle);
            if of_robot || handle == self.table {
                continue;
            }
            let parent = collider.parent();
            let moves = parent.and_then(|body| self.physics.bodies.get(body)).is_some_and(RigidBody::is_dynamic);
            let body = if parent == Some(self.object) {
                self.body_of("object", Kind::Object, handle)
            } else if moves {
                let number = 1 + bodies.iter().filter(|body| body.kind == Kind::Loose).count();
                self.body_of(&format!("loose_{number}"), Kind::Loose, handle)
            } else {
                let number = 1 + bodies.iter().filter(|body| body.kind == Kind::Obstacle).count();
                self.body_of(&format!("obstacle_{number}"), Kind::Obstacle, handle)
            };
            bodies.extend(body);
        }
        bodies
    }

    fn links(&self) -> Vec<Body> {
        let frames = self.robot.frames.iter();
        let hand = self.robot.frames.len() - self.robot.hand_links.len();
        let link = |(index, frame): (usize, &super::robot::LinkFrame)| {
            let own = self.robot.colliders.iter().filter(|named| named.link == frame.link);
            let shapes = own.filter_map(|named| self.physics.colliders.get(named.collider)).map(|collider| {
                let in_body = collider.position_wrt_parent().copied().unwrap_or(Pose::IDENTITY);
                ((frame.in_body.inverse() * in_body).into(), collider.shared_shape().clone())
            });
            Body {
                name: frame.link.clone(),
                // The arm is built before the hand.
                kind: if index < hand { Kind::Arm } else { Kind::Hand },
                shapes: shapes.collect(),
                handle: frame.body,
                in_body: frame.in_body,
            }
        };
        frames.enumerate().map(link).collect()
    }

    fn body_of(&self, name: &str, kind: Kind, collider: ColliderHandle) -> Option<Body> {
        let collider = self.physics.colliders.get(collider)?;
        let at = collider.position_wrt_parent().copied().unwrap_or(Pose::IDENTITY);
        Some(Body {
            name: name.to_owned(),
            kind,
            shapes: vec![(at.into(), collider.shared_shape().clone())],
            handle: collider.parent()?,
            in_body: Pose::IDENTITY,
        })
    }

    /// World-from-body pose of one of this world's [`Self::bodies`], as it truly is.
    pub fn pose_of(&self, body: &Body) -> Isometry3<f32> {
        self.physics.bodies.get(body.handle).map_or_else(Isometry3::identity, |b| (*b.position() * body.in_body).into())
    }

    /// The cells of a pad, in the frame of the link that carries it ([`super::PAD_LINKS`]).
    pub fn pad_cells(&self, pad: usize) -> &[Cell] {
        self.pads.cells(pad)
    }

    /// The forces that acted on the hand in the last physics step.
    pub fn hand_forces(&self) -> Vec<HandForce> {
        let mut forces = Vec::new();
        let dt_s = self.physics.integration_parameters.dt;
        contacts::hand_contacts(&self.physics, &self.robot, dt_s, |contact| {
            let world_from_link: Isometry3<f32> = self.robot.hand_link_pose(&self.physics, contact.link).into();
            forces.extend(contact.points().iter().map(|point| HandForce {
                link: contact.link,
                point_m: world_from_link * Point3::from(point.point_m.to_array()),
                force_n: world_from_link.rotation * Vector3::from(point.force_n.to_array()),
            }));
        });
        forces
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Mismatch, Scene};

    #[test]
    fn every_body_has_a_name_of_its_own_and_a_shape_and_is_where_the_world_says() {
        let world = World::new(&Scene::default(), &Mismatch::none(), 1).unwrap();
        let bodies = world.bodies();
        let names: std::collections::BTreeSet<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
        assert_eq!((names.len(), bodies.len()), (19, 19), "{names:?}");
        assert!(bodies.iter().all(|body| !body.shapes.is_empty()));
        let kinds = |kind| bodies.iter().filter(|body| body.kind == kind).count();
        assert_eq!([Kind::Arm, Kind::Hand, Kind::Table, Kind::Object].map(kinds), [8, 9, 1, 1]);
        let object = bodies.iter().find(|body| body.kind == Kind::Object).unwrap();
        assert_eq!(world.pose_of(object), world.object_pose());
        let palm = bodies.iter().find(|body| body.kind == Kind::Hand).unwrap();
        assert_eq!(world.pose_of(palm), world.hand_pose());
    }
}
