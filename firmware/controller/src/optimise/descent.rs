//! Descent: a direction, a search along it, and again: `x_{k+1} = x_k + lambda_k d_k` (Nikandrova 2011, eq. 3).
//!
//! Bounds: a component at a bound that would be crossed is held there, and each line ends at the nearest bound
//! (projected gradients with an active set; Nocedal & Wright 2006, section 16.7).

use super::StopReason;
use super::differences::Differencing;
use super::line::{Line, LineSearch};
use super::options::Gradient;
use super::search::{Model, Next, Point, Sample, Setup, Strategy};
use super::stencil::Stencil;
use nalgebra::{Matrix3, Vector3};

/// Length of the first step of all, in half widths.
const FIRST_STEP: f32 = 0.25;
/// A component this near its bound is at it.
const AT_BOUND: f32 = 1e-6;
/// A step whose foretold gain is below this part of the error is lost in the rounding of 32-bit numbers.
const ROUNDING: f32 = 6e-8;

/// What a direction is chosen from.
#[derive(Clone, Copy, Debug)]
pub struct Slope {
    /// Where.
    pub point: Point,
    /// Free components.
    pub free: usize,
    /// First derivatives; 0 for a component that is held.
    pub gradient: Point,
    /// Second derivatives, if known.
    pub curvature: Option<Matrix3<f32>>,
    /// The components held at their bounds.
    pub held: [bool; 3],
}

impl Slope {
    /// Would a step in this direction leave the box at once?
    pub fn is_blocked(&self, axis: usize, step: f32) -> bool {
        self.held[axis] || is_outward(self.point[axis], step)
    }
}

/// A direction.
#[derive(Clone, Copy, Debug)]
pub struct Heading {
    /// Where to; any length.
    pub direction: Point,
    /// `true` if its length means something: the line search should try all of it first.
    pub is_whole_step: bool,
}

/// Chooses directions.
pub trait Direction {
    /// A choice over `free` components that has not begun.
    fn new(free: usize) -> Self;
    /// Does the next choice need second derivatives?
    fn wants_curvature(&self) -> bool {
        false
    }
    /// The direction from here.
    fn choose(&mut self, slope: &Slope) -> Heading;
    /// The line has led nowhere: is there another direction to choose from the same place?
    fn restart(&mut self) -> bool {
        false
    }
    /// The line has led from one error to a lower one.
    fn arrive(&mut self, _before: f32, _after: f32) {}
}

#[derive(Clone, Copy, Debug)]
enum Phase<L> {
    Start,
    Gradient(Differencing),
    Curvature(Stencil),
    Line(L),
}

/// Descent with directions `D` and line searches `L`. About 300 bytes.
#[derive(Clone, Debug)]
pub struct Descent<D, L> {
    free: usize,
    steps: Point,
    gradient: Gradient,
    step_min: f32,
    direction: D,
    phase: Phase<L>,
    /// The start of the line and the slope there.
    here: Sample,
    model: Model,
    knows_curvature: bool,
    /// The lowest point of the line.
    lowest: Sample,
    heading: Point,
    longest: f32,
    /// Length of the last line's step.
    last: f32,
    /// Steps in a row that were too short to matter.
    short_steps: usize,
    has_moved: bool,
}

impl<D: Direction, L: LineSearch> Strategy for Descent<D, L> {
    fn new(setup: &Setup) -> Self {
        let here = Sample { point: setup.start, error: f32::INFINITY, model: None };
        Self {
            free: setup.free,
            steps: setup.steps,
            gradient: setup.options.gradient,
            step_min: setup.options.step_min.max(1e-6),
            direction: D::new(setup.free),
            phase: Phase::Start,
            here,
            model: Model { gradient: Vector3::zeros(), curvature: Matrix3::zeros() },
            knows_curvature: false,
            lowest: here,
            heading: Vector3::zeros(),
            longest: 0.0,
            last: FIRST_STEP,
            short_steps: 0,
            has_moved: false,
        }
    }

    fn next(&mut self, sample: &Sample) -> Next {
        match &mut self.phase {
            Phase::Start if !sample.error.is_finite() => Next::Stop(StopReason::NotEvaluable),
            Phase::Start => {
                self.here = *sample;
                self.look()
            }
            Phase::Gradient(differencing) => match differencing.tell(sample.error) {
                None => Next::Try(differencing.ask()),
                Some(found) if found.is_flat => Next::Stop(StopReason::Flat),
                Some(found) => {
                    self.model = Model { gradient: found.gradient, curvature: Matrix3::zeros() };
                    self.knows_curvature = false;
                    self.head()
                }
            },
            Phase::Curvature(stencil) => match stencil.tell(sample.error) {
                None => Next::Try(stencil.ask()),
                Some((_, true)) => Next::Stop(StopReason::Flat),
                Some((model, false)) => {
                    self.model = model;
                    self.knows_curvature = true;
                    self.head()
                }
            },
            Phase::Line(line) => {
                if sample.error < self.lowest.error {
                    self.lowest = *sample;
                }
                if line.tell(sample.error) {
                    self.arrive()
                } else {
                    let distance = line.ask();
                    Next::Try(self.on_line(distance))
                }
            }
        }
    }
}

impl<D: Direction, L: LineSearch> Descent<D, L> {
    /// Finds out the slope here.
    fn look(&mut self) -> Next {
        let two_sided = self.gradient != Gradient::OneSided;
        let Sample { point, error, model } = self.here;
        if let Some(model) = model {
            if model.gradient == Vector3::zeros() && model.curvature == Matrix3::zeros() {
                return Next::Stop(StopReason::Flat);
            }
            self.model = model;
            self.knows_curvature = true;
            return self.head();
        }
        if self.direction.wants_curvature() {
            let stencil = Stencil::new(&point, error, &self.steps, self.free, two_sided);
            self.phase = Phase::Curvature(stencil);
            Next::Try(stencil.ask())
        } else {
            let differencing = Differencing::new(&point, error, &self.steps, self.free, two_sided);
            self.phase = Phase::Gradient(differencing);
            Next::Try(differencing.ask())
        }
    }

    /// Chooses a direction and begins the line.
    fn head(&mut self) -> Next {
        let slope = self.slope();
        if slope.gradient == Vector3::zeros() {
            let is_level = self.model.gradient == Vector3::zeros();
            return Next::Stop(if is_level { StopReason::Converged } else { StopReason::AtBound });
        }
        let mut heading = self.direction.choose(&slope);
        for axis in 0..3 {
            if slope.is_blocked(axis, heading.direction[axis]) {
                heading.direction[axis] = 0.0;
            }
        }
        let length = heading.direction.norm();
        if !(length.is_finite() && length > 0.0 && heading.direction.dot(&slope.gradient) < 0.0) {
            heading = Heading { direction: -slope.gradient, is_whole_step: false };
        }
        // A whole step keeps its length, so that 1 is all of it; any other becomes one half width long.
        if !heading.is_whole_step {
            // In two steps: the square of a large slope is beyond 32-bit numbers.
            heading.direction /= heading.direction.amax();
            heading.direction /= heading.direction.norm();
        }
        self.heading = heading.direction;
        self.begin_line(&slope, heading.is_whole_step)
    }

    fn begin_line(&mut self, slope: &Slope, is_whole_step: bool) -> Next {
        let length = self.heading.norm();
        if is_whole_step && self.heading.amax() < self.step_min {
            return Next::Stop(StopReason::Converged);
        }
        self.longest = distance_to_bound(&self.here.point, &self.heading);
        let shortest = self.step_min / length;
        let first = if is_whole_step { 1.0 } else { L::first(self.last).max(2.0 * shortest) };
        let line = Line {
            error: self.here.error,
            slope: self.heading.dot(&slope.gradient),
            first: first.min(self.longest),
            longest: self.longest,
            shortest,
            is_whole_step,
        };
        if -line.slope * shortest <= ROUNDING * self.here.error {
            return Next::Stop(StopReason::Converged);
        }
        let search = L::new(&line);
        let distance = search.ask();
        self.lowest = self.here;
        self.phase = Phase::Line(search);
        Next::Try(self.on_line(distance))
    }

    /// Goes on from the lowest point of the line.
    fn arrive(&mut self) -> Next {
        if self.lowest.error >= self.here.error {
            if !self.direction.restart() {
                return Next::Stop(if self.has_moved { StopReason::Converged } else { StopReason::NoDescent });
            }
            let needs_more = self.direction.wants_curvature() && !self.knows_curvature;
            return if needs_more { self.look() } else { self.head() };
        }
        let moved = self.lowest.point - self.here.point;
        let (before, after) = (self.here.error, self.lowest.error);
        self.here = self.lowest;
        self.has_moved = true;
        self.last = moved.norm();
        self.direction.arrive(before, after);
        // One short step may be one across a narrow valley: only as many in a row as there are components count.
        let is_short = moved.amax() < self.step_min;
        self.short_steps = if is_short { self.short_steps + 1 } else { 0 };
        if self.short_steps >= self.free {
            return Next::Stop(StopReason::Converged);
        }
        self.look()
    }

    fn slope(&self) -> Slope {
        let Model { mut gradient, curvature } = self.model;
        let mut held = [false; 3];
        for (axis, held) in held.iter_mut().enumerate() {
            *held = axis >= self.free || is_outward(self.here.point[axis], -gradient[axis]);
            if *held {
                gradient[axis] = 0.0;
            }
        }
        let curvature = self.knows_curvature.then_some(curvature);
        Slope { point: self.here.point, free: self.free, gradient, curvature, held }
    }

    fn on_line(&self, distance: f32) -> Point {
        self.here.point + self.heading * distance
    }
}

fn is_outward(value: f32, step: f32) -> bool {
    (step > 0.0 && value >= 1.0 - AT_BOUND) || (step < 0.0 && value <= AT_BOUND - 1.0)
}

fn distance_to_bound(point: &Point, heading: &Point) -> f32 {
    point.iter().zip(heading.iter()).fold(f32::INFINITY, |nearest, (value, step)| {
        let room = if *step > 0.0 { 1.0 - value } else { 1.0 + value };
        if *step == 0.0 { nearest } else { nearest.min(room / libm::fabsf(*step)) }
    })
}
