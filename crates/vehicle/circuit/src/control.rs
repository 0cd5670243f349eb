//! The control laws, which choose the open valves once every sampling period.
//!
//! The commanded speed is `v_r = v_ref + K_p (x_ref - x)`; within the dead zone, while the reference rests, it is zero and all valves
//! close. [`Law::Model`] is the steady-state search of model-based digital flow control (M. Linjama, M. Huova et al., *Design and
//! implementation of energy saving digital hydraulic control system*, SICFP 2007; A. Laamanen, *Minimization of pressure peaks in the
//! digital hydraulic system*, TUT 2009). The controller compares pairs of edges and their openings. For each opening of A's edge it considers the
//! present opening of B's edge, and the openings next to the one needed for the commanded speed. The cost includes the steady speed under the
//! measured force, switchings, power, and the resulting pressures: the steady ones, those while only one edge has switched, and their overshoot when
//! load and oil spring absorb the change of speed. Pressures above the limit, or below atmospheric pressure (an empty chamber), have a cost that
//! grows with the distance from the limit.

use crate::circuit::{Circuit, Law, MOST_EDGES, MOST_VALVES};
use crate::coding::{Opening, SAME_FLOW, openings};
use crate::simulation::Simulation;

/// Cost of a pressure beyond the limit per relative excess: a tenth costs as much as an error of the whole speed.
const OVER_LIMIT: f64 = 10.0;

/// The maximum of this cost, so that a ram that can be moved or stopped only beyond the limit still is.
const MOST_OVER: f64 = 0.4;

/// The reference at the beginning of a sampling period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reference {
    /// m
    pub position: f64,
    /// m/s; 0 if not known.
    pub speed: f64,
}

/// The controller of a circuit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Controller {
    openings: Vec<Vec<Opening>>,
    pairs: Vec<[Option<usize>; 2]>,
    largest_speed: f64,
    largest_power: f64,
    /// For the laws without measured pressures: the pair for each direction, and its speed with all valves open.
    both_ways: [Option<([Option<usize>; 2], f64)>; 2],
    /// The filtered force of the oil on the ram, N.
    force: Option<f64>,
}

impl Controller {
    pub(crate) fn new(circuit: &Circuit) -> Self {
        let openings: Vec<Vec<Opening>> = circuit
            .edges
            .iter()
            .map(|edge| openings(&edge.valves))
            .collect();
        let pairs = circuit.pairs();
        let whole = |edge: Option<usize>| {
            edge.and_then(|edge| openings[edge].last())
                .map_or(0.0, |all| all.k)
        };
        let fastest = |sign: f64| {
            let speeds = pairs.iter().filter_map(|pair| {
                let steady = circuit.steady(*pair, pair.map(whole), circuit.load.force)?;
                (steady.speed * sign > 0.0).then_some((*pair, steady.speed.abs()))
            });
            speeds.max_by(|one, other| one.1.total_cmp(&other.1))
        };
        let powers = pairs
            .iter()
            .filter_map(|pair| circuit.steady(*pair, pair.map(whole), 0.0));
        Self {
            largest_speed: circuit.largest_speed().max(1e-9),
            largest_power: powers.map(|steady| steady.power.abs()).fold(1e-9, f64::max),
            both_ways: [fastest(1.0), fastest(-1.0)],
            openings,
            pairs,
            force: None,
        }
    }

    /// Commands the valves at the beginning of a sampling period.
    pub(crate) fn decide(&mut self, simulation: &mut Simulation, reference: Reference) {
        let circuit = simulation.circuit().clone();
        let control = &circuit.control;
        let period = control.period as f64 * 1e-9;
        let [x, v, p_a, p_b] = simulation.at(0.0);
        let [a, b] = circuit.areas();
        let oil = p_a * a + p_b * b;
        let share = if control.force_filter > 0.0 {
            period / (period + control.force_filter)
        } else {
            1.0
        };
        let before = self.force.unwrap_or(oil);
        let force = before + share * (oil - before);
        self.force = Some(force);
        let error = reference.position - x;
        let rests = reference.speed == 0.0 && error.abs() <= control.dead_zone;
        let asked = if rests {
            0.0
        } else {
            reference.speed + control.gain * error
        };
        let mut masks = [0; MOST_EDGES];
        // The part of the period for which they hold.
        let mut duty = 1.0;
        if asked != 0.0 {
            match control.law {
                Law::Nearest => self.nearest(&circuit, simulation, asked, &mut masks),
                Law::Model => {
                    let measured = Measured {
                        position: x,
                        speed: v,
                        pressures: [p_a, p_b],
                        force,
                    };
                    self.by_model(&circuit, simulation, asked, &measured, &mut masks);
                }
                Law::Pwm => {
                    if let Some((pair, fastest)) = self.both_ways[usize::from(asked < 0.0)] {
                        for edge in pair.into_iter().flatten() {
                            masks[edge] = self.openings[edge].last().map_or(0, |all| all.mask);
                        }
                        duty = asked.abs() / fastest;
                    }
                }
            }
        }
        simulation.command(0.0, &masks);
        if duty < 1.0 {
            simulation.command(duty * period, &[0; MOST_EDGES]);
        }
    }

    /// Among openings of an edge with the same flow, the opening that switches the fewest valves; equal cases prefer valves with the fewest
    /// switchings so far.
    fn choices(&self, simulation: &Simulation, edge: usize) -> Vec<Opening> {
        let commanded = simulation.commanded()[edge];
        let cost = |opening: &Opening| {
            let switched = opening.mask ^ commanded;
            let wear = (0..MOST_VALVES).filter(|valve| switched >> valve & 1 == 1);
            let most = wear.map(|valve| simulation.switchings(edge, valve)).max();
            (switched.count_ones(), most)
        };
        let mut choices: Vec<Opening> = Vec::new();
        for opening in &self.openings[edge] {
            match choices.last_mut() {
                Some(last) if opening.k <= last.k * (1.0 + SAME_FLOW) => {
                    if cost(opening) < cost(last) {
                        *last = *opening;
                    }
                }
                _ => choices.push(*opening),
            }
        }
        choices
    }

    /// Each edge at the opening whose flow at half of the supply pressure is nearest.
    fn nearest(
        &self,
        circuit: &Circuit,
        simulation: &Simulation,
        asked: f64,
        masks: &mut [u32; MOST_EDGES],
    ) {
        let Some((pair, _)) = self.both_ways[usize::from(asked < 0.0)] else {
            return;
        };
        let (high, low) = circuit.pressures();
        let root = (0.5 * (high - low)).sqrt();
        for (chamber, edge) in pair.into_iter().enumerate() {
            let Some(edge) = edge else { continue };
            let choices = self.choices(simulation, edge);
            let wanted = circuit.chambers[chamber].area * asked.abs() / root;
            let largest = self.openings[edge].last().map_or(1.0, |all| all.k);
            let cost = |opening: &&Opening| {
                let switched = (opening.mask ^ simulation.commanded()[edge]).count_ones();
                (opening.k - wanted).abs() / largest
                    + circuit.control.switching_cost * f64::from(switched)
            };
            let best = choices
                .iter()
                .min_by(|one, other| cost(one).total_cmp(&cost(other)));
            masks[edge] = best.map_or(0, |best| best.mask);
        }
    }

    /// The pair and openings with the lowest cost.
    fn by_model(
        &self,
        circuit: &Circuit,
        simulation: &Simulation,
        asked: f64,
        measured: &Measured,
        masks: &mut [u32; MOST_EDGES],
    ) {
        let force = measured.force;
        let overshoots = measured.overshoots(circuit);
        let control = &circuit.control;
        let commanded = simulation.commanded();
        let all_switched: u32 = commanded.iter().map(|mask| mask.count_ones()).sum();
        let over = |pressures: [f64; 2], speed: f64| {
            measured.cost_over_limits(circuit, overshoots, pressures, speed)
        };
        let mut best = asked.abs() / self.largest_speed
            + control.switching_cost * f64::from(all_switched)
            + over(measured.pressures, 0.0);
        let choices: Vec<Vec<Opening>> = (0..circuit.edges.len())
            .map(|edge| self.choices(simulation, edge))
            .collect();
        for pair in &self.pairs {
            let Some(a) = pair[0] else { continue };
            let open = |edge: usize| {
                self.openings[edge]
                    .iter()
                    .find(|o| o.mask == commanded[edge])
                    .map_or(0.0, |o| o.k)
            };
            let others = all_switched
                - commanded[a].count_ones()
                - pair[1].map_or(0, |b| commanded[b].count_ones());
            let mut weigh = |first: &Opening, second: Option<&Opening>| {
                let k = [first.k, second.map_or(0.0, |second| second.k)];
                let Some(steady) = circuit.steady(*pair, k, force) else {
                    return;
                };
                let mut switched = others + (first.mask ^ commanded[a]).count_ones();
                if let (Some(b), Some(second)) = (pair[1], second) {
                    switched += (second.mask ^ commanded[b]).count_ones();
                }
                let mut cost = (asked - steady.speed).abs() / self.largest_speed
                    + control.switching_cost * f64::from(switched)
                    + control.energy_cost * steady.power / self.largest_power;
                if cost >= best {
                    return;
                }
                // Also while one edge has switched already and the other not yet.
                let mut worst = over(steady.pressures, steady.speed);
                if let Some(b) = pair[1] {
                    for mixed in [[k[0], open(b)], [open(a), k[1]]] {
                        if let Some(between) = circuit.steady(*pair, mixed, force) {
                            worst = worst.max(over(between.pressures, between.speed));
                        }
                    }
                }
                cost += worst;
                if cost < best {
                    best = cost;
                    *masks = [0; MOST_EDGES];
                    masks[a] = first.mask;
                    if let (Some(b), Some(second)) = (pair[1], second) {
                        masks[b] = second.mask;
                    }
                }
            };
            for first in &choices[a] {
                let Some(b) = pair[1] else {
                    weigh(first, None);
                    continue;
                };
                let list = &choices[b];
                let wanted = needed(circuit, *pair, first.k, asked, force);
                let place = list.partition_point(|opening| opening.k < wanted);
                for near in [place.wrapping_sub(1), place] {
                    if let Some(second) = list.get(near) {
                        weigh(first, Some(second));
                    }
                }
                if let Some(same) = list.iter().find(|opening| opening.mask == commanded[b]) {
                    weigh(first, Some(same));
                }
            }
        }
    }
}

/// The controller's measurements.
struct Measured {
    /// m
    position: f64,
    /// m/s
    speed: f64,
    /// Gauge, Pa.
    pressures: [f64; 2],
    /// Force of the oil on the ram, filtered, N.
    force: f64,
}

impl Measured {
    /// The overshoot of each chamber's pressure per change of speed, Pa s/m: the load oscillates on the oil with `w = sqrt(k/M)`,
    /// `k = sum of B A^2/V`, by `dv/w`, and the pressure of each chamber changes by `B A/V` per distance.
    fn overshoots(&self, circuit: &Circuit) -> [f64; 2] {
        let travels = circuit.areas().map(|area| area * self.position);
        let per_way = [0, 1].map(|place| {
            let chamber = &circuit.chambers[place];
            let volume = chamber.volume_at(travels[place]);
            let pressure = self.pressures[place];
            circuit
                .oil
                .effective(pressure, circuit.oil.air_at(pressure))
                * chamber.area
                / volume
        });
        let stiffness =
            per_way[0] * circuit.chambers[0].area + per_way[1] * circuit.chambers[1].area;
        per_way.map(|per_way| per_way / (stiffness / circuit.load.mass).sqrt())
    }

    /// The cost of pressures beyond the limits at a speed, which increases with the excess.
    fn cost_over_limits(
        &self,
        circuit: &Circuit,
        overshoots: [f64; 2],
        pressures: [f64; 2],
        speed: f64,
    ) -> f64 {
        let limit = circuit.control.pressure_limit;
        let supply = circuit.pressures().0;
        let change = (speed - self.speed).abs();
        let mut cost: f64 = 0.0;
        for (chamber, pressure) in pressures.iter().enumerate() {
            if circuit.chambers[chamber].area == 0.0 {
                continue;
            }
            let swing = overshoots[chamber] * change;
            if pressure + swing > limit {
                cost = cost.max(OVER_LIMIT * ((pressure + swing) / limit - 1.0));
            }
            if pressure - swing < 0.0 {
                cost = cost.max(OVER_LIMIT * (swing - pressure) / supply);
            }
        }
        cost.min(MOST_OVER)
    }
}

/// The opening of B's edge that gives the speed `asked` when A's edge has the opening `k`; 0 if there is none.
fn needed(circuit: &Circuit, pair: [Option<usize>; 2], k: f64, asked: f64, force: f64) -> f64 {
    let level = |edge: Option<usize>| {
        edge.map_or(0.0, |edge| {
            circuit.levels[circuit.edges[edge].level].pressure
        })
    };
    let [a, b] = [circuit.chambers[0].area, circuit.chambers[1].area];
    let surplus =
        (level(pair[0]) * a - level(pair[1]) * b - force) * asked.signum() - circuit.load.coulomb;
    let left = surplus / (asked * asked) - a * a * a / (k * k);
    if left > 0.0 {
        (b * b * b / left).sqrt()
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::Reference;
    use crate::actuator::{Actuator, Demand};
    use crate::file::{BUILT_IN, parse};

    #[test]
    fn the_model_based_law_decides_as_a_program_of_its_own() {
        // numpy weighs the openings as docs/circuit.md says, scipy's DOP853 at 1e-10 moves the ram: after so many periods of 20 ms x, p_A and p_B.
        let expected = [
            (
                20,
                [0.09328350485727624, 7117763.563490348, 11320999.57041379],
            ),
            (
                60,
                [-0.09470798407827162, 4459215.863235611, 7601192.9493104],
            ),
            (
                120,
                [-0.011559187001654809, 6187996.046070885, 9355211.55139133],
            ),
            (
                160,
                [0.02902296931638821, 6560247.968389653, 10841942.698684316],
            ),
        ];
        let mut circuit = parse(BUILT_IN[0].1).unwrap();
        circuit.valves.scatter = 0.0;
        let period = circuit.control.period;
        let mut actuator = Actuator::new(&Arc::new(circuit), 1e-11, 0.0, 0.0, 1);
        for tick in 0..160 {
            let position = match tick {
                0..40 => 0.1,
                40..110 => -0.12,
                _ => 0.03,
            };
            let reference = Reference {
                position,
                speed: 0.0,
            };
            actuator.advance_to(
                (tick + 1) * period,
                Demand {
                    reference,
                    ..Demand::default()
                },
            );
            if let Some((_, [x, p_a, p_b])) = expected.iter().find(|(after, _)| *after == tick + 1)
            {
                let found = actuator.at((tick + 1) * period);
                assert!((found[0] - x).abs() < 1e-10, "{tick}: {found:?}");
                assert!(
                    (found[2] - p_a).abs() < 1.0 && (found[3] - p_b).abs() < 1.0,
                    "{tick}: {found:?}"
                );
            }
        }
    }
}
