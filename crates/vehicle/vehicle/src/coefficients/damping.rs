//! Viscous damping of a plate that rotates about its middle, and its linearisations (pp. 55-57).
//! Each half of the plate is assumed to move at its mean speed `L w / 4`, with its force at two thirds of its length:
//!
//! ```text
//! N = C w^2,    C = rho C_D A L^3 / 96
//! ```
//!
//! An integration strip by strip would give `/ 64`, which is 50 % more. A linear controller needs `N = B w`: the secant of the parabola at
//! a rate, `C w`, or its tangent there, `2 C w`.

/// `C` \[N m s^2\] from mean speed and centroid, for a plate of area `area` and length `length`.
#[must_use]
pub fn plate(rho: f64, drag_coefficient: f64, area: f64, length: f64) -> f64 {
    rho * drag_coefficient * area * length.powi(3) / 96.0
}

/// `C` \[N m s^2\] by integration over strips.
#[must_use]
pub fn plate_by_strips(rho: f64, drag_coefficient: f64, area: f64, length: f64) -> f64 {
    rho * drag_coefficient * area * length.powi(3) / 64.0
}

/// `B` \[N m s\], the secant of `N = c w^2` at the rate `w` \[rad/s\].
#[must_use]
pub fn secant(c: f64, w: f64) -> f64 {
    c * w
}

/// `B` \[N m s\], the tangent of `N = c w^2` at the rate `w` \[rad/s\].
#[must_use]
pub fn tangent(c: f64, w: f64) -> f64 {
    2.0 * c * w
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_strips_add_up_to_the_exact_moment() {
        // N = rho/2 C_D b integral |r| r^2 w^2 dr over -L/2..L/2
        let (rho, c_d, length, breadth): (f64, f64, f64, f64) = (1000.0, 1.2, 0.7, 0.2);
        let n = 100_000;
        let dr = length / f64::from(n);
        let moment: f64 = (0..n)
            .map(|i| (f64::from(i) + 0.5) * dr - length / 2.0)
            .map(|r| 0.5 * rho * c_d * breadth * dr * r.abs().powi(3))
            .sum();
        let closed = super::plate_by_strips(rho, c_d, length * breadth, length);
        assert!((moment / closed - 1.0).abs() < 1e-6);
    }
}
