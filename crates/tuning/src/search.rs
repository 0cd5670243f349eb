//! Gains by search on one plant: the least error after a load, or the largest integral gain, within limits.
//!
//! For each `Ti` (and `Td`, a quarter of it at most, so that the zeros are real) the largest gain within the limits is
//! sought; of these the best is taken. With the integral gain that is the design of Astrom, Panagopoulos and Hagglund
//! (*Automatica* 34, 1998; MIGO in *Advanced PID Control*, ch. 7), with the integrated absolute error what it stands for. The
//! search is Hooke and Jeeves' on the times' logarithms: no derivatives, no chance.

use planesman_linear::{ComplexFunctions as _, frequency};

use crate::closed_loop::{Limits, Seen};
use crate::controller::Controller;
use crate::response::{Motion, Trial};

/// `Ti` is sought between these times the inverse of the plant's phase crossover frequency.
const TI: (f64, f64) = (0.1, 1000.0);
/// `Td` from this one on.
const TD: f64 = 0.01;
/// The first steps of the times' logarithms, and the last.
const STEPS: (f64, f64) = (0.8, 0.02);
/// Gains are tried from so much above that which takes the plant to its limit of stability, down to so much below.
const GAINS: (f64, f64) = (1e2, 1e-4);
/// So many for each factor of e.
const GAINS_PER_E: f64 = 8.0;
/// The duration of a response in inverse phase crossover frequencies, and its ticks at most.
const DURATION: f64 = 300.0;
const MOST_TICKS: f64 = 20_000.0;
/// `Td` of `Ti` at most.
const TD_PER_TI: f64 = 0.25;

/// What is made small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Objective {
    /// The integrated absolute error after a step of the load.
    AbsoluteError,
    /// The inverse of the integral gain: the integrated error after a step of the load.
    IntegralGain,
}

/// The best PI or PID controller for a plant within limits; `None` where none is found that keeps them.
#[must_use]
pub fn best(
    seen: &Seen,
    is_pid: bool,
    limits: &Limits,
    objective: Objective,
) -> Option<Controller> {
    let search = Search {
        seen,
        limits,
        objective,
        pace: 1.0 / pace(seen),
        sign: seen.plant.sign(),
    };
    let (low, high) = TI;
    // A coarse look first: cost has more than one valley where the plant is unstable.
    let coarse =
        (0..=10).map(|i| libm::log(low * libm::pow(high / low, f64::from(i) / 10.0) * search.pace));
    let ratios: &[f64] = if is_pid { &[0.25, 0.1] } else { &[0.0] };
    let starts = coarse.flat_map(|ti| ratios.iter().map(move |ratio| [ti, ti + libm::log(*ratio)]));
    let mut best = starts
        .map(|at| (at, search.cost(at)))
        .min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
    let mut step = STEPS.0;
    while step > STEPS.1 {
        let before = best.1.0;
        for i in 0..if is_pid { 2 } else { 1 } {
            for change in [step, -step] {
                let mut at = best.0;
                at[i] += change;
                let cost = search.cost(at);
                if cost.0 < best.1.0 {
                    best = (at, cost);
                    break;
                }
            }
        }
        if best.1.0 >= before {
            step *= 0.5;
        }
    }
    best.1.1
}

/// The plant's first phase crossover, rad/s; of a plant without one Nyquist's frequency.
fn pace(seen: &Seen) -> f64 {
    let sign = seen.plant.sign();
    let response: Vec<_> = seen.response.iter().map(|(w, p)| (*w, p * sign)).collect();
    let crossovers = frequency::gain_margins(&response, |w| seen.plant.at(w) * sign);
    crossovers
        .first()
        .map_or_else(|| seen.plant.nyquist(), |it| it.frequency)
}

struct Search<'a> {
    seen: &'a Seen,
    limits: &'a Limits,
    objective: Objective,
    /// s
    pace: f64,
    sign: f64,
}

impl Search<'_> {
    /// Of `Ti` and `Td`, as logarithms: what is made small, infinite where no gain keeps the limits, and the controller.
    fn cost(&self, [ti, td]: [f64; 2]) -> (f64, Option<Controller>) {
        let (ti, td) = (libm::exp(ti), libm::exp(td));
        let is_within = (TI.0 * self.pace..=TI.1 * self.pace).contains(&ti);
        let may_lead = td == 0.0 || (td >= TD * self.pace && td <= (TD_PER_TI + 1e-9) * ti);
        let none = (f64::INFINITY, None);
        if !is_within || !may_lead {
            return none;
        }
        let shape = Controller::ideal(self.sign, ti, td);
        match self.largest_gain(&shape) {
            Some(controller) => (self.objective_of(&controller), Some(controller)),
            None => none,
        }
    }

    fn largest_gain(&self, shape: &Controller) -> Option<Controller> {
        let open = self.seen.open_loop(shape);
        let tick = self.seen.plant.tick;
        let at = |w: f64| self.seen.plant.at(w) * shape.at(w, tick);
        let ultimate = frequency::gain_margins(&open, at).first().map_or_else(
            || {
                1.0 / at(self.seen.plant.nyquist())
                    .modulus()
                    .max(f64::MIN_POSITIVE)
            },
            |it| it.factor,
        );
        let keeps = |factor: f64| {
            Seen::keeps(&open, factor, self.limits) && self.seen.is_stable(&shape.times(factor))
        };
        let (most, least) = GAINS;
        let count = (libm::log(most / least) * GAINS_PER_E) as usize;
        let step = libm::exp(-1.0 / GAINS_PER_E);
        let mut factor = ultimate * most;
        for _ in 0..count {
            if keeps(factor) {
                let (mut low, mut high) = (factor, factor / step);
                for _ in 0..10 {
                    let middle = (low * high).sqrt();
                    if keeps(middle) {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                return Some(shape.times(low));
            }
            factor *= step;
        }
        None
    }

    fn objective_of(&self, controller: &Controller) -> f64 {
        // The integrated error, which the absolute one is never below.
        let integrated = 1.0 / controller.ki.abs();
        match self.objective {
            Objective::IntegralGain => integrated,
            Objective::AbsoluteError => {
                let tick = self.seen.plant.tick;
                let ticks = (DURATION * self.pace / tick).clamp(100.0, MOST_TICKS);
                let trial = Trial {
                    setpoint: 0.0,
                    load: 1.0,
                    limit: None,
                };
                let motion = Motion::new(&self.seen.plant, controller, &trial, ticks as usize);
                let error = motion.absolute_error(0.0, tick);
                if error.is_finite() {
                    error.max(integrated)
                } else {
                    f64::INFINITY
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Plant;
    use planesman_linear::TransferFunction;

    const LIMITS: Limits = Limits {
        phase: 0.5,
        gain: 1.5,
        sensitivity: 1.6,
    };

    fn seen(num: &[f64], den: &[f64], delay: f64, tick: f64) -> Seen {
        let transfer = TransferFunction::new(num.to_vec(), den.to_vec()).unwrap();
        Seen::new(Plant::held(&transfer, delay, tick).unwrap())
    }

    #[test]
    fn what_is_found_keeps_its_limits_and_stands_at_one_of_them() {
        for (num, den, delay) in [
            (vec![2.0], vec![4.0, 1.0], 1.0),
            (vec![-0.3], vec![1.0, 0.0], 0.5),
            (vec![1.0], vec![1.0, 0.3, 1.0], 0.1),
            (vec![1.0], vec![5.0, -1.0], 0.2),
        ] {
            let seen = seen(&num, &den, delay, 0.1);
            for is_pid in [false, true] {
                let Some(found) = best(&seen, is_pid, &LIMITS, Objective::AbsoluteError) else {
                    assert!(!is_pid && den == [1.0, 0.3, 1.0], "{den:?}");
                    continue;
                };
                let margins = seen.margins(&found);
                assert!(
                    margins.is_stable && margins.sensitivity < 1.61,
                    "{den:?} {margins:?}"
                );
                assert!(
                    margins.sensitivity > 1.55 || margins.phase < 0.55,
                    "{den:?} {margins:?}"
                );
                assert_eq!(found.kp.signum(), num[0].signum());
            }
        }
    }

    #[test]
    fn a_derivative_and_looser_limits_make_the_error_smaller() {
        let seen = seen(&[1.0], &[2.0, 3.0, 1.0], 0.3, 0.05);
        let error = |is_pid: bool, sensitivity: f64| {
            let limits = Limits {
                sensitivity,
                ..LIMITS
            };
            let found = best(&seen, is_pid, &limits, Objective::AbsoluteError).unwrap();
            let trial = Trial {
                setpoint: 0.0,
                load: 1.0,
                limit: None,
            };
            Motion::new(&seen.plant, &found, &trial, 2000).absolute_error(0.0, 0.05)
        };
        let (pi, pid, loose) = (error(false, 1.4), error(true, 1.4), error(false, 1.8));
        assert!(pid < 0.6 * pi && loose < 0.8 * pi, "{pi} {pid} {loose}");
    }
}
