//! The state in ROS frames.
//!
//! In the models: depth down, pitch bow up, yaw to starboard, frames forward, right, down. ROS (REP 103, REP 105): `odom` with x forward
//! along the initial heading, y left and z up, its origin at the surface; `base_link` forward, left, up. The two frames differ by half a turn about
//! x, so y and z of every vector change their sign, also in the quaternion:
//!
//! ```text
//! position (x, -y, -z)     orientation (q_x, -q_y, -q_z, q_w)
//! velocity (u, -v, -w)     angular velocity (p, -q, -r)
//! ```
//!
//! The velocity is over ground and includes the current. Without roll, turn and current it is `(U, 0, -w)`, and the angular velocity is
//! `(0, -q, 0)`.

use planesman_vehicle::{Body, six_dof::rotation};

/// Pose of `base_link` in `odom`, and its velocity in `base_link`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Odometry {
    /// In `odom` \[m\].
    pub position: [f64; 3],
    /// The quaternion (x, y, z, w) that turns `base_link` vectors into `odom`.
    pub orientation: [f64; 4],
    /// Velocity over ground, in `base_link` \[m/s\].
    pub velocity: [f64; 3],
    /// Velocity through the water, in `base_link` \[m/s\].
    pub through_water: [f64; 3],
    /// Angular velocity in `base_link` \[rad/s\].
    pub angular_velocity: [f64; 3],
}

impl Default for Odometry {
    fn default() -> Self {
        Self::AT_REST
    }
}

impl Odometry {
    /// At rest at the origin of `odom`, parallel to its axes.
    pub(crate) const AT_REST: Self = Self {
        position: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        velocity: [0.0; 3],
        through_water: [0.0; 3],
        angular_velocity: [0.0; 3],
    };

    /// Rotates a vector from `base_link` to `odom`.
    #[must_use]
    pub(crate) fn to_odom(self, v: [f64; 3]) -> [f64; 3] {
        let [x, y, z, w] = self.orientation;
        rotation::to_fixed(&rotation::matrix([w, x, y, z]), v)
    }

    /// Rotates a vector from `odom` to `base_link`.
    #[must_use]
    pub(crate) fn to_body(self, v: [f64; 3]) -> [f64; 3] {
        let [x, y, z, w] = self.orientation;
        rotation::to_body(&rotation::matrix([w, x, y, z]), v)
    }

    /// Converts the state to ROS frames; `current` \[m/s\] is the water's velocity, forward, right, down in the fixed frame.
    #[must_use]
    pub(crate) fn new(body: &Body, current: [f64; 3]) -> Self {
        let attitude = body.attitude();
        let [qx, qy, qz, qw] = attitude.quaternion();
        let drift = attitude.to_body(current);
        let through = [body.speed, body.sway, body.plane.heave];
        Self {
            position: up([body.plane.distance, body.across, body.plane.depth]),
            orientation: [qx, -qy, 0.0 - qz, qw],
            velocity: up(std::array::from_fn(|i| through[i] + drift[i])),
            through_water: up(through),
            angular_velocity: up_rates(attitude.body_rates(&body.attitude_rates())),
        }
    }
}

/// Converts forward, right, down to forward, left, up. (`0 - y` instead of `-y` avoids a negative zero.)
fn up([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, 0.0 - y, -z]
}

/// Converts rates in the same way. (`0 - r` instead of `-r` avoids a negative zero.)
fn up_rates([p, q, r]: [f64; 3]) -> [f64; 3] {
    [p, -q, 0.0 - r]
}

/// The equivalent angle in `[-pi, pi]`.
#[must_use]
pub(crate) fn wrapped(angle: f64) -> f64 {
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
    use planesman_vehicle::{AxisState, State};

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

    fn body() -> Body {
        Body {
            plane: State {
                distance: 3.0,
                depth: 2.0,
                pitch: -0.7,
                heave: 0.05,
                pitch_rate: 0.2,
            },
            across: 0.5,
            speed: 0.3,
            sway: 0.0,
            roll: AxisState {
                angle: 0.2,
                rate: 0.1,
            },
            yaw: AxisState {
                angle: 1.1,
                rate: -0.1,
            },
        }
    }

    #[test]
    fn bow_up_the_forward_axis_points_upwards() {
        let state = State {
            pitch: 0.3,
            ..State::default()
        };
        let odometry = Odometry::new(&Body::upright(state, 0.3), [0.0; 3]);
        let bow = turned(odometry.orientation, [1.0, 0.0, 0.0]);
        assert!((bow[0] - libm::cos(0.3_f64)).abs() < 1e-15);
        assert!((bow[2] - libm::sin(0.3_f64)).abs() < 1e-15);
        assert!(odometry.orientation[1] < 0.0);
    }

    #[test]
    fn bow_to_starboard_the_forward_axis_points_right_of_the_first_course() {
        let mut turning = Body::upright(State::default(), 0.3);
        turning.yaw = AxisState {
            angle: 0.3,
            rate: 0.1,
        };
        let odometry = Odometry::new(&turning, [0.0; 3]);
        let bow = turned(odometry.orientation, [1.0, 0.0, 0.0]);
        assert!((bow[1] + libm::sin(0.3_f64)).abs() < 1e-15, "y is left");
        assert!(
            (odometry.angular_velocity[2] + 0.1).abs() < 1e-15,
            "z is up"
        );
    }

    #[test]
    fn the_twist_turned_into_odom_is_the_velocity_over_ground() {
        let current = [0.1, -0.2, 0.05];
        let odometry = Odometry::new(&body(), current);
        let velocity = turned(odometry.orientation, odometry.velocity);
        let [x, y, z] = body().attitude().to_fixed([0.3, 0.0, 0.05]);
        let expected = [x + 0.1, -(y - 0.2), -(z + 0.05)];
        for (value, expected) in velocity.into_iter().zip(expected) {
            assert!((value - expected).abs() < 1e-15);
        }
        assert_eq!(odometry.position, [3.0, -0.5, -2.0]);
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
