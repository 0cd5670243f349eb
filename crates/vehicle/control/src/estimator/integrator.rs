//! Integrates the gyro, the same as in the 1988 vehicle, and differentiates the depth.
//!
//! ```text
//! comparator:  theta' = q + q_0 if q + q_0 < 0, else 0     (Brunner 1988, p. 91)
//! dead band:   theta' = q       if |q| > q_0,   else 0
//! ```
//! The report offsets the gyro's zero (`q_0`) so far that its drift stays on one side of a single relay comparator at 0 V: bow-up motion is
//! not detected at all, bow-down motion late. The two-sided band loses slow motion in both directions.
//!
//! The depth rate is (depth - filtered depth) / T, with a first-order lag T: a derivative that amplifies noise by at most `1 / T`.

use super::motion::{Estimate, Measurement};

/// The dead band before the integrator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum DeadBand {
    /// The report's relay comparator.
    Comparator,
    /// A band on both sides.
    TwoSided,
}

/// The dead band and the lag of the depth's derivative: the parameters `integrator.*`.
#[derive(Clone, Copy, Debug, PartialEq, planesman_parameters::Parameters)]
pub struct IntegratorRules {
    /// Dead band before the integrator: the report's relay comparator, which passes only bow-down rates, or a
    /// two-sided band.
    #[parameter(default = DeadBand::Comparator)]
    pub dead_band: DeadBand,
    /// Offset of the comparator, or half width of the band; 25 mV, the drift of the gyro's zero (Brunner 1988, p.
    /// 90).
    #[parameter(default = 2.0_f64.to_radians(), unit = "rad/s", range = 0.0..=10.0)]
    pub width: f64,
    /// Time constant of the depth derivative used with the integrator.
    #[parameter(default = 0.5, unit = "s", range = 1e-3..=100.0)]
    pub depth_lag: f64,
}

impl IntegratorRules {
    /// The rate that reaches the integrator, rad/s.
    #[must_use]
    pub(crate) fn passed(&self, rate: f64) -> f64 {
        match self.dead_band {
            DeadBand::Comparator => (rate + self.width).min(0.0),
            DeadBand::TwoSided if rate.abs() <= self.width => 0.0,
            DeadBand::TwoSided => rate,
        }
    }
}

/// Pitch by integration; the vehicle is assumed to be level at the first measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Integrator {
    rules: IntegratorRules,
    state: Option<State>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    pitch: f64,
    /// The rate after the dead band at the last measurement, rad/s.
    rate: f64,
    /// The last depth, and the filtered depth, m.
    depth: f64,
    lagged: f64,
}

impl Integrator {
    /// An integrator before the first measurement.
    #[must_use]
    pub(crate) fn new(rules: IntegratorRules) -> Self {
        Self { rules, state: None }
    }

    /// Uses other rules from the next measurement on.
    pub(crate) fn set_rules(&mut self, rules: IntegratorRules) {
        self.rules = rules;
    }

    /// The estimate at a measurement `dt` seconds after the last.
    pub(crate) fn step(&mut self, measured: &Measurement, dt: f64) -> Estimate {
        let rate = self.rules.passed(measured.pitch_rate);
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
            depth_rate: (next.depth - next.lagged) / self.rules.depth_lag,
            gyro_bias: 0.0,
        }
    }

    /// The output of `1 / (T s + 1)` after `dt` seconds in which the depth changed linearly to `depth`.
    fn lagged(&self, last: &State, depth: f64, dt: f64) -> f64 {
        let lag = self.rules.depth_lag;
        let behind = if dt > 0.0 {
            lag * (depth - last.depth) / dt
        } else {
            0.0
        };
        depth - behind + (last.lagged - last.depth + behind) * libm::exp(-dt / lag)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(
        (dead_band, width): (DeadBand, f64),
        rate: impl Fn(f64) -> f64,
        depth: impl Fn(f64) -> f64,
    ) -> Estimate {
        let dt = 0.05;
        let mut integrator = Integrator::new(IntegratorRules {
            dead_band,
            width,
            depth_lag: 0.2,
        });
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
        let end = run((DeadBand::TwoSided, 0.0), |_| drift, |_| 0.0);
        assert!((end.pitch - 10.0 * drift).abs() < 1e-12);
        assert_eq!(
            run((DeadBand::TwoSided, drift), |_| drift, |_| 0.0).pitch,
            0.0
        );
    }

    #[test]
    fn the_comparator_does_not_see_the_bow_rise_and_loses_the_offset_of_its_fall() {
        let offset = 2_f64.to_radians();
        let comparator = (DeadBand::Comparator, offset);
        assert_eq!(run(comparator, |_| 0.5, |_| 0.0).pitch, 0.0);
        let end = run(comparator, |_| -0.1, |_| 0.0);
        assert!((end.pitch + 10.0 * (0.1 - offset)).abs() < 1e-12);
        assert_eq!(run(comparator, |_| -0.5 * offset, |_| 0.0).pitch, 0.0);
    }

    #[test]
    fn a_steady_dive_has_its_depth_rate() {
        let end = run((DeadBand::TwoSided, 0.0), |_| 0.0, |t| 1.0 + 0.1 * t);
        assert!((end.depth_rate - 0.1).abs() < 1e-9, "{}", end.depth_rate);
        assert_eq!(end.depth, 2.0);
    }
}
