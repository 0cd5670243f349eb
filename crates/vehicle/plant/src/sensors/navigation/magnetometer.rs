//! The magnetometer: the earth's field in body axes, with hard iron and noise.
//!
//! A position has a field of strength `B`, an inclination `I` below the horizon and a declination `D` east of true north; the horizontal
//! component is `B cos I`. The x axis of `odom` points to the azimuth `psi`:
//!
//! ```text
//! x = B cos I cos(D - psi)     y = -B cos I sin(D - psi)     z = -B sin I
//! ```

use std::f64::consts::{FRAC_PI_2, PI};

use planesman_parameters::Parameters;

use crate::sensors::noise::{Source, Stream};

/// The earth's field.
///
/// Its parameters are `environment.earth_field.*`.
#[derive(Clone, Copy, Debug, PartialEq, Parameters)]
pub struct EarthField {
    /// Strength of the earth's magnetic field; strength, declination and inclination are the values for Monterey Bay in 2025 (World Magnetic Model).
    #[parameter(default = 46.9e-6, unit = "T", range = 0.0..=1e-3)]
    pub strength: f64,
    /// Declination: angle of magnetic north east of true north.
    #[parameter(default = 0.221, unit = "rad", range = -PI..=PI)]
    pub declination: f64,
    /// Inclination of the magnetic field below the horizon.
    #[parameter(default = 1.052, unit = "rad", range = -FRAC_PI_2..=FRAC_PI_2)]
    pub inclination: f64,
}

impl EarthField {
    /// The field \[T\] in the axes of `odom`, whose x axis points to an azimuth \[rad\].
    pub(super) fn in_odom(&self, azimuth: f64) -> [f64; 3] {
        let (down, level) = libm::sincos(self.inclination);
        let (sin, cos) = libm::sincos(self.declination - azimuth);
        [level * cos, -level * sin, -down].map(|share| self.strength * share)
    }
}

/// A three-axis magnetometer.
///
/// Its parameters are `sensors.magnetometer.*`.
#[derive(Clone, Copy, Debug, PartialEq, Parameters)]
pub struct Magnetometer {
    /// Measurements of the magnetometer (magnetic_field), at most one a tick; 0: off.
    #[parameter(default = 0.0, unit = "Hz", range = 0.0..=1000.0, read_only)]
    pub rate: f64,
    /// Standard deviation of each axis; assumed.
    #[parameter(default = 2e-7, unit = "T", range = 0.0..=1e-3)]
    pub noise: f64,
    /// `sensors.magnetometer.hard_iron.*`.
    pub hard_iron: HardIron,
}

/// The parameters `sensors.magnetometer.hard_iron.*`.
#[derive(Clone, Copy, Debug, PartialEq, Parameters)]
pub struct HardIron {
    /// Field of the vehicle's own iron, forward.
    #[parameter(default = 0.0, unit = "T", range = -1e-3..=1e-3)]
    pub x: f64,
    /// Field of the vehicle's own iron, to the left.
    #[parameter(default = 0.0, unit = "T", range = -1e-3..=1e-3)]
    pub y: f64,
    /// Field of the vehicle's own iron, upwards.
    #[parameter(default = 0.0, unit = "T", range = -1e-3..=1e-3)]
    pub z: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Memory([Stream; 3]);

impl Memory {
    pub(super) fn new(seed: u64) -> Self {
        Self([0, 1, 2].map(|axis| Stream::new(seed, Source::Magnetometer(axis))))
    }
}

impl Magnetometer {
    /// Measurement of a field \[T\]; both forward, left, up.
    pub(super) fn read(&self, field: [f64; 3], memory: &mut Memory) -> [f64; 3] {
        let HardIron { x, y, z } = self.hard_iron;
        let iron = [x, y, z];
        std::array::from_fn(|i| field[i] + iron[i] + self.noise * memory.0[i].draw())
    }
}
