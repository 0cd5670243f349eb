//! The rate gyros: model-aircraft gyros read out in volts.
//!
//! ```text
//! volts = offset + S (1 + 5.6 e) rate + bias + drift + noise n
//! ```
//!
//! with the calibration's offset \[V\] and sensitivity `S` \[V s/rad\], both different for each direction of turning. `e` is the relative
//! error of the reference voltage, `bias` and `drift` \[V\] are the zero's, and `n` is normal with mean 0 and variance 1.
//!
//! Source: Brunner 1988, ch. IV.B (pp. 70-75) and p. 90. The report gives two calibrations. The preliminary calibration was made on a
//! milling machine's handwheel, with an amplifier (the mixer) that was removed later. The calibration is printed for both directions and two
//! reference voltages (Figs. 29-34). The final calibration, from the strip chart of the swing test, gives only pitch and roll (p. 75). The final
//! calibration has no yaw; it uses the mean of the preliminary calibration's two directions.
//!
//! The zero drifts "in a range of about 25 millivolts" (p. 90) and is "relatively constant" over one run (ch. V). Here it is a random walk
//! reflected at the limits of the range,
//!
//! ```text
//! drift' = reflected(drift + r sqrt(dt) n)      |drift| <= range
//! ```
//!
//! whose rate `r`, not given in the report, defaults to 1 mV per root second: 5 mV over a run, the whole range in ten minutes. White noise
//! is not given either; 5 mV is assumed.

use std::f64::consts::PI;

/// Straight line for one direction, as in the figures: millivolts over RPM.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// \[mV\]
    pub offset: f64,
    /// \[mV/RPM\]
    pub slope: f64,
}

impl Line {
    /// A line through the origin with a slope in mV per deg/s.
    const fn through_zero(millivolts: f64) -> Self {
        Self {
            offset: 0.0,
            slope: millivolts * DEGREES_PER_SECOND_IN_RPM,
        }
    }

    /// Sensitivity \[mV per deg/s\].
    #[must_use]
    pub fn sensitivity(&self) -> f64 {
        self.slope / DEGREES_PER_SECOND_IN_RPM
    }
}

/// 1 rpm in deg/s.
const DEGREES_PER_SECOND_IN_RPM: f64 = 6.0;

/// Conversion from mV per deg/s to V per rad/s.
pub const SI_PER_MILLIVOLT_PER_DEGREE: f64 = 1e-3 * 180.0 / PI;

/// Output of a gyro as a function of direction and rate of turning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Clockwise, assumed to be the positive rate about the body's axis; the report does not say.
    pub clockwise: Line,
    /// Counterclockwise, magnitudes.
    pub counterclockwise: Line,
}

impl Calibration {
    const fn both(line: Line) -> Self {
        Self {
            clockwise: line,
            counterclockwise: line,
        }
    }

    /// Calibration with the mean sensitivity of both directions and no offset: the calibration used to read the voltages, and that of a gyro with
    /// equal directions.
    #[must_use]
    pub const fn equal_sides(&self) -> Self {
        Self::both(Line {
            offset: 0.0,
            slope: 0.5 * (self.clockwise.slope + self.counterclockwise.slope),
        })
    }

    const fn measured(cw: (f64, f64), ccw: (f64, f64)) -> Self {
        Self {
            clockwise: Line {
                offset: cw.0,
                slope: cw.1,
            },
            counterclockwise: Line {
                offset: ccw.0,
                slope: ccw.1,
            },
        }
    }

    /// Mean sensitivity of both directions \[V s/rad\], which a reader of the voltages uses.
    #[must_use]
    pub fn sensitivity(&self) -> f64 {
        self.equal_sides().clockwise.sensitivity() * SI_PER_MILLIVOLT_PER_DEGREE
    }

    /// Output \[V\] at a rate \[rad/s\], with the sensitivity multiplied by `scale`.
    ///
    /// The lines' offsets are intercepts of fits to a turning gyro; at rest the offset is 0.
    #[must_use]
    pub fn volts(&self, rate: f64, scale: f64) -> f64 {
        let line = if rate > 0.0 {
            self.clockwise
        } else if rate < 0.0 {
            self.counterclockwise
        } else {
            return 0.0;
        };
        let rpm = rate.abs() * 30.0 / PI;
        1e-3 * (line.offset + scale * line.slope * rpm).copysign(rate)
    }
}

/// Calibrations of the roll, pitch and yaw gyro.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibrations {
    /// About the body's x axis.
    pub roll: Calibration,
    /// About the body's y axis.
    pub pitch: Calibration,
    /// About the body's z axis.
    pub yaw: Calibration,
}

impl Calibrations {
    /// All three with equal directions.
    #[must_use]
    pub const fn equal_sides(&self) -> Self {
        Self {
            roll: self.roll.equal_sides(),
            pitch: self.pitch.equal_sides(),
            yaw: self.yaw.equal_sides(),
        }
    }
}

/// The reference voltage of Figs. 29-31 \[V\].
pub const REFERENCE: f64 = 4.8;
/// The reference voltage of Figs. 32-34 \[V\].
pub const LOW_REFERENCE: f64 = 4.35;

/// With the mixer, at 4.8 V (Figs. 29-31).
pub const PRELIMINARY: Calibrations = Calibrations {
    pitch: Calibration::measured((-0.224, 53.783), (5.143, 52.693)),
    yaw: Calibration::measured((13.320, 39.665), (11.545, 44.404)),
    roll: Calibration::measured((3.509, 50.508), (3.506, 44.165)),
};

/// With the mixer, at about 4.35 V (Figs. 32-34).
pub const PRELIMINARY_LOW: Calibrations = Calibrations {
    pitch: Calibration::measured((8.886, 32.560), (5.907, 34.793)),
    yaw: Calibration::measured((16.715, 30.520), (4.035, 37.523)),
    roll: Calibration::measured((-7.102, 41.954), (5.456, 35.757)),
};

/// From the swing test, as used finally: 12.5 mV per deg/s in pitch and 18.6 in roll (p. 75). Yaw was not calibrated again: its sensitivity is the
/// mean of both directions in the preliminary calibration. A swing to both sides with the mixer still present would have given this mean.
pub const SWING: Calibrations = Calibrations {
    pitch: Calibration::both(Line::through_zero(12.5)),
    roll: Calibration::both(Line::through_zero(18.6)),
    yaw: PRELIMINARY.yaw.equal_sides(),
};

/// Relative change of the pitch gyro's sensitivity per relative change of the reference voltage: 5.6, from the mean slopes of the two
/// preliminary calibrations.
#[must_use]
pub fn reference_sensitivity() -> f64 {
    let high = PRELIMINARY.pitch.sensitivity();
    let low = PRELIMINARY_LOW.pitch.sensitivity();
    (high / low - 1.0) / (REFERENCE / LOW_REFERENCE - 1.0)
}

/// Drift of a gyro's zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drift {
    /// Limit to either side \[V\]; 0: no drift.
    pub range: f64,
    /// Standard deviation after 1 s \[V\]; it grows with the square root of time.
    pub rate: f64,
}

impl Drift {
    /// The drift \[V\] after another `dt` \[s\], from a normal random number.
    #[must_use]
    pub fn step(&self, drift: f64, dt: f64, normal: f64) -> f64 {
        reflected(drift + self.rate * dt.sqrt() * normal, self.range)
    }
}

/// Reflects a number into `[-range, range]`, as if mirrors stood at both ends.
fn reflected(x: f64, range: f64) -> f64 {
    if range <= 0.0 {
        return 0.0;
    }
    let from_end = (x + range).rem_euclid(4.0 * range);
    from_end.min(4.0 * range - from_end) - range
}

/// Errors of a gyro.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Relative error of the reference voltage.
    pub reference: f64,
    /// Constant zero \[V\].
    pub bias: f64,
    /// Drift of the zero.
    pub drift: Drift,
    /// Standard deviation of the white noise \[V\].
    pub noise: f64,
}

impl Errors {
    /// Output of a gyro \[V\] at a rate \[rad/s\], with its drift \[V\] and a normal random number.
    #[must_use]
    pub fn volts(&self, calibration: &Calibration, rate: f64, drift: f64, normal: f64) -> f64 {
        let scale = 1.0 + reference_sensitivity() * self.reference;
        calibration.volts(rate, scale) + self.bias + drift + self.noise * normal
    }
}

#[cfg(test)]
mod tests {
    use super::super::noise::{Source, Stream};
    use super::*;

    const RATE: f64 = 0.1;

    #[test]
    fn ten_degrees_a_second_bow_up_are_an_eighth_of_a_volt() {
        let volts = SWING.pitch.volts(10_f64.to_radians(), 1.0);
        assert!((volts - 0.125).abs() < 1e-12);
        assert_eq!(SWING.pitch.volts(0.0, 1.0), 0.0);
        assert!((SWING.roll.volts(-RATE, 1.0) + 1.0657015 * RATE).abs() < 1e-7);
    }

    #[test]
    fn the_preliminary_gyros_read_differently_each_way() {
        // Fig. 31 at 3 RPM: 3.509 + 50.508 x 3 = 155.033 mV, 3.506 + 44.165 x 3 = 136.001 mV.
        let rate = 3.0 * PI / 30.0;
        assert!((PRELIMINARY.roll.volts(rate, 1.0) - 0.155_033).abs() < 1e-12);
        assert!((PRELIMINARY.roll.volts(-rate, 1.0) + 0.136_001).abs() < 1e-12);
    }

    #[test]
    fn the_final_gyros_read_the_same_each_way_through_the_sensitivity_that_the_reader_knows() {
        for calibration in [SWING.roll, SWING.pitch, SWING.yaw] {
            for rate in [-2.0, -RATE, 0.0, 1e-4, RATE] {
                let read = calibration.volts(rate, 1.0) / calibration.sensitivity();
                assert!((read - rate).abs() < 1e-15, "{read} is not {rate}");
            }
        }
        // Figs. 30: 39.665 and 44.404 mV/RPM.
        let yaw = SWING.yaw.clockwise.sensitivity();
        assert!((yaw - 0.5 * (39.665 + 44.404) / 6.0).abs() < 1e-12);
        let preliminary = &PRELIMINARY.yaw;
        let slow = preliminary.volts(0.05, 1.0) / preliminary.sensitivity() / 0.05;
        assert!(
            slow > 1.5,
            "its offset of 13 mV alone is half of it: {slow}"
        );
    }

    #[test]
    fn a_percent_of_reference_is_five_and_a_half_percent_of_rate() {
        let weak = Errors {
            reference: -0.01,
            ..Errors::default()
        };
        let nominal = SWING.pitch.volts(RATE, 1.0);
        let read = weak.volts(&SWING.pitch, RATE, 0.0, 0.0);
        assert!((read / nominal - (1.0 - 0.056_15)).abs() < 1e-5);
    }

    #[test]
    fn the_zero_wanders_to_the_ends_of_its_range_and_never_past_them() {
        let drift = Drift {
            range: 0.025,
            rate: 1e-3,
        };
        let mut normals = Stream::new(1, Source::GyroDrift(1));
        let mut zero = 0.0;
        let mut extent = [0.0_f64; 2];
        let mut after_a_run = 0.0;
        for k in 0..100_000 {
            zero = drift.step(zero, 0.05, normals.draw());
            extent = [extent[0].min(zero), extent[1].max(zero)];
            if k == 400 {
                after_a_run = zero;
            }
        }
        assert!(extent[0] >= -0.025 && extent[1] <= 0.025);
        assert!(extent[0] < -0.024 && extent[1] > 0.024);
        assert!(after_a_run.abs() < 0.015 && after_a_run != 0.0);
    }

    #[test]
    fn a_step_of_many_ranges_still_ends_within() {
        for x in [-1e9, -0.76, -0.75, 0.1, 0.26, 3.0, 1e9] {
            assert!(reflected(x, 0.25).abs() <= 0.25);
        }
        assert!((reflected(0.26, 0.25) - 0.24).abs() < 1e-15);
        assert_eq!(reflected(1.0, 0.0), 0.0);
    }
}
