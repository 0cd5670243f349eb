//! What the loops are told of the vehicle: the one place where truth becomes feedback.
//!
//! Everything behind it takes a [`Feedback`], so an estimator that fills one instead of
//! [`Feedback::truth`] is all it takes to fly on sensors.

use planesman_msgs::planesman_msgs::msg::VehicleState;

/// The vehicle as the loops see it. Signs and units as in `VehicleState`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Feedback {
    /// m, down.
    pub depth: f64,
    /// m/s, down.
    pub depth_rate: f64,
    /// rad, bow up.
    pub pitch: f64,
    /// rad/s, bow up.
    pub pitch_rate: f64,
    /// rad, starboard side down.
    pub roll: f64,
    /// rad/s.
    pub roll_rate: f64,
    /// rad, from the first course, to starboard.
    pub yaw: f64,
    /// rad/s, to starboard.
    pub yaw_rate: f64,
    /// m/s, through the water, forward.
    pub speed: f64,
}

impl Feedback {
    /// The true state.
    #[must_use]
    pub fn truth(state: &VehicleState) -> Self {
        Self {
            depth: state.depth,
            depth_rate: state.depth_rate,
            pitch: state.pitch,
            pitch_rate: state.pitch_rate,
            roll: state.roll,
            roll_rate: state.roll_rate,
            yaw: state.yaw,
            yaw_rate: state.yaw_rate,
            speed: state.surge,
        }
    }
}
