//! The loops at a tick: setpoints, feedback and gains in, one answer out.
//!
//! ```text
//! depth setpoint -> depth PD -> [pitch limit] -> pitch P + rate -> (+ test signal) -> [plane limit] -> bow, stern
//! level          -> roll PD -> bow planes, differentially
//! heading setpoint -> heading PD -> rudder           speed setpoint -> feed-forward + P -> thrust
//! ```
//! Heading and speed are held when their `active` parameter says so, or once a setpoint for them has
//! come on its topic. Roll is held level. In mode off nothing is held.

use planesman_msgs::planesman_msgs::msg::{ControlState, PlaneCommand};

use crate::allocation::Shared;
use crate::angle_loop::short_way;
use crate::autopilot::{Autopilot, DiveSetpoints, Gains, Mode};
use crate::feedback::Feedback;
use crate::limits::bounded;
use crate::parameters::Config;
use crate::safety::Reaction;
use crate::setpoint::{Bounds, Setpoints};

/// The answer to a state.
pub type Answer = (PlaneCommand, ControlState);

/// A tick within its run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tick {
    /// Since the run began, ns.
    pub elapsed: i64,
    /// Since the run began, m along the initial heading.
    pub distance: f64,
    /// Since the last tick, s; 0 at the first.
    pub dt: f64,
}

/// Roll, heading or speed at a tick; the command in the unit of its actuator.
#[derive(Clone, Copy, Debug, Default)]
struct Regulated {
    setpoint: f64,
    error: f64,
    command: f64,
}

/// The loops with their setpoints.
#[derive(Clone, Debug, Default)]
pub(crate) struct Loops {
    /// The setpoints.
    pub setpoints: Setpoints,
    autopilot: Autopilot,
}

impl Loops {
    /// Takes note that the planes were put to neutral from outside.
    pub(crate) fn neutralised(&mut self) {
        self.autopilot.neutralised();
    }

    /// The answer with the loops closed; `manoeuvre` is the test signal of a manoeuvre, rad of plane. The fields of
    /// `control` that are not the loops' stay.
    pub(crate) fn step(
        &mut self,
        (config, gains): (&Config, &Gains),
        feedback: &Feedback,
        tick: Tick,
        manoeuvre: f64,
        control: ControlState,
    ) -> Answer {
        let control = self.dive((config, gains), feedback, tick, manoeuvre, control);
        let planes = config.allocation.share(control.dive_planes);
        let (mut roll, mut heading, mut speed) = (None, None, None);
        if config.parameters.mode == Mode::Off {
            self.setpoints.heading.release();
            self.setpoints.speed.release();
        } else {
            roll = hold_level(config, feedback, planes.bow());
            heading = self.heading(config, feedback, tick);
            speed = self.speed(config, feedback, tick);
        }
        let held = [roll, heading, speed].map(|regulated| regulated.is_some());
        let [roll, heading, speed] = [roll, heading, speed].map(Option::unwrap_or_default);
        let command = PlaneCommand {
            header: control.header.clone(),
            dive_planes: planes.mean,
            bow_stern_differential: planes.differential,
            roll_differential: roll.command,
            rudder: heading.command,
            thrust: speed.command,
        };
        let control = ControlState {
            manoeuvre,
            dive_planes: planes.mean,
            bow_stern_differential: planes.differential,
            roll_held: held[0],
            roll_error: roll.error,
            roll_differential: roll.command,
            heading_held: held[1],
            heading_setpoint: heading.setpoint,
            heading_error: heading.error,
            rudder: heading.command,
            speed_held: held[2],
            speed_setpoint: speed.setpoint,
            speed_error: speed.error,
            thrust: speed.command,
            ..control
        };
        (command, control)
    }

    /// The answer in a fault, with the loops set aside: the dive planes to climb or neutral.
    pub(crate) fn emergency(
        &mut self,
        config: &Config,
        reaction: Reaction,
        control: ControlState,
    ) -> Answer {
        self.autopilot.neutralised();
        self.setpoints.heading.release();
        self.setpoints.speed.release();
        let climbing = reaction == Reaction::Climb;
        let planes = if climbing {
            let climb = -config.parameters.safety.climb_planes;
            let limited = config.dive.planes_limit.apply(climb).value;
            config.allocation.share(limited)
        } else {
            Shared::default()
        };
        let command = PlaneCommand {
            header: control.header.clone(),
            dive_planes: planes.mean,
            bow_stern_differential: planes.differential,
            ..PlaneCommand::default()
        };
        let control = ControlState {
            climbing,
            dive_planes: planes.mean,
            bow_stern_differential: planes.differential,
            ..control
        };
        (command, control)
    }

    /// The dive loops: their fields of `control`.
    fn dive(
        &mut self,
        (config, gains): (&Config, &Gains),
        feedback: &Feedback,
        tick: Tick,
        manoeuvre: f64,
        mut control: ControlState,
    ) -> ControlState {
        let mode = config.parameters.mode;
        if self.autopilot.changes_to(mode) {
            self.setpoints.depth.release();
            self.setpoints.pitch.release();
        }
        let mut pitch = 0.0;
        if mode == Mode::Depth {
            (control.depth_target, control.depth_setpoint_source) = self.depth_target(config, tick);
            control.depth_setpoint = self.setpoints.depth.follow(
                control.depth_target,
                feedback.depth,
                config.depth_bounds,
                tick.dt,
            );
        }
        if mode == Mode::Pitch {
            let commanded = self.setpoints.pitch.commanded();
            let target = commanded.unwrap_or(config.parameters.pitch_setpoint);
            pitch =
                self.setpoints
                    .pitch
                    .follow(target, feedback.pitch, config.pitch_bounds, tick.dt);
        }
        if mode != Mode::Off {
            control.identification = config.identification.value(tick.elapsed);
        }
        let setpoints = DiveSetpoints {
            mode,
            depth: control.depth_setpoint,
            pitch,
            signal: control.identification + manoeuvre,
        };
        let law = (gains, &config.dive);
        self.autopilot
            .step(law, setpoints, feedback, tick.dt, control)
    }

    /// The depth to go to, m, and its source.
    fn depth_target(&self, config: &Config, tick: Tick) -> (f64, u8) {
        let depth = &self.setpoints.depth;
        let scheduled = config.schedule.depth(tick.elapsed, tick.distance);
        match (depth.commanded(), scheduled) {
            (Some(value), _) if depth.is_from_the_topic() => (value, ControlState::SETPOINT_TOPIC),
            (Some(value), _) => (value, ControlState::SETPOINT_PARAMETER),
            (None, Some(value)) => (value, ControlState::SETPOINT_SCHEDULE),
            (None, None) => (
                config.parameters.depth_setpoint,
                ControlState::SETPOINT_PARAMETER,
            ),
        }
    }

    /// Heading, by the rudder; `None` while it is not held.
    fn heading(&mut self, config: &Config, feedback: &Feedback, tick: Tick) -> Option<Regulated> {
        let heading = &mut self.setpoints.heading;
        if !config.parameters.heading.active && heading.commanded().is_none() {
            heading.release();
            return None;
        }
        let target = heading
            .commanded()
            .unwrap_or(config.parameters.heading_setpoint);
        let from = heading.stands().unwrap_or(feedback.yaw);
        let bounds = Bounds {
            rate: config.parameters.heading.setpoint_rate,
            ..Bounds::NONE
        };
        let to = bounded(from + short_way(from, target));
        let setpoint = heading.follow(to, feedback.yaw, bounds, tick.dt);
        let error = short_way(feedback.yaw, setpoint);
        Some(Regulated {
            setpoint,
            error,
            command: config.heading.evaluate(error, feedback.yaw_rate),
        })
    }

    /// Speed, by the thrust; `None` while it is not held.
    fn speed(&mut self, config: &Config, feedback: &Feedback, tick: Tick) -> Option<Regulated> {
        let speed = &mut self.setpoints.speed;
        if !config.parameters.speed.active && speed.commanded().is_none() {
            speed.release();
            return None;
        }
        let target = speed
            .commanded()
            .unwrap_or(config.parameters.speed_setpoint);
        let bounds = Bounds {
            rate: config.parameters.speed.setpoint_rate,
            ..Bounds::NONE
        };
        let setpoint = speed.follow(target, feedback.speed, bounds, tick.dt);
        Some(Regulated {
            setpoint,
            error: bounded(setpoint - feedback.speed),
            command: config.parameters.speed.evaluate(setpoint, feedback.speed),
        })
    }
}

/// Roll, held level by the bow planes' differential within the travel that the dive leaves of them; `bow` is
/// their angle in the dive, rad.
fn hold_level(config: &Config, feedback: &Feedback, bow: f64) -> Option<Regulated> {
    let error = bounded(0.0 - feedback.roll);
    let room = (config.dive.planes_limit.bound() - bow.abs()).max(0.0);
    let asked = config.roll.evaluate(error, feedback.roll_rate);
    config.parameters.roll.active.then(|| Regulated {
        setpoint: 0.0,
        error,
        command: asked.clamp(-room, room),
    })
}
