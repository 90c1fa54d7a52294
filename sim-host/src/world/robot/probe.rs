//! What the physics tests change and measure on the robot.

use super::Robot;
use rapier3d::prelude::*;

impl Robot {
    /// Sets arm damping and dry friction to zero, keeping the rotors' inertia.
    pub fn make_frictionless(&self, world: &mut PhysicsWorld, keep_damping: bool) {
        if let Some(multibody) = self.multibody_mut(world) {
            for joint in &self.arm {
                let k = multibody.link(joint.link_id).map_or(0, MultibodyLink::assembly_id);
                multibody.frictions_mut()[k] = 0.0;
                if !keep_damping {
                    multibody.damping_mut()[k] = 0.0;
                }
            }
        }
    }

    /// Takes all viscous damping away.
    pub fn remove_all_damping(&self, world: &mut PhysicsWorld) {
        if let Some(multibody) = self.multibody_mut(world) {
            multibody.damping_mut().fill(0.0);
        }
    }

    /// Takes the limits off the arm's joints.
    pub fn remove_limits(&self, world: &mut PhysicsWorld) {
        if let Some(multibody) = self.multibody_mut(world) {
            for joint in &self.arm {
                if let Some(link) = multibody.link_mut(joint.link_id) {
                    link.joint.data.limit_axes = JointAxesMask::empty();
                }
            }
        }
    }

    /// Joint-space inertia M(q) by its definition over the bodies, rotors included (f64), and the joints' velocities.
    pub fn inertia_and_velocity(&self, world: &PhysicsWorld) -> (nalgebra::DMatrix<f64>, nalgebra::DVector<f64>) {
        let multibody = self.multibody(world).expect("the robot is there");
        let n = multibody.ndofs();
        let mut inertia = nalgebra::DMatrix::<f64>::from_diagonal(&multibody.armature().map(f64::from));
        for (id, link) in multibody.links().enumerate().skip(1) {
            let body = world.bodies.get(link.rigid_body_handle()).expect("every link has a body");
            let jacobian = multibody.body_jacobian(id).map(f64::from);
            let properties = &body.mass_properties().local_mprops;
            let turn = body.position().rotation * properties.principal_inertia_local_frame;
            let principal = properties.principal_inertia();
            let axes = [Vector::X, Vector::Y, Vector::Z].map(|axis| turn * axis);
            for k in 0..3 {
                let linear = jacobian.row(k);
                inertia += linear.transpose() * linear * f64::from(body.mass());
                let axis = nalgebra::RowVector3::new(axes[k].x, axes[k].y, axes[k].z).map(f64::from);
                let angular = axis * jacobian.rows(3, 3);
                inertia += angular.transpose() * angular * f64::from(principal[k]);
            }
        }
        (inertia, nalgebra::DVector::from_fn(n, |i, _| f64::from(multibody.generalized_velocity()[i])))
    }

    /// Potential energy of the robot's links in the world's gravity, joules (f64).
    pub fn potential_energy_j(&self, world: &PhysicsWorld) -> f64 {
        let Some(multibody) = self.multibody(world) else { return 0.0 };
        let g = world.gravity;
        let mut energy = 0.0;
        for link in multibody.links().skip(1) {
            if let Some(body) = world.bodies.get(link.rigid_body_handle()) {
                let properties = body.mass_properties();
                let com = *body.position() * properties.local_mprops.local_com;
                let height = f64::from(g.x) * f64::from(com.x)
                    + f64::from(g.y) * f64::from(com.y)
                    + f64::from(g.z) * f64::from(com.z);
                energy -= f64::from(body.mass()) * height;
            }
        }
        energy
    }
}
