//! The satellite receiver: a position while its antenna is above the water.

use planesman_parameters::Parameters;

use super::geodesy::{Geodetic, Origin};
use crate::{
    odometry::Odometry,
    sensors::noise::{Source, Stream},
};

/// A receiver with its antenna above the body's origin.
///
/// Its parameters are `sensors.gps.*`.
#[derive(Clone, Copy, Debug, PartialEq, Parameters)]
pub struct Gps {
    /// Measurements of the satellite receiver (gps), at most one a tick; 0: off.
    #[parameter(default = 0.0, unit = "Hz", range = 0.0..=1000.0, read_only)]
    pub rate: f64,
    /// Standard deviation to the east and to the north; assumed.
    #[parameter(default = 1.0, unit = "m", range = 0.0..=1000.0)]
    pub noise: f64,
    /// Standard deviation of the altitude; assumed.
    #[parameter(default = 2.0, unit = "m", range = 0.0..=1000.0)]
    pub vertical_noise: f64,
    /// Constant error to the east and to the north.
    #[parameter(default = 0.0, unit = "m", range = -1000.0..=1000.0)]
    pub bias: f64,
    /// Height of the antenna above the body's origin. There is a fix while the antenna is out of the water.
    #[parameter(default = 0.1, unit = "m", range = 0.0..=100.0, read_only)]
    pub antenna: f64,
}

/// Position of the antenna; `None` without a fix.
pub(crate) type Reading = Option<Geodetic>;

#[derive(Clone, Debug)]
pub(super) struct Memory([Stream; 3]);

impl Memory {
    pub(super) fn new(seed: u64) -> Self {
        Self([0, 1, 2].map(|axis| Stream::new(seed, Source::Gps(axis))))
    }
}

impl Gps {
    /// Standard deviations east, north, up \[m\].
    pub(crate) fn deviation(&self) -> [f64; 3] {
        [self.noise, self.noise, self.vertical_noise]
    }

    pub(super) fn read(
        &self,
        odometry: &Odometry,
        origin: &Origin,
        memory: &mut Memory,
    ) -> Reading {
        let normal = memory.0.each_mut().map(Stream::draw);
        let arm = odometry.to_odom([0.0, 0.0, self.antenna]);
        let antenna: [f64; 3] = std::array::from_fn(|i| odometry.position[i] + arm[i]);
        if antenna[2] < 0.0 {
            return None;
        }
        let place = origin.east_north_up(antenna);
        let (bias, deviation) = ([self.bias, self.bias, 0.0], self.deviation());
        Some(origin.geodetic(std::array::from_fn(|i| {
            place[i] + bias[i] + deviation[i] * normal[i]
        })))
    }
}
