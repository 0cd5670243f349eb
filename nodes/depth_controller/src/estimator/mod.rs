//! Pitch and depth rate from what the vehicle can measure: the rate gyro, the depth cell and its speed.
//!
//! The 1988 vehicle had no inclinometer. Its pitch was the integral of a gyro whose zero drifts by
//! 25 mV, which is 2 deg/s (Brunner, NPS thesis, 1988, p. 90): 20 degrees of pitch in ten seconds.
//!
//! - [`integrator`]: the report's remedy, a dead band before the integrator (p. 91).
//! - [`kalman`]: a Kalman filter, which learns the gyro's zero from the depth.
//!
//! The vehicle's true state is a third source; [`Source`] names them all.

pub mod integrator;
pub mod kalman;

pub use integrator::{DeadBand, Integrator};
pub use kalman::{Kalman, Tuning};

/// Where the loops take pitch, its rate, depth and its rate from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The vehicle's true state.
    Truth,
    /// The gyro behind a dead band, integrated; depth measured and differentiated.
    Integrator,
    /// The Kalman filter.
    Kalman,
}

impl Source {
    /// The names, as the parameter takes them.
    pub const NAMES: &'static [&'static str] = &["truth", "integrator", "kalman"];

    /// The source of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        [Self::Truth, Self::Integrator, Self::Kalman]
            .into_iter()
            .zip(Self::NAMES)
            .find_map(|(source, known)| (*known == name).then_some(source))
    }
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
