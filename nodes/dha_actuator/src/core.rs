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
//! **The differentials, rudder and thrust** have no actuator model yet: they are passed through at
//! once and unquantised, clipped to `command_limit` and to \[-1, 1\], held over the tick, and left
//! empty (neutral) where they are 0 or the command is stale.
//!
//! What is not finite is refused and changes nothing. The same inputs give the same outputs,
//! bit for bit, however a stretch of time is divided into ticks.

use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::{Duration, Time};
use planesman_msgs::planesman_msgs::msg::{DhaState, PlaneCommand, PlaneMotion};
use planesman_msgs::sensor_msgs::msg::JointState;
use planesman_msgs::std_msgs::msg::Header;
use planesman_parameters::Values;

use crate::actuator_file;
use crate::actuator_model::{ActuatorModel, Planes};
use crate::actuator_set::ActuatorSet;
use crate::condition::Condition;
use crate::dha::Demand;
use crate::modes::Load;
use crate::parameters::Config;

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
    /// Planes and ram at the stamp.
    pub planes: JointState,
    /// The actuator inside.
    pub state: DhaState,
}

/// The actuator with its messages.
#[derive(Clone, Debug)]
pub struct Actuator {
    set: ActuatorSet,
    config: Config,
    tick: i64,
    run: Option<Run>,
}

/// A run: from the first stamp on, until the clock is set back.
#[derive(Clone, Debug)]
struct Run {
    /// The first stamp, ns.
    began: i64,
    /// The last tick's stamp, ns, and the actuator there.
    stamp: i64,
    now: ActuatorModel,
    /// The actuator at the last tick's end.
    ahead: ActuatorModel,
    /// What the last tick was computed with.
    acting: Asked,
    /// The last command, clipped.
    command: Option<Held>,
    output: Output,
}

/// A command as far as it is obeyed, and its stamp.
#[derive(Clone, Copy, Debug)]
struct Held {
    /// rad
    dive_planes: f64,
    /// rad
    bow_stern_differential: f64,
    /// rad
    roll_differential: f64,
    /// rad
    rudder: f64,
    /// Share of full thrust.
    thrust: f64,
    /// ns
    stamp: i64,
}

impl Held {
    /// The command with its angles clipped to `limit`, rad.
    fn new(command: &PlaneCommand, limit: f64) -> Self {
        Self {
            dive_planes: command.dive_planes.clamp(-limit, limit),
            bow_stern_differential: command.bow_stern_differential.clamp(-limit, limit),
            roll_differential: command.roll_differential.clamp(-limit, limit),
            rudder: command.rudder.clamp(-limit, limit),
            thrust: command.thrust.clamp(-1.0, 1.0),
            stamp: command.header.stamp.nanos(),
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

/// What is asked for: a demand until a deadline, ns, then neutral planes.
#[derive(Clone, Copy, Debug)]
struct Asked {
    demand: Demand,
    deadline: i64,
}

impl Asked {
    /// The demand in force at `stamp`.
    fn at(&self, stamp: i64) -> Demand {
        if stamp < self.deadline {
            self.demand
        } else {
            Demand {
                angle: 0.0,
                ..self.demand
            }
        }
    }

    /// Runs `model` from one stamp to another, both in ns, in a run that began at `began`.
    fn drive(&self, model: &mut ActuatorModel, began: i64, from: i64, to: i64) {
        if from < self.deadline {
            model.advance_to(to.min(self.deadline) - began, self.demand);
        }
        if to > self.deadline {
            model.advance_to(to - began, self.at(self.deadline));
        }
    }
}

/// Whether the parameters fit the actuator.
fn fit(config: &Config, set: &ActuatorSet) -> Result<(), String> {
    if config.logic.two_speed && set.small.is_none() {
        return Err(format!(
            "logic.mode is two-speed, but actuator '{}' has no small_volume; auv_two_speed has one",
            config.actuator
        ));
    }
    Ok(())
}

impl Actuator {
    /// The actuator the parameters name, for ticks of `tick_nanos` ns, before its first stamp.
    ///
    /// # Errors
    /// The line to show: an actuator file that is refused, or a tick that is not positive.
    pub fn new(values: &Values, tick_nanos: i64) -> Result<Self, String> {
        let config = Config::from_values(values);
        if tick_nanos <= 0 {
            return Err(format!(
                "tick of {tick_nanos} ns refused: it must be positive"
            ));
        }
        let set = actuator_file::load(&config.actuator).map_err(|error| error.to_string())?;
        fit(&config, &set)?;
        Ok(Self {
            set,
            config,
            tick: tick_nanos,
            run: None,
        })
    }

    /// The constants of the actuator.
    #[must_use]
    pub fn set(&self) -> &ActuatorSet {
        &self.set
    }

    /// Takes changed parameters; they take effect at the next tick.
    ///
    /// # Errors
    /// When `actuator` or `model` differ, which are fixed from the start, or when the parameters
    /// do not fit the actuator. Nothing changes then.
    pub fn set_values(&mut self, values: &Values) -> Result<(), String> {
        let new = Config::from_values(values);
        if new.actuator != self.config.actuator || new.model != self.config.model {
            return Err("actuator and model are fixed once the actuator has started".to_owned());
        }
        fit(&new, &self.set)?;
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
        match run.command {
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

    /// The motion over a tick for which no command has come. A stamp already answered gets its
    /// answer again.
    pub fn on_silence(&mut self, stamp: Time) -> Output {
        let stamp = stamp.nanos();
        match &self.run {
            None => self.begin(stamp, None),
            Some(run) if stamp <= run.stamp => run.output.clone(),
            Some(run) if stamp.saturating_sub(run.stamp) > LONGEST_GAP => self.begin(stamp, None),
            Some(run) => {
                let held = run.command;
                self.go_on(stamp, held)
            }
        }
    }

    /// Starts a new run and answers its first tick.
    fn begin(&mut self, stamp: i64, command: Option<Held>) -> Output {
        let model = ActuatorModel::new(self.config.model, &self.set);
        self.answer(stamp, stamp, model, command)
    }

    /// Brings the run to `stamp` under what was asked for, and answers the tick from there.
    fn go_on(&mut self, stamp: i64, command: Option<Held>) -> Output {
        let Some(run) = &self.run else {
            return self.begin(stamp, command);
        };
        let tick_end = run.stamp.saturating_add(self.tick);
        let (mut model, from) = if stamp >= tick_end {
            (run.ahead, tick_end)
        } else {
            (run.now, run.stamp)
        };
        run.acting.drive(&mut model, run.began, from, stamp);
        let began = run.began;
        self.answer(began, stamp, model, command)
    }

    /// Computes the tick from `stamp`, where the actuator is `now`, and remembers it.
    fn answer(
        &mut self,
        began: i64,
        stamp: i64,
        mut now: ActuatorModel,
        command: Option<Held>,
    ) -> Output {
        let acting = self.asked(stamp, command);
        now.ask(acting.at(stamp));
        let planes = now.planes(stamp - began);

        let intervals = (self.tick as u64)
            .div_ceil(self.config.sample_interval.max(1) as u64)
            .clamp(1, MOST_SAMPLES as u64) as i64;
        let mut ahead = now;
        let mut angles = Vec::with_capacity(intervals as usize + 1);
        angles.push(planes.angle);
        let mut from = stamp;
        for i in 1..=intervals {
            let share = i128::from(self.tick) * i128::from(i) / i128::from(intervals);
            let to = stamp.saturating_add(share as i64);
            acting.drive(&mut ahead, began, from, to);
            angles.push(ahead.planes(to - began).angle);
            from = to;
        }

        let header = Header {
            stamp: Time::from_nanos(stamp),
            frame_id: FRAME.to_owned(),
        };
        let passed = command.filter(|_| stamp < acting.deadline);
        let through = |of: fn(&Held) -> f64| {
            passed
                .as_ref()
                .map_or_else(Vec::new, |held| held_samples(of(held)))
        };
        let output = Output {
            motion: PlaneMotion {
                header: header.clone(),
                duration: Duration::from_nanos(self.tick),
                dive_planes: angles,
                bow_stern_differential: through(|held| held.bow_stern_differential),
                roll_differential: through(|held| held.roll_differential),
                rudder: through(|held| held.rudder),
                thrust: through(|held| held.thrust),
            },
            planes: self.joints(&header, &planes),
            state: DhaState {
                commanded_angle: acting.at(stamp).angle,
                command_stale: stamp >= acting.deadline,
                ..self.state(&header, &planes, &mut ahead)
            },
        };
        self.run = Some(Run {
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

    /// What a command, or none, asks for from `stamp` on.
    fn asked(&self, stamp: i64, command: Option<Held>) -> Asked {
        let deadline = match command {
            // At its own stamp a command is never stale.
            Some(held) if held.stamp == stamp => {
                stamp.saturating_add(self.config.command_timeout.max(1))
            }
            Some(held) => held.stamp.saturating_add(self.config.command_timeout),
            None => i64::MIN,
        };
        Asked {
            demand: Demand {
                angle: command.map_or(0.0, |held| held.dive_planes),
                position_loop: self.config.position_loop,
                logic: self.config.logic,
                condition: Condition {
                    leakage_scale: self.config.leakage_scale,
                    ..Condition::SOUND
                },
            },
            deadline,
        }
    }

    fn joints(&self, header: &Header, planes: &Planes) -> JointState {
        JointState {
            header: header.clone(),
            name: vec!["dive_planes".to_owned(), "ram".to_owned()],
            position: vec![planes.angle, planes.angle * self.set.moment_arm],
            velocity: vec![planes.rate, planes.rate * self.set.moment_arm],
            effort: Vec::new(),
        }
    }

    fn state(&self, header: &Header, planes: &Planes, ahead: &mut ActuatorModel) -> DhaState {
        let mut state = DhaState {
            header: header.clone(),
            ram: planes.angle * self.set.moment_arm,
            ram_velocity: planes.rate * self.set.moment_arm,
            plane_angle: planes.angle,
            sign: 1,
            ..DhaState::default()
        };
        if let Some(reading) = planes.reading {
            state.pressure = reading.pressure;
            state.volume = reading.ram.volume;
            state.leakage = reading.leaked;
            state.sign = reading.polarity;
            state.sliding = matches!(reading.mode.load, Load::Sliding(_));
            state.at_stop = matches!(reading.mode.load, Load::AtStop(_));
            state.pressure_limited = reading.mode.clamped.is_some();
        }
        if let ActuatorModel::Dha(dha) = ahead {
            state.pulses = dha.pulses();
            state.inhibited = dha.take_inhibited();
            state.error = dha.error();
        }
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_parameters::Value;

    const TICK: i64 = 50_000_000;

    fn values(changes: &[(&str, Value)]) -> Values {
        Values::defaults(crate::parameters::declarations())
            .with(
                changes
                    .iter()
                    .map(|(name, value)| ((*name).to_owned(), value.clone())),
            )
            .expect("declared")
    }

    fn actuator(changes: &[(&str, Value)]) -> Actuator {
        Actuator::new(&values(changes), TICK).expect("valid")
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
            assert_eq!(output.state.plane_angle, end);
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
        assert!((last.state.commanded_angle + thirty).abs() < 1e-12);
        assert!((last.state.plane_angle + thirty).abs() < 0.5f64.to_radians());
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
        let mut whole = Actuator::new(&values(&[]), TICK).expect("valid");
        let mut long = Actuator::new(&values(&[]), 10 * TICK).expect("valid");
        for k in 0..30 {
            let angle = 0.3 * (k as f64).sin();
            let a = answer(&mut whole, k * TICK, angle);
            let b = answer(&mut long, k * TICK, angle);
            assert_eq!(a.planes, b.planes);
            assert_eq!(a.state.volume, b.state.volume);
        }
    }

    #[test]
    fn without_commands_the_planes_hold_and_then_go_to_neutral_flagged() {
        let mut actuator = actuator(&[]);
        for k in 0..20 {
            answer(&mut actuator, k * TICK, 0.3);
        }
        let mut silent = |k: i64| actuator.on_silence(Time::from_nanos(k * TICK)).state;
        let held = (20..29).map(&mut silent).next_back().expect("answered");
        assert!(!held.command_stale && held.commanded_angle == 0.3);
        let stale = silent(29);
        assert!(stale.command_stale && stale.commanded_angle == 0.0);
        let neutral = (30..60).map(&mut silent).next_back().expect("answered");
        assert!(neutral.plane_angle.abs() < 0.5f64.to_radians());
        let back = answer(&mut actuator, 60 * TICK, 0.1).state;
        assert!(!back.command_stale && back.commanded_angle == 0.1);
    }

    #[test]
    fn before_the_first_command_neutral_is_asked_for() {
        let mut actuator = actuator(&[]);
        let first = actuator.on_silence(Time::from_nanos(0)).state;
        assert!(first.command_stale && first.commanded_angle == 0.0);
    }

    #[test]
    fn a_command_after_its_tick_was_answered_in_silence_acts_from_the_next_on() {
        let mut actuator = actuator(&[]);
        answer(&mut actuator, 0, 0.0);
        let silent = actuator.on_silence(Time::from_nanos(2 * TICK));
        assert_eq!(answer(&mut actuator, TICK, 0.2), silent);
        let next = actuator.on_silence(Time::from_nanos(3 * TICK));
        assert_eq!(next.state.commanded_angle, 0.2);
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
        assert_eq!(far.state.pulses, first.state.pulses);
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
        assert_eq!(output.state.plane_angle, 0.25);
    }

    #[test]
    fn parameters_take_effect_at_the_next_tick() {
        let mut actuator = actuator(&[]);
        answer(&mut actuator, 0, 0.5);
        actuator
            .set_values(&values(&[("command_limit", Value::Double(0.1))]))
            .expect("accepted");
        let next = answer(&mut actuator, TICK, 0.5);
        assert_eq!(next.state.commanded_angle, 0.1);
        let changed = values(&[("model", Value::from("ideal"))]);
        assert!(actuator.set_values(&changed).is_err());
        let two_speed = values(&[("logic.mode", Value::from("two_speed"))]);
        let error = actuator.set_values(&two_speed).expect_err("refused");
        assert!(error.contains("small_volume"), "{error}");
        assert!(Actuator::new(&two_speed, TICK).is_err());
        let unknown = values(&[("actuator", Value::from("no/such.yaml"))]);
        let error = Actuator::new(&unknown, TICK).expect_err("refused");
        assert!(error.contains("no/such.yaml"), "{error}");
        assert!(Actuator::new(&values(&[]), 0).is_err());
    }
}
