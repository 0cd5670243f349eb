//! Program T6 (Brunner, NPS thesis, 1988, App. C, p. 132): the depth controller with the damped-inertia plant, simulated with the controller's
//! own [`DepthLoop`] and [`PitchLoop`].
//!
//! ```text
//! J T'' = Ky delta - By T' - Me sin T      T: pitch, dive-positive; Me = 0 in the program
//! z'    = U sin T                          z: depth
//! J = 0.6 ft lbf s^2, By = 0.06 ft lbf s, Ky = 0.14 ft lbf/rad, U = 1 ft/s
//! Kpz = 0.25 rad/ft, Kpy = 0.7, Kr = 2 s
//! ```
//! The loops use SI with pitch positive bow up; the plant is the program's with `theta = -T`. The integrator is the classical fourth-order
//! Runge-Kutta method with steps of [`STEP`]. The program has no limits; the report states them in the text.

use planesman_control::{DepthLoop, Limit, LimitError, PitchLoop};
use planesman_linear::runge_kutta_step;
use planesman_units::FOOT;

use super::axis::DampedInertia;
use super::pitch::{AXIS, GAINS};

/// Integration step, s.
pub const STEP: f64 = 0.005;
/// Duration of the program, s.
pub const DURATION: f64 = 50.0;
/// `Kpz`, rad/ft.
pub const DEPTH_GAIN: f64 = 0.25;
/// Limit of the pitch command in the report, deg.
pub const PITCH_LIMIT: f64 = 45.0;
/// Limit of the plane angle in the report, deg.
pub const PLANE_LIMIT: f64 = 30.0;

/// State of the vehicle, in the controller's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Pitch, rad, positive bow up.
    pub pitch: f64,
    /// Pitch rate, rad/s, positive bow up.
    pub pitch_rate: f64,
    /// Depth, m, positive down.
    pub depth: f64,
}

/// The program's vehicle: a damped inertia whose path follows its pitch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// Pitch dynamics.
    pub axis: DampedInertia,
    /// `U`, m/s.
    pub speed: f64,
    /// Whether `z' = U T` is used for `z' = U sin T`.
    pub small_angles: bool,
}

impl Default for Plant {
    /// The same as in the program.
    fn default() -> Self {
        Self {
            axis: AXIS,
            speed: FOOT,
            small_angles: false,
        }
    }
}

impl Plant {
    /// Depth rate `z'`, m/s, positive down.
    #[must_use]
    pub fn depth_rate(&self, motion: &Motion) -> f64 {
        match self.small_angles {
            true => -self.speed * motion.pitch,
            false => -self.speed * libm::sin(motion.pitch),
        }
    }

    /// State after `dt` seconds; `planes` returns the plane angle (rad, positive to dive) at each stage.
    #[must_use]
    pub fn after(&self, motion: Motion, dt: f64, planes: impl Fn(&Motion) -> f64) -> Motion {
        let state = [motion.pitch, motion.pitch_rate, motion.depth];
        let at = |&[pitch, pitch_rate, depth]: &[f64; 3]| Motion {
            pitch,
            pitch_rate,
            depth,
        };
        let axis = &self.axis;
        at(&runge_kutta_step(&state, dt, [&(); 3], |(), x| {
            let m = at(x);
            let sine = libm::sin(m.pitch);
            let moment = -axis.plane_moment * planes(&m)
                - axis.damping * m.pitch_rate
                - axis.restoring * sine;
            let climbs = if self.small_angles { m.pitch } else { sine };
            [m.pitch_rate, moment / axis.inertia, -self.speed * climbs]
        }))
    }
}

/// The program with its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Program {
    /// Depth setpoint `ZC`, ft.
    pub setpoint: f64,
    /// Derivative gain `Kdz`, rad s/ft.
    pub derivative: f64,
    /// Whether the limits stated in the text are applied.
    pub limited: bool,
    /// Whether `DERIV` differentiates the setpoint's step as an impulse, after which the vehicle pitches at `T' = Ky Kpy Kdz ZC / J`.
    pub impulse: bool,
    /// Whether `z' = U T` is used.
    pub small_angles: bool,
}

impl Program {
    /// The program as coded, with a setpoint in ft and a `Kdz` in rad s/ft.
    #[must_use]
    pub fn new(setpoint: f64, derivative: f64) -> Self {
        Self {
            setpoint,
            derivative,
            limited: false,
            impulse: false,
            small_angles: false,
        }
    }

    fn plant(&self) -> Plant {
        Plant {
            small_angles: self.small_angles,
            ..Plant::default()
        }
    }

    /// Simulates the program over [`DURATION`].
    ///
    /// # Errors
    /// Those of [`Limit::new`].
    pub fn fly(&self) -> Result<Track, LimitError> {
        let law = Law::of(self)?;
        let plant = self.plant();
        let mut motion = Motion::default();
        if self.impulse {
            let dive_rate = AXIS.plane_moment * GAINS.p * self.derivative * self.setpoint;
            motion.pitch_rate = -dive_rate / AXIS.inertia;
        }
        let steps = (DURATION / STEP).round() as usize;
        let mut motions = Vec::with_capacity(steps + 1);
        motions.push(motion);
        for _ in 0..steps {
            motion = plant.after(motion, STEP, |m| law.at(m, plant.depth_rate(m)).planes);
            motions.push(motion);
        }
        Ok(Track {
            setpoint: self.setpoint,
            motions,
        })
    }

    /// First command after the setpoint's step, with the vehicle at rest.
    ///
    /// # Errors
    /// Those of [`Limit::new`].
    pub fn first_command(&self) -> Result<Command, LimitError> {
        self.command(Motion::default())
    }

    /// Command of the loops for a state.
    ///
    /// # Errors
    /// Those of [`Limit::new`].
    pub fn command(&self, motion: Motion) -> Result<Command, LimitError> {
        let depth_rate = Plant::default().depth_rate(&motion);
        Ok(Law::of(self)?.at(&motion, depth_rate))
    }
}

/// Command of the loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Pitch command `TC`, rad, positive to dive.
    pub dive_angle: f64,
    /// Plane command `DEL`, rad, positive to dive.
    pub planes: f64,
}

/// Both loops with the planes' limit.
struct Law {
    setpoint: f64,
    depth: DepthLoop,
    pitch: PitchLoop,
    planes: Limit,
}

impl Law {
    fn of(program: &Program) -> Result<Self, LimitError> {
        // Without limits: far beyond anything the program asks for.
        let limit = |degrees: f64| match program.limited {
            true => Limit::new(degrees.to_radians()),
            false => Limit::new(1e3),
        };
        Ok(Self {
            setpoint: program.setpoint * FOOT,
            depth: DepthLoop {
                p: DEPTH_GAIN / FOOT,
                d: program.derivative / FOOT,
                pitch_limit: limit(PITCH_LIMIT)?,
            },
            pitch: PitchLoop {
                p: GAINS.p,
                rate: GAINS.rate,
            },
            planes: limit(PLANE_LIMIT)?,
        })
    }

    fn at(&self, motion: &Motion, depth_rate: f64) -> Command {
        let depth = self
            .depth
            .evaluate(self.setpoint, motion.depth, depth_rate, 0.0);
        let pitch_command = depth.pitch_command.value;
        let terms = self
            .pitch
            .evaluate(pitch_command, motion.pitch, motion.pitch_rate);
        Command {
            dive_angle: -pitch_command,
            planes: self.planes.apply(terms.dive_planes()).value,
        }
    }
}

/// Result of a simulation: a state every [`STEP`].
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    setpoint: f64,
    motions: Vec<Motion>,
}

impl Track {
    /// Depth at the sample nearest to `time` (s), ft.
    #[must_use]
    pub fn depth(&self, time: f64) -> f64 {
        self.motion(time).depth / FOOT
    }

    /// `T` at the sample nearest to `time` (s), deg, positive to dive.
    #[must_use]
    pub fn dive_angle(&self, time: f64) -> f64 {
        -self.motion(time).pitch.to_degrees()
    }

    /// Largest `T`, deg.
    #[must_use]
    pub fn largest_dive_angle(&self) -> f64 {
        let angles = self.motions.iter().map(|m| -m.pitch.to_degrees());
        angles.fold(f64::MIN, f64::max)
    }

    /// Overshoot of the depth, percent of the setpoint; negative if the setpoint is not reached.
    #[must_use]
    pub fn overshoot(&self) -> f64 {
        100.0 * (self.shares().fold(f64::MIN, f64::max) - 1.0)
    }

    /// Time of the first sample at which this fraction of the setpoint is reached, s.
    #[must_use]
    pub fn reached(&self, share: f64) -> Option<f64> {
        let index = self.shares().position(|s| s >= share)?;
        Some(index as f64 * STEP)
    }

    /// First maximum of the depth: time (s), and depth as a fraction of the setpoint.
    #[must_use]
    pub fn first_maximum(&self) -> Option<(f64, f64)> {
        self.turn(0, |before, now, after| before < now && now >= after)
    }

    /// First minimum of the depth after the first maximum: time (s), and depth as a fraction of the setpoint.
    #[must_use]
    pub fn first_dip(&self) -> Option<(f64, f64)> {
        let (time, _) = self.first_maximum()?;
        self.turn(self.index(time), |before, now, after| {
            before > now && now <= after
        })
    }

    /// Largest deviation from the setpoint after `time`, percent of the setpoint.
    #[must_use]
    pub fn deviation_since(&self, time: f64) -> f64 {
        let deviations = self
            .shares()
            .skip(self.index(time))
            .map(|s| (s - 1.0).abs());
        100.0 * deviations.fold(0.0, f64::max)
    }

    fn shares(&self) -> impl Iterator<Item = f64> {
        self.motions
            .iter()
            .map(|m| m.depth / (self.setpoint * FOOT))
    }

    /// First sample after `from` for which `is_turn` of its neighbours and itself is true.
    fn turn(&self, from: usize, is_turn: impl Fn(f64, f64, f64) -> bool) -> Option<(f64, f64)> {
        let shares: Vec<f64> = self.shares().collect();
        let after = shares[from..]
            .windows(3)
            .position(|w| is_turn(w[0], w[1], w[2]))?;
        let index = from + after + 1;
        Some((index as f64 * STEP, shares[index]))
    }

    fn index(&self, time: f64) -> usize {
        ((time / STEP).round() as usize).min(self.motions.len() - 1)
    }

    /// State at the sample nearest to `time` (s).
    #[must_use]
    pub fn motion(&self, time: f64) -> Motion {
        self.motions[self.index(time)]
    }
}
