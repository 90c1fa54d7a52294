//! `cmaes`: knows no bounds; see [`super::counted`] for what it finds outside.

use super::{SEED, STEP, contender};
use crate::Contender;
use cmaes::{CMAESOptions, DVector};

/// The one there is.
pub fn all() -> Vec<Contender> {
    let note = "without bounds (outside: the nearest pose within, plus a parabola), no slope, looks everywhere";
    vec![contender("cmaes", "CMAES", note, |counted, _| {
        // No number ends it.
        let error = |u: &DVector<f64>| counted.at(u.as_slice()).map_or(f64::NAN, |told| told.error);
        if let Ok(mut search) = CMAESOptions::new(vec![0.0; 3], STEP).seed(SEED).build(error) {
            let _ = search.run();
        }
    })]
}
