//! Contact forces on the hand's links, read from rapier's narrow phase after a step.

use super::robot::Robot;
use super::tactile::LinkForce;
use rapier3d::prelude::*;
use tactus_common::limits::HAND_LINKS;

/// Most points of one patch: rapier solves at most four a manifold.
pub const PATCH_POINTS_MAX: usize = 4;

/// One contact between a hand link and anything else: a point, or the ends of a line, or the corners of an area.
#[derive(Clone, Copy, Debug)]
pub struct HandContact {
    /// Hand link, contact-matrix index.
    pub link: usize,
    /// The other collider.
    pub other: ColliderHandle,
    points: [LinkForce; PATCH_POINTS_MAX],
    count: usize,
}

impl HandContact {
    /// Where and how hard, in the link's frame.
    pub fn points(&self) -> &[LinkForce] {
        &self.points[..self.count]
    }

    /// Normal force, newtons.
    pub fn force_n(&self) -> f32 {
        self.points().iter().map(|p| p.force_n.length()).sum()
    }

    /// The force where it truly acts. Two rigid bodies that meet along a line are held apart by forces at its ends;
    /// the load itself lies along the line. So each pair of points carries its share as a line load with the same
    /// total and the same centre.
    pub fn along_the_patch(&self, mut visit: impl FnMut(&LinkForce)) {
        const PARTS: usize = 8;
        if self.count < 2 {
            self.points().iter().for_each(visit);
            return;
        }
        let share = 1.0 / (self.count - 1) as f32;
        for (i, a) in self.points().iter().enumerate() {
            for b in &self.points()[i + 1..] {
                let total_n = (a.force_n + b.force_n) * share;
                let sum = a.force_n.length() + b.force_n.length();
                let centre = if sum > 0.0 { b.force_n.length() / sum } else { 0.5 };
                // A linear density has its centre within the middle third; beyond, only part of the line bears.
                let (from, to) = if centre < 1.0 / 3.0 {
                    (0.0, 3.0 * centre)
                } else if centre > 2.0 / 3.0 {
                    (1.0 - 3.0 * (1.0 - centre), 1.0)
                } else {
                    (0.0, 1.0)
                };
                let width = to - from;
                let lean = if width > 0.0 { 6.0 * ((centre - from) / width - 0.5) } else { 0.0 };
                for part in 0..PARTS {
                    let t = (part as f32 + 0.5) / PARTS as f32;
                    let density = (1.0 + lean * (2.0 * t - 1.0)) / PARTS as f32;
                    let point_m = a.point_m + (b.point_m - a.point_m) * (from + width * t);
                    visit(&LinkForce { point_m, force_n: total_n * density });
                }
            }
        }
    }
}

/// Calls `visit` for every contact of the hand that carried a force in the last step of length `dt_s`.
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
            let none = LinkForce { point_m: Vector::ZERO, force_n: Vector::ZERO };
            let mut contact = HandContact { link, other, points: [none; PATCH_POINTS_MAX], count: 0 };
            // Only points that the solver saw: the others keep an impulse of long ago.
            for solved in manifold.data.solver_contacts.iter().take(PATCH_POINTS_MAX) {
                let index = solved.contact_indices()[0] as usize;
                let Some(point) = manifold.points.get(index).filter(|p| p.data.impulse > 0.0) else { continue };
                let local = if first { point.local_p1 } else { point.local_p2 };
                let force_n = push * (point.data.impulse / dt_s);
                contact.points[contact.count] = LinkForce { point_m: link_from_collider * local, force_n };
                contact.count += 1;
            }
            if contact.count > 0 {
                visit(&contact);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(left_n: f32, right_n: f32) -> HandContact {
        let force = |x: f32, n: f32| LinkForce { point_m: Vector::new(x, 0.0, 0.0), force_n: Vector::Y * n };
        let none = force(0.0, 0.0);
        HandContact {
            link: 3,
            other: ColliderHandle::invalid(),
            points: [force(0.0, left_n), force(0.02, right_n), none, none],
            count: 2,
        }
    }

    #[test]
    fn a_line_load_keeps_the_force_and_its_centre() {
        for (left_n, right_n) in [(1.0, 1.0), (2.0, 1.2), (0.3, 3.0)] {
            let (mut total_n, mut moment) = (0.0, 0.0);
            line(left_n, right_n).along_the_patch(|part| {
                assert!(part.force_n.y >= 0.0);
                total_n += part.force_n.y;
                moment += part.force_n.y * part.point_m.x;
            });
            assert!((total_n - left_n - right_n).abs() < 1e-5);
            let (centre, expected) = (moment / total_n, 0.02 * right_n / (left_n + right_n));
            assert!((centre - expected).abs() < 2e-4, "{centre} {expected}");
        }
    }
}
