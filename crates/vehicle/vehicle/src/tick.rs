//! The integration of the body's motion over a tick.
//!
//! All equations are integrated together with the eighth-order method of Dormand and Prince. A step is never longer than the motion's, and
//! shorter if its estimated error would exceed [`TOLERANCE`]; it may span corners of the actuators' paths (`planes`). Near surface and
//! bottom the path within a step is checked (`depth_limits`).

use planesman_linear::{DORMAND_PRINCE_NODES, dormand_prince_step};

use crate::{
    State,
    attitude::Rotation,
    axis::{Axis, AxisState},
    body::{Body, BodyMotion, Inputs, Positions},
    depth_limits::{Contact, DepthState},
    dynamics::{GeneralisedForce, InverseInertia},
    motion::{Diverged, Motion},
    planes::PlanePath,
    steps::Steps,
};

/// Largest estimated error of a step, sum over the state's components in SI units.
const TOLERANCE: f64 = 4e-12;

/// A longer step \[s\] with a contact is divided: within it the depth is a cubic (`depth_limits`), whose error is not estimated.
const LONGEST_STEP_WITH_A_CONTACT: f64 = 0.01;

/// Quantities that are constant during a tick.
pub(crate) struct Tick<'a> {
    motion: &'a BodyMotion,
    inputs: &'a Inputs<'a>,
    /// External constant load.
    load: GeneralisedForce,
    /// Inverse inertia; it does not depend on the speed.
    inertia: InverseInertia,
    /// Full thrust \[N\]; 0 if the speed is held.
    full_thrust: f64,
}

/// The integrated state, one number per component.
type Vector = [f64; 11];

const DISTANCE: usize = 0;
const ACROSS: usize = 1;
const DEPTH: usize = 2;
const PITCH: usize = 3;
const HEAVE: usize = 4;
const PITCH_RATE: usize = 5;
const SPEED: usize = 6;
const ROLL: usize = 7;
const ROLL_RATE: usize = 8;
const YAW: usize = 9;
const YAW_RATE: usize = 10;

/// Accelerations of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acceleration {
    /// `U'` \[m/s^2\]
    pub surge: f64,
    /// `w'` \[m/s^2\]
    pub heave: f64,
    /// `q'` \[rad/s^2\], derivative of the pitch rate.
    pub pitch: f64,
    /// Vertical acceleration of the origin \[m/s^2\], positive down, due to a surface or bottom that holds the body at its depth; the other
    /// accelerations do not include it.
    pub boundary: f64,
}

impl Acceleration {
    /// Acceleration of a body's origin due to `U'` and `w'` alone, forward, right, down \[m/s^2\]: `U' + q w`, `r U - p w`, `w' - q U`.
    #[must_use]
    pub fn of_the_origin(&self, body: &Body) -> [f64; 3] {
        let (u, w) = (body.speed, body.plane.heave);
        let [p, q, r] = body.rates();
        [self.surge + q * w, r * u - p * w, self.heave - q * u]
    }
}

impl BodyMotion {
    /// State after a number of longest steps with `load` and the inputs, which begin at the first step; also the first contact, with its
    /// time from the first step's start.
    ///
    /// # Errors
    /// [`Diverged`], if the state is not finite or outside the range of vehicles.
    pub fn advance(
        &self,
        from: &Body,
        inputs: &Inputs<'_>,
        load: GeneralisedForce,
        steps: u32,
    ) -> Result<(Body, Option<Contact>), Diverged> {
        let mut body = *from;
        if self.drive.is_none() {
            body.speed = self.vertical.derivatives.speed;
        }
        Tick::new(self, inputs, load).advance(&body, steps)
    }

    /// Accelerations of the body at the start of the inputs with `load`; the acceleration by a boundary in contact is separate
    /// (`depth_limits`).
    #[must_use]
    pub fn acceleration(
        &self,
        body: &Body,
        inputs: &Inputs<'_>,
        load: GeneralisedForce,
    ) -> Acceleration {
        Tick::new(self, inputs, load).acceleration(body)
    }
}

impl Motion {
    /// State after a number of longest steps along the plane path, which begins at the first step.
    ///
    /// # Errors
    /// [`Diverged`], if the state is not finite or outside the range of vehicles.
    pub fn advance(
        &self,
        from: &State,
        planes: &PlanePath<'_>,
        steps: u32,
    ) -> Result<State, Diverged> {
        let inputs = Inputs {
            dive_planes: *planes,
            ..Inputs::all(PlanePath::NEUTRAL)
        };
        let body = Body::upright(*from, self.derivatives.speed);
        let (after, _) = BodyMotion::of_the_plane(*self).advance(
            &body,
            &inputs,
            GeneralisedForce::NONE,
            steps,
        )?;
        Ok(after.plane)
    }
}

impl<'a> Tick<'a> {
    pub(crate) fn new(
        motion: &'a BodyMotion,
        inputs: &'a Inputs<'a>,
        load: GeneralisedForce,
    ) -> Self {
        Self {
            inertia: motion.vertical.derivatives.inverse_inertia(),
            full_thrust: motion
                .drive
                .as_ref()
                .map_or(0.0, |drive| drive.propulsion.full_thrust()),
            motion,
            inputs,
            load,
        }
    }

    /// Same as [`BodyMotion::advance`].
    pub(crate) fn advance(
        &self,
        from: &Body,
        steps: u32,
    ) -> Result<(Body, Option<Contact>), Diverged> {
        let longest = self.motion.vertical.step;
        let duration = f64::from(steps) * longest;
        let mut y = vector(from);
        let mut rotation = from.attitude().rotation();
        let mut contact = None;
        let (mut t, mut steps) = (0.0, Steps::new(longest, TOLERANCE));
        while t < duration {
            let (h, is_last) = steps.next(duration - t);
            let inputs = self.inputs.over(t, h, &DORMAND_PRINCE_NODES);
            let (mut next, error) =
                dormand_prince_step(&y, h, &inputs, |inputs, y| self.rates(inputs, &rotation, y));
            let error: f64 = error.iter().map(|error| error.abs()).sum();
            if !steps.accept(h, error) {
                continue;
            }
            check(&next)?;
            if self.motion.drive.is_some() {
                // It does not go astern.
                next[SPEED] = next[SPEED].max(0.0);
            }
            if self.comes_near_a_limit(&y, &next, h) {
                let (depth, touched) = (self.motion.depth_limits).way(
                    self.depth_state(&y),
                    self.depth_state(&next),
                    h,
                );
                if touched.is_some() && h > 1.001 * LONGEST_STEP_WITH_A_CONTACT {
                    steps.wanted = LONGEST_STEP_WITH_A_CONTACT;
                    continue;
                }
                next[DEPTH] = depth;
                contact = contact.or(touched.map(|found| Contact {
                    time: t + found.time,
                    ..found
                }));
            }
            rotation = turned(&rotation, &next);
            y = next;
            t = if is_last { duration } else { t + h };
        }
        Ok((body(&y), contact))
    }

    /// Like [`BodyMotion::acceleration`], at the start of the tick.
    pub(crate) fn acceleration(&self, body: &Body) -> Acceleration {
        let rotation = body.attitude().rotation();
        let [inputs] = self.inputs.over(0.0, 0.0, &[0.0]);
        let rates = self.rates(&inputs, &rotation, &vector(body));
        let mut found = Acceleration {
            surge: rates[SPEED],
            heave: rates[HEAVE],
            pitch: rates[PITCH_RATE],
            boundary: 0.0,
        };
        let (depth_limits, depth) = (self.motion.depth_limits, body.plane.depth);
        let rate = body.depth_rate(self.motion.current);
        if depth_limits.confined_rate(depth, rate) != rate {
            let [_, _, down] = rotation.to_fixed(found.of_the_origin(body));
            found.boundary = -down;
        }
        found
    }

    /// Derivative of the state, whose angles are near `near`.
    // Innermost: in line it is faster by a third.
    #[inline(always)]
    fn rates(&self, inputs: &Positions, near: &Rotation, y: &Vector) -> Vector {
        let motion = self.motion;
        let (depth, speed, w, q) = (y[DEPTH], y[SPEED], y[HEAVE], y[PITCH_RATE]);
        let density = motion.vertical.environment.density;
        let driven;
        let (derivatives, surge) = match &motion.drive {
            None => (&motion.vertical.derivatives, 0.0),
            Some(drive) => {
                driven = drive.derivatives(speed.max(0.0));
                let thrust = self.full_thrust * inputs.thrust;
                let tether = motion.tether.drag_per_square_speed(depth, density);
                let mass = drive.vehicle.mass;
                let surge = drive.propulsion.acceleration(speed, thrust, mass, tether);
                (&driven, surge)
            }
        };
        let u = derivatives.speed;
        let rotation = turned(near, y);
        let tether = GeneralisedForce {
            heave: 0.0,
            pitch: motion.tether.moment(depth, u, density),
        };
        let hull = derivatives.hull_force(w, q, rotation.pitch, motion.vertical.restoring);
        let planes = derivatives.plane_force(inputs.dive_planes, inputs.bow_stern_differential);
        let (w_dot, q_dot) = self
            .inertia
            .accelerations(hull + planes + tether + self.load);
        let [x_dot, y_dot, z_dot] = rotation.to_fixed([u, 0.0, w]);
        let [cx, cy, cz] = motion.current;
        // Without a plant for it an angle stays as it is.
        let turning = |axis: &Option<Axis>, angle, rate, delta| match axis {
            Some(axis) => (rate, axis.acceleration(AxisState { angle, rate }, u, delta)),
            None => (0.0, 0.0),
        };
        let mut dot = [0.0; 11];
        (dot[DISTANCE], dot[ACROSS], dot[DEPTH]) = (x_dot + cx, y_dot + cy, z_dot + cz);
        (dot[PITCH], dot[HEAVE], dot[PITCH_RATE], dot[SPEED]) = (q, w_dot, q_dot, surge);
        (dot[ROLL], dot[ROLL_RATE]) = turning(
            &motion.roll,
            y[ROLL],
            y[ROLL_RATE],
            inputs.roll_differential,
        );
        (dot[YAW], dot[YAW_RATE]) = turning(&motion.yaw, y[YAW], y[YAW_RATE], inputs.rudder);
        dot
    }

    fn depth_state(&self, y: &Vector) -> DepthState {
        body(y).depth_state(self.motion.current)
    }

    /// Whether a limit might be reached within a step of `h`: a bound that does not use the angles.
    fn comes_near_a_limit(&self, from: &Vector, to: &Vector, h: f64) -> bool {
        let BodyMotion {
            depth_limits,
            current: [_, _, down],
            ..
        } = self.motion;
        let fastest = |y: &Vector| y[SPEED].abs() + y[HEAVE].abs() + down.abs();
        let reach = 2.0 * h * fastest(from).max(fastest(to));
        let (a, b) = (from[DEPTH], to[DEPTH]);
        depth_limits.touched(a.min(b) - reach).is_some()
            || depth_limits.touched(a.max(b) + reach).is_some()
    }
}

/// The rotation updated to a state's angles.
#[inline(always)]
fn turned(near: &Rotation, y: &Vector) -> Rotation {
    Rotation {
        roll: near.roll.turned_to(y[ROLL]),
        pitch: near.pitch.turned_to(y[PITCH]),
        yaw: near.yaw.turned_to(y[YAW]),
    }
}

fn vector(body: &Body) -> Vector {
    let plane = body.plane;
    let mut y = [0.0; 11];
    (y[DISTANCE], y[ACROSS], y[DEPTH]) = (plane.distance, body.across, plane.depth);
    (y[PITCH], y[HEAVE], y[PITCH_RATE]) = (plane.pitch, plane.heave, plane.pitch_rate);
    y[SPEED] = body.speed;
    (y[ROLL], y[ROLL_RATE]) = (body.roll.angle, body.roll.rate);
    (y[YAW], y[YAW_RATE]) = (body.yaw.angle, body.yaw.rate);
    y
}

fn body(y: &Vector) -> Body {
    let axis = |angle: usize, rate: usize| AxisState {
        angle: y[angle],
        rate: y[rate],
    };
    Body {
        plane: State {
            distance: y[DISTANCE],
            depth: y[DEPTH],
            pitch: y[PITCH],
            heave: y[HEAVE],
            pitch_rate: y[PITCH_RATE],
        },
        across: y[ACROSS],
        speed: y[SPEED],
        sway: 0.0,
        roll: axis(ROLL, ROLL_RATE),
        yaw: axis(YAW, YAW_RATE),
    }
}

/// Limits of each component, beyond which numbers soon overflow.
static LIMITS: [(&str, f64); 11] = [
    ("distance [m]", 1e9),
    ("distance across [m]", 1e9),
    ("depth [m]", 1e6),
    ("pitch [rad]", 1e6),
    ("heave velocity [m/s]", 1e3),
    ("pitch rate [rad/s]", 1e3),
    ("speed [m/s]", 1e3),
    ("roll [rad]", 1e6),
    ("roll rate [rad/s]", 1e3),
    ("yaw [rad]", 1e9),
    ("yaw rate [rad/s]", 1e3),
];

fn check(y: &Vector) -> Result<(), Diverged> {
    for (&value, (quantity, limit)) in y.iter().zip(&LIMITS) {
        // NaN is not within.
        let within = value.abs() <= *limit;
        if !within {
            return Err(Diverged {
                quantity,
                value,
                limit: *limit,
            });
        }
    }
    Ok(())
}
