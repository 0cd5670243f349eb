//! Drag without lift: damping matrices, and cross-flow drag by strips.

use planesman_units::{Rule, readers};
use serde::Deserialize;

use super::inertia::Matrix6;
use super::lanes::{Real, Six, product, sum};
use crate::positive;

/// Linear and quadratic damping: `force_i = -sum_j (D_ij nu_j + Q_ij |nu_j| nu_j)`, with `nu` through the water.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Damping {
    /// `D`: N s/m, N s; rows of moments N s, N m s.
    pub linear: Matrix6,
    /// `Q`: N s^2/m^2 etc.
    pub quadratic: Matrix6,
}

impl Damping {
    #[inline(always)]
    pub(super) fn force<T: Real>(&self, nu: &Six<T>) -> Six<T> {
        let mut square = *nu;
        for x in &mut square {
            *x = x.abs() * *x;
        }
        let mut force = sum(product(&self.linear, nu), product(&self.quadratic, &square));
        for x in &mut force {
            *x = -*x;
        }
        force
    }
}

readers! {
    array 2 ends: Length, Rule::Any;
}

/// Cross-flow drag of a hull of constant width: each strip has the drag of its own cross-flow velocity.
///
/// ```text
/// v(x) = v + x r    w(x) = w - x q    V = sqrt(v(x)^2 + w(x)^2)
/// (Y, Z) = -1/2 rho C_d int b V (v(x), w(x)) dx     M = 1/2 rho C_d int b V w(x) x dx     N = -1/2 rho C_d int b V v(x) x dx
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrossFlow {
    /// \[kg/m^3\]
    #[serde(with = "positive::density")]
    pub density: f64,
    /// `C_d` of a cylinder across the flow.
    pub drag: f64,
    /// `b` \[m\]
    #[serde(with = "positive::length")]
    pub width: f64,
    /// Ends of the hull, aft and forward of the origin \[m\].
    #[serde(with = "ends")]
    pub ends: [f64; 2],
}

/// Nodes and weights of Gauss-Legendre quadrature on -1 to 1.
const GAUSS: [(f64, f64); 8] = [
    (-0.9602898564975363, 0.10122853629037626),
    (-0.7966664774136267, 0.22238103445337448),
    (-0.525532409916329, 0.31370664587788727),
    (-0.1834346424956498, 0.362683783378362),
    (0.1834346424956498, 0.362683783378362),
    (0.525532409916329, 0.31370664587788727),
    (0.7966664774136267, 0.22238103445337448),
    (0.9602898564975363, 0.10122853629037626),
];
const PANELS: usize = 8;

impl CrossFlow {
    #[inline(always)]
    pub(super) fn force<T: Real>(&self, nu: &Six<T>) -> Six<T> {
        let [_, v, w, _, q, r] = *nu;
        let zero = T::of(0.0);
        let mut force = [zero; 6];
        let [aft, fore] = self.ends;
        let half = (fore - aft) / (2.0 * PANELS as f64);
        for panel in 0..PANELS {
            let middle = aft + (2.0 * panel as f64 + 1.0) * half;
            for (place, weight) in GAUSS {
                let x = T::of(middle + half * place);
                let (v, w) = (v + x * r, w - x * q);
                let share = T::of(0.5 * self.density * self.drag * self.width * half * weight);
                let drag = share * (v * v + w * w).sqrt();
                force[1] += -(drag * v);
                force[2] += -(drag * w);
                force[4] += drag * w * x;
                force[5] += -(drag * v * x);
            }
        }
        force
    }
}
