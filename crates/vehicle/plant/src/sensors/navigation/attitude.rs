//! The attitude and heading reference: orientation of the body relative to east, north, up (REP 103, REP 145).
//!
//! The error is a small rotation about the axes east, north and up. The heading is true, not magnetic.

use std::f64::consts::PI;

use planesman_parameters::Parameters;

use super::geodesy::Origin;
use crate::sensors::noise::{Source, Stream};

/// An attitude and heading reference.
///
/// Its parameters are `sensors.attitude.*`.
#[derive(Clone, Copy, Debug, PartialEq, Parameters)]
pub struct AttitudeReference {
    /// Whether an attitude and heading reference fills the orientation of imu, from the body to east, north, up.
    #[parameter(default = false)]
    pub enabled: bool,
    /// Standard deviation of the error about each horizontal axis; assumed.
    #[parameter(default = 0.002, unit = "rad", range = 0.0..=1.0)]
    pub noise: f64,
    /// Standard deviation of the heading; assumed.
    #[parameter(default = 0.01, unit = "rad", range = 0.0..=1.0)]
    pub heading_noise: f64,
    /// Constant error of the heading, to starboard.
    #[parameter(default = 0.0, unit = "rad", range = -PI..=PI)]
    pub heading_bias: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Memory([Stream; 3]);

impl Memory {
    pub(super) fn new(seed: u64) -> Self {
        Self([0, 1, 2].map(|axis| Stream::new(seed, Source::Attitude(axis))))
    }
}

impl AttitudeReference {
    /// Standard deviations about east, north, up \[rad\].
    pub(crate) fn deviation(&self) -> [f64; 3] {
        [self.noise, self.noise, self.heading_noise]
    }

    /// The quaternion (x, y, z, w) from the body to east, north, up. The input is the quaternion to `odom`, whose x axis points to the
    /// azimuth `heading` \[rad\].
    pub(super) fn read(
        &self,
        orientation: [f64; 4],
        heading: f64,
        memory: &mut Memory,
    ) -> [f64; 4] {
        let normal = memory.0.each_mut().map(Stream::draw);
        let deviation = self.deviation();
        let [x, y, up]: [f64; 3] = std::array::from_fn(|i| deviation[i] * normal[i]);
        let from_east = turn([0.0, 0.0, Origin::from_east(heading)]);
        let error = turn([x, y, up - self.heading_bias]);
        product(error, product(from_east, orientation))
    }
}

/// The quaternion (x, y, z, w) of a rotation about a vector by its length \[rad\].
fn turn(vector: [f64; 3]) -> [f64; 4] {
    let [x, y, z] = vector;
    let angle = libm::hypot(libm::hypot(x, y), z);
    if angle == 0.0 {
        return [0.0, 0.0, 0.0, 1.0];
    }
    let (sin, cos) = libm::sincos(0.5 * angle);
    let share = sin / angle;
    [share * x, share * y, share * z, cos]
}

/// The rotation by `b`, followed by `a`.
fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    let ([ax, ay, az, aw], [bx, by, bz, bw]) = (a, b);
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}
