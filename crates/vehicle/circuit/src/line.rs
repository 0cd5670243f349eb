//! A hydraulic line between a level's source and its valves, by the method of characteristics.
//!
//! Pressure `p` and flow `q` towards the valves travel as two waves, `p + Z q` to the valves and `p - Z q` back, each for `T` (E. B. Wylie,
//! V. L. Streeter, *Fluid Transients in Systems*, 1993, chapter 3). All pressures here are relative to the source's constant pressure:
//!
//! ```text
//! at the valves    p = c - (Z + R/2) q,   w = c - 2 Z q          c the wave that arrives, w the one that leaves
//! at the source    c(t) = -r w(t - 2 T),  r = (Z - R/2)/(Z + R/2),   q_s(t) = -w(t - T)/(Z + R/2)
//! ```
//! Half of the laminar resistance `R` is at each end (P. Krus, K. Weddfelt, J.-O. Palmberg, *Fast pipeline models for simulation of
//! hydraulic systems*, ASME J. Dyn. Sys. Meas. Control 116, 1994). The contents of the line follow from the travelling waves:
//!
//! ```text
//! volume = 1/(2Z) (I1 - r I2),   energy = 1/(4Z) (J1 + r^2 J2) + p_source volume
//! I1, J1 the integrals of w and w^2 over [t - T, t], I2, J2 those over [t - 2T, t - T]
//! ```
//! The wave that left an end is stored for a round trip, as a polynomial for each integration step.

use std::collections::VecDeque;

use crate::circuit::{Line, root, root_slope};
use planesman_linear::below_zero_near;

/// Degree of the polynomials.
pub(crate) const DEGREE: usize = 8;
/// `cos(k pi/DEGREE)`: the points at which a step is sampled, from its end to its beginning.
pub(crate) const NODES: [f64; DEGREE + 1] = [
    1.0,
    0.9238795325112867,
    std::f64::consts::FRAC_1_SQRT_2,
    0.3826834323650898,
    0.0,
    -0.3826834323650898,
    -std::f64::consts::FRAC_1_SQRT_2,
    -0.9238795325112867,
    -1.0,
];
/// Gauss's nodes and weights: exact for the square of the polynomials.
const GAUSS: [(f64, f64); 9] = [
    (-0.9681602395076261, 0.08127438836157441),
    (-0.8360311073266358, 0.1806481606948574),
    (-0.6133714327005904, 0.2606106964029354),
    (-0.3242534234038089, 0.3123470770400029),
    (0.0, 0.3302393550012598),
    (0.3242534234038089, 0.3123470770400029),
    (0.6133714327005904, 0.2606106964029354),
    (0.8360311073266358, 0.1806481606948574),
    (0.9681602395076261, 0.08127438836157441),
];
/// Maximum jump of the slope over a step, relative to the jump of the wave itself.
const SLOPE: f64 = 20.0;
/// Instants nearer than this are equal, s.
const SAME_TIME: f64 = 1e-12;

/// The coefficients of the Chebyshev polynomials through the values at [`NODES`].
fn chebyshev(values: &[f64; DEGREE + 1]) -> [f64; DEGREE + 1] {
    let end = |place: usize| {
        if place.is_multiple_of(DEGREE) {
            0.5
        } else {
            1.0
        }
    };
    std::array::from_fn(|order| {
        let cosine = |place: usize| {
            let turn = order * place % (2 * DEGREE);
            NODES[turn.min(2 * DEGREE - turn)]
        };
        let terms = (0..=DEGREE).map(|place| end(place) * values[place] * cosine(place));
        end(order) * terms.sum::<f64>() / (0.5 * DEGREE as f64)
    })
}

/// The integral over [-1, 1] of the polynomial with these coefficients.
fn integral(coefficients: &[f64; DEGREE + 1]) -> f64 {
    let even = coefficients.iter().enumerate().step_by(2);
    even.map(|(order, it)| 2.0 * it / (1.0 - (order * order) as f64))
        .sum()
}

/// The wave that left during an interval of time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    begin: f64,
    end: f64,
    /// Middle and half length of the step of the coefficients.
    middle: f64,
    half: f64,
    coefficients: [f64; DEGREE + 1],
    /// Whether the wave or its slope jumps at the beginning.
    jump: bool,
}

impl Piece {
    /// Value and slope, by Clenshaw's recurrence.
    fn at(&self, time: f64) -> (f64, f64) {
        let x = (time - self.middle) / self.half;
        let (mut b, mut b_slope) = ([0.0; 2], [0.0; 2]);
        for coefficient in self.coefficients[1..].iter().rev() {
            let slope = 2.0 * b[0] + 2.0 * x * b_slope[0] - b_slope[1];
            b = [coefficient + 2.0 * x * b[0] - b[1], b[0]];
            b_slope = [slope, b_slope[0]];
        }
        (
            self.coefficients[0] + x * b[0] - b[1],
            (b[0] + x * b_slope[0] - b_slope[1]) / self.half,
        )
    }

    /// The integrals of the wave and of its square over the part of `[begin, end]` within the piece.
    fn integrals(&self, begin: f64, end: f64) -> [f64; 2] {
        let (begin, end) = (begin.max(self.begin), end.min(self.end));
        if begin >= end {
            return [0.0; 2];
        }
        let (middle, half) = (0.5 * (begin + end), 0.5 * (end - begin));
        GAUSS.iter().fold([0.0; 2], |[first, second], (x, weight)| {
            let value = self.at(middle + x * half).0;
            let weight = weight * half;
            [first + weight * value, second + weight * value * value]
        })
    }
}

/// The quantities at the valves over a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LineStep {
    piece: Piece,
    /// Lost to the friction at this end, J.
    friction: f64,
    peaks: (f64, f64),
}

impl LineStep {
    /// The size of the wave's last coefficients: approximately the polynomial's error, Pa.
    pub(crate) fn tail(&self) -> f64 {
        let last = &self.piece.coefficients[DEGREE - 1..];
        last.iter().fold(0.0, |most, it| it.abs().max(most))
    }
}

/// The valves' end of a line, with pressures relative to the source's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AtValves {
    pub(crate) pressure: f64,
    pub(crate) flow: f64,
    /// The wave that leaves.
    leaving: f64,
}

/// The totals of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LineSample {
    /// Volume from the source since the start, m^3.
    pub(crate) volume: f64,
    /// Gain of energy in the line since the start, J, for a source with the given pressure.
    pub(crate) stored: f64,
    /// Loss by its friction since the start, J.
    pub(crate) friction: f64,
}

/// The waves in a line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Waves {
    /// The index of the line's level.
    pub(crate) level: usize,
    /// A round trip, s.
    trip: f64,
    line: Line,
    /// Pressure jumps below this are ignored, Pa.
    small: f64,
    /// The length of a step without interruptions, s.
    reach: f64,
    /// Flow coefficients of the open valves to A and B, m^3/(s sqrt(Pa)).
    k: [f64; 2],
    /// The wave that left, at least over the last round trip.
    pieces: VecDeque<Piece>,
    /// The first and the last of the pieces that arrive before the next jump.
    arriving: (usize, usize),
    /// The integrals of the wave that left and of its square since the start.
    total: [f64; 2],
    /// Loss by the friction at the valves' end, J.
    friction: f64,
    /// The highest and the lowest pressure at the valves.
    peaks: (f64, f64),
}

impl Waves {
    /// At rest. Jumps smaller than `small`, Pa, are ignored.
    pub(crate) fn new(level: usize, line: Line, small: f64) -> Self {
        let trip = 2.0 * line.delay;
        Self {
            level,
            trip,
            line,
            small,
            reach: trip,
            k: [0.0; 2],
            pieces: VecDeque::from([Piece {
                begin: -trip,
                end: 0.0,
                middle: -line.delay,
                half: line.delay,
                coefficients: [0.0; DEGREE + 1],
                jump: false,
            }]),
            arriving: (0, 0),
            total: [0.0; 2],
            friction: 0.0,
            peaks: (0.0, 0.0),
        }
    }

    /// The highest and the lowest pressure at the valves so far, relative to the source's.
    pub(crate) fn peaks(&self) -> (f64, f64) {
        self.peaks
    }

    /// Sets the flow coefficient of the open valves to A or B.
    pub(crate) fn open(&mut self, chamber: usize, k: f64) {
        self.k[chamber] = k;
    }

    /// Whether any of its valves is open.
    pub(crate) fn is_open(&self) -> bool {
        self.k != [0.0; 2]
    }

    /// The time up to which the wave that left is known.
    fn end(&self) -> f64 {
        self.pieces.back().map_or(0.0, |last| last.end)
    }

    fn reflection(&self) -> f64 {
        let half = 0.5 * self.line.resistance;
        (self.line.impedance - half) / (self.line.impedance + half)
    }

    /// Shifts the clock back.
    pub(crate) fn set_back(&mut self, by: f64) {
        for piece in &mut self.pieces {
            piece.begin -= by;
            piece.end -= by;
            piece.middle -= by;
        }
    }

    /// Finds the waves that arrive from a round trip before `now`, and returns the end of the next step: where the next jump arrives, or a
    /// round trip from now.
    pub(crate) fn look_back(&mut self, now: f64) -> f64 {
        let since = now - self.trip + SAME_TIME;
        let after = self.pieces.partition_point(|piece| piece.end <= since);
        let first = after.min(self.pieces.len() - 1);
        let jumps = self.pieces.iter().skip(first + 1);
        let smooth = jumps.take_while(|piece| !piece.jump).count();
        self.arriving = (first, first + smooth);
        if self.arriving.1 + 1 < self.pieces.len() {
            self.pieces[self.arriving.1].end + self.trip
        } else {
            now + self.trip
        }
    }

    /// Pressure and flow at the valves for the pressures `chambers`, relative to the source's: the flow through the valves equals the flow
    /// that the arriving wave gives at their pressure.
    #[inline]
    pub(crate) fn at_valves(&self, time: f64, chambers: [f64; 2], transition: f64) -> AtValves {
        let since = time - self.trip;
        let (mut place, last) = self.arriving;
        while place < last && self.pieces[place].end <= since {
            place += 1;
        }
        let arriving = -self.reflection() * self.pieces[place].at(since).0;
        let resistance = self.line.impedance + 0.5 * self.line.resistance;
        let k = self.k;
        // From the pressure of a chamber, so that a small drop keeps its digits.
        let from = if k[0] > 0.0 { chambers[0] } else { chambers[1] };
        let (mut low, mut high) = ((arriving - from).min(0.0), (arriving - from).max(0.0));
        if k[1] > 0.0 {
            low = low.min(chambers[1] - from);
            high = high.max(chambers[1] - from);
        }
        let flow = |above: f64| {
            let mut sum = (0.0, 0.0);
            for (chamber, k) in chambers.iter().zip(k) {
                if k > 0.0 {
                    let drop = above + (from - chamber);
                    sum.0 += k * root(drop, transition);
                    sum.1 += k * root_slope(drop, transition);
                }
            }
            sum
        };
        // Near to where it would be behind all valves at once by the square root.
        let both = k[0] + k[1];
        let mean = (k[0] * chambers[0] + k[1] * chambers[1]) / both;
        let (drop, half) = (arriving - mean, 0.5 * resistance * both);
        let speed = (half * half + drop.abs()).sqrt() - half;
        let near = (mean - from) + drop.signum() * speed * speed;
        let above = below_zero_near(near.clamp(low, high), low, high, |above| {
            let (flow, slope) = flow(above);
            (
                (arriving - from) - above - resistance * flow,
                -1.0 - resistance * slope,
            )
        });
        let flow = flow(above).0;
        AtValves {
            pressure: from + above,
            flow,
            leaving: arriving - 2.0 * self.line.impedance * flow,
        }
    }

    /// Evaluates the step from `begin` to `end` with these values at its [`NODES`].
    pub(crate) fn step(&self, begin: f64, end: f64, valves: &[AtValves; DEGREE + 1]) -> LineStep {
        let half = 0.5 * (end - begin);
        let losses = chebyshev(&valves.map(|it| 0.5 * self.line.resistance * it.flow * it.flow));
        let pressures = valves.map(|it| it.pressure);
        LineStep {
            piece: Piece {
                begin,
                end,
                middle: 0.5 * (begin + end),
                half,
                coefficients: chebyshev(&valves.map(|it| it.leaving)),
                jump: false,
            },
            friction: half * integral(&losses),
            peaks: (
                pressures.into_iter().fold(f64::NEG_INFINITY, f64::max),
                pressures.into_iter().fold(f64::INFINITY, f64::min),
            ),
        }
    }

    /// Completes the step; without interruptions the next would be `reach`, s, long.
    pub(crate) fn push(&mut self, step: &LineStep, reach: f64) {
        self.reach = reach.min(self.trip);
        self.friction += step.friction;
        self.peaks.0 = self.peaks.0.max(step.peaks.0);
        self.peaks.1 = self.peaks.1.min(step.peaks.1);
        self.append(step.piece);
    }

    fn append(&mut self, mut piece: Piece) {
        if piece.end <= piece.begin {
            return;
        }
        if let Some(last) = self.pieces.back() {
            let ((before, slope_before), (after, slope)) =
                (last.at(piece.begin), piece.at(piece.begin));
            piece.jump = (after - before).abs() > self.small
                || (slope - slope_before).abs() * self.reach > SLOPE * self.small;
        }
        let integrals = piece.integrals(piece.begin, piece.end);
        self.total = [0, 1].map(|power| self.total[power] + integrals[power]);
        self.pieces.push_back(piece);
        let since = piece.end - self.trip - SAME_TIME;
        while self.pieces.front().is_some_and(|first| first.end < since) {
            self.pieces.pop_front();
        }
    }

    /// While all valves are closed, an arriving wave leaves unchanged: the last round trip repeats until `to`.
    pub(crate) fn stay_closed(&mut self, to: f64) {
        let trips = ((to - self.end()) / self.trip).floor();
        if trips > 4.0 {
            // Two trips give the peaks; then all of an even number of trips at once.
            self.repeat(self.end() + 2.0 * self.trip);
            let trips = 2.0 * (0.5 * trips - 1.0).floor();
            let [first, second] = self.integrals(self.end() - self.trip, self.end());
            let r = self.reflection();
            let left = libm::pow(r.abs(), trips);
            self.total[0] -= first * r * (1.0 - left) / (1.0 + r);
            if r < 1.0 {
                self.total[1] += second * r * r * (1.0 - left * left) / (1.0 - r * r);
            }
            self.set_back(-trips * self.trip);
            for piece in &mut self.pieces {
                piece.coefficients = piece.coefficients.map(|it| left * it);
            }
        }
        self.repeat(to);
    }

    fn repeat(&mut self, to: f64) {
        while self.end() < to {
            let (end, r) = (self.end(), self.reflection());
            let since = end - self.trip + SAME_TIME;
            let again = self.pieces.iter().find(|piece| piece.end > since).copied();
            let Some(mut piece) = again else { return };
            piece.end = if piece.end + self.trip < to {
                piece.end + self.trip
            } else {
                to
            };
            piece.begin = end;
            piece.middle += self.trip;
            piece.coefficients = piece.coefficients.map(|it| -r * it);
            let middle = 0.5 * (piece.begin + piece.end);
            let half = piece.end - middle;
            for x in NODES {
                let pressure = piece.at(middle + x * half).0;
                self.peaks = (self.peaks.0.max(pressure), self.peaks.1.min(pressure));
            }
            self.append(piece);
        }
    }

    /// The integrals of the wave that left and of its square.
    fn integrals(&self, begin: f64, end: f64) -> [f64; 2] {
        self.pieces.iter().fold([0.0; 2], |sum, piece| {
            let more = piece.integrals(begin, end);
            [sum[0] + more[0], sum[1] + more[1]]
        })
    }

    /// The totals at the end of the last step, for a source at the pressure `source`.
    pub(crate) fn taken(&self, source: f64) -> LineSample {
        let Line {
            delay,
            impedance,
            resistance,
        } = self.line;
        let (end, r) = (self.end(), self.reflection());
        let late = self.integrals(end - delay, end);
        let early = self.integrals(end - self.trip, end - delay);
        let volume = (late[0] - r * early[0]) / (2.0 * impedance);
        let at_source = impedance + 0.5 * resistance;
        LineSample {
            volume: (late[0] - self.total[0]) / at_source,
            stored: (late[1] + r * r * early[1]) / (4.0 * impedance) + source * volume,
            friction: self.friction
                + 0.5 * resistance * (self.total[1] - late[1]) / (at_source * at_source),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Oil's density, kg/m^3, bulk modulus, Pa, and the line's diameter, m.
    const OIL: (f64, f64) = (870.0, 1.4e9);
    const DIAMETER: f64 = 0.012;

    /// A line in which oil has flowed into a chamber at a pressure 2 MPa below for 400 round trips, and the flow.
    fn flowing(viscosity: f64) -> (Waves, f64) {
        let line = Line::new(3.0, DIAMETER, OIL.1, OIL.0, viscosity);
        let mut waves = Waves::new(0, line, 1e-6);
        waves.open(0, 2e-7);
        let mut flow = 0.0;
        for trip in 0..400 {
            let begin = f64::from(trip) * waves.trip;
            waves.look_back(begin);
            let at = |node: f64| {
                let time = begin + 0.5 * (1.0 + node) * waves.trip;
                waves.at_valves(time, [-2e6, 0.0], 5e4)
            };
            let step = waves.step(begin, begin + waves.trip, &NODES.map(at));
            flow = at(1.0).flow;
            waves.push(&step, waves.trip);
        }
        waves.open(0, 0.0);
        (waves, flow)
    }

    fn leaving(waves: &Waves, time: f64) -> f64 {
        let piece = waves.pieces.iter().find(|piece| piece.end > time).unwrap();
        piece.at(time).0
    }

    #[test]
    fn a_valve_that_shuts_raises_the_pressure_by_density_speed_of_sound_and_speed() {
        // N. Joukowsky 1898: dp = rho a dv, for a round trip; then as much below, and so on with the period 4 l/a.
        let (mut waves, flow) = flowing(0.0);
        assert!((flow / (2e-7 * root(2e6, 5e4)) - 1.0).abs() < 1e-12);
        let sound = (OIL.1 / OIL.0).sqrt();
        let rise = OIL.0 * sound * flow / (0.25 * std::f64::consts::PI * DIAMETER * DIAMETER);
        let (shut, trip) = (waves.end(), 2.0 * 3.0 / sound);
        for (after, sign) in [(0.5, 1.0), (1.5, -1.0), (2.5, 1.0), (9.5, -1.0)] {
            let time = shut + after * trip;
            waves.stay_closed(time + 0.25 * trip);
            let found = leaving(&waves, time);
            assert!(
                (found / (sign * rise) - 1.0).abs() < 1e-11,
                "{after}: {found} for {rise}"
            );
        }
        let (highest, lowest) = waves.peaks();
        assert!((highest / rise - 1.0).abs() < 1e-11 && (lowest / rise + 1.0).abs() < 1e-11);
        // All of the oil's kinetic energy stays, in turn as pressure: rho l A v^2/2.
        let kinetic =
            0.5 * OIL.0 * 3.0 * flow * flow / (0.25 * std::f64::consts::PI * DIAMETER * DIAMETER);
        assert!((waves.taken(0.0).stored / kinetic - 1.0).abs() < 1e-11);
    }

    #[test]
    fn what_friction_takes_from_a_closed_line_is_what_it_held_however_long_it_is_looked_at() {
        let (mut at_once, flow) = flowing(46e-6);
        let mut longer = at_once.clone();
        let held = at_once.taken(1e7);
        let begin = at_once.end();
        let mut often = at_once.clone();
        at_once.stay_closed(begin + 100.3 * at_once.trip);
        for part in 1..=143 {
            often
                .stay_closed((begin + 0.7013986 * f64::from(part) * often.trip).min(at_once.end()));
        }
        often.stay_closed(at_once.end());
        let (one, other) = (at_once.taken(1e7), often.taken(1e7));
        for (one, other) in [
            (one.volume, other.volume),
            (one.stored, other.stored),
            (one.friction, other.friction),
        ] {
            assert!((one / other - 1.0).abs() < 1e-9, "{one} {other}");
        }
        let supplied = 1e7 * (one.volume - held.volume);
        let (lost, gained) = (one.friction - held.friction, one.stored - held.stored);
        assert!(
            (supplied - lost - gained).abs() < 1e-9 * held.stored.abs(),
            "{supplied} {lost} {gained}"
        );
        // In the end nothing moves.
        longer.stay_closed(begin + 1e4 * longer.trip);
        let rest = longer.taken(0.0);
        let kept = held.stored - 1e7 * (rest.volume - held.volume);
        assert!(rest.stored.abs() < 1e-9 * kept.abs() && flow > 0.0);
    }
}
