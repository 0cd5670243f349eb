//! Inertia of the body and its added mass, and their Coriolis forces.
//!
//! For any symmetric 6 x 6 inertia `A` with the momentum `(P, H) = A nu`, `nu = (v, w)`:
//!
//! ```text
//! C(nu) nu = ( w x P ,  v x P + w x H )
//! ```
//!
//! Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control (2011), (3.46) and (6.43), as a product. With added mass it includes
//! the Munk moment, `(X_udot - Y_vdot) u v` about z, and uses the velocity through the water.

use nalgebra::SMatrix;

use super::lanes::{Real, Six, Three, cross, halves, of, product, scaled, six, sum};

/// A 6 x 6 matrix, by rows.
pub type Matrix6 = [[f64; 6]; 6];

/// The rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidBody {
    /// \[kg\]
    pub mass: f64,
    /// Centre of gravity from the origin \[m\].
    pub centre_of_gravity: Three<f64>,
    /// Inertia about the origin \[kg m^2\]; the off-diagonal products are negative: `[Ix -Ixy -Ixz; ...]`.
    pub inertia: [Three<f64>; 3],
}

impl RigidBody {
    /// `M_RB`.
    #[must_use]
    pub fn matrix(&self) -> Matrix6 {
        let m = self.mass;
        let [x, y, z] = self.centre_of_gravity.map(|r| m * r);
        let [a, b, c] = self.inertia;
        [
            [m, 0.0, 0.0, 0.0, z, -y],
            [0.0, m, 0.0, -z, 0.0, x],
            [0.0, 0.0, m, y, -x, 0.0],
            [0.0, -z, y, a[0], a[1], a[2]],
            [z, 0.0, -x, b[0], b[1], b[2]],
            [-y, x, 0.0, c[0], c[1], c[2]],
        ]
    }

    /// `-C_RB(nu) nu`.
    #[inline(always)]
    pub(super) fn coriolis<T: Real>(&self, nu: &Six<T>) -> Six<T> {
        let (v, w) = halves(*nu);
        let (m, r) = (T::of(self.mass), of(&self.centre_of_gravity));
        let momentum = scaled(m, sum(v, cross(w, r)));
        let turning = sum(product(&self.inertia, &w), scaled(m, cross(r, v)));
        reaction(v, w, momentum, turning)
    }
}

/// Inertia about the origin from the inertia about the centre of gravity: `I_g - m S(r)^2`.
#[must_use]
pub fn about_origin(inertia: [Three<f64>; 3], mass: f64, r: Three<f64>) -> [Three<f64>; 3] {
    let square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let own = if i == j { square } else { 0.0 };
            inertia[i][j] + mass * (own - r[i] * r[j])
        })
    })
}

/// `-C(nu) nu` for an inertia `A`.
#[inline(always)]
pub(super) fn coriolis<T: Real>(a: &Matrix6, nu: &Six<T>) -> Six<T> {
    let (v, w) = halves(*nu);
    let (momentum, turning) = halves(product(a, nu));
    reaction(v, w, momentum, turning)
}

/// `-( w x P , v x P + w x H )`.
#[inline(always)]
fn reaction<T: Real>(v: Three<T>, w: Three<T>, p: Three<T>, h: Three<T>) -> Six<T> {
    six(cross(p, w), sum(cross(p, v), cross(h, w)))
}

/// Inverse of a symmetric matrix; `None` if it is not positive definite.
pub(super) fn inverse(a: &Matrix6) -> Option<Matrix6> {
    let matrix = SMatrix::<f64, 6, 6>::from_fn(|i, j| a[i][j]);
    let inverse = matrix.cholesky()?.inverse();
    Some(std::array::from_fn(|i| {
        std::array::from_fn(|j| inverse[(i, j)])
    }))
}

/// `a + b`.
pub(super) fn added(a: &Matrix6, b: &Matrix6) -> Matrix6 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + b[i][j]))
}

/// Added mass of an ellipsoid about its centre: the diagonal X, Y, Z, K, M, N \[kg, kg m^2\], for semi-axes `[a, b, c]` \[m\] in water of
/// density `rho` \[kg/m^3\] (Lamb, Hydrodynamics (1932), art. 114 and 373).
#[must_use]
pub fn ellipsoid(rho: f64, axes: Three<f64>) -> Six<f64> {
    let [a, b, c] = axes;
    let squares = axes.map(|x| x * x);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * a * b * c;
    let shape: Three<f64> = std::array::from_fn(|i| {
        let [x, y] = [squares[(i + 1) % 3], squares[(i + 2) % 3]];
        2.0 / 3.0 * a * b * c * carlson_rd(x, y, squares[i])
    });
    let along = shape.map(|s| rho * volume * s / (2.0 - s));
    let about = std::array::from_fn(|i| {
        let [j, k] = [(i + 1) % 3, (i + 2) % 3];
        let (less, more) = (squares[j] - squares[k], squares[j] + squares[k]);
        let turn = shape[k] - shape[j];
        let denominator = 2.0 * less - more * turn;
        match less == 0.0 {
            true => 0.0,
            false => rho * volume / 5.0 * less * less * turn / denominator,
        }
    });
    six(along, about)
}

/// Carlson's integral `R_D(x, y, z) = 3/2 int_0^inf dt / (sqrt((t+x)(t+y)) (t+z)^(3/2))`, by duplication (Numerical Algorithms 10 (1995),
/// 13).
fn carlson_rd(x: f64, y: f64, z: f64) -> f64 {
    let (mut x, mut y, mut z) = (x, y, z);
    let (mut sum, mut power) = (0.0, 1.0);
    loop {
        let mean = (x + y + 3.0 * z) / 5.0;
        let [dx, dy, dz] = [x, y, z].map(|v| 1.0 - v / mean);
        if [dx, dy, dz].iter().all(|d| d.abs() < 1e-3) {
            let (ea, eb) = (dx * dy, dz * dz);
            let e2 = ea - 6.0 * eb;
            let e3 = (3.0 * ea - 8.0 * eb) * dz;
            let e4 = 3.0 * (ea - eb) * eb;
            let e5 = ea * eb * dz;
            let series = 1.0 - 3.0 / 14.0 * e2 + e3 / 6.0 + 9.0 / 88.0 * e2 * e2
                - 3.0 / 22.0 * e4
                - 9.0 / 52.0 * e2 * e3
                + 3.0 / 26.0 * e5;
            return 3.0 * sum + power * series / (mean * mean.sqrt());
        }
        let [sx, sy, sz] = [x.sqrt(), y.sqrt(), z.sqrt()];
        let lambda = sx * sy + sx * sz + sy * sz;
        sum += power / (sz * (z + lambda));
        power /= 4.0;
        [x, y, z] = [x, y, z].map(|v| (v + lambda) / 4.0);
    }
}
