//! Looking things up in the URDF, with a clear message for whatever is missing or wrong.

use crate::spatial::{Body, Frame, from_rpy};
use urdf_rs::{Joint, JointType, Link, Robot};

/// Name used in messages.
pub const FILE: &str = "models/wam7_bh280.urdf";

/// Parses the URDF and checks every inertial in it.
pub fn parse(text: &str) -> Result<Robot, String> {
    let robot =
        urdf_rs::read_from_string(text).map_err(|e| format!("{FILE}: not a readable URDF: {e}").replace('\n', " "))?;
    robot.links.iter().try_for_each(check_inertial)?;
    Ok(robot)
}

/// The one link of that name.
pub fn link<'a>(robot: &'a Robot, name: &str) -> Result<&'a Link, String> {
    robot
        .links
        .iter()
        .find(|l| l.name == name)
        .ok_or_else(|| format!("{FILE}: no link `{name}`; expected one (named in the TOML)"))
}

/// The one joint of that name, of the expected kind.
pub fn joint<'a>(robot: &'a Robot, name: &str, kind: JointType) -> Result<&'a Joint, String> {
    let joint = robot.joints.iter().find(|j| j.name == name);
    let joint = joint.ok_or_else(|| format!("{FILE}: no joint `{name}`; expected one (named in the TOML)"))?;
    if joint.joint_type != kind {
        return Err(format!("{FILE}: joint `{name}` is {:?}; expected {kind:?}", joint.joint_type));
    }
    if kind != JointType::Fixed {
        check_limit(joint)?;
    }
    Ok(joint)
}

/// The joint must connect `parent` to `child`.
pub fn expect_links(joint: &Joint, parent: &str, child: &str) -> Result<(), String> {
    if joint.parent.link == parent && joint.child.link == child {
        return Ok(());
    }
    let (p, c) = (&joint.parent.link, &joint.child.link);
    Err(format!("{FILE}: joint `{}` connects `{p}` to `{c}`; expected `{parent}` to `{child}`", joint.name))
}

/// The joint's axis must be `axis`.
pub fn expect_axis(joint: &Joint, axis: [f64; 3]) -> Result<(), String> {
    if (0..3).all(|i| (joint.axis.xyz[i] - axis[i]).abs() < 1e-9) {
        return Ok(());
    }
    Err(format!("{FILE}: joint `{}` has axis {:?}; expected {axis:?}", joint.name, joint.axis.xyz.0))
}

/// The joint's origin as a frame (parent from child at zero).
pub fn origin(joint: &Joint) -> Frame {
    Frame { rotation: from_rpy(&joint.origin.rpy.0), xyz_m: joint.origin.xyz.0 }
}

/// A link's mass, centre of mass and inertia, in the link's axes.
pub fn body(link: &Link) -> Body {
    let i = &link.inertial.inertia;
    let inertia = [[i.ixx, i.ixy, i.ixz], [i.ixy, i.iyy, i.iyz], [i.ixz, i.iyz, i.izz]];
    Body { mass_kg: link.inertial.mass.value, com_m: link.inertial.origin.xyz.0, inertia }
}

fn check_limit(joint: &Joint) -> Result<(), String> {
    let (name, l) = (&joint.name, &joint.limit);
    if !(l.lower.is_finite() && l.upper.is_finite() && l.lower < l.upper) {
        return Err(format!(
            "{FILE}: joint `{name}`: limits {} .. {}; expected lower < upper, radians",
            l.lower, l.upper
        ));
    }
    if !(l.velocity.is_finite() && l.velocity > 0.0 && l.effort.is_finite() && l.effort > 0.0) {
        return Err(format!(
            "{FILE}: joint `{name}`: velocity {}, effort {}; expected both above 0",
            l.velocity, l.effort
        ));
    }
    match &joint.dynamics {
        Some(d) if d.damping.is_finite() && d.damping >= 0.0 => Ok(()),
        Some(d) => Err(format!("{FILE}: joint `{name}`: damping {}; expected 0 or more, N m s/rad", d.damping)),
        None => Err(format!("{FILE}: joint `{name}` has no <dynamics damping=...>; expected one")),
    }
}

/// A real body has mass, and its moments of inertia satisfy the triangle inequality (checked on the diagonal).
fn check_inertial(link: &Link) -> Result<(), String> {
    let (name, b) = (&link.name, body(link));
    if !(b.mass_kg.is_finite() && b.mass_kg > 0.0) {
        return Err(format!("{FILE}: link `{name}`: mass {}; expected above 0 kg", b.mass_kg));
    }
    if link.inertial.origin.rpy.0 != [0.0; 3] {
        return Err(format!("{FILE}: link `{name}`: inertial is turned; expected rpy 0 0 0 (inertia in link axes)"));
    }
    let m = b.inertia;
    let minors = [m[0][0], m[0][0] * m[1][1] - m[0][1] * m[0][1], determinant(&m)];
    let triangle = m[0][0] + m[1][1] >= m[2][2] && m[1][1] + m[2][2] >= m[0][0] && m[2][2] + m[0][0] >= m[1][1];
    if minors.iter().all(|d| d.is_finite() && *d > 0.0) && triangle {
        return Ok(());
    }
    Err(format!(
        "{FILE}: link `{name}`: inertia {m:?} is not that of a body; expected positive definite, each moment at most the sum of the others"
    ))
}

fn determinant(m: &[[f64; 3]; 3]) -> f64 {
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}
