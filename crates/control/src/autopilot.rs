//! The dive autopilot as built: the report's loops with what a sampled, limited, switched controller
//! needs around them.
//!
//! ```text
//! depth:  theta_c = -limit(Kpz e_z + I_z + Kdz d),   d = lag(-dz/dt), or lag(d(z_c - z)/dt)
//! pitch:  law     = -Kpy (theta_c - theta) + I_y + Kr q
//! planes: delta   = rate limit(limit(law + transfer + test signals))
//! ```
//! - The derivative acts on the measurement, as in program T6, or on the error; filtered or not.
//! - The integrals `I_z`, `I_y`, which the report has none of, are kept from winding up
//!   ([`crate::integral`]).
//! - **Bumpless transfer**: when the mode changes, `transfer` begins at what the loops commanded last minus
//!   what the new law asks for, and fades with its time constant. So at the tick of a change the loops'
//!   command is the last one to within rounding, wherever the vehicle is, and until the next tick the
//!   transfer itself moves by no more than its size times `dt / time`. Switching off is at once.
//! - The pitch integral winds against the plane limit, the depth integral against the pitch limit.
//!
//! With integrals, filter, rate limits and transfer at 0 it is the report's law, to the last bit.

use planesman_msgs::planesman_msgs::msg::ControlState;

use crate::depth_loop::DepthLoop;
use crate::feedback::Feedback;
use crate::integral::{AntiWindup, Integral};
use crate::lag::{Lag, faded};
use crate::limits::{Limit, bounded, slewed};
use crate::pitch_loop::PitchLoop;

/// The loops that are closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Mode {
    /// Nothing: planes, rudder and thrust neutral.
    Off,
    /// Nothing by the planes: they follow the test signals.
    OpenLoop,
    /// Pitch.
    Pitch,
    /// Depth.
    Depth,
}

impl Mode {
    /// Its constant in `ControlState`.
    #[must_use]
    pub fn constant(self) -> u8 {
        match self {
            Self::Off => ControlState::MODE_OFF,
            Self::OpenLoop => ControlState::MODE_OPEN_LOOP,
            Self::Pitch => ControlState::MODE_PITCH,
            Self::Depth => ControlState::MODE_DEPTH,
        }
    }
}

/// The gains in force at a tick: fixed, or from whatever follows the vehicle.
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

/// The signal of the depth loop's derivative.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Derivative {
    /// The depth: a step of the setpoint makes no impulse.
    Measurement,
    /// The error.
    Error,
}

/// Everything about the dive autopilot but its gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DiveRules {
    /// The signal of the derivative.
    pub derivative: Derivative,
    /// Time constant of the derivative's filter, s; 0 for none.
    pub derivative_filter: f64,
    /// The largest integral share of the dive angle, rad.
    pub depth_i_limit: Limit,
    /// The largest integral share of the planes, rad.
    pub pitch_i_limit: Limit,
    /// The anti-windup strategy.
    pub anti_windup: AntiWindup,
    /// The largest plane angle, rad.
    pub planes_limit: Limit,
    /// The planes' largest rate, rad/s; 0 for none.
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
    /// The remainder of the step that a change of mode would have made, rad.
    transfer: f64,
    /// The command of the loops at the last tick, without test signals, rad.
    loops: f64,
    /// The planes' angle commanded at the last tick, rad.
    planes: f64,
}

impl Autopilot {
    /// Takes note that the planes have been put to neutral: the loops come back from there without a
    /// bump, with nothing left in their integrals.
    pub(crate) fn neutralised(&mut self) {
        *self = Self {
            mode: Some(Mode::Off),
            ..Self::default()
        };
    }

    /// Whether this tick's mode is another one than the last tick's.
    #[must_use]
    pub(crate) fn changes_to(&self, mode: Mode) -> bool {
        self.mode != Some(mode)
    }

    /// The plane command `dt` seconds after the last tick, and every term that led to it, in the fields of `control`; a loop
    /// that is open leaves its fields as they are.
    pub(crate) fn step(
        &mut self,
        (gains, rules): (&Gains, &DiveRules),
        setpoints: DiveSetpoints,
        feedback: &Feedback,
        dt: f64,
        control: ControlState,
    ) -> ControlState {
        let changed = self.changes_to(setpoints.mode);
        if changed {
            self.depth_setpoint = None;
            self.depth_derivative = Lag::default();
            self.depth_integral = Integral::default();
            self.pitch_integral = Integral::default();
        }
        let control = match setpoints.mode {
            Mode::Off | Mode::OpenLoop => control,
            Mode::Pitch => {
                let command = gains.depth.pitch_limit.apply(setpoints.pitch);
                let outer = ControlState {
                    pitch_command: command.value,
                    pitch_command_limited: command.at_limit,
                    ..control
                };
                self.pitch_law((gains, rules), feedback, dt, outer)
            }
            Mode::Depth => {
                let outer = self.depth_law((gains, rules), setpoints.depth, feedback, dt, control);
                self.pitch_law((gains, rules), feedback, dt, outer)
            }
        };
        let law = control.planes_p + control.planes_rate + control.planes_i;
        self.transfer = match self.mode {
            _ if setpoints.mode == Mode::Off || rules.transfer_time == 0.0 => 0.0,
            Some(_) if changed => bounded(self.loops - law),
            _ => faded(self.transfer, rules.transfer_time, dt),
        };
        self.mode = Some(setpoints.mode);
        let loops = bounded(law + self.transfer);
        let wanted = match setpoints.mode {
            Mode::Off => 0.0,
            _ => bounded(loops + setpoints.signal),
        };
        let limited = rules.planes_limit.apply(wanted);
        // From within the limit, which may have been narrowed since the last tick.
        let from = rules.planes_limit.apply(self.planes).value;
        let planes = slewed(from, limited.value, rules.planes_rate_limit, dt);
        self.pitch_integral.lead(
            bounded(-gains.pitch_i * control.pitch_error),
            wanted - planes,
            rules.anti_windup,
        );
        self.loops = rules.planes_limit.apply(loops).value;
        self.planes = planes;
        ControlState {
            transfer: self.transfer,
            dive_planes: planes,
            dive_planes_limited: limited.at_limit || planes != limited.value,
            ..control
        }
    }

    /// The outer loop: the terms of depth and the pitch command.
    fn depth_law(
        &mut self,
        (gains, rules): (&Gains, &DiveRules),
        setpoint: f64,
        feedback: &Feedback,
        dt: f64,
        control: ControlState,
    ) -> ControlState {
        let setpoint_rate = match (rules.derivative, self.depth_setpoint) {
            (Derivative::Error, Some(last)) if dt > 0.0 => bounded((setpoint - last) / dt),
            _ => 0.0,
        };
        self.depth_setpoint = Some(setpoint);
        let rate = bounded(feedback.depth_rate - setpoint_rate);
        let rate = self
            .depth_derivative
            .after(rate, rules.derivative_filter, dt);
        let integral = self.depth_integral.after(dt, rules.depth_i_limit);
        let terms = gains
            .depth
            .evaluate(setpoint, feedback.depth, rate, integral);
        self.depth_integral.lead(
            bounded(gains.depth_i * terms.error),
            terms.dive_angle + terms.pitch_command.value,
            rules.anti_windup,
        );
        ControlState {
            depth_error: terms.error,
            depth_p: terms.p,
            depth_i: integral,
            depth_d: terms.d,
            pitch_command: terms.pitch_command.value,
            pitch_command_limited: terms.pitch_command.at_limit,
            ..control
        }
    }

    /// The inner loop: the terms of the planes, beside those of the `outer` loop.
    fn pitch_law(
        &mut self,
        (gains, rules): (&Gains, &DiveRules),
        feedback: &Feedback,
        dt: f64,
        outer: ControlState,
    ) -> ControlState {
        let integral = self.pitch_integral.after(dt, rules.pitch_i_limit);
        let terms = gains
            .pitch
            .evaluate(outer.pitch_command, feedback.pitch, feedback.pitch_rate);
        ControlState {
            pitch_error: terms.error,
            planes_p: terms.p,
            planes_i: integral,
            planes_rate: terms.rate,
            ..outer
        }
    }
}
