//! The gyro integrated, as the 1988 vehicle did, and depth differentiated.
//!
//! ```text
//! comparator:  theta' = q + q_0 if q + q_0 < 0, else 0     (Brunner 1988, p. 91)
//! dead band:   theta' = q       if |q| > q_0,   else 0
//! ```
//! The report offsets the gyro's zero so far (`q_0`) that its drift stays on one side of a single relay
//! comparator at 0 V: bow-up motion is not seen at all, bow-down motion is seen late. The two-sided
//! band loses slow motion either way.
//!
//! Depth rate is the depth behind a first-order lag, taken from the depth, over the lag: a derivative that does
//! not answer noise with more than `1 / T` of it.

use super::motion::{Estimate, Measurement};

/// The dead band between gyro and integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum DeadBand {
    /// The report's one comparator behind an offset `q_0`, rad/s.
    Comparator(f64),
    /// Both sides of zero, to `q_0`, rad/s.
    TwoSided(f64),
}

impl DeadBand {
    /// The rate that reaches the integrator, rad/s.
    #[must_use]
    pub(crate) fn passed(self, rate: f64) -> f64 {
        match self {
            Self::Comparator(offset) => (rate + offset).min(0.0),
            Self::TwoSided(band) if rate.abs() <= band => 0.0,
            Self::TwoSided(_) => rate,
        }
    }
}

/// Pitch by integration, from level at the first measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Integrator {
    dead_band: DeadBand,
    /// Of the lag in the depth's derivative, s.
    lag: f64,
    state: Option<State>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    pitch: f64,
    /// The rate behind the dead band at the last measurement, rad/s.
    rate: f64,
    /// The last depth, and the depth behind the lag, m.
    depth: f64,
    lagged: f64,
}

impl Integrator {
    /// Before the first measurement; `lag` in s.
    #[must_use]
    pub(crate) fn new(dead_band: DeadBand, lag: f64) -> Self {
        Self {
            dead_band,
            lag,
            state: None,
        }
    }

    /// Takes another dead band and lag (s) from the next measurement on.
    pub(crate) fn set(&mut self, dead_band: DeadBand, lag: f64) {
        (self.dead_band, self.lag) = (dead_band, lag);
    }

    /// The estimate at a measurement `dt` seconds after the one before.
    pub(crate) fn step(&mut self, measured: &Measurement, dt: f64) -> Estimate {
        let rate = self.dead_band.passed(measured.pitch_rate);
        let next = match self.state {
            None => {
                let depth = measured.depth.unwrap_or(0.0);
                State {
                    pitch: 0.0,
                    rate,
                    depth,
                    lagged: depth,
                }
            }
            Some(last) => State {
                pitch: last.pitch + 0.5 * (last.rate + rate) * dt,
                rate,
                depth: measured.depth.unwrap_or(last.depth),
                lagged: self.lagged(&last, measured.depth.unwrap_or(last.depth), dt),
            },
        };
        self.state = Some(next);
        Estimate {
            pitch: next.pitch,
            pitch_rate: rate,
            depth: next.depth,
            depth_rate: (next.depth - next.lagged) / self.lag,
            gyro_bias: 0.0,
        }
    }

    /// The output of `1 / (T s + 1)` after `dt` seconds in which the depth went to `depth` at a
    /// steady rate.
    fn lagged(&self, last: &State, depth: f64, dt: f64) -> f64 {
        let behind = if dt > 0.0 {
            self.lag * (depth - last.depth) / dt
        } else {
            0.0
        };
        depth - behind + (last.lagged - last.depth + behind) * (-dt / self.lag).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(dead_band: DeadBand, rate: impl Fn(f64) -> f64, depth: impl Fn(f64) -> f64) -> Estimate {
        let dt = 0.05;
        let mut integrator = Integrator::new(dead_band, 0.2);
        let mut end = Estimate::default();
        for k in 0..=200 {
            let t = f64::from(k) * dt;
            let measured = Measurement {
                pitch_rate: rate(t),
                depth: Some(depth(t)),
                speed: 0.3,
            };
            end = integrator.step(&measured, dt);
        }
        end
    }

    #[test]
    fn two_degrees_a_second_of_drift_are_twenty_degrees_in_ten_seconds() {
        let drift = 2_f64.to_radians();
        let end = run(DeadBand::TwoSided(0.0), |_| drift, |_| 0.0);
        assert!((end.pitch - 10.0 * drift).abs() < 1e-12);
        assert_eq!(
            run(DeadBand::TwoSided(drift), |_| drift, |_| 0.0).pitch,
            0.0
        );
    }

    #[test]
    fn the_comparator_does_not_see_the_bow_rise_and_loses_the_offset_of_its_fall() {
        let offset = 2_f64.to_radians();
        let comparator = DeadBand::Comparator(offset);
        assert_eq!(run(comparator, |_| 0.5, |_| 0.0).pitch, 0.0);
        let end = run(comparator, |_| -0.1, |_| 0.0);
        assert!((end.pitch + 10.0 * (0.1 - offset)).abs() < 1e-12);
        assert_eq!(run(comparator, |_| -0.5 * offset, |_| 0.0).pitch, 0.0);
    }

    #[test]
    fn a_steady_dive_has_its_depth_rate() {
        let end = run(DeadBand::TwoSided(0.0), |_| 0.0, |t| 1.0 + 0.1 * t);
        assert!((end.depth_rate - 0.1).abs() < 1e-9, "{}", end.depth_rate);
        assert_eq!(end.depth, 2.0);
    }
}
