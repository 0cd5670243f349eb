//! The parameters of the instruments that a vehicle finds its way by, and of the earth that they measure.

use std::f64::consts::{FRAC_PI_2, PI};

use planesman_parameters::Parameters;

use crate::sensors::navigation::{self, Navigation};

/// The parameters `environment.origin.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Origin {
    /// Latitude of the frame odom's origin, positive north; Monterey Bay.
    #[parameter(default = 36.7, unit = "deg", range = -90.0..=90.0)]
    pub latitude: f64,
    /// Longitude of the frame odom's origin, positive east; Monterey Bay.
    #[parameter(default = -122.0, unit = "deg", range = -180.0..=180.0)]
    pub longitude: f64,
    /// True azimuth of the initial heading, odom's x axis, from north to the east. At its default, east, odom and map have the axes east,
    /// north, up.
    #[parameter(default = FRAC_PI_2, unit = "rad", range = -PI..=2.0 * PI)]
    pub heading: f64,
}

/// The parameters `environment.earth_field.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct EarthField {
    /// Strength of the earth's magnetic field; it, declination and inclination are those of Monterey Bay in 2025 (World Magnetic Model).
    #[parameter(default = 46.9e-6, unit = "T", range = 0.0..=1e-3)]
    pub strength: f64,
    /// Declination: magnetic north is so far east of true north.
    #[parameter(default = 0.221, unit = "rad", range = -PI..=PI)]
    pub declination: f64,
    /// Inclination of the magnetic field below the horizon.
    #[parameter(default = 1.052, unit = "rad", range = -FRAC_PI_2..=FRAC_PI_2)]
    pub inclination: f64,
}

/// The parameters `sensors.dvl.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Dvl {
    /// Measurements of the Doppler velocity log (dvl, dvl_water, altitude), at most one a tick; 0: off.
    #[parameter(default = 0.0, unit = "Hz", range = 0.0..=1000.0, read_only)]
    pub rate: f64,
    /// Standard deviation of the velocity along each of the four beams, with bottom lock; assumed, as all of this sensor.
    #[parameter(default = 0.005, unit = "m/s", range = 0.0..=10.0)]
    pub noise: f64,
    /// Standard deviation of the velocity along each of the four beams, with water lock.
    #[parameter(default = 0.02, unit = "m/s", range = 0.0..=10.0)]
    pub water_noise: f64,
    /// Relative error of all velocities, as of a wrong speed of sound.
    #[parameter(default = 0.0, range = -0.5..=0.5)]
    pub scale: f64,
    /// Standard deviation of the altitude.
    #[parameter(default = 0.01, unit = "m", range = 0.0..=10.0)]
    pub altitude_noise: f64,
    /// Largest distance to the bottom along a beam, for bottom lock.
    #[parameter(default = 50.0, unit = "m", range = 0.0..=11_000.0)]
    pub range: f64,
    /// Probability that a measurement gives nothing.
    #[parameter(default = 0.0, range = 0.0..=1.0)]
    pub dropout: f64,
}

/// The parameters `sensors.magnetometer.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
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
#[derive(Clone, Debug, PartialEq, Parameters)]
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

/// The parameters `sensors.gps.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
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
    /// Height of the antenna above the body's origin. There is a fix while it is out of the water.
    #[parameter(default = 0.1, unit = "m", range = 0.0..=100.0, read_only)]
    pub antenna: f64,
}

/// The parameters `sensors.usbl.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Usbl {
    /// Measurements of the ultra-short baseline (usbl), whose transceiver is at the origin of map; at most one a tick; 0: off.
    #[parameter(default = 0.0, unit = "Hz", range = 0.0..=1000.0, read_only)]
    pub rate: f64,
    /// Standard deviation along each axis, close by; assumed.
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

/// The parameters `sensors.attitude.*`.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Attitude {
    /// Whether an attitude and heading reference fills the orientation of imu, from the body to east, north, up.
    #[parameter(default = false)]
    pub enabled: bool,
    /// Standard deviation about a level axis; assumed.
    #[parameter(default = 0.002, unit = "rad", range = 0.0..=1.0)]
    pub noise: f64,
    /// Standard deviation of the heading; assumed.
    #[parameter(default = 0.01, unit = "rad", range = 0.0..=1.0)]
    pub heading_noise: f64,
    /// Constant error of the heading, to starboard.
    #[parameter(default = 0.0, unit = "rad", range = -PI..=PI)]
    pub heading_bias: f64,
}

/// Of a plant's parameters those of these instruments.
pub(crate) struct NavigationParameters<'a> {
    pub(crate) errors: bool,
    pub(crate) origin: &'a Origin,
    pub(crate) earth_field: &'a EarthField,
    pub(crate) dvl: &'a Dvl,
    pub(crate) magnetometer: &'a Magnetometer,
    pub(crate) gps: &'a Gps,
    pub(crate) usbl: &'a Usbl,
    pub(crate) attitude: &'a Attitude,
}

impl NavigationParameters<'_> {
    /// The instruments, without errors where none are asked for; ranges, delay and mounting stay.
    pub(crate) fn instruments(&self) -> Navigation {
        let of = |error: f64| if self.errors { error } else { 0.0 };
        let Self {
            origin,
            earth_field,
            dvl,
            magnetometer,
            gps,
            usbl,
            attitude,
            ..
        } = self;
        let iron = &magnetometer.hard_iron;
        Navigation {
            origin: navigation::Origin {
                latitude: origin.latitude,
                longitude: origin.longitude,
                heading: origin.heading,
            },
            earth_field: navigation::EarthField {
                strength: earth_field.strength,
                declination: earth_field.declination,
                inclination: earth_field.inclination,
            },
            dvl: navigation::Dvl {
                rate: dvl.rate,
                noise: of(dvl.noise),
                water_noise: of(dvl.water_noise),
                scale: of(dvl.scale),
                altitude_noise: of(dvl.altitude_noise),
                range: dvl.range,
                dropout: of(dvl.dropout),
            },
            magnetometer: navigation::Magnetometer {
                rate: magnetometer.rate,
                noise: of(magnetometer.noise),
                hard_iron: [iron.x, iron.y, iron.z].map(of),
            },
            gps: navigation::Gps {
                rate: gps.rate,
                noise: [gps.noise, gps.noise, gps.vertical_noise].map(of),
                bias: [gps.bias, gps.bias, 0.0].map(of),
                antenna: gps.antenna,
            },
            usbl: navigation::Usbl {
                rate: usbl.rate,
                noise: of(usbl.noise),
                relative_noise: of(usbl.relative_noise),
                bias: of(usbl.bias),
                delay: (usbl.delay * 1e9).round() as i64,
                dropout: of(usbl.dropout),
                outlier: of(usbl.outlier),
                outlier_size: of(usbl.outlier_size),
            },
            attitude: navigation::AttitudeReference {
                enabled: attitude.enabled,
                noise: of(attitude.noise),
                heading_noise: of(attitude.heading_noise),
                heading_bias: of(attitude.heading_bias),
            },
        }
    }
}
