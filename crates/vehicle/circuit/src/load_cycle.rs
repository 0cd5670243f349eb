//! A load cycle, and the results of a circuit that follows it.

use std::sync::Arc;

use crate::actuator::{Actuator, Demand};
use crate::circuit::Circuit;
use crate::control::Reference;
use crate::ledger::Ledger;
use crate::simulation::Force;

/// The largest force on a load, N.
pub const MOST_FORCE: f64 = 1e8;

/// Number of samples of the position error in a sampling period.
const SAMPLES: i64 = 4;

/// A load cycle, linear between its points.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadCycle {
    points: Vec<Point>,
}

/// A point of a load cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// s
    pub time: f64,
    /// Reference of the ram, m.
    pub position: f64,
    /// Force against positive motion, N.
    pub force: f64,
}

/// The reason why points do not form a load cycle.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LoadCycleError {
    /// Fewer than two.
    #[error("a load cycle needs at least two points, but has {0}")]
    Few(usize),
    /// Not finite.
    #[error("point {0} of the load cycle has a number that is not finite")]
    NotFinite(usize),
    /// Time does not increase.
    #[error("point {0} of the load cycle is not later than the previous point")]
    Order(usize),
    /// The load cycle lasts longer than a day, or less than a millisecond.
    #[error("the load cycle lasts {0} s; 0.001 to 86400 s are allowed")]
    Length(f64),
    /// A force beyond the range of a circuit's file.
    #[error(
        "point {point} of the load cycle has a force of {force} N; at most {MOST_FORCE} N in \
         either direction are allowed"
    )]
    Force {
        /// Its number, from 1.
        point: usize,
        /// N
        force: f64,
    },
    /// The ram cannot reach this position.
    #[error(
        "point {point} of the load cycle, {position} m, is beyond the ram's travel of +-{travel} m"
    )]
    Travel {
        /// Its number, from 1.
        point: usize,
        /// m
        position: f64,
        /// m
        travel: f64,
    },
}

impl LoadCycle {
    /// A load cycle through `points`; the first may have any time.
    ///
    /// # Errors
    /// [`LoadCycleError`], with the number of the point, from 1.
    pub fn new(mut points: Vec<Point>) -> Result<Self, LoadCycleError> {
        if points.len() < 2 {
            return Err(LoadCycleError::Few(points.len()));
        }
        for (place, point) in points.iter().enumerate() {
            if ![point.time, point.position, point.force]
                .iter()
                .all(|number| number.is_finite())
            {
                return Err(LoadCycleError::NotFinite(place + 1));
            }
            if point.force.abs() > MOST_FORCE {
                return Err(LoadCycleError::Force {
                    point: place + 1,
                    force: point.force,
                });
            }
        }
        if let Some(place) = points.windows(2).position(|two| two[1].time <= two[0].time) {
            return Err(LoadCycleError::Order(place + 2));
        }
        let first = points[0].time;
        for point in &mut points {
            point.time -= first;
        }
        let cycle = Self { points };
        if !(1e-3..=86_400.0).contains(&cycle.duration()) {
            return Err(LoadCycleError::Length(cycle.duration()));
        }
        Ok(cycle)
    }

    /// Checks that the ram of `circuit` can reach every point.
    ///
    /// # Errors
    /// [`LoadCycleError::Travel`].
    pub fn fits(&self, circuit: &Circuit) -> Result<(), LoadCycleError> {
        let travel = circuit.load.travel;
        match self
            .points
            .iter()
            .position(|point| point.position.abs() > travel)
        {
            None => Ok(()),
            Some(place) => Err(LoadCycleError::Travel {
                point: place + 1,
                position: self.points[place].position,
                travel,
            }),
        }
    }

    /// The energy, J, that an ideal 4-way proportional valve without lag and leakage would need for the motion of the reference: the highest level's
    /// pressure times each volume into a chamber, minus the lowest level's pressure times each volume out of the other.
    #[must_use]
    pub fn proportional(&self, circuit: &Circuit) -> f64 {
        let ways = self.points.windows(2);
        ways.map(|two| circuit.proportional(two[1].position - two[0].position))
            .sum()
    }

    /// The standard deviation of the reference over time, m.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        let mean = |of: &dyn Fn(f64, f64) -> f64| {
            let lines = self
                .points
                .windows(2)
                .map(|two| of(two[0].position, two[1].position) * (two[1].time - two[0].time));
            lines.sum::<f64>() / self.duration()
        };
        let middle = mean(&|one, other| 0.5 * (one + other));
        let square = mean(&|one, other| {
            let (one, other) = (one - middle, other - middle);
            (one * one + one * other + other * other) / 3.0
        });
        square.sqrt()
    }

    /// s
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.points.last().map_or(0.0, |last| last.time)
    }

    /// Position and force at `time`, and their rates from there on; after the end the last point.
    #[must_use]
    pub fn at(&self, time: f64) -> (Point, Point) {
        let later = self.points.partition_point(|point| point.time <= time);
        let rest = |point: Point| (Point { time, ..point }, Point::default());
        match (
            later.checked_sub(1).map(|before| self.points[before]),
            self.points.get(later),
        ) {
            (Some(one), Some(two)) => {
                let span = two.time - one.time;
                let rate = Point {
                    time: 1.0,
                    position: (two.position - one.position) / span,
                    force: (two.force - one.force) / span,
                };
                let since = time - one.time;
                (
                    Point {
                        time,
                        position: one.position + rate.position * since,
                        force: one.force + rate.force * since,
                    },
                    rate,
                )
            }
            (Some(last), None) => rest(last),
            (None, first) => rest(first.copied().unwrap_or_default()),
        }
    }
}

/// The results of a circuit that follows a load cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Energy from the supply plus the energy of the solenoids, J.
    pub energy: f64,
    /// Root mean square of reference minus position, m.
    pub tracking: f64,
    /// Whether the ram reached a stop, because it could not carry its load or overshot.
    pub met_stop: bool,
    /// The largest position error, m.
    pub largest_error: f64,
    /// The highest pressure in a chamber, gauge, Pa.
    pub peak_pressure: f64,
    /// The lowest pressure in a chamber, gauge, Pa.
    pub lowest_pressure: f64,
    /// The highest and the lowest pressure at the valves' end of a line ([`Simulation::line_peaks`](crate::Simulation::line_peaks)),
    /// gauge, Pa; `None` without lines.
    pub line_pressures: Option<(f64, f64)>,
    /// Switchings of all valves per hour, opening and closing counted separately.
    pub switchings: f64,
    /// Time until the valve that switches most has reached its rated life, h.
    pub life: f64,
    /// The ledger at the end.
    pub ledger: Ledger,
    /// Number of integration steps.
    pub steps: u64,
    /// Whether the motion could not be solved ([`Simulation::unsolved`](crate::Simulation::unsolved)): the other numbers are then
    /// meaningless.
    pub unsolved: bool,
}

/// Follows `cycle` once, from rest at its beginning, and passes the time and `[x, v, p_A, p_B]` to `trace` four times a sampling period.
#[must_use]
pub fn run(
    circuit: &Arc<Circuit>,
    cycle: &LoadCycle,
    accuracy: f64,
    seed: u64,
    mut trace: impl FnMut(f64, [f64; 4]),
) -> Figures {
    let period = circuit.control.period;
    let seconds = |nanos: i64| nanos as f64 * 1e-9;
    let start = cycle.at(0.0).0;
    let mut actuator = Actuator::new(circuit, accuracy, start.position, start.force, seed);
    let end = (cycle.duration() * 1e9).round() as i64;
    let (mut squares, mut samples, mut largest) = (0.0, 0_u64, 0.0_f64);
    let mut begin = 0;
    trace(0.0, actuator.at(0));
    while begin < end {
        let (point, rate) = cycle.at(seconds(begin));
        // The force at the period's end as it will be, so that it is continuous.
        let then = cycle.at(seconds(begin + period)).0;
        let demand = Demand {
            reference: Reference {
                position: point.position,
                speed: rate.position,
            },
            force: Force {
                begin: point.force,
                rate: (then.force - point.force) / seconds(period),
            },
        };
        for sample in 1..=SAMPLES {
            let now = (begin + period * sample / SAMPLES).min(end);
            actuator.advance_to(now, demand);
            let row = actuator.at(now);
            let error = cycle.at(seconds(now)).0.position - row[0];
            squares += error * error;
            samples += 1;
            largest = largest.max(error.abs());
            trace(seconds(now), row);
        }
        begin += period;
    }
    let simulation = actuator.simulation();
    let ledger = actuator.ledger(end);
    let hours = cycle.duration() / 3600.0;
    let (highest, lowest) = simulation.peaks();
    Figures {
        energy: ledger.supply + ledger.switching,
        tracking: (squares / samples.max(1) as f64).sqrt(),
        met_stop: simulation.met_stop(),
        largest_error: largest,
        peak_pressure: highest,
        lowest_pressure: lowest,
        line_pressures: simulation.line_peaks(),
        switchings: simulation.total_switchings() as f64 / hours,
        life: circuit.valves.rated_life / f64::from(simulation.most_switchings()) * hours,
        ledger,
        steps: simulation.steps(),
        unsolved: simulation.unsolved(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::circuit::Law;
    use crate::coding::Coding;
    use crate::file::{BUILT_IN, parse};
    use planesman_parameters::Choice as _;

    fn point(time: f64, position: f64, force: f64) -> Point {
        Point {
            time,
            position,
            force,
        }
    }

    #[test]
    fn the_model_based_law_draws_no_chamber_empty_while_a_load_is_lowered() {
        let mut circuit = parse(BUILT_IN[0].1).unwrap();
        for edge in &mut circuit.edges {
            edge.valves = Coding::Pcm.share(edge.valves.iter().sum(), 6);
        }
        let circuit = Arc::new(circuit);
        let points = vec![
            point(0.0, 0.15, 2500.0),
            point(1.0, 0.15, 2500.0),
            point(2.5, -0.05, 2500.0),
            point(3.0, -0.05, 2500.0),
        ];
        let cycle = LoadCycle::new(points).unwrap();
        for seed in 1..=6 {
            let figures = run(&circuit, &cycle, 1e-6, seed, |_, _| ());
            assert!(figures.tracking < 1.5e-3, "{seed}: {}", figures.tracking);
            assert!(
                figures.lowest_pressure > -2e4,
                "{seed}: {}",
                figures.lowest_pressure
            );
            assert!(!figures.met_stop);
        }
    }

    #[test]
    fn however_coarse_its_valves_the_model_based_law_follows_and_meets_no_stop() {
        let points = vec![
            point(0.0, -0.15, 800.0),
            point(1.5, 0.15, 800.0),
            point(2.5, 0.15, 2500.0),
            point(4.0, -0.05, 2500.0),
            point(5.0, -0.05, 800.0),
        ];
        let cycle = LoadCycle::new(points).unwrap();
        for name in Coding::NAMES {
            for count in 3..=6 {
                let mut circuit = parse(BUILT_IN[0].1).unwrap();
                for edge in &mut circuit.edges {
                    edge.valves = Coding::named(name)
                        .unwrap()
                        .share(edge.valves.iter().sum(), count);
                }
                let figures = run(&circuit.into(), &cycle, 1e-6, 1, |_, _| ());
                assert!(
                    !figures.met_stop && figures.tracking < 0.02,
                    "{name} {count}: {figures:?}"
                );
            }
        }
    }

    #[test]
    fn every_law_closes_its_valves_where_nothing_moves_the_ram_the_way_it_is_asked() {
        for name in Law::NAMES {
            let mut circuit = parse(BUILT_IN[0].1).unwrap();
            circuit.control.law = Law::named(name).unwrap();
            // More than the supply pushes, and than the limit would let the chamber hold.
            circuit.control.pressure_limit = f64::INFINITY;
            circuit.load.force = 12_000.0;
            let points = vec![
                point(0.0, 0.1, 0.0),
                point(0.2, 0.0, 0.0),
                point(0.3, 0.2, 0.0),
                point(2.0, 0.2, 0.0),
            ];
            let mut last = [0.0; 4];
            let figures = run(
                &circuit.into(),
                &LoadCycle::new(points).unwrap(),
                1e-6,
                1,
                |_, row| last = row,
            );
            assert!(
                last[1].abs() < 1e-3 && !figures.met_stop,
                "{name}: {last:?}"
            );
        }
    }
}
