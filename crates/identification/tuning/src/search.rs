//! Gains by search on one plant: the smallest error after a load, or the largest integral gain, within limits.
//!
//! The controller is `K (1 + 1/(Ti s) + Td s / (filter s + 1))`. With the integral gain as objective the search is the design of Astrom,
//! Panagopoulos and Hagglund (*Automatica* 34, 1998; MIGO in *Advanced PID Control*, ch. 7), which approximates the smallest integrated
//! absolute error. `K` and `Ti`, and for a PID controller `Td` and the filter, vary within [`Bounds`]. The search is global ([`lowest`]),
//! over the frequency `1 / sqrt(Ti Td)` of the controller's zeros, their damping ratio `sqrt(Ti / Td) / 2`, the filter and the gain. Missed
//! limits have priority over the error, measured by the same margins as the final gains.

use std::convert::Infallible;

use planesman_identification::on_all_cores;
use planesman_linear::{ComplexFunctions as _, frequency, lowest};

use crate::closed_loop::{Limits, PlantResponse};
use crate::controller::{Controller, FILTER_RATIO};
use crate::response::{Motion, Trial};

/// Range of `Ti` of a PI controller, times the inverse of the plant's phase crossover frequency.
const TI: (f64, f64) = (0.1, 1000.0);
/// Range of the frequency of a PID controller's zeros, in the plant's phase crossover frequency, and of their damping ratio.
const ZEROS: (f64, f64) = (1e-3, 100.0);
const DAMPING: (f64, f64) = (1e-3, 50.0);
/// Range of the square root of the filter's time constant times that frequency; below 0 there is no filter.
const FILTER: (f64, f64) = (-0.1, 1.5);
/// Range of the magnitude of the open loop at the plant's phase crossover frequency.
const SIZE: (f64, f64) = (1e-3, 1e2);
/// Members of the search for a PI and a PID controller, and maximum number of rounds.
const MEMBERS: (usize, usize) = (16, 40);
const ROUNDS: usize = 250;
/// The search ends when the costs of all members are within this factor.
const ALIKE: f64 = 1.0005;
/// The duration of a response in inverse phase crossover frequencies, and its maximum number of ticks.
const DURATION: f64 = 300.0;
const MOST_TICKS: f64 = 20_000.0;

/// The objective to be minimised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Objective {
    /// The integrated absolute error after a step of the load.
    AbsoluteError,
    /// The inverse of the integral gain: the integrated error after a step of the load.
    IntegralGain,
}

/// Bounds of a PID controller's derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Maximum of `Td / Ti`: up to 1/4 the zeros are real.
    pub td_per_ti: f64,
    /// Maximum of `Td` over the filter's time constant.
    pub filter_ratio: f64,
}

impl Bounds {
    /// No bounds for the absolute error, which itself limits the derivative. With the integral gain as objective, derivative without a
    /// bound would lead to oscillations.
    #[must_use]
    pub const fn of(objective: Objective) -> Self {
        let (td_per_ti, filter_ratio) = match objective {
            Objective::AbsoluteError => (f64::INFINITY, f64::INFINITY),
            Objective::IntegralGain => (0.25, FILTER_RATIO),
        };
        Self {
            td_per_ti,
            filter_ratio,
        }
    }
}

/// The best PI or PID controller for a plant within limits; `None` if no gains keep the limits.
#[must_use]
pub fn best(
    seen: &PlantResponse,
    is_pid: bool,
    limits: &Limits,
    objective: Objective,
    bounds: Bounds,
) -> Option<Controller> {
    let search = Search {
        seen,
        limits,
        objective,
        pace: 1.0 / pace(seen),
        sign: seen.plant.sign(),
    };
    let within = |(low, high): (f64, f64)| (libm::log(low), libm::log(high));
    if !is_pid {
        return search.best([within(TI), within(SIZE)], MEMBERS.0, |[ti, size]| {
            let shape = Controller::ideal(search.sign, libm::exp(ti) * search.pace, 0.0);
            search.of_size(&shape, size)
        });
    }
    let damped = DAMPING.0.max(0.5 / bounds.td_per_ti.sqrt());
    let ranges = [
        within(ZEROS),
        within((damped, DAMPING.1)),
        FILTER,
        within(SIZE),
    ];
    search.best(ranges, MEMBERS.1, |[zeros, damping, root, size]| {
        let (time, damping) = (search.pace / libm::exp(zeros), libm::exp(damping));
        let td = 0.5 * time / damping;
        let shape = Controller {
            filter: (root.max(0.0).powi(2) * time).max(td / bounds.filter_ratio),
            ..Controller::ideal(search.sign, 2.0 * damping * time, td)
        };
        search.of_size(&shape, size)
    })
}

/// The plant's first phase crossover, rad/s; Nyquist's frequency for a plant without a phase crossover.
fn pace(seen: &PlantResponse) -> f64 {
    let sign = seen.plant.sign();
    let response: Vec<_> = seen.response.iter().map(|(w, p)| (*w, p * sign)).collect();
    let crossovers = frequency::gain_margins(&response, |w| seen.plant.at(w) * sign);
    crossovers
        .first()
        .map_or_else(|| seen.plant.nyquist(), |it| it.frequency)
}

struct Search<'a> {
    seen: &'a PlantResponse,
    limits: &'a Limits,
    objective: Objective,
    /// s
    pace: f64,
    sign: f64,
}

impl Search<'_> {
    /// The controller of a shape scaled so that the open loop has this magnitude (its logarithm is given) at the plant's phase crossover.
    fn of_size(&self, shape: &Controller, size: f64) -> Controller {
        let (plant, frequency) = (&self.seen.plant, 1.0 / self.pace);
        let open = plant.at(frequency) * shape.at(frequency, plant.tick);
        shape.times(libm::exp(size) / open.modulus().max(f64::MIN_POSITIVE))
    }

    /// The best of the controllers within ranges.
    fn best<const N: usize>(
        &self,
        ranges: [(f64, f64); N],
        members: usize,
        controller: impl Fn([f64; N]) -> Controller + Sync,
    ) -> Option<Controller> {
        // By how much the limits are missed, then the objective.
        let cost = |at: &[f64; N]| {
            let controller = controller(*at);
            match self.limits.missed_by(self.seen, &controller) {
                0.0 => (0.0, self.objective_of(&controller)),
                missed => (missed, 0.0),
            }
        };
        let costs = |all: &[[f64; N]]| Ok::<_, Infallible>(on_all_cores(all, cost));
        let is_like = |best: (f64, f64), it: (f64, f64)| it.0 == best.0 && it.1 <= best.1 * ALIKE;
        let Ok((at, (missed, _))) = lowest(&ranges, members, ROUNDS, is_like, costs);
        (missed == 0.0).then(|| controller(at))
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

    fn seen(num: &[f64], den: &[f64], delay: f64, tick: f64) -> PlantResponse {
        let transfer = TransferFunction::new(num.to_vec(), den.to_vec()).unwrap();
        PlantResponse::new(Plant::held(&transfer, delay, tick).unwrap())
    }

    fn absolute(seen: &PlantResponse, is_pid: bool, limits: &Limits) -> Option<Controller> {
        let objective = Objective::AbsoluteError;
        best(seen, is_pid, limits, objective, Bounds::of(objective))
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
                let Some(found) = absolute(&seen, is_pid, &LIMITS) else {
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
            let found = absolute(&seen, is_pid, &limits).unwrap();
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
