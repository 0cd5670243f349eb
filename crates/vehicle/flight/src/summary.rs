//! Summary of a flight: the depth response, and the identified model compared with the true one.

use std::fmt;

use crate::error::{Result, refused};
use planesman_control::{ControllerParameters, Mode};
use planesman_hydraulics::{ActuatorFile, ActuatorParameters, Energy, Model, actuator_file};
use planesman_linear::digits::significant;
use planesman_linear::{ComplexFunctions as _, StepMetrics, TransferFunction};
use planesman_parameters::Choice as _;
use planesman_plant::PlantParameters;
use planesman_text::number;

use crate::flight::Flight;
use crate::model_summary::{ModelSummary, identified, slowest_first};
use crate::scenario::Scenario;
use crate::track::{self, Track};

/// Tolerance of the dominant pole, relative to its magnitude.
pub const POLE_TOLERANCE: f64 = 0.10;

/// The summary of a flight.
#[derive(Clone, Debug)]
pub struct Summary {
    /// Last depth setpoint, m.
    pub depth_setpoint: f64,
    /// Response to the last change of the depth setpoint; `None` without a depth step.
    pub depth: Option<StepMetrics>,
    /// Evaluated part of the flight, s.
    pub judged: [f64; 2],
    /// Whether a test signal moved the planes in that part.
    pub is_disturbed: bool,
    /// Duration of the flight, s.
    pub duration: f64,
    /// Mode of the controller at the start.
    pub mode: Mode,
    planes: &'static str,
    /// Largest deviation from the depth held during the whole flight, m; `None` if no depth was held throughout.
    pub depth_kept: Option<f64>,
    /// Test signal on the planes; `None` if there is none.
    pub test_signal: Option<TestSignal>,
    /// Identified model; `None` without a valid one.
    pub identified: Option<ModelSummary>,
    /// Number of regression rows used for the model.
    pub samples: u64,
    /// One-step fit, %.
    pub fit: f64,
    /// Reason why there is no identified model.
    pub no_model: String,
    /// True model of the vehicle at its speed.
    pub truth: ModelSummary,
    /// Number of ticks without the actuator's answer.
    pub held_ticks: u64,
    /// Pulses of all actuators.
    pub pulses: u64,
    /// Whether hydraulics move any of the planes; false for ideal actuators.
    pub is_hydraulic: bool,
    /// Energies of all actuators; `None` without hydraulics.
    pub energy: Option<Energy>,
    /// Energy of an ideal proportional valve for the same motion in the actuator's own circuit, J. `None` with several actuators, without
    /// the actuator's file, or with lost supply pressure.
    pub proportional: Option<f64>,
    /// Whether the vehicle has only thrusters, and thus no response to planes.
    pub hovers: bool,
    /// Accuracy at its way-points or its held position; `None` without these.
    pub track: Option<Track>,
    /// Result of the turning circle or zig-zag; `None` if there is none.
    pub turn: Option<String>,
    /// Irregularities of the bag, one sentence each.
    pub notes: Vec<String>,
}

impl Summary {
    /// Summarizes `flight`, a run of `scenario`.
    ///
    /// # Errors
    /// If the flight has no states, or the scenario's vehicle cannot be linearised.
    pub fn new(flight: &Flight, scenario: &Scenario) -> Result<Self> {
        let Some(step) = &flight.step else {
            return Err(refused!("the bag has no vehicle states"));
        };
        let model = flight.model.as_ref();
        let controller: ControllerParameters = scenario.parameters_of("depth_controller")?;
        let hovers = controller.mode == Mode::Hover;
        let actuators: ActuatorParameters = scenario.parameters_of("dha_actuator")?;
        let depths = &flight.time_histories.depth;
        let duration = flight.ticks as f64 * scenario.tick;
        let holds_depth = matches!(controller.mode, Mode::Depth | Mode::Hover);
        let holds = controller.mode == Mode::Depth && step.response.is_none();
        Ok(Self {
            judged: step.judged,
            is_disturbed: step.is_disturbed,
            duration,
            mode: controller.mode,
            planes: planes_text(&actuators),
            depth_kept: holds.then(|| {
                let off = depths.iter().map(|it| (it.1 - step.setpoint).abs());
                off.fold(0.0, f64::max)
            }),
            turn: track::turn(&flight.time_histories, &controller),
            hovers,
            track: Track::of(&flight.time_histories.place, &controller, hovers),
            depth_setpoint: step.setpoint,
            depth: step.response.filter(|_| holds_depth),
            test_signal: test_signal(scenario)?.filter(|it| it.start < duration),
            identified: model.map(identified),
            samples: model.map_or(0, |m| m.samples),
            fit: model.map_or(0.0, |m| m.fit),
            no_model: flight.no_model.clone(),
            truth: truth(scenario)?,
            held_ticks: flight.held_ticks,
            pulses: flight
                .actuators
                .values()
                .fold(0, |sum, actuator| actuator.pulses.saturating_add(sum)),
            energy: (flight.actuators.values().map(|it| it.energy))
                .reduce(|sum, it| sum + it)
                .filter(|it| it.supply != 0.0),
            is_hydraulic: actuators.is_hydraulic(),
            proportional: proportional(flight, &actuators),
            notes: flight.notes.clone(),
        })
    }

    /// Distance of the identified dominant pole from the true one, relative to its magnitude.
    #[must_use]
    pub fn pole_error(&self) -> Option<f64> {
        let identified = self.identified.as_ref()?.dominant()?;
        let truth = self.truth.dominant()?;
        Some((identified - truth).modulus() / truth.modulus())
    }

    /// Quantities for the comparison of flights.
    #[must_use]
    pub fn quantities(&self) -> Vec<Quantity> {
        let response = |of: fn(&StepMetrics) -> Option<f64>| {
            let depth = self.depth.as_ref().ok_or("no step")?;
            of(depth).ok_or("not reached")
        };
        let pole_error = match self.pole_error() {
            None => Err("no model"),
            Some(error) if error <= 10.0 => Ok(100.0 * error),
            // Beyond ten times the pole's magnitude the number says nothing.
            Some(_) => Err("more than 1000 %"),
        };
        let signal = self.test_signal.as_ref().map(ToString::to_string);
        let energy = self.energy.ok_or("none");
        let pulses = self.is_hydraulic.then_some(self.pulses as f64);
        let percent = |of: fn(&Energy) -> Option<f64>| {
            Ok(100.0 * energy.and_then(|it| of(&it).ok_or("none"))?)
        };
        [
            (
                "depth_setpoint",
                " m",
                3,
                self.depth.map(|_| self.depth_setpoint).ok_or("no step"),
            ),
            ("rise_time", " s", 2, response(|it| it.rise_time)),
            ("overshoot", " %", 2, response(|it| Some(it.overshoot))),
            ("settling_time_2", " s", 2, response(|it| it.settling_time)),
            (
                "settling_time_5",
                " s",
                2,
                response(|it| it.settling_time_5),
            ),
            (
                "steady_error",
                " m",
                4,
                response(|it| Some(it.steady_error)),
            ),
            (
                "test_signal",
                "",
                0,
                Err(signal.as_deref().unwrap_or("none")),
            ),
            ("pulses", "", 0, pulses.ok_or("none")),
            ("energy_supply", " J", 3, energy.map(|it| it.supply)),
            ("efficiency", " %", 1, percent(Energy::efficiency)),
            (
                "efficiency_proportional",
                " %",
                1,
                energy.and_then(|it| Ok(100.0 * it.load() / self.proportional.ok_or("not known")?)),
            ),
            ("held_ticks", "", 0, Ok(self.held_ticks as f64)),
            ("pole_error", " %", 1, pole_error),
        ]
        .map(|(field, unit, decimals, value)| Quantity {
            applies: match field {
                "pulses" | "energy_supply" | "efficiency" | "efficiency_proportional" => {
                    self.is_hydraulic
                }
                "pole_error" => !self.hovers,
                _ => true,
            },
            field,
            unit,
            decimals,
            value: value.map_err(str::to_owned),
        })
        .into()
    }

    /// Gains from plane angle to pitch rate: name, identified, true.
    #[must_use]
    pub fn gains(&self) -> [(&'static str, String, String); 2] {
        let text =
            |gain: Option<f64>| gain.map_or_else(|| "none".to_owned(), |it| format!("{it:.5}"));
        let row = |name, of: fn(&ModelSummary) -> Option<f64>| {
            (
                name,
                text(self.identified.as_ref().and_then(of)),
                text(of(&self.truth)),
            )
        };
        [
            row("first Markov parameter", |it| {
                Some(it.first_markov_parameter)
            }),
            row("steady-state gain", |it| it.steady_state_gain),
        ]
    }

    /// Results of the flight, one sentence each, the most important first.
    #[must_use]
    pub fn conclusions(&self) -> Vec<String> {
        let flown = match (&self.depth, self.mode, self.depth_kept) {
            (Some(depth), ..) => Some(self.depth_text(depth)),
            _ if self.turn.is_some() || self.track.is_some() => None,
            (None, Mode::Depth, Some(off)) => Some(format!(
                "Held {:.3} m for {:.0} s with an error of at most {} m",
                self.depth_setpoint,
                self.duration,
                significant(off, 2)
            )),
            (None, mode, _) => Some(format!(
                "Flew {:.0} s {}",
                self.duration,
                match mode {
                    Mode::OpenLoop => "in open loop",
                    Mode::Pitch => "in pitch hold",
                    Mode::Off => "with neutral planes",
                    Mode::Depth | Mode::Hover => "without a depth step",
                }
            )),
        };
        let planes = if self.hovers { "" } else { self.planes };
        let flown = flown.map(|it| format!("{it}{planes}."));
        let turn = self.turn.clone();
        let track = self.track.as_ref().map(Track::text);
        let model = self.model_text().filter(|_| !self.hovers);
        turn.into_iter()
            .chain(flown)
            .chain(track)
            .chain(model)
            .collect()
    }

    /// Poles and gains from plane angle to pitch rate, identified and true, one per line; empty without a model.
    #[must_use]
    pub fn model_lines(&self) -> String {
        let Some(model) = self.identified.as_ref().filter(|_| !self.hovers) else {
            return String::new();
        };
        let modes = [("identified", model), ("true", &self.truth)]
            .map(|(name, it)| format!("{name} modes: {}\n", it.modes().join("; ")));
        let gains = self.gains();
        let gains = gains.map(|(name, found, truth)| format!("{name}: {found}, true {truth}\n"));
        modes.concat() + &gains.concat()
    }

    fn depth_text(&self, depth: &StepMetrics) -> String {
        let at = match self.judged[0] > 0.0 {
            true => format!("the last depth, {:.3} m,", self.depth_setpoint),
            false => format!("{:.3} m", self.depth_setpoint),
        };
        let overshoot = match format!("{:.1}", depth.overshoot).as_str() {
            "0.0" => ", no overshoot".to_owned(),
            _ => format!(", overshoot {} %", significant(depth.overshoot, 2)),
        };
        let duration = self.judged[1] - self.judged[0];
        let reached = match (depth.settling_time, depth.settling_time_5) {
            (Some(t), _) => format!("Reached {at} in {t:.1} s (2 %){overshoot}"),
            (None, Some(t)) => {
                format!("Reached {at} in {t:.1} s (5 %), but did not settle within 2 %{overshoot}")
            }
            (None, None) => format!(
                "Did NOT reach {at} within 5 % in {duration:.0} s; the steady error is {:+.3} m{}",
                depth.steady_error,
                Some(overshoot)
                    .filter(|it| it != ", no overshoot")
                    .unwrap_or_default()
            ),
        };
        match (&self.test_signal, self.is_disturbed) {
            (Some(signal), true) => {
                format!("{reached}, disturbed by a {} test signal", signal.size())
            }
            _ => reached,
        }
    }

    /// Text about the identified model, if a test signal was to identify it.
    fn model_text(&self) -> Option<String> {
        let signal = self.test_signal.as_ref()?;
        let found = match self.pole_error() {
            Some(error) if error <= POLE_TOLERANCE => {
                // Rounded up: it is a bound.
                let percent = ((1000.0 * error).ceil() / 10.0).max(0.1);
                format!("slowest pole identified within {percent:.1} %")
            }
            Some(error) => format!(
                "slowest pole NOT identified: the estimate is {} from the true pole",
                distance_text(error)
            ),
            None => format!("no valid model of the pitch response: {}", self.no_model),
        };
        let when = match (self.depth.is_some(), self.is_disturbed) {
            (true, false) => "Then a",
            (true, true) => return Some(format!("From that signal: {found}.")),
            (false, _) => "A",
        };
        Some(format!("{when} {} test signal: {found}.", signal.size()))
    }
}

/// Text about the dive planes' actuator, as the end of a sentence.
fn planes_text(parameters: &ActuatorParameters) -> &'static str {
    match parameters.dive_planes_model() {
        Model::Ideal => ", with ideal planes",
        Model::FirstOrder => ", through a first-order actuator",
        Model::Dha => match actuator_file::read(&parameters.actuator) {
            Ok(ActuatorFile::Circuit(_)) => ", through a circuit of on/off valves",
            _ => ", through a digital hydraulic actuator",
        },
    }
}

/// A test signal on the planes.
#[derive(Clone, Debug, PartialEq)]
pub struct TestSignal {
    /// Shape of the signal, with the name that the parameter `identification.signal` uses.
    pub shape: &'static str,
    /// rad
    pub amplitude: f64,
    /// Start time, s.
    pub start: f64,
}

impl TestSignal {
    /// Effect of the signal on the responses to a scenario's steps.
    #[must_use]
    pub fn effect(&self) -> &'static str {
        match self.start > 0.0 {
            true => {
                "a response that settles before the test signal starts is evaluated up to its start"
            }
            false => "the test signal disturbs every response",
        }
    }

    /// Amplitude of the signal with sign and unit.
    fn size(&self) -> String {
        let (sides, amplitude) = match self.shape {
            "step" | "pulse" => ("", self.amplitude),
            _ => ("±", self.amplitude.abs()),
        };
        // 0.0349 rad is said to be 2 degrees.
        let text = significant(amplitude.to_degrees(), 2);
        format!("{sides}{}°", text.trim_end_matches(".0"))
    }
}

impl fmt::Display for TestSignal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let amplitude = self.amplitude.to_degrees();
        write!(f, "{} of {amplitude:.2} deg on the planes", self.shape)?;
        match self.start > 0.0 {
            true => write!(f, " from {} s", number(self.start)),
            false => Ok(()),
        }
    }
}

/// Test signal of a scenario; `None` if it does not start before the end. While it is active, it disturbs the response to a step.
///
/// # Errors
/// If the scenario's parameters are refused.
pub fn test_signal(scenario: &Scenario) -> Result<Option<TestSignal>> {
    let controller: ControllerParameters = scenario.parameters_of("depth_controller")?;
    let signal = TestSignal {
        shape: controller.identification.signal.name(),
        amplitude: controller.identification.amplitude,
        start: controller.identification.start,
    };
    let is_flown = signal.start < scenario.duration;
    let is_on = is_flown && signal.shape != "none" && signal.amplitude != 0.0;
    Ok(Some(signal).filter(|_| is_on))
}

/// True sampled model of the vehicle from plane angle to pitch rate.
fn truth(scenario: &Scenario) -> Result<ModelSummary> {
    truth_of(&scenario.parameters_of("plant_sim")?, scenario.tick)
}

/// The true value for the vehicle with these parameters.
pub fn truth_of(parameters: &PlantParameters, tick: f64) -> Result<ModelSummary> {
    let craft = planesman_plant::VehicleModel::load(parameters).map_err(|e| refused!("{e}"))?;
    let model = planesman_vehicle::linearised::true_model_of(
        &planesman_plant::derivatives(parameters, &craft),
        tick,
    )
    .map_err(|e| refused!("{e}"))?;
    Ok(ModelSummary {
        poles: slowest_first(model.continuous_poles, 0.0),
        steady_state_gain: model.steady_state_gain,
        first_markov_parameter: first_markov_parameter(&model.transfer_function),
    })
}

/// `b1` of `(b0 z^n + b1 z^(n-1) + ...)/(z^n + ...)`; there is no direct feedthrough, b0 = 0.
fn first_markov_parameter(model: &TransferFunction) -> f64 {
    let missing = model.den.len() - model.num.len().min(model.den.len());
    match missing {
        0 => model.num.get(1),
        1 => model.num.first(),
        _ => None,
    }
    .copied()
    .unwrap_or(0.0)
}

/// Energy of an ideal proportional valve in the actuator's own circuit, for the motion of a flight's only actuator, J.
fn proportional(flight: &Flight, parameters: &ActuatorParameters) -> Option<f64> {
    let mut actuators = flight.actuators.values();
    let (only, None) = (actuators.next()?, actuators.next()) else {
        return None;
    };
    let four_way = only.energy.proportional_valve;
    match actuator_file::read(&parameters.actuator).ok()? {
        ActuatorFile::Metering(set) if parameters.fault.lost_supply == 0.0 => {
            Some(set.proportional_in_own_circuit(four_way, only.ram))
        }
        ActuatorFile::Metering(_) => None,
        // It has four ways itself.
        ActuatorFile::Circuit(_) => Some(four_way),
    }
}

/// A step response in one line.
#[must_use]
pub fn step_text(step: &StepMetrics) -> String {
    let seconds = |time: Option<f64>| time.map_or("never".to_owned(), |t| format!("{t:.2} s"));
    format!(
        "rise {}, overshoot {:.2} %, settling {} (2 %), {} (5 %), ITAE {:.2} s^2",
        seconds(step.rise_time),
        step.overshoot,
        seconds(step.settling_time),
        seconds(step.settling_time_5),
        step.itae
    )
}

/// Distance relative to the true pole's magnitude, %; above ten times the magnitude the number is not printed.
#[must_use]
pub fn distance_text(distance: f64) -> String {
    if distance <= 10.0 {
        format!("{:.1} %", 100.0 * distance)
    } else {
        "more than 1000 %".to_owned()
    }
}

/// A quantity of a flight with its display format.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Name of the result's field, one of [`crate::titles`].
    pub field: &'static str,
    /// Unit printed after the number.
    pub unit: &'static str,
    /// Number of decimals.
    pub decimals: usize,
    /// Whether the result applies to the flight's vehicle: an ideal actuator has no pulses.
    pub applies: bool,
    /// Value, or the reason why there is no value.
    value: Result<f64, String>,
}

impl Quantity {
    /// Whether the result has a value.
    #[must_use]
    pub const fn is_known(&self) -> bool {
        self.applies && self.value.is_ok()
    }

    /// Value with its unit.
    #[must_use]
    pub fn text(&self) -> String {
        match &self.value {
            Ok(value) if self.field == "steady_error" => self.signed(*value),
            Ok(value) => format!("{value:.*}{}", self.decimals, self.unit),
            Err(reason) => reason.clone(),
        }
    }

    /// Difference to the value of another flight.
    #[must_use]
    pub fn less(&self, other: &Self) -> String {
        match (&self.value, &other.value) {
            (Ok(own), Ok(other)) => {
                // Of the values as they are shown, so that the row adds up.
                let scale = 10f64.powi(self.decimals as i32);
                self.signed(((own * scale).round() - (other * scale).round()) / scale)
            }
            _ => "-".to_owned(),
        }
    }

    fn signed(&self, value: f64) -> String {
        // What rounds to nothing has no sign.
        let rounded = format!("{value:+.*}", self.decimals);
        let is_none = rounded.bytes().all(|it| b"+-0.".contains(&it));
        format!("{}{}", &rounded[usize::from(is_none)..], self.unit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distance_beyond_all_sense_is_not_counted_out() {
        assert_eq!(distance_text(0.0234), "2.3 %");
        for far in [22_519_660_479_084.685, f64::INFINITY, f64::NAN] {
            assert_eq!(distance_text(far), "more than 1000 %");
        }
    }

    #[test]
    fn without_hydraulics_nothing_is_said_of_pulses_and_energy() {
        let folder = tempfile::tempdir().expect("a folder");
        for (model, is_hydraulic) in [("ideal", false), ("first_order", false), ("dha", true)] {
            let parameters = format!("parameters:\n  dha_actuator: {{model: {model}}}\n");
            let text = format!("description: a dive\nduration: 10.0\n{parameters}");
            let scenario = Scenario::parse(&text).expect("a scenario");
            let bag = folder.path().join(format!("{model}.mcap"));
            crate::fly(&scenario, &crate::Parts::default(), &bag, "/auv", &()).expect("flown");
            let flight = Flight::read(&bag).expect("a flight");
            let summary = Summary::new(&flight, &scenario).expect("a summary");
            let conclusions = summary.conclusions().join(" ");
            assert_eq!(conclusions.contains("hydraulic"), is_hydraulic);
            let quantities = summary.quantities();
            let of = |name: &str| quantities.iter().find(|it| it.field == name);
            for field in ["pulses", "energy_supply", "efficiency"] {
                let quantity = of(field).expect("a row");
                assert_eq!(quantity.applies, is_hydraulic, "{model}: {field}");
                assert_eq!(quantity.text() != "none", is_hydraulic, "{model}: {field}");
            }
        }
    }

    /// Setpoints one after the other: what is shown is the response to the last.
    #[test]
    fn of_several_depths_the_last_is_the_step() {
        let scenario = Scenario::parse(
            "
description: two depths
duration: 80.0
parameters:
  depth_controller:
    schedule.times: [0.0, 40.0]
    schedule.depths: [1.0, 0.5]
",
        )
        .expect("a scenario");
        let folder = tempfile::tempdir().expect("a folder");
        let bag = folder.path().join("flight.mcap");
        crate::fly(&scenario, &crate::Parts::default(), &bag, "/auv", &()).expect("flown");
        let flight = Flight::read(&bag).expect("a flight");
        let summary = Summary::new(&flight, &scenario).expect("a summary");
        let depth = summary.depth.expect("a step");
        assert_eq!(summary.depth_setpoint, 0.5);
        assert!(depth.overshoot < 10.0, "{depth:?}");
        // Not that from the beginning, which it would have reached at once and left again.
        assert!(depth.rise_time.is_some_and(|t| t < 40.0), "{depth:?}");
    }
}
