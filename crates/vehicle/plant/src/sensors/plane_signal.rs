//! The plane command signals of the radio control box, scaled for recording.
//!
//! ```text
//! volts = zero + slope * angle - compensation
//! ```
//!
//! Source: Brunner 1988, ch. IV.G (pp. 84-87): 2.44 V + 0.010 V per degree of dive plane, 2.483 V + 0.004 V per degree of roll plane, about
//! a transmitter reference of roughly 2.5 V. A pot subtracts the zero in a summer so that neutral dive planes read 0.0 V (Fig. 43).
//!
//! The report contradicts itself on the setting of that pot. Figs. 42 and 43 require 2.44 V; p. 89 states 2.19 V, which would leave 0.25 V, or 25
//! degrees, at neutral planes. The same potentiometer fed the roll summing amplifier. The figures leave 0.061 V of 2.483 V there, so it subtracted
//! 2.422 V: only p. 89 supports 2.19 V. 2.44 V is the default; 2.19 V can be set.

/// Calibration of a command signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneSignal {
    /// Voltage at neutral planes \[V\].
    pub zero: f64,
    /// Slope \[V/deg\], dive positive.
    pub slope: f64,
    /// Offset that the pot subtracts \[V\].
    pub compensation: f64,
    /// Standard deviation of the white noise \[V\].
    pub noise: f64,
}

/// Voltage of the pot according to p. 89.
pub const PRINTED_COMPENSATION: f64 = 2.19;

/// Largest dive plane angle \[deg\] (p. 8).
pub const LARGEST_ANGLE: f64 = 30.0;

/// The dive planes (Figs. 42, 43).
pub const DIVE: PlaneSignal = PlaneSignal {
    zero: 2.44,
    slope: 0.010,
    compensation: 2.44,
    noise: 0.0,
};

/// The roll planes (Figs. 40, 41). The roll signal is not a `daq` channel: it was recorded only on the strip chart. The converter's four channels (p.
/// 90) are pitch rate, depth, dive planes and speed.
pub const ROLL: PlaneSignal = PlaneSignal {
    zero: 2.483,
    slope: 0.004,
    compensation: 2.422,
    noise: 0.0,
};

impl PlaneSignal {
    /// The signal \[V\] at a plane angle \[rad\], with a normal random number.
    #[must_use]
    pub fn volts(&self, angle: f64, normal: f64) -> f64 {
        self.zero + self.slope * angle.to_degrees() - self.compensation + self.noise * normal
    }

    /// \[V/rad\]
    #[must_use]
    pub fn slope_si(&self) -> f64 {
        self.slope * 1_f64.to_degrees()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_dive_is_three_tenths_of_a_volt() {
        assert_eq!(DIVE.volts(0.0, 0.0), 0.0);
        let full = DIVE.volts(LARGEST_ANGLE.to_radians(), 0.0);
        assert!((full - 0.3).abs() < 1e-12);
    }

    #[test]
    fn the_other_printed_compensation_leaves_a_quarter_volt() {
        let p89 = PlaneSignal {
            compensation: PRINTED_COMPENSATION,
            ..DIVE
        };
        assert!((p89.volts(0.0, 0.0) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn neutral_roll_planes_leave_what_figure_41_shows() {
        assert!((ROLL.volts(0.0, 0.0) - 0.061).abs() < 1e-12);
        let ten = ROLL.volts(10_f64.to_radians(), 0.0);
        assert!((ten - 0.101).abs() < 1e-12);
    }
}
