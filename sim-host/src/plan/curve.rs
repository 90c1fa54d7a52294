//! A path through joint space without time: a uniform cubic B-spline, continuous to the second derivative.

use super::Joints;

/// Joint angles as a function of a path parameter `u` in [0, [`Curve::length`]].
///
/// Interpolating (a line that must be followed) and approximating (corners to be rounded) curves differ only in how the control
/// points come about. Numbers are `f64` with the four operations and the square root alone, hence equal on every machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Path parameter between two breakpoints.
    step: f64,
    /// One more than breakpoints at each end.
    control: Vec<[f64; 7]>,
}

/// Position and derivatives of a curve with respect to its parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Joint angles, radians.
    pub q: [f64; 7],
    /// First derivative, radians per unit of `u`.
    pub dq: [f64; 7],
    /// Second derivative.
    pub ddq: [f64; 7],
}

impl Curve {
    /// The curve through all `points` (at least two), `step` apart in `u`. The second derivatives at the ends are estimated from the first and
    /// last four points, so that the error stays of fourth order in `step`.
    pub fn through(points: &[Joints], step: f64) -> Option<Self> {
        let n = points.len().checked_sub(1).filter(|n| *n >= 1 && step > 0.0)?;
        let p: Vec<[f64; 7]> = points.iter().map(|q| q.map(f64::from)).collect();
        let bend = |a: usize, b: usize, c: usize, d: usize, j: usize| {
            if n >= 3 { 2.0 * p[a][j] - 5.0 * p[b][j] + 4.0 * p[c][j] - p[d][j] } else { 0.0 }
        };
        let mut control = vec![[0.0; 7]; n + 3];
        for j in 0..7 {
            let (first, last) =
                if n >= 3 { (bend(0, 1, 2, 3, j), bend(n, n - 1, n - 2, n - 3, j)) } else { (0.0, 0.0) };
            // c[i-1] + 4 c[i] + c[i+1] = 6 p[i] with both ends known: Thomas' algorithm. Control point i is at index i + 1.
            let c_first = p[0][j] - first / 6.0;
            let c_last = p[n][j] - last / 6.0;
            let mut upper = vec![0.0; n];
            let mut right = vec![c_first; n];
            for i in 1..n {
                let pivot = 4.0 - upper[i - 1];
                upper[i] = 1.0 / pivot;
                right[i] = (6.0 * p[i][j] - right[i - 1]) / pivot;
            }
            control[n + 1][j] = c_last;
            for i in (1..n).rev() {
                control[i + 1][j] = right[i] - upper[i] * control[i + 2][j];
            }
            control[1][j] = c_first;
            control[0][j] = 2.0 * c_first - control[2][j] + first;
            control[n + 2][j] = 2.0 * c_last - control[n][j] + last;
        }
        Some(Self { step, control })
    }

    /// The curve that starts and ends where `polyline` does and rounds its corners within half a length of `step = length / pieces`.
    /// Its parameter is the length of the polyline as measured by `metric`. `None` if that is zero.
    pub fn rounding(polyline: &[Joints], pieces: usize, metric: impl Fn(&Joints, &Joints) -> f64) -> Option<Self> {
        let mut lengths = vec![0.0];
        for (a, b) in polyline.iter().zip(polyline.iter().skip(1)) {
            lengths.push(lengths[lengths.len() - 1] + metric(a, b));
        }
        let total = *lengths.last()?;
        if total <= 0.0 || !total.is_finite() || pieces == 0 {
            return None;
        }
        let step = total / pieces as f64;
        let at = |u: f64| {
            let k = lengths.iter().position(|l| *l >= u).unwrap_or(lengths.len() - 1).max(1);
            let (a, b) = (polyline[k - 1].map(f64::from), polyline[k].map(f64::from));
            let s = ((u - lengths[k - 1]) / (lengths[k] - lengths[k - 1])).clamp(0.0, 1.0);
            core::array::from_fn(|j| a[j] + s * (b[j] - a[j]))
        };
        let mut control = vec![[0.0; 7]];
        control.extend((0..=pieces).map(|i| at(step * i as f64)));
        control.push([0.0; 7]);
        let n = control.len();
        // Ends without curvature make the curve pass through the first and the last point.
        control[0] = core::array::from_fn(|j| 2.0 * control[1][j] - control[2][j]);
        control[n - 1] = core::array::from_fn(|j| 2.0 * control[n - 2][j] - control[n - 3][j]);
        Some(Self { step, control })
    }

    /// Range of the parameter.
    pub fn length(&self) -> f64 {
        self.step * self.pieces() as f64
    }

    /// Number of cubic pieces.
    pub fn pieces(&self) -> usize {
        self.control.len() - 3
    }

    /// Where the curve is at `u` (clamped to its range).
    pub fn at(&self, u: f64) -> Point {
        let x = (u / self.step).clamp(0.0, self.pieces() as f64);
        let i = (x as usize).min(self.pieces() - 1);
        let s = x - i as f64;
        let r = 1.0 - s;
        let w = [
            r * r * r / 6.0,
            (4.0 + s * s * (3.0 * s - 6.0)) / 6.0,
            (4.0 + r * r * (3.0 * r - 6.0)) / 6.0,
            s * s * s / 6.0,
        ];
        let dw = [-0.5 * r * r, 0.5 * s * (3.0 * s - 4.0), 0.5 * r * (4.0 - 3.0 * r), 0.5 * s * s];
        let ddw = [r, 3.0 * s - 2.0, 3.0 * r - 2.0, s];
        let mix = |weights: &[f64; 4], scale: f64| {
            core::array::from_fn(|j| (0..4).map(|k| weights[k] * self.control[i + k][j]).sum::<f64>() * scale)
        };
        Point { q: mix(&w, 1.0), dq: mix(&dw, 1.0 / self.step), ddq: mix(&ddw, 1.0 / (self.step * self.step)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(u: f64) -> [f64; 7] {
        core::array::from_fn(|j| libm::sin(u + 0.3 * j as f64))
    }

    #[test]
    fn an_interpolating_curve_follows_a_sine_and_its_derivatives() {
        let points: Vec<Joints> = (0..=20).map(|i| sine(0.1 * f64::from(i)).map(|x| x as f32)).collect();
        let curve = Curve::through(&points, 0.1).unwrap();
        assert!((curve.length() - 2.0).abs() < 1e-12);
        for k in 0..=100 {
            let u = 0.02 * f64::from(k);
            let point = curve.at(u);
            for j in 0..7 {
                let x = u + 0.3 * j as f64;
                assert!((point.q[j] - libm::sin(x)).abs() < 2e-5, "q at {u}");
                assert!((point.dq[j] - libm::cos(x)).abs() < 1e-3, "dq at {u}");
                assert!((point.ddq[j] + libm::sin(x)).abs() < 2e-2, "ddq at {u}");
            }
        }
    }

    #[test]
    fn a_rounded_polyline_keeps_its_ends_and_cuts_only_the_corner() {
        let corner = [[0.0; 7], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]];
        let length =
            |a: &Joints, b: &Joints| f64::from(a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max));
        let curve = Curve::rounding(&corner, 10, length).unwrap();
        assert!((curve.length() - 2.0).abs() < 1e-9);
        assert_eq!(curve.at(0.0).q, [0.0; 7]);
        let end = curve.at(2.0).q;
        assert!((end[0] - 1.0).abs() < 1e-12 && (end[1] - 1.0).abs() < 1e-12);
        let middle = curve.at(1.0).q;
        assert!(middle[0] > 0.95 && middle[0] < 1.0 && middle[1] > 0.0 && middle[1] < 0.05, "{middle:?}");
        assert!((curve.at(0.5).q[0] - 0.5).abs() < 1e-9, "straight parts stay straight");
    }

    #[test]
    fn nothing_to_travel_is_no_curve() {
        assert_eq!(Curve::rounding(&[[0.3; 7], [0.3; 7]], 8, |_, _| 0.0), None);
        assert_eq!(Curve::through(&[[0.3; 7]], 0.1), None);
    }
}
