//! An input between two instants.

/// The input over one sampling interval.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Input {
    /// `u = (1/T) integral of u(t) dt`, the mean, in the input's unit.
    pub mean: f64,
    /// `m = (1/T^2) integral of (t - T/2) u(t) dt`, the first moment about the interval's middle divided by the interval, in the input's
    /// unit; 0 for a constant input.
    pub moment: f64,
}

impl Input {
    /// An input held at `value` over the interval.
    #[must_use]
    pub fn held(value: f64) -> Self {
        Self {
            mean: value,
            moment: 0.0,
        }
    }

    /// An input from evenly spaced samples, linear in between; the first is at the interval's beginning, the last at its end. The mean follows the
    /// trapezoid rule; the moment is exact. A single sample is held. `None` without samples.
    #[must_use]
    pub fn through(samples: &[f64]) -> Option<Self> {
        match samples {
            [] => None,
            [value] => Some(Self::held(*value)),
            _ => {
                let h = 1.0 / (samples.len() - 1) as f64;
                let mut input = Self::default();
                for (i, pair) in samples.windows(2).enumerate() {
                    let middle = (i as f64 + 0.5) * h - 0.5;
                    let mean = 0.5 * (pair[0] + pair[1]);
                    input.mean += h * mean;
                    input.moment += h * (middle * mean + h * (pair[1] - pair[0]) / 12.0);
                }
                Some(input)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_moment_of_a_held_a_rising_and_a_stepping_input() {
        assert_eq!(Input::through(&[0.3]), Some(Input::held(0.3)));
        let held = Input::through(&[0.3; 11]).unwrap();
        assert!((held.mean - 0.3).abs() < 1e-15 && held.moment.abs() < 1e-15);
        // u = t/T: mean 1/2, moment 1/3 - 1/4.
        for samples in [2, 3, 11] {
            let ramp: Vec<f64> = (0..samples)
                .map(|i| f64::from(i) / f64::from(samples - 1))
                .collect();
            let ramp = Input::through(&ramp).unwrap();
            assert!((ramp.mean - 0.5).abs() < 1e-15);
            assert!((ramp.moment - 1.0 / 12.0).abs() < 1e-15);
        }
        // 0 in the first half, 1 in the second: mean 1/2, moment 3/8 - 1/4.
        let step: Vec<f64> = (0..=1000).map(|i| f64::from(u8::from(i > 500))).collect();
        let step = Input::through(&step).unwrap();
        assert!((step.mean - 0.5).abs() < 1e-3 && (step.moment - 0.125).abs() < 1e-3);
        assert_eq!(Input::through(&[]), None);
    }
}
