//! The satellite receiver: a position while its antenna is out of the water.

use super::geodesy::{Geodetic, Origin};
use crate::{
    odometry::Odometry,
    sensors::noise::{Source, Stream},
};

/// A receiver with its antenna above the body's origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Gps {
    /// \[Hz\]; 0: off.
    pub rate: f64,
    /// Standard deviations east, north, up \[m\].
    pub noise: [f64; 3],
    /// Constant error, east, north, up \[m\].
    pub bias: [f64; 3],
    /// The antenna's height above the body's origin \[m\].
    pub antenna: f64,
}

/// The antenna's place; `None` without a fix.
pub(crate) type Reading = Option<Geodetic>;

#[derive(Clone, Debug)]
pub(super) struct Memory([Stream; 3]);

impl Memory {
    pub(super) fn new(seed: u64) -> Self {
        Self([0, 1, 2].map(|axis| Stream::new(seed, Source::Gps(axis))))
    }
}

impl Gps {
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
        Some(origin.geodetic(std::array::from_fn(|i| {
            place[i] + self.bias[i] + self.noise[i] * normal[i]
        })))
    }
}
