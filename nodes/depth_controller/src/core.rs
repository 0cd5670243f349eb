//! The controller: a vehicle state in, the plane command for the same stamp out.
//!
//! ```text
//! depth setpoint -> depth PD -> [pitch limit] -> pitch P + rate -> (+ test signal) -> [plane limit] -> bow, stern
//! level          -> roll PD -> bow planes, differentially
//! course setpoint -> course PD -> rudder             speed setpoint -> feed-forward + P -> thrust
//! ```
//!
//! **Time** is the states' own: elapsed time and distance run from the first state. A state
//! with the last stamp again gets the last answer again; one with an earlier stamp begins a new
//! run, with the elapsed time at zero, nothing in the loops, and the topics' setpoints forgotten.
//!
//! **Depth setpoint**: the last word counts. The schedule is followed from its first entry
//! on, the parameter `depth_setpoint` before it. A setpoint from the topic, or a live
//! change of the parameter, overrides the schedule from then on; a live change of the
//! schedule puts the schedule in charge again. With `setpoint_timeout` a word from a topic holds only so long.
//!
//! **Course and speed** are held when their `active` parameter says so, or once a setpoint for them has
//! come on its topic. Roll is held level. In mode off nothing is held.
//!
//! **Feedback** is the true state, or what an [`Estimator`] makes of the instruments, which are to be heard before
//! the state of their stamp is answered. **Gains** are the parameters', or follow the vehicle ([`Follower`]).
//! Nothing else here knows of either.
//!
//! What is not finite is refused and changes nothing.

use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::action::ManoeuvreGoal;
use planesman_msgs::planesman_msgs::msg::{
    ControlState, ModelEstimate, MotionEstimate, PlaneCommand, VehicleState,
};
use planesman_msgs::sensor_msgs::msg::{FluidPressure, Imu};
use planesman_msgs::std_msgs::msg::Header;

use crate::angle_loop::short_way;
use crate::autopilot::{Asked, Autopilot, Gains};
use crate::estimator::{Estimated, Estimator, Source};
use crate::feedback::Feedback;
use crate::gains::Follower;
use crate::goal::{Progress, Underway};
use crate::limits::bounded;
use crate::parameters::{Config, ControllerParameters, Mode};
use crate::safety::{Fault, Reaction, Safety};
use crate::setpoint::{Bounds, Setpoint};

/// The frame the commands are given in: forward, right, down.
const FRAME: &str = "base_link_frd";

/// The frame that depth and pitch are estimated in: forward, starboard, down from the surface.
const ESTIMATE_FRAME: &str = "map_ned";

/// What a state is answered with.
pub type Answer = (PlaneCommand, ControlState);

/// A quantity that an operator gives a setpoint for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// m, down.
    Depth,
    /// rad, bow up; in mode pitch.
    Pitch,
    /// rad, from the first course, to starboard.
    Course,
    /// m/s, through the water.
    Speed,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Depth, Self::Pitch, Self::Course, Self::Speed];

    /// Its name, as in the topic `NAME_setpoint`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Pitch => "pitch",
            Self::Course => "course",
            Self::Speed => "speed",
        }
    }

    /// The unit of its setpoint.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Depth => "m",
            Self::Pitch | Self::Course => "rad",
            Self::Speed => "m/s",
        }
    }
}

/// The setpoints of the four quantities.
#[derive(Clone, Debug, Default)]
struct Setpoints {
    depth: Setpoint,
    pitch: Setpoint,
    course: Setpoint,
    speed: Setpoint,
}

impl Setpoints {
    fn of(&mut self, quantity: Quantity) -> &mut Setpoint {
        match quantity {
            Quantity::Depth => &mut self.depth,
            Quantity::Pitch => &mut self.pitch,
            Quantity::Course => &mut self.course,
            Quantity::Speed => &mut self.speed,
        }
    }
}

/// The autopilots with their setpoints.
#[derive(Clone, Debug)]
pub struct Controller {
    config: Config,
    setpoints: Setpoints,
    autopilot: Autopilot,
    estimator: Estimator,
    follower: Follower,
    /// What the last state was answered on, where that was not the truth.
    estimate: Option<MotionEstimate>,
    safety: Safety,
    /// What the loops were told last; `None` before that, and in silence.
    feedback: Option<Feedback>,
    manoeuvre: Option<Underway>,
    /// How the last manoeuvre ended, until it is asked for: completed, or why not.
    manoeuvre_end: Option<Result<(), String>>,
    run: Option<Run>,
    /// What is to be told the operator.
    news: Vec<String>,
}

/// A run: from the first state on, until the stamps go back.
#[derive(Clone, Debug)]
struct Run {
    /// The first state's stamp, ns.
    began: i64,
    /// The first state's distance, m.
    from: f64,
    /// The last state's stamp, ns, and what it was answered with.
    last: i64,
    answer: Answer,
}

/// A tick within its run.
#[derive(Clone, Copy, Debug)]
struct Tick {
    /// Since the run began, ns.
    elapsed: i64,
    /// Since the run began, m along the first course.
    distance: f64,
    /// Since the last tick, s; 0 at the first.
    dt: f64,
}

impl Controller {
    /// A controller with the parameters' gains and setpoints, before its first state.
    ///
    /// # Errors
    /// As [`Config::new`].
    pub fn new(parameters: &ControllerParameters) -> Result<Self, String> {
        Ok(Self {
            config: Config::new(parameters)?,
            setpoints: Setpoints::default(),
            autopilot: Autopilot::default(),
            estimator: Estimator::default(),
            follower: Follower::default(),
            estimate: None,
            safety: Safety::default(),
            feedback: None,
            manoeuvre: None,
            manoeuvre_end: None,
            run: None,
            news: Vec::new(),
        })
    }

    /// Takes changed parameters, whole or not at all; they take effect at the next stamp.
    ///
    /// # Errors
    /// As [`Config::new`]; the present parameters then stay.
    pub fn set_parameters(&mut self, parameters: &ControllerParameters) -> Result<(), String> {
        let new = Config::new(parameters)?;
        let old = std::mem::replace(&mut self.config, new);
        let new = &self.config;
        if new.schedule != old.schedule {
            self.setpoints.depth.forget();
        } else if new.depth_setpoint != old.depth_setpoint {
            self.setpoints.depth.change(new.depth_setpoint);
        }
        let switched_off = new.mode == Mode::Off && old.mode != Mode::Off;
        if new.pitch_setpoint != old.pitch_setpoint {
            self.setpoints.pitch.forget();
        }
        if new.course_setpoint != old.course_setpoint || new.course_active != old.course_active {
            self.setpoints.course.forget();
        }
        if new.speed_setpoint != old.speed_setpoint || new.speed_active != old.speed_active {
            self.setpoints.speed.forget();
        }
        if switched_off {
            self.break_off("the controller was switched off");
        }
        Ok(())
    }

    /// Begins a manoeuvre at the next stamp, in place of one under way.
    ///
    /// # Errors
    /// A sentence that says why it cannot be flown; one under way then goes on.
    pub fn begin_manoeuvre(&mut self, goal: &ManoeuvreGoal) -> Result<(), String> {
        if self.config.mode == Mode::Off {
            return Err("refused: the controller is switched off (mode off)".to_owned());
        }
        if let Some(fault) = self.fault() {
            return Err(format!("refused: a fault stands: {}", fault.text()));
        }
        self.manoeuvre = Some(Underway::of(goal, self.config.dive.planes_limit)?);
        self.manoeuvre_end = None;
        Ok(())
    }

    /// The fault that stands.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.safety.fault()
    }

    /// Takes the fault back; the loops take up the next state without a bump.
    ///
    /// # Errors
    /// A sentence with what is still wrong, or that nothing is.
    pub fn reset_fault(&mut self) -> Result<Fault, String> {
        if self.feedback.is_none() && self.safety.fault() == Some(Fault::Silence) {
            return Err("there is still no vehicle state".to_owned());
        }
        self.safety
            .reset(&self.config.envelope, self.feedback.as_ref())
    }

    /// Takes note of a fault.
    fn fail(&mut self, fault: Fault) {
        if self.safety.latch(fault) {
            let text = format!("fault: {}", fault.text());
            self.break_off(&text);
            self.news.push(text);
        }
    }

    /// Ends the manoeuvre under way, if there is one.
    pub fn stop_manoeuvre(&mut self) {
        self.manoeuvre = None;
    }

    /// How far the manoeuvre under way has come.
    #[must_use]
    pub fn manoeuvre(&self) -> Option<Progress> {
        self.manoeuvre.as_ref().map(|underway| underway.progress)
    }

    /// How the manoeuvre ended, once it has of itself: completed, or broken off and why.
    pub fn manoeuvre_end(&mut self) -> Option<Result<(), String>> {
        self.manoeuvre_end.take()
    }

    /// Ends the manoeuvre under way for a reason that lies outside it.
    fn break_off(&mut self, reason: &str) {
        if self.manoeuvre.take().is_some() {
            self.manoeuvre_end = Some(Err(format!("broken off: {reason}")));
        }
    }

    /// Takes the operator's word on a setpoint, from the next stamp on.
    ///
    /// # Errors
    /// A sentence, when it is not finite.
    pub fn set_setpoint(&mut self, quantity: Quantity, value: f64) -> Result<(), String> {
        if !value.is_finite() {
            let name = quantity.name();
            return Err(format!(
                "{name} setpoint {value} refused: it must be finite"
            ));
        }
        let elapsed = self.run.as_ref().map_or(0, |run| run.last - run.began);
        self.setpoints.of(quantity).say(value, elapsed);
        Ok(())
    }

    /// The silence of the state, s, after which the node calls [`Controller::on_silence`].
    #[must_use]
    pub fn state_timeout(&self) -> f64 {
        self.config.state_timeout
    }

    /// What has happened since this was last asked and is worth a line in the log.
    pub fn news(&mut self) -> Vec<String> {
        std::mem::take(&mut self.news)
    }

    /// The plane command that answers `state`, and everything that led to it.
    ///
    /// # Errors
    /// A sentence naming the field, when a number in `state` is not finite; nothing changes then.
    pub fn on_state(&mut self, state: &VehicleState) -> Result<Answer, String> {
        if let Some(field) = state.first_non_finite() {
            return Err(format!("state refused: {field} is not finite"));
        }
        let stamp = state.header.stamp.nanos();
        let (began, from, last) = match &self.run {
            Some(run) if stamp == run.last => return Ok(run.answer.clone()),
            Some(run) if stamp > run.last => (run.began, run.from, run.last),
            _ => {
                if self.run.is_some() {
                    self.setpoints = Setpoints::default();
                    self.autopilot = Autopilot::default();
                    self.estimator.restart();
                    self.follower = Follower::default();
                    self.break_off("the vehicle began a new run");
                }
                (stamp, state.distance, stamp)
            }
        };
        let tick = Tick {
            elapsed: stamp - began,
            distance: bounded(state.distance - from),
            dt: (stamp - last) as f64 * 1e-9,
        };
        let answer = self.answer(state, tick);
        self.run = Some(Run {
            began,
            from,
            last: stamp,
            answer: answer.clone(),
        });
        Ok(answer)
    }

    /// What to command at `stamp` when no state has come for [`Controller::state_timeout`]:
    /// everything neutral, flagged. The run goes on with the next state.
    #[must_use]
    pub fn on_silence(&mut self, stamp: Time) -> Answer {
        self.break_off("the vehicle's state is silent");
        self.feedback = None;
        if self.config.envelope.latch_silence {
            self.fail(Fault::Silence);
        }
        self.neutral(stamp)
    }

    /// Everything neutral for want of feedback.
    fn neutral(&mut self, stamp: Time) -> Answer {
        self.autopilot.neutralised();
        let header = header(stamp);
        let command = PlaneCommand {
            header: header.clone(),
            ..PlaneCommand::default()
        };
        let control = ControlState {
            header,
            mode: self.config.mode.constant(),
            feedback_stale: true,
            fault: self.fault_constant(),
            ..ControlState::default()
        };
        (command, control)
    }

    /// Takes the gyro's reading, for the state of its stamp.
    pub fn on_imu(&mut self, imu: &Imu) {
        self.estimator.instruments.on_imu(imu);
    }

    /// Takes the depth cell's reading, for the state of its stamp.
    pub fn on_depth_pressure(&mut self, pressure: &FluidPressure) {
        self.estimator.instruments.on_depth_pressure(pressure);
    }

    /// Takes the speed cell's reading, for the state of its stamp.
    pub fn on_speed_pressure(&mut self, pressure: &FluidPressure) {
        self.estimator.instruments.on_speed_pressure(pressure);
    }

    /// Takes a model that `sysid` has identified.
    pub fn on_model(&mut self, model: ModelEstimate) {
        self.follower.on_model(model);
    }

    /// Whether the loops look at the instruments rather than at the truth.
    #[must_use]
    pub fn reads_instruments(&self) -> bool {
        self.config.feedback.source != Source::Truth
    }

    /// Whether everything that a state of this stamp is answered on has been heard.
    #[must_use]
    pub fn ready_for(&self, stamp: &Time) -> bool {
        self.estimator.ready(stamp.nanos(), &self.config.feedback)
    }

    /// What the last state was answered on, where that was not the truth.
    #[must_use]
    pub fn estimate(&self) -> Option<&MotionEstimate> {
        self.estimate.as_ref()
    }

    /// The gains in force for this feedback at a tick.
    fn gains(
        &mut self,
        feedback: &Feedback,
        stamp: i64,
        dt: f64,
        inside: &mut ControlState,
    ) -> Gains {
        let rules = &self.config.following;
        let (followed, adapted) = self.follower.gains(rules, feedback.speed, stamp, dt);
        self.news.extend(self.follower.news());
        inside.gains_adapted = adapted;
        inside.gain_depth_p = followed.depth_p;
        inside.gain_depth_d = followed.depth_d;
        inside.gain_pitch_p = followed.pitch_p;
        inside.gain_pitch_rate = followed.pitch_rate;
        let mut gains = self.config.gains;
        (gains.depth.p, gains.depth.d) = (followed.depth_p, followed.depth_d);
        (gains.pitch.p, gains.pitch.rate) = (followed.pitch_p, followed.pitch_rate);
        gains
    }

    /// The estimate as a message.
    fn estimate_message(&self, stamp: Time, estimated: &Estimated) -> MotionEstimate {
        let estimate = &estimated.estimate;
        MotionEstimate {
            header: Header {
                stamp,
                frame_id: ESTIMATE_FRAME.to_owned(),
            },
            source: feedback_constant(self.config.feedback.source),
            pitch: estimate.pitch,
            pitch_rate: estimate.pitch_rate,
            depth: estimate.depth,
            depth_rate: estimate.depth_rate,
            gyro_bias: estimate.gyro_bias,
            covariance: estimated.covariance,
            depth_measured: estimated.measured.depth.is_some(),
        }
    }

    /// Everything commanded at a tick.
    fn answer(&mut self, state: &VehicleState, tick: Tick) -> Answer {
        let stamp = &state.header.stamp;
        let rules = &self.config.feedback;
        let estimated = self.estimator.step(rules, stamp.nanos(), tick.dt);
        let mut feedback = Feedback::truth(state);
        if let Some(estimated) = &estimated {
            feedback = feedback.estimated(estimated);
        }
        if !feedback.is_finite() {
            self.estimator.restart();
            self.estimate = None;
            self.news
                .push("the estimate is not finite: begun again, planes neutral".to_owned());
            return self.neutral(stamp.clone());
        }
        self.estimate = estimated.map(|estimated| self.estimate_message(stamp.clone(), &estimated));
        self.feedback = Some(feedback);
        if let Some(fault) = self.config.envelope.violated(&feedback) {
            self.fail(fault);
        }
        let mut inside = ControlState {
            header: header(state.header.stamp.clone()),
            mode: self.config.mode.constant(),
            depth_rate: feedback.depth_rate,
            feedback_source: feedback_constant(self.config.feedback.source),
            instruments_missing: estimated.is_some_and(|estimated| estimated.missing),
            ..ControlState::default()
        };
        let gains = self.gains(&feedback, stamp.nanos(), tick.dt, &mut inside);
        for quantity in Quantity::ALL {
            let timeout = self.config.setpoint_timeout;
            if self.setpoints.of(quantity).expire(timeout, tick.elapsed) {
                let name = quantity.name();
                self.news.push(format!(
                    "no {name} setpoint for {timeout} s: back to the parameters'"
                ));
            }
        }
        let mut command = PlaneCommand {
            header: inside.header.clone(),
            ..PlaneCommand::default()
        };
        let envelope = self.config.envelope;
        if let Some(reaction) = self.safety.react(&envelope, &feedback, tick.dt) {
            self.emergency(reaction, &mut command, &mut inside);
            return (command, inside);
        }
        self.dive(&gains, &feedback, tick, &mut command, &mut inside);
        if self.config.mode == Mode::Off {
            self.setpoints.course.release();
            self.setpoints.speed.release();
        } else {
            self.roll(&feedback, &mut command, &mut inside);
            self.course(&feedback, tick, &mut command, &mut inside);
            self.speed(&feedback, tick, &mut command, &mut inside);
        }
        (command, inside)
    }

    fn fault_constant(&self) -> u8 {
        self.fault()
            .map_or(ControlState::FAULT_NONE, Fault::constant)
    }

    /// The dive planes in a fault, with the loops set aside.
    fn emergency(
        &mut self,
        reaction: Reaction,
        command: &mut PlaneCommand,
        inside: &mut ControlState,
    ) {
        self.autopilot.neutralised();
        self.setpoints.course.release();
        self.setpoints.speed.release();
        inside.fault = self.fault_constant();
        if reaction == Reaction::Climb {
            inside.climbing = true;
            let climb = -self.config.envelope.climb_planes;
            self.share_out(
                self.config.dive.planes_limit.apply(climb).value,
                command,
                inside,
            );
        }
    }

    /// Gives bow and stern planes their part of a plane angle (rad, positive dive).
    fn share_out(&self, planes: f64, command: &mut PlaneCommand, inside: &mut ControlState) {
        let shared = self.config.allocation.share(planes);
        command.dive_planes = shared.mean;
        command.bow_stern_differential = shared.differential;
        inside.dive_planes = shared.mean;
        inside.bow_stern_differential = shared.differential;
    }

    /// The dive planes.
    fn dive(
        &mut self,
        gains: &Gains,
        feedback: &Feedback,
        tick: Tick,
        command: &mut PlaneCommand,
        inside: &mut ControlState,
    ) {
        let config = &self.config;
        let mode = config.mode;
        if self.autopilot.changes_to(mode) {
            self.setpoints.depth.release();
            self.setpoints.pitch.release();
        }
        let mut asked = Asked {
            mode,
            depth: 0.0,
            pitch: 0.0,
            signal: 0.0,
        };
        if mode == Mode::Depth {
            (inside.depth_target, inside.depth_setpoint_source) = self.depth_target(tick);
            asked.depth = self.setpoints.depth.follow(
                inside.depth_target,
                feedback.depth,
                config.depth_bounds,
                tick.dt,
            );
            inside.depth_setpoint = asked.depth;
        }
        if mode == Mode::Pitch {
            let target = self.setpoints.pitch.word().unwrap_or(config.pitch_setpoint);
            asked.pitch =
                self.setpoints
                    .pitch
                    .follow(target, feedback.pitch, config.pitch_bounds, tick.dt);
        }
        if mode != Mode::Off {
            inside.identification = config.identification.value(tick.elapsed);
            inside.manoeuvre = self.manoeuvre_offset(tick.elapsed);
            asked.signal = inside.identification + inside.manoeuvre;
        }
        let law = (gains, &self.config.dive);
        let planes = self.autopilot.planes(law, asked, feedback, tick.dt, inside);
        self.share_out(planes, command, inside);
    }

    /// What the manoeuvre under way adds to the planes, rad; ends it when it is over.
    fn manoeuvre_offset(&mut self, elapsed: i64) -> f64 {
        let Some(underway) = &mut self.manoeuvre else {
            return 0.0;
        };
        underway.at(elapsed).unwrap_or_else(|| {
            self.manoeuvre = None;
            self.manoeuvre_end = Some(Ok(()));
            0.0
        })
    }

    /// The depth to go to, m, and who says so.
    fn depth_target(&self, tick: Tick) -> (f64, u8) {
        let word = &self.setpoints.depth;
        let scheduled = self.config.schedule.depth(tick.elapsed, tick.distance);
        match (word.word(), scheduled) {
            (Some(depth), _) if word.is_from_the_topic() => (depth, ControlState::SETPOINT_TOPIC),
            (Some(depth), _) => (depth, ControlState::SETPOINT_PARAMETER),
            (None, Some(depth)) => (depth, ControlState::SETPOINT_SCHEDULE),
            (None, None) => (self.config.depth_setpoint, ControlState::SETPOINT_PARAMETER),
        }
    }

    /// The bow planes' differential, within what the dive leaves of their travel.
    fn roll(&self, feedback: &Feedback, command: &mut PlaneCommand, inside: &mut ControlState) {
        let config = &self.config;
        if !config.roll_active {
            return;
        }
        inside.roll_held = true;
        inside.roll_error = bounded(0.0 - feedback.roll);
        let bow = command.dive_planes + command.bow_stern_differential;
        let room = (config.dive.planes_limit.bound() - bow.abs()).max(0.0);
        let asked = config.roll.evaluate(inside.roll_error, feedback.roll_rate);
        command.roll_differential = asked.clamp(-room, room);
        inside.roll_differential = command.roll_differential;
    }

    /// The rudder.
    fn course(
        &mut self,
        feedback: &Feedback,
        tick: Tick,
        command: &mut PlaneCommand,
        inside: &mut ControlState,
    ) {
        let config = &self.config;
        let course = &mut self.setpoints.course;
        if !config.course_active && course.word().is_none() {
            course.release();
            return;
        }
        let target = course.word().unwrap_or(config.course_setpoint);
        let from = course.stands().unwrap_or(feedback.yaw);
        let bounds = Bounds {
            rate: config.course_rate,
            ..Bounds::NONE
        };
        let to = bounded(from + short_way(from, target));
        inside.course_held = true;
        inside.course_setpoint = course.follow(to, feedback.yaw, bounds, tick.dt);
        inside.course_error = short_way(feedback.yaw, inside.course_setpoint);
        command.rudder = config
            .course
            .evaluate(inside.course_error, feedback.yaw_rate);
        inside.rudder = command.rudder;
    }

    /// The thrust.
    fn speed(
        &mut self,
        feedback: &Feedback,
        tick: Tick,
        command: &mut PlaneCommand,
        inside: &mut ControlState,
    ) {
        let config = &self.config;
        let speed = &mut self.setpoints.speed;
        if !config.speed_active && speed.word().is_none() {
            speed.release();
            return;
        }
        let target = speed.word().unwrap_or(config.speed_setpoint);
        let bounds = Bounds {
            rate: config.speed_rate,
            ..Bounds::NONE
        };
        inside.speed_held = true;
        inside.speed_setpoint = speed.follow(target, feedback.speed, bounds, tick.dt);
        inside.speed_error = bounded(inside.speed_setpoint - feedback.speed);
        command.thrust = config.speed.evaluate(inside.speed_setpoint, feedback.speed);
        inside.thrust = command.thrust;
    }
}

/// A source's constant in `ControlState` and `MotionEstimate`.
fn feedback_constant(source: Source) -> u8 {
    match source {
        Source::Truth => ControlState::FEEDBACK_TRUTH,
        Source::Integrator => ControlState::FEEDBACK_INTEGRATOR,
        Source::Kalman => ControlState::FEEDBACK_KALMAN,
    }
}

fn header(stamp: Time) -> Header {
    Header {
        stamp,
        frame_id: FRAME.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use planesman_parameters::{Choice as _, Parameters as _, Value};
    use std::f64::consts::FRAC_PI_6;

    const TICK: i64 = 50_000_000;

    fn with(changes: &[(&str, Value)]) -> ControllerParameters {
        ControllerParameters::default().with(changes).unwrap()
    }

    fn controller(changes: &[(&str, Value)]) -> Controller {
        Controller::new(&with(changes)).unwrap()
    }

    fn state(tick: i64) -> VehicleState {
        let mut state = VehicleState::default();
        state.header.stamp = Time::from_nanos(tick * TICK);
        state
    }

    #[test]
    fn a_deeper_setpoint_dives_the_planes_and_the_answer_bears_the_states_stamp() {
        let mut controller = controller(&[]);
        controller.set_setpoint(Quantity::Depth, 0.1).unwrap();
        let (command, control) = controller.on_state(&state(3)).unwrap();
        assert!(command.dive_planes > 0.0);
        assert!(control.pitch_command < 0.0);
        assert_eq!(command.header.stamp, Time::from_nanos(3 * TICK));
        assert_eq!(control.header, command.header);
        assert_eq!(control.dive_planes, control.planes_p + control.planes_rate);
    }

    #[test]
    fn a_stamp_seen_again_gets_the_same_answer_even_after_a_change() {
        let mut controller = controller(&[]);
        controller.set_setpoint(Quantity::Depth, 0.1).unwrap();
        let first = controller.on_state(&state(0)).unwrap();
        controller.set_setpoint(Quantity::Depth, 0.2).unwrap();
        controller
            .set_parameters(&with(&[("pitch.p", Value::Double(0.1))]))
            .unwrap();
        assert_eq!(controller.on_state(&state(0)).unwrap(), first);
        assert_ne!(
            controller.on_state(&state(1)).unwrap().0.dive_planes,
            first.0.dive_planes
        );
    }

    #[test]
    fn the_schedule_runs_from_the_first_state_and_the_topic_overrides_it() {
        let mut controller = controller(&[
            ("depth_setpoint", Value::Double(0.05)),
            ("schedule.times", Value::DoubleArray(vec![0.1, 0.2])),
            ("schedule.depths", Value::DoubleArray(vec![0.3, 0.4])),
        ]);
        let setpoint = |controller: &mut Controller, tick: i64| {
            controller
                .on_state(&state(1000 + tick))
                .unwrap()
                .1
                .depth_setpoint
        };
        for (tick, depth) in [(0, 0.05), (1, 0.05), (2, 0.3), (3, 0.3), (4, 0.4)] {
            assert_eq!(setpoint(&mut controller, tick), depth);
        }
        controller.set_setpoint(Quantity::Depth, 0.7).unwrap();
        assert_eq!(setpoint(&mut controller, 5), 0.7);
    }

    #[test]
    fn the_last_word_on_the_depth_counts() {
        let mut controller = controller(&[]);
        controller.set_setpoint(Quantity::Depth, 0.7).unwrap();
        let changed = [("depth_setpoint", Value::Double(0.2))];
        controller.set_parameters(&with(&changed)).unwrap();
        assert_eq!(
            controller.on_state(&state(0)).unwrap().1.depth_setpoint,
            0.2
        );
        let scheduled = [
            ("depth_setpoint", Value::Double(0.2)),
            ("schedule.times", Value::DoubleArray(vec![0.0])),
            ("schedule.depths", Value::DoubleArray(vec![0.3])),
        ];
        controller.set_parameters(&with(&scheduled)).unwrap();
        assert_eq!(
            controller.on_state(&state(1)).unwrap().1.depth_setpoint,
            0.3
        );
    }

    #[test]
    fn an_earlier_stamp_begins_the_run_again() {
        let changes = [
            ("schedule.times", Value::DoubleArray(vec![0.0, 0.1])),
            ("schedule.depths", Value::DoubleArray(vec![0.3, 0.4])),
        ];
        let mut controller = controller(&changes);
        let first = controller.on_state(&state(0)).unwrap();
        for tick in 1..5 {
            controller.on_state(&state(tick)).unwrap();
        }
        controller.set_setpoint(Quantity::Depth, 0.9).unwrap();
        assert_eq!(controller.on_state(&state(0)).unwrap(), first);
    }

    #[test]
    fn the_test_signal_is_added_in_every_mode_but_off() {
        for mode in &Mode::NAMES[1..] {
            let mut controller = controller(&[
                ("mode", Value::from(*mode)),
                ("identification.signal", Value::from("square")),
                ("identification.amplitude", Value::Double(0.1)),
                ("identification.period", Value::Double(0.1)),
            ]);
            assert_eq!(controller.on_state(&state(0)).unwrap().0.dive_planes, 0.1);
            assert_eq!(controller.on_state(&state(1)).unwrap().0.dive_planes, -0.1);
        }
    }

    #[test]
    fn switched_off_everything_is_neutral_at_once() {
        let mut controller = controller(&[
            ("depth_setpoint", Value::Double(5.0)),
            ("speed.active", Value::Bool(true)),
        ]);
        let mut adrift = state(0);
        (adrift.roll, adrift.yaw) = (0.1, 0.2);
        let (command, _) = controller.on_state(&adrift).unwrap();
        for angle in [command.dive_planes, command.rudder, command.thrust] {
            assert_ne!(angle, 0.0);
        }
        let off = [
            ("mode", Value::from("off")),
            ("identification.signal", Value::from("step")),
        ];
        controller.set_parameters(&with(&off)).unwrap();
        adrift.header.stamp = Time::from_nanos(TICK);
        let (command, control) = controller.on_state(&adrift).unwrap();
        let neutral = PlaneCommand {
            header: command.header.clone(),
            ..PlaneCommand::default()
        };
        assert_eq!(command, neutral);
        assert_eq!(control.mode, ControlState::MODE_OFF);
    }

    #[test]
    fn roll_is_held_level_within_what_the_dive_leaves_of_the_bow_planes() {
        let mut controller = controller(&[]);
        let mut heeled = state(0);
        heeled.roll = 0.01;
        let (command, _) = controller.on_state(&heeled).unwrap();
        assert!(
            (command.roll_differential + 0.1).abs() < 1e-15,
            "port side down"
        );
        controller.set_setpoint(Quantity::Depth, 100.0).unwrap();
        heeled.header.stamp = Time::from_nanos(TICK);
        let (command, _) = controller.on_state(&heeled).unwrap();
        assert_eq!(command.dive_planes, FRAC_PI_6);
        assert_eq!(command.roll_differential, 0.0);
    }

    #[test]
    fn a_course_from_the_topic_is_steered_the_short_way_at_its_rate() {
        let mut controller = controller(&[("course.setpoint_rate", Value::Double(0.2))]);
        controller.set_setpoint(Quantity::Course, -3.0).unwrap();
        let mut off_course = state(0);
        off_course.yaw = 3.0;
        let (command, control) = controller.on_state(&off_course).unwrap();
        assert!(control.course_held);
        assert_eq!((command.rudder, control.course_setpoint), (0.0, 3.0));
        off_course.header.stamp = Time::from_nanos(TICK);
        let (command, control) = controller.on_state(&off_course).unwrap();
        assert!((control.course_error - 0.2 * 0.05).abs() < 1e-12);
        assert!((command.rudder - 0.2 * 0.05).abs() < 1e-12, "to starboard");
    }

    #[test]
    fn a_speed_is_held_once_it_is_asked_for() {
        let mut controller = controller(&[]);
        let (command, control) = controller.on_state(&state(0)).unwrap();
        assert!(!control.speed_held);
        assert_eq!(command.thrust, 0.0);
        controller.set_setpoint(Quantity::Speed, 0.3).unwrap();
        let (command, control) = controller.on_state(&state(1)).unwrap();
        assert!(control.speed_held);
        assert!((command.thrust - (0.3 / 1.524 + 2.0 * 0.3)).abs() < 1e-12);
    }

    #[test]
    fn bow_or_stern_planes_dive_alone_when_told_to() {
        for (allocation, bow, stern) in [("bow", 1.0, 0.0), ("stern", 0.0, 1.0)] {
            let mut controller = controller(&[
                ("planes.allocation", Value::from(allocation)),
                ("depth_setpoint", Value::Double(100.0)),
            ]);
            let (command, _) = controller.on_state(&state(0)).unwrap();
            let differential = command.bow_stern_differential;
            assert_eq!(command.dive_planes + differential, bow * FRAC_PI_6);
            assert_eq!(command.dive_planes - differential, stern * FRAC_PI_6);
        }
    }

    #[test]
    fn a_depth_setpoint_is_limited_and_moves_at_its_rate() {
        let mut controller = controller(&[
            ("depth.max", Value::Double(2.0)),
            ("depth.setpoint_rate", Value::Double(1.0)),
        ]);
        controller.set_setpoint(Quantity::Depth, 5.0).unwrap();
        let mut setpoints = (0..100).map(|tick| controller.on_state(&state(tick)).unwrap().1);
        let first = setpoints.next().unwrap();
        assert_eq!((first.depth_target, first.depth_setpoint), (5.0, 0.0));
        assert_eq!(first.depth_setpoint_source, ControlState::SETPOINT_TOPIC);
        assert!((setpoints.next().unwrap().depth_setpoint - 0.05).abs() < 1e-12);
        assert_eq!(setpoints.last().unwrap().depth_setpoint, 2.0);
    }

    #[test]
    fn a_setpoint_from_the_topic_holds_as_long_as_it_is_allowed_to() {
        let mut controller = controller(&[("setpoint_timeout", Value::Double(0.1))]);
        controller.on_state(&state(0)).unwrap();
        controller.set_setpoint(Quantity::Depth, 5.0).unwrap();
        let mut setpoint = |tick| controller.on_state(&state(tick)).unwrap().1.depth_setpoint;
        assert_eq!([1, 2, 3].map(&mut setpoint), [5.0, 5.0, 0.0]);
        assert_eq!(controller.news().len(), 1);
    }

    #[test]
    fn way_depths_follow_the_distance_run() {
        let mut controller = controller(&[
            ("schedule.distances", Value::DoubleArray(vec![0.0, 10.0])),
            ("schedule.depths", Value::DoubleArray(vec![1.0, 3.0])),
        ]);
        let mut setpoint = |tick, distance| {
            let mut state = state(tick);
            state.distance = distance;
            let (_, control) = controller.on_state(&state).unwrap();
            assert_eq!(
                control.depth_setpoint_source,
                ControlState::SETPOINT_SCHEDULE
            );
            control.depth_setpoint
        };
        assert_eq!(setpoint(0, 100.0), 1.0, "the run begins here");
        assert_eq!(setpoint(1, 109.9), 1.0);
        assert_eq!(setpoint(2, 110.0), 3.0);
    }

    #[test]
    fn an_integral_takes_away_what_a_trim_moment_leaves() {
        // A plant that answers the planes at once and is pulled bow up by 0.1 rad.
        let settled = |gain: f64| {
            let mut controller = controller(&[
                ("mode", Value::from("pitch")),
                ("pitch.i", Value::Double(gain)),
            ]);
            (0..4000).fold(0.1, |pitch, tick| {
                let mut state = state(tick);
                state.pitch = pitch;
                let (command, _) = controller.on_state(&state).unwrap();
                0.9 * pitch + 0.1 * (0.1 - command.dive_planes)
            })
        };
        assert!((settled(0.0) - 0.1 / 1.7).abs() < 1e-9);
        assert!(settled(0.5).abs() < 1e-6);
    }

    #[test]
    fn pitch_is_held_within_the_limit() {
        let mut controller = controller(&[("mode", Value::from("pitch"))]);
        controller.set_setpoint(Quantity::Pitch, -0.2).unwrap();
        let (command, control) = controller.on_state(&state(0)).unwrap();
        assert!((command.dive_planes - 0.7 * 0.2).abs() < 1e-15);
        assert_eq!(control.mode, ControlState::MODE_PITCH);
        controller.set_setpoint(Quantity::Pitch, -3.0).unwrap();
        let (_, control) = controller.on_state(&state(1)).unwrap();
        assert!(control.pitch_command_limited);
        assert_eq!(control.pitch_command, -std::f64::consts::FRAC_PI_4);
    }

    #[test]
    fn silence_puts_the_planes_to_neutral_and_says_so() {
        let mut controller = controller(&[("depth_setpoint", Value::Double(5.0))]);
        controller.on_state(&state(0)).unwrap();
        let (command, control) = controller.on_silence(Time::from_nanos(20 * TICK));
        assert_eq!(command.dive_planes, 0.0);
        assert!(control.feedback_stale);
        assert!(!controller.on_state(&state(1)).unwrap().1.feedback_stale);
    }

    #[test]
    fn what_is_not_finite_is_refused_and_changes_nothing() {
        let mut controller = controller(&[("depth_setpoint", Value::Double(0.1))]);
        let before = controller.on_state(&state(1)).unwrap();
        let mut bad = state(0);
        bad.pitch_rate = f64::NAN;
        assert!(
            controller
                .on_state(&bad)
                .unwrap_err()
                .contains("pitch_rate")
        );
        assert!(
            controller
                .set_setpoint(Quantity::Depth, f64::INFINITY)
                .is_err()
        );
        assert!(controller.set_setpoint(Quantity::Pitch, f64::NAN).is_err());
        assert_eq!(controller.on_state(&state(1)).unwrap(), before);
    }

    fn deep(tick: i64, depth: f64) -> VehicleState {
        let mut state = state(tick);
        state.depth = depth;
        state
    }

    #[test]
    fn below_the_floor_it_climbs_then_goes_neutral_and_stays_so_until_it_is_reset() {
        let mut controller = controller(&[
            ("safety.floor", Value::Double(3.0)),
            ("depth.max", Value::Double(2.5)),
            ("depth_setpoint", Value::Double(2.0)),
        ]);
        let climb = -10_f64.to_radians();
        for (tick, depth, planes) in [
            (0, 3.1, climb),
            (1, 2.8, climb),
            (2, 2.7, 0.0),
            (3, 1.0, 0.0),
        ] {
            let (command, control) = controller.on_state(&deep(tick, depth)).unwrap();
            assert_eq!(command.dive_planes, planes, "tick {tick}");
            assert_eq!(control.fault, ControlState::FAULT_FLOOR);
            assert_eq!(control.climbing, planes != 0.0);
            assert_eq!(command.rudder, 0.0);
        }
        // Neither a new run nor another mode takes it back.
        assert_eq!(
            controller.on_state(&deep(0, 1.0)).unwrap().1.fault,
            ControlState::FAULT_FLOOR
        );
        let goal = ManoeuvreGoal {
            name: "pulse".to_owned(),
            amplitude: 0.1,
            period: 1.0,
            ..ManoeuvreGoal::default()
        };
        let refusal = controller.begin_manoeuvre(&goal).unwrap_err();
        assert!(refusal.contains("safety.floor"), "{refusal}");

        assert_eq!(controller.reset_fault(), Ok(Fault::Floor));
        let (command, control) = controller.on_state(&deep(1, 1.0)).unwrap();
        assert_eq!(control.fault, ControlState::FAULT_NONE);
        assert!(command.dive_planes.abs() < 1e-13, "without a bump");
        let (command, _) = controller.on_state(&deep(2, 1.0)).unwrap();
        assert!(command.dive_planes > 0.0);
        assert!(controller.begin_manoeuvre(&goal).is_ok());
    }

    #[test]
    fn a_manoeuvre_is_broken_off_by_a_fault() {
        let mut controller = controller(&[("safety.pitch", Value::Double(1.0))]);
        let goal = ManoeuvreGoal {
            name: "step".to_owned(),
            amplitude: 0.1,
            duration: 10.0,
            ..ManoeuvreGoal::default()
        };
        controller.begin_manoeuvre(&goal).unwrap();
        assert_eq!(controller.on_state(&state(0)).unwrap().1.manoeuvre, 0.1);
        assert_eq!(controller.manoeuvre_end(), None);
        let mut pitched = state(1);
        pitched.pitch = 1.1;
        let (command, control) = controller.on_state(&pitched).unwrap();
        assert_eq!((command.dive_planes, control.manoeuvre), (0.0, 0.0));
        assert_eq!(control.fault, ControlState::FAULT_BOW_UP);
        let end = controller.manoeuvre_end().unwrap().unwrap_err();
        assert!(end.contains("broken off"), "{end}");
    }

    #[test]
    fn silence_stays_a_fault_where_it_is_to() {
        let mut controller = controller(&[("safety.latch_silence", Value::Bool(true))]);
        controller.on_state(&state(0)).unwrap();
        let (_, control) = controller.on_silence(Time::from_nanos(20 * TICK));
        assert_eq!(control.fault, ControlState::FAULT_SILENCE);
        assert!(controller.reset_fault().unwrap_err().contains("still"));
        let (_, control) = controller.on_state(&state(21)).unwrap();
        assert_eq!(control.fault, ControlState::FAULT_SILENCE);
        assert_eq!(controller.reset_fault(), Ok(Fault::Silence));
        assert_eq!(
            controller.on_state(&state(22)).unwrap().1.fault,
            ControlState::FAULT_NONE
        );
    }

    /// A fixed linear congruential sequence (Numerical Recipes), enough to spread inputs.
    fn draws(count: usize) -> impl Iterator<Item = u32> {
        let mut x = 12345_u32;
        (0..count).map(move |_| {
            x = x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            x
        })
    }

    #[test]
    fn any_finite_state_gives_a_finite_answer_within_the_limits() {
        let limit = std::f64::consts::FRAC_PI_6;
        let numbers = |draw: u32| {
            let extreme = [
                f64::MAX,
                -f64::MAX,
                f64::MIN_POSITIVE,
                0.0,
                -0.0,
                1e300,
                -1e154,
            ];
            match draw >> 29 {
                0 => extreme[(draw >> 16) as usize % extreme.len()],
                n => (f64::from(draw & 0xffff) / 32768.0 - 1.0) * 10_f64.powi(n as i32 * 40 - 120),
            }
        };
        for mode in Mode::NAMES {
            let mut controller = controller(&[
                ("mode", Value::from(*mode)),
                ("depth.p", Value::Double(1e3)),
                ("depth.d", Value::Double(1e3)),
                ("pitch.rate", Value::Double(1e3)),
            ]);
            let draws: Vec<f64> = draws(30_000).map(numbers).collect();
            for (tick, d) in draws.chunks_exact(5).enumerate() {
                let mut state = state(tick as i64);
                (state.depth, state.depth_rate, state.pitch, state.pitch_rate) =
                    (d[0], d[1], d[2], d[3]);
                controller.set_setpoint(Quantity::Depth, d[4]).unwrap();
                let (command, control) = controller.on_state(&state).unwrap();
                assert!(command.dive_planes.abs() <= limit);
                assert_eq!(command.first_non_finite(), None);
                assert_eq!(control.first_non_finite(), None, "{control:?}");
            }
        }
    }
}
