//! The state in ROS frames.
//!
//! Here: depth down, pitch bow up, body axes forward, right, down. ROS (REP 103, REP 105): `odom`
//! with x forward along the track, y left and z up, its origin at the surface; `base_link`
//! forward, left, up. So
//!
//! ```text
//! position (x, 0, -z)      orientation: about the left-hand y by -theta, (0, -sin(theta/2), 0, cos(theta/2))
//! velocity (U, 0, -w)      angular velocity (0, -q, 0)
//! ```

use crate::{State, vehicle::Derivatives};

/// Where `base_link` is in `odom`, and its velocity in `base_link`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Odometry {
    /// In `odom` \[m\].
    pub position: [f64; 3],
    /// The quaternion (x, y, z, w) that turns `base_link` vectors into `odom`.
    pub orientation: [f64; 4],
    /// In `base_link` \[m/s\].
    pub velocity: [f64; 3],
    /// In `base_link` \[rad/s\].
    pub angular_velocity: [f64; 3],
}

impl Odometry {
    /// The state in ROS frames.
    #[must_use]
    pub fn of(state: &State, derivatives: &Derivatives) -> Self {
        let (sin, cos) = (0.5 * wrapped(state.pitch)).sin_cos();
        Self {
            position: [state.distance, 0.0, -state.depth],
            orientation: [0.0, -sin, 0.0, cos],
            velocity: [derivatives.speed, 0.0, -state.heave],
            angular_velocity: [0.0, -state.pitch_rate, 0.0],
        }
    }
}

/// The same angle in `[-pi, pi]`.
#[must_use]
pub fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if (-PI..=PI).contains(&angle) {
        return angle;
    }
    let turned = (angle + PI).rem_euclid(TAU) - PI;
    turned.clamp(-PI, PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle_file::brunner;

    /// `v` turned by the quaternion: `v + 2 u x (u x v + s v)`.
    fn turned([x, y, z, s]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
        let u = [x, y, z];
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ]
        };
        let inner = cross(u, v);
        let outer = cross(u, std::array::from_fn(|i| inner[i] + s * v[i]));
        std::array::from_fn(|i| v[i] + 2.0 * outer[i])
    }

    #[test]
    fn bow_up_the_forward_axis_points_upwards() {
        let state = State {
            pitch: 0.3,
            ..State::default()
        };
        let odometry = Odometry::of(&state, &brunner().derivatives(0.3));
        let bow = turned(odometry.orientation, [1.0, 0.0, 0.0]);
        assert!((bow[0] - 0.3_f64.cos()).abs() < 1e-15);
        assert!((bow[2] - 0.3_f64.sin()).abs() < 1e-15);
        assert!(odometry.orientation[1] < 0.0);
    }

    #[test]
    fn the_twist_turned_into_odom_is_the_rate_of_the_position() {
        let d = brunner().derivatives(0.3);
        let state = State {
            depth: 2.0,
            pitch: -0.7,
            heave: 0.05,
            ..State::default()
        };
        let odometry = Odometry::of(&state, &d);
        let velocity = turned(odometry.orientation, odometry.velocity);
        assert!((velocity[0] - d.track_speed(&state)).abs() < 1e-15);
        assert!((velocity[2] + d.depth_rate(&state)).abs() < 1e-15);
        assert_eq!(odometry.position[2], -2.0);
    }

    #[test]
    fn angles_are_wrapped_to_half_a_turn_either_way() {
        use std::f64::consts::PI;
        for (angle, expected) in [
            (0.5, 0.5),
            (PI, PI),
            (-PI, -PI),
            (4.0, 4.0 - 2.0 * PI),
            (-7.0, -7.0 + 2.0 * PI),
        ] {
            assert!((wrapped(angle) - expected).abs() < 1e-12, "{angle}");
        }
    }
}
