//! First-order smoothing: the filter of a derivative, and the decay of the step that a change of mode would have caused.
//!
//! Both are exact for any time between two ticks:
//! ```text
//! y' = (x - y) / tau    ->    y(t + dt) = x + (y(t) - x) exp(-dt / tau)
//! ```

/// The remainder after `dt` seconds of a value that decays with the time constant `tau` (s); nothing
/// for a `tau` of 0.
#[must_use]
pub(crate) fn faded(value: f64, tau: f64, dt: f64) -> f64 {
    match tau > 0.0 {
        true => value * libm::exp(-dt / tau),
        false => 0.0,
    }
}

/// A first-order lag, which starts at its first input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Lag {
    output: Option<f64>,
}

impl Lag {
    /// The output `dt` seconds after the last one, for the input `input` and the time constant
    /// `tau` (s); with a `tau` of 0 the output is the input.
    pub(crate) fn after(&mut self, input: f64, tau: f64, dt: f64) -> f64 {
        let output = match self.output {
            Some(last) if tau > 0.0 => input + faded(last - input, tau, dt),
            _ => input,
        };
        self.output = Some(output);
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_reaches_63_percent_after_its_time_constant_however_it_is_sampled() {
        for steps in [1, 10, 1000] {
            let mut lag = Lag::default();
            lag.after(0.0, 2.0, 0.0);
            let dt = 2.0 / f64::from(steps);
            let last = (0..steps).map(|_| lag.after(1.0, 2.0, dt)).last();
            assert!((last.unwrap_or(0.0) - (1.0 - libm::exp(-1.0_f64))).abs() < 1e-12);
        }
    }

    #[test]
    fn without_a_time_constant_nothing_lags_or_lasts() {
        let mut lag = Lag::default();
        assert_eq!(lag.after(3.0, 0.0, 0.1), 3.0);
        assert_eq!(lag.after(-1.0, 0.0, 0.1), -1.0);
        assert_eq!(faded(5.0, 0.0, 0.1), 0.0);
    }
}
