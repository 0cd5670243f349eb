//! Added mass of a hull approximated by a row of square blocks (Brunner 1988, p. 53, and Table 4).
//!
//! A block of side `A` and thickness `B` that moves normal to its square face has the added mass
//!
//! ```text
//! dm = k rho A^2 B,    k = 1.32, 0.70, 0.35  at  B/A = 0.5, 1, 2
//! ```
//!
//! Between these ratios `k` is interpolated over the logarithm of the ratio; outside them it is unknown.

use super::inertia::box_inertia;

/// `(B/A, k)` as tabulated.
const FACTORS: [(f64, f64); 3] = [(0.5, 1.32), (1.0, 0.70), (2.0, 0.35)];

/// `k` at the ratio `B/A`; `None` outside the table.
#[must_use]
pub fn block_factor(ratio: f64) -> Option<f64> {
    // A ratio of sides that were converted from inches is off by rounding.
    let ratio = FACTORS
        .iter()
        .map(|(r, _)| *r)
        .find(|r| (ratio - r).abs() < 1e-9)
        .unwrap_or(ratio);
    FACTORS.windows(2).find_map(|pair| {
        let ((r0, k0), (r1, k1)) = (pair[0], pair[1]);
        (r0..=r1)
            .contains(&ratio)
            .then(|| k0 + (k1 - k0) * libm::log(ratio / r0) / libm::log(r1 / r0))
    })
}

/// Added mass \[kg\] of one block of side `a` and thickness `b` \[m\] in water of density `rho`; `None` if `b/a` is outside the table.
#[must_use]
pub fn block(rho: f64, a: f64, b: f64) -> Option<f64> {
    Some(block_factor(b / a)? * rho * a * a * b)
}

/// Added moment of inertia \[kg m^2\] of `mass` \[kg\] distributed over a box with sides `length` and `breadth`.
#[must_use]
pub fn spread(mass: f64, length: f64, breadth: f64) -> f64 {
    box_inertia(mass, length, breadth)
}

/// Added moment of inertia \[kg m^2\] of `count` blocks of side `a` in a row along the hull, with total mass `mass` \[kg\]; each block's
/// own extent along the row is included.
#[must_use]
pub fn in_a_row(mass: f64, count: u32, a: f64) -> f64 {
    let n = f64::from(count);
    // The mean square of the centres' places, a (i - (n - 1) / 2), is a^2 (n^2 - 1) / 12.
    let places = a * a * (n * n - 1.0) / 12.0;
    mass * (places + a * a / 12.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_s_ratios_have_the_table_s_factors_and_others_lie_between() {
        assert_eq!(block_factor(0.5), Some(1.32));
        assert!((block_factor(1.0).expect("in") - 0.70).abs() < 1e-15);
        assert!((block_factor(2.0 + 1e-12).expect("in") - 0.35).abs() < 1e-15);
        assert!((0.35..0.70).contains(&block_factor(1.5).expect("in")));
        assert_eq!(block_factor(3.0), None);
        assert_eq!(block_factor(f64::NAN), None);
    }

    #[test]
    fn blocks_in_a_row_weigh_like_a_rod_of_their_length() {
        assert!((in_a_row(2.0, 4, 0.5) - spread(2.0, 2.0, 0.0)).abs() < 1e-15);
    }
}
