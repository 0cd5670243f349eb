//! Power for a drag, the jet behind screws, and the force of a deflected jet (Brunner 1988, pp. 8-9, 30, 59-62).
//!
//! A plane deflects the jet that meets it, of area `A` and speed `V`, by the angle `alpha` (eqs. 5 and 6):
//!
//! ```text
//! F_y = rho A V^2 sin(alpha)     F_x = rho A V^2 (1 - cos(alpha))
//! ```

use std::f64::consts::PI;

/// Power \[W\] against `drag` \[N\] at `speed` \[m/s\].
#[must_use]
pub fn against(drag: f64, speed: f64) -> f64 {
    drag * speed
}

/// Converts `power` at `speed` to the speed `other` by the cube law.
#[must_use]
pub fn by_cube_law(power: f64, speed: f64, other: f64) -> f64 {
    power * (other / speed).powi(3)
}

/// Area \[m^2\] swept by `count` screws of `diameter` \[m\].
#[must_use]
pub fn swept_area(count: u32, diameter: f64) -> f64 {
    f64::from(count) * PI * diameter * diameter / 4.0
}

/// Speed \[m/s\] of the jet after screws of `area` \[m^2\] that overcome `drag` \[N\] at `speed` \[m/s\]: `V_p^2 = V^2 + 2 D / (rho A)`, from `D =
/// rho Q (V_p - V)` with `Q = A (V + V_p) / 2`.
#[must_use]
pub fn jet_speed(rho: f64, speed: f64, drag: f64, area: f64) -> f64 {
    (speed * speed + 2.0 * drag / (rho * area)).sqrt()
}

/// `F_y` \[N\], the force across the stream.
#[must_use]
pub fn side_force(rho: f64, area: f64, speed: f64, angle: f64) -> f64 {
    rho * area * speed * speed * libm::sin(angle)
}

/// `F_x` \[N\], the force against the stream: induced drag.
#[must_use]
pub fn induced_drag(rho: f64, area: f64, speed: f64, angle: f64) -> f64 {
    rho * area * speed * speed * (1.0 - libm::cos(angle))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_jet_carries_off_the_momentum_of_the_drag() {
        let (rho, v, drag, area) = (1000.0, 0.3, 0.2, 5e-4);
        let vp = jet_speed(rho, v, drag, area);
        let flow = area * (v + vp) / 2.0;
        assert!((rho * flow * (vp - v) - drag).abs() < 1e-12);
    }

    #[test]
    fn a_stream_turned_right_back_loses_twice_its_momentum() {
        assert!((induced_drag(1000.0, 0.01, 2.0, PI) - 80.0).abs() < 1e-12);
        assert!(side_force(1000.0, 0.01, 2.0, PI).abs() < 1e-9);
    }
}
