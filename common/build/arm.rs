//! What the closed-form kinematics takes for granted about the arm, checked, and its dimensions.

use crate::model::{FILE, expect_axis, expect_links, joint};
use crate::settings::Settings;
use urdf_rs::{Joint, JointType, Robot};

/// The dimensions of the arm that the closed-form inverse kinematics uses, metres.
pub struct Dimensions {
    pub shoulder_height_m: f64,
    pub upper_arm_m: f64,
    pub elbow_offset_m: f64,
    pub forearm_m: f64,
    pub flange_m: f64,
}

/// The seven joints in order, checked to form one chain.
pub fn joints<'a>(robot: &'a Robot, settings: &Settings) -> Result<Vec<&'a Joint>, String> {
    let mut parent = settings.arm.base.as_str();
    let mut chain = Vec::new();
    for name in &settings.arm.joints {
        let j = joint(robot, name, JointType::Revolute)?;
        expect_links(j, parent, &j.child.link)?;
        expect_axis(j, [0.0, 0.0, 1.0])?;
        parent = &j.child.link;
        chain.push(j);
    }
    let mount = joint(robot, &settings.hand.mount_joint, JointType::Fixed)?;
    expect_links(mount, parent, &settings.hand.links[0])?;
    chain.push(mount);
    Ok(chain)
}

/// Checks that the joints lie as the inverse kinematics needs them: spherical shoulder and wrist, axes turned by a
/// quarter turn about x in alternation, elbow offset there and back.
pub fn dimensions(chain: &[&Joint]) -> Result<Dimensions, String> {
    let quarter = std::f64::consts::FRAC_PI_2;
    let rolls = [0.0, -quarter, quarter, -quarter, quarter, -quarter, quarter, 0.0];
    let [offset, upper] = [chain[3].origin.xyz[0], chain[3].origin.xyz[2]];
    let expected = [
        [0.0, 0.0, chain[0].origin.xyz[2]],
        [0.0; 3],
        [0.0; 3],
        [offset, 0.0, upper],
        [-offset, 0.0, 0.0],
        [0.0, 0.0, chain[5].origin.xyz[2]],
        [0.0; 3],
        [0.0, 0.0, chain[7].origin.xyz[2]],
    ];
    for (i, j) in chain.iter().enumerate() {
        let rpy = j.origin.rpy.0;
        if (rpy[0] - rolls[i]).abs() > 1e-6 || rpy[1] != 0.0 || rpy[2] != 0.0 {
            return Err(format!("{FILE}: joint `{}`: origin rpy {rpy:?}; expected [{}, 0, 0]", j.name, rolls[i]));
        }
        if (0..3).any(|k| (j.origin.xyz[k] - expected[i][k]).abs() > 1e-9) {
            let xyz = j.origin.xyz.0;
            return Err(format!(
                "{FILE}: joint `{}`: origin xyz {xyz:?}; the closed-form inverse kinematics expects {:?}",
                j.name, expected[i]
            ));
        }
    }
    let d = Dimensions {
        shoulder_height_m: expected[0][2],
        upper_arm_m: upper,
        elbow_offset_m: offset,
        forearm_m: expected[5][2],
        flange_m: expected[7][2],
    };
    if [d.shoulder_height_m, d.upper_arm_m, d.elbow_offset_m, d.forearm_m, d.flange_m].iter().any(|l| *l <= 0.0) {
        return Err(format!(
            "{FILE}: arm: a length of the chain is 0 or less; expected shoulder, upper arm, elbow offset, forearm, flange above 0"
        ));
    }
    Ok(d)
}
