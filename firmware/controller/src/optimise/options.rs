//! What all optimisers are told.

/// Where slopes come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gradient {
    /// Differences to one side, `(E(x + dx) - E(x)) / dx` (Nikandrova 2011, eq. 19).
    OneSided,
    /// Differences to both sides, `(E(x + dx) - E(x - dx)) / (2 dx)` (Nikandrova 2011, eq. 20).
    TwoSided,
    /// The error function's own where it has one, two-sided differences where it has none.
    #[default]
    Analytic,
}

impl Gradient {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::OneSided, Self::TwoSided, Self::Analytic];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::OneSided => "one-sided",
            Self::TwoSided => "two-sided",
            Self::Analytic => "analytic",
        }
    }

    /// The one with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|g| g.name() == name)
    }
}

/// Options of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchOptions {
    /// Most evaluations, those for differences included; 0 counts as 1.
    pub evaluations_max: u16,
    /// An error below this ends the search; 0 = never.
    pub goal_error: f32,
    /// Where slopes come from, for the methods that use one.
    pub gradient: Gradient,
    /// Steps of the differences in x, y (metres) and phi (radians); the sign is of no matter.
    pub steps: [f32; 3],
    /// Moves below this fraction of the half widths end a search: 1e-4 of 0.1 m is 10 micrometres.
    pub step_min: f32,
    /// Starts of the methods that begin anew while the budget lasts: the given one, then a low-discrepancy sequence over
    /// the region.
    pub starts: u16,
    /// Seed of the methods that draw random numbers.
    pub seed: u64,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self {
            evaluations_max: 200,
            goal_error: 0.0,
            gradient: Gradient::Analytic,
            // A millimetre is the resolution that contacts have; 10 mrad move a face's end 0.1 m away by as much.
            steps: [1e-3, 1e-3, 1e-2],
            step_min: 1e-4,
            starts: 8,
            seed: 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_gradient_is_found_by_its_name() {
        for gradient in Gradient::ALL {
            assert_eq!(Gradient::from_name(gradient.name()), Some(gradient));
        }
        assert_eq!(Gradient::from_name("sideways"), None);
    }
}
