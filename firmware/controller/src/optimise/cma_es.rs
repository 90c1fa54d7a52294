//! CMA-ES: an evolution strategy whose cloud of samples takes the shape of the error's valley.
//!
//! Hansen (2016), "The CMA evolution strategy: a tutorial", arXiv:1604.00772, figure 6 with the default parameters of
//! its table 1 and positive weights; small population `4 + floor(3 ln n)`. When a cloud has shrunk to nothing the next
//! one is drawn twice as large about another start (Auger & Hansen 2005, IPOP), up to `CLOUDS_MAX` clouds.
//!
//! Bounds: a sample beyond the box is mirrored at its face, and the mirrored point is the one that is evaluated and
//! learnt from; so the cloud can lie against a face. Errors that are no numbers rank last.

use super::StopReason;
use super::chart::within;
use super::search::{Next, Point, Sample, Search, Setup, Strategy};
use super::starts::start;
use crate::sort::insertion_sort;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use tactus_common::random::Random;

/// Clouds one after the other; each is twice as large as the one before.
const CLOUDS_MAX: u8 = 3;
/// Samples of the largest cloud: `4 + floor(3 ln 3)` = 7, twice doubled.
const POPULATION_MAX: usize = 28;
/// Standard deviation of the first samples, in half widths (tutorial: about a third of the region).
const SPREAD: f32 = 0.6;
/// Generations of equal errors that end a cloud.
const FLAT_MAX: u8 = 6;
/// Most sweeps of the eigenvalue algorithm; three rows need a few.
const EIGEN_SWEEPS_MAX: usize = 50;

/// Weights and learning rates of a population (tutorial, table 1).
#[derive(Clone, Copy, Debug)]
struct Rates {
    population: usize,
    parents: usize,
    weights: [f32; POPULATION_MAX / 2],
    parents_effective: f32,
    step_path: f32,
    step_damping: f32,
    path: f32,
    rank_one: f32,
    rank_parents: f32,
    /// Expected length of a normal vector.
    chi: f32,
}

impl Rates {
    fn new(free: usize, population: usize) -> Self {
        let n = free as f32;
        let population = population.min(POPULATION_MAX);
        let parents = (population / 2).max(1);
        let mut weights = [0.0; POPULATION_MAX / 2];
        for (rank, weight) in weights.iter_mut().enumerate().take(parents) {
            *weight = libm::logf(0.5 * (population as f32 + 1.0)) - libm::logf(rank as f32 + 1.0);
        }
        let sum: f32 = weights.iter().sum();
        weights = weights.map(|weight| weight / sum);
        let effective = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f32>();
        let step_path = (effective + 2.0) / (n + effective + 5.0);
        let excess = libm::sqrtf((effective - 1.0) / (n + 1.0)) - 1.0;
        let rank_one = 2.0 / ((n + 1.3) * (n + 1.3) + effective);
        let rank_parents = 2.0 * (0.25 + effective + 1.0 / effective - 2.0) / ((n + 2.0) * (n + 2.0) + effective);
        Self {
            population,
            parents,
            weights,
            parents_effective: effective,
            step_path,
            step_damping: 1.0 + 2.0 * excess.max(0.0) + step_path,
            path: (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n),
            rank_one,
            rank_parents: rank_parents.min(1.0 - rank_one),
            chi: libm::sqrtf(n) * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n)),
        }
    }
}

/// The strategy. About 770 bytes.
#[derive(Clone, Debug)]
pub struct Evolution {
    free: usize,
    step_min: f32,
    random: Random,
    rates: Rates,
    has_begun: bool,
    mean: Point,
    spread: f32,
    covariance: Matrix3<f32>,
    /// Columns are the axes of the cloud, and their lengths.
    axes: Matrix3<f32>,
    lengths: Point,
    path: Point,
    step_path: Point,
    samples: [(Point, f32); POPULATION_MAX],
    count: usize,
    generation: u16,
    flat: u8,
    cloud: u8,
    varies: bool,
}

impl Strategy for Evolution {
    fn new(setup: &Setup) -> Self {
        let population = 4 + libm::floorf(3.0 * libm::logf(setup.free.max(1) as f32)) as usize;
        Self {
            free: setup.free,
            step_min: setup.options.step_min,
            random: Random::new(setup.options.seed),
            rates: Rates::new(setup.free.max(1), population),
            has_begun: false,
            mean: setup.start,
            spread: SPREAD,
            covariance: Matrix3::identity(),
            axes: Matrix3::identity(),
            lengths: Vector3::repeat(1.0),
            path: Vector3::zeros(),
            step_path: Vector3::zeros(),
            samples: [(Vector3::zeros(), f32::INFINITY); POPULATION_MAX],
            count: 0,
            generation: 0,
            flat: 0,
            cloud: 1,
            varies: false,
        }
    }

    fn next(&mut self, sample: &Sample) -> Next {
        if !self.has_begun {
            // The start is told for the accounts; the cloud about it takes over from here.
            self.has_begun = true;
            return Next::Try(self.draw());
        }
        if let Some(slot) = self.samples.get_mut(self.count) {
            *slot = (sample.point, sample.error);
        }
        self.count += 1;
        if self.count >= self.rates.population {
            self.count = 0;
            self.learn();
            let is_flat = self.flat >= FLAT_MAX;
            let widest = (0..self.free).fold(0.0_f32, |widest, axis| widest.max(self.covariance[(axis, axis)]));
            let longest = self.spread * libm::sqrtf(widest);
            if (is_flat || longest < self.step_min) && !self.begin_cloud() {
                return Next::Stop(if self.varies { StopReason::Converged } else { StopReason::Flat });
            }
        }
        Next::Try(self.draw())
    }
}

impl Evolution {
    /// A sample of the cloud, mirrored into the box.
    fn draw(&mut self) -> Point {
        // All three: the axes of the cloud come in any order, those beyond the free components among them.
        let normal = Vector3::zeros().map(|_: f32| self.random.normal());
        let mut step = self.axes * normal.component_mul(&self.lengths) * self.spread;
        for axis in self.free..3 {
            step[axis] = 0.0;
        }
        (self.mean + step).map(mirrored)
    }

    /// Mean, paths, covariance and spread from a generation (tutorial, figure 6).
    fn learn(&mut self) {
        let rates = self.rates;
        let Some(generation) = self.samples.get_mut(..rates.population) else { return };
        insertion_sort(generation, |a, b| a.1.total_cmp(&b.1));
        let is_flat = generation.first().is_some_and(|best| generation.iter().all(|sample| sample.1 == best.1));
        self.varies |= !is_flat;
        self.generation = self.generation.saturating_add(1);
        let mut shift = Vector3::zeros();
        let mut spread_of_parents = Matrix3::zeros();
        for ((point, _), weight) in generation.iter().zip(rates.weights).take(rates.parents) {
            let step = (point - self.mean) / self.spread;
            shift += step * weight;
            spread_of_parents += step * step.transpose() * weight;
        }
        self.mean += shift * self.spread;

        let whitened = self.axes * (self.axes.transpose() * shift).component_div(&self.lengths);
        let gain = libm::sqrtf(rates.step_path * (2.0 - rates.step_path) * rates.parents_effective);
        self.step_path = self.step_path * (1.0 - rates.step_path) + whitened * gain;
        let length = self.step_path.norm();
        let settled = 1.0 - libm::powf(1.0 - rates.step_path, 2.0 * f32::from(self.generation));
        let stalls = length / libm::sqrtf(settled) >= (1.4 + 2.0 / (self.free as f32 + 1.0)) * rates.chi;
        let gain = libm::sqrtf(rates.path * (2.0 - rates.path) * rates.parents_effective);
        self.path *= 1.0 - rates.path;
        if !stalls {
            self.path += shift * gain;
        }
        let lost = if stalls { rates.rank_one * rates.path * (2.0 - rates.path) } else { 0.0 };
        self.covariance = self.covariance * (1.0 + lost - rates.rank_one - rates.rank_parents)
            + self.path * self.path.transpose() * rates.rank_one
            + spread_of_parents * rates.rank_parents;
        let change = rates.step_path / rates.step_damping * (length / rates.chi - 1.0);
        // A plateau is left by a wider cloud (tutorial, B.3); no cloud is wider than the box.
        let change = if is_flat { 0.2 + rates.step_path / rates.step_damping } else { change.min(1.0) };
        self.flat = if is_flat { self.flat + 1 } else { 0 };
        self.spread = (self.spread * libm::expf(change)).min(1.0);
        self.decompose();
    }

    /// The axes of the cloud; if the algorithm does not settle, a round cloud again.
    fn decompose(&mut self) {
        for axis in self.free..3 {
            for other in 0..3 {
                self.covariance[(axis, other)] = 0.0;
                self.covariance[(other, axis)] = 0.0;
            }
            self.covariance[(axis, axis)] = 1.0;
        }
        let eigen = if self.covariance.iter().all(|v| v.is_finite()) {
            SymmetricEigen::try_new(self.covariance, f32::EPSILON, EIGEN_SWEEPS_MAX)
        } else {
            None
        };
        match eigen {
            Some(eigen) => {
                self.axes = eigen.eigenvectors;
                self.lengths = eigen.eigenvalues.map(|value| libm::sqrtf(value.max(1e-10)));
            }
            None => {
                self.covariance = Matrix3::identity();
                self.axes = Matrix3::identity();
                self.lengths = Vector3::repeat(1.0);
            }
        }
    }

    /// Another, larger cloud about another start, if there is one left.
    fn begin_cloud(&mut self) -> bool {
        if self.cloud >= CLOUDS_MAX {
            return false;
        }
        let unit = start(u16::from(self.cloud) - 1);
        self.cloud += 1;
        self.rates = Rates::new(self.free, 2 * self.rates.population);
        self.mean = Vector3::zeros();
        for (value, unit) in self.mean.iter_mut().zip(unit).take(self.free) {
            *value = 2.0 * unit - 1.0;
        }
        self.spread = SPREAD;
        self.covariance = Matrix3::identity();
        self.axes = Matrix3::identity();
        self.lengths = Vector3::repeat(1.0);
        self.path = Vector3::zeros();
        self.step_path = Vector3::zeros();
        self.generation = 0;
        self.flat = 0;
        true
    }
}

/// `value` mirrored at the face that it is beyond; at the far face if it is that far.
fn mirrored(value: f32) -> f32 {
    let mirrored = if value > 1.0 {
        2.0 - value
    } else if value < -1.0 {
        -2.0 - value
    } else {
        value
    };
    within(mirrored, -1.0, 1.0)
}

/// CMA-ES.
pub type CmaEs = Search<Evolution>;

#[cfg(test)]
mod tests {
    use super::super::SearchOptions;
    use super::*;

    #[test]
    fn rates_are_those_of_the_tutorials_table() {
        // n = 3, population 7: weights ln 4 - ln i of 3 parents, normalised.
        let rates = Rates::new(3, 7);
        assert_eq!(rates.parents, 3);
        let expected = [0.5856, 0.2928, 0.1215];
        for (weight, expected) in rates.weights.iter().zip(expected) {
            assert!((weight - expected).abs() < 1e-3, "{:?}", rates.weights);
        }
        assert!((rates.parents_effective - 2.258).abs() < 0.01, "{}", rates.parents_effective);
        assert!((rates.chi - 1.5958).abs() < 0.01, "{}", rates.chi);
    }

    #[test]
    fn a_cloud_is_as_wide_in_each_free_component_as_its_covariance_says_whatever_the_order_of_its_axes() {
        let setup = Setup { start: Point::zeros(), free: 2, steps: Point::zeros(), options: SearchOptions::default() };
        for deviations in [[0.01_f32, 0.2], [0.2, 0.01], [2.0, 0.5]] {
            let mut cloud = Evolution::new(&setup);
            cloud.spread = 0.1;
            for (axis, deviation) in deviations.iter().enumerate() {
                cloud.covariance[(axis, axis)] = deviation * deviation;
            }
            cloud.decompose();
            let mut squares = Point::zeros();
            for _ in 0..2000 {
                let point = cloud.draw();
                squares += point.component_mul(&point) / 2000.0;
            }
            for (axis, deviation) in deviations.iter().enumerate() {
                let width = libm::sqrtf(squares[axis]);
                assert!((width / (0.1 * deviation) - 1.0).abs() < 0.1, "{axis}: {width} {deviation}");
            }
            assert_eq!(squares.z, 0.0);
        }
    }

    #[test]
    fn what_is_beyond_a_face_is_mirrored_into_the_box() {
        assert_eq!([1.25, -1.5, 0.3, 9.0, -9.0].map(mirrored), [0.75, -0.5, 0.3, -1.0, 1.0]);
    }
}
