//! How the parameters of an estimator's recursive form developed.

use crate::estimators::Estimator;
use crate::structure::Problem;

/// Maximum number of samples of a trajectory, and of its stored points.
const WATCHED: usize = 10_000;
const POINTS: usize = 400;

/// Parameters over time, for a plot of the recursive estimation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectory {
    /// Parameter names: `a1`, `b1` and so on, or `K/J` and so on.
    pub names: Vec<String>,
    /// Time, s, and the parameters at that time.
    pub points: Vec<(f64, Vec<f64>)>,
}

impl Trajectory {
    /// Empty for an estimator without a recursive form.
    pub(super) fn of(estimator: &dyn Estimator, problem: &Problem<'_>) -> Self {
        let Ok(mut learner) = estimator.learner(problem) else {
            return Self::default();
        };
        let total: usize = problem.runs.iter().map(|run| run.outputs.len()).sum();
        let stride = total.min(WATCHED).div_ceil(POINTS).max(1);
        let samples = problem.runs.iter().flat_map(|run| {
            let before = std::iter::once(None).chain(run.inputs.iter().map(Some));
            before.zip(run.outputs)
        });
        let mut points = Vec::new();
        for (sample, (input, output)) in samples.take(WATCHED).enumerate() {
            match input {
                None => learner.begin(*output),
                Some(input) => learner.push(*input, *output),
            }
            if sample % stride == 0 {
                let learnt = learner.parameters().iter().copied().collect();
                points.push((sample as f64 * problem.sample_time, learnt));
            }
        }
        Self {
            names: learner.names(),
            points,
        }
    }
}
