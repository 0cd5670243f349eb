//! The two differential pressure cells, for depth and for speed.
//!
//! ```text
//! volts = limited(zero + S p + bias + noise n)      0 <= volts <= full scale
//! ```
//!
//! with the sensitivity `S` \[V/Pa\] of the calibration, which was made in inches of water.
//!
//! Source: Brunner 1988, ch. III.G (pp. 64-65) and IV.C (pp. 75-79).
//!
//! - **Depth.** On the bench it was set to 10 V at 39 in (Fig. 36). In the tank it read 1.627 V + 0.257 V/in (Fig. 38): the same slope,
//!   with the zero shifted by 6.33 in of water. This reduces the depth of saturation from 38.9 in to 32.58 in, in a tank of 48 in. The first port was
//!   at the bottom 17.5 in aft of the bow, where manoeuvres disturbed it; later there were two ports at the sides 14.5 in aft, near the middle.
//! - **Speed.** 12.453 V per inch of water (Fig. 35), 10 V at 0.8 in, which is 2.07 ft/s. The cell measures between the nose and the side ports 14.5
//!   in aft of the nose, through lines too thin to fill with water. So the cell also measures the water column between the ports, and 3.17 degrees
//!   bow down saturate it. The report finally used a stopwatch.
//!
//! The report gives the ranges as 0 to 100 cm and 0 to 2 cm of water, and elsewhere with a sign that may be a plus-minus; the output of
//! these cells does not go below 0 V.

use planesman_units::{FOOT, INCH, POUND_FORCE};
use planesman_vehicle::Port;

/// Full scale of both cells \[V\].
pub const FULL_SCALE: f64 = 10.0;

/// A pressure cell with its amplifier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureCell {
    /// Output of the calibration without pressure \[V\].
    pub zero: f64,
    /// Sensitivity \[V/Pa\].
    pub slope: f64,
    /// Largest output \[V\]; if it is infinite, there is no limit, and no lower limit of 0 either.
    pub saturation: f64,
    /// Zero error in addition to the calibration \[V\].
    pub bias: f64,
    /// Standard deviation of the white noise \[V\].
    pub noise: f64,
}

/// Specific weight of the water in the report's tank \[N/m^3\]: 1.94 slug/ft^3 at 32.2 ft/s^2.
pub const TANK_WATER: f64 = 999.835 * 9.81456;

/// Specific weight of the water in the manometer \[N/m^3\]: the report's 62.4 lbf/ft^3 (p. 79).
pub const MANOMETER_WATER: f64 = 62.4 * POUND_FORCE / (FOOT * FOOT * FOOT);

/// Depth cell as calibrated in the tank (Fig. 38), without errors or limits.
pub const DEPTH: PressureCell = PressureCell {
    zero: 1.627,
    slope: 0.257 / (INCH * TANK_WATER),
    saturation: f64::INFINITY,
    bias: 0.0,
    noise: 0.0,
};

/// Speed cell as calibrated on the bench (Fig. 35), without errors or limits.
pub const SPEED: PressureCell = PressureCell {
    zero: 0.0,
    slope: 12.453 / (INCH * MANOMETER_WATER),
    saturation: f64::INFINITY,
    bias: 0.0,
    noise: 0.0,
};

impl PressureCell {
    /// Output \[V\] at a differential pressure \[Pa\], with a normal random number.
    #[must_use]
    pub fn volts(&self, pressure: f64, normal: f64) -> f64 {
        let volts = self.zero + self.slope * pressure + self.bias + self.noise * normal;
        if self.saturation.is_finite() {
            volts.clamp(0.0, self.saturation)
        } else {
            volts
        }
    }

    /// Whether an output \[V\] is at a limit.
    #[must_use]
    pub fn saturated(&self, volts: f64) -> bool {
        self.saturation.is_finite() && (volts <= 0.0 || volts >= self.saturation)
    }

    /// Pressure \[Pa\] for an output \[V\], by the calibration.
    #[must_use]
    pub fn pressure(&self, volts: f64) -> f64 {
        (volts - self.zero) / self.slope
    }

    /// Standard deviation of the noise as a pressure \[Pa\].
    #[must_use]
    pub fn pressure_noise(&self) -> f64 {
        self.noise / self.slope
    }
}

/// Port of the depth cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, planesman_parameters::Choice)]
pub enum DepthPort {
    /// Port of the vehicle file: for the report's vehicle the two at the sides, 14.5 in aft.
    #[default]
    Vehicle,
    /// The report's first port: bottom centreline, 17.5 in aft of the bow.
    Bottom,
    /// Centre of gravity: no effect of pitch.
    Centre,
}

/// Overall length and height of the report's vehicle \[in\] (p. 70); the centre of gravity is assumed in the middle.
const HULL: (f64, f64) = (30.0, 3.5);
/// Position of the first depth port \[in aft of the bow\] (p. 64).
pub const BOTTOM_PORT: f64 = 17.5;
/// Position of the final ports \[in aft of the bow\] (p. 64).
pub const SIDE_PORTS: f64 = 14.5;

impl DepthPort {
    /// Position of the port; `vehicle` is the port of the vehicle file.
    #[must_use]
    pub fn place(self, vehicle: Port) -> Port {
        match self {
            Self::Vehicle => vehicle,
            Self::Bottom => Port {
                forward: (0.5 * HULL.0 - BOTTOM_PORT) * INCH,
                below: 0.5 * HULL.1 * INCH,
            },
            Self::Centre => Port {
                forward: 0.0,
                below: 0.0,
            },
        }
    }
}

/// Depth of a port \[m\], with the centre of gravity at `depth` and the vehicle at a pitch \[rad\].
#[must_use]
pub fn depth_of(port: &Port, depth: f64, pitch: f64) -> f64 {
    depth - port.forward * libm::sin(pitch) + port.below * libm::cos(pitch)
}

/// Pressure \[Pa\] of the water column along dry lines between the nose port and a port `spacing` \[m\] aft of the nose, at a pitch \[rad\] in water
/// of a specific weight \[N/m^3\]; with the bow down, the nose is deeper.
#[must_use]
pub fn dry_line_pressure(spacing: f64, pitch: f64, specific_weight: f64) -> f64 {
    -specific_weight * spacing * libm::sin(pitch)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inches_of_tank(depth: f64) -> f64 {
        depth * INCH * TANK_WATER
    }

    #[test]
    fn the_shifted_zero_saturates_the_depth_cell_at_two_thirds_of_the_tank() {
        let cell = PressureCell {
            saturation: FULL_SCALE,
            ..DEPTH
        };
        assert!((cell.volts(inches_of_tank(32.5), 0.0) - 9.9795).abs() < 1e-9);
        assert_eq!(cell.volts(inches_of_tank(32.6), 0.0), 10.0);
        assert!(cell.saturated(10.0) && !cell.saturated(9.9795));
        assert_eq!(cell.volts(-1e6, 0.0), 0.0);
    }

    #[test]
    fn a_foot_is_three_volts() {
        let volts = DEPTH.volts(inches_of_tank(12.0), 0.0);
        assert!((volts - 1.627 - 3.084).abs() < 1e-12);
        assert!((DEPTH.pressure(volts) - inches_of_tank(12.0)).abs() < 1e-9);
    }

    #[test]
    fn a_foot_a_second_is_a_quarter_of_the_speed_cell() {
        let pressure = 0.5 * 999.835 * FOOT * FOOT;
        assert!((SPEED.volts(pressure, 0.0) - 2.323).abs() < 1e-3);
        let fastest = (FULL_SCALE / SPEED.volts(pressure, 0.0)).sqrt();
        assert!((fastest - 2.07).abs() < 5e-3);
    }

    #[test]
    fn three_degrees_bow_down_saturate_the_speed_cell_at_rest() {
        let column = |degrees: f64| {
            dry_line_pressure(SIDE_PORTS * INCH, degrees.to_radians(), MANOMETER_WATER)
        };
        assert!(SPEED.volts(column(-3.17), 0.0) < FULL_SCALE);
        assert!(SPEED.volts(column(-3.18), 0.0) > FULL_SCALE);
        assert!(column(3.0) < 0.0);
    }

    #[test]
    fn noise_is_given_in_volts_and_known_in_pascals() {
        let cell = PressureCell {
            noise: 5e-3,
            ..DEPTH
        };
        let shift = cell.pressure(cell.volts(1000.0, 1.0)) - 1000.0;
        assert!((shift - cell.pressure_noise()).abs() < 1e-9);
        assert!((shift - 4.85).abs() < 5e-3);
    }
}
