//! The list of all optimisers, by name.
//!
//! A new one is a file with a type that implements [`Create`], and one line in the list below. All but the default method's are
//! compiled in with the feature `optimizers` alone: an image without it knows their names and refuses them.

#[cfg(feature = "optimizers")]
use super::annealing::Annealing;
#[cfg(feature = "optimizers")]
use super::cma_es::CmaEs;
#[cfg(feature = "optimizers")]
use super::conjugate_gradients::{ConjugateGradientsFr, ConjugateGradientsPr};
#[cfg(feature = "optimizers")]
use super::direct::Direct;
#[cfg(feature = "optimizers")]
use super::hybrid::Hybrid;
use super::multi_start::LevenbergMarquardtStarts;
#[cfg(feature = "optimizers")]
use super::newton::NewtonRaphson;
use super::options::SearchOptions;
#[cfg(feature = "optimizers")]
use super::steepest_descent::{SteepestDescentBrent, SteepestDescentGolden, SteepestDescentSimple};
use super::{Ask, Bounds, Create, Found, Optimiser};
use crate::error::Evaluation;
use tactus_common::pose::PlanarPose;

macro_rules! methods {
    ($($(#[$doc:meta])+ $method:ident = $name:literal: $optimiser:ty, searches: $reach:ident, if $built:meta;)+) => {
        /// A way to search for the least error.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Method {
            $($(#[$doc])+ $method,)+
        }

        impl Method {
            /// All of them, in the order of tables.
            pub const ALL: [Self; [$($name),+].len()] = [$(Self::$method),+];

            /// The name on the command line.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$method => $name,)+
                }
            }

            /// How far it looks.
            pub const fn reach(self) -> Reach {
                match self {
                    $(Self::$method => Reach::$reach,)+
                }
            }

            /// The memory of its search, bytes; `None` if it is not compiled in.
            pub const fn size(self) -> Option<usize> {
                match self {
                    $(
                        #[cfg($built)]
                        Self::$method => Some(size_of::<$optimiser>()),
                        #[cfg(not($built))]
                        Self::$method => None,
                    )+
                }
            }
        }

        #[derive(Clone, Debug)]
        #[cfg_attr(
            feature = "optimizers",
            expect(clippy::large_enum_variant, reason = "there is no heap to put the large ones on")
        )]
        enum Inner {
            $(#[cfg($built)] $method($optimiser),)+
        }

        impl AnyOptimiser {
            /// A search from `start`, brought within `bounds`, by `method`; `None` if that is not compiled in.
            pub fn new(
                method: Method,
                start: &PlanarPose,
                bounds: &Bounds,
                options: &SearchOptions,
            ) -> Option<Self> {
                match method {
                    $(
                        #[cfg($built)]
                        Method::$method => {
                            Some(Self { inner: Inner::$method(Create::create(start, bounds, options)) })
                        }
                        #[cfg(not($built))]
                        Method::$method => None,
                    )+
                }
            }

            /// How it searches.
            pub fn method(&self) -> Method {
                match &self.inner {
                    $(#[cfg($built)] Inner::$method(_) => Method::$method,)+
                }
            }

            /// Evaluations told so far.
            pub fn evaluations(&self) -> u16 {
                match &self.inner {
                    $(#[cfg($built)] Inner::$method(search) => search.evaluations(),)+
                }
            }

            /// The best so far; `None` before the first evaluation.
            pub fn best(&self) -> Option<Found> {
                match &self.inner {
                    $(#[cfg($built)] Inner::$method(search) => search.best(),)+
                }
            }
        }

        impl Optimiser for AnyOptimiser {
            fn ask(&self) -> Ask {
                match &self.inner {
                    $(#[cfg($built)] Inner::$method(search) => search.ask(),)+
                }
            }

            fn tell(&mut self, evaluation: &Evaluation) {
                match &mut self.inner {
                    $(#[cfg($built)] Inner::$method(search) => search.tell(evaluation),)+
                }
            }
        }
    };
}

methods! {
    /// Steepest descent with bracketing and golden sections: the published method.
    SteepestDescentGolden = "steepest-descent-golden": SteepestDescentGolden, searches: Downhill, if feature = "optimizers";
    /// Steepest descent with a simple step.
    SteepestDescentSimple = "steepest-descent-simple": SteepestDescentSimple, searches: Downhill, if feature = "optimizers";
    /// Steepest descent with bracketing and Brent's line search.
    SteepestDescentBrent = "steepest-descent-brent": SteepestDescentBrent, searches: Downhill, if feature = "optimizers";
    /// Conjugate gradients by Polak and Ribiere.
    ConjugateGradientsPr = "conjugate-gradients-pr": ConjugateGradientsPr, searches: Downhill, if feature = "optimizers";
    /// Conjugate gradients by Fletcher and Reeves.
    ConjugateGradientsFr = "conjugate-gradients-fr": ConjugateGradientsFr, searches: Downhill, if feature = "optimizers";
    /// Newton-Raphson with backtracking.
    Newton = "newton": NewtonRaphson, searches: Downhill, if feature = "optimizers";
    /// Steepest descent, then Newton-Raphson.
    Hybrid = "hybrid": Hybrid, searches: Downhill, if feature = "optimizers";
    /// Levenberg-Marquardt from several starts.
    LevenbergMarquardt = "levenberg-marquardt": LevenbergMarquardtStarts, searches: Everywhere, if all();
    /// Simulated annealing by Corana.
    Annealing = "annealing": Annealing, searches: Everywhere, if feature = "optimizers";
    /// Evolution strategy with covariance matrix adaptation.
    CmaEs = "cma-es": CmaEs, searches: Everywhere, if feature = "optimizers";
    /// Division of the region into boxes.
    Direct = "direct": Direct, searches: Everywhere, if feature = "optimizers";
}

/// How far a method looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Downhill from its start: it finds the minimum of the valley that the start lies in.
    Downhill,
    /// All over the region: it finds the least of several minima, if the budget allows.
    Everywhere,
}

impl Method {
    /// Is it compiled in?
    pub const fn is_built_in(self) -> bool {
        self.size().is_some()
    }

    /// The one with this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.name() == name)
    }
}

/// Any optimiser, chosen while the program runs. Takes the memory of the largest, DIRECT: 6.7 kB. The others take 0.3 to
/// 0.9 kB each ([`Method::size`]).
#[derive(Clone, Debug)]
pub struct AnyOptimiser {
    inner: Inner,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_found_by_its_name_and_names_differ() {
        for method in Method::ALL {
            assert_eq!(Method::from_name(method.name()), Some(method));
            assert!(method.name().chars().all(|c| c.is_ascii_lowercase() || c == '-'), "{}", method.name());
        }
        assert_eq!(Method::from_name("Newton"), None);
    }

    #[test]
    fn any_fits_8_kib_and_all_but_direct_1_kib() {
        assert!(size_of::<AnyOptimiser>() <= 8192, "{}", size_of::<AnyOptimiser>());
        for method in Method::ALL {
            let size = method.size().expect("tests have them all");
            assert!(size <= 1024 || method == Method::Direct, "{}: {size}", method.name());
        }
    }
}
