//! Observation of an oscillating loop, and the kind of its motion: a periodic orbit that it follows, an exact repetition, rest, or an irregular
//! motion.

use planesman_hydraulics::{Command, Dha, Volume};

use crate::studies::orbit::{self, Actuation, Body, Decision, Orbit, State, range};

/// Relative differences in frequency and in the actuator's stroke within which a loop follows an orbit. In precision mode a stroke is at most three
/// valve cycles of drift, and sampling takes a part of this time.
const FOLLOWED: (f64, f64) = (0.02, 0.05);
/// Largest excess of the output's amplitude per period over the orbit's: SI, due to sampling alone, and relative.
const WALK: (f64, f64) = (5e-5, 0.2);
/// Window for amplitudes and rates of an irregular motion, s.
const WINDOW: f64 = 50.0;
/// Maximum number of decisions stored.
const MOST_DECISIONS: usize = 40_000;
/// Time over which the growth of deviations is measured, s.
const GROWN: f64 = 250.0;
/// Amplitude below which nothing moves, SI.
const STILL: f64 = 1e-6;

/// Observed motion of a loop, in equal steps.
#[derive(Clone, Debug)]
pub struct Watched<B> {
    /// Beginning, s.
    pub from: f64,
    /// Time between two samples, s.
    pub interval: f64,
    /// Outputs, as [`Body::output`].
    pub outputs: Vec<f64>,
    /// Angles of the actuator, rad.
    pub angles: Vec<f64>,
    /// Decisions during that time.
    pub decisions: Vec<Decision>,
    /// State shortly before each decision.
    pub before: Vec<State<B>>,
}

/// Counters of an actuator: volumes, small volumes, changes of sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Done(u64, u64, u64);

impl Done {
    pub(crate) fn of(dha: &Dha) -> Self {
        Self(dha.pulses(), dha.small_pulses(), dha.sign_changes())
    }
}

/// Kind of a loop's motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// A stable orbit that the loop follows: frequency within 2 %, stroke of the actuator within 5 %, output within 20 %.
    Orbit(Orbit),
    /// Rest within the thresholds, at any place there.
    Rest,
    /// An exact repetition at its own samples, with no orbit nearby: the period, s.
    Repeats(f64),
    /// None of these.
    Irregular(Irregular),
}

/// An irregular motion, in windows of 50 s.
#[derive(Clone, Debug, PartialEq)]
pub struct Irregular {
    /// Number of windows.
    pub windows: usize,
    /// Smallest and largest amplitude of the output in a window, SI.
    pub swing: (f64, f64),
    /// Smallest and largest number of decisions per second.
    pub rate: (f64, f64),
    /// Growth rate of small deviations in each of the first windows, up to 250 s, 1/s, as in [`Actuation::growth`].
    pub growth: Vec<f64>,
    /// The orbit nearest in frequency: unstable, or not followed.
    pub orbit: Option<Orbit>,
}

impl Irregular {
    /// This motion combined with another one of the same loop.
    #[must_use]
    pub fn and(mut self, other: &Self) -> Self {
        let wider = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        self.windows += other.windows;
        self.swing = wider(self.swing, other.swing);
        self.rate = wider(self.rate, other.rate);
        self.growth.extend(&other.growth);
        self.orbit = self.orbit.or_else(|| other.orbit.clone());
        self
    }
}

impl Motion {
    /// The orbit; for an irregular motion the nearest one.
    #[must_use]
    pub fn orbit(&self) -> Option<&Orbit> {
        match self {
            Self::Orbit(orbit) => Some(orbit),
            Self::Irregular(irregular) => irregular.orbit.as_ref(),
            Self::Rest | Self::Repeats(_) => None,
        }
    }

    /// Whether two motions are of the same kind; two orbits must be equal within the effect of sampling.
    #[must_use]
    pub fn alike(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64, share: f64| (a - b).abs() < share * a;
        match (self, other) {
            (Self::Orbit(a), Self::Orbit(b)) => {
                near(a.turns(), b.turns(), FOLLOWED.0) && near(a.stroke(), b.stroke(), FOLLOWED.1)
            }
            (Self::Rest, Self::Rest)
            | (Self::Repeats(_), Self::Repeats(_))
            | (Self::Irregular(_), Self::Irregular(_)) => true,
            _ => false,
        }
    }
}

impl<B: Body> Watched<B> {
    /// An empty observation with samples spaced by `interval`, s, beginning at `from`, s.
    #[must_use]
    pub fn new(interval: f64, from: f64) -> Self {
        Self {
            from,
            interval,
            outputs: Vec::new(),
            angles: Vec::new(),
            decisions: Vec::new(),
            before: Vec::new(),
        }
    }

    /// Stores the decision that the actuator has made since `before`, if there is one; the actuator is now at `nanos` with the command `asked`, rad,
    /// and shortly before the loop was in `state`.
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

    /// Peak-to-peak values in each interval of `period` s.
    fn swings<'a>(&self, values: &'a [f64], period: f64) -> impl Iterator<Item = f64> + 'a {
        let length = (period / self.interval) as usize;
        values
            .chunks_exact(length.clamp(1, values.len().max(1)))
            .map(|values| {
                let (low, high) = range(values.iter().copied());
                high - low
            })
    }

    /// Mean peak-to-peak output per `period` s, SI.
    #[must_use]
    pub fn swing(&self, period: f64) -> f64 {
        mean(self.swings(&self.outputs, period))
    }

    /// Mean peak-to-peak angle of the actuator per `period` s, rad.
    #[must_use]
    pub fn stroke(&self, period: f64) -> f64 {
        mean(self.swings(&self.angles, period))
    }

    /// Relative differences of the loop's frequency and stroke from an orbit's.
    #[must_use]
    pub fn apart(&self, orbit: &Orbit) -> (f64, f64) {
        let turns = orbit::turns(&self.decisions).unwrap_or_default();
        (
            orbit.turns() / turns - 1.0,
            orbit.stroke() / self.stroke(orbit.period) - 1.0,
        )
    }

    /// Whether the loop follows an orbit.
    #[must_use]
    pub fn follows(&self, orbit: &Orbit) -> bool {
        let (frequency, stroke) = self.apart(orbit);
        let (walk, share) = WALK;
        let swing = self.swing(orbit.period) - orbit.swing();
        orbit.stable()
            && frequency.abs() < FOLLOWED.0
            && stroke.abs() < FOLLOWED.1
            && swing < walk + share * orbit.swing()
    }

    /// Classifies the motion.
    #[must_use]
    pub fn motion(&self, actuation: &Actuation) -> Motion {
        let follows = |orbit: &Orbit| self.follows(orbit);
        match orbit::find(actuation, &self.decisions, &self.before, follows) {
            Some(orbit) if follows(&orbit) => Motion::Orbit(orbit),
            nearest => self.no_orbit(actuation, nearest),
        }
    }

    fn no_orbit(&self, actuation: &Actuation, orbit: Option<Orbit>) -> Motion {
        let latest = &self.outputs[self.outputs.len() / 2..];
        let (low, high) = range(latest.iter().copied());
        if self.decisions.len() < 2 && high - low < STILL {
            return Motion::Rest;
        }
        if let Some(period) = orbit::repeats(&self.decisions, &self.before) {
            return Motion::Repeats(period);
        }
        let swings = self.swings(&self.outputs, WINDOW);
        let windows = (self.outputs.len() as f64 * self.interval / WINDOW) as usize;
        let rates = (0..windows).map(|i| {
            let from = self.from + i as f64 * WINDOW;
            let within = |d: &&Decision| (from..from + WINDOW).contains(&d.time);
            self.decisions.iter().filter(within).count() as f64 / WINDOW
        });
        let soon = |d: &Decision| d.time < self.from + GROWN;
        let grown = self.decisions.partition_point(soon);
        Motion::Irregular(Irregular {
            windows,
            swing: range(swings),
            rate: range(rates),
            growth: actuation.growth(&self.decisions[..grown], &self.before[..grown], WINDOW),
            orbit,
        })
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), x| (sum + x, count + 1));
    sum / f64::from(count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn irregular_motions_of_several_starts_are_pooled() {
        let of = |swing, rate, growth: &[f64]| Irregular {
            windows: growth.len(),
            swing,
            rate,
            growth: growth.to_vec(),
            orbit: None,
        };
        let all = of((0.3, 0.5), (4.0, 5.0), &[0.1]).and(&of((0.2, 0.4), (4.5, 6.0), &[0.2, 0.3]));
        assert_eq!(all, of((0.2, 0.5), (4.0, 6.0), &[0.1, 0.2, 0.3]));
    }
}
