//! Progress of one mission, one line an event: what the hand felt and what the controller made of it.

use crate::mission::Progressed;
use tactus_common::message::{EventKind, Phase};

/// Prints progress unless told to be quiet.
pub struct Progress {
    quiet: bool,
}

/// Names of the tactile sources, by index.
const FINGER: [&str; 4] = ["F1", "F2", "F3", "palm"];

impl Progress {
    /// Progress on standard error; `quiet` prints nothing.
    pub fn new(quiet: bool) -> Self {
        Self { quiet }
    }

    /// Shows one event.
    pub fn show(&mut self, event: &Progressed) {
        if self.quiet {
            return;
        }
        let Some(text) = describe(event) else { return };
        eprintln!("{:7.3} s  {text}", event.time_s);
    }

    /// Ends the display.
    pub fn finish(&mut self) {}
}

/// One line for an event; `None` for one that would only repeat another.
fn describe(event: &Progressed) -> Option<String> {
    let text = match event.kind {
        EventKind::Phase(Phase::Trial | Phase::Update | Phase::Plan) => return None,
        EventKind::Phase(phase) => format!("{phase:?}"),
        EventKind::Touch { candidate, information_nats } => {
            format!("Touch {candidate}: {information_nats:.1} nats expected")
        }
        EventKind::Contact { finger, inner_rad, descending } => {
            let name = FINGER.get(usize::from(finger)).copied().unwrap_or("?");
            let how = if descending { "coming down" } else { "closing" };
            format!("  {name} feels something {how}, at {:.1} deg", inner_rad.to_degrees())
        }
        EventKind::Updated { belief, covariance, evaluations, modes, confident } => format!(
            "  belief ({:+.1}, {:+.1}) mm, {:+.2} deg; sd {:.1}, {:.1} mm, {:.2} deg; {modes} mode{}; {evaluations} evaluations{}",
            belief.x_m * 1e3,
            belief.y_m * 1e3,
            belief.phi_rad.to_degrees(),
            sd(covariance[0]) * 1e3,
            sd(covariance[3]) * 1e3,
            sd(covariance[5]).to_degrees(),
            if modes == 1 { "" } else { "s" },
            if confident { "; certain enough to grasp" } else { "" }
        ),
        EventKind::Confirmed(true) => "  the mental world foretells the same".to_owned(),
        EventKind::Confirmed(false) => "  the mental world foretells something else: touch again".to_owned(),
        EventKind::Refused(reason) => format!("  planner: {reason:?}; next best"),
        EventKind::Finished(outcome) => format!("{outcome:?}"),
    };
    Some(text)
}

fn sd(variance: f32) -> f32 {
    libm::sqrtf(variance.max(0.0))
}
