//! Random numbers, with a separate stream for each source of error.
//!
//! The numbers of a stream depend only on the seed, the source and the number of draws: switching off one source does not change another.

use planesman_vehicle::standard_normal;
use rand_pcg::{
    Pcg64,
    rand_core::{Rng, SeedableRng},
};

/// Sources of random errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// White noise of the rate gyro about an axis, 0 to 2: roll, pitch, yaw.
    GyroNoise(u8),
    /// Drift of that gyro's zero.
    GyroDrift(u8),
    /// White noise of the accelerometer along an axis, 0 to 2: forward, left, up.
    Accelerometer(u8),
    /// White noise of the depth cell.
    Depth,
    /// White noise of the speed cell.
    Speed,
    /// White noise of the dive-plane signal.
    Planes,
    /// White noise of the Doppler log along a beam, 0 to 3.
    DvlBeam(u8),
    /// White noise of its altitude.
    DvlAltitude,
    /// Its dropouts.
    DvlDropout,
    /// White noise of the magnetometer along an axis, 0 to 2.
    Magnetometer(u8),
    /// White noise of the satellite receiver: east, north, up.
    Gps(u8),
    /// White noise of the ultra-short baseline along an axis, 0 to 2.
    Usbl(u8),
    /// Error of an outlier of the ultra-short baseline along an axis.
    UsblOutlier(u8),
    /// Lost measurements and outliers of the ultra-short baseline.
    UsblEvents,
    /// White noise of the attitude reference about east, north, up.
    Attitude(u8),
}

impl Source {
    /// Number of the stream; it is permanent for each source, so a seed always gives the same numbers.
    fn number(self) -> u64 {
        match self {
            Self::GyroNoise(axis) => u64::from(axis),
            Self::GyroDrift(axis) => 16 + u64::from(axis),
            Self::Accelerometer(axis) => 32 + u64::from(axis),
            Self::Depth => 48,
            Self::Speed => 49,
            Self::Planes => 50,
            Self::DvlBeam(beam) => 64 + u64::from(beam),
            Self::DvlAltitude => 72,
            Self::DvlDropout => 73,
            Self::Magnetometer(axis) => 80 + u64::from(axis),
            Self::Gps(axis) => 96 + u64::from(axis),
            Self::Usbl(axis) => 112 + u64::from(axis),
            Self::UsblOutlier(axis) => 116 + u64::from(axis),
            Self::UsblEvents => 120,
            Self::Attitude(axis) => 128 + u64::from(axis),
        }
    }
}

/// Normal random numbers with mean 0 and variance 1: PCG XSL RR 128/64 (O'Neill 2014), identical on every machine.
#[derive(Clone, Debug)]
pub(crate) struct Stream(Pcg64);

impl Stream {
    /// Returns the stream of a source for a seed.
    #[must_use]
    pub(crate) fn new(seed: u64, source: Source) -> Self {
        // Steps of 2^64 over the golden ratio keep neighbouring seeds' streams apart.
        let step = source.number().wrapping_mul(0x9E37_79B9_7F4A_7C15);
        Self(Pcg64::seed_from_u64(seed.wrapping_add(step)))
    }

    /// Draws the next number.
    pub(crate) fn draw(&mut self) -> f64 {
        standard_normal(&mut self.0)
    }

    /// Draws whether an event of this probability happens.
    pub(crate) fn happens(&mut self, probability: f64) -> bool {
        // 53 bits, from 0 to below 1.
        let share = (self.0.next_u64() >> 11) as f64 * (0.5_f64).powi(53);
        share < probability
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(seed: u64, source: Source) -> [f64; 3] {
        let mut stream = Stream::new(seed, source);
        std::array::from_fn(|_| stream.draw())
    }

    #[test]
    fn a_seed_gives_the_same_numbers_in_every_run() {
        let known = [-1.330321424148039, 0.5976417696013718, -1.5256378743128125];
        assert_eq!(first(1988, Source::GyroNoise(0)), known);
        assert_ne!(first(1989, Source::GyroNoise(0)), known);
    }

    #[test]
    fn no_two_sources_share_numbers() {
        let axes = |f: fn(u8) -> Source| (0..3).map(f);
        let sources: Vec<Source> = axes(Source::GyroNoise)
            .chain(axes(Source::GyroDrift))
            .chain(axes(Source::Accelerometer))
            .chain((0..4).map(Source::DvlBeam))
            .chain(axes(Source::Magnetometer))
            .chain(axes(Source::Gps))
            .chain(axes(Source::Usbl))
            .chain(axes(Source::UsblOutlier))
            .chain(axes(Source::Attitude))
            .chain([Source::Depth, Source::Speed, Source::Planes])
            .chain([Source::DvlAltitude, Source::DvlDropout, Source::UsblEvents])
            .collect();
        for (i, a) in sources.iter().enumerate() {
            for b in &sources[..i] {
                assert_ne!(first(7, *a), first(7, *b), "{a:?} and {b:?}");
            }
        }
    }
}
