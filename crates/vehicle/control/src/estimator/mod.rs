//! Pitch and depth rate from the vehicle's measurements: the rate gyro, the depth cell and its speed.
//!
//! The 1988 vehicle had no inclinometer. Pitch was the integral of a gyro whose zero drifts by 25 mV, which is 2 deg/s (Brunner, NPS thesis, 1988, p.
//! 90): 20 degrees of pitch in ten seconds.
//!
//! - [`Instruments`]: the readings of the topics.
//! - [`Integrator`]: the report's remedy, a dead band before the integrator (p. 91).
//! - [`Kalman`]: a Kalman filter, which estimates the gyro's zero from the depth.
//!
//! The vehicle's true state is a third source; [`Source`] names them all.

mod instruments;
mod integrator;
mod kalman;
mod motion;

pub(crate) use instruments::{Calibration, Instruments};
pub(crate) use integrator::{Integrator, IntegratorRules};
pub(crate) use kalman::{Kalman, Tuning};
pub(crate) use motion::{Estimate, Measurement};

/// The source of pitch, depth and their rates for the loops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Source {
    /// The vehicle's true state.
    Truth,
    /// The integrated gyro with a dead band; depth measured and differentiated.
    Integrator,
    /// The Kalman filter.
    Kalman,
}

/// An estimator's settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rules {
    /// The source of the feedback, which may be an estimator.
    pub source: Source,
    /// The constants of the instruments.
    pub calibration: Calibration,
    /// The rules of the integrator.
    pub integrator: IntegratorRules,
    /// The tuning of the filter.
    pub tuning: Tuning,
}

/// The estimator of the rules, and its instruments.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Estimator {
    /// The instruments' last readings.
    pub instruments: Instruments,
    state: State,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum State {
    #[default]
    Fresh,
    Integrator(Integrator),
    Kalman(Kalman),
}

impl Estimator {
    /// Clears the estimate for a new run.
    pub(crate) fn restart(&mut self) {
        self.state = State::Fresh;
    }

    /// Whether the instruments for this stamp (ns) have been received, or are not needed.
    #[must_use]
    pub(crate) fn ready(&self, stamp: i64, rules: &Rules) -> bool {
        rules.source == Source::Truth || self.instruments.complete(stamp, &rules.calibration)
    }

    /// The estimate at a stamp (ns), `dt` seconds after the last; `None` if the true state is fed back.
    pub(crate) fn step(&mut self, rules: &Rules, stamp: i64, dt: f64) -> Option<Estimated> {
        if self.state == State::Fresh {
            self.state = match rules.source {
                Source::Truth => return None,
                Source::Integrator => State::Integrator(Integrator::new(rules.integrator)),
                Source::Kalman => State::Kalman(Kalman::new(rules.tuning)),
            };
        }
        let measured = self.instruments.measurement(stamp, &rules.calibration);
        let missing = !self.instruments.complete(stamp, &rules.calibration);
        let (estimate, covariance) = match &mut self.state {
            State::Fresh => return None,
            State::Integrator(integrator) => {
                integrator.set_rules(rules.integrator);
                (integrator.step(&measured, dt), None)
            }
            State::Kalman(filter) => {
                filter.set_tuning(rules.tuning);
                (filter.step(&measured, dt), filter.covariance())
            }
        };
        Some(Estimated {
            estimate,
            measured,
            missing,
            covariance: covariance.unwrap_or([0.0; 16]),
        })
    }
}

/// An estimate with its measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Estimated {
    /// The estimate.
    pub estimate: Estimate,
    /// The readings.
    pub measured: Measurement,
    /// Whether a reading for the stamp did not come.
    pub missing: bool,
    /// Like [`Kalman::covariance`]; 0 for the integrator.
    pub covariance: [f64; 16],
}
