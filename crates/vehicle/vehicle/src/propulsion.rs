//! Thrust, drag and power: the speed of the vehicle.
//!
//! ```text
//! (m + m_x) U' = n T_full - D(U)              D = rho A C_D U^2 / 2
//! C_D = C_fb + C_db       C_fb = C_f S_fb / A        C_db = 0.029 / sqrt(C_fb)
//! C_f = 0.043 / Re^(1/6)                      Re = U l / nu
//! ```
//!
//! Source: Brunner 1988, II.E, Tables 5 and 6 (p. 58), turbulent, in fresh water, but without the table's rounding of intermediate columns.
//! `n` in \[-1, 1\] is the share of full thrust. Full thrust equals the drag at the design speed of the vehicle (5 ft/s, p. 57). The
//! thesis' motor curves are lost, so the motors are assumed to respond at once. Additional drag due to turning and pitching is omitted, as
//! in the report.
//!
//! The other coefficients apply to a vehicle under way, so it does not go astern: reverse thrust brakes it until it stops.

use planesman_units::{FOOT, SLUG};
use serde::Deserialize;

use crate::positive;

/// `rho` \[kg/m^3\] of the report's fresh water, 1.94 slug/ft^3.
pub(crate) const DENSITY: f64 = 1.94 * SLUG / (FOOT * FOOT * FOOT);

/// `nu` \[m^2/s\]: 1.25e-5 ft^2/s, with which Table 6 has Re = 1.4e5 at 1 ft/s over 21 in.
pub(crate) const KINEMATIC_VISCOSITY: f64 = 1.25e-5 * FOOT * FOOT;

/// Thrust and drag of the vehicle, in SI units.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Propulsion {
    /// `A` \[m^2\], the cross section.
    #[serde(with = "positive::area")]
    pub frontal_area: f64,
    /// `S_fb` \[m^2\], the wetted surface of the forebody.
    #[serde(with = "positive::area")]
    pub wetted_area: f64,
    /// `l` \[m\], length of the plate in the Reynolds number.
    #[serde(with = "positive::length")]
    pub plate_length: f64,
    /// `m_x` \[kg\], added mass of the water.
    #[serde(with = "positive::mass")]
    pub added_mass: f64,
    /// Speed at full thrust \[m/s\].
    #[serde(with = "positive::speed")]
    pub design_speed: f64,
}

impl Propulsion {
    /// `C_f` at a positive speed \[m/s\].
    #[must_use]
    pub fn friction_coefficient(&self, speed: f64) -> f64 {
        let reynolds = speed * self.plate_length / KINEMATIC_VISCOSITY;
        0.043 / libm::pow(reynolds, 1.0 / 6.0)
    }

    /// `C_fb` and `C_db` at a positive speed \[m/s\].
    #[must_use]
    pub fn drag_coefficients(&self, speed: f64) -> (f64, f64) {
        let forebody = self.friction_coefficient(speed) * self.wetted_area / self.frontal_area;
        (forebody, 0.029 / forebody.sqrt())
    }

    /// `D` \[N\] at a speed \[m/s\]; 0 at rest.
    #[must_use]
    pub fn drag(&self, speed: f64) -> f64 {
        if speed <= 0.0 {
            return 0.0;
        }
        let (forebody, base) = self.drag_coefficients(speed);
        0.5 * DENSITY * self.frontal_area * (forebody + base) * speed * speed
    }

    /// Power lost to drag \[W\] at a speed \[m/s\].
    #[must_use]
    pub fn power(&self, speed: f64) -> f64 {
        self.drag(speed) * speed
    }

    /// `T_full` \[N\].
    #[must_use]
    pub fn full_thrust(&self) -> f64 {
        self.drag(self.design_speed)
    }

    /// `U'` \[m/s^2\] at a speed \[m/s\] with a thrust \[N\], for a vehicle of `mass` \[kg\] with additional drag `k` U^2 \[N\]. At rest a
    /// reverse thrust has no effect.
    #[must_use]
    pub fn acceleration(&self, speed: f64, thrust: f64, mass: f64, k: f64) -> f64 {
        let force = thrust - self.drag(speed) - k * speed * speed.abs();
        if speed <= 0.0 && force < 0.0 {
            return 0.0;
        }
        force / (mass + self.added_mass)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle_file::brunner;

    fn propulsion() -> Propulsion {
        brunner().propulsion.expect("the report's")
    }

    #[test]
    fn the_coefficients_round_to_those_of_table_6() {
        let p = propulsion();
        for (feet, friction) in [(1.0, 0.006), (2.0, 0.005), (3.0, 0.005), (5.0, 0.005)] {
            assert!((p.friction_coefficient(feet * FOOT) - friction).abs() < 5e-4);
        }
        let (forebody, base) = p.drag_coefficients(FOOT);
        assert!((forebody - 0.11).abs() < 6e-3 && (base - 0.09).abs() < 5e-3);
        let (forebody, base) = p.drag_coefficients(5.0 * FOOT);
        assert!((forebody - 0.09).abs() < 5e-3 && (base - 0.10).abs() < 7e-3);
    }

    #[test]
    fn at_five_feet_per_second_the_drag_takes_some_five_watts() {
        // Forebody and base, without the stern's share in the thesis' 6.5 W; with C_D = 0.2
        // in their place the thesis prints 5.8 W and 5.59 W come out.
        let watts = propulsion().power(5.0 * FOOT);
        assert!((4.8..5.6).contains(&watts), "{watts}");
    }
}
