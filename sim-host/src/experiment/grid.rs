//! Grids of poses: those of the published experiments, or any other.

use super::conduct::Conditions;
use super::method::Method;
use super::replan::Replan;
use serde::{Serialize, Serializer};
use std::str::FromStr;
use tactus_common::pose::{Interval, PlanarPose};

/// Equally spaced values from a least to a greatest one, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    min: f32,
    max: f32,
    step: f32,
}

/// Most values of an axis.
const VALUES_MAX: f32 = 10_000.0;

impl Axis {
    /// One value only.
    pub const fn at(value: f32) -> Self {
        Self { min: value, max: value, step: 1.0 }
    }

    /// How many values there are.
    pub fn count(&self) -> usize {
        libm::floorf((self.max - self.min) / self.step + 1.0 + 1e-3) as usize
    }

    /// The value of an index.
    pub fn value(&self, index: usize) -> f32 {
        self.min + index as f32 * self.step
    }

    /// The greatest distance of a value from `centre`.
    fn reach(&self, centre: f32) -> f32 {
        (centre - self.min).abs().max((self.max - centre).abs())
    }
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected MIN,MAX,STEP: three numbers, MIN <= MAX, STEP > 0";
        let numbers: Vec<f32> = text.split(',').filter_map(|s| s.trim().parse().ok()).collect();
        let [min, max, step] = numbers[..] else { return Err(expected.to_owned()) };
        let is_sound = [min, max, step].iter().all(|v| v.is_finite()) && min <= max && step > 0.0;
        if !is_sound || text.split(',').count() != 3 {
            return Err(expected.to_owned());
        }
        if (max - min) / step > VALUES_MAX {
            return Err(format!("more than {VALUES_MAX} values; {expected}"));
        }
        Ok(Self { min, max, step })
    }
}

impl Serialize for Axis {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        [self.min, self.max, self.step].serialize(serializer)
    }
}

/// Poses on a grid: x runs fastest, then y, then phi.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Grid {
    /// World x, metres.
    pub x: Axis,
    /// World y, metres.
    pub y: Axis,
    /// Yaw, radians.
    pub phi: Axis,
}

impl Grid {
    /// The starts of the published experiments (Nikandrova 2011, table 3): 21 x 23 poses.
    pub const TABLE_3: Self = Self {
        x: Axis { min: 0.1, max: 0.3, step: 0.01 },
        y: Axis { min: -0.15, max: -0.04, step: 0.005 },
        phi: Axis::at(0.0),
    };

    /// The number of poses.
    pub fn count(&self) -> usize {
        self.x.count() * self.y.count() * self.phi.count()
    }

    /// The pose of an index.
    pub fn pose(&self, index: usize) -> PlanarPose {
        let (nx, ny) = (self.x.count(), self.y.count());
        PlanarPose::new(self.x.value(index % nx), self.y.value(index / nx % ny), self.phi.value(index / nx / ny))
    }

    /// Half widths about any pose of the grid that hold `truth`; 0 where the grid has one value, which is then known.
    pub fn interval(&self, truth: &PlanarPose) -> Interval {
        // A tenth of a millimetre more: the farthest start must not lie on the very edge, where rounding decides.
        let half = |axis: &Axis, truth| if axis.count() > 1 { axis.reach(truth) + 1e-4 } else { 0.0 };
        Interval {
            x_m: half(&self.x, truth.x_m),
            y_m: half(&self.y, truth.y_m),
            phi_rad: half(&self.phi, truth.phi_rad),
        }
    }
}

/// A method, and the poses of which something is to be found out.
#[derive(Clone, Debug)]
pub struct GridOptions {
    /// The conditions; the object stands where the scene says.
    pub conditions: Conditions,
    /// The starts, or the poses of a surface.
    pub grid: Grid,
    /// The method.
    pub method: Method,
}

impl GridOptions {
    /// Where the object truly stands.
    pub fn truth(&self) -> PlanarPose {
        self.conditions.scenario.true_pose()
    }

    /// Half widths about any start that hold the truth.
    pub fn interval(&self) -> Interval {
        self.grid.interval(&self.truth())
    }

    /// The two worlds of the published formulation.
    ///
    /// # Errors
    /// The error is none of the published ones.
    pub fn replan(&self) -> anyhow::Result<Replan> {
        let published = self.method.config.published().ok_or_else(|| {
            anyhow::anyhow!("--formulation replan --error geometric: needs no trial per evaluation; expected: fixed")
        })?;
        let Conditions { scenario, reality, seed, .. } = &self.conditions;
        Replan::new(scenario, self.truth(), *reality, *seed, published)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_3_has_483_starts_from_corner_to_corner() {
        let grid = Grid::TABLE_3;
        assert_eq!((grid.x.count(), grid.y.count(), grid.count()), (21, 23, 483));
        assert_eq!(grid.pose(0), PlanarPose::new(0.1, -0.15, 0.0));
        let last = grid.pose(482);
        assert!((last.x_m - 0.3).abs() < 1e-5 && (last.y_m + 0.04).abs() < 1e-5, "{last:?}");
        assert!((grid.pose(1).x_m - 0.11).abs() < 1e-6, "x runs fastest");
    }

    #[test]
    fn the_interval_holds_the_truth_from_every_start() {
        let truth = PlanarPose::new(0.2, -0.1, 0.0);
        let interval = Grid::TABLE_3.interval(&truth);
        for index in 0..Grid::TABLE_3.count() {
            let start = Grid::TABLE_3.pose(index);
            assert!((start.x_m - truth.x_m).abs() < interval.x_m && (start.y_m - truth.y_m).abs() < interval.y_m);
        }
        assert_eq!(interval.phi_rad, 0.0);
    }

    #[test]
    fn an_axis_is_three_numbers() {
        assert_eq!("0.1,0.3,0.01".parse::<Axis>().map(|a| a.count()), Ok(21));
        for bad in ["", "1,2", "1,2,0", "2,1,0.1", "1,2,nan", "1,2,3,4", "1,x,2", "0,1e9,1e-9"] {
            assert!(bad.parse::<Axis>().is_err(), "{bad}");
        }
    }
}
