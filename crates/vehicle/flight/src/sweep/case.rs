//! One case: the simulation of a scenario in this process, and its results.

use crate::error::Result;
use planesman_control::gains::FIRST_PAIR;
use planesman_hydraulics::Energy;
use planesman_linear::{Complex, StepMetrics};
use planesman_msgs::planesman_msgs::msg::ModelEstimate;

use crate::compose::{Answers, Loop, Step};
use crate::flight::{HeldDepth, step_meter};
use crate::model_summary::identified;
use crate::parts::{Model, Parts};
use crate::scenario::Scenario;

/// Results of a flight. Response and model are the same as in `planesman report`.
#[derive(Clone, Debug, Default)]
pub(super) struct Metrics {
    /// Last depth setpoint, m.
    setpoint: Option<f64>,
    /// Response to its last change.
    response: Option<StepMetrics>,
    /// Total plane travel in both directions, rad.
    travel: f64,
    /// Volumes moved by all actuators.
    pulses: u64,
    /// Hydraulic work of all actuators, J.
    work: f64,
    /// Energies of all actuators with hydraulics.
    energy: Option<Energy>,
    /// Last valid model of the first pair.
    model: Option<ModelEstimate>,
}

/// Columns of a case's numbers, before the columns of the poles.
pub const COLUMNS: [&str; 25] = [
    "depth_setpoint [m]",
    "rise_time [s]",
    "overshoot [%]",
    "settling_time_2 [s]",
    "settling_time_5 [s]",
    "steady_error [m]",
    "itae [s^2]",
    "plane_travel [rad]",
    "pulses [1]",
    "hydraulic_work [J]",
    "energy_supply [J]",
    "energy_switching [J]",
    "energy_load [J]",
    "energy_friction [J]",
    "energy_stops [J]",
    "energy_throttling [J]",
    "energy_leakage [J]",
    "energy_compression [J]",
    "energy_auxiliary [J]",
    "energy_proportional_valve [J]",
    "efficiency [%]",
    "samples [1]",
    "fit [%]",
    "steady_state_gain",
    "first_markov_parameter",
];

/// Index of the settling time in [`COLUMNS`].
pub const SETTLING: usize = 4;
/// Index of the plane travel.
pub const TRAVEL: usize = 7;

/// Number of estimates kept until the last valid one is computed.
const MOST_DUE: usize = 100;

impl Metrics {
    /// Simulates the scenario.
    ///
    /// # Errors
    /// If a vehicle or parameter is refused, or the flight fails.
    pub(super) fn fly(parts: &Parts, scenario: &Scenario) -> Result<Self> {
        let mut flight = Loop::of_parts(parts, scenario)?;
        let mut metrics = Self::default();
        let mut depths = Vec::with_capacity(scenario.ticks() as usize);
        // Times are ticks.
        let mut held: Option<HeldDepth<usize>> = None;
        let mut stood = 0.0;
        let mut due: Vec<Model> = Vec::new();
        while !flight.is_over() {
            let Step { state, answers } = flight.step()?;
            let Answers {
                control,
                actuator,
                models,
                ..
            } = answers;
            held = HeldDepth::after(held, &control, depths.len());
            depths.push(state.depth);
            for angle in &actuator.motion().dive_planes {
                metrics.travel += (angle - stood).abs();
                stood = *angle;
            }
            metrics.work += actuator.hydraulic_power() * scenario.tick;
            metrics.pulses = actuator.pulses();
            metrics.energy = actuator.energy();
            due.extend(models.into_iter().filter(|due| due.name() == FIRST_PAIR));
            if due.len() >= MOST_DUE {
                metrics.model = last_valid(&mut due).or(metrics.model);
            }
        }
        metrics.model = last_valid(&mut due).or(metrics.model);
        if let Some(held) = held {
            metrics.setpoint = Some(held.depth);
            // To the last tick, with it on.
            let response =
                |to: usize| response(&depths[..=to], held.since, held.depth, scenario.tick);
            let (response, ..) = held.judged(depths.len() - 1, response);
            metrics.response = response?;
        }
        Ok(metrics)
    }

    /// The numbers of [`COLUMNS`], then real and imaginary parts of `poles` poles, 1/s, slowest first.
    pub(super) fn numbers(&self, poles: usize) -> Vec<Option<f64>> {
        let response = |of: fn(&StepMetrics) -> Option<f64>| self.response.as_ref().and_then(of);
        let summary = self.model.as_ref().map(identified);
        let model = |of: fn(&ModelEstimate) -> f64| self.model.as_ref().map(of);
        let energy = |of: fn(&Energy) -> f64| self.energy.as_ref().map(of);
        let mut numbers = vec![
            self.setpoint,
            response(|it| it.rise_time),
            response(|it| Some(it.overshoot)),
            response(|it| it.settling_time),
            response(|it| it.settling_time_5),
            response(|it| Some(it.steady_error)),
            response(|it| Some(it.itae)),
            Some(self.travel),
            Some(self.pulses as f64),
            Some(self.work),
            energy(|it| it.supply),
            energy(|it| it.switching),
            energy(Energy::load),
            energy(|it| it.friction),
            energy(|it| it.stops),
            energy(|it| it.throttling + it.throttling_small),
            energy(|it| it.leakage),
            energy(Energy::compression),
            energy(Energy::auxiliary),
            energy(|it| it.proportional_valve),
            self.energy.and_then(|it| Some(100.0 * it.efficiency()?)),
            model(|it| it.samples as f64),
            model(|it| it.fit),
            summary.as_ref().and_then(|it| it.steady_state_gain),
            summary.as_ref().map(|it| it.first_markov_parameter),
        ];
        for place in 0..poles {
            let pole = summary.as_ref().and_then(|it| it.poles.get(place));
            numbers.extend([
                pole.map(|pole: &Complex<f64>| pole.re),
                pole.map(|pole: &Complex<f64>| pole.im),
            ]);
        }
        numbers
    }
}

/// Removes all estimates and returns the last valid one.
fn last_valid(due: &mut Vec<Model>) -> Option<ModelEstimate> {
    let mut newest_first = due.drain(..).rev().filter_map(|due| due.estimate());
    newest_first.find(|model| model.valid)
}

/// Response to a depth held from the tick `since` on; `None` if the vehicle was already there.
fn response(depths: &[f64], since: usize, setpoint: f64, tick: f64) -> Result<Option<StepMetrics>> {
    let nanos = (tick * 1e9).round() as i64;
    let time = |k: usize| (k as i64 * nanos) as f64 * 1e-9;
    let Some(from) = depths.get(since) else {
        return Ok(None);
    };
    let Some(mut meter) = step_meter(*from, setpoint, time(depths.len() - 1))? else {
        return Ok(None);
    };
    for (k, depth) in depths.iter().enumerate().skip(since) {
        meter.take(time(k), *depth)?;
    }
    Ok(Some(meter.metrics()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::Flight;

    #[test]
    fn the_numbers_of_a_case_are_those_of_the_report_on_its_bag() {
        let scenario = Scenario::parse(
            "
description: two depths
duration: 40.0
parameters:
  depth_controller:
    schedule.times: [0.0, 12.0]
    schedule.depths: [0.3, 0.5]
    identification: {signal: prbs, amplitude: 0.0349, period: 1.0}
",
        )
        .expect("a scenario");
        let metrics = Metrics::fly(&Parts::default(), &scenario).expect("flown");
        let folder = tempfile::tempdir().expect("a folder");
        let bag = folder.path().join("flight.mcap");
        crate::fly(&scenario, &crate::Parts::default(), &bag, "/auv", &()).expect("flown");
        let flight = Flight::read(&bag).expect("a flight");
        let step = flight.step.expect("a step");
        assert_eq!(metrics.setpoint, Some(0.5));
        assert_eq!(metrics.setpoint, Some(step.setpoint));
        assert!(metrics.response.is_some());
        assert_eq!(metrics.response, step.response);
        assert!(metrics.model.is_some());
        assert_eq!(metrics.model, flight.model);
        let pulses: u64 = flight.actuators.values().map(|it| it.pulses).sum();
        assert_eq!(metrics.pulses, pulses);
        let energies = flight.actuators.values().map(|it| it.energy);
        assert_eq!(metrics.energy, energies.reduce(|sum, it| sum + it));
        assert!(metrics.energy.is_some_and(|it| it.closure() < Some(1e-12)));
        assert!(metrics.travel > 0.0 && metrics.work > 0.0);
        assert_eq!(metrics.numbers(3).len(), COLUMNS.len() + 6);
    }
}
