//! A loop watched while it oscillates, and what that motion is: a periodic orbit that it follows, an exact repetition, rest, or
//! an irregular motion.

use planesman_hydraulics::{Command, Dha, Volume};

use crate::orbit::{self, Actuation, Body, Cycle, Decision, Orbit, State, range};

/// How near a loop comes to an orbit that it follows, in frequency and in the stroke of the actuator. In precision mode a
/// stroke is no more than three valve cycles of drift, and samples take their share of it.
const FOLLOWED: (f64, f64) = (0.02, 0.05);
/// The time over which an irregular motion's swings and rates are taken, s.
const WINDOW: f64 = 50.0;
/// The most decisions that are kept.
const MOST_DECISIONS: usize = 40_000;
/// Below this nothing moves, SI.
const STILL: f64 = 1e-6;

/// What was seen of a loop, in equal steps.
#[derive(Clone, Debug)]
pub struct Watched<B> {
    /// Between two samples, s.
    pub interval: f64,
    /// [`Body::output`].
    pub outputs: Vec<f64>,
    /// The actuator's angle, rad.
    pub angles: Vec<f64>,
    /// The decisions in that time.
    pub decisions: Vec<Decision>,
    /// The state a little before each.
    pub before: Vec<State<B>>,
}

/// What an actuator has done: volumes, small volumes, changes of sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Done(u64, u64, u64);

impl Done {
    pub(crate) fn of(dha: &Dha) -> Self {
        Self(dha.pulses(), dha.small_pulses(), dha.sign_changes())
    }
}

/// What a loop's motion is.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// A stable orbit, which the loop follows: its frequency within 2 %, the actuator's stroke within 5 %.
    Orbit(Orbit),
    /// It rests within the thresholds: every place there is one of rest.
    Rest,
    /// It repeats itself exactly, on its own samples, with no orbit nearby: the period, s.
    Repeats(f64),
    /// Neither.
    Irregular(Irregular),
}

/// An irregular motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Irregular {
    /// The least and the largest swing of the output in 50 s, SI.
    pub swing: (f64, f64),
    /// The fewest and the most decisions a second in 50 s.
    pub rate: (f64, f64),
    /// The orbit nearest to it: unstable, or not followed.
    pub orbit: Option<Orbit>,
}

impl<B: Body> Watched<B> {
    /// Of samples so far apart, s.
    #[must_use]
    pub fn new(interval: f64) -> Self {
        Self {
            interval,
            outputs: Vec::new(),
            angles: Vec::new(),
            decisions: Vec::new(),
            before: Vec::new(),
        }
    }

    /// Keeps the decision, if there is one, that the actuator has taken since `before`, at last at `nanos` with the angle `asked`
    /// of it, rad; a little earlier the loop was in `state`.
    pub(crate) fn take_decision(
        &mut self,
        dha: &Dha,
        before: Done,
        (nanos, asked): (i64, f64),
        state: &State<B>,
    ) {
        let done = Done::of(dha);
        if done == before || self.decisions.len() == MOST_DECISIONS {
            return;
        }
        let volume = if done.1 > before.1 {
            Volume::Small
        } else if done.0 > before.0 {
            Volume::Large
        } else {
            Volume::None
        };
        let cycles = (nanos - 1) as f64 * 1e-9 / dha.cycle();
        self.decisions.push(Decision {
            time: cycles.floor() * dha.cycle(),
            command: Command {
                volume,
                sign: dha.sign(),
            },
            booked: asked - dha.error(),
        });
        self.before.push(*state);
    }

    /// What values swing in a time of `period` s, for each such time.
    fn swings<'a>(&self, values: &'a [f64], period: f64) -> impl Iterator<Item = f64> + 'a {
        let length = (period / self.interval) as usize;
        values
            .chunks_exact(length.clamp(1, values.len().max(1)))
            .map(|values| {
                let (low, high) = range(values.iter().copied());
                high - low
            })
    }

    /// What the output swings in `period` s on average, SI.
    #[must_use]
    pub fn swing(&self, period: f64) -> f64 {
        mean(self.swings(&self.outputs, period))
    }

    /// What the actuator's angle swings in `period` s on average, rad.
    #[must_use]
    pub fn stroke(&self, period: f64) -> f64 {
        mean(self.swings(&self.angles, period))
    }

    /// The share by which the loop's frequency differs from an orbit's, and that of the stroke.
    #[must_use]
    pub fn apart(&self, orbit: &Orbit) -> (f64, f64) {
        let turns = orbit::turns(&self.decisions).unwrap_or_default();
        (
            orbit.turns() / turns - 1.0,
            orbit.stroke() / self.stroke(orbit.period) - 1.0,
        )
    }

    /// What the motion is, and the cycle of its orbit.
    #[must_use]
    pub fn motion(&self, actuation: &Actuation) -> (Motion, Option<Cycle<B>>) {
        let follows = |orbit: &Orbit| {
            let (frequency, stroke) = self.apart(orbit);
            orbit.stable() && frequency.abs() < FOLLOWED.0 && stroke.abs() < FOLLOWED.1
        };
        match orbit::find(actuation, &self.decisions, &self.before, follows) {
            Some((orbit, cycle)) if follows(&orbit) => (Motion::Orbit(orbit), Some(cycle)),
            found => (self.no_orbit(found.map(|(orbit, _)| orbit)), None),
        }
    }

    fn no_orbit(&self, orbit: Option<Orbit>) -> Motion {
        let latest = &self.outputs[self.outputs.len() / 2..];
        let (low, high) = range(latest.iter().copied());
        if self.decisions.len() < 2 && high - low < STILL {
            return Motion::Rest;
        }
        if let Some(period) = orbit::repeats(&self.decisions, &self.before) {
            return Motion::Repeats(period);
        }
        let swings = self.swings(&self.outputs, WINDOW);
        let begin = self.decisions.first().map_or(0.0, |first| first.time);
        let last = self.decisions.last().map_or(0.0, |last| last.time);
        let seconds = last - begin;
        let rates = (0..(seconds / WINDOW) as i32).map(|i| {
            let from = begin + f64::from(i) * WINDOW;
            let within = |d: &&Decision| (from..from + WINDOW).contains(&d.time);
            self.decisions.iter().filter(within).count() as f64 / WINDOW
        });
        Motion::Irregular(Irregular {
            swing: range(swings),
            rate: range(rates),
            orbit,
        })
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), x| (sum + x, count + 1));
    sum / f64::from(count)
}
