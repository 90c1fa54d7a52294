//! Kinematics and dynamics against an independent model: the URDF loaded at run time, in f64, through energies.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use nalgebra::{Isometry3, Matrix3, Point3, SMatrix, Translation3, UnitQuaternion, Vector3};
use tactus_common::robot::source::URDF;
use tactus_common::robot::tables::{ARM_LIMITS, GRASP_POINT_Z_M, ROTOR_INERTIA_KG_M2};
use tactus_common::robot::{arm, dynamics};

const ARM: usize = 7;

/// A moving body: the joints that carry it, its pose in the last of these, mass, inertia about its origin's COM.
struct Body {
    in_last: Isometry3<f64>,
    joints: usize,
    mass: f64,
    com: Point3<f64>,
    inertia: Matrix3<f64>,
}

struct Model {
    origins: Vec<Isometry3<f64>>,
    bodies: Vec<Body>,
}

fn isometry(pose: &urdf_rs::Pose) -> Isometry3<f64> {
    let ([x, y, z], [r, p, w]) = (pose.xyz.0, pose.rpy.0);
    Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_euler_angles(r, p, w))
}

impl Model {
    /// Arm from the URDF; the hand's links fixed with the inner joints at half their range, the tips as their mimics say.
    fn load() -> Self {
        let robot = urdf_rs::read_from_string(URDF).unwrap();
        let joint = |child: &str| robot.joints.iter().find(|j| j.child.link == child);
        let mut model = Self { origins: Vec::new(), bodies: Vec::new() };
        for i in 1..=ARM {
            model.origins.push(isometry(&joint(&format!("wam_link{i}")).unwrap().origin));
        }
        for link in robot.links.iter().filter(|l| l.name != "wam_base") {
            let (mut pose, mut name) = (Isometry3::identity(), link.name.clone());
            while !name.starts_with("wam_link") {
                let j = joint(&name).unwrap();
                let half = 0.5 * j.limit.upper;
                let angle = match (&j.mimic, j.name.contains("spread"), j.joint_type == urdf_rs::JointType::Fixed) {
                    (_, true, _) | (_, _, true) => 0.0,
                    (Some(m), ..) => {
                        m.multiplier.unwrap()
                            * 0.5
                            * robot.joints.iter().find(|k| k.name == m.joint).unwrap().limit.upper
                    }
                    (None, ..) => half,
                };
                let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
                pose = isometry(&j.origin) * turn * pose;
                name = j.parent.link.clone();
            }
            let i = &link.inertial.inertia;
            model.bodies.push(Body {
                in_last: pose,
                joints: name.trim_start_matches("wam_link").parse().unwrap(),
                mass: link.inertial.mass.value,
                com: Point3::from(link.inertial.origin.xyz.0),
                inertia: Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz),
            });
        }
        model
    }

    fn with_payload(mut self, mass: f64) -> Self {
        let com = Point3::new(0.0, 0.0, 0.06 + f64::from(GRASP_POINT_Z_M));
        self.bodies.push(Body { in_last: Isometry3::identity(), joints: ARM, mass, com, inertia: Matrix3::zeros() });
        self
    }

    fn poses(&self, q: &[f64; ARM]) -> Vec<Isometry3<f64>> {
        let mut pose = Isometry3::identity();
        let step = |(i, origin): (usize, &Isometry3<f64>)| {
            pose = pose * origin * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), q[i]);
            pose
        };
        self.origins.iter().enumerate().map(step).collect()
    }

    fn potential(&self, q: &[f64; ARM]) -> f64 {
        let poses = self.poses(q);
        self.bodies.iter().map(|b| b.mass * 9.81 * (poses[b.joints - 1] * b.in_last * b.com).z).sum()
    }

    fn mass_matrix(&self, q: &[f64; ARM]) -> SMatrix<f64, ARM, ARM> {
        let poses = self.poses(q);
        let mut m = SMatrix::<f64, ARM, ARM>::zeros();
        for b in &self.bodies {
            let pose = poses[b.joints - 1] * b.in_last;
            let (at, turn) = (pose * b.com, pose.rotation.to_rotation_matrix());
            let (mut jv, mut jw) = (SMatrix::<f64, 3, ARM>::zeros(), SMatrix::<f64, 3, ARM>::zeros());
            for (k, carrier) in poses.iter().enumerate().take(b.joints) {
                let axis = carrier.rotation * Vector3::z();
                jv.set_column(k, &axis.cross(&(at.coords - carrier.translation.vector)));
                jw.set_column(k, &axis);
            }
            m += jv.transpose() * jv * b.mass + jw.transpose() * (turn * b.inertia * turn.transpose()) * jw;
        }
        for k in 0..ARM {
            m[(k, k)] += f64::from(ROTOR_INERTIA_KG_M2[k]);
        }
        m
    }

    /// Lagrange: tau = M qdd + dM/dt qd - 1/2 d(qd' M qd)/dq + dV/dq, derivatives by central differences.
    fn torque(&self, q: &[f64; ARM], qd: &[f64; ARM], qdd: &[f64; ARM]) -> [f64; ARM] {
        let h = 1e-5;
        let moved = |k: usize, by: f64| {
            let mut p = *q;
            p[k] += by;
            p
        };
        let (v, a) = (SMatrix::<f64, ARM, 1>::from(*qd), SMatrix::<f64, ARM, 1>::from(*qdd));
        let mut tau = self.mass_matrix(q) * a;
        for k in 0..ARM {
            let slope = (self.mass_matrix(&moved(k, h)) - self.mass_matrix(&moved(k, -h))) / (2.0 * h);
            tau += slope * v * v[k];
            tau[k] -= 0.5 * (v.transpose() * slope * v)[0];
            tau[k] += (self.potential(&moved(k, h)) - self.potential(&moved(k, -h))) / (2.0 * h);
        }
        std::array::from_fn(|k| tau[k])
    }
}

/// Numbers in -1..1 from a fixed sequence.
fn unit(state: &mut u32) -> f32 {
    *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    (*state >> 8) as f32 / (1 << 23) as f32 - 1.0
}

fn configuration(state: &mut u32) -> [f32; ARM] {
    std::array::from_fn(|k| {
        let l = &ARM_LIMITS[k];
        0.5 * (l.lower_rad + l.upper_rad) + 0.5 * unit(state) * (l.upper_rad - l.lower_rad)
    })
}

#[test]
fn link_poses_are_those_of_the_urdf() {
    let (model, mut state) = (Model::load(), 5);
    for _ in 0..500 {
        let q = configuration(&mut state);
        let expected = model.poses(&q.map(f64::from));
        for (got, wanted) in arm::link_poses_from(&Isometry3::identity(), &q).iter().zip(&expected) {
            let got: Isometry3<f64> = got.cast();
            assert!((got.translation.vector - wanted.translation.vector).norm() < 2e-6);
            assert!(got.rotation.angle_to(&wanted.rotation) < 2e-6);
        }
    }
}

#[test]
fn torques_are_those_of_lagrange() {
    for payload in [0.0_f32, 0.6] {
        let (model, mut state) = (Model::load().with_payload(f64::from(payload)), 11);
        for _ in 0..200 {
            let q = configuration(&mut state);
            let qd = std::array::from_fn(|_| 2.0 * unit(&mut state));
            let qdd = std::array::from_fn(|_| 5.0 * unit(&mut state));
            let expected = model.torque(&q.map(f64::from), &qd.map(f64::from), &qdd.map(f64::from));
            let got = dynamics::inverse_dynamics(&q, &qd, &qdd, payload);
            for k in 0..ARM {
                assert!((f64::from(got[k]) - expected[k]).abs() < 1e-4, "J{}: {} for {}", k + 1, got[k], expected[k]);
            }
        }
    }
}

#[test]
fn gravity_is_the_slope_of_the_potential_energy() {
    let (model, mut state) = (Model::load(), 23);
    for _ in 0..500 {
        let q = configuration(&mut state);
        let expected = model.torque(&q.map(f64::from), &[0.0; ARM], &[0.0; ARM]);
        let got = dynamics::gravity(&q, 0.0);
        for k in 0..ARM {
            assert!((f64::from(got[k]) - expected[k]).abs() < 5e-5, "J{}: {} for {}", k + 1, got[k], expected[k]);
        }
    }
}
