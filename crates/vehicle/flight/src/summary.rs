//! The summary of a flight: the depth response, and the identified model beside the true one.

use std::fmt;

use crate::error::{Result, refused};
use planesman_control::{ControllerParameters, Mode};
use planesman_hydraulics::{ActuatorFile, ActuatorParameters, Energy, actuator_file};
use planesman_linear::{Complex, ComplexFunctions as _, StepMetrics, TransferFunction, pole_text};
use planesman_parameters::Choice as _;
use planesman_plant::PlantParameters;
use planesman_text::number;

use crate::flight::Flight;
use crate::model_summary::{ModelSummary, identified, slowest_first};
use crate::scenario::Scenario;
use crate::titles;
use crate::track::Track;

/// Tolerance of the dominant pole, relative to its magnitude.
pub const POLE_TOLERANCE: f64 = 0.10;

/// Those of [`Summary::quantities`] that are of the response to a step.
const RESPONSE: std::ops::RangeInclusive<usize> = 1..=5;

/// The summary of a flight.
#[derive(Clone, Debug)]
pub struct Summary {
    /// The last depth setpoint, m.
    pub depth_setpoint: f64,
    /// The response to the last change of the depth setpoint, `None` when the flight has no depth step.
    pub depth: Option<StepMetrics>,
    /// The test signal on the planes, which disturbs that response; `None` when the flight had none.
    pub test_signal: Option<String>,
    /// The identified model, `None` while none is valid.
    pub identified: Option<ModelSummary>,
    /// Regression rows behind it.
    pub samples: u64,
    /// One-step fit, %.
    pub fit: f64,
    /// Why there is no identified model.
    pub no_model: String,
    /// The vehicle's own model at its speed.
    pub truth: ModelSummary,
    /// Ticks without the actuator's answer.
    pub held_ticks: u64,
    /// Pulses that all actuators issued.
    pub pulses: u64,
    /// Whether hydraulics move one of the planes, as not with an ideal actuator.
    pub is_hydraulic: bool,
    /// The energies of all actuators; `None` of those without hydraulics.
    pub energy: Option<Energy>,
    /// What an ideal proportional valve would take for the same motion in the actuator's own circuit, J; `None` of several
    /// actuators, of a file that is not there, and with supply pressure lost.
    pub proportional: Option<f64>,
    /// Whether thrusters alone moved it: then there is no response to planes.
    pub hovers: bool,
    /// How it kept to its way-points or its place, where it had any.
    pub track: Option<Track>,
    /// Irregularities of the bag, a sentence each.
    pub notes: Vec<String>,
}

impl Summary {
    /// The summary of `flight`, a run of `scenario`.
    ///
    /// # Errors
    /// When the flight holds no states or the scenario's vehicle cannot be linearised.
    pub fn new(flight: &Flight, scenario: &Scenario) -> Result<Self> {
        let Some(step) = &flight.step else {
            return Err(refused!("the bag holds no vehicle states"));
        };
        let model = flight.model.as_ref();
        let controller: ControllerParameters = scenario.parameters_of("depth_controller")?;
        let hovers = controller.mode == Mode::Hover;
        let actuators: ActuatorParameters = scenario.parameters_of("dha_actuator")?;
        Ok(Self {
            hovers,
            track: Track::of(&flight.time_histories.place, &controller, hovers),
            depth_setpoint: step.setpoint,
            depth: step.response,
            test_signal: test_signal(scenario)?,
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

    /// The distance of the identified dominant pole from the true one, relative to its magnitude.
    #[must_use]
    pub fn pole_error(&self) -> Option<f64> {
        let identified = self.identified.as_ref()?.dominant()?;
        let truth = self.truth.dominant()?;
        Some((identified - truth).modulus() / truth.modulus())
    }

    /// The quantities that flights are compared by.
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
        let signal = self.test_signal.as_deref();
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
            ("test_signal", "", 0, Err(signal.unwrap_or("none"))),
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

    /// The gains of plane angle to pitch rate: name, identified, true.
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

    /// What is to be known first, a sentence each.
    #[must_use]
    pub fn conclusions(&self) -> Vec<String> {
        let depth = self.depth.as_ref().map(|depth| {
            let settles = match (depth.settling_time, depth.settling_time_5) {
                (Some(t), _) => format!("settles within 2 % after {t:.1} s"),
                (None, Some(t)) => format!("settles within 5 % after {t:.1} s, not within 2 %"),
                (None, None) => "does not settle within 5 %".to_owned(),
            };
            let disturbed = match self.test_signal {
                Some(_) => ", with the test signal on the planes",
                None => "",
            };
            format!(
                "Depth {:.3} m: {settles}, overshoot {:.1} %, steady error {:+.1} mm{disturbed}.",
                self.depth_setpoint,
                depth.overshoot,
                1e3 * depth.steady_error
            )
        });
        let model = match (&self.identified, self.pole_error()) {
            (Some(model), Some(error)) => {
                let within = if error <= POLE_TOLERANCE { "" } else { "NOT " };
                format!(
                    "Pitch response identified {within}within {:.0} %: {}. The dominant pole is {} from the true one.",
                    100.0 * POLE_TOLERANCE,
                    model.modes().join("; "),
                    distance_text(error)
                )
            }
            _ => format!("No valid model of the pitch response: {}.", self.no_model),
        };
        let model = Some(model).filter(|_| !self.hovers);
        let track = self.track.as_ref().map(Track::text);
        depth.into_iter().chain(track).chain(model).collect()
    }
}

/// The test signal of a scenario, with its amplitude; it disturbs every response to a step.
///
/// # Errors
/// When the scenario's parameters are refused.
pub fn test_signal(scenario: &Scenario) -> Result<Option<String>> {
    let controller: ControllerParameters = scenario.parameters_of("depth_controller")?;
    let (signal, amplitude) = (
        controller.identification.signal.name(),
        controller.identification.amplitude.to_degrees(),
    );
    let is_on = signal != "none" && amplitude != 0.0;
    Ok(is_on.then(|| format!("{signal} of {amplitude:.2} deg on the planes")))
}

/// The vehicle's own sampled model between plane angle and pitch rate.
fn truth(scenario: &Scenario) -> Result<ModelSummary> {
    truth_of(&scenario.parameters_of("plant_sim")?, scenario.tick)
}

/// The same of the vehicle with these parameters.
pub fn truth_of(parameters: &PlantParameters, tick: f64) -> Result<ModelSummary> {
    let craft = planesman_plant::Craft::load(parameters).map_err(|e| refused!("{e}"))?;
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

/// `b1` of `(b0 z^n + b1 z^(n-1) + ...)/(z^n + ...)`: nothing comes through at once, b0 = 0.
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

/// What an ideal proportional valve takes for the motion of a flight's only actuator in its own circuit, J.
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

/// The energies of actuators in one line, with what an ideal proportional valve takes in the same circuit.
#[must_use]
pub fn energy_line(energy: &Energy, proportional: Option<f64>) -> String {
    let shares = energy.terms().map(|(name, it)| {
        let share = format!("{:.1} %", 100.0 * it / energy.supply);
        (name, share)
    });
    let named = shares
        .into_iter()
        .filter(|(_, share)| !["0.0 %", "-0.0 %"].contains(&share.as_str()));
    let named: Vec<_> = named
        .map(|(name, share)| format!("{name} {share}"))
        .collect();
    let valve = proportional.map_or_else(String::new, |joule| {
        let joule = number(joule);
        format!("; an ideal proportional valve in the same circuit would need {joule} J")
    });
    let supply = number(energy.supply);
    format!(
        "Energy of the supply: {supply} J: {}{valve}",
        named.join(", ")
    )
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

/// A distance relative to the true pole's magnitude, %; beyond ten times that its number says nothing.
#[must_use]
pub fn distance_text(distance: f64) -> String {
    if distance <= 10.0 {
        format!("{:.1} %", 100.0 * distance)
    } else {
        "more than 1000 %".to_owned()
    }
}

/// A quantity of a flight, as people read it.
#[derive(Clone, Debug)]
pub struct Quantity {
    /// Its field, one of [`titles`].
    pub field: &'static str,
    /// Behind its number.
    pub unit: &'static str,
    /// Behind the point.
    pub decimals: usize,
    /// Whether the flight's vehicle can have it: an ideal actuator has no pulses.
    pub applies: bool,
    /// Its value, or why there is none.
    value: Result<f64, String>,
}

impl Quantity {
    /// Its value with its unit.
    #[must_use]
    pub fn text(&self) -> String {
        match &self.value {
            Ok(value) if self.field == "steady_error" => self.signed(*value),
            Ok(value) => format!("{value:.*}{}", self.decimals, self.unit),
            Err(reason) => reason.clone(),
        }
    }

    /// By how much it is more than that of another flight.
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

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.depth.is_some() {
            writeln!(f, "Depth response to {:.3} m", self.depth_setpoint)?;
            for quantity in &self.quantities()[RESPONSE] {
                let name = titles::name(quantity.field);
                writeln!(f, "  {name:<24}{}", quantity.text())?;
            }
            if let Some(signal) = &self.test_signal {
                writeln!(f, "  test signal             {signal}")?;
            }
            writeln!(f)?;
        }
        if let Some(track) = &self.track {
            let end = if self.hovers { "" } else { "\n\n" };
            write!(f, "Track: {}{end}", track.text())?;
        }
        if !self.hovers {
            self.fmt_planes(f)?;
        }
        for note in &self.notes {
            write!(f, "\nNote: {note}")?;
        }
        Ok(())
    }
}

impl Summary {
    /// The model from planes to pitch rate, and the actuators.
    fn fmt_planes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "Plane angle -> pitch rate   {:>22}  {:>22}",
            "identified", "true"
        )?;
        match &self.identified {
            None => writeln!(f, "  no valid model: {}", self.no_model)?,
            Some(model) => {
                let rows = model.poles.len().max(self.truth.poles.len());
                let text = |poles: &[Complex<f64>], i: usize| {
                    poles.get(i).map_or_else(String::new, |p| pole_text(*p, 4))
                };
                for i in 0..rows {
                    writeln!(
                        f,
                        "  pole {} [1/s]              {:>22}  {:>22}",
                        i + 1,
                        text(&model.poles, i),
                        text(&self.truth.poles, i)
                    )?;
                }
                for (name, identified, truth) in self.gains() {
                    writeln!(f, "  {name:<26}{identified:>22}  {truth:>22}")?;
                }
                if let Some(error) = self.pole_error() {
                    writeln!(
                        f,
                        "  dominant pole {} of the true one (distance {} of its magnitude, {} samples, one-step fit {:.2} %)",
                        if error <= POLE_TOLERANCE {
                            format!("within {:.0} %", 100.0 * POLE_TOLERANCE)
                        } else {
                            format!("NOT within {:.0} %", 100.0 * POLE_TOLERANCE)
                        },
                        distance_text(error),
                        self.samples,
                        self.fit
                    )?;
                }
            }
        }
        match self.is_hydraulic {
            true => write!(f, "\nActuator: {} pulses; ticks", self.pulses)?,
            false => write!(f, "\nActuator: ticks")?,
        }
        write!(f, " without its answer: {}", self.held_ticks)?;
        if let Some(energy) = &self.energy {
            write!(f, "\n{}", energy_line(energy, self.proportional))?;
        }
        Ok(())
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
            assert_eq!(summary.to_string().contains("pulses"), is_hydraulic);
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
