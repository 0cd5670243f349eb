//! Hydrodynamic coefficients by name: force or moment per product of velocities (Prestero 2001; Healey and Lienard 1993).
//!
//! `Y_uv` is the sway force per `u v`, `Z_w|w|` the heave force per `w |w|`, `N_uudr` the yaw moment per `u^2 delta_r`, `X_udot` the surge
//! force per `u'`. SI units; the velocities are through the water.

use super::inertia::{Matrix6, coriolis};
use super::lanes::{Real, Six};

/// A product of two velocities, or of `u^2` and an input, in one equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Index of the equation: 0 to 5 for X, Y, Z, K, M, N.
    pub row: usize,
    /// Factor that the coefficient multiplies.
    pub of: Factor,
    /// Value of the coefficient, SI.
    pub value: f64,
}

/// Factor that a coefficient multiplies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Factor {
    /// `nu_i nu_j`, `i <= j`.
    Velocities(usize, usize),
    /// `nu_i |nu_j|`, written `i|j|` or `|j|i`.
    Drag(usize, usize),
    /// `nu_i`.
    Velocity(usize),
    /// `nu_i'`, an acceleration: added mass.
    Acceleration(usize),
    /// `u^2` times input `k` of the vehicle.
    Input(usize),
}

const VELOCITIES: &str = "uvwpqr";
const ROWS: &str = "XYZKMN";

/// An invalid coefficient name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "not the name of a coefficient; use a row (X, Y, Z, K, M or N), then _ and velocities of u, v, w, p, q, r (Y_uv, Z_w|w|), a velocity and dot (X_udot), or uu and an input ({0})"
)]
pub struct Unknown(String);

/// Parses the name of a term; `inputs` are the vehicle's names, such as `dr` for the rudder.
///
/// # Errors
/// [`Unknown`], if the name is invalid.
pub fn term(name: &str, value: f64, inputs: &[&str]) -> Result<Term, Unknown> {
    let parsed = (|| {
        let (row, product) = name.split_once('_')?;
        let row = ROWS.find(row).filter(|_| row.len() == 1)?;
        let velocity = |c: char| VELOCITIES.find(c);
        let chars: Vec<char> = product.chars().collect();
        let of = match chars[..] {
            [x, 'd', 'o', 't'] => Factor::Acceleration(velocity(x)?),
            [x, '|', y, '|'] | ['|', y, '|', x] => Factor::Drag(velocity(x)?, velocity(y)?),
            [x] => Factor::Velocity(velocity(x)?),
            [x, y] => {
                let (x, y) = (velocity(x)?, velocity(y)?);
                Factor::Velocities(x.min(y), x.max(y))
            }
            ['u', 'u', ..] => Factor::Input(inputs.iter().position(|name| *name == &product[2..])?),
            _ => return None,
        };
        Some(Term { row, of, value })
    })();
    parsed.ok_or_else(|| Unknown(format!("inputs: {}", inputs.join(", "))))
}

impl Term {
    #[inline(always)]
    pub(super) fn force<T: Real>(&self, nu: &Six<T>, inputs: &[T]) -> T {
        let factor = match self.of {
            Factor::Velocities(i, j) => nu[i] * nu[j],
            Factor::Drag(i, j) => nu[i] * nu[j].abs(),
            Factor::Velocity(i) => nu[i],
            Factor::Acceleration(_) => T::of(0.0),
            Factor::Input(k) => nu[0] * nu[0] * inputs[k],
        };
        T::of(self.value) * factor
    }
}

/// Added mass from the terms in `nu'`: `M_A = -(derivatives)`. One name is enough for two symmetric entries of the matrix.
pub(super) fn added_mass(terms: &[Term]) -> Matrix6 {
    let mut named = [[None; 6]; 6];
    for term in terms {
        if let Factor::Acceleration(j) = term.of {
            named[term.row][j] = Some(-term.value);
        }
    }
    std::array::from_fn(|i| std::array::from_fn(|j| named[i][j].or(named[j][i]).unwrap_or(0.0)))
}

/// Terms of a table that includes the products of added mass, with these products removed: the Coriolis forces of added mass are computed
/// from `M_A`, and only the remainder of a printed coefficient is kept. Terms in `nu'` are removed.
pub(super) fn beyond_added_mass(terms: &[Term], added_mass: &Matrix6) -> Vec<Term> {
    let unit = |i: usize, j: usize| -> Six<f64> {
        std::array::from_fn(|k| if k == i || k == j { 1.0 } else { 0.0 })
    };
    let mut rest: Vec<Term> = terms.to_vec();
    rest.retain(|term| !matches!(term.of, Factor::Acceleration(_)));
    for i in 0..6 {
        for j in i..6 {
            let both = coriolis(added_mass, &unit(i, j));
            let (first, second) = (
                coriolis(added_mass, &unit(i, i)),
                coriolis(added_mass, &unit(j, j)),
            );
            for row in 0..6 {
                let implied = match i == j {
                    true => both[row],
                    false => both[row] - first[row] - second[row],
                };
                let of = Factor::Velocities(i, j);
                match rest
                    .iter_mut()
                    .find(|term| term.row == row && term.of == of)
                {
                    Some(term) => term.value -= implied,
                    None if implied != 0.0 => rest.push(Term {
                        row,
                        of,
                        value: -implied,
                    }),
                    None => {}
                }
            }
        }
    }
    rest.retain(|term| term.value != 0.0);
    rest
}
