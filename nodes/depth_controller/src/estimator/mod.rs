//! Pitch and depth rate from what the vehicle can measure: the rate gyro, the depth cell and its speed.
//!
//! The 1988 vehicle had no inclinometer. Its pitch was the integral of a gyro whose zero drifts by
//! 25 mV, which is 2 deg/s (Brunner, NPS thesis, 1988, p. 90): 20 degrees of pitch in ten seconds.
//!
//! - [`instruments`]: the topics read.
//! - [`integrator`]: the report's remedy, a dead band before the integrator (p. 91).
//! - [`kalman`]: a Kalman filter, which learns the gyro's zero from the depth.
//!
//! The vehicle's true state is a third source; [`Source`] names them all.

pub mod instruments;
pub mod integrator;
pub mod kalman;

pub use instruments::{Calibration, Instruments};
pub use integrator::{DeadBand, Integrator};
pub use kalman::{Kalman, Tuning};

/// Where the loops take pitch, its rate, depth and its rate from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Source {
    /// The vehicle's true state.
    Truth,
    /// The gyro behind a dead band, integrated; depth measured and differentiated.
    Integrator,
    /// The Kalman filter.
    Kalman,
}

/// What the instruments read at one stamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measurement {
    /// The rate gyro, rad/s, positive bow up.
    pub pitch_rate: f64,
    /// The depth cell, m, positive down; `None` where it is beyond its range.
    pub depth: Option<f64>,
    /// The speed through the water, m/s.
    pub speed: f64,
}

/// What is fed back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// rad, positive bow up
    pub pitch: f64,
    /// rad/s, positive bow up
    pub pitch_rate: f64,
    /// m, positive down
    pub depth: f64,
    /// m/s, positive down
    pub depth_rate: f64,
    /// The gyro's zero, rad/s; 0 where it is not estimated.
    pub gyro_bias: f64,
}

/// An estimator's settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rules {
    /// Which estimator, if any.
    pub source: Source,
    /// How the instruments are read.
    pub calibration: Calibration,
    /// Before the integrator.
    pub dead_band: DeadBand,
    /// Of the depth's derivative beside the integrator, s.
    pub lag: f64,
    /// Of the filter.
    pub tuning: Tuning,
}

/// The estimator that the rules name, and what it reads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimator {
    /// The instruments' last words.
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
    /// Forgets what it estimates: a new run begins.
    pub fn restart(&mut self) {
        self.state = State::Fresh;
    }

    /// Whether the instruments have spoken for this stamp (ns), or are not asked.
    #[must_use]
    pub fn ready(&self, stamp: i64, rules: &Rules) -> bool {
        rules.source == Source::Truth || self.instruments.complete(stamp, &rules.calibration)
    }

    /// The estimate at a stamp (ns), `dt` seconds after the last; `None` where the truth is fed back.
    pub fn step(&mut self, rules: &Rules, stamp: i64, dt: f64) -> Option<Estimated> {
        if self.state == State::Fresh {
            self.state = match rules.source {
                Source::Truth => return None,
                Source::Integrator => {
                    State::Integrator(Integrator::new(rules.dead_band, rules.lag))
                }
                Source::Kalman => State::Kalman(Kalman::new(rules.tuning)),
            };
        }
        let measured = self.instruments.measurement(stamp, &rules.calibration);
        let missing = !self.instruments.complete(stamp, &rules.calibration);
        let (estimate, covariance) = match &mut self.state {
            State::Fresh => return None,
            State::Integrator(integrator) => {
                integrator.set(rules.dead_band, rules.lag);
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

/// An estimate with what it was made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimated {
    /// The estimate.
    pub estimate: Estimate,
    /// The readings.
    pub measured: Measurement,
    /// A reading for the stamp did not come.
    pub missing: bool,
    /// As [`Kalman::covariance`]; 0 for the integrator.
    pub covariance: [f64; 16],
}
