//! The feedback of the loops: either the true state, or an estimate.
//!
//! All loops use a [`Feedback`]: the true state, or an estimator's motion in the vertical plane instead ([`Feedback::estimated`]).

use crate::estimator::Estimated;
use planesman_msgs::planesman_msgs::msg::VehicleState;

/// The vehicle's state used by the loops. Signs and units as in `VehicleState`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Feedback {
    /// m, along the initial heading.
    pub x: f64,
    /// m, to starboard of the initial heading.
    pub y: f64,
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
    /// rad, from the initial heading, to starboard.
    pub yaw: f64,
    /// rad/s, to starboard.
    pub yaw_rate: f64,
    /// m/s, through the water, forward.
    pub speed: f64,
}

impl Feedback {
    /// The true state.
    #[must_use]
    pub(crate) fn truth(state: &VehicleState) -> Self {
        Self {
            x: state.distance,
            y: state.cross_track,
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

    /// Replaces depth, pitch, their rates and speed by the estimate; roll and heading remain unchanged.
    #[must_use]
    pub(crate) fn estimated(self, estimated: &Estimated) -> Self {
        let estimate = &estimated.estimate;
        Self {
            depth: estimate.depth,
            depth_rate: estimate.depth_rate,
            pitch: estimate.pitch,
            pitch_rate: estimate.pitch_rate,
            speed: estimated.measured.speed,
            ..self
        }
    }

    /// Whether every number is finite: absurd readings can make an estimate infinite.
    #[must_use]
    pub(crate) fn is_finite(&self) -> bool {
        [
            self.x,
            self.y,
            self.depth,
            self.depth_rate,
            self.pitch,
            self.pitch_rate,
            self.roll,
            self.roll_rate,
            self.yaw,
            self.yaw_rate,
            self.speed,
        ]
        .iter()
        .all(|number| number.is_finite())
    }
}
