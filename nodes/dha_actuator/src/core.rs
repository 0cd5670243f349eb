//! The actuator node's core: a plane command in, the coming tick's plane motion out.
//!
//! **A tick** is [t, t + tick]. The command stamped t acts on every valve cycle that begins in
//! [t, t + tick); the cycles run on the actuator's own clock, which starts with the first stamp.
//! The motion is computed ahead on a copy, so that any next stamp can follow: one that leaves
//! out ticks, or one before the tick's end.
//!
//! **Commands hold** for `command_timeout` from their stamp; then neutral planes are asked for,
//! and `command_stale` says so. Before the first command neutral is asked for too.
//!
//! **Stamps**: the last command's stamp again gets the last answer again. A command that comes
//! late, after its tick was answered in silence, gets that answer, and acts from the next tick
//! on. A stamp before the last command's is a clock set back, and one 600 s beyond the last tick
//! a clock set on: both begin a new run, planes neutral and at rest.
//!
//! In `dha_state` what is physical is at the stamp; the pulses, `inhibited`, `error` and
//! `commanded_angle` are of the decisions within the tick.
//!
//! **Groups.** Together, one actuator moves the bow and stern planes; the differentials and the
//! rudder pass through at once and unquantised, clipped to `command_limit`, held over the tick, and
//! are left empty (neutral) where they are 0 or the command is stale. Each for itself, bow, stern,
//! roll and rudder have an actuator each ([`crate::groups`]). The thrust always passes through,
//! clipped to \[-1, 1\].
//!
//! What is not finite is refused and changes nothing. The same inputs give the same outputs,
//! bit for bit, however a stretch of time is divided into ticks.

use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::{Duration, Time};
use planesman_msgs::planesman_msgs::msg::{DhaState, PlaneCommand, PlaneMotion};
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_msgs::std_msgs::msg::Header;

use crate::actuator_file;
use crate::actuator_model::{ActuatorModel, Model, Planes, Request};
use crate::actuator_set::{ActuatorSet, MOST_CYCLES_IN_FLIGHT};
use crate::dha::Demand;
use crate::groups::{Group, Grouping};
use crate::modes::Load;
use crate::parameters::{ActuatorParameters, Config, Member};

/// The frame the plane angles are given in: forward, right, down.
const FRAME: &str = "base_link_frd";

/// A longer gap between stamps is not caught up, ns.
const LONGEST_GAP: i64 = 600_000_000_000;

/// The most samples of motion in a tick.
const MOST_SAMPLES: i64 = 100_000;

/// What a command is answered with.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// The plane angle over the tick.
    pub motion: PlaneMotion,
    /// Planes and rams at the stamp.
    pub planes: JointState,
    /// The actuators inside, a state for each group.
    pub states: Vec<DhaState>,
}

impl Output {
    /// What keeps planes from where they are asked to be: a line for each group at its limit.
    #[must_use]
    pub fn limits(&self) -> Vec<String> {
        let told = |state: &DhaState| {
            let limit = if state.at_stop {
                "at its stop"
            } else if state.inhibited {
                "at its travel limit"
            } else {
                return None;
            };
            Some(format!("{}: {limit}", state.group))
        };
        self.states.iter().filter_map(told).collect()
    }
}

/// The actuators with their messages.
#[derive(Clone, Debug)]
pub struct Actuator {
    /// The constants of each group's actuator.
    sets: Vec<ActuatorSet>,
    config: Config,
    tick: i64,
    run: Option<Run>,
}

/// A run: from the first stamp on, until the clock is set back.
#[derive(Clone, Debug)]
struct Run {
    /// The first stamp, ns.
    began: i64,
    /// The last tick's stamp, ns, and each group's actuator there.
    stamp: i64,
    now: Vec<ActuatorModel>,
    /// The actuators at the last tick's end.
    ahead: Vec<ActuatorModel>,
    /// What the last tick was computed with.
    acting: Asked,
    /// The last command, clipped.
    command: Option<Held>,
    output: Output,
    /// What the tick before was answered with.
    before: Option<Output>,
}

/// A command as far as it is obeyed, and its stamp, ns.
#[derive(Clone, Debug)]
struct Held {
    command: PlaneCommand,
    stamp: i64,
}

impl Held {
    /// The command with its angles clipped to `limit`, rad.
    fn new(command: &PlaneCommand, limit: f64) -> Self {
        Self {
            stamp: command.header.stamp.nanos(),
            command: PlaneCommand {
                dive_planes: command.dive_planes.clamp(-limit, limit),
                bow_stern_differential: command.bow_stern_differential.clamp(-limit, limit),
                roll_differential: command.roll_differential.clamp(-limit, limit),
                rudder: command.rudder.clamp(-limit, limit),
                thrust: command.thrust.clamp(-1.0, 1.0),
                ..PlaneCommand::default()
            },
        }
    }
}

/// A value held over a tick as samples; none for 0, which is neutral.
fn held_samples(value: f64) -> Vec<f64> {
    if value == 0.0 {
        Vec::new()
    } else {
        vec![value; 2]
    }
}

/// What is asked for: a request to each group until a deadline, ns, then neutral planes.
#[derive(Clone, Debug)]
struct Asked {
    requests: Vec<Request>,
    deadline: i64,
}

impl Asked {
    /// The request to the group `index` that is in force at `stamp`.
    fn at(&self, index: usize, stamp: i64) -> Request {
        let mut request = self.requests[index];
        if stamp >= self.deadline {
            request.demand.angle = 0.0;
        }
        request
    }

    /// Runs the group `index` from one stamp to another, both in ns, in a run that began at
    /// `began`.
    fn drive(&self, index: usize, model: &mut ActuatorModel, began: i64, from: i64, to: i64) {
        if from < self.deadline {
            model.advance_to(to.min(self.deadline) - began, &self.requests[index]);
        }
        if to > self.deadline {
            model.advance_to(to - began, &self.at(index, self.deadline));
        }
    }
}

/// Whether the parameters fit the actuators.
fn fit(config: &Config, sets: &[ActuatorSet]) -> Result<(), String> {
    if let Some(group) = config.faults.group
        && !config.grouping.groups().contains(&group)
    {
        let groups: Vec<_> = config.grouping.groups().iter().map(|g| g.name()).collect();
        return Err(format!(
            "fault.group '{}' has no actuator; all, {} have",
            group.name(),
            groups.join(", ")
        ));
    }
    let mut ill = config.members.iter().map(|m| config.fault_words(m));
    let faults = config.faults.condition.faults_beside(&config.worn);
    if !faults.is_empty() && ill.all(|words| words.is_empty()) {
        let whom = config.faults.group.map_or("all", Group::name);
        return Err(format!(
            "fault.*: in fault.group '{whom}' there is no digital hydraulic actuator that could fail"
        ));
    }
    let hydraulic = |member: &&Member| member.model == Model::Dha;
    for (member, set) in config
        .members
        .iter()
        .zip(sets)
        .filter(|(m, _)| hydraulic(m))
    {
        let (name, actuator) = (member.group.name(), &member.actuator);
        if config.logic.two_speed && set.small.is_none() {
            return Err(format!(
                "logic.mode is two-speed, but the actuator '{actuator}' of the {name} has no small_volume; auv_two_speed has one"
            ));
        }
        let slow_latch = config.condition(member.group).slow_latch;
        let last = set.delay() + slow_latch + 2.0 * set.flow_time;
        if slow_latch > 0.0 && last > set.cycle() * MOST_CYCLES_IN_FLIGHT as f64 {
            return Err(format!(
                "fault.slow_latch '{slow_latch}' refused: a volume of the actuator '{actuator}' would arrive later than {MOST_CYCLES_IN_FLIGHT} valve cycles"
            ));
        }
    }
    Ok(())
}

impl Actuator {
    /// The actuator the parameters name, for ticks of `tick_nanos` ns, before its first stamp.
    ///
    /// # Errors
    /// The line to show: an actuator file that is refused, or a tick that is not positive.
    pub fn new(parameters: &ActuatorParameters, tick_nanos: i64) -> Result<Self, String> {
        let config = Config::new(parameters);
        if tick_nanos <= 0 {
            return Err(format!(
                "tick of {tick_nanos} ns refused: it must be positive"
            ));
        }
        let sets = config
            .members
            .iter()
            .map(|member| actuator_file::load(&member.actuator).map_err(|error| error.to_string()))
            .collect::<Result<Vec<_>, _>>()?;
        fit(&config, &sets)?;
        Ok(Self {
            sets,
            config,
            tick: tick_nanos,
            run: None,
        })
    }

    /// The groups with an actuator, in the order of [`Output::states`].
    #[must_use]
    pub fn groups(&self) -> &'static [Group] {
        self.config.grouping.groups()
    }

    /// What is wrong with the actuators, a line for each group that is ill.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let told = |member: &Member| {
            let faults = self.config.fault_words(member);
            let name = member.group.name();
            (!faults.is_empty()).then(|| format!("{name}: {}", faults.join("; ")))
        };
        self.config.members.iter().filter_map(told).collect()
    }

    /// Takes changed parameters; they take effect at the next tick.
    ///
    /// # Errors
    /// When `groups` or what moves them differs, which is fixed from the start, or when the
    /// parameters do not fit the actuators. Nothing changes then.
    pub fn set_parameters(&mut self, parameters: &ActuatorParameters) -> Result<(), String> {
        let new = Config::new(parameters);
        if new.members != self.config.members {
            return Err(
                "groups, actuators and models are fixed once the actuator has started".to_owned(),
            );
        }
        fit(&new, &self.sets)?;
        self.config = new;
        Ok(())
    }

    /// The motion over the tick that begins at the command's stamp.
    ///
    /// # Errors
    /// When a number in the command is not finite; the actuator is then as it was.
    pub fn on_command(&mut self, command: &PlaneCommand) -> Result<Output, String> {
        if let Some(field) = command.first_non_finite() {
            return Err(format!("plane command refused: {field} is not finite"));
        }
        let stamp = command.header.stamp.nanos();
        let held = Held::new(command, self.config.command_limit);
        let Some(run) = &mut self.run else {
            return Ok(self.begin(stamp, Some(held)));
        };
        match &run.command {
            Some(last) if stamp == last.stamp => return Ok(run.output.clone()),
            Some(last) if stamp < last.stamp => return Ok(self.begin(stamp, Some(held))),
            None if stamp < run.stamp => return Ok(self.begin(stamp, Some(held))),
            _ => {}
        }
        if stamp <= run.stamp {
            // Its tick was answered in silence.
            run.command = Some(held);
            return Ok(run.output.clone());
        }
        if stamp.saturating_sub(run.stamp) > LONGEST_GAP {
            return Ok(self.begin(stamp, Some(held)));
        }
        Ok(self.go_on(stamp, Some(held)))
    }

    /// What the tick before the last one was answered with, in the same run: said again when a command is, to
    /// whoever waits for the motion that led to the present state.
    #[must_use]
    pub fn before(&self) -> Option<&Output> {
        self.run.as_ref()?.before.as_ref()
    }

    /// The motion over a tick for which no command has come. A stamp already answered gets its
    /// answer again.
    pub fn on_silence(&mut self, stamp: Time) -> Output {
        let stamp = stamp.nanos();
        match &self.run {
            None => self.begin(stamp, None),
            Some(run) if stamp <= run.stamp => run.output.clone(),
            Some(run) if stamp.saturating_sub(run.stamp) > LONGEST_GAP => self.begin(stamp, None),
            Some(run) => {
                let held = run.command.clone();
                self.go_on(stamp, held)
            }
        }
    }

    /// Starts a new run and answers its first tick.
    fn begin(&mut self, stamp: i64, command: Option<Held>) -> Output {
        let models = self
            .config
            .members
            .iter()
            .zip(&self.sets)
            .map(|(member, set)| ActuatorModel::new(member.model, set, self.config.lag))
            .collect();
        self.run = None;
        self.answer(stamp, stamp, models, command)
    }

    /// Brings the run to `stamp` under what was asked for, and answers the tick from there.
    fn go_on(&mut self, stamp: i64, command: Option<Held>) -> Output {
        let Some(run) = &self.run else {
            return self.begin(stamp, command);
        };
        let tick_end = run.stamp.saturating_add(self.tick);
        let (mut models, from) = if stamp >= tick_end {
            (run.ahead.clone(), tick_end)
        } else {
            (run.now.clone(), run.stamp)
        };
        for (index, model) in models.iter_mut().enumerate() {
            run.acting.drive(index, model, run.began, from, stamp);
        }
        let began = run.began;
        self.answer(began, stamp, models, command)
    }

    /// Computes the tick from `stamp`, where the actuators are `now`, and remembers it.
    fn answer(
        &mut self,
        began: i64,
        stamp: i64,
        mut now: Vec<ActuatorModel>,
        command: Option<Held>,
    ) -> Output {
        let acting = self.asked(stamp, command.as_ref());
        for (index, model) in now.iter_mut().enumerate() {
            model.ask(&acting.at(index, stamp));
            if let ActuatorModel::Dha(dha) = model {
                // Counted is what the tick ahead brings.
                dha.take_tally();
            }
        }
        let planes: Vec<Planes> = now.iter().map(|m| m.planes(stamp - began)).collect();
        let mut ahead = now.clone();
        let angles = ahead
            .iter_mut()
            .enumerate()
            .map(|(index, model)| self.angles(&acting, index, model, began, stamp))
            .collect();

        let header = Header {
            stamp: Time::from_nanos(stamp),
            frame_id: FRAME.to_owned(),
        };
        let obeyed = command.as_ref().filter(|_| stamp < acting.deadline);
        let states = (0..planes.len())
            .map(|index| DhaState {
                commanded_angle: acting.at(index, stamp).demand.angle,
                command_stale: stamp >= acting.deadline,
                ..self.state(&header, index, &planes[index], &mut ahead[index])
            })
            .collect();
        let output = Output {
            motion: self.motion(&header, obeyed, angles),
            planes: self.joints(&header, &planes),
            states,
        };
        self.run = Some(Run {
            before: self.run.take().map(|last| last.output),
            began,
            stamp,
            now,
            ahead,
            acting,
            command,
            output: output.clone(),
        });
        output
    }

    /// Runs the group `index` over the tick from `stamp`, and returns its angle at the samples.
    fn angles(
        &self,
        acting: &Asked,
        index: usize,
        model: &mut ActuatorModel,
        began: i64,
        stamp: i64,
    ) -> Vec<f64> {
        let intervals = (self.tick as u64)
            .div_ceil(self.config.sample_interval.max(1) as u64)
            .clamp(1, MOST_SAMPLES as u64) as i64;
        let mut angles = Vec::with_capacity(intervals as usize + 1);
        angles.push(model.planes(stamp - began).angle);
        let mut from = stamp;
        for i in 1..=intervals {
            let share = i128::from(self.tick) * i128::from(i) / i128::from(intervals);
            let to = stamp.saturating_add(share as i64);
            acting.drive(index, model, began, from, to);
            angles.push(model.planes(to - began).angle);
            from = to;
        }
        angles
    }

    /// The tick's motion: what the actuators do, and what passes through.
    fn motion(&self, header: &Header, obeyed: Option<&Held>, angles: Vec<Vec<f64>>) -> PlaneMotion {
        let through = |of: fn(&PlaneCommand) -> f64| {
            obeyed.map_or_else(Vec::new, |held| held_samples(of(&held.command)))
        };
        let mut motion = PlaneMotion {
            header: header.clone(),
            duration: Duration::from_nanos(self.tick),
            dive_planes: Vec::new(),
            bow_stern_differential: through(|command| command.bow_stern_differential),
            roll_differential: through(|command| command.roll_differential),
            rudder: through(|command| command.rudder),
            thrust: through(|command| command.thrust),
        };
        self.config.grouping.fill(&mut motion, angles);
        motion
    }

    /// What a command, or none, asks for from `stamp` on.
    fn asked(&self, stamp: i64, command: Option<&Held>) -> Asked {
        let config = &self.config;
        let deadline = match command {
            // At its own stamp a command is never stale.
            Some(held) if held.stamp == stamp => {
                stamp.saturating_add(config.command_timeout.max(1))
            }
            Some(held) => held.stamp.saturating_add(config.command_timeout),
            None => i64::MIN,
        };
        let limit = config.command_limit;
        let request = |group: Group| Request {
            demand: Demand {
                angle: command.map_or(0.0, |held| group.angle(&held.command).clamp(-limit, limit)),
                position_loop: config.position_loop,
                logic: config.logic,
                condition: config.condition(group),
            },
            lag: config.lag,
        };
        Asked {
            requests: self.groups().iter().map(|group| request(*group)).collect(),
            deadline,
        }
    }

    /// Each group's planes and ram by name; the dive planes, bow and stern together, first.
    fn joints(&self, header: &Header, planes: &[Planes]) -> JointState {
        let mut joints = JointState {
            header: header.clone(),
            ..JointState::default()
        };
        let mut add = |name: String, angle: f64, rate: f64| {
            joints.name.push(name);
            joints.position.push(angle);
            joints.velocity.push(rate);
        };
        if self.config.grouping == Grouping::Each {
            let mean = |of: fn(&Planes) -> f64| 0.5 * (of(&planes[0]) + of(&planes[1]));
            add(
                Group::DivePlanes.name().to_owned(),
                mean(|planes| planes.angle),
                mean(|planes| planes.rate),
            );
        }
        for ((group, planes), set) in self.groups().iter().zip(planes).zip(&self.sets) {
            let ram = match group {
                Group::DivePlanes => "ram".to_owned(),
                other => format!("{}_ram", other.name()),
            };
            add(group.name().to_owned(), planes.angle, planes.rate);
            let arm = set.moment_arm;
            add(ram, planes.angle * arm, planes.rate * arm);
        }
        joints
    }

    /// The state of the group `index`: what is physical at the stamp, what is decided from the
    /// tick ahead.
    fn state(
        &self,
        header: &Header,
        index: usize,
        planes: &Planes,
        ahead: &mut ActuatorModel,
    ) -> DhaState {
        let member = &self.config.members[index];
        let moment_arm = self.sets[index].moment_arm;
        let mut state = DhaState {
            header: header.clone(),
            group: member.group.name().to_owned(),
            ram: planes.angle * moment_arm,
            ram_velocity: planes.rate * moment_arm,
            plane_angle: planes.angle,
            sign: 1,
            faults: self.config.fault_words(member).join("; "),
            ..DhaState::default()
        };
        if let Some(reading) = planes.reading {
            state.pressure = reading.pressure;
            state.volume = reading.ram.volume;
            state.leakage = reading.leaked;
            state.sign = reading.polarity;
            state.sliding = matches!(reading.mode.load, Load::Sliding(_));
            state.at_stop =
                matches!(reading.mode.load, Load::AtStop(_)) || reading.mode.limited.is_some();
            state.pressure_limited = reading.mode.clamped.is_some();
        }
        if let ActuatorModel::Dha(dha) = ahead {
            let tally = dha.take_tally();
            state.pulses = dha.pulses();
            state.small_pulses = dha.small_pulses();
            state.sign_changes = dha.sign_changes();
            state.inhibited = tally.inhibited;
            state.slewing = tally.slews();
            state.hydraulic_power = tally.work / (self.tick as f64 * 1e-9);
            state.error = dha.error();
            if let Some(cycle) = dha.limit_cycle() {
                state.limit_cycle_frequency = cycle.frequency;
                state.limit_cycle_amplitude = cycle.amplitude;
            }
        }
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_parameters::{Parameters as _, Value};

    const TICK: i64 = 50_000_000;

    fn with(changes: &[(&str, Value)]) -> ActuatorParameters {
        ActuatorParameters::default()
            .with(changes)
            .expect("declared")
    }

    fn actuator(changes: &[(&str, Value)]) -> Actuator {
        Actuator::new(&with(changes), TICK).expect("valid")
    }

    fn command(nanos: i64, angle: f64) -> PlaneCommand {
        let mut command = PlaneCommand {
            dive_planes: angle,
            ..PlaneCommand::default()
        };
        command.header.stamp = Time::from_nanos(nanos);
        command
    }

    fn answer(actuator: &mut Actuator, nanos: i64, angle: f64) -> Output {
        actuator.on_command(&command(nanos, angle)).expect("finite")
    }

    #[test]
    fn a_tick_of_motion_has_51_samples_and_the_next_goes_on_where_it_ends() {
        let mut actuator = actuator(&[]);
        let mut end = 0.0;
        for k in 0..40 {
            let output = answer(&mut actuator, k * TICK, 0.2);
            assert_eq!(output.motion.dive_planes.len(), 51);
            assert_eq!(output.motion.duration, Duration::from_nanos(TICK));
            assert_eq!(output.motion.dive_planes[0], end);
            assert_eq!(output.states[0].plane_angle, end);
            assert_eq!(output.planes.position[0], end);
            assert_eq!(output.planes.name, ["dive_planes", "ram"]);
            end = output.motion.dive_planes[50];
        }
        assert!((end - 0.2).abs() < 0.01, "{end}");
    }

    #[test]
    fn the_command_is_clipped_to_thirty_degrees() {
        let mut actuator = actuator(&[]);
        let mut last = None;
        for k in 0..60 {
            last = Some(answer(&mut actuator, k * TICK, -3.0));
        }
        let last = last.expect("answered");
        let thirty = 30f64.to_radians();
        assert!((last.states[0].commanded_angle + thirty).abs() < 1e-12);
        assert!((last.states[0].plane_angle + thirty).abs() < 0.5f64.to_radians());
    }

    #[test]
    fn roll_rudder_and_thrust_pass_through_until_the_command_is_stale() {
        let mut actuator = actuator(&[]);
        let asked = PlaneCommand {
            roll_differential: 0.1,
            rudder: -3.0,
            thrust: 2.0,
            ..command(0, 0.0)
        };
        let motion = actuator.on_command(&asked).expect("finite").motion;
        assert_eq!(motion.roll_differential, [0.1, 0.1]);
        assert_eq!(motion.rudder, [-std::f64::consts::FRAC_PI_6; 2]);
        assert_eq!(motion.thrust, [1.0, 1.0]);
        let held = actuator.on_silence(Time::from_nanos(TICK)).motion;
        assert_eq!(held.thrust, [1.0, 1.0]);
        let stale = actuator.on_silence(Time::from_nanos(100 * TICK)).motion;
        assert!(stale.thrust.is_empty() && stale.rudder.is_empty());
        assert!(stale.roll_differential.is_empty());
    }

    #[test]
    fn the_same_stamp_gets_the_same_answer() {
        let mut actuator = actuator(&[]);
        answer(&mut actuator, 0, 0.1);
        let first = answer(&mut actuator, TICK, 0.1);
        assert_eq!(answer(&mut actuator, TICK, 0.1), first);
        assert_eq!(actuator.on_silence(Time::from_nanos(TICK)), first);
        let mut undisturbed = actuator.clone();
        assert_eq!(
            answer(&mut actuator, 2 * TICK, 0.1),
            answer(&mut undisturbed, 2 * TICK, 0.1)
        );
    }

    #[test]
    fn the_tick_before_can_be_told_again_until_a_new_run_begins() {
        let mut actuator = actuator(&[]);
        assert_eq!(actuator.before(), None);
        let first = answer(&mut actuator, 0, 0.1);
        assert_eq!(actuator.before(), None);
        let second = answer(&mut actuator, TICK, 0.1);
        assert_eq!(actuator.before(), Some(&first));
        answer(&mut actuator, TICK, 0.1);
        assert_eq!(actuator.before(), Some(&first), "a repeat changes nothing");
        answer(&mut actuator, 2 * TICK, 0.1);
        assert_eq!(actuator.before(), Some(&second));
        answer(&mut actuator, 0, 0.1);
        assert_eq!(actuator.before(), None, "a new run");
    }

    #[test]
    fn left_out_ticks_are_caught_up_by_holding_the_command() {
        let (mut every, mut some) = (actuator(&[]), actuator(&[]));
        for k in 0..8 {
            answer(&mut every, k * TICK, 0.3);
        }
        answer(&mut some, 0, 0.3);
        assert_eq!(
            answer(&mut every, 8 * TICK, 0.1),
            answer(&mut some, 8 * TICK, 0.1)
        );
    }

    #[test]
    fn a_stamp_within_the_tick_cuts_it_short() {
        let mut whole = Actuator::new(&with(&[]), TICK).expect("valid");
        let mut long = Actuator::new(&with(&[]), 10 * TICK).expect("valid");
        for k in 0..30 {
            let angle = 0.3 * (k as f64).sin();
            let a = answer(&mut whole, k * TICK, angle);
            let b = answer(&mut long, k * TICK, angle);
            assert_eq!(a.planes, b.planes);
            assert_eq!(a.states[0].volume, b.states[0].volume);
        }
    }

    #[test]
    fn without_commands_the_planes_hold_and_then_go_to_neutral_flagged() {
        let mut actuator = actuator(&[]);
        for k in 0..20 {
            answer(&mut actuator, k * TICK, 0.3);
        }
        let mut silent = |k: i64| actuator.on_silence(Time::from_nanos(k * TICK)).states[0].clone();
        let held = (20..29).map(&mut silent).next_back().expect("answered");
        assert!(!held.command_stale && held.commanded_angle == 0.3);
        let stale = silent(29);
        assert!(stale.command_stale && stale.commanded_angle == 0.0);
        let neutral = (30..60).map(&mut silent).next_back().expect("answered");
        assert!(neutral.plane_angle.abs() < 0.5f64.to_radians());
        let back = answer(&mut actuator, 60 * TICK, 0.1).states[0].clone();
        assert!(!back.command_stale && back.commanded_angle == 0.1);
    }

    #[test]
    fn before_the_first_command_neutral_is_asked_for() {
        let mut actuator = actuator(&[]);
        let first = actuator.on_silence(Time::from_nanos(0)).states[0].clone();
        assert!(first.command_stale && first.commanded_angle == 0.0);
    }

    #[test]
    fn a_command_after_its_tick_was_answered_in_silence_acts_from_the_next_on() {
        let mut actuator = actuator(&[]);
        answer(&mut actuator, 0, 0.0);
        let silent = actuator.on_silence(Time::from_nanos(2 * TICK));
        assert_eq!(answer(&mut actuator, TICK, 0.2), silent);
        let next = actuator.on_silence(Time::from_nanos(3 * TICK));
        assert_eq!(next.states[0].commanded_angle, 0.2);
    }

    #[test]
    fn a_clock_set_back_or_far_on_begins_a_new_run() {
        let mut fresh = actuator(&[]);
        let first = answer(&mut fresh, 0, 0.2);
        let mut used = actuator(&[]);
        for k in 100..140 {
            answer(&mut used, k * TICK, 0.3);
        }
        assert_eq!(answer(&mut used, 0, 0.2), first);
        let far = answer(&mut used, 3_600_000_000_000, 0.2);
        assert_eq!(far.motion.dive_planes, first.motion.dive_planes);
        assert_eq!(far.states[0].pulses, first.states[0].pulses);
    }

    #[test]
    fn what_is_not_finite_is_refused_and_changes_nothing() {
        let mut actuator = actuator(&[]);
        answer(&mut actuator, 0, 0.2);
        let before = format!("{actuator:?}");
        for bad in [f64::NAN, f64::INFINITY] {
            let error = actuator
                .on_command(&command(TICK, bad))
                .expect_err("refused");
            assert!(error.contains("dive_planes"), "{error}");
        }
        assert_eq!(format!("{actuator:?}"), before);
    }

    #[test]
    fn no_stamp_is_beyond_it() {
        let mut actuator = actuator(&[]);
        let seconds = 1_000_000_000 * i64::from(i32::MAX);
        for stamp in [0, seconds, -seconds, 1, seconds - 1, seconds] {
            let output = answer(&mut actuator, stamp, 0.1);
            assert!(
                output
                    .motion
                    .dive_planes
                    .iter()
                    .all(|angle| angle.is_finite())
            );
        }
    }

    #[test]
    fn the_ideal_actuator_is_at_its_command_at_once() {
        let mut actuator = actuator(&[("model", Value::from("ideal"))]);
        let output = answer(&mut actuator, 0, 0.25);
        assert!(output.motion.dive_planes.iter().all(|angle| *angle == 0.25));
        assert_eq!(output.states[0].plane_angle, 0.25);
    }

    #[test]
    fn the_first_order_actuator_slews_and_settles() {
        let mut actuator = actuator(&[("model", Value::from("first_order"))]);
        let motion = answer(&mut actuator, 0, 0.5).motion.dive_planes;
        let rate = (motion[50] - motion[10]) / 0.04;
        assert!((rate.to_degrees() - 40.0).abs() < 1e-9, "{rate}");
        let last = (1..30).map(|k| answer(&mut actuator, k * TICK, 0.5)).last();
        let state = last.expect("answered").states[0].clone();
        assert!((state.plane_angle - 0.5).abs() < 1e-9);
        assert_eq!((state.pressure, state.pulses), (0.0, 0));
    }

    /// Bow, stern, roll and rudder with an actuator each.
    fn each(changes: &[(&str, Value)]) -> Actuator {
        let mut all = vec![("groups", Value::from("each"))];
        all.extend_from_slice(changes);
        actuator(&all)
    }

    #[test]
    fn each_group_follows_its_own_command_with_its_own_actuator() {
        let mut actuator = each(&[
            ("bow.actuator", Value::from("auv_two_speed")),
            ("roll.model", Value::from("first_order")),
            ("rudder.model", Value::from("ideal")),
        ]);
        let mut last = None;
        for k in 0..40 {
            let asked = PlaneCommand {
                bow_stern_differential: 0.125,
                roll_differential: -0.2,
                rudder: 0.3,
                ..command(k * TICK, 0.25)
            };
            last = Some(actuator.on_command(&asked).expect("finite"));
        }
        let Output {
            motion,
            planes,
            states,
        } = last.expect("answered");
        let close = |angle: f64, asked: f64| assert!((angle - asked).abs() < 0.015, "{angle}");
        for (state, (group, asked)) in states.iter().zip([
            ("bow", 0.375),
            ("stern", 0.125),
            ("roll", -0.2),
            ("rudder", 0.3),
        ]) {
            assert_eq!(
                (state.group.as_str(), state.commanded_angle),
                (group, asked)
            );
            close(state.plane_angle, asked);
        }
        // The bow's volumes are of one degree, the stern's of half a degree.
        assert!(states[0].pulses < 30 && states[1].pulses > 10);
        assert_eq!((states[2].pulses, states[3].pulses), (0, 0));
        close(motion.dive_planes[50], 0.25);
        close(motion.bow_stern_differential[50], 0.125);
        close(motion.roll_differential[50], -0.2);
        assert_eq!(motion.rudder, [0.3; 51]);
        assert_eq!(planes.name[..3], ["dive_planes", "bow", "bow_ram"]);
        assert_eq!(planes.position.len(), 9);
        assert_eq!(planes.position[0], motion.dive_planes[0]);
        assert!(motion.first_non_finite().is_none());
    }

    #[test]
    fn each_with_equal_actuators_moves_the_dive_planes_as_one_ram_does() {
        let (mut one, mut four) = (actuator(&[]), each(&[]));
        for k in 0..100 {
            let angle = 0.4 * (0.1 * k as f64).sin();
            let (one, four) = (
                answer(&mut one, k * TICK, angle),
                answer(&mut four, k * TICK, angle),
            );
            assert_eq!(four.motion.dive_planes, one.motion.dive_planes);
            assert!(four.motion.bow_stern_differential.iter().all(|d| *d == 0.0));
        }
    }

    #[test]
    fn a_fault_befalls_its_group_from_the_next_tick_on_and_is_told() {
        let mut actuator = each(&[]);
        answer(&mut actuator, 0, 0.3);
        assert!(actuator.faults().is_empty());
        let ill = with(&[
            ("groups", Value::from("each")),
            ("fault.group", Value::from("stern")),
            ("fault.lost_supply", Value::from(0.9)),
        ]);
        actuator.set_parameters(&ill).expect("accepted");
        assert_eq!(actuator.faults(), ["stern: supply pressure low by 90.0 %"]);
        let states = (1..40)
            .map(|k| answer(&mut actuator, k * TICK, 0.3).states)
            .last()
            .expect("answered");
        assert!(states[0].faults.is_empty() && states[0].plane_angle > 0.29);
        assert_eq!(states[1].faults, "supply pressure low by 90.0 %");
        assert!(states[1].plane_angle < 0.1, "{}", states[1].plane_angle);
        let sound = with(&[("groups", Value::from("each"))]);
        actuator.set_parameters(&sound).expect("accepted");
        let mended = (40..80)
            .map(|k| answer(&mut actuator, k * TICK, 0.3).states)
            .last()
            .expect("answered");
        assert!(mended[1].faults.is_empty() && mended[1].plane_angle > 0.28);
    }

    #[test]
    fn faults_that_cannot_be_are_refused_as_a_set() {
        for (changes, rule) in [
            (
                vec![
                    ("fault.group", Value::from("rudder")),
                    ("fault.air", 0.5.into()),
                ],
                "fault.group 'rudder' has no actuator; all, dive_planes have",
            ),
            (
                vec![("model", Value::from("ideal")), ("fault.air", 0.5.into())],
                "could fail",
            ),
            (
                vec![
                    ("groups", Value::from("each")),
                    ("rudder.model", Value::from("first_order")),
                    ("fault.group", Value::from("rudder")),
                    ("fault.encoder", Value::from("lost")),
                ],
                "in fault.group 'rudder' there is no",
            ),
            (
                vec![("fault.stuck_valve", Value::from("both"))],
                "fault.stuck_valve",
            ),
        ] {
            let error = match ActuatorParameters::default().with(&changes) {
                Ok(parameters) => Actuator::new(&parameters, TICK).expect_err(rule),
                Err(refusal) => refusal.to_string(),
            };
            assert!(error.contains(rule), "{error}");
        }
    }

    #[test]
    fn the_state_tells_power_slewing_and_the_limit_cycle() {
        let mut actuator = actuator(&[]);
        answer(&mut actuator, 0, 0.0);
        let slews = answer(&mut actuator, TICK, 0.5).states[0].clone();
        assert!(slews.slewing && slews.pulses == 4 && !slews.inhibited);
        // Four volumes of half a degree against 80 psi in a tick.
        let watts = 4.0 * 80.0 * 6894.757 * 3.5752e-9 / 0.05;
        assert!(
            (slews.hydraulic_power / watts - 1.0).abs() < 1e-3,
            "{} W for {watts} W",
            slews.hydraulic_power
        );
        assert_eq!(slews.limit_cycle_frequency, 0.0);
        // Held at a constant angle, the drift and its correction make a limit cycle.
        let mut held = Vec::new();
        for k in 2..1200 {
            held.push(answer(&mut actuator, k * TICK, 0.1).states[0].clone());
        }
        let last = held.last().expect("answered");
        assert!(!last.slewing && last.sign_changes > 20);
        let cycles = (last.sign_changes - held[200].sign_changes) as f64 / 2.0;
        let frequency = cycles / (0.05 * (held.len() - 201) as f64);
        assert!(
            (last.limit_cycle_frequency / frequency - 1.0).abs() < 0.1,
            "{} Hz for {frequency} Hz",
            last.limit_cycle_frequency
        );
        let covered = held[200..].iter().map(|state| state.plane_angle);
        let high = covered.clone().fold(f64::NEG_INFINITY, f64::max);
        let low = covered.fold(f64::INFINITY, f64::min);
        let amplitude = last.limit_cycle_amplitude;
        assert!(amplitude > 0.0 && amplitude <= 0.5 * (high - low) * 1.01);
    }

    #[test]
    fn parameters_take_effect_at_the_next_tick() {
        let mut actuator = actuator(&[]);
        answer(&mut actuator, 0, 0.5);
        actuator
            .set_parameters(&with(&[("command_limit", Value::Double(0.1))]))
            .expect("accepted");
        let next = answer(&mut actuator, TICK, 0.5);
        assert_eq!(next.states[0].commanded_angle, 0.1);
        let changed = with(&[("model", Value::from("ideal"))]);
        assert!(actuator.set_parameters(&changed).is_err());
        let two_speed = with(&[("logic.mode", Value::from("two_speed"))]);
        let error = actuator.set_parameters(&two_speed).expect_err("refused");
        assert!(error.contains("small_volume"), "{error}");
        assert!(Actuator::new(&two_speed, TICK).is_err());
        let unknown = with(&[("actuator", Value::from("no/such.yaml"))]);
        let error = Actuator::new(&unknown, TICK).expect_err("refused");
        assert!(error.contains("no/such.yaml"), "{error}");
        assert!(Actuator::new(&with(&[]), 0).is_err());
    }
}
