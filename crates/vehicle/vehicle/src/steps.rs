//! Step size control of an integration by estimated errors.

/// Shortest step \[s\]; it is accepted with any error, so that a flight ends and a diverging motion is detected.
const SHORTEST: f64 = 1e-5;

/// Steps over a time: equal parts of the remaining time, of a length that the last error allows.
pub(crate) struct Steps {
    longest: f64,
    /// Largest accepted error of a step.
    tolerance: f64,
    /// Largest allowed length of the next step \[s\].
    pub(crate) wanted: f64,
}

impl Steps {
    /// Creates a control with a longest step \[s\].
    pub(crate) fn new(longest: f64, tolerance: f64) -> Self {
        Self {
            longest,
            tolerance,
            wanted: longest,
        }
    }

    /// Length of the next step for a remaining time \[s\], and whether it is the last step.
    #[inline]
    pub(crate) fn next(&self, left: f64) -> (f64, bool) {
        let parts = (left / self.wanted - 1e-9).ceil().max(1.0);
        (left / parts, parts == 1.0)
    }

    /// Whether a step of length `h` \[s\] with this error is accepted; adapts the next length.
    #[inline]
    pub(crate) fn accept(&mut self, h: f64, error: f64) -> bool {
        // NaN is too much. Equal parts of what is left may be longer than the shortest step by rounding.
        let accepted = error <= self.tolerance || h <= SHORTEST * (1.0 + 1e-6);
        if !accepted || self.wanted < self.longest {
            let ratio = match error.is_finite() {
                true => (0.9 * libm::pow(self.tolerance / error, 0.125)).clamp(0.2, 5.0),
                false => 0.2,
            };
            self.wanted = self.longest.min(h * ratio).max(SHORTEST);
        }
        accepted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motion that blows up: however long is left, the steps come to its end.
    #[test]
    fn whatever_the_error_the_steps_come_to_the_end() {
        for duration in [0.05, 1e-3, 3.1e-5, 0.049_999_999_999_999_996] {
            for error in [f64::NAN, f64::INFINITY, 1.0] {
                let mut steps = Steps::new(duration, 1e-12);
                let (mut t, mut tried) = (0.0, 0);
                while t < duration {
                    let (h, is_last) = steps.next(duration - t);
                    tried += 1;
                    assert!(tried < 20_000, "{duration} {error}: stands at {t}");
                    if steps.accept(h, error) {
                        t = if is_last { duration } else { t + h };
                    }
                }
            }
        }
    }

    #[test]
    fn without_error_steps_become_the_longest_again() {
        let mut steps = Steps::new(0.1, 1e-12);
        assert!(!steps.accept(0.1, 1.0));
        assert!(steps.wanted < 0.1);
        for _ in 0..4 {
            let (h, _) = steps.next(10.0);
            assert!(steps.accept(h, 0.0));
        }
        assert_eq!(steps.wanted, 0.1);
    }
}
