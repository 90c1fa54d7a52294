//! Worlds for controllers that come by themselves.

use crate::mission::{self, MissionOptions, MissionReport};
use crate::observer::Observer;
use crate::report::progress::lost_text;
use crate::wire::Wire;
use std::time::Duration;
use tactus_hil::choice::Pace;

/// A world waits for ever, this long at a time.
const PATIENCE: Duration = Duration::from_secs(1);

/// Waits for a controller at the other end of `wire`, carries the mission out with it, hands the report to `done`; and
/// so on until `missions` have come to an end. A controller that is lost on the way does not count: the world is set up
/// anew for the next one. Returns the last report.
///
/// # Errors
/// The scene cannot be simulated, or the bus broke down.
pub fn serve(
    options: &MissionOptions,
    pace: Pace,
    missions: u32,
    wire: &mut dyn Wire,
    log: &mut dyn FnMut(&str),
    observer: &mut dyn Observer,
) -> anyhow::Result<MissionReport> {
    let mut ended = 0;
    loop {
        log("waiting for a controller");
        meet(wire, log);
        log(&format!("mission {} begins (seed {})", ended + 1, options.seed));
        let report = mission::run_on(options, pace, wire, observer)?;
        if let Some(lost) = &report.lost {
            log(&lost_text(lost));
            if let Some(tick) = report.released {
                log(&format!("the arm is released: no torque since tick {tick}; the world is set up anew"));
            }
            continue;
        }
        ended += 1;
        log(&format!("mission {ended} over: {}", report.outcome_text()));
        if ended == missions {
            return Ok(report);
        }
    }
}

/// Waits for a controller that speaks this world's version; says once why another one will not do.
fn meet(wire: &mut dyn Wire, log: &mut dyn FnMut(&str)) {
    let mut said = String::new();
    loop {
        match wire.meet(PATIENCE) {
            Ok(true) => return,
            Ok(false) => {}
            Err(error) => {
                let why = format!("{error:#}");
                if why != said {
                    log(&why);
                }
                said = why;
            }
        }
    }
}
