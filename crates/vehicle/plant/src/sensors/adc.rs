//! The analog-to-digital converter.
//!
//! Brunner 1988 digitized four channels at 20 Hz (pp. 90, 97) but gives neither resolution nor range of the board. 12 bits over plus-minus
//! 10 V, common then, are assumed.

/// A converter with two's complement codes, the same for each channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Adc {
    /// Bits per sample; 0: neither rounding nor limits.
    pub bits: u32,
    /// Full scale to either side \[V\].
    pub range: f64,
}

/// No converter: voltages pass unchanged.
pub(crate) const NONE: Adc = Adc {
    bits: 0,
    range: f64::INFINITY,
};

impl Adc {
    /// Voltage step of one code \[V\].
    #[must_use]
    pub(crate) fn resolution(&self) -> f64 {
        if self.bits == 0 {
            0.0
        } else {
            2.0 * self.range / 2_f64.powi(self.bits as i32)
        }
    }

    /// The voltage of the sampled code \[V\].
    #[must_use]
    pub(crate) fn sampled(&self, volts: f64) -> f64 {
        if self.bits == 0 {
            return volts;
        }
        let resolution = self.resolution();
        let top = 2_f64.powi(self.bits as i32 - 1);
        (volts / resolution).round().clamp(-top, top - 1.0) * resolution
    }

    /// Lowest and highest sample \[V\].
    #[must_use]
    pub(crate) fn ends(&self) -> [f64; 2] {
        [-self.range, self.range - self.resolution()]
    }

    /// Whether a sample is at a limit of the range.
    #[must_use]
    pub(crate) fn saturated(&self, sample: f64) -> bool {
        self.bits != 0 && !(-self.range < sample && sample < self.range - self.resolution())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWELVE: Adc = Adc {
        bits: 12,
        range: 10.0,
    };

    #[test]
    fn twelve_bits_of_twenty_volts_are_five_millivolts() {
        assert!((TWELVE.resolution() - 4.882_812_5e-3).abs() < 1e-15);
        for volts in [-9.99, -0.3, 0.0, 0.0024, 1.627, 9.99] {
            let sample = TWELVE.sampled(volts);
            assert!((sample - volts).abs() <= 0.5 * TWELVE.resolution());
            assert_eq!(TWELVE.sampled(sample), sample);
            assert!(!TWELVE.saturated(sample));
        }
    }

    #[test]
    fn beyond_the_range_is_the_last_code() {
        assert_eq!(TWELVE.sampled(25.0), 10.0 - TWELVE.resolution());
        assert_eq!(TWELVE.sampled(-25.0), -10.0);
        assert!(TWELVE.saturated(TWELVE.sampled(10.0)));
        assert!(TWELVE.saturated(-10.0));
    }

    #[test]
    fn no_bits_change_nothing() {
        assert_eq!(NONE.sampled(123.456_789), 123.456_789);
        assert!(!NONE.saturated(1e9));
    }
}
