//! A running FMU: setting, stepping and reading, without the C interface.
//!
//! The subject is sampled: a tick uses the inputs at its beginning, and is complete when a step reaches its end. Steps of any length are
//! allowed; a step of one tick corresponds to the loop.

use planesman_parameters::{Declaration, Value};

use crate::resources::Resources;
use crate::subject::Simulation;
use crate::variable::{Causality, Variable};

/// The maximum number of ticks in one step: a longer step is a mistake of units.
const MOST_TICKS: f64 = 1e7;

/// The share of a tick by which times may differ by rounding. At large times the distance between floating-point numbers may be at most
/// this share of a tick, or times are not exact enough.
const ROUNDING: f64 = 1e-6;
const MOST_ROUNDING: f64 = 0.1;

/// The share of a tick by which times near `time` may differ, because importers add up rounded steps.
fn rounding(time: f64, tick: f64) -> f64 {
    ROUNDING.max(4.0 * f64::EPSILON * time.abs() / tick)
}

/// The reason why a call fails. The instance is then unchanged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum Fault {
    /// The call is not allowed now: `fmi3Error`.
    #[error("{0}")]
    Misuse(String),
    /// The values are not accepted, but others would be: `fmi3Discard`.
    #[error("{0}")]
    Discarded(String),
}

/// `Misuse` of a formatted text.
macro_rules! misuse {
    ($($part:tt)*) => { $crate::instance::Fault::Misuse(format!($($part)*)) };
}
pub(crate) use misuse;

/// The state of an instance between its creation and its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Instantiated,
    Initialisation,
    Steps,
    Terminated,
}

/// The changing state of a simulation.
struct State {
    phase: Phase,
    /// The values of every variable except time, in their order.
    values: Vec<Value>,
    simulation: Option<Box<dyn Simulation>>,
    start: f64,
    time: f64,
    /// Number of completed ticks.
    ticks: f64,
    /// The inputs of the current tick, once it has begun.
    taken: Option<Vec<f64>>,
}

impl State {
    /// The state after instantiation.
    fn new(resources: &Resources) -> Self {
        let start = resources.variables();
        Self {
            phase: Phase::Instantiated,
            values: start.map(|it| it.declaration.default.clone()).collect(),
            simulation: None,
            start: 0.0,
            time: 0.0,
            ticks: 0.0,
            taken: None,
        }
    }
}

impl Clone for State {
    fn clone(&self) -> Self {
        Self {
            values: self.values.clone(),
            simulation: self.simulation.as_ref().map(|it| it.copy()),
            taken: self.taken.clone(),
            ..*self
        }
    }
}

/// An instance of an FMU.
pub(crate) struct Instance {
    resources: Resources,
    state: State,
}

/// A state that the importer saves, to return to it later.
pub(crate) struct Kept(State);

impl Instance {
    pub(crate) fn new(resources: Resources) -> Self {
        Self {
            state: State::new(&resources),
            resources,
        }
    }

    /// The variable of a value reference, and its index; `None` for time.
    fn place(&self, reference: u32) -> Result<Option<usize>, Fault> {
        let place = (reference as usize).checked_sub(1);
        match place {
            Some(place) if place >= self.state.values.len() => Err(misuse!(
                "value reference {reference}: there is no such variable"
            )),
            place => Ok(place),
        }
    }

    /// The values of variables.
    ///
    /// # Errors
    /// If there is no such variable.
    pub(crate) fn get(&mut self, references: &[u32]) -> Result<Vec<Value>, Fault> {
        let places = references.iter().map(|it| self.place(*it));
        let places: Vec<Option<usize>> = places.collect::<Result<_, _>>()?;
        self.refresh()?;
        let time = || Value::Double(self.state.time);
        let value = |place: usize| self.state.values[place].clone();
        Ok(places
            .into_iter()
            .map(|it| it.map_or_else(time, value))
            .collect())
    }

    /// Sets all variables, or no variable if one is refused.
    ///
    /// # Errors
    /// If a variable must not be set now, or a value is invalid.
    pub(crate) fn set(&mut self, values: Vec<(u32, Value)>) -> Result<(), Fault> {
        let mut new = self.state.values.clone();
        let mut parameters = false;
        for (reference, value) in values {
            let place = self.place(reference)?;
            let place = place.ok_or_else(|| misuse!("the time cannot be set as a variable"))?;
            let Variable {
                declaration,
                causality,
            } = self.resources.variable(place);
            let name = &declaration.name;
            match (causality, self.state.phase) {
                (Causality::Output(_), _) => return Err(misuse!("{name} is an output")),
                (_, Phase::Terminated) => return Err(misuse!("{name}: the FMU is terminated")),
                (Causality::Parameter, Phase::Steps) if declaration.read_only => {
                    return Err(misuse!("{name} is fixed during the simulation"));
                }
                (Causality::Parameter, _) => parameters = true,
                (Causality::Input, _) => {}
            }
            new[place] = accepted(declaration, value)?;
        }
        std::mem::swap(&mut self.state.values, &mut new);
        if parameters {
            let parameters = self.parameters();
            let taken = match &mut self.state.simulation {
                Some(simulation) if self.state.phase == Phase::Steps => {
                    simulation.set_parameters(&parameters)
                }
                _ => {
                    self.state.simulation = None;
                    Ok(())
                }
            };
            if let Err(refusal) = taken {
                self.state.values = new;
                return Err(Fault::Discarded(refusal.to_string()));
            }
        }
        Ok(())
    }

    /// # Errors
    /// If not called after instantiation.
    pub(crate) fn enter_initialisation(&mut self, start: f64) -> Result<(), Fault> {
        if self.state.phase != Phase::Instantiated {
            return Err(misuse!(
                "initialization must follow instantiation or a reset"
            ));
        }
        let tick = self.resources.subject.tick();
        if !start.is_finite() || rounding(start, tick) > MOST_ROUNDING {
            return Err(misuse!(
                "start time {start:e} s refused: numbers of that size cannot represent ticks of {tick} s; start at 0"
            ));
        }
        (self.state.start, self.state.time) = (start, start);
        self.state.phase = Phase::Initialisation;
        Ok(())
    }

    /// # Errors
    /// If not called in initialization, or parameters conflict.
    pub(crate) fn exit_initialisation(&mut self) -> Result<(), Fault> {
        if self.state.phase != Phase::Initialisation {
            return Err(misuse!("the FMU is not in initialization mode"));
        }
        self.refresh()?;
        self.state.phase = Phase::Steps;
        Ok(())
    }

    /// # Errors
    /// Before the end of initialization.
    pub(crate) fn terminate(&mut self) -> Result<(), Fault> {
        if self.state.phase != Phase::Steps {
            return Err(misuse!("the simulation has not begun"));
        }
        self.state.phase = Phase::Terminated;
        Ok(())
    }

    /// Returns to the state after instantiation.
    pub(crate) fn reset(&mut self) {
        self.state = State::new(&self.resources);
    }

    pub(crate) fn keep(&self) -> Kept {
        Kept(self.state.clone())
    }

    pub(crate) fn go_back(&mut self, kept: &Kept) {
        self.state = kept.0.clone();
    }

    pub(crate) fn time(&self) -> f64 {
        self.state.time
    }

    /// Steps from `from`, which must be the current time, by `step`, both in s.
    ///
    /// # Errors
    /// If `from` is another instant, the step is not positive or too long, the motion diverges, or an output is not finite.
    pub(crate) fn step(&mut self, from: f64, step: f64) -> Result<(), Fault> {
        let tick = self.resources.subject.tick();
        if self.state.phase != Phase::Steps {
            return Err(misuse!(
                "a step is possible only between the end of initialization and the end of the simulation"
            ));
        }
        let time = self.state.time;
        let rounding = rounding(time, tick);
        // Written so that NaN is refused too.
        let is_here = (from - time).abs() <= rounding * tick;
        if !is_here {
            return Err(misuse!(
                "step from {from} s refused: the time of the FMU is {time} s"
            ));
        }
        if !(step > 0.0 && step / tick <= MOST_TICKS) {
            return Err(misuse!(
                "step of {step} s refused: it must be above 0, and at most {MOST_TICKS:e} ticks \
                 of {tick} s"
            ));
        }
        let mut next = self.state.clone();
        next.time = from + step;
        if next.time <= time || rounding > MOST_ROUNDING {
            return Err(misuse!(
                "step of {step} s from {from} s refused: numbers of that size cannot represent so short a step"
            ));
        }
        // Where the step ends, in ticks since the start.
        let end = (next.time - next.start) / tick;
        let inputs = self.inputs();
        if let Some(simulation) = &mut next.simulation {
            while next.ticks + 1.0 <= end + rounding {
                let taken = next.taken.take().unwrap_or_else(|| inputs.clone());
                (simulation.advance(&taken)).map_err(|it| Fault::Discarded(it.to_string()))?;
                next.ticks += 1.0;
            }
        }
        if next.ticks + rounding < end {
            next.taken.get_or_insert(inputs);
        }
        let before = std::mem::replace(&mut self.state, next);
        let done = self.refresh();
        if done.is_err() {
            self.state = before;
        }
        done
    }

    fn parameters(&self) -> Vec<(String, Value)> {
        let all = self.resources.variables().zip(&self.state.values);
        all.filter(|(variable, _)| variable.causality == Causality::Parameter)
            .map(|(variable, value)| (variable.declaration.name.clone(), value.clone()))
            .collect()
    }

    fn inputs(&self) -> Vec<f64> {
        let all = self.resources.variables().zip(&self.state.values);
        all.filter(|(variable, _)| variable.causality == Causality::Input)
            .flat_map(|(_, value)| value.numbers())
            .collect()
    }

    /// Updates the outputs; from initialization on.
    ///
    /// # Errors
    /// If parameters conflict, or an output is not finite.
    fn refresh(&mut self) -> Result<(), Fault> {
        if self.state.phase == Phase::Instantiated {
            return Ok(());
        }
        if self.state.simulation.is_none() {
            let begun = self.resources.subject.begin(&self.parameters());
            self.state.simulation = Some(begun.map_err(|it| Fault::Discarded(it.to_string()))?);
        }
        let inputs = self.inputs();
        let Some(simulation) = &self.state.simulation else {
            return Ok(());
        };
        let outputs = simulation.outputs(&inputs);
        let all = self.resources.variables().zip(&mut self.state.values);
        let places = all.filter(|(variable, _)| matches!(variable.causality, Causality::Output(_)));
        for ((variable, place), output) in places.zip(outputs) {
            if let Some(number) = output.numbers().into_iter().find(|it| !it.is_finite()) {
                let (name, time) = (&variable.declaration.name, self.state.time);
                return Err(Fault::Discarded(format!("{name} is {number} at {time} s")));
            }
            *place = output;
        }
        Ok(())
    }
}

/// The value in the variable's own type, checked against its range.
fn accepted(declaration: &Declaration, value: Value) -> Result<Value, Fault> {
    if std::mem::discriminant(&value) != std::mem::discriminant(&declaration.default) {
        let name = &declaration.name;
        let expected = declaration.default.type_with_article();
        return Err(misuse!(
            "{name} was set with the wrong type: {expected} is expected"
        ));
    }
    let value = declaration.accept(value);
    value.map_err(|refusal| Fault::Discarded(refusal.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resources::Manifest;
    use crate::subject::Kind;
    use std::path::Path;

    const AUV: &str = include_str!("../../hydraulics/actuators/auv.yaml");
    const DFCU: &str = include_str!("../../circuit/circuits/dfcu.yaml");

    fn actuator(text: &str) -> Instance {
        let manifest = Manifest {
            format: crate::resources::Format::One,
            version: String::new(),
            kind: Kind::Actuator,
            file: "actuator.yaml".to_owned(),
            tick: None,
            start: Vec::new(),
        };
        let resources = Resources::of(manifest, Path::new("actuator.yaml"), text);
        Instance::new(resources.expect("an actuator"))
    }

    fn begun(text: &str, start: f64) -> Instance {
        let mut instance = actuator(text);
        instance.enter_initialisation(start).expect("a start");
        instance.exit_initialisation().expect("initialised");
        instance
    }

    fn reference(instance: &Instance, name: &str) -> u32 {
        let place = (instance.resources.variables()).position(|it| it.declaration.name == name);
        1 + place.expect("a variable") as u32
    }

    fn number(instance: &mut Instance, name: &str) -> f64 {
        let reference = reference(instance, name);
        match instance.get(&[reference]).expect("a value")[0] {
            Value::Double(number) => number,
            ref other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_step_from_no_instant_or_another_one_is_refused() {
        let mut fmu = begun(AUV, 0.0);
        for from in [
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
            1e300,
            0.01,
            -1e-3,
        ] {
            let fault = fmu.step(from, 0.05).expect_err("another instant");
            assert!(matches!(fault, Fault::Misuse(_)), "{fault}");
        }
        for step in [f64::INFINITY, f64::NAN, 0.0, -0.05, 1e300] {
            assert!(fmu.step(0.0, step).is_err(), "{step}");
        }
        assert_eq!(fmu.time(), 0.0);
        fmu.step(1e-9, 0.05).expect("here but for rounding");
    }

    #[test]
    fn a_clock_of_seconds_since_1970_neither_jumps_nor_runs_back() {
        let start = 1.7e9;
        let mut fmu = begun(AUV, start);
        for from in [start + 1.5, start - 1.5, start + 1e-3] {
            assert!(fmu.step(from, 0.05).is_err(), "{from}");
        }
        // As long as the step, but from a number before the present one.
        let before = start - 2f64.powi(-22);
        assert!(fmu.step(before, 1e-9).is_err(), "time would run back");
        for k in 0..100 {
            fmu.step(start + f64::from(k) * 0.05, 0.05)
                .expect("the next tick");
            assert_eq!(fmu.state.ticks, f64::from(k + 1));
        }
        for start in [1e16, -1e300, f64::MAX, f64::INFINITY, f64::NAN] {
            let refused = actuator(AUV).enter_initialisation(start);
            assert!(refused.is_err(), "{start}");
        }
    }

    #[test]
    fn numbers_that_would_hang_or_overflow_are_refused_by_their_field() {
        for (name, value) in [
            ("load.viscous", 1e20),
            ("load.moment_arm", 1e308),
            ("leakage.rate_gain", 1e308),
        ] {
            let mut fmu = actuator(AUV);
            let reference = reference(&fmu, name);
            fmu.set(vec![(reference, Value::Double(value))])
                .expect("a number");
            fmu.enter_initialisation(0.0).expect("a start");
            let fault = fmu.exit_initialisation().expect_err(name);
            assert!(matches!(fault, Fault::Discarded(_)), "{fault}");
            assert!(fault.to_string().contains(name), "{fault}");
        }
    }

    /// The works on a circuit's ram since the start add up at every instant, to what the ram's speed there makes of its mass.
    #[test]
    fn the_outputs_of_a_circuit_at_an_instant_belong_to_it() {
        let mut fmu = begun(DFCU, 0.0);
        let command = reference(&fmu, "plane_command");
        let mass = number(&mut fmu, "load.mass");
        for k in 0..40 {
            let angle = if k % 20 < 10 { 0.2 } else { -0.2 };
            fmu.set(vec![(command, Value::Double(angle))])
                .expect("a command");
            fmu.step(f64::from(k) * 0.05, 0.05).expect("a tick");
            let speed = number(&mut fmu, "ram_velocity");
            let kinetic = number(&mut fmu, "energy_kinetic");
            let expected = 0.5 * mass * speed * speed;
            assert!(
                (kinetic - expected).abs() < 1e-9 * (1.0 + expected),
                "{k}: {kinetic} {expected}"
            );
        }
    }
}
