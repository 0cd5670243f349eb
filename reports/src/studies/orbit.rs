//! Periodic orbits of a loop with a digital hydraulic actuator, by shooting.
//!
//! Between two decisions of the pulse logic there is no feedback: the body moves while the actuator executes its commands. So for one cycle of m
//! decisions, at t_1 to t_m, the final state x is a function F only of the initial state and of these instants; and each decision happens when the
//! error e reaches its threshold:
//!
//! ```text
//! x = F(x; t_2 ... t_m, T)        a period T later everything is as it was (t_1 is held: the phase)
//! e(t_i; x, t) = +-threshold_i    i = 1 ... m
//! ```
//! Newton's method solves both equations together; derivatives are differences of exact motions with fixed commands. The multipliers are the
//! eigenvalues of the derivative of x(T) with respect to x(0), with the instants following the thresholds,
//!
//! ```text
//! Phi = F_x - F_t E_t^-1 E_x
//! ```
//! (di Bernardo et al., *Piecewise-smooth Dynamical Systems*, 2008, ch. 2.5: saltation; Astrom, *Oscillations in systems with relay feedback*,
//! 1995.) One multiplier is 1, a shift along the orbit, and is left out. If a multiplier's magnitude is below 1, a deviation decays from cycle to
//! cycle; above 1 the deviation grows; at 1 it stays, and the orbit belongs to a continuum of orbits.
//!
//! **Sampling.** The loop's own decisions wait for its next sample; here the instants are real numbers with the mean delay of the samples
//! ([`Lags`]). So each decision of the sampled loop is up to half a sample early or late, and its motion scatters about this orbit. The motion seldom
//! repeats exactly: between samples the body moves freely, and its own multipliers (1 for the depth, above 1 for an unstable missile) prevent
//! deviations from decaying.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use planesman_hydraulics::frequency_response::Harmonic;
use planesman_hydraulics::{ActuatorSet, Command, Hydraulics, Options, Volume};
use planesman_linear::poles::eigenvalues;
use planesman_linear::{Complex, ComplexFunctions as _};

/// Number of integration steps of the body per valve cycle in which the ram moves.
const STEPS: u32 = 4;
/// Valve cycles from the beginning of an orbit to its first decision: more than the lags.
const AHEAD: i64 = 6;
/// Scale of the coordinates: a thousandth of a radian, or of a metre.
pub const SCALE: f64 = 1e-3;
/// Displacement of a coordinate for a numerical derivative, in that scale.
const DISPLACED: f64 = 1e-3;
/// Maximum number of Newton steps.
const MOST_STEPS: usize = 12;
/// Number of steps after which the step size must be below a limit, in the coordinates' scale.
const NEARING: (usize, f64) = (6, 1.0);
/// Largest remaining step of a closed orbit, in the coordinates' scale.
const CLOSED: f64 = 1e-5;
/// Distance below which places count as equal, in the coordinates' scale.
const EXACTLY: f64 = 1e-3;
/// Maximum number of decisions per cycle.
const MOST_DECISIONS: usize = 16;
/// Maximum number of valve cycles simulated for one Newton step.
const MOST_FLOWN: f64 = 45_000.0;
/// Relative difference below which frequencies of a cycle and of the motion count as equal, since decisions happen at samples.
const ALIKE: f64 = 0.05;
/// Maximum number of cycles tried.
const MOST_TRIED: usize = 6;

/// The part of the loop outside actuator and logic: the moved body and its measurement.
pub trait Body: Copy {
    /// Moves the body by `h` seconds, with the actuator's angles, rad, at the beginning, middle and end.
    fn advance(&mut self, angles: [f64; 3], h: f64);
    /// Angle commanded to the actuator, rad.
    fn asked(&self) -> f64;
    /// Oscillating output, SI: the depth error or the yaw angle.
    fn output(&self) -> f64;
    /// State vector, each element in [`SCALE`].
    fn coordinates(&self) -> Vec<f64>;
    /// Changes the state vector by this amount.
    fn displace(&mut self, by: &[f64]);
}

/// Mean delay of a decision, in valve cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lags {
    /// Delay after the commanded angle, which is held between two samples of the controller.
    pub asked: f64,
    /// Delay after the ram position, which is read at the beginning of each valve cycle.
    pub measured: f64,
}

impl Lags {
    /// For a controller with a sampling time of `tick` s, synchronous with the valves or not.
    #[must_use]
    pub fn of(tick: f64, cycle: f64) -> Self {
        let cycles = tick / cycle;
        let in_step = (cycles - cycles.round()).abs() < 1e-9;
        Self {
            asked: 0.5 * cycles + if in_step { 0.0 } else { 0.5 },
            measured: 0.5,
        }
    }
}

/// An observed decision of the logic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Time, s.
    pub time: f64,
    /// Command to the valves.
    pub command: Command,
    /// Open loop: commanded angle minus eps, rad, as counted by the logic.
    pub booked: f64,
}

/// State of body and actuator at the beginning of a valve cycle.
#[derive(Clone, Copy, Debug)]
pub struct State<B> {
    /// The body.
    pub body: B,
    /// Valves, metering and ram.
    pub hydraulics: Hydraulics,
    /// Last sign pulse.
    pub sign: i8,
    /// Time, s.
    pub time: f64,
}

/// A loop without its body.
#[derive(Clone, Debug)]
pub struct Actuation {
    /// The actuator.
    pub set: ActuatorSet,
    /// Options of the logic.
    pub logic: Options,
    /// Whether the position loop is closed.
    pub position_loop: bool,
    /// Mean delay of a decision.
    pub lags: Lags,
}

/// A sample of an orbit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time, s.
    pub time: f64,
    /// Output, as [`Body::output`].
    pub output: f64,
    /// Angle of the actuator, rad.
    pub angle: f64,
    /// Angle commanded to the actuator, rad.
    pub asked: f64,
}

/// A periodic orbit.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbit {
    /// Period, s.
    pub period: f64,
    /// Decisions: time from the first, s, and command.
    pub decisions: Vec<(f64, Command)>,
    /// Multipliers, largest first, without the multiplier of a shift along the orbit.
    pub multipliers: Vec<Complex<f64>>,
    /// Samples of one period, four per valve cycle.
    pub samples: Vec<Sample>,
    /// Minimum, maximum and mean of the output.
    pub output: (f64, f64, f64),
    /// Minimum and maximum of the angle, rad.
    pub angle: (f64, f64),
}

/// Growth rate of small deviations from a motion: its largest Lyapunov exponent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Mean rate, 1/s; positive for a chaotic motion, negative if deviations decay.
    pub rate: f64,
    /// Standard error of that mean over the windows, 1/s.
    pub error: f64,
}

impl Growth {
    /// From the growth in windows, 1/s; `None` for fewer than two.
    #[must_use]
    pub fn of(windows: &[f64]) -> Option<Self> {
        let count = windows.len() as f64;
        let rate = windows.iter().sum::<f64>() / count;
        let squares = windows.iter().map(|x| (x - rate).powi(2)).sum::<f64>();
        (count > 1.0).then(|| Self {
            rate,
            error: (squares / (count - 1.0) / count).sqrt(),
        })
    }
}

impl Orbit {
    /// Frequency, Hz.
    #[must_use]
    pub fn frequency(&self) -> f64 {
        1.0 / self.period
    }

    /// Peak-to-peak angle, rad.
    #[must_use]
    pub fn stroke(&self) -> f64 {
        self.angle.1 - self.angle.0
    }

    /// Cycles per second, the same as in [`turns`].
    #[must_use]
    pub fn turns(&self) -> f64 {
        turned(self.decisions.iter().copied()) as f64 / self.period
    }

    /// Peak-to-peak output.
    #[must_use]
    pub fn swing(&self) -> f64 {
        self.output.1 - self.output.0
    }

    /// Largest magnitude of the multipliers.
    #[must_use]
    pub fn growth(&self) -> f64 {
        self.multipliers.first().map_or(0.0, |m| m.modulus())
    }

    /// Share of the first harmonic in the variance of the commanded angle; near 1 if harmonic balance, which assumes a sinusoid, may be valid. 0 for a
    /// constant angle.
    #[must_use]
    pub fn first_harmonic(&self) -> f64 {
        let count = self.samples.len() as f64;
        let mean = self.samples.iter().map(|s| s.asked).sum::<f64>() / count;
        let variance = self.samples.iter().map(|s| (s.asked - mean).powi(2));
        let variance = variance.sum::<f64>() / count;
        let mut harmonic = Harmonic::new(TAU * self.turns());
        for sample in &self.samples {
            harmonic.add(sample.time, sample.asked - mean);
        }
        if variance > 0.0 {
            0.5 * harmonic.phasor().modulus().powi(2) / variance
        } else {
            0.0
        }
    }

    /// Whether deviations decay or stay.
    #[must_use]
    pub fn stable(&self) -> bool {
        self.growth() < 1.0 + 1e-3
    }
}

/// A motion with fixed commands.
struct Flight<B> {
    /// Commanded angle at the beginning of each valve cycle, rad.
    asked: Vec<f64>,
    measured: Vec<f64>,
    /// State after the period, and one valve cycle later.
    end: Vec<f64>,
    later: Vec<f64>,
    state: State<B>,
    samples: Vec<Sample>,
}

/// A cycle of decisions, and the state a few valve cycles before the first: the start of [`Actuation::orbit`].
#[derive(Clone, Debug)]
struct Cycle<B> {
    start: State<B>,
    /// Instants, in valve cycles from the start.
    times: Vec<i64>,
    commands: Vec<Command>,
    booked: Vec<f64>,
    /// Period, in valve cycles.
    period: i64,
}

/// Result of one Newton step.
struct Step {
    /// Change of the coordinates.
    by: Vec<f64>,
    /// Change of the instants (the first is fixed) and of the period, in valve cycles.
    later: Vec<f64>,
    period: f64,
    multipliers: Vec<Complex<f64>>,
}

/// The orbit that a loop follows, according to `follows`, or else the one nearest in frequency. Arguments are the loop's decisions and the state
/// shortly before each. `None` if no cycle of up to 16 decisions closes.
#[must_use]
pub fn find<B: Body>(
    actuation: &Actuation,
    decisions: &[Decision],
    before: &[State<B>],
    follows: impl Fn(&Orbit) -> bool,
) -> Option<Orbit> {
    let turns = turns(decisions)?;
    let apart = |orbit: &Orbit| (orbit.turns() / turns - 1.0).abs();
    let mut nearest: Option<Orbit> = None;
    for (first, count) in candidates(actuation, decisions, turns) {
        let cycle = actuation.cycle(&decisions[first..=first + count], &before[first]);
        let Some(orbit) = actuation.orbit(cycle) else {
            continue;
        };
        if follows(&orbit) {
            return Some(orbit);
        }
        if nearest.as_ref().is_none_or(|it| apart(&orbit) < apart(it)) {
            nearest = Some(orbit);
        }
    }
    nearest
}

/// Number of changes of direction to "+" per second, the frequency of most cycles: changes of the volumes' sign, or of the sign alone if no volumes
/// move. `None` for fewer than two.
#[must_use]
pub fn turns(decisions: &[Decision]) -> Option<f64> {
    let signs = turning(decisions.iter().map(|d| (d.time, d.command)));
    let times: Vec<f64> = signs
        .windows(2)
        .filter(|pair| pair[1].1 > pair[0].1)
        .map(|pair| pair[1].0)
        .collect();
    let [first, .., last] = times[..] else {
        return None;
    };
    Some((times.len() - 1) as f64 / (last - first))
}

/// Number of changes to "+" in a cycle of decisions.
fn turned(decisions: impl Iterator<Item = (f64, Command)> + Clone) -> usize {
    let signs = turning(decisions);
    let next = signs.iter().cycle().skip(1);
    signs.iter().zip(next).filter(|(a, b)| b.1 > a.1).count()
}

/// Time and sign of the volumes, or of all decisions if no volume moves.
fn turning(decisions: impl Iterator<Item = (f64, Command)> + Clone) -> Vec<(f64, i8)> {
    let moves = |command: &Command| command.volume != Volume::None;
    let any = decisions.clone().any(|(_, command)| moves(&command));
    decisions
        .filter(|(_, command)| !any || moves(command))
        .map(|(time, command)| (time, command.sign))
        .collect()
}

/// Period, s, with which the sampled loop repeats exactly: its last decisions occur twice at the same intervals, and the body is at the same place.
/// `None` if it does not repeat within the given decisions.
#[must_use]
pub fn repeats<B: Body>(decisions: &[Decision], before: &[State<B>]) -> Option<f64> {
    let n = decisions.len();
    let pause = |i: usize| decisions[i].time - decisions[i - 1].time;
    (2..n / 2).find_map(|count| {
        // Over a quarter of them at least.
        let same = (n - count.max(n / 4)..n).all(|i| {
            let j = i - count;
            decisions[i].command == decisions[j].command
                && j > 0
                && (pause(i) - pause(j)).abs() < 1e-6
        });
        let place = |i: usize| before[i].body.coordinates();
        let back = || {
            let (now, then) = (place(n - 1), place(n - 1 - count));
            now.iter().zip(&then).all(|(a, b)| (a - b).abs() < EXACTLY)
        };
        (same && back()).then(|| decisions[n - 1].time - decisions[n - 1 - count].time)
    })
}

/// Cycles of decisions that nearly repeat, with the frequency of the motion, best first: index of the first decision and number of decisions.
fn candidates(actuation: &Actuation, decisions: &[Decision], turns: f64) -> Vec<(usize, usize)> {
    let room = (AHEAD + actuation.tick()) as f64 * actuation.set.cycle();
    let mut found: Vec<(f64, usize, usize)> = Vec::new();
    for count in 1..=MOST_DECISIONS.min(decisions.len() / 2) {
        for first in 1..decisions.len().saturating_sub(2 * count) {
            // The longest pause lies before the first: there the state is cut.
            let pause = |i: usize| decisions[i].time - decisions[i - 1].time;
            if (first + 1..first + count).any(|i| pause(i) > pause(first)) || pause(first) < room {
                continue;
            }
            let same = (first..first + count)
                .all(|i| decisions[i].command == decisions[i + count].command);
            if !same {
                continue;
            }
            let period = decisions[first + count].time - decisions[first].time;
            let apart = (first..first + count)
                .map(|i| (pause(i) - pause(i + count)).abs())
                .fold(0.0, f64::max);
            // A flight for each coordinate and each decision.
            let flown = period / actuation.set.cycle() * (count + 6) as f64;
            if flown < MOST_FLOWN {
                let these = &decisions[first..first + count];
                let often = turned(these.iter().map(|d| (d.time, d.command))) as f64;
                let beside = (often / (period * turns) - 1.0).abs().max(ALIKE);
                found.push((apart / period + beside + 0.01 * count as f64, first, count));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut tried: Vec<(usize, usize)> = Vec::new();
    for (_, first, count) in found {
        // A few of each length.
        if tried.iter().filter(|(_, other)| *other == count).count() < 2 {
            tried.push((first, count));
        }
        if tried.len() == MOST_TRIED {
            break;
        }
    }
    tried
}

impl Actuation {
    /// Threshold of |e| for a command.
    fn threshold(&self, command: Command) -> f64 {
        match command.volume {
            Volume::None => 0.0,
            Volume::Large => self.set.threshold,
            Volume::Small => self.set.small.map_or(0.0, |small| small.threshold),
        }
    }

    /// Smallest error that moves a volume.
    fn least(&self) -> f64 {
        let small = self.set.small.filter(|_| self.logic.two_speed);
        small.map_or(self.set.threshold, |small| small.threshold)
    }

    /// The cycle from a decision up to the decision before the last given one, which begins the next cycle.
    fn cycle<B: Body>(&self, decisions: &[Decision], before: &State<B>) -> Cycle<B> {
        let cycle = self.set.cycle();
        let first = decisions[0].time;
        let whole = |time: f64| ((time - first) / cycle).round() as i64;
        let (last, those) = (
            decisions[decisions.len() - 1],
            &decisions[..decisions.len() - 1],
        );
        Cycle {
            start: *before,
            times: those.iter().map(|d| AHEAD + whole(d.time)).collect(),
            commands: those.iter().map(|d| d.command).collect(),
            booked: those.iter().map(|d| d.booked).collect(),
            period: whole(last.time),
        }
    }

    /// The orbit nearest to a cycle, by Newton's method; `None` if it does not converge, or if the logic would decide differently.
    fn orbit<B: Body>(&self, mut cycle: Cycle<B>) -> Option<Orbit> {
        for taken in 0..MOST_STEPS {
            let step = self.step(&cycle)?;
            let size = step.by.iter().fold(0.0_f64, |most, by| most.max(by.abs()));
            let (after, nearing) = NEARING;
            let astray = taken >= after && size > nearing;
            // Beyond a radian there is no small cycle.
            if !size.is_finite() || size > 1.0 / SCALE || astray {
                return None;
            }
            cycle.start = self.displaced(&cycle.start, &step.by);
            let mut moved = false;
            let mut whole = |later: f64| {
                let whole = if later.abs() > 0.6 {
                    later.round()
                } else {
                    0.0
                };
                moved |= whole != 0.0;
                whole as i64
            };
            for (time, later) in cycle.times.iter_mut().zip(&step.later) {
                *time += whole(*later);
            }
            cycle.period += whole(step.period);
            let in_order = cycle.times.windows(2).all(|pair| pair[0] < pair[1])
                && cycle.times[cycle.times.len() - 1] < cycle.period + AHEAD;
            if !in_order {
                return None;
            }
            if size < CLOSED && !moved {
                return self.described(&cycle, &step);
            }
        }
        None
    }

    /// Whether there is no leakage: then every motion keeps the ram's initial oil plus whole volumes.
    fn tight(&self) -> bool {
        self.set.rate_gain == 0.0 && self.set.error_rate == 0.0
    }

    fn displaced<B: Body>(&self, state: &State<B>, by: &[f64]) -> State<B> {
        let mut state = *state;
        let rams = if self.tight() { 1 } else { 2 };
        let (body, ram) = by.split_at(by.len() - rams);
        state.body.displace(body);
        let arm = self.set.load.moment_arm * SCALE;
        let squeezed = ram.get(1).copied().unwrap_or(-ram[0]);
        state
            .hydraulics
            .displace(ram[0] * arm, squeezed * arm * self.set.area);
        state
    }

    fn coordinates<B: Body>(&self, state: &State<B>) -> Vec<f64> {
        let mut all = state.body.coordinates();
        let ram = state.hydraulics.reading(self.set.cycle()).ram;
        let arm = self.set.load.moment_arm * SCALE;
        all.push(ram.position / arm);
        if !self.tight() {
            all.push(ram.squeezed / (arm * self.set.area));
        }
        all
    }

    /// The motion over a period and one valve cycle, with fixed commands.
    fn fly<B: Body>(&self, cycle: &Cycle<B>, times: &[i64], sampled: bool) -> Flight<B> {
        let h = self.set.cycle() / f64::from(STEPS);
        let mut state = cycle.start;
        let count = cycle.period as usize + 1;
        let mut flight = Flight {
            asked: Vec::with_capacity(count + 1),
            measured: Vec::with_capacity(count + 1),
            end: Vec::new(),
            later: Vec::new(),
            state,
            samples: Vec::new(),
        };
        state.hydraulics.finish_cycle();
        let arm = self.set.load.moment_arm;
        let mut angle = state.hydraulics.position(self.set.cycle()) / arm;
        let mut next = 0;
        for c in 0..count as i64 {
            if c == cycle.period {
                flight.end = self.coordinates(&state);
                flight.state = state;
            }
            flight.asked.push(state.body.asked());
            flight.measured.push(angle);
            let mut command = Command {
                volume: Volume::None,
                sign: state.sign,
            };
            if next < times.len() && times[next] == c {
                command = cycle.commands[next];
                next += 1;
            }
            state.sign = command.sign;
            state.hydraulics.begin_cycle(command);
            let halves: [f64; 2 * STEPS as usize] = std::array::from_fn(|i| {
                let time = (0.5 * (i + 1) as f64 * h).min(self.set.cycle());
                state.hydraulics.advance(time);
                state.hydraulics.position(time) / arm
            });
            if !sampled && halves.iter().all(|it| *it == angle) {
                // The ram is stuck: the body's equations alone need no short steps.
                state.body.advance([angle; 3], self.set.cycle());
            } else {
                for (i, pair) in halves.chunks_exact(2).enumerate() {
                    if sampled && c < cycle.period {
                        flight.samples.push(Sample {
                            time: (i as f64 + c as f64 * f64::from(STEPS)) * h,
                            output: state.body.output(),
                            angle,
                            asked: state.body.asked(),
                        });
                    }
                    state.body.advance([angle, pair[0], pair[1]], h);
                    angle = pair[1];
                }
            }
            state.hydraulics.finish_cycle();
        }
        flight.later = self.coordinates(&state);
        flight.asked.push(state.body.asked());
        flight.measured.push(angle);
        flight
    }

    /// Error e at a real number of valve cycles from the start.
    fn error<B>(&self, flight: &Flight<B>, at: f64, booked: f64) -> f64 {
        let value = |values: &[f64], at: f64| {
            let whole = at.floor().max(0.0);
            let i = (whole as usize).min(values.len() - 2);
            values[i] + (values[i + 1] - values[i]) * (at - i as f64)
        };
        let asked = value(&flight.asked, at - self.lags.asked);
        if self.position_loop {
            asked - value(&flight.measured, at - self.lags.measured)
        } else {
            asked - booked
        }
    }

    /// Growth rate of a small deviation along a loop's decisions, 1/s, for each window of `window` s; given the state shortly before each decision.
    ///
    /// From one decision to the next the deviation v becomes w, computed from two exact motions with fixed commands. Then the decision moves with its
    /// threshold, and the deviation is evaluated at the decision:
    ///
    /// ```text
    /// w' = w - x_t (e_x w)/e_t        x_t, e_t: speed of state and error, e_x w: change of the error
    /// ```
    /// (saltation, as in [`Orbit::multipliers`]: along an orbit the growth equals that of the largest multiplier). The mean is the largest Lyapunov
    /// exponent of the loop with real-valued instants (Benettin et al., *Meccanica* 15, 1980). `None` if most decisions directly follow another one,
    /// at the next sample.
    #[must_use]
    pub fn growth<B: Body>(
        &self,
        decisions: &[Decision],
        before: &[State<B>],
        window: f64,
    ) -> Vec<f64> {
        let cycles = |from: f64, to: f64| ((to - from) / self.set.cycle()).round() as i64;
        let held = |start: State<B>, first: usize, end: usize, until: f64| {
            let these = &decisions[first..end];
            Cycle {
                times: these.iter().map(|d| cycles(start.time, d.time)).collect(),
                commands: these.iter().map(|d| d.command).collect(),
                booked: these.iter().map(|d| d.booked).collect(),
                period: cycles(start.time, until),
                start,
            }
        };
        let Some(begin) = decisions.first().map(|first| first.time) else {
            return Vec::new();
        };
        // Decisions right after one another follow no threshold.
        let late = |pair: &&[Decision]| cycles(pair[0].time, pair[1].time) > self.tick();
        if 2 * decisions.windows(2).filter(late).count() < decisions.len() {
            return Vec::new();
        }
        let (mut windows, mut grown, mut from) = (Vec::new(), 0.0, begin);
        let mut deviation: Option<Vec<f64>> = None;
        for (i, pair) in decisions.windows(2).enumerate() {
            let (now, next) = (pair[0].time, pair[1].time);
            let passed = decisions[..i].partition_point(|d| d.time < before[i].time);
            let ahead = held(before[i], passed, i, now);
            let mut state = self.fly(&ahead, &ahead.times, false).state;
            state.time = now;
            let motion = held(state, i, i + 1, next);
            let v = deviation
                .take()
                .unwrap_or_else(|| vec![1.0; self.coordinates(&state).len()]);
            let by: Vec<f64> = v.iter().map(|x| x * DISPLACED).collect();
            let beside = Cycle {
                start: self.displaced(&state, &by),
                ..motion.clone()
            };
            let flown = self.fly(&motion, &motion.times, false);
            let other = self.fly(&beside, &motion.times, false);
            let at = motion.period as f64;
            let later = if motion.period <= self.tick() {
                0.0
            } else {
                let speed = self.error(&flown, at + 0.5, 0.0) - self.error(&flown, at - 0.5, 0.0);
                let change = self.error(&other, at, 0.0) - self.error(&flown, at, 0.0);
                if speed == 0.0 { 0.0 } else { -change / speed }
            };
            let w: Vec<f64> = (0..by.len())
                .map(|k| other.end[k] - flown.end[k] + (flown.later[k] - flown.end[k]) * later)
                .collect();
            let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
            let size = norm(&w);
            if size > 0.0 && size.is_finite() {
                // The first is not yet of the section, nor along the direction that grows most.
                if i > 0 {
                    grown += libm::log(size / norm(&by));
                }
                deviation = Some(w.iter().map(|x| x / size).collect());
            }
            if next - from >= window {
                windows.push(grown / (next - from));
                (grown, from) = (0.0, next);
            }
        }
        windows
    }

    /// Residuals of the threshold equations; a decision directly after another one follows it regardless of the error.
    fn residuals<B>(&self, cycle: &Cycle<B>, flight: &Flight<B>, times: &[i64]) -> Vec<f64> {
        (0..times.len())
            .map(|i| {
                if follows(&cycle.times, i, self.tick()) {
                    return 0.0;
                }
                let command = cycle.commands[i];
                let threshold = f64::from(command.sign) * self.threshold(command);
                (self.error(flight, times[i] as f64, cycle.booked[i]) - threshold) / SCALE
            })
            .collect()
    }

    /// Sampling interval of the controller, in valve cycles, at least one.
    fn tick(&self) -> i64 {
        (2.0 * self.lags.asked).floor().max(1.0) as i64
    }

    /// One step of Newton's method.
    fn step<B: Body>(&self, cycle: &Cycle<B>) -> Option<Step> {
        let begin = self.coordinates(&{
            let mut start = cycle.start;
            start.hydraulics.finish_cycle();
            start
        });
        let (n, m) = (begin.len(), cycle.times.len());
        let held = self.fly(cycle, &cycle.times, false);
        let residual = self.residuals(cycle, &held, &cycle.times);
        let mut f_x = DMatrix::zeros(n, n);
        let mut e_x = DMatrix::zeros(m, n);
        for k in 0..n {
            let mut by = vec![0.0; n];
            by[k] = DISPLACED;
            let beside = Cycle {
                start: self.displaced(&cycle.start, &by),
                ..cycle.clone()
            };
            let flight = self.fly(&beside, &cycle.times, false);
            let changed = self.residuals(cycle, &flight, &cycle.times);
            for i in 0..n {
                f_x[(i, k)] = (flight.end[i] - held.end[i]) / DISPLACED;
            }
            for i in 0..m {
                e_x[(i, k)] = (changed[i] - residual[i]) / DISPLACED;
            }
        }
        let mut f_t = DMatrix::zeros(n, m);
        let mut e_t = DMatrix::zeros(m, m);
        for k in 0..m {
            let mut times = cycle.times.clone();
            let by = if k + 1 < m && times[k + 1] == times[k] + 1 {
                -1
            } else {
                1
            };
            times[k] += by;
            let flight = self.fly(cycle, &times, false);
            let by = by as f64;
            for i in 0..n {
                f_t[(i, k)] = (flight.end[i] - held.end[i]) / by;
            }
            let changed = self.residuals(cycle, &flight, &cycle.times);
            for i in k + 1..m {
                e_t[(i, k)] = (changed[i] - residual[i]) / by;
            }
            if follows(&cycle.times, k, self.tick()) {
                e_t[(k, k)] = 1.0;
                e_t[(k, k - 1)] = -1.0;
            } else {
                let at = |later: f64| {
                    self.error(&held, cycle.times[k] as f64 + later, cycle.booked[k]) / SCALE
                };
                e_t[(k, k)] = at(0.5) - at(-0.5);
            }
        }
        // Unknown: the coordinates' change, the instants' but the first, the period's.
        let size = n + m;
        let mut equations = DMatrix::zeros(size, size);
        let mut right = DVector::zeros(size);
        for i in 0..n {
            for k in 0..n {
                equations[(i, k)] = f64::from(u8::from(i == k)) - f_x[(i, k)];
            }
            for k in 1..m {
                equations[(i, n + k - 1)] = -f_t[(i, k)];
            }
            equations[(i, size - 1)] = held.end[i] - held.later[i];
            right[i] = held.end[i] - begin[i];
        }
        for i in 0..m {
            for k in 0..n {
                equations[(n + i, k)] = e_x[(i, k)];
            }
            for k in 1..m {
                equations[(n + i, n + k - 1)] = e_t[(i, k)];
            }
            right[n + i] = -residual[i];
        }
        let solution = least_norm(equations, &right)?;
        let speed = DVector::from_fn(n, |i, _| held.later[i] - held.end[i]);
        let multipliers = multipliers((&f_x, &f_t), (&e_x, &e_t), &speed)?;
        let mut later = vec![0.0];
        later.extend((1..m).map(|k| solution[n + k - 1]));
        Some(Step {
            by: solution.rows(0, n).iter().copied().collect(),
            later,
            period: solution[size - 1],
            multipliers,
        })
    }

    /// The orbit of a cycle that closes, if the logic would make exactly these decisions.
    fn described<B: Body>(&self, cycle: &Cycle<B>, step: &Step) -> Option<Orbit> {
        let flight = self.fly(cycle, &cycle.times, true);
        self.decided_so(cycle, &flight).then_some(())?;
        let seconds = self.set.cycle();
        let samples = self.between_cycles(cycle, &flight.samples, &step.later);
        let output = range(samples.iter().map(|sample| sample.output));
        let mean = samples.iter().map(|s| s.output).sum::<f64>() / samples.len() as f64;
        let first = cycle.times[0] as f64;
        let times = cycle.times.iter().zip(&step.later);
        Some(Orbit {
            period: (cycle.period as f64 + step.period) * seconds,
            decisions: times
                .map(|(time, later)| (*time as f64 + later - first) * seconds)
                .zip(cycle.commands.iter().copied())
                .collect(),
            multipliers: step.multipliers.clone(),
            output: (output.0, output.1, mean),
            angle: range(samples.iter().map(|sample| sample.angle)),
            samples,
        })
    }

    /// The samples, with the output interpolated for the delay of each decision after its valve cycle. The actuator's angle is not interpolated, which
    /// would cut off its turning points.
    fn between_cycles<B: Body>(
        &self,
        cycle: &Cycle<B>,
        whole: &[Sample],
        later: &[f64],
    ) -> Vec<Sample> {
        let mut samples = whole.to_vec();
        for (k, later) in later.iter().enumerate() {
            let mut times = cycle.times.clone();
            times[k] += if *later < 0.0 { -1 } else { 1 };
            if *later == 0.0 || !times.is_sorted_by(|a, b| a < b) {
                continue;
            }
            let beside = self.fly(cycle, &times, true).samples;
            for ((sample, beside), whole) in samples.iter_mut().zip(&beside).zip(whole) {
                let share = later.abs();
                sample.output += share * (beside.output - whole.output);
            }
        }
        samples
    }

    /// Whether thresholds are passed only at the decisions, within one valve cycle.
    fn decided_so<B>(&self, cycle: &Cycle<B>, flight: &Flight<B>) -> bool {
        let after = self.tick() + 2;
        let mut next = 0;
        let mut last = cycle.times[cycle.times.len() - 1] - cycle.period;
        for c in 0..cycle.period {
            while next < cycle.times.len() && cycle.times[next] <= c {
                last = cycle.times[next];
                next += 1;
            }
            let near = cycle.times.get(next).is_some_and(|time| time - c <= 1);
            if c - last <= after || near || (c as f64) < self.lags.asked {
                continue;
            }
            let booked = cycle.booked[next % cycle.times.len()];
            if self.error(flight, c as f64, booked).abs() > self.least() * (1.0 + 1e-6) {
                return false;
            }
        }
        true
    }
}

/// Whether a decision comes within a sample of the previous one, because the error was already beyond the threshold.
fn follows(times: &[i64], i: usize, tick: i64) -> bool {
    i > 0 && times[i] - times[i - 1] <= tick
}

/// Minimum and maximum.
pub(crate) fn range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let both = |(low, high): (f64, f64), x: f64| (low.min(x), high.max(x));
    values.into_iter().fold((f64::MAX, f64::MIN), both)
}

/// Least-norm solution of equations that may not determine some combinations of the unknowns.
fn least_norm(equations: DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let finite = equations.iter().chain(right.iter()).all(|x| x.is_finite());
    let parts = finite.then(|| equations.svd(true, true))?;
    let cut = 1e-9 * parts.singular_values.max();
    parts.solve(right, cut).ok()
}

/// Eigenvalues, largest first, of the map from one first decision to the next: derivatives of the end and of the errors with respect to the beginning
/// (F_x, E_x) and to the instants (F_t, E_t), and the speed at the end.
///
/// The first instant is fixed, so a deviation keeps its error there, e_1 = 0, now and a period later. That removes one dimension, whose eigenvalue of
/// 0 is left out.
fn multipliers(
    (f_x, f_t): (&DMatrix<f64>, &DMatrix<f64>),
    (e_x, e_t): (&DMatrix<f64>, &DMatrix<f64>),
    speed: &DVector<f64>,
) -> Option<Vec<Complex<f64>>> {
    let (n, m) = f_t.shape();
    let mut map = f_x.clone();
    if m > 1 {
        let later = e_t.view((1, 1), (m - 1, m - 1)).into_owned();
        let following = later.lu().solve(&e_x.rows(1, m - 1).into_owned())?;
        map -= f_t.columns(1, m - 1) * following;
    }
    let first = e_x.rows(0, 1).into_owned();
    let passes = (&first * speed)[(0, 0)];
    if passes != 0.0 {
        map -= speed * (&first * &map) / passes;
    }
    let mut all = eigenvalues(&map).ok()?;
    all.sort_by(|a, b| b.modulus().total_cmp(&a.modulus()));
    all.truncate(n - 1);
    Some(all)
}
