//! The rates of the states, and one integration step.

use planesman_linear::{DORMAND_PRINCE_NODES, dormand_prince_step};

use super::{FIRST_EDGE, Mode, STATES, Simulation};
use crate::circuit::{MOST_LEVELS, root};

/// Number of states of a circuit with at most four edges, the usual case.
const FEW_STATES: usize = FIRST_EDGE + 2 * 4;

impl Simulation {
    /// The force on the ram without friction, N.
    #[inline(always)]
    pub(super) fn net(&self, time: f64, row: &[f64]) -> f64 {
        let load = &self.circuit.load;
        let [a, b] = self.circuit.areas();
        row[2] * a + row[3] * b
            - load.spring * row[0]
            - load.force
            - self.force_at(time)
            - self.stop_force(row).0
    }

    #[inline(always)]
    pub(super) fn force_at(&self, time: f64) -> f64 {
        self.force.begin + self.force.rate * time
    }

    /// The elastic stop's force against positive motion, N, and its damping part.
    #[inline(always)]
    pub(super) fn stop_force(&self, row: &[f64]) -> (f64, f64) {
        let (Some(side), Some(stop)) = (self.contact, self.circuit.load.elastic_stop) else {
            return (0.0, 0.0);
        };
        let depth = side * row[0] - self.circuit.load.travel;
        let spring = stop.stiffness * depth;
        let whole = spring * (1.0 + stop.damping * side * row[1]).max(0.0);
        (side * whole, side * (whole - spring))
    }

    /// The rates of all states.
    #[inline(always)]
    pub(super) fn rates(&self, time: f64, row: &[f64; STATES]) -> [f64; STATES] {
        if self.lines.is_empty() {
            self.rates_of::<STATES, false>(time, row)
        } else {
            self.rates_behind_lines(time, row)
        }
    }

    #[inline(never)]
    pub(super) fn rates_behind_lines(&self, time: f64, row: &[f64; STATES]) -> [f64; STATES] {
        self.rates_of::<STATES, true>(time, row)
    }

    /// The rates of the first `N` states, with lines or without.
    #[inline(always)]
    fn rates_of<const N: usize, const LINES: bool>(&self, time: f64, row: &[f64; N]) -> [f64; N] {
        // At the valves less at the source.
        let mut differences = [0.0; MOST_LEVELS];
        if LINES {
            for line in self.lines.iter().filter(|line| line.is_open()) {
                differences[line.level] = self.at_valves(line, time, row).pressure;
            }
        }
        let c = &*self.circuit;
        let load = &c.load;
        let [a, b] = &c.chambers;
        let [x, v, p_a, p_b] = [row[0], row[1], row[2], row[3]];
        let mut rates = [0.0; N];
        let pressures = [p_a, p_b];
        let mut flows = [0.0; 2];
        for (place, edge) in c.edges.iter().enumerate() {
            if self.k[place] == 0.0 {
                continue;
            }
            let mut drop = c.levels[edge.level].pressure - pressures[edge.chamber];
            if LINES {
                drop += differences[edge.level];
            }
            let flow = self.k[place] * root(drop, c.valves.transition);
            flows[edge.chamber] += flow;
            rates[FIRST_EDGE + 2 * place] = flow;
            rates[FIRST_EDGE + 1 + 2 * place] = flow * drop;
        }
        let leak = c.seal_leakage * (p_a - p_b);
        rates[9] = leak * (p_a - p_b);
        let squeezed = [flows[0] - leak - a.area * v, flows[1] + leak + b.area * v];

        rates[2] = c.oil.effective(p_a, row[10]) / a.volume_at(a.area * x) * squeezed[0];
        rates[10] = c.oil.air_rate(p_a, row[10], rates[2]);
        let mut powers = [p_a * squeezed[0], 0.0];
        if b.area > 0.0 {
            rates[3] = c.oil.effective(p_b, row[11]) / b.volume_at(-b.area * x) * squeezed[1];
            rates[11] = c.oil.air_rate(p_b, row[11], rates[3]);
            powers[1] = p_b * squeezed[1];
        }
        rates[4] = powers[0] + powers[1];
        rates[5] = powers[0].max(0.0) + powers[1].max(0.0);
        if let Mode::Sliding(sign) = self.mode {
            rates[0] = v;
            rates[1] = (self.net(time, row) - load.viscous * v - sign * load.coulomb) / load.mass;
            rates[6] = load.viscous * v * v;
            rates[7] = self.force_at(time) * v;
            rates[8] = self.stop_force(row).1 * v;
        }
        rates
    }

    /// A step of length `h` from here, and its error.
    pub(super) fn stepped(&self, h: f64) -> ([f64; STATES], [f64; STATES]) {
        if !self.lines.is_empty() {
            return self.stepped_behind_lines(h);
        }
        let times = DORMAND_PRINCE_NODES.map(|share| self.time + share * h);
        if self.circuit.edges.len() > 4 {
            return dormand_prince_step(&self.row, h, &times, |time, row| {
                self.rates_of::<STATES, false>(*time, row)
            });
        }
        let mut few = [0.0; FEW_STATES];
        few.copy_from_slice(&self.row[..FEW_STATES]);
        let (after, error) = dormand_prince_step(&few, h, &times, |time, row| {
            self.rates_of::<FEW_STATES, false>(*time, row)
        });
        let (mut row, mut errors) = ([0.0; STATES], [0.0; STATES]);
        row[..FEW_STATES].copy_from_slice(&after);
        errors[..FEW_STATES].copy_from_slice(&error);
        (row, errors)
    }

    // Apart, so that it costs circuits without lines nothing.
    #[inline(never)]
    fn stepped_behind_lines(&self, h: f64) -> ([f64; STATES], [f64; STATES]) {
        let times = DORMAND_PRINCE_NODES.map(|share| self.time + share * h);
        dormand_prince_step(&self.row, h, &times, |time, row| {
            self.rates_behind_lines(*time, row)
        })
    }
}
