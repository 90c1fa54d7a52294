//! Why a mission did not end as it should, in a sentence, and what may help.

use super::progress::lost_text;
use crate::mission::MissionReport;
use tactus_common::message::{FailureReason, FaultReason, Outcome, RefusalReason};

/// A sentence about the end of a mission; `None` if the object stands at its goal.
pub fn explanation(report: &MissionReport) -> Option<String> {
    if report.transported() {
        return None;
    }
    Some(match report.outcome {
        None => match &report.lost {
            Some(lost) => lost_text(lost),
            None => "the controller did not come to an end in the time allowed".into(),
        },
        Some(Outcome::Transported) => format!(
            "the controller put the object down where it believed its goal to be, which is {:.0} mm and {:.0} deg off, tilted by {:.0} deg",
            report.goal_position_error_m * 1e3,
            report.goal_yaw_error_rad.to_degrees(),
            report.final_tilt_rad.to_degrees()
        ),
        Some(Outcome::Failed(reason)) => failure(reason, report.trials),
        Some(Outcome::Fault(reason)) => fault(reason),
    })
}

fn failure(reason: FailureReason, touches: u32) -> String {
    match reason {
        FailureReason::NoPlan(reason) => {
            format!("the planner refused every motion that was asked for, the last because {}", refusal(reason))
        }
        FailureReason::NotConfident => {
            format!(
                "the touches allowed ({touches}) did not make the pose certain enough to grasp; --max-trials allows more"
            )
        }
        FailureReason::NothingFelt => {
            format!(
                "nothing was felt in the touches allowed ({touches}); is the object within the interval around the guess?"
            )
        }
        FailureReason::GraspMissed => "the fingers closed without holding the object, more than once".into(),
        FailureReason::ObjectLost => "the object left the hand on the way, more than once".into(),
    }
}

fn refusal(reason: RefusalReason) -> &'static str {
    match reason {
        RefusalReason::NoInverseKinematics => "no joint angles within the limits follow it",
        RefusalReason::OutOfReach => "the place is beyond the arm's reach",
        RefusalReason::StartInCollision => "the robot touches something where it stands",
        RefusalReason::GoalInCollision => "the robot would touch something at the end of it",
        RefusalReason::NoPath => "no way to it is free",
        RefusalReason::TooManyKnots => "it takes more knots than a trajectory holds",
        RefusalReason::NonFinite => "it was asked for with a value that is not finite",
    }
}

fn fault(reason: FaultReason) -> String {
    let joint = |number: u8| match number {
        0..7 => format!("J{}", number + 1),
        7..10 => format!("the motor of F{}", number - 6),
        _ => "the spread".into(),
    };
    match reason {
        FaultReason::HostSilent => "the controller heard no readings any more".into(),
        FaultReason::SensorInvalid => "a reading that the controller needs was not measured for several ticks".into(),
        FaultReason::JointLimit(number) => format!("{} left its range", joint(number)),
        FaultReason::JointSpeed(number) => format!("{} moved faster than it may", joint(number)),
        FaultReason::Tracking(number) => format!("{} did not go where it was told to; is it blocked?", joint(number)),
        FaultReason::BadSetup => "the controller refused the mission: a value of it makes no sense".into(),
        FaultReason::SchemaMismatch => {
            "the controller speaks another version of the messages; build both from the same source".into()
        }
        FaultReason::HostSlow => "the controller waited too long for the planner or the mental world".into(),
        FaultReason::NotInImage => {
            "the controller was built without this optimiser; build its image with --features optimizers".into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_joint_has_its_name() {
        let told = [0, 6, 7, 9, 10].map(|number| fault(FaultReason::Tracking(number)));
        for (told, name) in told.iter().zip(["J1 ", "J7 ", "the motor of F1 ", "the motor of F3 ", "the spread "]) {
            assert!(told.starts_with(name), "{told}");
        }
    }
}
