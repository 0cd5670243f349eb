//! The delay's interval: the delays, longer and shorter, at which the model fits as well.
//!
//! With every delay all other parameters are fitted anew, the residual whitened by its autoregression; one whose sum of
//! squares S has `N ln(S / S_least)` above 3.84 lies outside the 95 % interval (profile likelihood; Wilks 1938). A
//! delay below 0 is tried as well: at one, the output moves before its input.

use crate::estimators::{Error, Estimate, NormalEquations, Search, radius_of_memory};
use crate::structure::Problem;
use planesman_record::Run;

/// 95 % and 99.9 % of the chi-squared distribution with one degree of freedom.
const WITHIN: f64 = 3.841_459;
const BEYOND_DOUBT: f64 = 10.827_566;
/// Samples by which a delay is moved at most, and by which the output may come before its input.
pub(crate) const FARTHEST: i64 = 20;
const EARLIEST: i64 = -10;

/// What the record says of the delay, samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lag {
    /// The delay that fits best.
    pub best: i64,
    /// The least and the greatest of the 95 % interval.
    pub interval: (i64, i64),
    /// Whether the best fits better than the model's own beyond doubt (99.9 %).
    pub is_another: bool,
}

/// The lag of a model of the output error, from the longest record it was fitted to.
pub(super) fn lag(found: &Estimate, problem: &Problem<'_>) -> Option<Lag> {
    let has_dead_time = found.process.is_some() || found.frequency.is_some();
    if found.error != Error::Output || found.physical.is_some() || has_dead_time {
        return None;
    }
    let one = Problem {
        runs: vec![*problem.runs.iter().max_by_key(|run| run.outputs.len())?],
        structure: found.layout.structure.clone(),
        sample_time: problem.sample_time,
    };
    let one = one.part().unwrap_or(one);
    let chosen = i64::try_from(one.structure.delay).ok()?;
    let poles = &found.theta.as_slice()[found.layout.a()];
    let whitening = {
        let equations = NormalEquations::new(&one, &[1.0]);
        equations.whitening(&equations.completed(poles, &equations.whole())?)
    };
    let last = one.runs[0]
        .outputs
        .len()
        .checked_sub(EARLIEST.unsigned_abs() as usize)?;
    let cost = |delay: i64| -> Option<f64> {
        if delay < EARLIEST {
            return None;
        }
        let (ahead, structure) = (delay.min(0).unsigned_abs() as usize, delay.max(0) as usize);
        let mut of = one.clone();
        of.structure.delay = structure;
        of.runs[0] = Run {
            inputs: &one.runs[0].inputs[ahead..last + ahead],
            outputs: &one.runs[0].outputs[..last],
            ..one.runs[0]
        };
        let equations = NormalEquations::new(&of, &whitening);
        let whole = equations.whole();
        let search = Search {
            steps: 20,
            enough: 1e-7,
            radius: radius_of_memory(last),
        };
        Some(
            equations
                .minimised(equations.completed(poles, &whole)?, &whole, search)?
                .1,
        )
    };
    profile(chosen, last, cost)
}

/// What so many samples say of the delay, by the sum of squares that the least error leaves of them at each: from the `chosen` one
/// on, to both sides, as far as there is one and it lies in the interval.
pub(crate) fn profile(
    chosen: i64,
    samples: usize,
    mut cost: impl FnMut(i64) -> Option<f64>,
) -> Option<Lag> {
    let own = cost(chosen)?;
    let worse = |cost: f64, than: f64| samples as f64 * libm::log(cost / than);
    let mut costs = vec![(chosen, own)];
    for step in [-1, 1] {
        let mut delay = chosen;
        loop {
            delay += step;
            if (delay - chosen).abs() > FARTHEST {
                break;
            }
            let Some(cost) = cost(delay) else {
                break;
            };
            let least = costs.iter().map(|it| it.1).fold(f64::INFINITY, f64::min);
            costs.push((delay, cost));
            if worse(cost, least) > WITHIN {
                break;
            }
        }
    }
    let (best, least) = costs.iter().copied().min_by(|p, q| p.1.total_cmp(&q.1))?;
    let within = || {
        costs
            .iter()
            .filter(|it| worse(it.1, least) <= WITHIN)
            .map(|it| it.0)
    };
    Some(Lag {
        best,
        interval: (within().min()?, within().max()?),
        is_another: worse(own, least) > BEYOND_DOUBT,
    })
}
