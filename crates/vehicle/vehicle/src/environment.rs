//! Water and gravity.
//!
//! The density affects the pressures only. The hydrodynamic coefficients keep their own density (fresh water), and the vehicle is trimmed
//! neutral in any water. Sea water's difference of 2.5 % is less than the coefficients' uncertainty.
//! For the extent of the water and its waves see `depth_limits` and `seaway`.

/// Water and gravity, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// `rho` \[kg/m^3\].
    pub density: f64,
    /// `g` \[m/s^2\].
    pub gravity: f64,
    /// Absolute pressure at the surface \[Pa\].
    pub atmospheric_pressure: f64,
}

/// Depth of the surface \[m\].
pub const SURFACE: f64 = 0.0;

impl Environment {
    /// Absolute pressure \[Pa\] at a depth \[m\]; above the surface the atmospheric pressure.
    #[must_use]
    pub fn pressure(&self, depth: f64) -> f64 {
        self.atmospheric_pressure + self.density * self.gravity * (depth - SURFACE).max(0.0)
    }

    /// Dynamic pressure `rho V^2 / 2` \[Pa\] at the speed `V` \[m/s\].
    #[must_use]
    pub fn dynamic_pressure(&self, speed: f64) -> f64 {
        0.5 * self.density * speed * speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_units::{FOOT, INCH};

    /// 1.94 slug/ft^3 and 32.2 ft/s^2, the report's.
    const FRESH: Environment = Environment {
        density: 999.835,
        gravity: 9.81456,
        atmospheric_pressure: 101_325.0,
    };

    #[test]
    fn a_foot_per_second_is_a_fifth_of_an_inch_of_water() {
        // The report's speed cell: 0.1865 inch of water at 1 ft/s.
        let head = FRESH.dynamic_pressure(FOOT) / (FRESH.density * FRESH.gravity);
        assert!((head / INCH - 0.1865).abs() < 2e-4);
    }

    #[test]
    fn ten_metres_of_water_are_an_atmosphere() {
        let gauge = FRESH.pressure(10.0) - FRESH.pressure(0.0);
        assert!((gauge / 101_325.0 - 1.0).abs() < 0.04);
        assert_eq!(FRESH.pressure(-1.0), 101_325.0);
    }
}
