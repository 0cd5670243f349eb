//! The Doppler velocity log: four beams, reflected by the bottom or the water.
//!
//! Each beam measures the velocity along its own direction; the vehicle's velocity is their least-squares solution. With the beams at an
//! angle `J` from the downward axis, at azimuths of 45, 135, 225 and 315 degrees (a Janus configuration):
//!
//! ```text
//! m_i = b_i . v + n_i              b_i = (sin J cos a_i, sin J sin a_i, -cos J)
//! v   = (B^T B)^-1 B^T m           B^T B = diag(2 sin^2 J, 2 sin^2 J, 4 cos^2 J)
//! sigma_x = sigma_y = sigma / (sqrt 2 sin J)          sigma_z = sigma / (2 cos J)
//! ```
//!
//! The sensor has bottom lock while all four beams reach the bottom within the range, and water lock otherwise.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_6};

use planesman_parameters::Parameters;

use crate::{
    odometry::Odometry,
    sensors::noise::{Source, Stream},
};

/// `J` \[rad\], typical of such units.
pub(crate) const BEAM_ANGLE: f64 = FRAC_PI_6;

/// Cosine and sine of each beam's azimuth, times `sqrt 2`.
const AZIMUTHS: [[f64; 2]; 4] = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];

/// A Doppler velocity log at the body's origin.
///
/// Its parameters are `sensors.dvl.*`.
#[derive(Clone, Copy, Debug, PartialEq, Parameters)]
pub struct Dvl {
    /// Measurements of the Doppler velocity log (dvl, dvl_water, altitude), at most one a tick; 0: off.
    #[parameter(default = 0.0, unit = "Hz", range = 0.0..=1000.0, read_only)]
    pub rate: f64,
    /// Standard deviation of the velocity along each of the four beams, with bottom lock; assumed, like all values of this sensor.
    #[parameter(default = 0.005, unit = "m/s", range = 0.0..=10.0)]
    pub noise: f64,
    /// Standard deviation of the velocity along each of the four beams, with water lock.
    #[parameter(default = 0.02, unit = "m/s", range = 0.0..=10.0)]
    pub water_noise: f64,
    /// Relative error of all velocities, for example because of a wrong speed of sound.
    #[parameter(default = 0.0, range = -0.5..=0.5)]
    pub scale: f64,
    /// Standard deviation of the altitude.
    #[parameter(default = 0.01, unit = "m", range = 0.0..=10.0)]
    pub altitude_noise: f64,
    /// Largest distance to the bottom along a beam, for bottom lock.
    #[parameter(default = 50.0, unit = "m", range = 0.0..=11_000.0)]
    pub range: f64,
    /// Probability that a measurement gives no result.
    #[parameter(default = 0.0, range = 0.0..=1.0)]
    pub dropout: f64,
}

/// Reflector of the beams.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Lock {
    /// The velocity is over ground; `altitude` is the distance to the bottom \[m\] along the body's downward axis.
    Bottom { altitude: f64 },
    /// The velocity is through the water.
    Water,
}

/// A measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    pub lock: Lock,
    /// Forward, left, up \[m/s\].
    pub velocity: [f64; 3],
    /// Its standard deviations.
    pub deviation: [f64; 3],
}

#[derive(Clone, Debug)]
pub(super) struct Memory {
    beams: [Stream; 4],
    altitude: Stream,
    dropout: Stream,
}

impl Memory {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            beams: [0, 1, 2, 3].map(|i| Stream::new(seed, Source::DvlBeam(i))),
            altitude: Stream::new(seed, Source::DvlAltitude),
            dropout: Stream::new(seed, Source::DvlDropout),
        }
    }
}

impl Dvl {
    /// Returns the present measurement over a bottom at a depth \[m\]; `None` for a dropout.
    pub(super) fn read(
        &self,
        odometry: &Odometry,
        bottom: Option<f64>,
        memory: &mut Memory,
    ) -> Option<Reading> {
        let normal = memory.beams.each_mut().map(Stream::draw);
        let altitude_error = self.altitude_noise * memory.altitude.draw();
        if memory.dropout.happens(self.dropout) {
            return None;
        }
        let (lock, velocity, noise) = match bottom.and_then(|it| self.altitude(odometry, it)) {
            Some(altitude) => {
                let altitude = (altitude + altitude_error).max(0.0);
                (Lock::Bottom { altitude }, odometry.velocity, self.noise)
            }
            None => (Lock::Water, odometry.through_water, self.water_noise),
        };
        let (sin, cos) = libm::sincos(BEAM_ANGLE);
        let weights = [2.0 * sin * sin, 2.0 * sin * sin, 4.0 * cos * cos];
        let mut solution = [0.0; 3];
        for (beam, normal) in beams().into_iter().zip(normal) {
            let [x, y, z] = beam;
            let along = x * velocity[0] + y * velocity[1] + z * velocity[2];
            let measured = (1.0 + self.scale) * along + noise * normal;
            for (i, weight) in weights.into_iter().enumerate() {
                solution[i] += beam[i] * measured / weight;
            }
        }
        let across = noise * FRAC_1_SQRT_2 / sin;
        Some(Reading {
            lock,
            velocity: solution,
            deviation: [across, across, noise / (2.0 * cos)],
        })
    }

    /// Distance to the bottom \[m\] along the body's downward axis; `None` unless all beams reach it.
    fn altitude(&self, odometry: &Odometry, bottom: f64) -> Option<f64> {
        let above = bottom + odometry.position[2];
        let along = |axis: [f64; 3]| above / -odometry.to_odom(axis)[2];
        // Of a beam that points upwards the distance is negative, or it is infinite.
        let reaches = |beam| (0.0..=self.range).contains(&along(beam));
        let locked = beams().into_iter().all(reaches);
        locked.then(|| along([0.0, 0.0, -1.0]))
    }
}

/// Directions of the beams, forward, left, up.
fn beams() -> [[f64; 3]; 4] {
    let (sin, cos) = libm::sincos(BEAM_ANGLE);
    let aside = sin * FRAC_1_SQRT_2;
    AZIMUTHS.map(|[x, y]| [aside * x, aside * y, -cos])
}
