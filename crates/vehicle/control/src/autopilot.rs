//! The dive autopilot: the report's loops with the additions that a sampled, limited, switched controller needs.
//!
//! ```text
//! depth:  theta_c = -limit(Kpz e_z + I_z + Kdz d),   d = lag(-dz/dt), or lag(d(z_c - z)/dt)
//! pitch:  law     = -Kpy (theta_c - theta) + I_y + Kr q
//! planes: delta   = rate limit(limit(law + transfer + test signals))
//! ```
//! - The derivative acts on the measurement, as in program T6, or on the error; with or without a filter.
//! - The integrals `I_z`, `I_y`, which the report does not have, are protected from wind-up ([`crate::integral`]).
//! - **Bumpless transfer**: when the mode changes, `transfer` begins at the loops' last command minus the command of the new law, and
//!   decays with its time constant. So at the tick of a change, the loops' command equals the last command to within rounding, wherever the vehicle
//!   is. Until the next tick the transfer changes by at most its size times `dt / time`. Switching off takes effect at once.
//! - Anti-windup of the pitch integral uses the plane limit; anti-windup of the depth integral uses the pitch limit.
//!
//! With integrals, filter, rate limits and transfer at 0 it is the report's law, bit for bit.

use crate::depth_loop::{DepthLoop, DepthTerms};
use crate::feedback::Feedback;
use crate::integral::{AntiWindup, Integral};
use crate::lag::{Lag, faded};
use crate::limits::{Limit, Limited, bounded, slewed};
use crate::pitch_loop::{PitchLoop, PitchTerms};

/// The loops that are closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Mode {
    /// No loop is closed: planes, rudder and thrust are neutral.
    Off,
    /// No loop commands the planes: they follow the test signals.
    OpenLoop,
    /// Pitch.
    Pitch,
    /// Depth.
    Depth,
    /// No loop commands the planes: the thrusters hold position, depth and heading.
    Hover,
}

/// The gains at a tick: fixed, or from a source that follows the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Gains {
    /// The outer loop.
    pub depth: DepthLoop,
    /// `Kiz`, rad/(m s): dive angle per metre of depth error and second.
    pub depth_i: f64,
    /// The inner loop.
    pub pitch: PitchLoop,
    /// `Kiy`, 1/s: plane angle per pitch error and second.
    pub pitch_i: f64,
}

/// The signal for the depth loop's derivative.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Derivative {
    /// The depth: a step of the setpoint causes no impulse.
    Measurement,
    /// The error.
    Error,
}

/// All settings of the dive autopilot except its gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DiveRules {
    /// The signal of the derivative.
    pub derivative: Derivative,
    /// Time constant of the derivative's filter, s; 0 for no filter.
    pub derivative_filter: f64,
    /// The largest integral term of the dive angle, rad.
    pub depth_i_limit: Limit,
    /// The largest integral term of the planes, rad.
    pub pitch_i_limit: Limit,
    /// The anti-windup strategy.
    pub anti_windup: AntiWindup,
    /// The largest plane angle, rad.
    pub planes_limit: Limit,
    /// The planes' largest rate, rad/s; 0 for no limit.
    pub planes_rate_limit: f64,
    /// Time constant of the transfer between modes, s; 0 for a step.
    pub transfer_time: f64,
}

/// The setpoints and test signals at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DiveSetpoints {
    /// The loops that are closed.
    pub mode: Mode,
    /// The depth to hold, m, in mode depth.
    pub depth: f64,
    /// The pitch to hold, rad, in mode pitch.
    pub pitch: f64,
    /// Test signals on the planes, rad.
    pub signal: f64,
}

/// The command of the dive planes, and every term that led to it; the terms of an open loop are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct DiveTerms {
    /// The outer loop.
    pub depth: DepthTerms,
    /// `I_z`, rad, bow down positive.
    pub depth_i: f64,
    /// `theta_c`, rad, bow up positive, after its limit.
    pub pitch_command: Limited,
    /// The inner loop.
    pub pitch: PitchTerms,
    /// `I_y`, rad of plane, dive positive.
    pub pitch_i: f64,
    /// The remainder of the step that a change of mode would have caused, rad of plane.
    pub transfer: f64,
    /// `delta`, rad, dive positive, after limit and rate limit; and whether one of the limits acts.
    pub planes: Limited,
}

/// The state of the dive autopilot.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Autopilot {
    /// The mode of the last tick; `None` before the first.
    mode: Option<Mode>,
    /// The depth setpoint of the last tick, m.
    depth_setpoint: Option<f64>,
    depth_derivative: Lag,
    depth_integral: Integral,
    pitch_integral: Integral,
    /// The remainder of the step that a change of mode would have caused, rad.
    transfer: f64,
    /// The loops' command at the last tick, without test signals, rad.
    loops: f64,
    /// The commanded plane angle at the last tick, rad.
    planes: f64,
}

impl Autopilot {
    /// Records that the planes have been set to neutral: the loops start from there without a bump, with empty integrals.
    pub(crate) fn neutralised(&mut self) {
        *self = Self {
            mode: Some(Mode::Off),
            ..Self::default()
        };
    }

    /// Whether this tick's mode differs from the last tick's.
    #[must_use]
    pub(crate) fn changes_to(&self, mode: Mode) -> bool {
        self.mode != Some(mode)
    }

    /// The law: the plane command `dt` seconds after the last tick.
    pub(crate) fn step(
        &mut self,
        (gains, rules): (&Gains, &DiveRules),
        setpoints: DiveSetpoints,
        feedback: &Feedback,
        dt: f64,
    ) -> DiveTerms {
        let mode = setpoints.mode;
        let changed = self.changes_to(mode);
        if changed {
            self.depth_setpoint = None;
            self.depth_derivative = Lag::default();
            self.depth_integral = Integral::default();
            self.pitch_integral = Integral::default();
        }
        let mut terms = DiveTerms::default();

        // theta_c = -limit(Kpz e_z + I_z + Kdz d)
        if mode == Mode::Depth {
            let rate = self.depth_derivative(rules, setpoints.depth, feedback.depth_rate, dt);
            terms.depth_i = self.depth_integral.after(dt, rules.depth_i_limit);
            let (z_c, z) = (setpoints.depth, feedback.depth);
            terms.depth = gains.depth.evaluate(z_c, z, rate, terms.depth_i);
            terms.pitch_command = terms.depth.pitch_command;
            let drive = bounded(gains.depth_i * terms.depth.error);
            let excess = terms.depth.dive_angle + terms.pitch_command.value;
            self.depth_integral.lead(drive, excess, rules.anti_windup);
        } else if mode == Mode::Pitch {
            terms.pitch_command = gains.depth.pitch_limit.apply(setpoints.pitch);
        }

        // law = -Kpy (theta_c - theta) + Kr q + I_y
        if matches!(mode, Mode::Depth | Mode::Pitch) {
            let theta_c = terms.pitch_command.value;
            terms.pitch = gains
                .pitch
                .evaluate(theta_c, feedback.pitch, feedback.pitch_rate);
            terms.pitch_i = self.pitch_integral.after(dt, rules.pitch_i_limit);
        }
        let law = terms.pitch.dive_planes() + terms.pitch_i;

        // delta = rate limit(limit(law + transfer + test signals))
        terms.transfer = match self.mode {
            _ if matches!(mode, Mode::Off | Mode::Hover) || rules.transfer_time == 0.0 => 0.0,
            Some(_) if changed => bounded(self.loops - law),
            _ => faded(self.transfer, rules.transfer_time, dt),
        };
        let loops = bounded(law + terms.transfer);
        let wanted = match mode {
            Mode::Off | Mode::Hover => 0.0,
            _ => bounded(loops + setpoints.signal),
        };
        let limited = rules.planes_limit.apply(wanted);
        // From within the limit, which may have been narrowed since the last tick.
        let from = rules.planes_limit.apply(self.planes).value;
        let planes = slewed(from, limited.value, rules.planes_rate_limit, dt);
        terms.planes = Limited {
            value: planes,
            at_limit: limited.at_limit || planes != limited.value,
        };
        let drive = bounded(-gains.pitch_i * terms.pitch.error);
        self.pitch_integral
            .lead(drive, wanted - planes, rules.anti_windup);

        self.mode = Some(mode);
        self.transfer = terms.transfer;
        self.loops = rules.planes_limit.apply(loops).value;
        self.planes = planes;
        terms
    }

    /// `-d`: the filtered rate of the depth, or of the depth minus its setpoint, m/s.
    fn depth_derivative(&mut self, rules: &DiveRules, setpoint: f64, rate: f64, dt: f64) -> f64 {
        let setpoint_rate = match (rules.derivative, self.depth_setpoint.replace(setpoint)) {
            (Derivative::Error, Some(last)) if dt > 0.0 => bounded((setpoint - last) / dt),
            _ => 0.0,
        };
        let rate = bounded(rate - setpoint_rate);
        self.depth_derivative
            .after(rate, rules.derivative_filter, dt)
    }
}
