//! The ultra-short baseline: the vehicle's position as a transceiver hears it, at the surface above the origin.
//!
//! The error grows with the slant range `r`, as bearings have errors: `sigma^2 = sigma_0^2 + (c r)^2` along each axis. A measurement is
//! valid when it was made, and reaches the vehicle after a delay; some are lost, and some are outliers.

use std::collections::VecDeque;

use crate::sensors::noise::{Source, Stream};

/// An ultra-short baseline.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Usbl {
    /// \[Hz\]; 0: off.
    pub rate: f64,
    /// `sigma_0` \[m\].
    pub noise: f64,
    /// `c`
    pub relative_noise: f64,
    /// Constant error along each axis \[m\].
    pub bias: f64,
    /// From the measurement until the vehicle has it \[ns\].
    pub delay: i64,
    /// Probability that a measurement is lost.
    pub dropout: f64,
    /// Probability that it is an outlier.
    pub outlier: f64,
    /// Standard deviation of an outlier's further error along each axis \[m\].
    pub outlier_size: f64,
}

/// A measurement that has arrived.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    /// In `map` \[m\].
    pub position: [f64; 3],
    /// Its standard deviation along each axis, outliers left out.
    pub deviation: f64,
    /// How long ago it was valid \[ns\].
    pub age: i64,
}

#[derive(Clone, Debug)]
pub(super) struct Memory {
    noise: [Stream; 3],
    outlier: [Stream; 3],
    events: Stream,
    /// On their way, with the time at which each was made \[ns\].
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
    /// What arrives at a time \[ns\], at most one; where `due`, the position \[m\] is measured.
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
        if age < self.delay {
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
