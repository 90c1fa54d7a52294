//! Safety: which conditions make the robot safe, and what safe means.
//!
//! Two safe states. **Hold**: the arm stays where it is under gravity compensation and a position law, the fingers
//! stand (their worm gears hold by themselves). **Limp**: no torque at all; taken when the arm's angles are not
//! known, because gravity compensation without angles pushes blindly. Modes only ever become safer; a new set-up
//! starts afresh.

use tactus_common::limits::{ARM_JOINTS, SILENCE_TICKS_MAX};
use tactus_common::message::FaultReason;
use tactus_common::reading::JointReadings;
use tactus_common::robot::ARM_LIMITS;

/// Ticks in a row that a needed reading may be missing.
const INVALID_TICKS_MAX: u8 = 3;
/// A joint may be measured this far outside its range before it counts as out, radians.
const LIMIT_MARGIN_RAD: f32 = 0.02;
/// A joint may be this much faster than its limit for measurement noise, factor.
const SPEED_MARGIN: f32 = 1.3;
/// A joint that is this far from its reference does not follow it, radians (about 6 cm at the hand).
const TRACKING_MAX_RAD: f32 = 0.1;

/// What the robot does as a whole, from free to safest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mode {
    /// The mission commands.
    Run,
    /// Holds still.
    Hold,
    /// No torque.
    Limp,
}

impl Mode {
    /// Every mode.
    pub const ALL: [Self; 3] = [Self::Run, Self::Hold, Self::Limp];
}

/// What can be wrong, in order of gravity; the first that holds names the fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// No sensor message for [`SILENCE_TICKS_MAX`] ticks.
    Silent,
    /// A needed reading missing for more than three ticks.
    Invalid,
    /// A joint outside its range.
    Limit,
    /// A joint too fast.
    Speed,
    /// A joint that does not follow.
    Tracking,
    /// The mission itself found something wrong.
    Mission,
}

impl Condition {
    /// Every condition, gravest first.
    pub const ALL: [Self; 6] = [Self::Silent, Self::Invalid, Self::Limit, Self::Speed, Self::Tracking, Self::Mission];

    /// The mode that it demands.
    pub const fn demands(self) -> Mode {
        match self {
            Self::Silent | Self::Invalid => Mode::Limp,
            Self::Limit | Self::Speed | Self::Tracking | Self::Mission => Mode::Hold,
        }
    }
}

/// A set of conditions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Conditions(u8);

impl Conditions {
    /// With `condition` added.
    #[must_use]
    pub const fn with(self, condition: Condition) -> Self {
        Self(self.0 | 1 << condition as u8)
    }

    /// Does `condition` hold?
    pub const fn has(self, condition: Condition) -> bool {
        self.0 & 1 << condition as u8 != 0
    }
}

/// The next mode: the safest of the present one and all that is demanded.
pub fn step(mode: Mode, conditions: Conditions) -> Mode {
    let mut next = mode;
    for condition in Condition::ALL {
        if conditions.has(condition) {
            next = next.max(condition.demands());
        }
    }
    next
}

/// The supervisor's memory: counts, the mode and the first fault.
#[derive(Clone, Copy, Debug)]
pub struct Supervisor {
    silent_ticks: u32,
    invalid_ticks: u8,
    mode: Mode,
    fault: Option<FaultReason>,
}

impl Default for Supervisor {
    fn default() -> Self {
        Self { silent_ticks: 0, invalid_ticks: 0, mode: Mode::Run, fault: None }
    }
}

impl Supervisor {
    /// The mode.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// The first fault, if there was one.
    pub fn fault(&self) -> Option<FaultReason> {
        self.fault
    }

    /// Looks at one tick. `readings` is `None` if no sensor message came; `qd_rad_s` is the velocity estimate;
    /// `q_ref_rad` the reference of the tick before; `mission` a fault that the mission reports.
    pub fn assess(
        &mut self,
        readings: Option<&JointReadings>,
        qd_rad_s: &[f32; ARM_JOINTS],
        q_ref_rad: Option<&[f32; ARM_JOINTS]>,
        mission: Option<FaultReason>,
    ) -> Mode {
        let mut conditions = Conditions::default();
        let mut reason = mission;
        let mut joint_reason = None;
        match readings {
            None => self.silent_ticks = self.silent_ticks.saturating_add(1),
            Some(r) if r.valid.arm() && r.valid.hand() => {
                self.silent_ticks = 0;
                self.invalid_ticks = 0;
                joint_reason = worst_joint(r, qd_rad_s, q_ref_rad);
            }
            Some(_) => {
                self.silent_ticks = 0;
                self.invalid_ticks = self.invalid_ticks.saturating_add(1);
            }
        }
        if mission.is_some() {
            conditions = conditions.with(Condition::Mission);
        }
        if let Some((condition, why)) = joint_reason {
            conditions = conditions.with(condition);
            reason = Some(why);
        }
        if self.invalid_ticks > INVALID_TICKS_MAX {
            conditions = conditions.with(Condition::Invalid);
            reason = Some(FaultReason::SensorInvalid);
        }
        if self.silent_ticks >= SILENCE_TICKS_MAX {
            conditions = conditions.with(Condition::Silent);
            reason = Some(FaultReason::HostSilent);
        }
        self.mode = step(self.mode, conditions);
        if self.mode != Mode::Run && self.fault.is_none() {
            self.fault = reason;
        }
        self.mode
    }
}

/// The gravest thing wrong with a joint.
fn worst_joint(
    readings: &JointReadings,
    qd_rad_s: &[f32; ARM_JOINTS],
    q_ref_rad: Option<&[f32; ARM_JOINTS]>,
) -> Option<(Condition, FaultReason)> {
    let q = &readings.arm_q_rad;
    let out = |j: &usize| {
        q[*j] < ARM_LIMITS[*j].lower_rad - LIMIT_MARGIN_RAD || q[*j] > ARM_LIMITS[*j].upper_rad + LIMIT_MARGIN_RAD
    };
    if let Some(j) = (0..ARM_JOINTS).find(out) {
        return Some((Condition::Limit, FaultReason::JointLimit(j as u8)));
    }
    let fast = |j: &usize| qd_rad_s[*j].abs() > ARM_LIMITS[*j].velocity_rad_s * SPEED_MARGIN;
    if let Some(j) = (0..ARM_JOINTS).find(fast) {
        return Some((Condition::Speed, FaultReason::JointSpeed(j as u8)));
    }
    let reference = q_ref_rad?;
    let astray = |j: &usize| (reference[*j] - q[*j]).abs() > TRACKING_MAX_RAD;
    (0..ARM_JOINTS).find(astray).map(|j| (Condition::Tracking, FaultReason::Tracking(j as u8)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tactus_common::reading::Validity;

    fn readings() -> JointReadings {
        JointReadings {
            tick: 0,
            arm_q_rad: [0.0; 7],
            motor_q_rad: [0.0; 4],
            inner_q_rad: [0.0; 3],
            effort_nm: [0.0; 4],
            tip_torque_nm: [0.0; 3],
            valid: Validity::ALL,
        }
    }

    #[test]
    fn from_every_mode_and_set_of_conditions_the_safest_demand_wins_and_nothing_becomes_less_safe() {
        for mode in Mode::ALL {
            for bits in 0..1_u8 << Condition::ALL.len() {
                let next = step(mode, Conditions(bits));
                assert!(next >= mode);
                for condition in Condition::ALL {
                    if Conditions(bits).has(condition) {
                        assert!(next >= condition.demands(), "{mode:?} {bits:b} -> {next:?}");
                    }
                }
                assert!(bits != 0 || next == mode, "nothing wrong, nothing changes");
            }
        }
    }

    #[test]
    fn silence_makes_limp_at_the_twentieth_tick_and_not_before() {
        let mut s = Supervisor::default();
        for tick in 1..SILENCE_TICKS_MAX {
            assert_eq!(s.assess(None, &[0.0; 7], None, None), Mode::Run, "tick {tick}");
        }
        assert_eq!(s.assess(None, &[0.0; 7], None, None), Mode::Limp);
        assert_eq!(s.fault(), Some(FaultReason::HostSilent));
        assert_eq!(s.assess(Some(&readings()), &[0.0; 7], None, None), Mode::Limp, "stays safe");
    }

    #[test]
    fn one_invalid_tick_is_bridged_four_are_not() {
        let mut s = Supervisor::default();
        let mut bad = readings();
        bad.valid = Validity(Validity::ALL.0 & !1);
        for _ in 0..INVALID_TICKS_MAX {
            assert_eq!(s.assess(Some(&bad), &[0.0; 7], None, None), Mode::Run);
        }
        assert_eq!(s.assess(Some(&readings()), &[0.0; 7], None, None), Mode::Run);
        for _ in 0..=INVALID_TICKS_MAX {
            s.assess(Some(&bad), &[0.0; 7], None, None);
        }
        assert_eq!((s.mode(), s.fault()), (Mode::Limp, Some(FaultReason::SensorInvalid)));
    }

    #[test]
    fn a_joint_out_of_range_too_fast_or_astray_is_held_and_named() {
        let mut out = readings();
        out.arm_q_rad[1] = ARM_LIMITS[1].upper_rad + 0.03;
        let mut s = Supervisor::default();
        assert_eq!(s.assess(Some(&out), &[0.0; 7], None, None), Mode::Hold);
        assert_eq!(s.fault(), Some(FaultReason::JointLimit(1)));
        let mut s = Supervisor::default();
        let mut fast = [0.0; 7];
        fast[6] = -ARM_LIMITS[6].velocity_rad_s * 1.4;
        assert_eq!(s.assess(Some(&readings()), &fast, None, None), Mode::Hold);
        assert_eq!(s.fault(), Some(FaultReason::JointSpeed(6)));
        let mut s = Supervisor::default();
        let mut reference = [0.0; 7];
        reference[3] = 0.11;
        assert_eq!(s.assess(Some(&readings()), &[0.0; 7], Some(&reference), None), Mode::Hold);
        assert_eq!(s.fault(), Some(FaultReason::Tracking(3)));
    }
}
