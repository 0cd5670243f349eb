//! Output error: the parameters with which the simulated outputs fit the measured ones best.
//!
//! ```text
//! V = sum over outputs  |y - yhat(p, x0)|^2 / noise^2
//! ```
//! Gauss-Newton steps with Marquardt's damping, limited to the bounds ([`Problem`]); from several starts if parameters have both bounds.
//! The covariance allows for residuals of any colour, separately for each output.

use nalgebra::{DMatrix, DVector};
use planesman_identification::analysis::{GOOD, SAMPLES_PER_PARAMETER, USABLE, Verdict};
use planesman_identification::{FitRange, fit as fit_percent};
use planesman_text::setting;

use crate::determined::{Uncertainty, Undetermined};
use crate::error::EquationsError;
use crate::model::{Equations, Unknown};
use crate::problem::Problem;
use crate::simulation::{Run, Unfinished, initial_states};

/// Largest number of updates of the weights, for outputs whose noise is not given.
const WEIGHINGS: usize = 4;
/// The share of a record that is fitted if the rest is used for validation.
pub(crate) const FITTED: f64 = 0.7;
/// Two searches have found the same minimum if their final costs differ by at most this share.
const SAME: f64 = 1e-3;
/// A message is printed if the residual exceeds the given noise by this factor.
const MORE_THAN_NOISE: f64 = 1.5;
/// If the residual is at least this share of an output's motion, the output is reported to be within the noise.
const WITHIN_NOISE: f64 = 0.9;
/// Correlations of two parameters above this are reported.
const CORRELATED: f64 = 0.99;

/// An estimated parameter or initial state.
#[derive(Clone, Debug)]
pub struct EstimatedParameter {
    /// The estimated quantity.
    pub unknown: Unknown,
    /// Its value.
    pub value: f64,
    /// The parameter's standard deviation; `None` if the data does not determine the parameter, or the parameter is at a bound.
    pub deviation: Option<f64>,
    /// Whether the parameter is at one of its bounds.
    pub is_at_bound: bool,
}

/// The fit of an output.
#[derive(Clone, Debug)]
pub struct OutputFit {
    /// Its name.
    pub name: String,
    /// The fit on all data, %.
    pub fit: Option<f64>,
    /// The fit on data not used for fitting, %.
    pub held_out_fit: Option<f64>,
    /// Root mean square of the residual, output unit.
    pub left: f64,
    /// The given noise.
    pub noise: Option<f64>,
    /// Samples.
    pub samples: usize,
}

/// Equations fitted to data.
#[derive(Clone, Debug)]
pub struct EquationsFit {
    /// The equations.
    pub equations: Equations,
    /// The parameters.
    pub parameters: Vec<EstimatedParameter>,
    /// The estimated initial states of each run.
    pub initial: Vec<Vec<EstimatedParameter>>,
    /// The parameters' correlation matrix; 0 for parameters without a deviation.
    pub correlation: DMatrix<f64>,
    /// Each output.
    pub outputs: Vec<OutputFit>,
    /// Parameters that the data does not determine.
    pub undetermined: Vec<Undetermined>,
    /// The number of searches that ended at the smallest cost, and of all searches.
    pub searches: (usize, usize),
    /// The simulated outputs of each run.
    pub simulated: Vec<Vec<Vec<f64>>>,
    /// Whether separate validation data was given.
    pub is_validated: bool,
    /// The findings, in sentences.
    pub reasons: Vec<String>,
    /// The verdict.
    pub verdict: Verdict,
}

pub(crate) fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|it| it * it).sum::<f64>() / values.len().max(1) as f64
}

/// The fit, %, of an output on data not used for fitting; `None` if the output moves there by hardly more than the residual `left` elsewhere.
pub(crate) fn informative<'a>(
    left: f64,
    runs: impl Iterator<Item = (&'a [f64], &'a [f64])> + Clone,
) -> Option<f64> {
    let (mut squares, mut count) = (0.0, 0.0);
    for (measured, _) in runs.clone() {
        let mut of = FitRange::default();
        measured.iter().for_each(|y| of.update(*y, 1.0));
        squares += of.sum_of_squares();
        count += measured.len() as f64;
    }
    let moves = left < WITHIN_NOISE * (squares / count).sqrt();
    fit_of(runs).filter(|_| moves)
}

/// The fit, %, of an output over runs, each relative to its own mean: measured and simulated values.
pub(crate) fn fit_of<'a>(runs: impl Iterator<Item = (&'a [f64], &'a [f64])>) -> Option<f64> {
    let (mut errors, mut spread) = (0.0, 0.0);
    for (measured, simulated) in runs {
        let mut of = FitRange::default();
        for (y, x) in measured.iter().zip(simulated) {
            of.update(*y, 1.0);
            errors += (y - x) * (y - x);
        }
        spread += of.sum_of_squares();
    }
    fit_percent(errors, spread)
}

/// Fits the equations to runs. The result is validated on `validation`, with an initial state estimated for each run; without separate data, a model of
/// the first 70 % of each run is validated on the rest.
///
/// # Errors
/// [`EquationsError`]: equations without a number at the start, too little data, parameters that change nothing.
pub fn fit(
    equations: &Equations,
    runs: &[Run],
    validation: &[Run],
) -> Result<EquationsFit, EquationsError> {
    let samples: usize = runs.iter().map(Run::samples).sum();
    let weights = first_weights(equations, runs)?;
    let mut problem = Problem::new(equations, runs, weights);
    let sought = problem.sought.len();
    if samples <= sought {
        return Err(EquationsError::TooFew { samples, sought });
    }
    let starts = problem.starts();
    if let Some(run) = runs.first() {
        check_start(equations, run, &problem.sought)?;
    }
    let mut tried: Vec<Option<(DVector<f64>, f64)>> = starts
        .iter()
        .map(|start| problem.minimised(start.clone()))
        .collect();
    let grown = starts.first().and_then(|start| problem.grown(start));
    tried.push(grown.and_then(|start| problem.minimised(start)));
    let begun = tried.len();
    let mut ends: Vec<(DVector<f64>, f64)> = tried.into_iter().flatten().collect();
    ends.sort_by(|p, q| p.1.total_cmp(&q.1));
    let Some((mut theta, cost)) = ends.first().cloned() else {
        let at = named(&problem.sought, &starts[0]);
        return Err(match problem.simulated(&starts[0], true) {
            Err(Unfinished { time, stiff }) => EquationsError::Unfinished { time, stiff, at },
            Ok(_) => EquationsError::NotFinite {
                entry: "the residual of the outputs".to_owned(),
                when: "at the start".to_owned(),
                at,
            },
        });
    };
    let same = ends.iter().filter(|it| it.1 <= (1.0 + SAME) * cost).count();
    let free: Vec<usize> = (0..equations.outputs.len())
        .filter(|it| equations.outputs[*it].noise.is_none())
        .collect();
    let left = |problem: &Problem<'_>, theta: &DVector<f64>| {
        let of = problem.by_output(theta).ok_or(EquationsError::NoEffect)?;
        let left = of.iter().map(|it| mean_square(&it.0.concat()).sqrt());
        Ok::<Vec<f64>, EquationsError>(left.collect())
    };
    for _ in 0..WEIGHINGS {
        if free.is_empty() || equations.outputs.len() == 1 {
            break;
        }
        let found = left(&problem, &theta)?;
        let mut moved = 0.0_f64;
        for output in &free {
            let weight = 1.0 / found[*output].max(1e-12 / problem.weights[*output]);
            moved = moved.max(libm::log(weight / problem.weights[*output]).abs());
            problem.weights[*output] = weight;
        }
        if moved < 0.01 {
            break;
        }
        theta = problem.minimised(theta.clone()).map_or(theta, |it| it.0);
    }
    let left = left(&problem, &theta)?;
    let held_out = held_out(&problem, runs, validation, &theta, &left);
    judged(
        &problem,
        theta,
        held_out,
        (same, begun),
        !validation.is_empty(),
    )
}

/// The inverse noise of each output, or its inverse standard deviation.
fn first_weights(equations: &Equations, runs: &[Run]) -> Result<Vec<f64>, EquationsError> {
    let outputs = equations.outputs.iter().enumerate();
    let weight = |(output, of): (usize, &crate::model::OutputEquation)| {
        let mut spread = FitRange::default();
        let values = runs.iter().flat_map(|it| &it.outputs[output].values);
        let mut count = 0.0;
        values.for_each(|value| {
            spread.update(*value, 1.0);
            count += 1.0;
        });
        let deviation = (spread.sum_of_squares() / count).sqrt();
        match of.noise {
            Some(noise) => Ok(1.0 / noise),
            None if deviation > 0.0 => Ok(1.0 / deviation),
            None => Err(EquationsError::Constant(of.name.clone())),
        }
    };
    outputs.map(weight).collect()
}

fn named(sought: &[Unknown], theta: &DVector<f64>) -> String {
    let each = sought.iter().zip(theta.iter());
    let each = each
        .take(12)
        .map(|(of, value)| format!("{} = {value}", of.name));
    each.collect::<Vec<_>>().join(", ")
}

/// Refuses equations whose value is not finite at the start of the search and of the first run.
fn check_start(equations: &Equations, run: &Run, sought: &[Unknown]) -> Result<(), EquationsError> {
    let starts: Vec<f64> = sought.iter().map(|it| it.start).collect();
    let parameters = equations.unknowns.len();
    let mut variables = run.inputs_at(0.0);
    let (of_model, of_run) = starts.split_at(parameters);
    let states = initial_states(equations, of_model, of_run, run);
    variables.extend(states);
    variables.extend(&starts[..parameters]);
    variables.push(0.0);
    equations.check_finite(&variables)
}

/// The fit of each output on data not used for fitting, %.
fn held_out(
    problem: &Problem<'_>,
    runs: &[Run],
    validation: &[Run],
    theta: &DVector<f64>,
    left: &[f64],
) -> Vec<Option<f64>> {
    let equations = problem.equations;
    let outputs = 0..equations.outputs.len();
    let none = || outputs.clone().map(|_| None).collect();
    let parameters = equations.unknowns.len();
    if validation.is_empty() {
        let cuts: Vec<f64> = runs.iter().map(|it| FITTED * it.end()).collect();
        let first: Vec<Run> = runs
            .iter()
            .zip(&cuts)
            .map(|(it, cut)| it.until(*cut))
            .collect();
        let of = Problem::new(equations, &first, problem.weights.clone());
        if first.iter().map(Run::samples).sum::<usize>() <= of.sought.len() {
            return none();
        }
        let Some((theta, _)) = of.minimised(theta.clone()) else {
            return none();
        };
        let whole = Problem::new(equations, runs, problem.weights.clone());
        let Ok(simulated) = whole.simulated(&theta, false) else {
            return none();
        };
        let of = |output: usize| {
            let each = runs.iter().zip(&simulated).zip(&first);
            informative(
                left[output],
                each.map(|((run, simulated), first)| {
                    let from = first.outputs[output].times.len();
                    (
                        &run.outputs[output].values[from..],
                        &simulated[output].values[from..],
                    )
                }),
            )
        };
        return outputs.map(of).collect();
    }
    // Only the initial states are found anew.
    let mut known = equations.clone();
    for (unknown, value) in known.unknowns.iter_mut().zip(theta.iter()) {
        unknown.start = *value;
        unknown.bounds = (*value, *value);
    }
    let of = Problem::new(&known, validation, problem.weights.clone());
    let start = DVector::from_iterator(of.sought.len(), of.sought.iter().map(|it| it.start));
    let found = match of.sought.len() > parameters {
        true => of.minimised(start).map(|it| it.0),
        false => Some(start),
    };
    let Some(simulated) = found.and_then(|theta| of.simulated(&theta, false).ok()) else {
        return none();
    };
    let of = |output: usize| {
        let each = validation.iter().zip(&simulated);
        informative(
            left[output],
            each.map(|(run, of)| (&run.outputs[output].values[..], &of[output].values[..])),
        )
    };
    outputs.map(of).collect()
}

/// Uncertainty, fits and verdict at the minimum.
fn judged(
    problem: &Problem<'_>,
    theta: DVector<f64>,
    held_out: Vec<Option<f64>>,
    searches: (usize, usize),
    is_validated: bool,
) -> Result<EquationsFit, EquationsError> {
    let equations = problem.equations;
    let by_output = problem.by_output(&theta).ok_or(EquationsError::NoEffect)?;
    let known = Uncertainty::of(problem, &theta, &by_output)?;
    let covariance = &known.covariance;
    let found = |i: usize| EstimatedParameter {
        unknown: problem.sought[i].clone(),
        value: theta[i],
        deviation: known
            .determines(i)
            .then(|| covariance[(i, i)].max(0.0).sqrt()),
        is_at_bound: problem.is_at_bound(&theta, i),
    };
    let parameters = equations.unknowns.len();
    let correlation = DMatrix::from_fn(parameters, parameters, |i, j| {
        let scale = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        match known.determines(i) && known.determines(j) && scale > 0.0 {
            true => covariance[(i, j)] / scale,
            false => 0.0,
        }
    });
    let simulated = problem
        .simulated(&theta, false)
        .map_err(|_| EquationsError::NoEffect)?;
    let simulated: Vec<Vec<Vec<f64>>> = simulated
        .into_iter()
        .map(|it| it.into_iter().map(|of| of.values).collect())
        .collect();
    let outputs = equations.outputs.iter().enumerate().map(|(output, of)| {
        let each = problem.runs.iter().zip(&simulated);
        let each = each.map(|(run, x)| (&run.outputs[output].values[..], &x[output][..]));
        OutputFit {
            name: of.name.clone(),
            fit: fit_of(each),
            held_out_fit: held_out[output],
            left: mean_square(&by_output[output].0.concat()).sqrt(),
            noise: of.noise,
            samples: by_output[output].1.nrows(),
        }
    });
    let mut result = EquationsFit {
        equations: equations.clone(),
        parameters: (0..parameters).map(found).collect(),
        initial: (0..problem.runs.len())
            .map(|run| {
                problem.places(run)[parameters..]
                    .iter()
                    .map(|it| found(*it))
                    .collect()
            })
            .collect(),
        correlation,
        outputs: outputs.collect(),
        undetermined: known.undetermined(problem, &theta),
        searches,
        simulated,
        is_validated,
        reasons: Vec::new(),
        verdict: Verdict::Good,
    };
    let rows = by_output.iter().map(|it| it.1.nrows()).sum();
    result.judge(rows, theta.len());
    Ok(result)
}

/// A verdict with the next step: `good` for a good model, `bad` otherwise.
pub(crate) fn verdict_text(verdict: Verdict, good: String, bad: String) -> String {
    verdict.text(match verdict {
        Verdict::Good | Verdict::Usable => good,
        Verdict::Unusable => bad,
        _ => verdict.next(),
    })
}

impl EquationsFit {
    /// The verdict, and the next step with equations.
    #[must_use]
    pub fn verdict_text(&self) -> String {
        verdict_text(
            self.verdict,
            format!(
                "write the fitted parameters to a file with {}, and plots of the fit with {}",
                setting("model", "fitted.yaml"),
                setting("html", "fit.html")
            ),
            format!(
                "look at the plots to see where the fit fails: {}. Either the equations lack something, or the search ended at a wrong minimum. Give the parameters min and max, so that several searches begin between these bounds",
                setting("html", "fit.html")
            ),
        )
    }

    /// Sets reasons and verdict.
    fn judge(&mut self, rows: usize, sought: usize) {
        let mut reasons = Vec::new();
        let is_few = rows < SAMPLES_PER_PARAMETER * sought;
        if is_few {
            reasons.push(format!(
                "{rows} samples for {sought} parameters and initial states"
            ));
        }
        match self.searches {
            (same, begun) if same == begun => {}
            (same, begun) => reasons.push(format!(
                "{same} of {begun} searches ended at this minimum: one began at the start values, one also began there but with growing parts of the data{}",
                if begun > 2 {
                    ", the others began between the bounds"
                } else {
                    ""
                }
            )),
        }
        for of in &self.outputs {
            let held = of
                .held_out_fit
                .map_or("none".to_owned(), |it| format!("{it:.1} %"));
            let on = match self.is_validated {
                true => "on the validation data, with only the initial states fitted to them",
                false => "on the last 30 % of the data, by a model of the first 70 %",
            };
            reasons.push(format!("{}: simulated fit {held} {on}", of.name));
            if let Some(noise) = of.noise.filter(|it| of.left > MORE_THAN_NOISE * it) {
                reasons.push(format!(
                    "{}: the residual is {:.1} times the given noise, so either the equations lack something, or the noise is larger",
                    of.name,
                    of.left / noise
                ));
            }
        }
        reasons.extend(self.undetermined.iter().map(ToString::to_string));
        let all = self.parameters.iter().chain(self.initial.iter().flatten());
        let at_bound = all.filter(|it| it.is_at_bound);
        reasons.extend(at_bound.map(|it| {
            format!(
                "{} is at its bound {}. Widen the bound, or fix the parameter at this value",
                it.unknown.name, it.value
            )
        }));
        for i in 0..self.parameters.len() {
            for j in 0..i {
                let of = self.correlation[(i, j)];
                if of.abs() > CORRELATED {
                    let names = [j, i].map(|it| &self.parameters[it].unknown.name);
                    reasons.push(format!(
                        "{} and {} can hardly be estimated separately, because their estimates have a correlation of {of:.4}",
                        names[0], names[1]
                    ));
                }
            }
        }
        let held = self.outputs.iter().map(|it| it.held_out_fit);
        let held = held.reduce(|a, b| Some(a?.min(b?))).flatten();
        let is_determined = self.undetermined.is_empty();
        self.verdict = match held {
            None => Verdict::NotValidated,
            Some(_) if is_few => Verdict::FewSamples,
            Some(held) if held < USABLE => Verdict::Unusable,
            Some(_) if !is_determined => Verdict::ParametersUndetermined,
            Some(held) if held < GOOD => Verdict::Usable,
            Some(_) => Verdict::Good,
        };
        self.reasons = reasons;
    }
}
