//! All optimisers on errors with known minima, and what all of them promise whatever the error is.

extern crate std;

use super::*;
use crate::error::Slope;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use std::{format, println, string::String, vec::Vec};
use tactus_common::pose::Interval;

const GUESS: PlanarPose = PlanarPose { x_m: 0.2, y_m: -0.1, phi_rad: 0.3 };
/// Half widths: as in the thesis, and a yaw of about 30 degrees.
const HALF: [f32; 3] = [0.1, 0.055, 0.5];
/// The minimum of most problems, in half widths from the guess.
const MINIMUM: [f64; 3] = [0.3, -0.2, 0.45];
/// The start of most searches.
const START: [f64; 3] = [-0.6, 0.5, -0.7];

/// An error over the region as residuals of the distance from the guess in half widths.
#[derive(Clone, Copy)]
struct Problem {
    name: &'static str,
    free: usize,
    start: [f64; 3],
    /// The least error within the bounds, and where.
    least: f32,
    minimum: [f64; 3],
    has_slope: bool,
    residuals: fn([f64; 3], usize) -> [f64; 6],
}

fn bowl(u: [f64; 3], free: usize) -> [f64; 6] {
    let mut r = [0.0; 6];
    for axis in 0..free {
        r[axis] = 10.0 * (u[axis] - MINIMUM[axis]);
    }
    r
}

/// The bowl with its minimum beyond the upper bound of x.
fn cut_bowl(u: [f64; 3], free: usize) -> [f64; 6] {
    bowl([u[0] - 1.1, u[1], u[2]], free)
}

/// A valley across the axes, 100 times as steep as it is long: condition number 10^4.
fn valley(u: [f64; 3], free: usize) -> [f64; 6] {
    let d: Vec<f64> = (0..3).map(|axis| if axis < free { u[axis] - MINIMUM[axis] } else { 0.0 }).collect();
    let rotated = [
        0.6 * d[0] + 0.8 * (0.8 * d[1] + 0.6 * d[2]),
        -0.8 * d[0] + 0.6 * (0.8 * d[1] + 0.6 * d[2]),
        -0.6 * d[1] + 0.8 * d[2],
    ];
    [100.0 * rotated[0], rotated[1], 10.0 * rotated[2], 0.0, 0.0, 0.0]
}

/// Rosenbrock (1960), two times the half widths wide: minimum at 0.5.
fn rosenbrock(u: [f64; 3], free: usize) -> [f64; 6] {
    let w = u.map(|value| 2.0 * value);
    let mut r = [0.0; 6];
    for axis in 1..free {
        r[2 * axis - 2] = 10.0 * (w[axis] - w[axis - 1] * w[axis - 1]);
        r[2 * axis - 1] = 1.0 - w[axis - 1];
    }
    r
}

/// Rastrigin-like: a wide bowl with ripples; local minima about every 0.4 of a half width.
fn ripples(u: [f64; 3], free: usize) -> [f64; 6] {
    let mut r = [0.0; 6];
    for axis in 0..free {
        let d = u[axis] - MINIMUM[axis];
        r[2 * axis] = 2.0 * d;
        r[2 * axis + 1] = (1.5 * (1.0 - (5.0 * core::f64::consts::PI * d).cos())).sqrt();
    }
    r
}

/// A plateau with a bowl in it.
fn pit(u: [f64; 3], free: usize) -> [f64; 6] {
    let square: f64 = (0..free).map(|axis| (u[axis] - MINIMUM[axis]).powi(2)).sum();
    [(square / 0.16).min(1.0).sqrt() * 3.0, 0.0, 0.0, 0.0, 0.0, 0.0]
}

/// Steps, as a count of contacts has: a bowl rounded to whole numbers, flat within 0.1 about its minimum.
fn stairs(u: [f64; 3], free: usize) -> [f64; 6] {
    let mut r = [0.0; 6];
    for axis in 0..free {
        r[axis] = (10.0 * (u[axis] - MINIMUM[axis])).abs().floor().sqrt();
    }
    r
}

fn nothing(_: [f64; 3], _: usize) -> [f64; 6] {
    [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]
}

impl Problem {
    const fn new(name: &'static str, free: usize, residuals: fn([f64; 3], usize) -> [f64; 6]) -> Self {
        Self { name, free, start: START, least: 0.0, minimum: MINIMUM, has_slope: true, residuals }
    }

    const BOWL_1: Self = Self::new("bowl 1", 1, bowl);
    const BOWL_2: Self = Self::new("bowl 2", 2, bowl);
    const BOWL_3: Self = Self::new("bowl 3", 3, bowl);
    const CUT_BOWL: Self =
        Self { least: 16.0, minimum: [1.0, MINIMUM[1], MINIMUM[2]], ..Self::new("cut bowl 3", 3, cut_bowl) };
    const VALLEY_2: Self = Self::new("valley 2", 2, valley);
    const VALLEY_3: Self = Self::new("valley 3", 3, valley);
    const ROSENBROCK_2: Self =
        Self { start: [-0.6, 0.5, 0.0], minimum: [0.5; 3], ..Self::new("rosenbrock 2", 2, rosenbrock) };
    const ROSENBROCK_3: Self =
        Self { start: [-0.6, 0.5, 0.5], minimum: [0.5; 3], ..Self::new("rosenbrock 3", 3, rosenbrock) };
    const RIPPLES_2: Self = Self { has_slope: false, ..Self::new("ripples 2", 2, ripples) };
    const RIPPLES_3: Self = Self { has_slope: false, ..Self::new("ripples 3", 3, ripples) };
    const PIT_2: Self = Self { has_slope: false, ..Self::new("pit 2", 2, pit) };
    const STAIRS_2: Self = Self { has_slope: false, ..Self::new("stairs 2", 2, stairs) };
    const PLATEAU: Self = Self { least: 4.0, has_slope: false, ..Self::new("plateau 3", 3, nothing) };

    const TABLE: [Self; 13] = [
        Self::BOWL_1,
        Self::BOWL_2,
        Self::BOWL_3,
        Self::CUT_BOWL,
        Self::VALLEY_2,
        Self::VALLEY_3,
        Self::ROSENBROCK_2,
        Self::ROSENBROCK_3,
        Self::RIPPLES_2,
        Self::RIPPLES_3,
        Self::PIT_2,
        Self::STAIRS_2,
        Self::PLATEAU,
    ];

    fn interval(&self) -> Interval {
        let half = |axis: usize| if axis < self.free { HALF[axis] } else { 0.0 };
        Interval { x_m: half(0), y_m: half(1), phi_rad: half(2) }
    }

    fn bounds(&self) -> Bounds {
        Bounds::new(&GUESS, &self.interval())
    }

    fn pose(&self, u: [f64; 3]) -> PlanarPose {
        let mut pose = GUESS.to_array();
        for axis in 0..self.free {
            pose[axis] += HALF[axis] * u[axis] as f32;
        }
        PlanarPose::from_array(pose)
    }

    fn unit(&self, pose: &PlanarPose) -> [f64; 3] {
        let (pose, guess) = (pose.to_array(), GUESS.to_array());
        core::array::from_fn(|axis| (f64::from(pose[axis]) - f64::from(guess[axis])) / f64::from(HALF[axis]))
    }

    fn evaluate(&self, pose: &PlanarPose) -> Evaluation {
        let u = self.unit(pose);
        let residuals = (self.residuals)(u, self.free);
        let error = residuals.iter().map(|r| r * r).sum::<f64>() as f32;
        if !self.has_slope {
            return Evaluation { error, slope: None };
        }
        let mut slope = Slope { half_gradient: Vector3::zeros(), information: Matrix3::zeros() };
        let mut rows = [Vector3::<f64>::zeros(); 6];
        for axis in 0..self.free {
            let (mut up, mut down) = (u, u);
            up[axis] += 1e-5;
            down[axis] -= 1e-5;
            let (up, down) = ((self.residuals)(up, self.free), (self.residuals)(down, self.free));
            for (row, (up, down)) in rows.iter_mut().zip(up.iter().zip(down)) {
                row[axis] = (up - down) / 2e-5 / f64::from(HALF[axis]);
            }
        }
        for (row, residual) in rows.iter().zip(residuals) {
            slope.half_gradient += (row * residual).cast::<f32>();
            slope.information += (row * row.transpose()).cast::<f32>();
        }
        Evaluation { error, slope: Some(slope) }
    }

    fn solve(&self, method: Method, options: &SearchOptions) -> (Found, StopReason, u16) {
        let mut search =
            AnyOptimiser::new(method, &self.pose(self.start), &self.bounds(), options).expect("compiled in");
        let (found, reason) = carry_through(&mut search, |pose| self.evaluate(pose)).expect("an end");
        (found, reason, search.evaluations())
    }

    /// Distance of `pose` from the minimum, in half widths.
    fn distance(&self, pose: &PlanarPose) -> f64 {
        let u = self.unit(pose);
        (0..self.free).map(|axis| (u[axis] - self.minimum[axis]).abs()).fold(0.0, f64::max)
    }
}

fn options(evaluations_max: u16, gradient: Gradient) -> SearchOptions {
    SearchOptions { evaluations_max, gradient, ..SearchOptions::default() }
}

/// Not a promise but a table to be read: `cargo test -p tactus-controller optimisers_in_a_table -- --ignored --nocapture`.
#[test]
#[ignore = "prints a table"]
fn optimisers_in_a_table() {
    for gradient in Gradient::ALL {
        println!("\n## {} gradient, at most 1000 evaluations", gradient.name());
        println!("evaluations to 1e-3 above the least error / final error above it, evaluations, reason\n");
        for problem in Problem::TABLE {
            println!("{}:", problem.name);
            for method in Method::ALL {
                let goal_error = problem.least * (1.0 + 1e-6) + 1e-3;
                let (_, reason, to_goal) =
                    problem.solve(method, &SearchOptions { goal_error, ..options(1000, gradient) });
                let to_goal: String = if reason == StopReason::GoalReached { format!("{to_goal}") } else { "-".into() };
                let (found, reason, evaluations) = problem.solve(method, &options(1000, gradient));
                let above = found.evaluation.error - problem.least;
                println!(
                    "  {:24} {to_goal:>5} {above:10.1e} {evaluations:5} {} ({:.1e})",
                    method.name(),
                    reason.name(),
                    problem.distance(&found.pose)
                );
            }
        }
    }
    for method in Method::ALL {
        println!("{:24} {:5} bytes", method.name(), method.size().unwrap_or(0));
    }
    println!("{:24} {:5} bytes", "any", size_of::<AnyOptimiser>());
}

/// Methods that use second derivatives, or learn them.
const SECOND_ORDER: [Method; 4] = [Method::Newton, Method::Hybrid, Method::LevenbergMarquardt, Method::CmaEs];

fn is_local(method: Method) -> bool {
    method.reach() == method::Reach::Downhill
}

#[test]
fn every_method_finds_the_minimum_of_a_bowl_in_one_two_and_three_components() {
    for gradient in [Gradient::TwoSided, Gradient::Analytic] {
        for problem in [Problem::BOWL_1, Problem::BOWL_2, Problem::BOWL_3] {
            for method in Method::ALL {
                let (found, reason, evaluations) = problem.solve(method, &options(800, gradient));
                let off = problem.distance(&found.pose);
                assert!(off < 5e-3, "{} on {}: {off} {reason:?} {evaluations}", method.name(), problem.name);
                let cheap = evaluations <= 90 && reason != StopReason::EvaluationLimit;
                assert!(cheap || !is_local(method), "{} on {}: {reason:?} {evaluations}", method.name(), problem.name);
            }
        }
    }
}

#[test]
fn one_sided_differences_end_half_a_step_off_and_two_sided_ones_do_not() {
    let problem = Problem::BOWL_2;
    // The y step is 1e-3 of 0.055: 0.018 half widths.
    for method in [Method::SteepestDescentGolden, Method::Newton] {
        let off = |gradient| problem.distance(&problem.solve(method, &options(200, gradient)).0.pose);
        let (one, two) = (off(Gradient::OneSided), off(Gradient::TwoSided));
        assert!((4e-3..1e-2).contains(&one) && two < 2e-4, "{}: {one} {two}", method.name());
    }
}

#[test]
fn second_order_methods_reach_the_end_of_a_narrow_valley_and_first_order_ones_get_to_its_floor() {
    for problem in [Problem::VALLEY_2, Problem::VALLEY_3] {
        let before = problem.evaluate(&problem.pose(problem.start)).error;
        for method in Method::ALL {
            let (found, reason, evaluations) = problem.solve(method, &options(1000, Gradient::Analytic));
            let error = found.evaluation.error;
            let least = if SECOND_ORDER.contains(&method) { 1e-3 } else { 1e-2 * before };
            assert!(error < least, "{} on {}: {error} {reason:?} {evaluations}", method.name(), problem.name);
        }
    }
}

#[test]
fn second_order_methods_follow_a_bent_valley_to_its_end() {
    for problem in [Problem::ROSENBROCK_2, Problem::ROSENBROCK_3] {
        for method in Method::ALL {
            let (found, reason, evaluations) = problem.solve(method, &options(1000, Gradient::Analytic));
            let error = found.evaluation.error;
            let least = if SECOND_ORDER.contains(&method) { 1e-3 } else { 5.0 };
            assert!(error < least, "{} on {}: {error} {reason:?} {evaluations}", method.name(), problem.name);
        }
    }
}

#[test]
fn a_minimum_beyond_a_bound_is_met_at_the_bound() {
    let problem = Problem::CUT_BOWL;
    for gradient in [Gradient::TwoSided, Gradient::Analytic] {
        for method in Method::ALL {
            let (found, reason, evaluations) = problem.solve(method, &options(1000, gradient));
            let off = problem.distance(&found.pose);
            assert!(off < 5e-3, "{}: {off} {reason:?} {evaluations}", method.name());
        }
    }
    // In one component the bound is all there is, and is named.
    let alone = Problem { free: 1, ..problem };
    let (found, reason, _) = alone.solve(Method::SteepestDescentGolden, &options(100, Gradient::Analytic));
    assert_eq!((reason, found.pose.x_m), (StopReason::AtBound, GUESS.x_m + HALF[0]));
}

#[test]
fn a_plateau_ends_every_search_with_its_reason() {
    for free in 1..=3 {
        let problem = Problem { free, ..Problem::PLATEAU };
        for gradient in Gradient::ALL {
            for method in Method::ALL {
                let (found, reason, evaluations) = problem.solve(method, &options(500, gradient));
                let name = method.name();
                // DIRECT divides on: the plateau may have a hole.
                let expected = if method == Method::Direct { 500 } else { 300 };
                assert!(evaluations <= expected, "{name}: {evaluations}");
                assert!(reason == StopReason::Flat || method == Method::Direct, "{name}: {reason:?}");
                assert!(!is_local(method) || evaluations <= 10, "{name}: {evaluations}");
                assert_eq!(found.evaluation.error, 4.0);
            }
        }
    }
}

#[test]
fn a_pit_in_a_plateau_is_found_by_those_that_look_everywhere_at_points() {
    let problem = Problem::PIT_2;
    for method in [Method::Annealing, Method::CmaEs, Method::Direct] {
        for seed in 1..=5 {
            let (found, reason, _) = problem.solve(method, &SearchOptions { seed, ..options(600, Gradient::TwoSided) });
            let off = problem.distance(&found.pose);
            assert!(off < 0.02, "{} seed {seed}: {off} {reason:?}", method.name());
        }
    }
}

#[test]
fn of_many_minima_local_methods_find_one_and_global_ones_the_least() {
    let problem = Problem { start: [-0.9, 0.9, 0.0], ..Problem::RIPPLES_2 };
    let before = problem.evaluate(&problem.pose(problem.start)).error;
    for method in Method::ALL {
        let mut least_found = 0;
        for seed in 1..=10 {
            let options = SearchOptions { seed, starts: 24, ..options(1500, Gradient::TwoSided) };
            let (found, reason, evaluations) = problem.solve(method, &options);
            let (off, error) = (problem.distance(&found.pose), found.evaluation.error);
            let what = format!("{} seed {seed}: {off} {error} {reason:?} {evaluations}", method.name());
            if is_local(method) {
                assert!(off > 0.2 && error < before && reason != StopReason::EvaluationLimit, "{what}");
            }
            least_found += usize::from(off < 0.01);
        }
        // Annealing is left with a wrong minimum now and then: about one time in ten here.
        let expected = if method == Method::Annealing { 7 } else { 10 };
        assert!(is_local(method) || least_found >= expected, "{}: {least_found} of 10", method.name());
    }
}

#[test]
fn a_slope_that_deceives_from_the_start_is_named() {
    let problem = Problem::BOWL_2;
    for method in Method::ALL.into_iter().filter(|method| is_local(*method)) {
        let options = options(200, Gradient::Analytic);
        let mut search =
            AnyOptimiser::new(method, &problem.pose(START), &problem.bounds(), &options).expect("compiled in");
        let (found, reason) = carry_through(&mut search, |pose| {
            let mut evaluation = problem.evaluate(pose);
            if let Some(slope) = &mut evaluation.slope {
                slope.half_gradient = -slope.half_gradient;
            }
            evaluation
        })
        .expect("an end");
        assert_eq!((reason, found.pose), (StopReason::NoDescent, problem.pose(START)), "{}", method.name());
    }
}

#[test]
fn the_scale_of_the_error_does_not_matter() {
    let problem = Problem { has_slope: false, ..Problem::BOWL_2 };
    for scale in [1e-8, 1e14] {
        for method in Method::ALL {
            // Levenberg-Marquardt takes an error for chi-squared: below 1 there is nothing to learn.
            if method == Method::LevenbergMarquardt && scale < 1.0 {
                continue;
            }
            let options = options(800, Gradient::TwoSided);
            let mut search =
                AnyOptimiser::new(method, &problem.pose(START), &problem.bounds(), &options).expect("compiled in");
            let (found, reason) = carry_through(&mut search, |pose| {
                let Evaluation { error, slope } = problem.evaluate(pose);
                Evaluation { error: error * scale, slope }
            })
            .expect("an end");
            let off = problem.distance(&found.pose);
            assert!(off < 0.02, "{} at {scale:e}: {off} {reason:?} {}", method.name(), search.evaluations());
        }
    }
}

#[test]
fn local_methods_say_at_once_that_a_start_without_a_number_is_none_and_global_ones_go_on() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for method in Method::ALL {
            let problem = Problem { has_slope: false, ..Problem::BOWL_2 };
            let mut search =
                AnyOptimiser::new(method, &problem.pose(START), &problem.bounds(), &options(600, Gradient::Analytic))
                    .expect("compiled in");
            let (found, reason) = carry_through(&mut search, |pose| {
                let near = problem.unit(pose)[0] < -0.3;
                if near { Evaluation { error: bad, slope: None } } else { problem.evaluate(pose) }
            })
            .expect("an end");
            if is_local(method) {
                assert_eq!((reason, search.evaluations()), (StopReason::NotEvaluable, 1), "{}", method.name());
            } else {
                let off = problem.distance(&found.pose);
                assert!(off < 0.01, "{}: {off} {reason:?}", method.name());
            }
            // Nowhere a number: said so, whatever the method.
            let mut search =
                AnyOptimiser::new(method, &problem.pose(START), &problem.bounds(), &options(100, Gradient::Analytic))
                    .expect("compiled in");
            let (_, reason) = carry_through(&mut search, |_| Evaluation { error: bad, slope: None }).expect("an end");
            assert_eq!(reason, StopReason::NotEvaluable, "{}", method.name());
        }
    }
}

#[test]
fn division_finds_the_numbers_in_a_region_that_has_hardly_any() {
    let problem = Problem::BOWL_2;
    let mut search =
        AnyOptimiser::new(Method::Direct, &problem.pose(START), &problem.bounds(), &options(600, Gradient::Analytic))
            .expect("compiled in");
    let (found, _) = carry_through(&mut search, |pose| {
        let Evaluation { error, .. } = problem.evaluate(pose);
        Evaluation { error: if error < 4.0 { error } else { f32::NAN }, slope: None }
    })
    .expect("an end");
    assert!(problem.distance(&found.pose) < 0.01, "{found:?}");
}

#[test]
fn a_cliff_beside_the_minimum_keeps_no_method_from_it() {
    let problem = Problem::BOWL_2;
    for method in Method::ALL {
        let mut search =
            AnyOptimiser::new(method, &problem.pose(START), &problem.bounds(), &options(800, Gradient::Analytic))
                .expect("compiled in");
        let (found, reason) = carry_through(&mut search, |pose| {
            let beyond = problem.unit(pose)[0] > 0.32;
            if beyond { Evaluation { error: f32::NAN, slope: None } } else { problem.evaluate(pose) }
        })
        .expect("an end");
        let off = problem.distance(&found.pose);
        assert!(off < 0.02, "{}: {off} {reason:?}", method.name());
    }
}

#[test]
fn the_first_error_below_the_goal_ends_the_search() {
    for method in Method::ALL {
        let problem = Problem::BOWL_2;
        let options = SearchOptions { goal_error: 10.0, ..options(500, Gradient::TwoSided) };
        let mut search =
            AnyOptimiser::new(method, &problem.pose(START), &problem.bounds(), &options).expect("compiled in");
        let mut below = 0;
        let (found, reason) = carry_through(&mut search, |pose| {
            let evaluation = problem.evaluate(pose);
            below += u16::from(evaluation.error < 10.0);
            evaluation
        })
        .expect("an end");
        assert_eq!((reason, below), (StopReason::GoalReached, 1), "{}", method.name());
        assert!(found.evaluation.error < 10.0);
    }
}

#[test]
fn a_region_without_a_free_component_is_one_evaluation() {
    let bounds = Bounds::new(&GUESS, &Interval::default());
    for method in Method::ALL {
        let mut search =
            AnyOptimiser::new(method, &PlanarPose::default(), &bounds, &SearchOptions::default()).expect("compiled in");
        let (found, reason) = carry_through(&mut search, |_| Evaluation { error: 3.0, slope: None }).expect("an end");
        assert_eq!((found.pose, reason, search.evaluations()), (GUESS, StopReason::Converged, 1), "{}", method.name());
    }
}

/// An error that has no shape at all: a hash of the pose, with missing numbers and slopes among its values.
fn noise(pose: &PlanarPose, seed: u64, bad: bool) -> Evaluation {
    let bits = pose.to_array().map(f32::to_bits);
    let mut z = seed;
    for word in bits {
        z = (z ^ u64::from(word)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z ^= z >> 29;
    }
    let value = |shift: u32| ((z >> shift) & 0xff) as f32;
    let error = match z & 0xf {
        0 if bad => f32::NAN,
        1 if bad => f32::INFINITY,
        _ => value(8),
    };
    let slope = Slope {
        half_gradient: Vector3::new(
            value(16) - 128.0,
            value(24) - 128.0,
            if bad && value(4) > 200.0 { f32::NAN } else { 1.0 },
        ),
        information: Matrix3::from_diagonal(&Vector3::new(value(32), value(40) - 20.0, value(48))),
    };
    Evaluation { error, slope: (z & 0x10 != 0).then_some(slope) }
}

/// What is asked of a search, up to its end, with its promises checked at each step.
fn watched(
    search: &mut AnyOptimiser,
    bounds: &Bounds,
    options: &SearchOptions,
    error: impl Fn(&PlanarPose) -> Evaluation,
) -> (Vec<PlanarPose>, StopReason) {
    let mut asked = Vec::new();
    let mut least = f32::INFINITY;
    loop {
        let ask = search.ask();
        // As text: what is no number does not equal itself.
        assert_eq!(format!("{ask:?}"), format!("{:?}", search.ask()));
        match ask {
            Ask::Done(found, reason) => {
                // The best is the least of all that were told, and a search that is done stays as it is.
                if least.is_finite() {
                    assert_eq!(found.evaluation.error, least);
                } else {
                    assert_eq!(reason, StopReason::NotEvaluable);
                }
                search.tell(&Evaluation { error: 0.0, slope: None });
                assert_eq!(search.evaluations() as usize, asked.len());
                return (asked, reason);
            }
            Ask::Evaluate(pose) => {
                assert_eq!(bounds.clamp(&pose), pose, "outside of {bounds:?}");
                asked.push(pose);
                assert!(asked.len() <= options.evaluations_max.max(1) as usize);
                let evaluation = error(&pose);
                if evaluation.error.is_finite() {
                    least = least.min(evaluation.error);
                }
                search.tell(&evaluation);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn no_search_leaves_its_bounds_or_its_budget_whatever_the_error_is(
        guess in [-1.0_f32..1.0, -1.0..1.0, -3.0..3.0],
        half in [0.0_f32..0.2, 0.0..0.2, 0.0..1.0],
        fixed in 0_u8..8,
        start in [-2.0_f32..2.0, -2.0..2.0, -4.0..4.0],
        evaluations_max in 0_u16..300,
        gradient in 0_usize..3,
        steps in [0.0_f32..0.5, 1e-6_f32..1e-2, -0.1_f32..0.1],
        shape in 0_u8..4,
        seed in any::<u64>(),
    ) {
        let half: Vec<f32> = half.iter().enumerate().map(|(axis, h)| if fixed & (1 << axis) == 0 { *h } else { 0.0 }).collect();
        let guess = PlanarPose::from_array(guess);
        let bounds = Bounds::new(&guess, &Interval { x_m: half[0], y_m: half[1], phi_rad: half[2] });
        let options = SearchOptions { evaluations_max, gradient: Gradient::ALL[gradient], steps, seed, ..SearchOptions::default() };
        let error = |pose: &PlanarPose| match shape {
            0 => noise(pose, seed, true),
            1 => noise(pose, seed, false),
            2 => Evaluation { error: 1e35 * (pose.x_m * pose.x_m + pose.y_m * pose.y_m), slope: None },
            _ => Evaluation { error: libm::fabsf(pose.x_m) + libm::fabsf(pose.y_m - pose.phi_rad), slope: None },
        };
        for method in Method::ALL {
            let start = PlanarPose::from_array(start);
            let mut search = AnyOptimiser::new(method, &start, &bounds, &options).expect("compiled in");
            let (asked, _) = watched(&mut search, &bounds, &options, error);
            for (axis, half) in half.iter().enumerate() {
                if *half == 0.0 {
                    prop_assert!(asked.iter().all(|pose| pose.to_array()[axis] == guess.to_array()[axis]));
                }
            }
            // The same again is the same.
            let mut again = AnyOptimiser::new(method, &start, &bounds, &options).expect("compiled in");
            prop_assert_eq!(asked, watched(&mut again, &bounds, &options, error).0);
        }
    }
}

#[test]
fn the_seed_matters_to_the_random_methods_alone() {
    let problem = Problem::BOWL_3;
    for method in Method::ALL {
        let path = |seed| {
            let options = SearchOptions { seed, ..options(60, Gradient::TwoSided) };
            let mut search =
                AnyOptimiser::new(method, &problem.pose(START), &problem.bounds(), &options).expect("compiled in");
            watched(&mut search, &problem.bounds(), &options, |pose| problem.evaluate(pose)).0
        };
        let is_random = matches!(method, Method::Annealing | Method::CmaEs);
        assert_eq!(path(1) != path(2), is_random, "{}", method.name());
    }
}
