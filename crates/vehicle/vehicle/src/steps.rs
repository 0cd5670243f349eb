//! How long the steps of an integration are, by the errors estimated of them.

/// A step \[s\] that is not divided further, whatever its error: so a flight ends, and a motion that blows up is found.
const SHORTEST: f64 = 1e-5;

/// The steps over a time: equal parts of what is left of it, each as long as the error of the last allows.
pub(crate) struct Steps {
    longest: f64,
    /// The largest error of a step that is accepted.
    tolerance: f64,
    /// How long the next may be \[s\].
    pub(crate) wanted: f64,
}

impl Steps {
    /// Of a longest step \[s\].
    pub(crate) fn new(longest: f64, tolerance: f64) -> Self {
        Self {
            longest,
            tolerance,
            wanted: longest,
        }
    }

    /// The length of the next step where so much is left \[s\], and whether it is the last.
    #[inline]
    pub(crate) fn next(&self, left: f64) -> (f64, bool) {
        let parts = (left / self.wanted - 1e-9).ceil().max(1.0);
        (left / parts, parts == 1.0)
    }

    /// Whether a step of length `h` \[s\] with that error is accepted; what follows is shorter or longer by it.
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
