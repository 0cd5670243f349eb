//! Optimises gains for a range of speeds: minimises the worst ITAE of a depth step, within margins.
//!
//! One set of four gains is used for all speeds. The cost is the largest value over the speeds of `ITAE U^2`, the ITAE in metres travelled instead of
//! seconds (a slow vehicle necessarily takes longer), with
//!
//! - at every speed a phase margin and gain margins at least as large as required, and an overshoot at most as large;
//! - at the first instant of a depth step of the given size, pitch command and planes within their limits: `Kpz e <= theta_lim`,
//!   `Kpy Kpz e <= delta_lim`.
//!
//! Without the second condition a linear loop only improves with more gain. The search is global ([`lowest`]), on the logarithms of `Kpz`,
//! `Kpy Kpz` and `Kr`, and of `1 + Kdz U`, the factor by which the depth rate at the largest speed `U` increases the weight of pitch. The
//! conditions at the first instant are then bounds, and small values of `Kdz` do not form a wide valley. Missed limits have priority over
//! the ITAE, and the result does not depend on initial gains.

use planesman_linear::{Error, StepMetrics, lowest};

use super::dive_loop::{DiveLoop, DivePlant, Judgement, Memory, Path};
use crate::gains::LoopGains;

/// The range of gains in the search.
const BOUNDS: (f64, f64) = (1e-3, 1e3);
/// Additional miss of gains for which a step exceeds a limit at its first instant.
const FIRST: f64 = 100.0;
/// Penalty for an unstable loop, larger than that of any stable loop.
const UNSTABLE: f64 = 10.0;
/// The search ends when the ITAE of all members differs by less than this share.
const ALIKE: f64 = 1e-3;
/// Number of members of the search, and maximum number of rounds.
const MEMBERS: usize = 60;
const MOST_ROUNDS: usize = 300;

/// The requirements on the gains.
#[derive(Clone, Debug, PartialEq)]
pub struct Wishes {
    /// The speeds, m/s, and the vehicle at each; a sampled one is analysed as the sampled loop.
    pub plants: Vec<(f64, DivePlant)>,
    /// The integrals and the filter, which are not optimised.
    pub memory: Memory,
    /// The actuator of a continuous loop.
    pub path: Path,
    /// rad, at every gain crossover.
    pub phase_margin: f64,
    /// The smallest factor by which the gain may rise, above 1; its inverse is the factor by which it may fall.
    pub gain_margin: f64,
    /// Largest overshoot of the depth step, percent.
    pub overshoot: f64,
    /// The depth step, m.
    pub step: f64,
    /// rad
    pub pitch_limit: f64,
    /// rad
    pub planes_limit: f64,
    /// The duration of the step response, s.
    pub duration: f64,
}

/// The result of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// The gains.
    pub gains: LoopGains,
    /// The analysis with these gains, at each speed.
    pub judgements: Vec<Judgement>,
    /// The largest `ITAE U^2`, m^2.
    pub worst: f64,
}

impl Wishes {
    /// The best gains; `None` if no gains satisfy all requirements.
    ///
    /// # Errors
    /// Errors of [`DiveLoop::judge`].
    pub fn propose(&self) -> Result<Option<Proposal>, Error> {
        let (low, high) = BOUNDS;
        let speeds = self.plants.iter().map(|it| it.0);
        let fastest = speeds.fold(f64::MIN_POSITIVE, f64::max);
        let first = |limit: f64| {
            let most = (limit / self.step).min(high);
            (low * most.min(1.0), most)
        };
        let bounds = [
            first(self.pitch_limit),
            first(self.planes_limit),
            (1.0 + low * fastest, 1.0 + high * fastest),
            (low, high),
        ];
        let bounds = bounds.map(|(low, high)| (libm::log(low), libm::log(high)));
        let gains = |at: &[f64; 4]| {
            let [depth_p, planes, pitch, pitch_rate] = at.map(libm::exp);
            LoopGains {
                depth_p,
                depth_d: (pitch - 1.0) / fastest,
                pitch_p: planes / depth_p,
                pitch_rate,
            }
        };
        let costs = |all: &[[f64; 4]]| all.iter().map(|at| self.cost(&gains(at))).collect();
        let (at, best) = lowest(&bounds, MEMBERS, MOST_ROUNDS, Cost::is_like, costs)?;
        if best.missed > 0.0 {
            return Ok(None);
        }
        let gains = gains(&at);
        Ok(Some(Proposal {
            judgements: self.judge(&gains)?,
            gains,
            worst: best.itae,
        }))
    }

    /// The largest `ITAE U^2` with other gains, m^2; `None` for gains that do not satisfy all requirements.
    ///
    /// # Errors
    /// Errors of [`DiveLoop::judge`].
    pub fn worst(&self, gains: &LoopGains) -> Result<Option<f64>, Error> {
        let cost = self.cost(gains)?;
        Ok((cost.missed == 0.0).then_some(cost.itae))
    }

    fn loops<'a>(&'a self, gains: &'a LoopGains) -> impl Iterator<Item = DiveLoop> + 'a {
        self.plants.iter().map(|(_, plant)| DiveLoop {
            plant: plant.clone(),
            gains: *gains,
            memory: self.memory,
            path: self.path,
        })
    }

    fn judge(&self, gains: &LoopGains) -> Result<Vec<Judgement>, Error> {
        self.loops(gains)
            .map(|dive| dive.judge(self.duration))
            .collect()
    }

    fn cost(&self, gains: &LoopGains) -> Result<Cost, Error> {
        let beyond = |value: f64, limit: f64| (value / limit - 1.0).max(0.0);
        let mut missed = beyond(gains.depth_p * self.step, self.pitch_limit)
            + beyond(gains.pitch_p * gains.depth_p * self.step, self.planes_limit);
        if missed > 0.0 {
            // Before the loop is looked at, which takes longer.
            missed += FIRST;
            return Ok(Cost { missed, itae: 0.0 });
        }
        for dive in self.loops(gains) {
            missed += self.missed(&dive)?;
        }
        // Among gains that miss their margins, how fast they are does not matter.
        let mut itae = 0.0_f64;
        if missed == 0.0 {
            for (dive, (speed, _)) in self.loops(gains).zip(&self.plants) {
                let (times, depths): (Vec<f64>, Vec<f64>) =
                    dive.step(self.duration)?.into_iter().unzip();
                let step = StepMetrics::of(&times, &depths, 0.0, 1.0)?;
                missed += beyond(step.overshoot, self.overshoot);
                itae = itae.max(step.itae * speed * speed);
            }
        }
        Ok(Cost { missed, itae })
    }

    /// The amount by which a loop misses its margins; for an unstable loop it increases with the loop's growth.
    fn missed(&self, dive: &DiveLoop) -> Result<f64, Error> {
        let growth = dive.growth()?;
        if growth >= 0.0 {
            return Ok(UNSTABLE + growth);
        }
        let judged = dive.margins()?;
        let phase = judged
            .phase_margin()
            .map_or(0.0, |margin| (1.0 - margin / self.phase_margin).max(0.0));
        let (above, below) = judged.gain_limits();
        let up = above.map_or(0.0, |m| (1.0 - m.factor / self.gain_margin).max(0.0));
        let down = below.map_or(0.0, |m| {
            (1.0 - 1.0 / (m.factor * self.gain_margin)).max(0.0)
        });
        Ok(phase + up + down)
    }
}

/// The violation of the requirements, then the cost, compared in this order.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Cost {
    missed: f64,
    itae: f64,
}

impl Cost {
    fn is_like(self, other: Self) -> bool {
        self.missed == other.missed && other.itae <= self.itae * (1.0 + ALIKE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gains::{PitchModel, SpeedLaw};
    use planesman_units::FOOT;

    fn wishes(speeds: &[f64]) -> Wishes {
        let law = SpeedLaw {
            model: PitchModel {
                plane: 0.47,
                damping: 1.2,
                restoring: 0.27,
            },
            reference_speed: FOOT,
            plane_exponent: 2.0,
            damping_exponent: 1.0,
        };
        let plant = |u: &f64| (*u, DivePlant::of_pitch(&law.at(*u), *u).unwrap());
        Wishes {
            plants: speeds.iter().map(plant).collect(),
            memory: Memory::default(),
            path: Path {
                lag: 0.0,
                delay: 0.05,
            },
            phase_margin: 60_f64.to_radians(),
            gain_margin: 2.0,
            overshoot: 5.0,
            step: 3.0 * FOOT,
            pitch_limit: std::f64::consts::FRAC_PI_4,
            planes_limit: std::f64::consts::FRAC_PI_6,
            duration: 60.0,
        }
    }

    const START: LoopGains = LoopGains {
        depth_p: 0.5,
        depth_d: 1.97,
        pitch_p: 0.7,
        pitch_rate: 2.0,
    };

    #[test]
    fn what_is_proposed_keeps_its_margins_and_limits_and_is_faster_than_the_start() {
        let wishes = wishes(&[FOOT, 2.0 * FOOT]);
        let proposed = wishes.propose().unwrap().unwrap();
        for judged in &proposed.judgements {
            assert!(judged.is_stable());
            assert!(judged.phase_margin().unwrap() >= wishes.phase_margin);
            let (above, below) = judged.gain_limits();
            assert!(above.is_none_or(|m| m.factor >= 2.0));
            assert!(below.is_none_or(|m| m.factor <= 0.5));
        }
        let gains = proposed.gains;
        assert!(gains.depth_p * wishes.step <= wishes.pitch_limit);
        assert!(gains.pitch_p * gains.depth_p * wishes.step <= wishes.planes_limit);
        let worst = |judged: &[Judgement]| {
            let speeds = wishes.plants.iter().map(|(speed, _)| speed * speed);
            let itae = judged.iter().map(|j| j.step.unwrap().itae);
            itae.zip(speeds).map(|(a, b)| a * b).fold(0.0, f64::max)
        };
        let start = worst(&wishes.judge(&START).unwrap());
        assert!(proposed.worst < 0.9 * start, "{proposed:?}");
        assert!((proposed.worst / worst(&proposed.judgements) - 1.0).abs() < 1e-12);
        assert_eq!(wishes.worst(&gains).unwrap(), Some(proposed.worst));
        let overshoots = proposed
            .judgements
            .iter()
            .map(|j| j.step.unwrap().overshoot);
        assert!(overshoots.fold(0.0, f64::max) <= wishes.overshoot);
    }

    #[test]
    fn what_cannot_be_had_is_not_proposed() {
        let mut impossible = wishes(&[FOOT]);
        // No margin is more than half a turn.
        impossible.phase_margin = 3.2;
        assert_eq!(impossible.propose().unwrap(), None);
    }
}
