//! What keeps round things from rolling on for ever.
//!
//! Rapier has no rolling resistance: a ball once touched would roll off the table. A real one sinks a little into what
//! it stands on, so that the normal force acts ahead of its centre: a moment `c r N` against its turning, which also
//! holds it at rest against pushes up to `c N` (Coulomb's law of rolling friction).

use rapier3d::prelude::*;

/// Coefficient of rolling resistance `c`. A billiard ball on cloth has about 0.01 (Marlow, *The Physics of Pocket
/// Billiards*, 1995); household things are softer and less round than that. Assumed.
pub const ROLLING_RESISTANCE: f32 = 0.02;

/// A body that can roll.
#[derive(Clone, Copy, Debug)]
struct Roller {
    body: RigidBodyHandle,
    collider: ColliderHandle,
    radius_m: f32,
}

/// The bodies of a world that can roll.
#[derive(Clone, Debug, Default)]
pub struct Rolling {
    rollers: Vec<Roller>,
}

impl Rolling {
    /// Takes a body in that rolls on this radius.
    pub fn add(&mut self, body: RigidBodyHandle, collider: ColliderHandle, radius_m: f32) {
        self.rollers.push(Roller { body, collider, radius_m });
    }

    /// Slows the turning of each about horizontal axes, as its load in the last step demands: before each step.
    pub fn resist(&self, physics: &mut PhysicsWorld) {
        for roller in &self.rollers {
            let impulse_ns = load_impulse_ns(physics, roller.collider);
            let Some(body) = physics.bodies.get_mut(roller.body) else { continue };
            let turning = body.angvel();
            let rolling = Vector::new(turning.x, turning.y, 0.0);
            let speed_rad_s = rolling.length();
            if impulse_ns <= 0.0 || speed_rad_s <= 0.0 {
                continue;
            }
            let moment_nms = rolling * (ROLLING_RESISTANCE * roller.radius_m * impulse_ns / speed_rad_s);
            let slowed = body.mass_properties().effective_world_inv_inertia * moment_nms;
            // It stops the turning, and never turns it round.
            let part = (rolling.dot(slowed) / (speed_rad_s * speed_rad_s)).min(1.0);
            let after = turning - rolling * part;
            body.set_angvel(after, false);
        }
    }
}

/// Normal impulse of the last step between a body and what is not the hand, newton seconds.
fn load_impulse_ns(physics: &PhysicsWorld, collider: ColliderHandle) -> f32 {
    let is_hand = |other: ColliderHandle| physics.colliders.get(other).is_some_and(|c| c.user_data != 0);
    let mut impulse_ns = 0.0;
    for pair in physics.narrow_phase.contact_pairs_with(collider) {
        let other = if pair.collider1 == collider { pair.collider2 } else { pair.collider1 };
        if is_hand(other) {
            continue;
        }
        for manifold in pair.manifolds() {
            for solved in &manifold.data.solver_contacts {
                let point = manifold.points.get(solved.contact_indices()[0] as usize);
                impulse_ns += point.map_or(0.0, |p| p.data.impulse.max(0.0));
            }
        }
    }
    impulse_ns
}
