//! The navigation instruments; each is off unless its rate is set.
//!
//! - `dvl`: velocity over ground or through the water, and the altitude above the bottom.
//! - `magnetometer`: the earth's field in body axes.
//! - `gps`: latitude and longitude, at the surface.
//! - `usbl`: the position from the surface, with a delay.
//! - `attitude`: an attitude and heading reference, in `imu`.
//!
//! Their parameters are declared next to their equations. All vectors are in ROS frames (REP 103): forward, left, up in the body, or the
//! axes of `odom`, whose direction on the earth is [`Origin::heading`].

mod attitude;
mod dvl;
mod geodesy;
mod gps;
mod magnetometer;
#[cfg(test)]
mod tests;
mod usbl;

pub(crate) use attitude::AttitudeReference;
pub(crate) use dvl::{BEAM_ANGLE, Dvl, Lock, Reading as DvlReading};
pub(crate) use geodesy::Origin;
pub(crate) use gps::{Gps, Reading as GpsReading};
use magnetometer::HardIron;
pub(crate) use magnetometer::{EarthField, Magnetometer};
pub(crate) use usbl::{Reading as UsblReading, Usbl};

use crate::odometry::Odometry;

/// The instruments, with the data of the earth that they need.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Navigation {
    pub origin: Origin,
    pub earth_field: EarthField,
    pub dvl: Dvl,
    pub magnetometer: Magnetometer,
    pub gps: Gps,
    pub usbl: Usbl,
    pub attitude: AttitudeReference,
}

/// State of the instruments from tick to tick.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    dvl: dvl::Memory,
    magnetometer: magnetometer::Memory,
    gps: gps::Memory,
    usbl: usbl::Memory,
    attitude: attitude::Memory,
}

impl Memory {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            dvl: dvl::Memory::new(seed),
            magnetometer: magnetometer::Memory::new(seed),
            gps: gps::Memory::new(seed),
            usbl: usbl::Memory::new(seed),
            attitude: attitude::Memory::new(seed),
        }
    }
}

/// Readings in a tick; `None` without a measurement in this tick, or if the instrument is off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Readings {
    pub dvl: Option<DvlReading>,
    /// Magnetic field \[T\], forward, left, up.
    pub magnetic_field: Option<[f64; 3]>,
    pub gps: Option<GpsReading>,
    pub usbl: Option<UsblReading>,
    /// The quaternion (x, y, z, w) from the body to east, north, up.
    pub orientation: Option<[f64; 4]>,
}

impl Navigation {
    /// Returns the same instruments without errors; ranges, delay and mounting stay.
    pub(crate) fn without_errors(self) -> Self {
        Self {
            dvl: Dvl {
                noise: 0.0,
                water_noise: 0.0,
                scale: 0.0,
                altitude_noise: 0.0,
                dropout: 0.0,
                ..self.dvl
            },
            magnetometer: Magnetometer {
                noise: 0.0,
                hard_iron: HardIron::default(),
                ..self.magnetometer
            },
            gps: Gps {
                noise: 0.0,
                vertical_noise: 0.0,
                bias: 0.0,
                ..self.gps
            },
            usbl: Usbl {
                noise: 0.0,
                relative_noise: 0.0,
                bias: 0.0,
                dropout: 0.0,
                outlier: 0.0,
                ..self.usbl
            },
            attitude: AttitudeReference {
                noise: 0.0,
                heading_noise: 0.0,
                heading_bias: 0.0,
                ..self.attitude
            },
            ..self
        }
    }

    /// Readings in the tick of length `tick` \[ns\] that begins at `time` \[ns\], over a bottom at a depth \[m\].
    pub(super) fn read(
        &self,
        odometry: &Odometry,
        bottom: Option<f64>,
        [time, tick]: [i64; 2],
        memory: &mut Memory,
    ) -> Readings {
        let due = |rate: f64| is_due(rate, time, tick);
        let heading = self.origin.heading;
        Readings {
            dvl: match due(self.dvl.rate) {
                true => self.dvl.read(odometry, bottom, &mut memory.dvl),
                false => None,
            },
            magnetic_field: due(self.magnetometer.rate).then(|| {
                let field = odometry.to_body(self.earth_field.in_odom(heading));
                self.magnetometer.read(field, &mut memory.magnetometer)
            }),
            gps: due(self.gps.rate).then(|| self.gps.read(odometry, &self.origin, &mut memory.gps)),
            usbl: {
                let due = due(self.usbl.rate);
                (self.usbl).read(odometry.position, time, due, &mut memory.usbl)
            },
            orientation: self
                .attitude
                .enabled
                .then(|| (self.attitude).read(odometry.orientation, heading, &mut memory.attitude)),
        }
    }
}

/// Whether a measurement is due in the tick of length `tick` \[ns\] that begins at `time` \[ns\]: in the first tick at or after each
/// multiple of the period 1/rate, at most one per tick. A rate of 0 means no measurement.
fn is_due(rate: f64, time: i64, tick: i64) -> bool {
    if rate <= 0.0 {
        return false;
    }
    let period = ((1e9 / rate).round() as i64).max(1);
    time.div_euclid(period) != (time - tick).div_euclid(period)
}
