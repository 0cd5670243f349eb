//! A loop watched while it oscillates, and what that motion is: a periodic orbit that it follows, an exact repetition, rest, or
//! an irregular motion.

use planesman_hydraulics::{Command, Dha, Volume};

use crate::studies::orbit::{self, Actuation, Body, Decision, Orbit, State, range};

/// How near a loop comes to an orbit that it follows, in frequency and in the stroke of the actuator. In precision mode a
/// stroke is no more than three valve cycles of drift, and samples take their share of it.
const FOLLOWED: (f64, f64) = (0.02, 0.05);
/// By how much more than the orbit the output may swing in a period: SI, as far as the samples alone move it, and a share.
const WALK: (f64, f64) = (5e-5, 0.2);
/// The time over which an irregular motion's swings and rates are taken, s.
const WINDOW: f64 = 50.0;
/// The most decisions that are kept.
const MOST_DECISIONS: usize = 40_000;
/// The time along which the growth of deviations is measured, s.
const GROWN: f64 = 250.0;
/// Below this nothing moves, SI.
const STILL: f64 = 1e-6;

/// What was seen of a loop, in equal steps.
#[derive(Clone, Debug)]
pub struct Watched<B> {
    /// The begin, s.
    pub from: f64,
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
    /// A stable orbit, which the loop follows: its frequency within 2 %, the actuator's stroke within 5 %, the output within 20 %.
    Orbit(Orbit),
    /// It rests within the thresholds: every place there is one of rest.
    Rest,
    /// It repeats itself exactly, on its own samples, with no orbit nearby: the period, s.
    Repeats(f64),
    /// Neither.
    Irregular(Irregular),
}

/// An irregular motion, in times of 50 s.
#[derive(Clone, Debug, PartialEq)]
pub struct Irregular {
    /// How many times of 50 s were seen.
    pub windows: usize,
    /// The least and the largest swing of the output among them, SI.
    pub swing: (f64, f64),
    /// The fewest and the most decisions a second.
    pub rate: (f64, f64),
    /// By how much small deviations grow in each of the first 250 s, 1/s, as of [`Actuation::growth`].
    pub growth: Vec<f64>,
    /// The orbit nearest to it in frequency: unstable, or not followed.
    pub orbit: Option<Orbit>,
}

impl Irregular {
    /// This one and another of the same loop as one.
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
    /// Its orbit, or of an irregular motion the nearest.
    #[must_use]
    pub fn orbit(&self) -> Option<&Orbit> {
        match self {
            Self::Orbit(orbit) => Some(orbit),
            Self::Irregular(irregular) => irregular.orbit.as_ref(),
            Self::Rest | Self::Repeats(_) => None,
        }
    }

    /// Whether two motions are of one kind, and if they are orbits, one within what the samples make of it.
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
    /// Of samples so far apart, s, from a time on, s.
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

    /// What the motion is.
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
