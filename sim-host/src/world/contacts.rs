//! Contact forces on the hand's links, read from rapier's narrow phase after a step.

use super::robot::Robot;
use super::tactile::LinkForce;
use rapier3d::prelude::*;
use tactus_common::limits::HAND_LINKS;

/// One contact point between a hand link and anything else.
#[derive(Clone, Copy, Debug)]
pub struct HandContact {
    /// Hand link, contact-matrix index.
    pub link: usize,
    /// The other collider.
    pub other: ColliderHandle,
    /// Where and how hard, in the link's frame.
    pub force: LinkForce,
}

/// Calls `visit` for every hand contact that carried a force in the last step of length `dt_s`.
pub fn hand_contacts(physics: &PhysicsWorld, robot: &Robot, dt_s: f32, mut visit: impl FnMut(&HandContact)) {
    for pair in physics.narrow_phase.contact_pairs() {
        let link_of = |collider: ColliderHandle| {
            let tag = physics.colliders.get(collider).map_or(0, |c| c.user_data) as usize;
            (1..=HAND_LINKS).contains(&tag).then(|| tag - 1)
        };
        let (link, first) = match (link_of(pair.collider1), link_of(pair.collider2)) {
            (Some(link), _) => (link, true),
            (None, Some(link)) => (link, false),
            (None, None) => continue,
        };
        for manifold in pair.manifolds() {
            if manifold.data.solver_contacts.is_empty() {
                continue;
            }
            let own = if first { pair.collider1 } else { pair.collider2 };
            let other = if first { pair.collider2 } else { pair.collider1 };
            let Some(collider) = physics.colliders.get(own) else { continue };
            let world_from_link = robot.hand_link_pose(physics, link);
            let link_from_collider = world_from_link.inverse() * *collider.position();
            // The normal points from the first body to the second; the second pushes the first the other way.
            let push = if first { -manifold.data.normal } else { manifold.data.normal };
            let push = world_from_link.rotation.inverse() * push;
            // Only points that the solver saw: the others keep an impulse of long ago.
            for solved in &manifold.data.solver_contacts {
                let index = solved.contact_indices()[0] as usize;
                let Some(point) = manifold.points.get(index).filter(|p| p.data.impulse > 0.0) else { continue };
                let local = if first { point.local_p1 } else { point.local_p2 };
                let force_n = push * (point.data.impulse / dt_s);
                visit(&HandContact { link, other, force: LinkForce { point_m: link_from_collider * local, force_n } });
            }
        }
    }
}
