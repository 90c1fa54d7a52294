//! `basin`: the bounded ones that apply, on plain vectors.

use super::counted::{Counted, Spent, Told};
use super::{SEED, STEP, contender, simplex};
use crate::Contender;
use basin::{
    Bobyqa, BoundedCmaEs, BoundedLevenbergMarquardt, BoxBounds, ConstraintDescription, ConstraintSet, Constraints,
    CostFunction, DenseMatrix, Executor, FirstOrderState, Gradient, Jacobian, Lbfgsb, NelderMead, PointState,
    PopulationProgress, Residual, SimplexProgress,
};

const ORIGIN: &str = "basin";
/// Rows of the residuals made of error, gradient and curvature.
const ROWS: usize = 4;

struct Objective<'a, 'b> {
    counted: &'a Counted<'b>,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl<'a, 'b> Objective<'a, 'b> {
    fn new(counted: &'a Counted<'b>) -> Self {
        Self { counted, lower: vec![-1.0; 3], upper: vec![1.0; 3] }
    }
}

impl Constraints for Objective<'_, '_> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

impl CostFunction for Objective<'_, '_> {
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Spent;

    fn cost(&self, u: &Vec<f64>) -> Result<f64, Spent> {
        Ok(self.counted.at(u)?.error)
    }
}

impl Gradient for Objective<'_, '_> {
    type Gradient = Vec<f64>;

    fn gradient(&self, u: &Vec<f64>) -> Result<Vec<f64>, Spent> {
        Ok(self.counted.at(u)?.gradient.to_vec())
    }
}

impl Residual for Objective<'_, '_> {
    type Param = Vec<f64>;
    type Output = Vec<f64>;
    type Error = Spent;

    fn residual(&self, u: &Vec<f64>) -> Result<Vec<f64>, Spent> {
        Ok(Model::of(&self.counted.at(u)?).residual.to_vec())
    }
}

impl Jacobian for Objective<'_, '_> {
    type Jacobian = DenseMatrix;

    fn jacobian(&self, u: &Vec<f64>) -> Result<DenseMatrix, Spent> {
        let model = Model::of(&self.counted.at(u)?);
        // The last residual is the rest of the error, which the model has no slope for.
        Ok(DenseMatrix::from_fn(ROWS, 3, |row, column| if row < 3 { model.root[column][row] } else { 0.0 }))
    }
}

/// Four residuals with the error's own Gauss-Newton model: the squares add up to the error, `J'r` is half its gradient
/// and `J'J` its half curvature. With `J'J = L L'` they are `L^-1 g` and the root of what is left of the error.
struct Model {
    residual: [f64; ROWS],
    root: [[f64; 3]; 3],
}

impl Model {
    fn of(told: &Told) -> Self {
        let mut root = [[0.0; 3]; 3];
        let trace: f64 = (0..3).map(|axis| told.curvature[axis][axis]).sum();
        let floor = 1e-9 * trace + 1e-12;
        for row in 0..3 {
            for column in 0..=row {
                let known: f64 = (0..column).map(|k| root[row][k] * root[column][k]).sum();
                let left = told.curvature[row][column] - known;
                root[row][column] = if row == column { left.max(floor).sqrt() } else { left / root[column][column] };
            }
        }
        let mut residual = [0.0; ROWS];
        for row in 0..3 {
            let known: f64 = (0..row).map(|k| root[row][k] * residual[k]).sum();
            residual[row] = (0.5 * told.gradient[row] - known) / root[row][row];
        }
        let explained: f64 = residual.iter().map(|r| r * r).sum();
        residual[3] = (told.error - explained).max(0.0).sqrt();
        Self { residual, root }
    }
}

/// Those that apply.
pub fn all() -> Vec<Contender> {
    vec![
        contender(ORIGIN, "Lbfgsb", "bounded, downhill from the guess", |counted, budget| {
            let state = FirstOrderState::new(vec![0.0; 3]);
            let _ = Executor::new(Objective::new(counted), Lbfgsb::new(), state).max_iter(budget).run();
        }),
        contender(
            ORIGIN,
            "BoundedLevenbergMarquardt",
            "downhill from the guess, on four residuals that have error, gradient and Gauss-Newton curvature of ours",
            |counted, budget| {
                let solver = BoundedLevenbergMarquardt::<Vec<f64>, DenseMatrix>::new();
                let state = PointState::new(vec![0.0; 3]);
                let _ = Executor::new(Objective::new(counted), solver, state).max_iter(budget).run();
            },
        ),
        contender(ORIGIN, "NelderMead projected", "bounded, no slope", |counted, budget| {
            let state = SimplexProgress::from_simplex(simplex());
            let _ = Executor::new(Objective::new(counted), NelderMead::new().projected(), state).max_iter(budget).run();
        }),
        contender(ORIGIN, "Bobyqa", "bounded, no slope", |counted, budget| {
            let solver = Bobyqa::new().with_initial_radius(STEP);
            let state = PointState::new(vec![0.0; 3]);
            let _ = Executor::new(Objective::new(counted), solver, state).max_iter(budget).run();
        }),
        contender(ORIGIN, "BoundedCmaEs", "bounded, no slope, looks everywhere", |counted, budget| {
            let solver = BoundedCmaEs::<Vec<f64>, DenseMatrix>::new(SEED, STEP);
            let state = PopulationProgress::<Vec<f64>>::from_point(vec![0.0; 3]);
            let _ = Executor::new(Objective::new(counted), solver, state).max_iter(budget).run();
        }),
    ]
}
