//! The loops at a tick: from setpoints, feedback and gains to commands, with all intermediate terms.
//!
//! ```text
//! depth setpoint -> depth PD -> [pitch limit] -> pitch P + rate -> (+ test signal) -> [plane limit] -> bow, stern
//! level          -> roll PD -> bow planes, differentially
//! heading setpoint -> heading PD -> rudder           speed setpoint -> feed-forward + P -> thrust
//! ```
//! Heading and speed are controlled if their `active` parameter is set, or once a setpoint has been received on their topic. Roll is controlled to
//! zero. In mode off no quantity is controlled.

use crate::allocation::Shared;
use crate::angle_loop::short_way;
use crate::autopilot::{Autopilot, DiveSetpoints, DiveTerms, Gains, Mode};
use crate::feedback::Feedback;
use crate::guidance::{Progress, Swing};
use crate::hover::{Hover, MeasuredPose, Target, Thrusters};
use crate::limits::bounded;
use crate::parameters::Config;
use crate::safety::Reaction;
use crate::setpoint::{Bounds, Setpoints};

/// A tick within its run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tick {
    /// Time since the run began, ns.
    pub elapsed: i64,
    /// Distance since the run began, m along the initial heading.
    pub distance: f64,
    /// Time since the last tick, s; 0 at the first.
    pub dt: f64,
}

/// Roll, heading or speed at a tick; the command has the unit of its actuator.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Regulated {
    pub setpoint: f64,
    pub error: f64,
    pub command: f64,
}

/// The source of the target depth.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) enum DepthSource {
    /// The value comes from the parameter, or from a live change of the parameter.
    #[default]
    Parameter,
    /// The list of way-depths.
    Schedule,
    /// The operator.
    Topic,
}

/// All commands at a tick, with all intermediate terms. Terms that the mode does not use are 0.
#[derive(Clone, Debug, Default)]
pub(crate) struct LoopTerms {
    /// The target depth, m.
    pub depth_target: f64,
    /// Its source.
    pub depth_source: DepthSource,
    /// The current depth setpoint, m.
    pub depth_setpoint: f64,
    /// The parameters' test signal, rad of plane.
    pub identification: f64,
    /// The test signal of the running manoeuvre, rad of plane.
    pub manoeuvre: f64,
    /// The dive loops.
    pub dive: DiveTerms,
    /// The dive planes' command.
    pub planes: Shared,
    /// The roll loop, if roll is controlled; the command is the bow planes' differential, rad.
    pub roll: Option<Regulated>,
    /// The heading loop, if heading is controlled; the command is the rudder, rad.
    pub heading: Option<Regulated>,
    /// The speed loop, if speed is controlled; the command is the share of full thrust.
    pub speed: Option<Regulated>,
    /// Whether the planes climb because of a fault.
    pub climbing: bool,
    /// The thrusters' commands; empty if they are stopped.
    pub thrusters: Vec<f64>,
}

/// The loops with their setpoints.
#[derive(Clone, Debug, Default)]
pub(crate) struct Loops {
    /// The setpoints.
    pub setpoints: Setpoints,
    autopilot: Autopilot,
    progress: Progress,
    swing: Swing,
    hover: Hover,
}

impl Loops {
    /// Records that the planes were set to neutral from outside.
    pub(crate) fn neutralised(&mut self) {
        self.autopilot.neutralised();
    }

    /// The commands of the closed loops; `manoeuvre` is the test signal of a manoeuvre, rad of plane.
    pub(crate) fn step(
        &mut self,
        (config, gains): (&Config, &Gains),
        feedback: &Feedback,
        tick: Tick,
        manoeuvre: f64,
    ) -> LoopTerms {
        let mut terms = self.dive((config, gains), feedback, tick, manoeuvre);
        terms.planes = config.allocation.share(terms.dive.planes.value);
        let mode = config.parameters.mode;
        if mode != Mode::Hover {
            self.hover = Hover::default();
        }
        if mode == Mode::Off {
            self.setpoints.heading.release();
            self.setpoints.speed.release();
        } else if mode == Mode::Hover {
            self.setpoints.speed.release();
            self.hover(config, feedback, tick, &mut terms);
        } else {
            terms.roll = hold_level(config, feedback, terms.planes.bow());
            terms.heading = self.heading(config, feedback, tick);
            terms.speed = self.speed(config, feedback, tick);
        }
        terms
    }

    /// The commands in a fault, without the loops: the dive planes climb or are neutral.
    pub(crate) fn emergency(
        &mut self,
        config: &Config,
        reaction: Reaction,
        feedback: &Feedback,
        dt: f64,
    ) -> LoopTerms {
        self.autopilot.neutralised();
        self.setpoints.heading.release();
        self.setpoints.speed.release();
        if reaction == Reaction::Neutral {
            self.hover = Hover::default();
            return LoopTerms::default();
        }
        let thrusters = match (&config.thrusters, config.parameters.mode) {
            (Some(thrusters), Mode::Hover) => self.climb(config, thrusters, feedback, dt),
            _ => Vec::new(),
        };
        let climb = -config.parameters.safety.climb_planes;
        let limited = config.dive.planes_limit.apply(climb).value;
        LoopTerms {
            climbing: true,
            planes: config.allocation.share(limited),
            thrusters,
            ..LoopTerms::default()
        }
    }

    /// The dive loops, with their setpoints and test signals.
    fn dive(
        &mut self,
        (config, gains): (&Config, &Gains),
        feedback: &Feedback,
        tick: Tick,
        manoeuvre: f64,
    ) -> LoopTerms {
        let mode = config.parameters.mode;
        if self.autopilot.changes_to(mode) {
            self.setpoints.depth.release();
            self.setpoints.pitch.release();
        }
        let mut terms = LoopTerms {
            manoeuvre,
            ..LoopTerms::default()
        };
        let mut pitch = 0.0;
        if matches!(mode, Mode::Depth | Mode::Hover) {
            (terms.depth_target, terms.depth_source) = self.depth_target(config, tick);
            let (target, bounds) = (terms.depth_target, config.depth_bounds);
            let setpoint = &mut self.setpoints.depth;
            terms.depth_setpoint = setpoint.follow(target, feedback.depth, bounds, tick.dt);
        }
        if mode == Mode::Pitch {
            let setpoint = &mut self.setpoints.pitch;
            let commanded = setpoint.commanded();
            let target = commanded.unwrap_or(config.parameters.pitch_setpoint);
            pitch = setpoint.follow(target, feedback.pitch, config.pitch_bounds, tick.dt);
        }
        if mode != Mode::Off {
            terms.identification = config.identification.value(tick.elapsed);
        }
        let setpoints = DiveSetpoints {
            mode,
            depth: terms.depth_setpoint,
            pitch,
            signal: terms.identification + manoeuvre,
        };
        let law = (gains, &config.dive);
        terms.dive = self.autopilot.step(law, setpoints, feedback, tick.dt);
        terms
    }

    /// The target depth, m, and its source.
    fn depth_target(&self, config: &Config, tick: Tick) -> (f64, DepthSource) {
        let depth = &self.setpoints.depth;
        let scheduled = config.schedule.depth(tick.elapsed, tick.distance);
        match (depth.commanded(), scheduled) {
            (Some(value), _) if depth.is_from_the_topic() => (value, DepthSource::Topic),
            (Some(value), _) => (value, DepthSource::Parameter),
            (None, Some(value)) => (value, DepthSource::Schedule),
            (None, None) => (config.parameters.depth_setpoint, DepthSource::Parameter),
        }
    }

    /// Controls heading by the rudder; `None` if heading is not controlled.
    fn heading(&mut self, config: &Config, feedback: &Feedback, tick: Tick) -> Option<Regulated> {
        let heading = &mut self.setpoints.heading;
        if !config.parameters.heading.active && heading.commanded().is_none() {
            heading.release();
            return None;
        }
        let course = config
            .path
            .course(&mut self.progress, [feedback.x, feedback.y]);
        let target = (heading.commanded())
            .or(course.map(|course| course.heading))
            .unwrap_or(config.parameters.heading_setpoint);
        let from = heading.current_target().unwrap_or(feedback.yaw);
        let bounds = Bounds {
            rate: config.parameters.heading.setpoint_rate,
            ..Bounds::NONE
        };
        let to = bounded(from + short_way(from, target));
        let setpoint = heading.follow(to, feedback.yaw, bounds, tick.dt);
        let error = short_way(feedback.yaw, setpoint);
        let turning = &config.parameters.turning;
        let swung = turning.rudder(&mut self.swing, tick.elapsed as f64 * 1e-9, feedback.yaw);
        Some(Regulated {
            setpoint,
            error,
            command: match swung {
                Some(rudder) => config.heading.limit.apply(rudder).value,
                None => config.heading.evaluate(error, feedback.yaw_rate),
            },
        })
    }

    /// Restarts the way-points at the first one, from the vehicle's present position.
    pub(crate) fn begin_path(&mut self) {
        self.progress = Progress::default();
    }

    /// Climbs vertically by the thrusters, at the speed of hovering.
    fn climb(
        &mut self,
        config: &Config,
        thrusters: &Thrusters,
        feedback: &Feedback,
        dt: f64,
    ) -> Vec<f64> {
        let target = Target {
            place: [feedback.x, feedback.y, f64::MIN],
            heading: feedback.yaw,
        };
        let law = &config.parameters.hover;
        self.hover
            .step(law, thrusters, &seen(feedback), &target, dt)
    }

    /// Holds position, depth and heading by the thrusters.
    fn hover(&mut self, config: &Config, feedback: &Feedback, tick: Tick, terms: &mut LoopTerms) {
        let Some(thrusters) = &config.thrusters else {
            return;
        };
        let law = &config.parameters.hover;
        let course = config
            .path
            .course(&mut self.progress, [feedback.x, feedback.y]);
        let [x, y] = course.map_or([law.x, law.y], |course| course.target);
        let heading = self.setpoints.heading.commanded();
        let heading = heading.unwrap_or(config.parameters.heading_setpoint);
        let target = Target {
            place: [x, y, terms.depth_setpoint],
            heading,
        };
        let seen = seen(feedback);
        terms.thrusters = self.hover.step(law, thrusters, &seen, &target, tick.dt);
        terms.dive.depth.error = bounded(terms.depth_setpoint - feedback.depth);
        terms.heading = Some(Regulated {
            setpoint: heading,
            error: short_way(feedback.yaw, heading),
            command: 0.0,
        });
    }

    /// Controls speed by the thrust; `None` if speed is not controlled.
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

fn seen(feedback: &Feedback) -> MeasuredPose {
    MeasuredPose {
        place: [feedback.x, feedback.y, feedback.depth],
        angles: [feedback.roll, feedback.pitch, feedback.yaw],
        rates: [feedback.roll_rate, feedback.pitch_rate, feedback.yaw_rate],
    }
}

/// Controls roll to zero by the bow planes' differential, within the travel that the dive does not use; `bow` is the bow planes' angle for the dive,
/// rad.
fn hold_level(config: &Config, feedback: &Feedback, bow: f64) -> Option<Regulated> {
    let error = bounded(0.0 - feedback.roll);
    let room = (config.dive.planes_limit.bound() - bow.abs()).max(0.0);
    let command = config.roll.evaluate(error, feedback.roll_rate);
    config.parameters.roll.active.then(|| Regulated {
        setpoint: 0.0,
        error,
        command: command.clamp(-room, room),
    })
}
