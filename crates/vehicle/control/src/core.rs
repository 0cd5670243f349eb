//! The controller: takes a vehicle state, returns the plane command for the same stamp.
//!
//! **Time** comes from the states: elapsed time and distance start at the first state. A repeated stamp gets the last answer again. An
//! earlier stamp, or a vehicle that was reset (`PLANES_RESET`), begins a new run, with the elapsed time at zero, cleared loops, and the
//! topics' setpoints forgotten.
//!
//! **Depth setpoint**: the last command applies. Before the schedule's first entry this is the parameter `depth_setpoint`, then the
//! schedule. A setpoint from the topic, or a live change of the parameter, then overrides the schedule; a live change of the schedule
//! restores it. With `setpoint_timeout` a setpoint from a topic expires.
//!
//! **Feedback** is the true state, or an [`Estimator`]'s estimate from the instruments, which must be received before
//! the state of their stamp is answered. **Gains** are the parameters', or follow the vehicle ([`Follower`]).
//!
//! A number that is not finite, and a setpoint outside the range of the parameter of its name, is rejected and changes nothing.

use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::action::ManoeuvreGoal;
use planesman_msgs::planesman_msgs::msg::{
    ModelEstimate, MotionEstimate, ThrusterCommand, VehicleState,
};
use planesman_msgs::sensor_msgs::msg::{FluidPressure, Imu};
use planesman_msgs::std_msgs::msg::Header;
use planesman_parameters::Parameters as _;

use crate::answer::{Answer, Basis, answer, feedback_constant};
use crate::autopilot::{Gains, Mode};
use crate::error::Error;
use crate::estimator::{Estimated, Estimator, Source};
use crate::fault::Fault;
use crate::feedback::Feedback;
use crate::gains::{self, Follower, LoopGains};
use crate::goal::{Progress, Underway};
use crate::limits::bounded;
use crate::loops::{LoopTerms, Loops, Tick};
use crate::parameters::{Config, ControllerParameters};
use crate::safety::Safety;
use crate::setpoint::Quantity;

/// The frame of the commands: forward, right, down.
const FRAME: &str = "base_link_frd";

/// The frame of the estimated depth and pitch: forward, starboard, down from the surface.
const ESTIMATE_FRAME: &str = "map_ned";

/// The autopilots with their setpoints.
#[derive(Clone, Debug)]
pub struct Controller {
    config: Config,
    loops: Loops,
    estimator: Estimator,
    follower: Follower,
    /// The estimate used for the last answer; `None` for the true state.
    estimate: Option<MotionEstimate>,
    /// The thrusters' commands of the last answer; `None` if the parameters name no vehicle with thrusters.
    thrusters: Option<ThrusterCommand>,
    safety: Safety,
    /// The last feedback; `None` before the first, and during silence.
    feedback: Option<Feedback>,
    manoeuvre: Option<Underway>,
    /// End of the last manoeuvre, until it is read: completed, or the reason why not.
    manoeuvre_end: Option<Result<(), Error>>,
    run: Option<Run>,
    /// Lines for the log that have not been read yet.
    changes: Vec<String>,
}

/// A run: from the first state until the stamps go back.
#[derive(Clone, Debug)]
struct Run {
    /// The first state's stamp, ns.
    began: i64,
    /// The first state's distance, m.
    from: f64,
    /// The last state's stamp, ns, and the answer to this state.
    last: i64,
    answer: Answer,
    /// Whether states have been missing since, so that everything is neutral.
    silent: bool,
}

impl Controller {
    /// A controller with the parameters' gains and setpoints, before its first state.
    ///
    /// # Errors
    /// [`Error::Parameters`].
    pub fn new(parameters: &ControllerParameters) -> Result<Self, Error> {
        Ok(Self {
            config: Config::new(parameters)?,
            loops: Loops::default(),
            estimator: Estimator::default(),
            follower: Follower::default(),
            estimate: None,
            thrusters: None,
            safety: Safety::default(),
            feedback: None,
            manoeuvre: None,
            manoeuvre_end: None,
            run: None,
            changes: Vec::new(),
        })
    }

    /// Applies all changed parameters, or none if one is refused; they take effect at the next stamp.
    ///
    /// # Errors
    /// [`Error::Parameters`]; then the present parameters stay.
    pub fn set_parameters(&mut self, parameters: &ControllerParameters) -> Result<(), Error> {
        let new = Config::new(parameters)?;
        let old = std::mem::replace(&mut self.config, new);
        if self.config.path.points != old.path.points {
            self.loops.begin_path();
        }
        let setpoints = &mut self.loops.setpoints;
        if self.config.schedule != old.schedule {
            setpoints.depth.forget();
        } else if parameters.depth_setpoint != old.parameters.depth_setpoint {
            setpoints.depth.change(parameters.depth_setpoint);
        }
        let (new, old) = (parameters, &old.parameters);
        if new.pitch_setpoint != old.pitch_setpoint {
            setpoints.pitch.forget();
        }
        if (new.heading_setpoint, new.heading.active) != (old.heading_setpoint, old.heading.active)
        {
            setpoints.heading.forget();
        }
        if (new.speed_setpoint, new.speed.active) != (old.speed_setpoint, old.speed.active) {
            setpoints.speed.forget();
        }
        if new.mode == Mode::Off && old.mode != Mode::Off {
            self.break_off("the controller is off");
        }
        Ok(())
    }

    /// Begins a manoeuvre at the next stamp, replacing a running one.
    ///
    /// # Errors
    /// [`Error::SwitchedOff`], [`Error::FaultStands`], [`Error::Manoeuvre`]; then a running one continues.
    pub fn begin_manoeuvre(&mut self, goal: &ManoeuvreGoal) -> Result<(), Error> {
        if self.config.parameters.mode == Mode::Off {
            return Err(Error::SwitchedOff);
        }
        if let Some(fault) = self.fault() {
            return Err(Error::FaultStands(fault));
        }
        let planes_limit = self.config.dive.planes_limit;
        self.manoeuvre = Some(Underway::new(goal, planes_limit)?);
        self.manoeuvre_end = None;
        Ok(())
    }

    /// The latched fault.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.safety.fault()
    }

    /// Resets the fault; the loops continue with the next state without a bump.
    ///
    /// # Errors
    /// [`Error::NoFault`], [`Error::StillFaulty`], [`Error::StillSilent`].
    pub fn reset_fault(&mut self) -> Result<Fault, Error> {
        if self.feedback.is_none() && self.safety.fault() == Some(Fault::Silence) {
            return Err(Error::StillSilent);
        }
        self.safety
            .reset(&self.config.parameters.safety, self.feedback.as_ref())
    }

    /// Latches a fault.
    fn fail(&mut self, fault: Fault) {
        if self.safety.latch(fault) {
            let text = format!("fault: {}", fault.text());
            self.break_off(&text);
            self.changes.push(text);
        }
    }

    /// Ends the running manoeuvre, if a manoeuvre is running.
    pub fn stop_manoeuvre(&mut self) {
        self.manoeuvre = None;
    }

    /// The progress of the running manoeuvre.
    #[must_use]
    pub fn manoeuvre(&self) -> Option<Progress> {
        self.manoeuvre.as_ref().map(|underway| underway.progress)
    }

    /// End of a manoeuvre that ended by itself: completed, or aborted with the reason.
    pub fn manoeuvre_end(&mut self) -> Option<Result<(), Error>> {
        self.manoeuvre_end.take()
    }

    /// Ends the running manoeuvre for an external reason.
    fn break_off(&mut self, reason: &str) {
        if self.manoeuvre.take().is_some() {
            self.manoeuvre_end = Some(Err(Error::BrokenOff(reason.to_owned())));
        }
    }

    /// Takes a setpoint from the operator, from the next stamp on, and returns it limited to its bounds. A value outside the range of the
    /// parameter `NAME_setpoint` is refused.
    ///
    /// # Errors
    /// [`Error::Setpoint`]; then the last setpoint stays.
    pub fn set_setpoint(&mut self, quantity: Quantity, value: f64) -> Result<f64, Error> {
        let name = quantity.name();
        let parameter = format!("{name}_setpoint");
        let declared = ControllerParameters::declarations().into_iter();
        for declaration in declared.filter(|it| it.name == parameter) {
            let accepted = declaration.accept(value.into());
            accepted.map_err(|refusal| Error::Setpoint(name, refusal.reason))?;
        }
        let elapsed = self.run.as_ref().map_or(0, |run| run.last - run.began);
        self.loops
            .setpoints
            .get_mut(quantity)
            .command(value, elapsed);
        Ok(match quantity {
            Quantity::Depth => self.config.depth_bounds.hold(value),
            Quantity::Pitch => self.config.pitch_bounds.hold(value),
            Quantity::Heading | Quantity::Speed => value,
        })
    }

    /// The time without a state, s, after which the node calls [`Controller::on_silence`].
    #[must_use]
    pub fn state_timeout(&self) -> f64 {
        self.config.parameters.state_timeout
    }

    /// The log lines since the last call.
    pub fn take_changes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.changes)
    }

    /// The plane command for `state`, and every intermediate term.
    ///
    /// # Errors
    /// [`Error::State`]; then nothing changes.
    pub fn on_state(&mut self, state: &VehicleState) -> Result<Answer, Error> {
        if let Some(field) = state.first_non_finite() {
            return Err(Error::State(field.to_string()));
        }
        let stamp = state.header.stamp.nanos();
        let (began, from, last) = match &self.run {
            Some(run) if stamp == run.last => return Ok(run.answer.clone()),
            Some(run) if stamp > run.last && state.planes_source != VehicleState::PLANES_RESET => {
                (run.began, run.from, run.last)
            }
            _ => {
                if self.run.is_some() {
                    self.loops = Loops::default();
                    self.estimator.restart();
                    self.follower = Follower::default();
                    self.break_off("the vehicle restarted");
                }
                (stamp, state.distance, stamp)
            }
        };
        let tick = Tick {
            elapsed: stamp - began,
            distance: bounded(state.distance - from),
            dt: match &self.run {
                // What was not controlled is not integrated.
                Some(run) if run.silent => 0.0,
                _ => (stamp - last) as f64 * 1e-9,
            },
        };
        let answer = self.answer(state, tick);
        self.run = Some(Run {
            began,
            from,
            last: stamp,
            answer: answer.clone(),
            silent: false,
        });
        Ok(answer)
    }

    /// The answer at the time `now`, after no state has come for [`Controller::state_timeout`]: everything neutral, flagged. The run
    /// continues with the next state.
    ///
    /// The stamp of this message is 1 ns after the last state's, so that a state that is only late can still be answered in the order of the stamps.
    #[must_use]
    pub fn on_silence(&mut self, now: Time) -> Answer {
        self.break_off("no vehicle state");
        self.feedback = None;
        let stamp = match &mut self.run {
            Some(run) => {
                run.silent = true;
                Time::from_nanos(run.last + 1)
            }
            None => now,
        };
        if self.config.parameters.safety.latch_silence {
            self.fail(Fault::Silence);
        }
        self.neutral(stamp)
    }

    /// Sets everything neutral because feedback is missing.
    fn neutral(&mut self, stamp: Time) -> Answer {
        self.loops.neutralised();
        self.message(stamp, None, &LoopTerms::default())
    }

    fn message(&mut self, stamp: Time, basis: Option<&Basis>, terms: &LoopTerms) -> Answer {
        self.thrusters = self.config.thrusters.as_ref().map(|of| ThrusterCommand {
            header: self.header(stamp.clone()),
            name: of.names.clone(),
            command: match terms.thrusters.is_empty() {
                true => vec![0.0; of.names.len()],
                false => terms.thrusters.clone(),
            },
        });
        let (mode, fault) = (self.config.parameters.mode, self.fault());
        answer(self.header(stamp), mode, fault, basis, terms)
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

    /// Whether the loops use the instruments instead of the true state.
    #[must_use]
    pub fn reads_instruments(&self) -> bool {
        self.config.feedback.source != Source::Truth
    }

    /// Whether the controller's gains follow an identified model.
    #[must_use]
    pub fn reads_models(&self) -> bool {
        self.config.following.source == gains::Source::Adaptive
    }

    /// Whether all instruments needed for the answer to this stamp have been received.
    #[must_use]
    pub fn ready_for(&self, stamp: &Time) -> bool {
        self.estimator.ready(stamp.nanos(), &self.config.feedback)
    }

    /// The estimate used for the last answer; `None` for the true state.
    #[must_use]
    pub fn estimate(&self) -> Option<&MotionEstimate> {
        self.estimate.as_ref()
    }

    /// Whether the controller commands thrusters.
    #[must_use]
    pub fn has_thrusters(&self) -> bool {
        self.config.thrusters.is_some()
    }

    /// The thrusters' commands of the last answer; `None` if `hover.vehicle` names no vehicle.
    #[must_use]
    pub fn thrusters(&self) -> Option<&ThrusterCommand> {
        self.thrusters.as_ref()
    }

    /// The gains for this feedback at a tick, and whether these gains come from an identified model.
    fn gains(&mut self, feedback: &Feedback, stamp: i64, dt: f64) -> (Gains, bool) {
        let rules = &self.config.following;
        let (followed, adapted) = self.follower.gains(rules, feedback.speed, stamp, dt);
        self.changes.extend(self.follower.take_changes());
        let LoopGains {
            depth_p,
            depth_d,
            pitch_p,
            pitch_rate,
        } = followed;
        let mut gains = self.config.gains;
        (gains.depth.p, gains.depth.d) = (depth_p, depth_d);
        (gains.pitch.p, gains.pitch.rate) = (pitch_p, pitch_rate);
        (gains, adapted)
    }

    fn header(&self, stamp: Time) -> Header {
        Header {
            stamp,
            frame_id: [self.config.parameters.frame_prefix.as_str(), FRAME].concat(),
        }
    }

    /// The estimate as a message.
    fn estimate_message(&self, stamp: Time, estimated: &Estimated) -> MotionEstimate {
        let estimate = &estimated.estimate;
        MotionEstimate {
            header: Header {
                stamp,
                frame_id: [self.config.parameters.frame_prefix.as_str(), ESTIMATE_FRAME].concat(),
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

    /// All commands at a tick.
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
            self.changes
                .push("the estimate is not finite; the estimator is restarted, and the planes go to neutral".to_owned());
            return self.neutral(stamp.clone());
        }
        self.estimate = estimated.map(|estimated| self.estimate_message(stamp.clone(), &estimated));
        self.feedback = Some(feedback);
        if let Some(fault) = self.config.parameters.safety.violated(&feedback) {
            self.fail(fault);
        }
        let (gains, adapted) = self.gains(&feedback, stamp.nanos(), tick.dt);
        self.expire_setpoints(tick);
        let envelope = self.config.parameters.safety;
        let terms = match self.safety.react(&envelope, &feedback, tick.dt) {
            Some(reaction) => self
                .loops
                .emergency(&self.config, reaction, &feedback, tick.dt),
            None => {
                let manoeuvre = match self.config.parameters.mode {
                    Mode::Off => 0.0,
                    _ => self.manoeuvre_offset(tick.elapsed),
                };
                let law = (&self.config, &gains);
                self.loops.step(law, &feedback, tick, manoeuvre)
            }
        };
        let basis = Basis {
            depth_rate: feedback.depth_rate,
            source: self.config.feedback.source,
            instruments_missing: estimated.is_some_and(|estimated| estimated.missing),
            gains,
            adapted,
        };
        self.message(stamp.clone(), Some(&basis), &terms)
    }

    /// Forgets setpoints from topics that are too old.
    fn expire_setpoints(&mut self, tick: Tick) {
        let timeout = self.config.parameters.setpoint_timeout;
        for quantity in Quantity::ALL {
            if self
                .loops
                .setpoints
                .get_mut(quantity)
                .expire(timeout, tick.elapsed)
            {
                let name = quantity.name();
                self.changes.push(format!(
                    "no {name} setpoint for {timeout} s: the controller uses the parameter instead"
                ));
            }
        }
    }

    /// The offset of the running manoeuvre on the planes, rad; ends the manoeuvre when it is over.
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
}
