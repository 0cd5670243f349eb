//! The ultra-short baseline: the vehicle's position, measured by a transceiver at the surface above the origin.
//!
//! The error grows with the slant range `r`, since it comes from bearings: `sigma^2 = sigma_0^2 + (c r)^2` along each axis. A measurement
//! is valid at the time it was made, and reaches the vehicle after a delay; some are lost, and some are outliers.

use std::collections::VecDeque;

use planesman_parameters::Parameters;

use crate::sensors::noise::{Source, Stream};

/// An ultra-short baseline.
///
/// Its parameters are `sensors.usbl.*`.
#[derive(Clone, Copy, Debug, PartialEq, Parameters)]
pub struct Usbl {
    /// Measurements of the ultra-short baseline (usbl), whose transceiver is at the origin of map; at most one a tick; 0: off.
    #[parameter(default = 0.0, unit = "Hz", range = 0.0..=1000.0, read_only)]
    pub rate: f64,
    /// Standard deviation along each axis at short range; assumed.
    #[parameter(default = 0.2, unit = "m", range = 0.0..=1000.0)]
    pub noise: f64,
    /// Further standard deviation along each axis, as a share of the slant range; assumed.
    #[parameter(default = 0.01, range = 0.0..=1.0)]
    pub relative_noise: f64,
    /// Constant error along each axis of map.
    #[parameter(default = 0.0, unit = "m", range = -1000.0..=1000.0)]
    pub bias: f64,
    /// Time from a measurement, its stamp, until the vehicle has it.
    #[parameter(default = 0.0, unit = "s", range = 0.0..=60.0)]
    pub delay: f64,
    /// Probability that a measurement is lost.
    #[parameter(default = 0.0, range = 0.0..=1.0)]
    pub dropout: f64,
    /// Probability that a measurement is an outlier.
    #[parameter(default = 0.0, range = 0.0..=1.0)]
    pub outlier: f64,
    /// Standard deviation of an outlier's further error along each axis.
    #[parameter(default = 20.0, unit = "m", range = 0.0..=10_000.0)]
    pub outlier_size: f64,
}

/// A measurement that has arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    /// In `map` \[m\].
    pub position: [f64; 3],
    /// Standard deviation of the fix along each axis, without outliers.
    pub deviation: f64,
    /// Its age \[ns\].
    pub age: i64,
}

#[derive(Clone, Debug)]
pub(super) struct Memory {
    noise: [Stream; 3],
    outlier: [Stream; 3],
    events: Stream,
    /// Measurements on their way, each with its time \[ns\].
    pending: VecDeque<(i64, Reading)>,
}

impl Memory {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            noise: [0, 1, 2].map(|axis| Stream::new(seed, Source::Usbl(axis))),
            outlier: [0, 1, 2].map(|axis| Stream::new(seed, Source::UsblOutlier(axis))),
            events: Stream::new(seed, Source::UsblEvents),
            pending: VecDeque::new(),
        }
    }
}

impl Usbl {
    /// Returns the measurement that arrives at a time \[ns\], at most one. If `due`, a new measurement of the position \[m\] is made.
    pub(super) fn read(
        &self,
        position: [f64; 3],
        time: i64,
        due: bool,
        memory: &mut Memory,
    ) -> Option<Reading> {
        if due && let Some(made) = self.measure(position, memory) {
            memory.pending.push_back((time, made));
        }
        let (made, _) = *memory.pending.front()?;
        let age = time - made;
        if age < (self.delay * 1e9).round() as i64 {
            return None;
        }
        let (_, reading) = memory.pending.pop_front()?;
        Some(Reading { age, ..reading })
    }

    fn measure(&self, position: [f64; 3], memory: &mut Memory) -> Option<Reading> {
        let normal = memory.noise.each_mut().map(Stream::draw);
        let far = memory.outlier.each_mut().map(Stream::draw);
        let is_lost = memory.events.happens(self.dropout);
        let is_outlier = memory.events.happens(self.outlier);
        if is_lost {
            return None;
        }
        let [x, y, z] = position;
        let slant = self.relative_noise * libm::hypot(libm::hypot(x, y), z);
        let deviation = libm::hypot(self.noise, slant);
        let beyond = if is_outlier { self.outlier_size } else { 0.0 };
        Some(Reading {
            position: std::array::from_fn(|i| {
                position[i] + self.bias + deviation * normal[i] + beyond * far[i]
            }),
            deviation,
            age: 0,
        })
    }
}
