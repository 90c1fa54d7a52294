//! The few spatial formulas that the table generator needs, in f64.

/// Rotation matrix, rows first.
pub type Matrix = [[f64; 3]; 3];

/// A rigid transform: rotation, then translation in metres.
#[derive(Clone, Copy)]
pub struct Frame {
    pub rotation: Matrix,
    pub xyz_m: [f64; 3],
}

/// Product of two 3x3 matrices.
pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let mut c = [[0.0; 3]; 3];
    for (i, row) in c.iter_mut().enumerate() {
        for (j, value) in row.iter_mut().enumerate() {
            *value = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
        }
    }
    c
}

/// Matrix times vector.
pub fn rotate(r: &Matrix, v: &[f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| r[i][0] * v[0] + r[i][1] * v[1] + r[i][2] * v[2])
}

/// Transposed matrix.
pub fn transpose(r: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[j][i]))
}

/// Rotation about z by an angle in radians.
pub fn about_z(angle_rad: f64) -> Matrix {
    let (s, c) = angle_rad.sin_cos();
    [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
}

/// URDF's fixed-axis roll, pitch, yaw: Rz(yaw) Ry(pitch) Rx(roll), radians.
pub fn from_rpy(rpy: &[f64; 3]) -> Matrix {
    let ((sr, cr), (sp, cp), (sy, cy)) = (rpy[0].sin_cos(), rpy[1].sin_cos(), rpy[2].sin_cos());
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

/// URDF's roll, pitch, yaw as quaternion i, j, k, w.
pub fn quaternion(rpy: &[f64; 3]) -> [f64; 4] {
    let [(sr, cr), (sp, cp), (sy, cy)] = rpy.map(|a| (0.5 * a).sin_cos());
    [sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy]
}

impl Frame {
    /// `self * other`.
    pub fn then(&self, other: &Frame) -> Frame {
        let moved = rotate(&self.rotation, &other.xyz_m);
        Frame { rotation: product(&self.rotation, &other.rotation), xyz_m: [0, 1, 2].map(|i| self.xyz_m[i] + moved[i]) }
    }
}

/// Mass, centre of mass and inertia about it, all in one frame.
#[derive(Clone, Copy)]
pub struct Body {
    pub mass_kg: f64,
    pub com_m: [f64; 3],
    pub inertia: Matrix,
}

impl Body {
    /// The same body seen from the frame in which `frame` is given.
    pub fn seen_through(&self, frame: &Frame) -> Body {
        let com = rotate(&frame.rotation, &self.com_m);
        Body {
            mass_kg: self.mass_kg,
            com_m: [0, 1, 2].map(|i| frame.xyz_m[i] + com[i]),
            inertia: product(&product(&frame.rotation, &self.inertia), &transpose(&frame.rotation)),
        }
    }

    /// Two bodies in one frame made one, by the parallel-axis theorem.
    pub fn joined(&self, other: &Body) -> Body {
        let mass_kg = self.mass_kg + other.mass_kg;
        let com_m = [0, 1, 2].map(|i| (self.mass_kg * self.com_m[i] + other.mass_kg * other.com_m[i]) / mass_kg);
        let mut inertia = [[0.0; 3]; 3];
        for part in [self, other] {
            let d: [f64; 3] = [0, 1, 2].map(|i| part.com_m[i] - com_m[i]);
            let square = d.iter().map(|x| x * x).sum::<f64>();
            for i in 0..3 {
                for j in 0..3 {
                    let diagonal = if i == j { square } else { 0.0 };
                    inertia[i][j] += part.inertia[i][j] + part.mass_kg * (diagonal - d[i] * d[j]);
                }
            }
        }
        Body { mass_kg, com_m, inertia }
    }
}
