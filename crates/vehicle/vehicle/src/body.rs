//! Motion of the whole body over a tick: vertical plane, roll, yaw and speed together.
//!
//! ```text
//! vertical plane:  the equations of `dynamics`                           (w, q, theta, depth)
//! roll, yaw:       the plants of `axis`                                  (angle, rate)
//! speed:           held, or the balance of `propulsion`                  (U)
//! position' = Rz(yaw) Ry(pitch) Rx(roll) (U, 0, w) + current
//! ```
//!
//! The axes are coupled only through the speed and the direction of motion that the attitude gives, the same as in the report (ch. II). There is no
//! sideslip, no roll in a turn and no drag due to turning. `tick` integrates.
//! With all these effects off (constant speed; no roll, rudder, current, bottom, waves or tether) only the motion in the vertical plane remains.

use crate::{
    State, Vehicle,
    attitude::Attitude,
    axis::{Axis, AxisState},
    depth_limits::{DepthLimits, DepthState},
    motion::Motion,
    planes::PlanePath,
    propulsion::Propulsion,
    tether::Tether,
    variant::Variant,
    vehicle::Derivatives,
};

/// State of the whole body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Body {
    /// State of the vertical plane; `distance` is `x` in the fixed frame.
    pub plane: State,
    /// `y` \[m\] in the fixed frame, positive to starboard of the initial heading.
    pub across: f64,
    /// `U` \[m/s\], forward speed through the water.
    pub speed: f64,
    /// `v` \[m/s\], sway velocity through the water, to starboard; 0 for the report's single-axis equations.
    pub sway: f64,
    /// Roll, positive starboard side down.
    pub roll: AxisState,
    /// Yaw from the initial heading, positive to starboard.
    pub yaw: AxisState,
}

impl Body {
    /// An upright body on its initial heading.
    #[must_use]
    pub fn upright(plane: State, speed: f64) -> Self {
        Self {
            plane,
            speed,
            ..Self::default()
        }
    }

    /// The three angles.
    #[must_use]
    pub fn attitude(&self) -> Attitude {
        Attitude {
            roll: self.roll.angle,
            pitch: self.plane.pitch,
            yaw: self.yaw.angle,
        }
    }

    /// Their rates.
    #[must_use]
    pub fn attitude_rates(&self) -> Attitude {
        Attitude {
            roll: self.roll.rate,
            pitch: self.plane.pitch_rate,
            yaw: self.yaw.rate,
        }
    }

    /// `p`, `q`, `r` \[rad/s\] about the body's axes forward, right, down, as rate gyros measure them.
    #[must_use]
    pub fn rates(&self) -> [f64; 3] {
        // `+ 0.0`: no negative zero.
        self.attitude()
            .body_rates(&self.attitude_rates())
            .map(|rate| rate + 0.0)
    }

    /// `z'` \[m/s\], positive down, with `current` \[m/s\] in the fixed frame.
    #[must_use]
    pub fn depth_rate(&self, current: [f64; 3]) -> f64 {
        let [_, _, down] = self
            .attitude()
            .to_fixed([self.speed, self.sway, self.plane.heave]);
        down + current[2]
    }

    /// Depth and depth rate.
    pub(crate) fn depth_state(&self, current: [f64; 3]) -> DepthState {
        DepthState {
            depth: self.plane.depth,
            rate: self.depth_rate(current),
        }
    }
}

/// Positions of the actuators over a tick.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// The dive planes \[rad\], positive dive.
    pub dive_planes: PlanePath<'a>,
    /// Added to the bow planes' angle and subtracted from the stern planes' \[rad\].
    pub bow_stern_differential: PlanePath<'a>,
    /// Added to the starboard bow plane's angle and subtracted from the port one's \[rad\].
    pub roll_differential: PlanePath<'a>,
    /// The rudder \[rad\], positive to starboard.
    pub rudder: PlanePath<'a>,
    /// Thrust as a share of full thrust, in \[-1, 1\].
    pub thrust: PlanePath<'a>,
}

/// Positions of the actuators at one time, in the form of [`Inputs`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Positions {
    pub(crate) dive_planes: f64,
    pub(crate) bow_stern_differential: f64,
    pub(crate) roll_differential: f64,
    pub(crate) rudder: f64,
    pub(crate) thrust: f64,
}

impl<'a> Inputs<'a> {
    /// All actuators on the same path; with [`PlanePath::NEUTRAL`] all neutral.
    #[must_use]
    pub const fn all(path: PlanePath<'a>) -> Self {
        Self {
            dive_planes: path,
            bow_stern_differential: path,
            roll_differential: path,
            rudder: path,
            thrust: path,
        }
    }

    /// Positions at fractions of a step from `start` \[s\] with length `h` \[s\], in the form of [`PlanePath::over`].
    pub(crate) fn over<const N: usize>(
        &self,
        start: f64,
        h: f64,
        shares: &[f64; N],
    ) -> [Positions; N] {
        let dive_planes = self.dive_planes.over(start, h, shares);
        let bow_stern_differential = self.bow_stern_differential.over(start, h, shares);
        let roll_differential = self.roll_differential.over(start, h, shares);
        let rudder = self.rudder.over(start, h, shares);
        let thrust = self.thrust.over(start, h, shares);
        std::array::from_fn(|i| Positions {
            dive_planes: dive_planes[i],
            bow_stern_differential: bow_stern_differential[i],
            roll_differential: roll_differential[i],
            rudder: rudder[i],
            thrust: thrust[i],
        })
    }
}

/// A vehicle driven by thrust.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Thrust and drag.
    pub propulsion: Propulsion,
    /// The vehicle; its derivatives change with the speed.
    pub vehicle: Vehicle,
    /// Changes of its equations.
    pub variant: Variant,
}

impl Drive {
    /// Derivatives at the speed `u` \[m/s\].
    pub(crate) fn derivatives(&self, u: f64) -> Derivatives {
        self.variant.apply(self.vehicle.derivatives(u))
    }
}

/// Parameters of the motion over a tick: vehicle, water, step.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMotion {
    /// The vertical plane at the held speed, and the longest step.
    pub vertical: Motion,
    /// Roll axis; with `None` roll stays constant.
    pub roll: Option<Axis>,
    /// Yaw axis; with `None` yaw stays constant.
    pub yaw: Option<Axis>,
    /// Thrust and drag; `None` if the speed is held at the value for the vertical plane.
    pub drive: Option<Drive>,
    /// Velocity of the water \[m/s\]: forward, right, down in the fixed frame.
    pub current: [f64; 3],
    /// Surface and bottom.
    pub depth_limits: DepthLimits,
    /// Tether.
    pub tether: Tether,
}

impl BodyMotion {
    /// Motion of the vertical plane alone.
    #[must_use]
    pub fn of_the_plane(vertical: Motion) -> Self {
        Self {
            vertical,
            roll: None,
            yaw: None,
            drive: None,
            current: [0.0; 3],
            depth_limits: DepthLimits::default(),
            tether: Tether::default(),
        }
    }

    /// Derivatives at the body's speed.
    #[must_use]
    pub fn derivatives(&self, body: &Body) -> Derivatives {
        match &self.drive {
            Some(drive) => drive.derivatives(body.speed),
            None => self.vertical.derivatives,
        }
    }
}

#[cfg(test)]
mod tests {
    use planesman_linear::runge_kutta_step;
    use planesman_units::FOOT;

    use super::*;
    use crate::{
        Boundary, Contact, Environment, GeneralisedForce, Restoring, vehicle_file::brunner,
    };

    fn vertical(speed: f64, step: f64) -> Motion {
        Motion {
            derivatives: brunner().derivatives(speed),
            restoring: Restoring::Sine,
            environment: Environment {
                density: 999.835,
                gravity: 9.81456,
                atmospheric_pressure: 101_325.0,
            },
            step,
        }
    }

    /// All axes and the propulsion, in still and open water.
    fn whole(step: f64) -> BodyMotion {
        let vehicle = brunner();
        BodyMotion {
            roll: vehicle.roll,
            yaw: vehicle.yaw,
            drive: Some(Drive {
                propulsion: vehicle.propulsion.expect("the report's"),
                vehicle,
                variant: Variant::default(),
            }),
            ..BodyMotion::of_the_plane(vertical(FOOT, step))
        }
    }

    /// The body after `seconds` under four held inputs.
    fn go(
        motion: &BodyMotion,
        from: &Body,
        [dive, roll, rudder, thrust]: [f64; 4],
        seconds: f64,
    ) -> (Body, Option<Contact>) {
        let inputs = Inputs {
            dive_planes: PlanePath::held(&dive),
            bow_stern_differential: PlanePath::held(&0.0),
            roll_differential: PlanePath::held(&roll),
            rudder: PlanePath::held(&rudder),
            thrust: PlanePath::held(&thrust),
        };
        let steps = (seconds / motion.vertical.step).round() as u32;
        motion
            .advance(from, &inputs, GeneralisedForce::NONE, steps)
            .expect("it moves")
    }

    fn deep(speed: f64) -> Body {
        let plane = State {
            depth: 50.0,
            ..State::default()
        };
        Body::upright(plane, speed)
    }

    #[test]
    fn with_all_off_it_is_the_vertical_plane_alone() {
        // Brunner's equations as they stand, without drag, coupling or attitude.
        let motion = vertical(FOOT, 0.001);
        let d = motion.derivatives;
        let mut y = [0.0, 1.0, 0.0, 0.0, 0.0];
        for k in 0..20_000 {
            let delta = if k % 8000 < 4000 { 0.4 } else { -0.3 };
            y = runge_kutta_step(
                &y,
                0.001,
                [&(); 3],
                |(), &[_, _, theta, w, q]: &[f64; 5]| {
                    [
                        d.speed * libm::cos(theta) + w * libm::sin(theta),
                        w * libm::cos(theta) - d.speed * libm::sin(theta),
                        q,
                        (d.z_w * w + d.z_q_plus_m_u * q + d.z_delta * delta) / d.heave_inertia,
                        (d.m_w * w + d.m_q * q + d.m_delta * delta
                            - d.restoring * libm::sin(theta))
                            / d.pitch_inertia,
                    ]
                },
            );
        }
        let start = State {
            depth: 1.0,
            ..State::default()
        };
        let mut body = Body::upright(start, FOOT);
        let held = BodyMotion {
            drive: None,
            ..whole(0.001)
        };
        for k in 0..5 {
            let delta = if k % 2 == 0 { 0.4 } else { -0.3 };
            (body, _) = go(&held, &body, [delta, 0.0, 0.0, 0.0], 4.0);
        }
        for (found, expected) in <[f64; 5]>::from(body.plane).into_iter().zip(y) {
            assert!(
                (found - expected).abs() < 1e-12,
                "{found} is not {expected}"
            );
        }
        assert_eq!((body.across, body.roll, body.yaw), Default::default());
        assert_eq!(body.speed, FOOT);
    }

    #[test]
    fn mirrored_rudder_and_roll_give_the_mirrored_track() {
        let motion = whole(0.01);
        let start = deep(FOOT);
        let (right, _) = go(&motion, &start, [0.1, 0.2, 0.3, 0.2], 30.0);
        let (left, _) = go(&motion, &start, [0.1, -0.2, -0.3, 0.2], 30.0);
        assert_eq!(right.plane, left.plane);
        assert_eq!(right.across, -left.across);
        assert_eq!(right.yaw.angle, -left.yaw.angle);
        assert_eq!(right.roll.angle, -left.roll.angle);
        assert!(right.yaw.angle > 0.0 && right.roll.angle > 0.0);
    }

    /// How far a flight with every input ends from where a fine step leads, in m.
    fn error(of: impl Fn(f64) -> BodyMotion, step: f64) -> f64 {
        let at = |step: f64| go(&of(step), &deep(0.8), [0.2, 0.1, 0.2, 0.7], 8.0).0;
        let (body, exact) = (at(step), at(0.001));
        libm::hypot(
            body.plane.distance - exact.plane.distance,
            body.across - exact.across,
        ) + (body.plane.depth - exact.plane.depth).abs()
    }

    fn at_held_speed(step: f64) -> BodyMotion {
        BodyMotion {
            drive: None,
            ..whole(step)
        }
    }

    #[test]
    fn long_steps_lead_where_short_ones_lead_with_or_without_propulsion() {
        for (what, of) in [("held", at_held_speed as fn(f64) -> _), ("driven", whole)] {
            for step in [0.5, 0.05] {
                let error = error(of, step);
                assert!(error < 1e-9, "{what}, {step} s: {error}");
            }
        }
    }

    #[test]
    fn a_step_across_corners_leads_where_steps_between_them_lead() {
        // Every actuator moves on by samples without any order.
        let samples: Vec<f64> = (0..51)
            .map(|i| 0.2 * f64::from(i * i * 37 % 101) / 100.0)
            .collect();
        let tick = 50_000_000;
        let path = PlanePath::new(&samples, tick, tick).expect("a path");
        let inputs = Inputs::all(path);
        let go = |steps: u32| {
            let mut body = deep(0.8);
            for _ in 0..100 {
                let motion = whole(0.05 / f64::from(steps));
                (body, _) = motion
                    .advance(&body, &inputs, GeneralisedForce::NONE, steps)
                    .expect("it moves");
            }
            body
        };
        let (long, short) = (go(1), go(50));
        for (long, short) in [
            (long.plane.depth, short.plane.depth),
            (long.plane.pitch, short.plane.pitch),
            (long.across, short.across),
            (long.speed, short.speed),
            (long.roll.angle, short.roll.angle),
            (long.yaw.angle, short.yaw.angle),
        ] {
            assert!((long - short).abs() < 1e-8, "{long} is not {short}");
        }
    }

    #[test]
    fn a_held_rudder_turns_the_vehicle_at_the_rate_that_damping_allows() {
        // K / B delta = 0.07 / 0.03 x 0.1 rad/s at 1 ft/s, after some time constants of 10 s.
        let (body, _) = go(
            &at_held_speed(0.05),
            &deep(FOOT),
            [0.0, 0.0, 0.1, 0.0],
            300.0,
        );
        assert!((body.yaw.rate - 0.07 / 0.03 * 0.1).abs() < 1e-9);
        assert!(body.yaw.angle > 0.0, "to starboard");
    }

    #[test]
    fn a_held_roll_differential_heels_the_vehicle_until_the_weight_holds_it() {
        let (body, _) = go(
            &at_held_speed(0.05),
            &deep(FOOT),
            [0.0, 0.1, 0.0, 0.0],
            2000.0,
        );
        // K delta / (W BG) = 0.02 x 0.1 / 0.16333 rad.
        assert!((body.roll.angle - 0.02 * 0.1 / 0.163_333).abs() < 1e-7);
        assert!(body.roll.rate.abs() < 1e-9);
    }

    #[test]
    fn a_thrust_backwards_stops_the_vehicle_and_no_more() {
        let (body, _) = go(&whole(0.05), &deep(0.5), [0.0, 0.0, 0.0, -1.0], 100.0);
        assert_eq!(body.speed, 0.0);
    }

    #[test]
    fn a_vehicle_that_leaves_the_surface_within_a_step_leaves_it_when_it_turns_down() {
        let rising = Body {
            plane: State {
                pitch: 0.05,
                pitch_rate: -0.2,
                ..State::default()
            },
            ..Body::upright(State::default(), FOOT)
        };
        let depth = |step: f64| {
            let (body, contact) = go(&at_held_speed(step), &rising, [0.3, 0.0, 0.0, 0.0], 1.0);
            assert_eq!(contact.expect("it is held").boundary, Boundary::Surface);
            body.plane.depth
        };
        let (long, short) = (depth(0.05), depth(1e-4));
        assert!(
            short > 0.01 && (long - short).abs() < 1e-8,
            "{long} is not {short}"
        );
    }

    #[test]
    fn a_steady_turn_is_a_circle_of_the_speed_over_the_rate() {
        let motion = BodyMotion {
            drive: None,
            ..whole(0.01)
        };
        let (turning, _) = go(&motion, &deep(FOOT), [0.0, 0.0, 0.1, 0.0], 200.0);
        let rate = turning.yaw.rate;
        let half = std::f64::consts::PI / rate;
        let steps = (half / 0.01).round() * 0.01;
        let (opposite, _) = go(&motion, &turning, [0.0, 0.0, 0.1, 0.0], steps);
        let diameter = libm::hypot(
            opposite.plane.distance - turning.plane.distance,
            opposite.across - turning.across,
        );
        assert!((diameter - 2.0 * FOOT / rate).abs() < 1e-4, "{diameter}");
    }

    #[test]
    fn full_thrust_and_the_drag_make_the_design_speed() {
        let (body, _) = go(&whole(0.05), &deep(0.0), [0.0, 0.0, 0.0, 1.0], 300.0);
        assert!((body.speed - 5.0 * FOOT).abs() < 1e-6, "{}", body.speed);
        // A tether holds it back and turns its bow up.
        let towing = BodyMotion {
            tether: Tether {
                diameter: 0.003,
                drag_coefficient: 1.2,
                above: 0.05,
            },
            ..whole(0.05)
        };
        let shallow = Body {
            plane: State {
                depth: 1.0,
                ..State::default()
            },
            ..deep(1.0)
        };
        let (held_back, _) = go(&towing, &shallow, [0.0, 0.0, 0.0, 1.0], 2.0);
        let (free, _) = go(&whole(0.05), &shallow, [0.0, 0.0, 0.0, 1.0], 2.0);
        assert!(held_back.speed < free.speed);
        assert!(held_back.plane.pitch > 0.0 && free.plane.pitch == 0.0);
    }

    #[test]
    fn a_current_carries_the_vehicle_and_changes_nothing_else() {
        let drifting = BodyMotion {
            current: [0.1, -0.2, 0.05],
            ..whole(0.01)
        };
        let input = [0.2, 0.1, 0.2, 0.3];
        let (still, _) = go(&whole(0.01), &deep(FOOT), input, 10.0);
        let (carried, _) = go(&drifting, &deep(FOOT), input, 10.0);
        assert!((carried.plane.distance - still.plane.distance - 1.0).abs() < 1e-9);
        assert!((carried.across - still.across + 2.0).abs() < 1e-9);
        assert!((carried.plane.depth - still.plane.depth - 0.5).abs() < 1e-9);
        assert_eq!(carried.plane.pitch, still.plane.pitch);
        assert_eq!(carried.yaw, still.yaw);
    }

    #[test]
    fn a_diving_vehicle_stops_at_the_bottom_at_the_time_it_gets_there() {
        let time = |step: f64| {
            let motion = BodyMotion {
                depth_limits: DepthLimits { bottom: Some(0.3) },
                drive: None,
                ..whole(step)
            };
            let (body, contact) = go(&motion, &Body::default(), [0.5, 0.0, 0.0, 0.0], 8.0);
            assert_eq!(body.plane.depth, 0.3);
            let contact = contact.expect("it touches");
            assert_eq!(contact.boundary, Boundary::Bottom);
            contact.time
        };
        assert!((time(0.1) - time(0.001)).abs() < 1e-5, "{}", time(0.1));
    }

    #[test]
    fn a_motion_that_blows_up_is_refused() {
        let mut motion = at_held_speed(0.05);
        motion.vertical.derivatives.m_q *= -1.0;
        let inputs = Inputs::all(PlanePath::held(&0.5));
        let refused = motion.advance(&deep(1.5), &inputs, GeneralisedForce::NONE, 10_000);
        let diverged = refused.expect_err("it turns ever faster");
        assert!(!(-diverged.limit..=diverged.limit).contains(&diverged.value));
    }
}
