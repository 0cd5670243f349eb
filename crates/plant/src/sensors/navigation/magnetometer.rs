//! The magnetometer: the earth's field turned into the body, with hard iron and noise.
//!
//! At a place the field has a strength `B`, an inclination `I` below the horizon and a declination `D` east of true north; its horizontal
//! share is `B cos I`. The x axis of `odom` points to the azimuth `psi`:
//!
//! ```text
//! x = B cos I cos(D - psi)     y = -B cos I sin(D - psi)     z = -B sin I
//! ```

use crate::sensors::noise::{Source, Stream};

/// The earth's field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct EarthField {
    /// \[T\]
    pub strength: f64,
    /// East of true north \[rad\].
    pub declination: f64,
    /// Below the horizon \[rad\].
    pub inclination: f64,
}

impl EarthField {
    /// \[T\], in the axes of `odom`, the first of which points to an azimuth \[rad\].
    pub(super) fn in_odom(&self, azimuth: f64) -> [f64; 3] {
        let (down, level) = libm::sincos(self.inclination);
        let (sin, cos) = libm::sincos(self.declination - azimuth);
        [level * cos, -level * sin, -down].map(|share| self.strength * share)
    }
}

/// A magnetometer of three axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Magnetometer {
    /// \[Hz\]; 0: off.
    pub rate: f64,
    /// Standard deviation of each axis \[T\].
    pub noise: f64,
    /// The field of the vehicle's own iron \[T\], forward, left, up.
    pub hard_iron: [f64; 3],
}

#[derive(Clone, Debug)]
pub(super) struct Memory([Stream; 3]);

impl Memory {
    pub(super) fn new(seed: u64) -> Self {
        Self([0, 1, 2].map(|axis| Stream::new(seed, Source::Magnetometer(axis))))
    }
}

impl Magnetometer {
    /// The measurement of a field \[T\]; both forward, left, up.
    pub(super) fn read(&self, field: [f64; 3], memory: &mut Memory) -> [f64; 3] {
        std::array::from_fn(|i| field[i] + self.hard_iron[i] + self.noise * memory.0[i].draw())
    }
}
