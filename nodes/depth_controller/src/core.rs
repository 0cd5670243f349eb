//! The controller: a vehicle state in, the plane command for the same stamp out.
//!
//! ```text
//! depth setpoint -> depth PD -> [pitch limit] -> pitch P + rate -> (+ test signal) -> [plane limit]
//! ```
//!
//! **Time** is the states' own: elapsed time runs from the first state's stamp. A state
//! with the last stamp again gets the last answer again; one with an earlier stamp begins a new
//! run, with the elapsed time at zero and the topics' setpoints forgotten.
//!
//! **Depth setpoint**: the last word counts. The schedule is followed from its first time
//! on, the parameter `depth_setpoint` before it. A setpoint from the topic, or a live
//! change of the parameter, overrides the schedule from then on; a live change of the
//! schedule puts the schedule in charge again.
//!
//! What is not finite is refused and changes nothing.

use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{ControlState, PlaneCommand, VehicleState};
use planesman_msgs::std_msgs::msg::Header;
use planesman_parameters::Values;

use crate::limits::bounded;
use crate::parameters::{Config, Mode};

/// The frame the commands are given in: forward, right, down.
const FRAME: &str = "base_link_frd";

/// What a state is answered with.
pub type Answer = (PlaneCommand, ControlState);

/// The depth and pitch loops with their setpoints.
#[derive(Clone, Debug)]
pub struct Controller {
    config: Config,
    /// Depth setpoint that overrides the schedule, m.
    depth_override: Option<f64>,
    /// Pitch setpoint that overrides the parameter, rad.
    pitch_override: Option<f64>,
    run: Option<Run>,
}

/// A run: from the first state on, until the stamps go back.
#[derive(Clone, Debug)]
struct Run {
    /// The first state's stamp, ns.
    began: i64,
    /// The last state's stamp, ns, and what it was answered with.
    last: i64,
    answer: Answer,
}

impl Controller {
    /// A controller with the parameters' gains and setpoints, before its first state.
    ///
    /// # Errors
    /// As [`Config::from_values`].
    pub fn new(values: &Values) -> Result<Self, String> {
        Ok(Self {
            config: Config::from_values(values)?,
            depth_override: None,
            pitch_override: None,
            run: None,
        })
    }

    /// Takes changed parameters, whole or not at all; they take effect at the next stamp.
    ///
    /// # Errors
    /// As [`Config::from_values`]; the present parameters then stay.
    pub fn set_values(&mut self, values: &Values) -> Result<(), String> {
        let new = Config::from_values(values)?;
        if new.schedule != self.config.schedule {
            self.depth_override = None;
        } else if new.depth_setpoint != self.config.depth_setpoint {
            self.depth_override = Some(new.depth_setpoint);
        }
        if new.pitch_setpoint != self.config.pitch_setpoint {
            self.pitch_override = None;
        }
        self.config = new;
        Ok(())
    }

    /// Holds `depth` (m, down) from the next stamp on, whatever the schedule says.
    ///
    /// # Errors
    /// A sentence, when it is not finite.
    pub fn set_depth_setpoint(&mut self, depth: f64) -> Result<(), String> {
        self.depth_override = Some(finite("depth setpoint", depth)?);
        Ok(())
    }

    /// Holds `pitch` (rad, bow up) from the next stamp on, in mode pitch.
    ///
    /// # Errors
    /// A sentence, when it is not finite.
    pub fn set_pitch_setpoint(&mut self, pitch: f64) -> Result<(), String> {
        self.pitch_override = Some(finite("pitch setpoint", pitch)?);
        Ok(())
    }

    /// The silence of the state, s, after which the node calls [`Controller::on_silence`].
    #[must_use]
    pub fn state_timeout(&self) -> f64 {
        self.config.state_timeout
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
        let began = match &self.run {
            Some(run) if stamp == run.last => return Ok(run.answer.clone()),
            Some(run) if stamp > run.last => run.began,
            Some(_) => {
                self.depth_override = None;
                self.pitch_override = None;
                stamp
            }
            None => stamp,
        };
        let answer = self.answer(state, stamp - began);
        self.run = Some(Run {
            began,
            last: stamp,
            answer: answer.clone(),
        });
        Ok(answer)
    }

    /// What to command at `stamp` when no state has come for [`Controller::state_timeout`]:
    /// planes neutral, flagged. The run goes on with the next state.
    #[must_use]
    pub fn on_silence(&self, stamp: Time) -> Answer {
        let header = header(stamp);
        let command = PlaneCommand {
            header: header.clone(),
            ..PlaneCommand::default()
        };
        let control = ControlState {
            header,
            mode: mode_constant(self.config.mode),
            feedback_stale: true,
            ..ControlState::default()
        };
        (command, control)
    }

    /// The control law at `elapsed` nanoseconds of the run.
    fn answer(&self, state: &VehicleState, elapsed: i64) -> Answer {
        let config = &self.config;
        let mut control = ControlState {
            header: header(state.header.stamp.clone()),
            mode: mode_constant(config.mode),
            depth_rate: state.depth_rate,
            identification: config.identification.value(elapsed),
            ..ControlState::default()
        };
        let pitch_command = match config.mode {
            Mode::Off => None,
            Mode::Pitch => {
                let setpoint = self.pitch_override.unwrap_or(config.pitch_setpoint);
                Some(config.depth.pitch_limit.apply(setpoint))
            }
            Mode::Depth => {
                control.depth_setpoint = self.depth_setpoint(elapsed);
                let terms =
                    config
                        .depth
                        .evaluate(control.depth_setpoint, state.depth, state.depth_rate);
                control.depth_error = terms.error;
                control.depth_p = terms.p;
                control.depth_d = terms.d;
                Some(terms.pitch_command)
            }
        };
        if let Some(command) = pitch_command {
            let terms = config
                .pitch
                .evaluate(command.value, state.pitch, state.pitch_rate);
            control.pitch_command = command.value;
            control.pitch_command_limited = command.at_limit;
            control.pitch_error = terms.error;
            control.planes_p = terms.p;
            control.planes_rate = terms.rate;
        }
        let planes = config.planes_limit.apply(bounded(
            control.planes_p + control.planes_rate + control.identification,
        ));
        control.dive_planes = planes.value;
        control.dive_planes_limited = planes.at_limit;
        let command = PlaneCommand {
            header: control.header.clone(),
            dive_planes: planes.value,
            ..PlaneCommand::default()
        };
        (command, control)
    }

    /// The depth to hold, m.
    fn depth_setpoint(&self, elapsed: i64) -> f64 {
        self.depth_override
            .or_else(|| self.config.schedule.depth(elapsed))
            .unwrap_or(self.config.depth_setpoint)
    }
}

fn header(stamp: Time) -> Header {
    Header {
        stamp,
        frame_id: FRAME.to_owned(),
    }
}

fn mode_constant(mode: Mode) -> u8 {
    match mode {
        Mode::Off => ControlState::MODE_OFF,
        Mode::Pitch => ControlState::MODE_PITCH,
        Mode::Depth => ControlState::MODE_DEPTH,
    }
}

fn finite(name: &str, number: f64) -> Result<f64, String> {
    if number.is_finite() {
        Ok(number)
    } else {
        Err(format!("{name} {number} refused: it must be finite"))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::parameters::declarations;
    use planesman_parameters::Value;

    const TICK: i64 = 50_000_000;

    fn values(changes: &[(&str, Value)]) -> Values {
        Values::defaults(declarations())
            .with(
                changes
                    .iter()
                    .map(|(name, value)| ((*name).to_owned(), value.clone())),
            )
            .unwrap()
    }

    fn controller(changes: &[(&str, Value)]) -> Controller {
        Controller::new(&values(changes)).unwrap()
    }

    fn state(tick: i64) -> VehicleState {
        let mut state = VehicleState::default();
        state.header.stamp = Time::from_nanos(tick * TICK);
        state
    }

    #[test]
    fn a_deeper_setpoint_dives_the_planes_and_the_answer_bears_the_states_stamp() {
        let mut controller = controller(&[]);
        controller.set_depth_setpoint(0.1).unwrap();
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
        controller.set_depth_setpoint(0.1).unwrap();
        let first = controller.on_state(&state(0)).unwrap();
        controller.set_depth_setpoint(0.2).unwrap();
        controller
            .set_values(&values(&[("pitch.p", Value::Double(0.1))]))
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
        controller.set_depth_setpoint(0.7).unwrap();
        assert_eq!(setpoint(&mut controller, 5), 0.7);
    }

    #[test]
    fn the_last_word_on_the_depth_counts() {
        let mut controller = controller(&[]);
        controller.set_depth_setpoint(0.7).unwrap();
        let changed = [("depth_setpoint", Value::Double(0.2))];
        controller.set_values(&values(&changed)).unwrap();
        assert_eq!(
            controller.on_state(&state(0)).unwrap().1.depth_setpoint,
            0.2
        );
        let scheduled = [
            ("depth_setpoint", Value::Double(0.2)),
            ("schedule.times", Value::DoubleArray(vec![0.0])),
            ("schedule.depths", Value::DoubleArray(vec![0.3])),
        ];
        controller.set_values(&values(&scheduled)).unwrap();
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
        controller.set_depth_setpoint(0.9).unwrap();
        assert_eq!(controller.on_state(&state(0)).unwrap(), first);
    }

    #[test]
    fn the_test_signal_is_added_in_every_mode() {
        for mode in Mode::NAMES {
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
    fn switched_off_the_planes_are_neutral() {
        let mut controller = controller(&[
            ("mode", Value::from("off")),
            ("depth_setpoint", Value::Double(5.0)),
        ]);
        let (command, control) = controller.on_state(&state(0)).unwrap();
        assert_eq!(command.dive_planes, 0.0);
        assert_eq!(control.mode, ControlState::MODE_OFF);
    }

    #[test]
    fn pitch_is_held_within_the_limit() {
        let mut controller = controller(&[("mode", Value::from("pitch"))]);
        controller.set_pitch_setpoint(-0.2).unwrap();
        let (command, control) = controller.on_state(&state(0)).unwrap();
        assert!((command.dive_planes - 0.7 * 0.2).abs() < 1e-15);
        assert_eq!(control.mode, ControlState::MODE_PITCH);
        controller.set_pitch_setpoint(-3.0).unwrap();
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
        assert!(controller.set_depth_setpoint(f64::INFINITY).is_err());
        assert!(controller.set_pitch_setpoint(f64::NAN).is_err());
        assert_eq!(controller.on_state(&state(1)).unwrap(), before);
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
                controller.set_depth_setpoint(d[4]).unwrap();
                let (command, control) = controller.on_state(&state).unwrap();
                assert!(command.dive_planes.abs() <= limit);
                assert_eq!(command.first_non_finite(), None);
                assert_eq!(control.first_non_finite(), None, "{control:?}");
            }
        }
    }
}
