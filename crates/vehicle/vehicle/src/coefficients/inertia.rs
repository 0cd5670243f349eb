//! Moments of inertia of a box: `J = m (a^2 + b^2) / 12` (Brunner 1988, p. 53).

/// Moment of inertia \[kg m^2\] about the axis through the centre normal to the sides `a` and `b` \[m\].
#[must_use]
pub fn box_inertia(mass: f64, a: f64, b: f64) -> f64 {
    mass * (a * a + b * b) / 12.0
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_thin_rod_has_a_twelfth_of_its_mass_times_its_length_squared() {
        assert_eq!(super::box_inertia(12.0, 2.0, 0.0), 4.0);
    }
}
