//! A tick of the body's motion, step by step.
//!
//! Within a step speed, roll and course are taken first, to its middle and to its end; the
//! vertical plane then takes them, the planes and the loads at the three times of the Runge-Kutta method.
//!
//! The inverse of the inertias is computed once per tick. The planes' load, the sines of roll and course, and
//! the derivatives at the speed are computed once per time; the end of one step is the start of the next.

use planesman_linear::runge_kutta_step;

use crate::{
    State,
    attitude::{Angle, Rotation},
    axis::Turn,
    body::{Body, BodyMotion, Drive, Inputs, Turning},
    dynamics::{InverseInertia, Load},
    motion::{Diverged, Motion},
    planes::PlanePath,
    tank::Contact,
    vehicle::Derivatives,
};

/// The quantities that are constant throughout a tick.
pub(crate) struct Tick<'a> {
    motion: &'a BodyMotion,
    inputs: &'a Inputs<'a>,
    /// From outside, held.
    load: Load,
    /// Neither inertia depends on the speed.
    inertia: InverseInertia,
    /// \[N\]; 0 where the speed is held.
    full_thrust: f64,
}

/// Speed, roll and course: the motion apart from the vertical plane.
#[derive(Clone, Copy)]
struct Apart {
    speed: f64,
    roll: Turn,
    course: Turn,
}

impl Apart {
    fn of(body: &Body) -> Self {
        Self {
            speed: body.speed,
            roll: body.roll,
            course: body.course,
        }
    }
}

/// The inputs of the vertical plane at one time.
#[derive(Clone, Copy)]
struct Outside {
    /// \[rad\], both pairs of planes together.
    dive_planes: f64,
    /// \[rad\], the pairs against each other.
    differential: f64,
    roll: Angle,
    yaw: Angle,
}

/// How the body's velocities change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acceleration {
    /// `U'` \[m/s^2\]
    pub surge: f64,
    /// `w'` \[m/s^2\]
    pub heave: f64,
    /// `q'` \[rad/s^2\], of the pitch angle's rate.
    pub pitch: f64,
    /// The acceleration that surface or bottom adds to the origin's \[m/s^2\], straight down, while it holds the
    /// body at its depth; the velocities above do not know of it.
    pub boundary: f64,
}

impl Acceleration {
    /// The acceleration of a body's origin by `U'` and `w'` alone, forward, right, down \[m/s^2\]:
    /// `U' + q w`, `r U - p w`, `w' - q U`.
    #[must_use]
    pub fn of_the_origin(&self, body: &Body) -> [f64; 3] {
        let (u, w) = (body.speed, body.plane.heave);
        let [p, q, r] = body.rates();
        [self.surge + q * w, r * u - p * w, self.heave - q * u]
    }
}

impl BodyMotion {
    /// Where so many steps lead under the inputs, which start with the first, and `load`; and
    /// the first contact on the way, its time from the first step's start.
    ///
    /// # Errors
    /// [`Diverged`] in place of a state that is not finite or no vehicle's.
    pub fn advance(
        &self,
        from: &Body,
        inputs: &Inputs<'_>,
        load: Load,
        steps: u32,
    ) -> Result<(Body, Option<Contact>), Diverged> {
        let mut body = *from;
        if self.drive.is_none() {
            body.speed = self.vertical.derivatives.speed;
        }
        Tick::new(self, inputs, load).advance(&body, steps)
    }

    /// How the body's velocities change at the start of the inputs, under `load`; a boundary that
    /// it is in contact with is given apart (`tank`).
    #[must_use]
    pub fn acceleration(&self, body: &Body, inputs: &Inputs<'_>, load: Load) -> Acceleration {
        Tick::new(self, inputs, load).acceleration(body)
    }
}

impl Motion {
    /// The state after so many steps along the plane path, which starts with the first.
    ///
    /// # Errors
    /// [`Diverged`] in place of a state that is not finite or no vehicle's.
    pub fn advance(
        &self,
        from: &State,
        planes: &PlanePath<'_>,
        steps: u32,
    ) -> Result<State, Diverged> {
        let neutral = PlanePath::NEUTRAL;
        let inputs = Inputs {
            dive_planes: *planes,
            bow_stern_differential: neutral,
            roll_differential: neutral,
            rudder: neutral,
            thrust: neutral,
        };
        let body = Body::upright(*from, self.derivatives.speed);
        let (after, _) =
            BodyMotion::of_the_plane(*self).advance(&body, &inputs, Load::NONE, steps)?;
        Ok(after.plane)
    }
}

impl<'a> Tick<'a> {
    pub(crate) fn new(motion: &'a BodyMotion, inputs: &'a Inputs<'a>, load: Load) -> Self {
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

    /// As [`BodyMotion::advance`].
    pub(crate) fn advance(
        &self,
        from: &Body,
        steps: u32,
    ) -> Result<(Body, Option<Contact>), Diverged> {
        let h = self.motion.vertical.step;
        let tank = &self.motion.tank;
        let mut body = *from;
        let mut contact = None;
        let mut outside = self.outside_at_the_start(from);
        let mut pitch = Angle::new(from.plane.pitch);
        for k in 0..steps {
            let t = f64::from(k) * h;
            let (mut next, at_the_end) = self.step(&body, &outside, pitch, t);
            check(&next)?;
            if contact.is_none() && self.comes_near_a_limit(&body, &next) {
                let current = self.motion.current;
                contact = tank
                    .contact(body.sounding(current), next.sounding(current), h)
                    .map(|found| Contact {
                        time: t + found.time,
                        ..found
                    });
            }
            next.plane.depth = tank.confined(next.plane.depth);
            pitch = pitch.turned_to(next.plane.pitch);
            (body, outside) = (next, at_the_end);
        }
        Ok((body, contact))
    }

    /// As [`BodyMotion::acceleration`], at the start of the tick.
    pub(crate) fn acceleration(&self, body: &Body) -> Acceleration {
        let outside = self.outside_at_the_start(body);
        let derivatives = self.motion.derivatives(body);
        let near = Angle::new(body.plane.pitch);
        let [.., heave, pitch] = self.rates(&derivatives, &outside, near, &vector(body));
        let mut found = Acceleration {
            surge: self.motion.drive.as_ref().map_or(0.0, |drive| {
                let thrust = self.full_thrust * self.inputs.thrust.at(0.0);
                drive.propulsion.acceleration(
                    body.speed,
                    thrust,
                    drive.vehicle.mass,
                    self.tether_drag(body.plane.depth),
                )
            }),
            heave,
            pitch,
            boundary: 0.0,
        };
        let (tank, depth) = (self.motion.tank, body.plane.depth);
        let rate = body.depth_rate(self.motion.current);
        if tank.confined_rate(depth, rate) != rate {
            let [_, _, down] = body.attitude().to_fixed(found.of_the_origin(body));
            found.boundary = -down;
        }
        found
    }

    /// One step from `t`, and what the vertical plane sees at its end. `near` is the body's pitch.
    fn step(&self, from: &Body, at_the_start: &Outside, near: Angle, t: f64) -> (Body, Outside) {
        let h = self.motion.vertical.step;
        let depth = from.plane.depth;
        let start = Apart::of(from);
        let middle = self.half_step(start, depth, t);
        let end = self.half_step(middle, depth, t + 0.5 * h);
        let in_the_middle = self.outside(at_the_start, &middle, t + 0.5 * h);
        let at_the_end = self.outside(&in_the_middle, &end, t + h);
        let driven;
        let [d0, d1, d2] = match &self.motion.drive {
            None => [&self.motion.vertical.derivatives; 3],
            Some(drive) => {
                driven = [start, middle, end].map(|apart| drive.derivatives(apart.speed));
                driven.each_ref()
            }
        };
        let [distance, across, depth, pitch, heave, pitch_rate] = runge_kutta_step(
            &vector(from),
            h,
            [
                &(d0, at_the_start),
                &(d1, &in_the_middle),
                &(d2, &at_the_end),
            ],
            |(derivatives, outside), y| self.rates(derivatives, outside, near, y),
        );
        let plane = State {
            distance,
            depth,
            pitch,
            heave,
            pitch_rate,
        };
        let Apart {
            speed,
            roll,
            course,
        } = end;
        let body = Body {
            plane,
            across,
            speed,
            roll,
            course,
        };
        (body, at_the_end)
    }

    /// Half a step on from `t`, at a depth, what moves them held at its mean.
    #[inline(always)]
    fn half_step(&self, from: Apart, depth: f64, t: f64) -> Apart {
        let (motion, inputs) = (self.motion, self.inputs);
        let half = 0.5 * motion.vertical.step;
        let mean = t + 0.5 * half;
        let speed = match &motion.drive {
            Some(Drive {
                propulsion,
                vehicle,
                ..
            }) => {
                let thrust = self.full_thrust * inputs.thrust.at(mean);
                let tether = self.tether_drag(depth);
                propulsion.speed_after(from.speed, half, thrust, vehicle.mass, tether)
            }
            None => from.speed,
        };
        let mean_speed = 0.5 * (from.speed + speed);
        let turned = |turning: &Option<Turning>, turn: Turn, path: &PlanePath<'_>| match turning {
            Some(turning) => turning.half_step(turn, mean_speed, path.at(mean)),
            None => turn,
        };
        Apart {
            speed,
            roll: turned(&motion.roll, from.roll, &inputs.roll_differential),
            course: turned(&motion.course, from.course, &inputs.rudder),
        }
    }

    /// The inputs of the vertical plane at the start of the tick.
    fn outside_at_the_start(&self, body: &Body) -> Outside {
        let level = Outside {
            dive_planes: 0.0,
            differential: 0.0,
            roll: Angle::new(body.roll.angle),
            yaw: Angle::new(body.course.angle),
        };
        self.outside(&level, &Apart::of(body), 0.0)
    }

    /// The inputs of the vertical plane at `t`, a little after those of an earlier time.
    #[inline(always)]
    fn outside(&self, before: &Outside, apart: &Apart, t: f64) -> Outside {
        Outside {
            dive_planes: self.inputs.dive_planes.at(t),
            differential: self.inputs.bow_stern_differential.at(t),
            roll: before.roll.turned_to(apart.roll.angle),
            yaw: before.yaw.turned_to(apart.course.angle),
        }
    }

    /// The rate of change of [`vector`], whose pitch is near another.
    // Innermost: in line it is faster by a third.
    #[inline(always)]
    fn rates(
        &self,
        derivatives: &Derivatives,
        outside: &Outside,
        near: Angle,
        &[_, _, depth, pitch, w, q]: &[f64; 6],
    ) -> [f64; 6] {
        let motion = self.motion;
        let u = derivatives.speed;
        let rotation = Rotation {
            roll: outside.roll,
            pitch: near.turned_to(pitch),
            yaw: outside.yaw,
        };
        let density = motion.vertical.environment.density;
        let tether = Load {
            heave: 0.0,
            pitch: motion.tether.moment(depth, u, density),
        };
        let hull = derivatives.hull_load(w, q, rotation.pitch, motion.vertical.restoring);
        let planes = derivatives.plane_load(outside.dive_planes, outside.differential);
        let (w_dot, q_dot) = self
            .inertia
            .accelerations(hull + planes + tether + self.load);
        let [x_dot, y_dot, z_dot] = rotation.to_fixed([u, 0.0, w]);
        let [cx, cy, cz] = motion.current;
        [x_dot + cx, y_dot + cy, z_dot + cz, q, w_dot, q_dot]
    }

    /// Per square of the speed \[kg/m\], at a depth \[m\].
    fn tether_drag(&self, depth: f64) -> f64 {
        let density = self.motion.vertical.environment.density;
        self.motion.tether.drag_per_square_speed(depth, density)
    }

    /// Whether a limit could have been reached within the step: a bound without the angles.
    fn comes_near_a_limit(&self, from: &Body, to: &Body) -> bool {
        let BodyMotion {
            tank,
            current: [_, _, down],
            ..
        } = self.motion;
        let fastest = |b: &Body| b.speed.abs() + b.plane.heave.abs() + down.abs();
        let reach = 2.0 * self.motion.vertical.step * fastest(from).max(fastest(to));
        let (a, b) = (from.plane.depth, to.plane.depth);
        tank.touched(a.min(b) - reach).is_some() || tank.touched(a.max(b) + reach).is_some()
    }
}

/// The state that the Runge-Kutta method integrates.
fn vector(body: &Body) -> [f64; 6] {
    let State {
        distance,
        depth,
        pitch,
        heave,
        pitch_rate,
    } = body.plane;
    [distance, body.across, depth, pitch, heave, pitch_rate]
}

/// Beyond these the motion is no vehicle's, and the numbers are soon none.
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

fn check(body: &Body) -> Result<(), Diverged> {
    let Body {
        plane,
        across,
        speed,
        roll,
        course,
    } = body;
    let values = [
        plane.distance,
        *across,
        plane.depth,
        plane.pitch,
        plane.heave,
        plane.pitch_rate,
        *speed,
        roll.angle,
        roll.rate,
        course.angle,
        course.rate,
    ];
    for (value, (quantity, limit)) in values.into_iter().zip(&LIMITS) {
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
