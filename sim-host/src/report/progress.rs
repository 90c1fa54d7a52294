//! Progress of one mission, one line an event: what the hand felt and what the controller made of it.

use crate::host::Lost;
use crate::observer::{Observer, Seen};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use tactus_common::limits::TICK_S;
use tactus_common::message::{Event, EventKind, Phase, Status};

/// Shows progress on a terminal: a line an event, and below them what the controller thinks now.
pub struct Progress {
    bar: Option<ProgressBar>,
}

/// Names of the tactile sources, by index.
const FINGER: [&str; 4] = ["F1", "F2", "F3", "palm"];

impl Progress {
    /// Progress on standard error, if that is a terminal and `quiet` is not wanted.
    pub fn new(quiet: bool) -> Self {
        let wanted = !quiet && std::io::stderr().is_terminal();
        Self { bar: wanted.then(spinner) }
    }

    /// Ends the display.
    pub fn finish(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Progress {
    fn see(&mut self, seen: &Seen) -> anyhow::Result<()> {
        let Some(bar) = &self.bar else { return Ok(()) };
        if let Some(lost) = &seen.lost {
            bar.println(format!("{:7.3} s  {}", lost.tick as f32 * TICK_S, lost_text(lost)));
        }
        for event in &seen.heard.events {
            if let Some(text) = describe(event) {
                bar.println(format!("{:7.3} s  {text}", event.tick as f32 * TICK_S));
            }
        }
        if let Some(status) = &seen.heard.status {
            bar.set_message(thought(status));
            bar.tick();
        }
        Ok(())
    }
}

/// One line about a controller that stopped answering.
pub fn lost_text(lost: &Lost) -> String {
    format!("controller lost in phase {:?}: no command since tick {}; the drives let go", lost.phase, lost.tick)
}

fn spinner() -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    // The template is a constant; without it the default does.
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
        bar.set_style(style);
    }
    bar
}

/// One line about what the controller thinks.
fn thought(status: &Status) -> String {
    format!(
        "{:7.3} s  {:?}: object at ({:+.1}, {:+.1}) mm, {:+.1} deg; sd {:.1}, {:.1} mm, {:.1} deg",
        status.tick as f32 * TICK_S,
        status.phase,
        status.belief.x_m * 1e3,
        status.belief.y_m * 1e3,
        status.belief.phi_rad.to_degrees(),
        sd(status.covariance[0]) * 1e3,
        sd(status.covariance[3]) * 1e3,
        sd(status.covariance[5]).to_degrees(),
    )
}

/// One line for an event; `None` for one that would only repeat another.
pub fn describe(event: &Event) -> Option<String> {
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
        EventKind::Slip { finger, sureness, grip_nm } => {
            let name = FINGER.get(usize::from(finger)).copied().unwrap_or("?");
            format!("  {name} feels the box slip ({:.0} % sure): it pushes with {grip_nm:.2} Nm", sureness * 100.0)
        }
        EventKind::Finished(outcome) => format!("{outcome:?}"),
    };
    Some(text)
}

fn sd(variance: f32) -> f32 {
    libm::sqrtf(variance.max(0.0))
}
