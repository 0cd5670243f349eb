//! From the axes of `odom` to latitude and longitude, with the plane tangent to the WGS 84 ellipsoid at the origin.
//!
//! ```text
//! N = a / sqrt(1 - e^2 sin^2 phi)
//! X = (N cos phi) - n sin phi + u cos phi,  Y = e,  Z = N (1 - e^2) sin phi + n cos phi + u sin phi
//! ```
//!
//! (e, n, u: east, north, up; X towards the origin's meridian). Inverse by Bowring's formula (Survey Review 23, 1976); its error within 10
//! km of the ellipsoid is below 1e-9 m.

use std::f64::consts::{FRAC_PI_2, PI};

use planesman_parameters::Parameters;

/// Semi-major axis \[m\] and flattening of WGS 84.
const WGS_84: (f64, f64) = (6_378_137.0, 1.0 / 298.257_223_563);

/// Position of `odom` on the earth.
///
/// Its parameters are `environment.origin.*`.
#[derive(Clone, Copy, Debug, PartialEq, Parameters)]
pub struct Origin {
    /// Latitude of the frame odom's origin, positive north; Monterey Bay.
    #[parameter(default = 36.7, unit = "deg", positive = "north", range = -90.0..=90.0)]
    pub latitude: f64,
    /// Longitude of the frame odom's origin, positive east; Monterey Bay.
    #[parameter(default = -122.0, unit = "deg", positive = "east", range = -180.0..=180.0)]
    pub longitude: f64,
    /// True azimuth of the initial heading, odom's x axis, from north to the east. At its default, east, odom and map have the axes east,
    /// north, up.
    #[parameter(default = FRAC_PI_2, unit = "rad", range = -PI..=2.0 * PI)]
    pub heading: f64,
}

/// A position on the earth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Geodetic {
    /// \[deg\], positive north.
    pub latitude: f64,
    /// \[deg\], positive east, in \[-180, 180).
    pub longitude: f64,
    /// Above the ellipsoid \[m\].
    pub altitude: f64,
}

impl Origin {
    /// A position in `odom` \[m\], in the axes east, north, up.
    pub(super) fn east_north_up(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let (sin, cos) = libm::sincos(self.heading);
        [x * sin - y * cos, x * cos + y * sin, z]
    }

    /// The position at distances east, north and up \[m\] of the origin, which is on the ellipsoid.
    pub(super) fn geodetic(&self, [east, north, up]: [f64; 3]) -> Geodetic {
        let (a, flattening) = WGS_84;
        let b = a * (1.0 - flattening);
        let e2 = flattening * (2.0 - flattening);
        let (sin, cos) = libm::sincos(self.latitude.to_radians());
        let n = a / (1.0 - e2 * sin * sin).sqrt();
        let x = (n + up) * cos - north * sin;
        let z = (n * (1.0 - e2) + up) * sin + north * cos;

        let from_axis = libm::hypot(x, east);
        let (sin, cos) = libm::sincos(libm::atan2(z * a, from_axis * b));
        let latitude = libm::atan2(
            z + e2 / (1.0 - e2) * b * sin.powi(3),
            from_axis - e2 * a * cos.powi(3),
        );
        let (sin, cos) = libm::sincos(latitude);
        let longitude = self.longitude + libm::atan2(east, x).to_degrees();
        Geodetic {
            latitude: latitude.to_degrees(),
            longitude: (longitude + 180.0).rem_euclid(360.0) - 180.0,
            altitude: from_axis * cos + z * sin - a * (1.0 - e2 * sin * sin).sqrt(),
        }
    }

    /// Angle from east to the x axis of `odom`, about up \[rad\].
    pub(super) fn from_east(heading: f64) -> f64 {
        FRAC_PI_2 - heading
    }
}
