//! Size of the dive planes: the report's momentum estimates.
//!
//! Source: Brunner 1988, ch. III.E (pp. 59-61). The aft planes deflect the propellers' jet, the forward planes deflect the free stream. Together they
//! must produce the moment needed for a depth change:
//!
//! ```text
//! 0.63 F1 + 1.36 F2 = M = J_y Z (2 pi)^2 / (U T^3)      (4)
//! F2 = rho A Vp^2 sin(alpha)       (5)
//! F1 = rho A Vf^2 sin(theta/2)     (p. 61)
//! ```
//!
//! Units are the report's: feet, pounds-force, seconds. For 30 degrees the report gets 0.048 lbf from (5), which gives 0.0431. The program computes
//! the forward area for 15 degrees with half of 30 degrees: 18.4 in^2 instead of 36.4.

/// Water density `rho` \[slug/ft^3\].
pub const DENSITY: f64 = 1.94;
/// Moment arms of the forward and the aft planes \[ft\].
pub const ARMS: [f64; 2] = [0.63, 1.36];
/// Jet speed `Vp` after the propellers at 1 ft/s \[ft/s\].
pub const JET_SPEED: f64 = 3.23;
/// Cross-section of the deflected jet \[in^2\]: half of two one-inch discs.
pub const TURNED_AREA: f64 = std::f64::consts::FRAC_PI_4;
/// Moment required for 1.5 ft of depth within 8 ft at 1 ft/s \[ft lbf\], as printed.
pub const REQUIRED_MOMENT: f64 = 0.07;

const SQUARE_INCHES: f64 = 144.0;

/// Effective angle \[rad\] by which a plane at `angle` \[rad\] deflects the jet: the angle of the vector sum of jet and free stream, both in ft/s.
#[must_use]
pub fn effective_angle(angle: f64, jet: f64, stream: f64) -> f64 {
    libm::atan2(jet * libm::sin(angle), stream + jet * libm::cos(angle))
}

/// Force `F2` of the aft planes \[lbf\], eq. (5), for an effective angle \[rad\].
#[must_use]
pub fn aft_force(alpha: f64) -> f64 {
    DENSITY * TURNED_AREA / SQUARE_INCHES * JET_SPEED * JET_SPEED * libm::sin(alpha)
}

/// Moment \[ft lbf\] of eq. (4) for an inertia \[ft lbf s^2\] and a depth change \[ft\] within a period \[s\] at a speed \[ft/s\].
#[must_use]
pub fn required_moment(inertia: f64, depth: f64, speed: f64, period: f64) -> f64 {
    inertia * depth * std::f64::consts::TAU.powi(2) / (speed * period.powi(3))
}

/// Force `F1` of the forward planes \[lbf\] required by eq. (4), given the aft force \[lbf\].
#[must_use]
pub fn forward_force(aft_force: f64) -> f64 {
    (REQUIRED_MOMENT - ARMS[1] * aft_force) / ARMS[0]
}

/// Area of the forward planes \[in^2\] for a force \[lbf\] at a plane angle \[rad\] in a stream of 1 ft/s.
#[must_use]
pub fn forward_area(force: f64, angle: f64) -> f64 {
    force / (DENSITY * libm::sin(0.5 * angle)) * SQUARE_INCHES
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_required_moment_is_the_printed_one() {
        assert!((required_moment(0.6, 1.5, 1.0, 8.0) - REQUIRED_MOMENT).abs() < 1e-3);
    }

    #[test]
    fn the_effective_angles_are_the_printed_ones() {
        for (angle, printed) in [(15_f64, 11.5), (30.0, 23.0)] {
            let found = effective_angle(angle.to_radians(), JET_SPEED, 1.0).to_degrees();
            assert!((found - printed).abs() < 0.1, "{found}");
        }
    }

    #[test]
    fn the_printed_area_for_fifteen_degrees_is_that_for_thirty() {
        let force = 0.064;
        let fifteen = forward_area(force, 15_f64.to_radians());
        let thirty = forward_area(force, 30_f64.to_radians());
        assert!((fifteen - 36.4).abs() < 0.05 && (thirty - 18.4).abs() < 0.1);
    }
}
