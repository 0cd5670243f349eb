//! The motion of ram and oil between and at the events.
//!
//! ```text
//! M dv/dt = p_A A_A - p_B A_B - C v - F_C sgn v - K x - F - stop
//! dp_A/dt = B(p_A)/(V_A + A_A x) (Q_A - A_A v),   dp_B/dt = B(p_B)/(V_B - A_B x) (Q_B + A_B v)
//! Q = sum of K_e root(p_level - p), less or plus what leaks past the piston
//! ```
//! Between two events the right-hand side is smooth, and DOP853 integrates it with error control. Events are: a valve opens or closes, the
//! ram halts, breaks away, reaches a stop or leaves it. Each except the first is the zero of a margin, located to the last bits by steps of
//! other lengths from the same start. The work of each part is integrated together with the motion. With lines ([`crate::line`]) a step is
//! at most a round trip long, and ends where a jump of a wave arrives.
//!
//! Steps depend on events and commands only, not on when results are read.

mod plan;
mod rates;

use std::sync::Arc;

use planesman_linear::{DORMAND_PRINCE_DENSE_NODES, DormandPrinceDense};
use rand::RngExt as _;
use rand_pcg::{Pcg64, rand_core::SeedableRng as _};

use crate::circuit::{Circuit, MOST_EDGES};
use crate::ledger::Ledger;
use crate::line::{AtValves, LineStep, NODES, Waves};

/// The index of the first edge's volume and loss.
const FIRST_EDGE: usize = 12;
/// Position, speed, pressures of A and B. Then integrals: net compression, compression work, viscous work, work on the load's force, work of the
/// stops' damping, work of the seal. Then the air's volume in A and B relative to the oil's; volume and loss of each edge.
const STATES: usize = FIRST_EDGE + 2 * MOST_EDGES;

/// The smallest jump of a line's wave at which an integration step ends, as a multiple of a step's largest error.
const JUMP: f64 = 1.0;
/// A step this short, s, is accepted regardless of its error. If a cycle has many such steps and events, the motion counts as unsolved.
const SHORTEST: f64 = 1e-9;
const MOST_FORCED: u32 = 100_000;

/// The state of the ram's contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    /// Sliding in this direction, +1 or -1.
    Sliding(f64),
    /// Held by friction.
    Stuck,
    /// Resting on the rigid stop of this side.
    AtStop(f64),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Event {
    Halt(f64),
    BreakAway(f64),
    Stop(f64),
    Release(f64),
    ContactOn(f64),
    ContactOff(f64),
}

/// A future opening or closing of a valve.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Transition {
    /// s from the beginning of the cycle.
    time: f64,
    edge: usize,
    valve: usize,
    open: bool,
}

/// The next stretch of motion.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stretch {
    end: f64,
    after: [f64; STATES],
    /// Slopes of p_A and p_B at beginning and end, Pa/s.
    slopes: [[f64; 2]; 2],
    event: Option<Event>,
}

/// A force against positive motion, N, that changes linearly over a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Force {
    /// N at the beginning of the cycle.
    pub begin: f64,
    /// N/s
    pub rate: f64,
}

/// Totals of the motion so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Totals {
    /// The way, m.
    slid: f64,
    /// The energy of an ideal proportional valve for the same motion, J.
    proportional: f64,
    met_stop: bool,
    /// Kinetic energy absorbed by rigid stops, J.
    impacts: f64,
    /// Stored energy at the start, J.
    first: f64,
    /// Highest and lowest (`lowest`) of the chambers' pressures, gauge, Pa.
    highest: f64,
    lowest: f64,
    steps: u64,
}

/// Ram, oil and valves. A clone has exactly the same future.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    circuit: Arc<Circuit>,
    /// Largest error of a step, relative to each quantity's scale.
    accuracy: f64,
    scales: [f64; STATES],
    longest: f64,
    /// s from the beginning of the cycle.
    time: f64,
    row: [f64; STATES],
    mode: Mode,
    /// The elastic stop in contact with the ram.
    contact: Option<f64>,
    force: Force,
    open: [u32; MOST_EDGES],
    commanded: [u32; MOST_EDGES],
    k: [f64; MOST_EDGES],
    pending: Vec<Transition>,
    stretch: Option<Stretch>,
    /// The waves of each line; one entry for each level with a line.
    lines: Vec<Waves>,
    /// The quantities at the valves of lines over the stretch.
    line_steps: Vec<(usize, LineStep)>,
    step: f64,
    random: Pcg64,
    switchings: Vec<u32>,
    totals: Totals,
    /// Number of steps in the present cycle that were accepted despite too large an error, and of events.
    forced: u32,
    unsolved: bool,
}

impl Simulation {
    /// A simulation at rest at `position`, m, with all valves closed. Chamber B has half the highest level's pressure, and A has the pressure that
    /// carries the load.
    #[must_use]
    pub fn new(circuit: Arc<Circuit>, accuracy: f64, position: f64, force: f64, seed: u64) -> Self {
        let c = &*circuit;
        let (high, low) = c.pressures();
        let [a, b] = c.chambers;
        let needed = c.load.spring * position + c.load.force + force;
        // Beside a single-acting ram is the atmosphere.
        let p_b = if b.area > 0.0 {
            low + 0.5 * (high - low)
        } else {
            0.0
        };
        let p_a = ((p_b * b.area + needed) / a.area).clamp(low, high);
        let p_b = if b.area > 0.0 {
            ((p_a * a.area - needed) / b.area).clamp(low, high)
        } else {
            0.0
        };
        let mut row = [0.0; STATES];
        row[..4].copy_from_slice(&[position, 0.0, p_a, p_b]);
        row[10] = c.oil.air_at(p_a);
        row[11] = c.oil.air_at(p_b);
        let volume = a.area.max(b.area) * c.load.travel;
        let mut scales = [high * volume; STATES];
        scales[..4].copy_from_slice(&[c.load.travel, c.largest_speed().max(1e-3), high, high]);
        for edge in 0..MOST_EDGES {
            scales[FIRST_EDGE + 2 * edge] = volume;
        }
        scales[10] = c.oil.air;
        scales[11] = c.oil.air;
        // The split of the compression has kinks that need not be resolved.
        scales[5] = f64::INFINITY;
        let longest = 0.25 / c.highest_frequency();
        let levels = c.levels.iter().enumerate();
        let lines = levels
            .filter_map(|(place, level)| {
                let small = JUMP * accuracy * high;
                Some(Waves::new(place, level.line?, small))
            })
            .collect();
        let valves = c.edges.len() * crate::circuit::MOST_VALVES;
        let mut new = Self {
            accuracy,
            scales,
            longest,
            time: 0.0,
            row,
            mode: Mode::Stuck,
            contact: None,
            force: Force {
                begin: force,
                rate: 0.0,
            },
            open: [0; MOST_EDGES],
            commanded: [0; MOST_EDGES],
            k: [0.0; MOST_EDGES],
            pending: Vec::new(),
            stretch: None,
            lines,
            line_steps: Vec::new(),
            step: longest,
            random: Pcg64::seed_from_u64(seed),
            switchings: vec![0; valves],
            totals: Totals {
                highest: p_a.max(p_b),
                lowest: if b.area > 0.0 { p_a.min(p_b) } else { p_a },
                ..Totals::default()
            },
            forced: 0,
            unsolved: false,
            circuit,
        };
        new.mode = new.at_rest();
        new.totals.first = new.stored(&row);
        new
    }

    /// The circuit.
    #[must_use]
    pub fn circuit(&self) -> &Arc<Circuit> {
        &self.circuit
    }

    /// The valves commanded open, for each edge.
    #[must_use]
    pub fn commanded(&self) -> &[u32; MOST_EDGES] {
        &self.commanded
    }

    /// Number of commanded switchings of all valves, opening and closing counted separately.
    #[must_use]
    pub fn total_switchings(&self) -> u64 {
        self.switchings.iter().map(|count| u64::from(*count)).sum()
    }

    /// Number of commanded switchings of one valve.
    pub(crate) fn switchings(&self, edge: usize, valve: usize) -> u32 {
        self.switchings[edge * crate::circuit::MOST_VALVES + valve]
    }

    /// Number of switchings of the valve with the most.
    #[must_use]
    pub fn most_switchings(&self) -> u32 {
        self.switchings.iter().copied().max().unwrap_or(0)
    }

    /// The highest and the lowest pressure in a chamber so far, gauge, Pa.
    #[must_use]
    pub fn peaks(&self) -> (f64, f64) {
        (self.totals.highest, self.totals.lowest)
    }

    /// The highest and the lowest pressure at the valves' end of a line, gauge, Pa; `None` without lines. Each step of the integration is
    /// checked at nine points. Below [`-ATMOSPHERE`](crate::ATMOSPHERE) real oil would boil, which this model of a line does not include.
    #[must_use]
    pub fn line_peaks(&self) -> Option<(f64, f64)> {
        let lines = self.lines_at(self.time);
        let of = lines.iter().map(|line| {
            let source = self.circuit.levels[line.level].pressure;
            (source + line.peaks().0, source + line.peaks().1)
        });
        of.reduce(|one, other| (one.0.max(other.0), one.1.min(other.1)))
    }

    /// Whether the ram has reached a stop since the start.
    #[must_use]
    pub fn met_stop(&self) -> bool {
        self.totals.met_stop
    }

    /// The energy, J, that an ideal 4-way proportional valve without lag and leakage would need for the same motion up to `time`, to which the
    /// simulation has been advanced: the highest level's pressure times each volume into a chamber, minus the lowest level's pressure times each
    /// volume out of the other.
    #[must_use]
    pub fn proportional(&self, time: f64) -> f64 {
        let moved = self.row_at(time)[0] - self.row[0];
        self.totals.proportional + self.circuit.proportional(moved)
    }

    /// Whether the motion could not be solved: it is no longer finite, or a cycle has endlessly many events or steps shorter than a
    /// nanosecond.
    #[must_use]
    pub fn unsolved(&self) -> bool {
        self.unsolved
    }

    /// Whether the ram rests on a stop or presses into one.
    #[must_use]
    pub fn at_stop(&self) -> bool {
        matches!(self.mode, Mode::AtStop(_)) || self.contact.is_some()
    }

    /// Net volume, m^3, taken from the supply levels up to `time`, to which the simulation has been advanced.
    #[must_use]
    pub fn volume(&self, time: f64) -> f64 {
        let row = self.row_at(time);
        let edges = self.circuit.edges.iter().enumerate();
        let at_valves: f64 = edges
            .filter(|(_, edge)| self.circuit.levels[edge.level].line.is_none())
            .map(|(place, _)| row[FIRST_EDGE + 2 * place])
            .sum();
        let lines = self.lines_at(time);
        at_valves + lines.iter().map(|line| line.taken(0.0).volume).sum::<f64>()
    }

    /// Steps taken.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.totals.steps
    }

    /// The state of the ram's contact.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Position m, speed m/s, p_A and p_B gauge Pa at `time`, to which the simulation has been advanced.
    #[must_use]
    pub fn at(&self, time: f64) -> [f64; 4] {
        let [x, v, a, b, ..] = self.row_at(time);
        [x, v, a, b]
    }

    fn row_at(&self, time: f64) -> [f64; STATES] {
        if time > self.time {
            self.stepped(time - self.time).0
        } else {
            self.row
        }
    }

    /// Commands the valves of each edge at `time` in the cycle: bit i opens valve i. A valve moves after its delay; if a command is
    /// withdrawn before that, nothing moves.
    pub fn command(&mut self, time: f64, masks: &[u32; MOST_EDGES]) {
        let circuit = Arc::clone(&self.circuit);
        for (edge, mask) in masks.iter().enumerate().take(circuit.edges.len()) {
            let changed = mask ^ self.commanded[edge];
            self.commanded[edge] = *mask;
            for valve in
                (0..circuit.edges[edge].valves.len()).filter(|valve| changed >> valve & 1 == 1)
            {
                let open = mask >> valve & 1 == 1;
                let common = &circuit.valves;
                let delay = if open { common.opening } else { common.closing };
                let scatter = if common.scatter > 0.0 {
                    common.scatter * (2.0 * self.random.random::<f64>() - 1.0)
                } else {
                    0.0
                };
                let at = time + (delay + scatter).max(0.0);
                self.switchings[edge * crate::circuit::MOST_VALVES + valve] += 1;
                let its = |pending: &&Transition| pending.edge == edge && pending.valve == valve;
                self.pending
                    .retain(|pending| !its(&pending) || pending.time < at);
                let last = self
                    .pending
                    .iter()
                    .rfind(its)
                    .map_or(self.open[edge] >> valve & 1 == 1, |last| last.open);
                if last != open {
                    let place = self.pending.partition_point(|pending| pending.time <= at);
                    self.pending.insert(
                        place,
                        Transition {
                            time: at,
                            edge,
                            valve,
                            open,
                        },
                    );
                    self.stretch = None;
                }
            }
        }
    }

    /// The force on the load in this cycle.
    pub fn set_force(&mut self, force: Force) {
        if force != self.force {
            self.force = force;
            self.stretch = None;
        }
    }

    /// Changes the force on the load, N, stepwise at `time`, to which the simulation has been advanced; the force then stays constant.
    pub fn push(&mut self, time: f64, force: f64) {
        let force = Force {
            begin: force,
            rate: 0.0,
        };
        if force == self.force {
            return;
        }
        let after = self.row_at(time);
        // What was planned at the valves of lines went further.
        self.line_steps = self.line_steps(time - self.time);
        let slopes = [self.rates(self.time, &self.row), self.rates(time, &after)];
        self.commit(&Stretch {
            end: time.max(self.time),
            after,
            slopes: slopes.map(|rates| [rates[2], rates[3]]),
            event: None,
        });
        self.set_force(force);
        let net = self.net(self.time, &self.row);
        match self.mode {
            Mode::Stuck => self.mode = self.at_rest(),
            Mode::AtStop(side) if side * net < -self.circuit.break_away() => {
                self.mode = Mode::Sliding(-side);
            }
            Mode::AtStop(_) | Mode::Sliding(_) => {}
        }
    }

    /// Begins a new cycle at the end of the present one, which is `period` s long and has been completed.
    pub fn next_cycle(&mut self, period: f64) {
        self.advance(period, period);
        self.time = 0.0;
        self.forced = 0;
        self.stretch = None;
        for line in &mut self.lines {
            line.set_back(period);
        }
        for pending in &mut self.pending {
            pending.time -= period;
        }
        self.force = Force {
            begin: self.force.begin + self.force.rate * period,
            rate: 0.0,
        };
    }

    /// Advances to `time` in the cycle, which is `period` s long. An earlier time has no effect.
    pub fn advance(&mut self, time: f64, period: f64) {
        while !self.unsolved {
            while self
                .pending
                .first()
                .is_some_and(|first| first.time <= self.time)
            {
                let moved = self.pending.remove(0);
                self.open[moved.edge] ^= 1 << moved.valve;
                let valves = &self.circuit.edges[moved.edge].valves;
                let open = self.open[moved.edge];
                self.k[moved.edge] = (0..valves.len())
                    .filter(|valve| open >> valve & 1 == 1)
                    .map(|valve| valves[valve])
                    .sum();
                let edge = &self.circuit.edges[moved.edge];
                let its = |line: &&mut Waves| line.level == edge.level;
                if let Some(line) = self.lines.iter_mut().find(its) {
                    line.open(edge.chamber, self.k[moved.edge]);
                }
            }
            let limit = self
                .pending
                .first()
                .map_or(period, |first| first.time.min(period));
            if self.time >= limit && limit >= period {
                return;
            }
            let stretch = match self.stretch {
                Some(stretch) => stretch,
                None => {
                    let planned = self.plan(limit);
                    self.stretch = Some(planned);
                    planned
                }
            };
            if stretch.end > time {
                return;
            }
            self.commit(&stretch);
        }
    }

    /// The ledger at `time`, to which the simulation has been advanced.
    #[must_use]
    pub fn ledger(&self, time: f64) -> Ledger {
        self.ledger_of(&self.row_at(time), &self.lines_at(time))
    }

    /// The ledger for the states `row`, within the stretch that begins here.
    fn ledger_of(&self, row: &[f64; STATES], lines: &[Waves]) -> Ledger {
        let c = &*self.circuit;
        let mut ledger = Ledger {
            compression: row[4],
            compressed: row[5],
            viscous: row[6],
            friction: c.load.coulomb * (self.totals.slid + (row[0] - self.row[0]).abs()),
            stops: row[8] + self.totals.impacts,
            seal: row[9],
            load: row[7],
            mechanical: self.stored(row) - self.totals.first,
            switching: c.valves.energy * self.total_switchings() as f64,
            ..Ledger::default()
        };
        for (place, edge) in c.edges.iter().enumerate() {
            let level = &c.levels[edge.level];
            if level.line.is_none() {
                let work = row[FIRST_EDGE + 2 * place] * level.pressure;
                ledger.supply += work;
                ledger.levels[edge.level] += work;
            }
            ledger.throttling[place] = row[FIRST_EDGE + 1 + 2 * place];
        }
        for line in lines {
            let source = c.levels[line.level].pressure;
            let taken = line.taken(source);
            ledger.supply += taken.volume * source;
            ledger.levels[line.level] += taken.volume * source;
            ledger.lines += taken.stored;
            ledger.line_friction += taken.friction;
        }
        ledger
    }

    /// The lines at `time`, to which the simulation has been advanced.
    fn lines_at(&self, time: f64) -> Vec<Waves> {
        let mut lines = self.lines.clone();
        for line in &mut lines {
            // Valves may have opened just now.
            line.stay_closed(if line.is_open() { self.time } else { time });
        }
        for (place, step) in self.line_steps(time - self.time) {
            lines[place].push(&step, self.step);
        }
        lines
    }

    /// The quantities at the valves of each line with open valves, over a step of length `h` from here.
    fn line_steps(&self, h: f64) -> Vec<(usize, LineStep)> {
        self.dense(h)
            .map_or_else(Vec::new, |dense| self.line_steps_along(h, &dense))
    }

    /// A step of length `h` from here with interpolation, if valves of lines are open.
    fn dense(&self, h: f64) -> Option<DormandPrinceDense<STATES>> {
        if h <= 0.0 || !self.lines.iter().any(Waves::is_open) {
            return None;
        }
        let times = DORMAND_PRINCE_DENSE_NODES.map(|share| self.time + share * h);
        let rates = |time: &f64, row: &_| self.rates_behind_lines(*time, row);
        Some(DormandPrinceDense::new(&self.row, h, &times, rates))
    }

    fn line_steps_along(
        &self,
        h: f64,
        dense: &DormandPrinceDense<STATES>,
    ) -> Vec<(usize, LineStep)> {
        let rows = NODES.map(|node| {
            let share = 0.5 * (1.0 + node);
            (self.time + share * h, dense.at(share))
        });
        let lines = self.lines.iter().enumerate();
        let open = lines.filter(|(_, line)| line.is_open());
        let steps = open.map(|(place, line)| {
            let valves = rows
                .each_ref()
                .map(|(time, row)| self.at_valves(line, *time, row));
            (place, line.step(self.time, self.time + h, &valves))
        });
        steps.collect()
    }

    #[inline]
    fn at_valves(&self, line: &Waves, time: f64, row: &[f64]) -> AtValves {
        let source = self.circuit.levels[line.level].pressure;
        let chambers = [row[2] - source, row[3] - source];
        line.at_valves(time, chambers, self.circuit.valves.transition)
    }

    /// Kinetic energy plus the energy of springs and weight, J.
    fn stored(&self, row: &[f64; STATES]) -> f64 {
        let load = &self.circuit.load;
        let [x, v, ..] = *row;
        let depth = (x.abs() - load.travel).max(0.0);
        let stop = load
            .elastic_stop
            .map_or(0.0, |stop| 0.5 * stop.stiffness * depth * depth);
        0.5 * load.mass * v * v + 0.5 * load.spring * x * x + load.force * x + stop
    }

    fn commit(&mut self, stretch: &Stretch) {
        let before = self.row;
        let h = stretch.end - self.time;
        for chamber in 0..2 {
            if self.circuit.chambers[chamber].area == 0.0 {
                continue;
            }
            let [begin, end] = stretch.slopes.map(|slopes| h * slopes[chamber]);
            let (highest, lowest) =
                extremes(before[2 + chamber], stretch.after[2 + chamber], begin, end);
            self.totals.highest = self.totals.highest.max(highest);
            self.totals.lowest = self.totals.lowest.min(lowest);
        }
        let moved = stretch.after[0] - before[0];
        self.totals.slid += moved.abs();
        self.totals.proportional += self.circuit.proportional(moved);
        self.row = stretch.after;
        self.time = stretch.end;
        self.stretch = None;
        for (place, step) in self.line_steps.drain(..) {
            self.lines[place].push(&step, self.step);
        }
        self.totals.steps += 1;
        self.forced += u32::from(stretch.event.is_some());
        self.unsolved |= self.forced > MOST_FORCED;
        let mass = self.circuit.load.mass;
        match stretch.event {
            None => {}
            Some(Event::Halt(_)) => {
                self.row[1] = 0.0;
                self.mode = self.at_rest();
            }
            Some(Event::BreakAway(sign)) => self.mode = Mode::Sliding(sign),
            Some(Event::Release(side)) => self.mode = Mode::Sliding(-side),
            Some(Event::Stop(side)) => {
                self.totals.impacts += 0.5 * mass * self.row[1] * self.row[1];
                self.row[0] = side * self.circuit.load.travel;
                self.row[1] = 0.0;
                self.mode = Mode::AtStop(side);
                self.totals.met_stop = true;
            }
            Some(Event::ContactOn(side)) => {
                self.contact = Some(side);
                self.totals.met_stop = true;
            }
            Some(Event::ContactOff(_)) => self.contact = None,
        }
    }

    /// The contact state of a ram that has come to rest.
    fn at_rest(&self) -> Mode {
        let net = self.net(self.time, &self.row);
        let held = self.circuit.break_away();
        if net.abs() > held {
            Mode::Sliding(net.signum())
        } else {
            Mode::Stuck
        }
    }
}

/// The largest and the smallest value of the cubic from `begin` to `end` with the slopes `m0` and `m1` there.
fn extremes(begin: f64, end: f64, m0: f64, m1: f64) -> (f64, f64) {
    let (mut highest, mut lowest) = (begin.max(end), begin.min(end));
    if m0 * m1 < 0.0 {
        // p(s) = begin + m0 s + c s^2 + d s^3
        let (c, d) = (
            3.0 * (end - begin) - 2.0 * m0 - m1,
            m0 + m1 - 2.0 * (end - begin),
        );
        let root = (c * c - 3.0 * d * m0).max(0.0).sqrt();
        let denominator = c + if c < 0.0 { -root } else { root };
        for s in [-m0 / denominator, -denominator / (3.0 * d)] {
            if s > 0.0 && s < 1.0 {
                let value = begin + s * (m0 + s * (c + s * d));
                (highest, lowest) = (highest.max(value), lowest.min(value));
            }
        }
    }
    (highest, lowest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::{BUILT_IN, parse};
    use proptest::prelude::*;

    /// Times of commands, s, and the masks of P-A, A-T, P-B, B-T.
    const COMMANDS: [(f64, [u32; 4]); 6] = [
        (0.0, [31, 0, 0, 31]),
        (0.06, [9, 0, 0, 5]),
        (0.15, [0, 0, 0, 0]),
        (0.22, [0, 20, 17, 0]),
        (0.34, [0, 31, 31, 0]),
        (0.5, [3, 0, 0, 2]),
    ];

    fn circuit(edit: impl FnOnce(&mut Circuit)) -> Arc<Circuit> {
        behind("", edit)
    }

    /// Of these lines.
    fn behind(lines: &str, edit: impl FnOnce(&mut Circuit)) -> Arc<Circuit> {
        let text = BUILT_IN[0].1.replace("oil:\n", &format!("{lines}\noil:\n"));
        let mut circuit = parse(&text).unwrap();
        circuit.valves.scatter = 0.0;
        circuit.load.travel = 0.04;
        edit(&mut circuit);
        Arc::new(circuit)
    }

    /// Position, speed, pressures and supplied work at the times.
    fn moved(circuit: &Arc<Circuit>, accuracy: f64, times: &[f64]) -> Vec<[f64; 5]> {
        pushed(circuit, accuracy, times, None)
    }

    /// The same where the force jumps at a time, s, to as much, N.
    fn pushed(
        circuit: &Arc<Circuit>,
        accuracy: f64,
        times: &[f64],
        jump: Option<(f64, f64)>,
    ) -> Vec<[f64; 5]> {
        let mut simulation = Simulation::new(Arc::clone(circuit), accuracy, 0.02, 500.0, 1);
        let names: Vec<String> = (0..4).map(|edge| circuit.edge_name(edge)).collect();
        let place = |name: &str| names.iter().position(|known| known == name).unwrap();
        let order = ["P-A", "A-T", "P-B", "B-T"].map(place);
        for (time, written) in COMMANDS {
            let mut masks = [0; MOST_EDGES];
            for (edge, mask) in order.into_iter().zip(written) {
                masks[edge] = mask;
            }
            simulation.command(time, &masks);
        }
        if let Some((time, force)) = jump {
            simulation.advance(time, 1.0);
            simulation.push(time, force);
        }
        let at = |time: &f64| {
            simulation.advance(*time, 1.0);
            let [x, v, a, b] = simulation.at(*time);
            let ledger = simulation.ledger(*time);
            assert!(
                ledger.residual().abs() <= 1e-9 * ledger.turnover(),
                "{ledger:?} {}",
                ledger.residual()
            );
            [x, v, a, b, ledger.supply]
        };
        times.iter().map(at).collect()
    }

    /// Commands the first four edges at their times, the earliest first.
    fn command_all(simulation: &mut Simulation, mut commands: Vec<(f64, [u32; 4])>) {
        commands.sort_by(|one, other| one.0.total_cmp(&other.0));
        for (time, masks) in commands {
            let mut all = [0; MOST_EDGES];
            all[..4].copy_from_slice(&masks);
            simulation.command(time, &all);
        }
    }

    fn assert_near(found: &[[f64; 5]], expected: &[[f64; 5]]) {
        let scales = [0.04, 1.0, 1e7, 1e7, 600.0];
        for (found, expected) in found.iter().zip(expected) {
            for ((found, expected), scale) in found.iter().zip(expected).zip(scales) {
                assert!(
                    (found - expected).abs() < 1e-10 * scale,
                    "{found} for {expected}"
                );
            }
        }
    }

    #[test]
    fn rams_against_rigid_and_elastic_stops_move_as_scipys() {
        // scipy 1.17.1, DOP853 with rtol = 3e-14 and events for halt, break-away and stops: a program of its own, with the equations of this
        // file's head and the numbers of dfcu.yaml. Its run at 1e-10 is as near to it as ours.
        let rigid = [
            [0.04, 0.0, 10000000.0, 300052.2268979533, 172.69389414477695],
            [
                0.013046202445772037,
                -0.41732895417762833,
                3684895.1473213346,
                6084876.170318988,
                308.109996455013,
            ],
            [
                -0.04,
                0.0,
                3295344.5161680677,
                7471668.478691589,
                557.3234811884915,
            ],
            [
                -0.03453833150667314,
                0.08867352136843364,
                5714682.161015375,
                7633688.7697118195,
                618.7157761863239,
            ],
        ];
        let times = [0.05, 0.3, 0.4, 0.6];
        assert_near(&moved(&circuit(|_| ()), 1e-13, &times), &rigid);
        let elastic = [
            [
                0.04268454053797805,
                -0.13460633818527232,
                10131679.056834973,
                238962.5119303316,
                194.1447785725875,
            ],
            [
                0.012648013608841439,
                -0.41830560176021414,
                3702601.163291494,
                6063775.8234613985,
                328.51406708630583,
            ],
            [
                -0.04043230620750861,
                -0.6514198443738468,
                3866842.3780649607,
                7018281.711854996,
                577.2172152756269,
            ],
            [
                -0.03534404759822354,
                0.05623110327349541,
                5785679.051717457,
                7711328.163618324,
                643.4955706692523,
            ],
        ];
        let with_stop = circuit(|circuit| {
            circuit.load.spring = 2000.0;
            circuit.load.elastic_stop = Some(crate::ElasticStop {
                stiffness: 5e6,
                damping: 2.0,
            });
        });
        assert_near(&moved(&with_stop, 1e-13, &times), &elastic);
    }

    #[test]
    fn rams_behind_lines_move_as_by_the_method_of_steps() {
        // scipy 1.17.1, DOP853 with rtol = 2.3e-14 and steps of 50 us at most, restarted at each valve, halt, break-away and stop and wherever a
        // wave of it arrives; the waves as Chebyshev polynomials of degree 16 over a quarter of a millisecond: a program of its own. The work
        // is what left the source, the integral of q_s.
        let without_friction = [
            [
                0.04,
                0.0,
                11700072.465251757,
                24295.2075378303,
                177.78010064344147,
            ],
            [
                0.01333633963954245,
                -0.417269968088286,
                3681322.355587462,
                6088621.560030057,
                306.7596627181587,
            ],
        ];
        let lines =
            "lines: {P: {length: 3 m, diameter: 12 mm}, T: {length: 2 m, diameter: 12 mm}}\n";
        assert_near(
            &moved(&behind(lines, |_| ()), 1e-12, &[0.05, 0.3]),
            &without_friction,
        );
        let with_friction = [
            [
                0.0429102264704515,
                -0.039816784855463576,
                12951566.173214575,
                193967.52113381194,
                205.988380949773,
            ],
            [
                0.013013667956827955,
                -0.4156796215720525,
                3674700.3240932073,
                6015962.861238911,
                326.33875786297534,
            ],
            [
                -0.03935350637474284,
                -0.6580542573318029,
                3827185.062374361,
                6917235.87038862,
                571.5933260419066,
            ],
            [
                -0.03536386987505454,
                0.05688373181738585,
                5758822.845503304,
                7684787.597625735,
                643.1280323353396,
            ],
        ];
        let lines =
            "lines: {P: {length: 3 m, diameter: 10 mm}, T: {length: 2 m, diameter: 16 mm}}\n";
        let with_stop = behind(lines, |circuit| {
            for (level, length, diameter) in [(0, 3.0, 0.01), (1, 2.0, 0.016)] {
                let line = crate::Line::new(length, diameter, 1.4e9, 870.0, 46e-6);
                circuit.levels[level].line = Some(line);
            }
            circuit.load.spring = 2000.0;
            circuit.load.elastic_stop = Some(crate::ElasticStop {
                stiffness: 5e6,
                damping: 2.0,
            });
        });
        let times = [0.05, 0.3, 0.4, 0.6];
        assert_near(&moved(&with_stop, 1e-12, &times), &with_friction);
        // The force jumps within a step, the ram on its way out of the elastic stop.
        let with_a_jump = [
            [
                0.04125500435092203,
                -0.001985868591764806,
                9847398.679658063,
                274534.14074658736,
                182.12094946065346,
            ],
            [
                0.010017614392801088,
                -0.4565181982386701,
                4369571.992723794,
                5203714.70018546,
                336.5992675830851,
            ],
        ];
        let jump = Some((0.1001, 1500.0));
        assert_near(&pushed(&with_stop, 1e-12, &[0.12, 0.3], jump), &with_a_jump);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(120))]

        /// Any circuit, any commands: the energy closes, nothing is beyond its bounds, and it comes to an end.
        #[test]
        fn energy_closes_whatever_the_circuit_and_its_commands(
            mass in 1.0..1e4, viscous in 0.0..1e4, coulomb in prop_oneof![Just(0.0), 0.0..2000.0], spring in 0.0..1e5,
            weight in -2000.0..2000.0, force in -2000.0..2000.0, travel in 0.01..0.2, stiffness in prop_oneof![Just(None), (1e5..1e7).prop_map(Some)],
            bulk in 2e8..2e9, air in 1e-4..0.05, leak in prop_oneof![Just(0.0), 0.0..1e-11], scatter in 0.0..4e-3,
            pressures in (1e6..3e7, 0.0..5e5), flow in 1e-5..1e-3, opening in 0.0..0.03,
            commands in prop::collection::vec((0.0..0.4, prop::array::uniform4(0_u32..32)), 1..12), single in prop::bool::weighted(0.2),
        ) {
            let mut circuit = parse(BUILT_IN[0].1).unwrap();
            circuit.load = crate::Load {
                mass, viscous, coulomb, spring, force: weight, travel, moment_arm: 1.0, stepping: 0.0,
                elastic_stop: stiffness.map(|stiffness| crate::ElasticStop { stiffness, damping: 1.0 }),
            };
            for chamber in &mut circuit.chambers {
                chamber.volume = 1.3 * chamber.area * travel + 1e-5;
            }
            circuit.oil = crate::Oil { bulk_modulus: bulk, air, ..circuit.oil };
            circuit.seal_leakage = leak;
            circuit.valves.scatter = scatter;
            circuit.valves.opening = opening;
            circuit.levels[0].pressure = pressures.0;
            circuit.levels[1].pressure = pressures.1;
            for edge in &mut circuit.edges {
                edge.valves = crate::coding::Coding::Pcm.share(flow / 5e5_f64.sqrt(), 5);
            }
            if single {
                circuit.chambers[1] = crate::Chamber { area: 0.0, volume: 1.0 };
                circuit.edges.retain(|edge| edge.chamber == 0);
            }
            let mut simulation = Simulation::new(Arc::new(circuit), 1e-11, 0.3 * travel, force, 7);
            command_all(&mut simulation, commands);
            for time in [0.1, 0.3, 0.5] {
                simulation.advance(time, 1.0);
                let [x, v, a, b] = simulation.at(time);
                prop_assert!(x.is_finite() && v.is_finite(), "{x} {v}");
                prop_assert!(stiffness.is_some() || x.abs() <= travel * (1.0 + 1e-12), "{x}");
                prop_assert!(a > -crate::ATMOSPHERE && b > -crate::ATMOSPHERE, "{a} {b}");
                let ledger = simulation.ledger(time);
                // Of next to no work next to nothing is missing: so much comes of a thousandth of a stroke.
                let whole = ledger.turnover() + 1e-3 * pressures.0 * 8e-4 * travel;
                prop_assert!(ledger.residual().abs() <= 1e-9 * whole, "{} of {whole} {ledger:?}", ledger.residual());
                for lost in ledger.throttling.iter().chain([&ledger.seal, &ledger.viscous, &ledger.friction]) {
                    prop_assert!(*lost >= 0.0, "{ledger:?}");
                }
                // The force turns round: friction or a stop that cannot hold the ram lets it go at once.
                simulation.push(time, -simulation.force.begin);
                prop_assert_eq!(simulation.at(time), [x, v, a, b]);
                let net = simulation.net(time, &simulation.row);
                let held = simulation.circuit.break_away();
                let holds = match simulation.mode {
                    Mode::Sliding(_) => true,
                    Mode::Stuck => net.abs() <= held,
                    Mode::AtStop(side) => side * net >= -held,
                };
                prop_assert!(holds, "{:?} {net} {held}", simulation.mode);
            }
            prop_assert!(simulation.steps() < 200_000, "{}", simulation.steps());
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// The same behind lines of any size.
        #[test]
        fn energy_closes_behind_lines(
            mass in 10.0..1e3, coulomb in prop_oneof![Just(0.0), 0.0..500.0], flow in 2e-5..5e-4, elastic in any::<bool>(),
            lines in prop::array::uniform2((0.2..20.0, 4e-3..0.03, prop_oneof![Just(0.0), 0.0..1e-4])), both in any::<bool>(),
            commands in prop::collection::vec((0.0..0.1, prop::array::uniform4(0_u32..32)), 1..5),
        ) {
            let circuit = circuit(|circuit| {
                circuit.load.mass = mass;
                circuit.load.coulomb = coulomb;
                circuit.load.elastic_stop = elastic.then_some(crate::ElasticStop { stiffness: 5e6, damping: 1.0 });
                for edge in &mut circuit.edges {
                    edge.valves = crate::coding::Coding::Pcm.share(flow / 5e5_f64.sqrt(), 5);
                }
                for (level, (length, diameter, viscosity)) in lines.into_iter().enumerate().skip(usize::from(!both)) {
                    let line = crate::Line::new(length, diameter, 1.4e9, 870.0, viscosity);
                    circuit.levels[level].line = Some(line);
                }
            });
            let mut simulation = Simulation::new(circuit, 1e-10, 0.012, 300.0, 7);
            command_all(&mut simulation, commands);
            for (cycle, time) in [(0, 0.06), (0, 0.12), (1, 0.01)] {
                if cycle == 1 {
                    simulation.next_cycle(0.15);
                }
                simulation.advance(time, 0.15);
                let ledger = simulation.ledger(time);
                let whole = ledger.turnover() + 1e-3 * 1e7 * 8e-4 * 0.04;
                prop_assert!(ledger.residual().abs() <= 1e-9 * whole, "{} of {whole} {ledger:?}", ledger.residual());
                prop_assert!(ledger.line_friction >= 0.0, "{ledger:?}");
                simulation.push(time, -simulation.force.begin);
            }
            prop_assert!(simulation.steps() < 100_000, "{}", simulation.steps());
        }
    }

    #[test]
    fn how_often_somebody_looks_changes_nothing() {
        let lines = "lines: {P: {length: 3 m, diameter: 12 mm}}\n";
        for (circuit, accuracy) in [(circuit(|_| ()), 1e-8), (behind(lines, |_| ()), 1e-10)] {
            let often: Vec<f64> = (1..=6000).map(|step| f64::from(step) * 1e-4).collect();
            let seldom = moved(&circuit, accuracy, &[0.6]);
            assert_eq!(moved(&circuit, accuracy, &often).last(), seldom.last());
        }
    }
}
