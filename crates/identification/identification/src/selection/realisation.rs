//! Poles for every order from one high-order equation.
//!
//! There are two ways from a high-order equation to few poles. First, the Markov parameters `g1, g2, ...` of its transfer function fill a
//! Hankel matrix, whose n largest singular directions are shift invariant and give the poles (Kung, *12th Asilomar Conf.*, 1978). Second,
//! states by canonical variates ([`crate::states`]), which weight by the noise and are valid in a closed loop too.

use nalgebra::DMatrix;

use super::lagged::{Equation, Lagged};
use crate::estimators::impulse;
use crate::states::{HIGH, characteristic, solved};
use crate::structure::monic;
use planesman_record::filter;

/// Number of Markov parameters in a row of the Hankel matrix.
const HANKEL: usize = 80;

/// The high-order equation chosen by Akaike's criterion.
pub(super) fn high_order(lagged: &Lagged, constant: bool) -> Option<Equation> {
    let all = lagged.over(&|_| true);
    let criterion = |of: &Equation| {
        let parameters = (of.a.len() + of.b.len()) as f64;
        of.rows as f64 * libm::log(of.variance.max(f64::MIN_POSITIVE)) + 2.0 * parameters
    };
    HIGH.iter()
        .filter(|order| **order <= lagged.lags && all.1 > 4 * (2 * **order + 2))
        .filter_map(|order| lagged.equation(&all, *order, 0, order + 1, constant))
        .min_by(|p, q| criterion(p).total_cmp(&criterion(q)))
}

/// `a1 ... an` of the orders up to `most`, from the Markov parameters.
pub(crate) fn from_markov_parameters(
    high: &Equation,
    samples: usize,
    most: usize,
) -> Vec<Vec<f64>> {
    let rows = HANKEL.min(samples / 4);
    if rows < 2 * most {
        return Vec::new();
    }
    let g = filter(&high.b, &monic(&high.a), &impulse(0, 2 * rows));
    let early = g.iter().take(20).fold(0.0_f64, |m, v| m.max(v.abs()));
    if !g.iter().all(|v| v.is_finite() && v.abs() <= 1e6 * early) {
        return Vec::new();
    }
    let hankel = DMatrix::from_fn(rows, rows, |i, j| g[i + j + 1]);
    let symmetric = hankel.symmetric_eigen();
    let mut order: Vec<usize> = (0..rows).collect();
    order.sort_by(|i, j| {
        let size = |i: &usize| symmetric.eigenvalues[*i].abs();
        size(j).total_cmp(&size(i))
    });
    (1..=most)
        .map_while(|n| {
            let observability = DMatrix::from_fn(rows, n, |i, j| {
                symmetric.eigenvectors[(i, order[j])] * symmetric.eigenvalues[order[j]].abs().sqrt()
            });
            let above = observability.rows(0, rows - 1).into_owned();
            let below = observability.rows(1, rows - 1).into_owned();
            characteristic(&solved(&above, &below)?)
        })
        .collect()
}
