//! Stamps, frames and covariances of the messages.

use planesman_msgs::{
    builtin_interfaces::msg::Time,
    geometry_msgs::msg::{Quaternion, Vector3},
    std_msgs::msg::Header,
};

use crate::description;

/// Stamp and frame prefix of all messages of one tick.
pub(crate) struct Frames<'a> {
    pub(crate) stamp: Time,
    pub(crate) prefix: &'a str,
}

impl Frames<'_> {
    pub(crate) fn header(&self, frame_id: String) -> Header {
        Header {
            stamp: self.stamp.clone(),
            frame_id,
        }
    }

    pub(crate) fn named(&self, frame: &str) -> String {
        [self.prefix, frame].concat()
    }

    pub(crate) fn odom(&self) -> String {
        self.named("odom")
    }

    pub(crate) fn base_link(&self) -> String {
        self.named(description::BODY)
    }

    /// The fixed frame of `VehicleState`: x along the initial heading, y to starboard, z down from the
    /// surface. REP 105's `map` has z up; REP 103 marks frames like this one by `_ned`.
    pub(crate) fn map_ned(&self) -> String {
        self.named("map_ned")
    }
}

pub(crate) fn vector([x, y, z]: [f64; 3]) -> Vector3 {
    Vector3 { x, y, z }
}

pub(crate) fn quaternion([x, y, z, w]: [f64; 4]) -> Quaternion {
    Quaternion { x, y, z, w }
}

/// Variance of each component of the true state: the smallest value that `robot_localization` accepts unchanged. Variances of 0 would make
/// its filter's matrices singular.
pub(crate) const TRUTH: f64 = 1e-9;

/// The 6 x 6 covariance of the true state.
pub(crate) fn truth() -> [f64; 36] {
    std::array::from_fn(|i| if i % 7 == 0 { TRUTH } else { 0.0 })
}

/// The 3 x 3 covariance of three independent channels with these standard deviations.
pub(crate) fn diagonal(deviations: [f64; 3]) -> [f64; 9] {
    let mut covariance = [0.0; 9];
    for (i, deviation) in deviations.iter().enumerate() {
        covariance[4 * i] = deviation * deviation;
    }
    covariance
}
