//! Process models for step tests: the choice of the form, and whether it describes the record as well as a model with more parameters.
//!
//! A record with one or two steps cannot be divided well: half of it may have no step. So models are compared by the Bayesian criterion on
//! the whole record, for the whitened simulation errors,
//! ```text
//! BIC = N ln V + (p + k) ln N
//! ```
//! where V is the variance after an autoregression of order k, and p the number of all estimated values, including offset, dead time and
//! initial state. The fit is cross-validated over short parts of the record, a tenth left out at a time; a model with few parameters can
//! bridge them.

use planesman_linear::Complex;

use crate::error::{IdentificationError, Result};
use crate::estimators::{
    Begins, Estimate, Estimator, Form, Process, ProcessModel, whitened, whitening,
};
use crate::fit::{FitRange, fit};
use crate::structure::{InitialState, Problem, range};
use crate::uncertainty::{Reading, SIGMAS_95};
use planesman_parallel::on_all_cores;
use planesman_record::Run;

/// The criterion must be lower by at least this in two cases. The first is an initial state if the record may begin at rest, since soon after a
/// step the two look alike; the second is another model, which is the best of many (Kass and Raftery, *J. Amer. Statist. Assoc.* 90, 1995,
/// call it very strong evidence).
const BEYOND_DOUBT: f64 = 10.0;
/// The distance of a pole from z = 1, times the number of samples, up to which it may be an integrator.
const MEMORY: f64 = 2.0;
/// Cross-validated errors up to this many times those of another model, or of this many %, are hardly larger.
const HARDLY_MORE: f64 = 1.1;
const UNSEEN: f64 = 0.1;
/// Number of parts, left out one at a time.
const PARTS: usize = 10;
/// Maximum number of input changes in a step test.
const CHANGES: usize = 2;
/// A change from sample to sample of at least this share of the input's range is a step; smaller changes count as constant.
const STEPS: f64 = 0.05;
const STANDS: f64 = 0.1;

/// The forms tried if no form is named; real and complex poles belong to one family.
const FORMS: [Form; 4] = [
    Form::First,
    Form::Second,
    Form::Integrator,
    Form::IntegratorWithLag,
];

/// A form with its criterion.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The form.
    pub form: Form,
    /// Whether the records begin at rest.
    pub is_at_rest: bool,
    /// The number of all estimated values: parameters, offsets, initial states.
    pub parameters: usize,
    /// The Bayesian criterion.
    pub bic: f64,
}

/// The forms, best first, and the best one's estimator and estimate.
pub(crate) struct Chosen {
    pub(crate) candidates: Vec<Candidate>,
    pub(crate) estimator: Process,
    pub(crate) estimate: Estimate,
    /// The fit of simulations on the parts left out, %.
    pub(crate) fit: Option<f64>,
}

/// The best process model of some records, of a named form or of any. `stood` means that the output was constant until a step in records at rest, or
/// that the options say that it was at rest. For long records the form is chosen where the input varies most ([`Problem::part`]) and then fitted to all
/// samples; a step test is used as a whole.
///
/// # Errors
/// [`IdentificationError`]: records that determine none.
pub(crate) fn choose(problem: &Problem<'_>, named: Option<Form>, stood: bool) -> Result<Chosen> {
    let is_whole = stood || is_step_test(problem);
    let Some(part) = problem.part().filter(|_| !is_whole) else {
        return chosen(problem, named, stood);
    };
    let found = chosen(&part, named, false)?;
    let of_part = Process {
        begins: Begins::AsGiven,
        ..found.estimator
    };
    let estimate = of_part.fit(problem)?;
    Ok(Chosen {
        estimator: Process {
            near: estimate.process.clone(),
            ..of_part
        },
        estimate,
        ..found
    })
}

/// The best process model of all samples.
fn chosen(problem: &Problem<'_>, named: Option<Form>, stood: bool) -> Result<Chosen> {
    let forms: Vec<Process> = match named {
        Some(form) => vec![Process {
            is_named: true,
            ..Process::of(form)
        }],
        None => FORMS.map(Process::of).into(),
    };
    let of = |begins: Begins| {
        forms.iter().map(move |it| Process {
            begins,
            ..it.clone()
        })
    };
    let mut estimators: Vec<Process> = of(Begins::AsGiven).collect();
    if let Some(input) = rest_of(problem) {
        estimators.extend(of(Begins::AtRest(input)));
    }
    if stood {
        // A ramp that noise hides before the step grows all along the record.
        estimators.extend(of(Begins::InMotion).filter(|it| it.form.integrates()));
    }
    let may_rest = estimators.len() > forms.len();
    let tried = on_all_cores(&estimators, |it| {
        let estimate = it.fit(problem)?;
        let model = estimate.process.clone();
        let estimator = Process {
            form: model.as_ref().map_or(it.form, |model| model.form),
            near: model,
            ..it.clone()
        };
        let parameters = estimate.process.as_ref().map_or(0, |model| model.sought);
        let errors = errors(&estimate, &problem.runs, &vec![0; problem.runs.len()]);
        let candidate = Candidate {
            form: estimator.form,
            is_at_rest: estimate.layout.structure.start == InitialState::Rest,
            parameters,
            bic: criterion(&errors, parameters),
        };
        Ok((candidate, estimator, estimate))
    });
    let (mut found, mut reason) = (Vec::new(), None);
    for it in tried {
        match it {
            Ok(it) => found.push(it),
            Err(error) => reason = reason.or(Some(error)),
        }
    }
    let doubtful = |of: &Candidate| match may_rest && !of.is_at_rest {
        true => of.bic + BEYOND_DOUBT,
        false => of.bic,
    };
    // A time constant or a damping ratio that may be 0 is one too many.
    let is_determined = |of: &Estimate| {
        let mut named = of.process.iter().flat_map(ProcessModel::named);
        named.all(|(name, _, value, deviation)| {
            let may_be_none = name == "K" || name == "theta";
            may_be_none || value >= SIGMAS_95 * deviation
        })
    };
    found.sort_by(|p: &(Candidate, Process, Estimate), q| {
        let worse = |it: &(Candidate, _, Estimate)| (!is_determined(&it.2), doubtful(&it.0));
        let (p, q) = (worse(p), worse(q));
        p.0.cmp(&q.0).then(p.1.total_cmp(&q.1))
    });
    let candidates = found.iter().map(|it| it.0.clone()).collect();
    let Some((_, estimator, estimate)) = found.into_iter().next() else {
        return Err(reason.unwrap_or(IdentificationError::Undetermined(
            "the records determine no process model",
        )));
    };
    Ok(Chosen {
        fit: cross_validated(&estimator, problem),
        candidates,
        estimator,
        estimate,
    })
}

/// Whether a real pole of a model is at z = 1, or as near as records of that length can resolve: a memory of at least half the record.
#[must_use]
pub fn may_integrate(of: &Estimate) -> bool {
    slow_poles(of).iter().any(|z| z.im == 0.0)
}

/// The poles of a model that are as near to z = 1 as records of that length can resolve.
fn slow_poles(of: &Estimate) -> Vec<Complex<f64>> {
    let samples = of.residuals.iter().map(Vec::len).max().unwrap_or_default();
    let poles = Reading::new(of, 0).poles().unwrap_or_default();
    let distance = |z: &Complex<f64>| (1.0 - z).norm_sqr().sqrt() * samples as f64;
    let values = poles.iter().map(|it| it.value);
    values.filter(|z| distance(z) <= MEMORY).collect()
}

/// The best process model for a step test, or for records in which the other model may integrate, if its criterion is no worse than that of the other
/// model, and, except for a step test or an integrating process, its cross-validated errors are hardly larger; `other` has the other model and its cross-validated fit, %. If the other model surely integrates, or has a slow pair of poles instead of an integrator with a constant at its input, an integrating
/// process model must have a clearly better criterion: only process models have such a constant.
pub(crate) fn instead_of(
    problem: &Problem<'_>,
    other: Option<(&Estimate, f64)>,
    stood: bool,
) -> Option<Chosen> {
    let (other, other_fit) = other.unzip();
    let is_at_one = |of: &Estimate| of.layout.structure.known_denominator.len() > 1;
    let is_doubtful = other.is_some_and(|it| may_integrate(it) && !is_at_one(it));
    let is_asked = is_step_test(problem) || is_doubtful;
    if !is_asked && other.is_none_or(|it| slow_poles(it).is_empty()) {
        return None;
    }
    let chosen = choose(problem, None, stood).ok()?;
    if !is_asked && !chosen.estimator.form.integrates() {
        return None;
    }
    let Some(other) = other else {
        return Some(chosen);
    };
    // Of both the same samples count.
    let runs = &problem.runs;
    let lead: Vec<usize> = runs.iter().map(|run| other.unknown(*run)).collect();
    let of_chosen = criterion(
        &errors(&chosen.estimate, runs, &lead),
        chosen.candidates[0].parameters,
    );
    // Its delay was sought, too.
    let of_other = criterion(&errors(other, runs, &lead), other.theta.len() + 1);
    let allowed = match is_asked {
        true => of_other + BEYOND_DOUBT,
        false => of_other - BEYOND_DOUBT,
    };
    let missed = |fit: Option<f64>| fit.map_or(0.0, |fit| 100.0 - fit);
    let is_near = missed(chosen.fit) <= HARDLY_MORE * missed(other_fit).max(UNSEEN);
    let may_differ = is_step_test(problem) || chosen.estimator.form.integrates();
    (of_chosen <= allowed && (is_near || may_differ)).then_some(chosen)
}

/// The initial input of records that may begin at rest; it must be the same in all records, without earlier inputs.
fn rest_of(problem: &Problem<'_>) -> Option<f64> {
    let structure = &problem.structure;
    let first = *problem.runs.first()?.inputs.first()?;
    let all = |run: &Run<'_>| {
        run.past
            .iter()
            .chain(run.inputs.first())
            .all(|u| *u == first)
    };
    let may_rest = structure.start == InitialState::Estimated && structure.offset;
    (may_rest && problem.runs.iter().all(all)).then_some(first)
}

/// Whether the input of each record is constant except for one or two steps, and at least one input changes; before a record at rest it was
/// 0.
pub(crate) fn is_step_test(problem: &Problem<'_>) -> bool {
    let at_rest = problem.structure.start == InitialState::Rest;
    let first = |run: &Run<'_>| run.inputs.first().is_some_and(|u| at_rest && *u != 0.0);
    let runs = problem.runs.iter();
    let changes = runs.map(|run| Some(changes(run.inputs)?.len() + usize::from(first(run))));
    let changes: Option<Vec<usize>> = changes.collect();
    changes.is_some_and(|all| all.iter().any(|it| *it > 0) && all.iter().all(|it| *it <= CHANGES))
}

/// The first sample of the first step of a step test.
pub(crate) fn first_step(inputs: &[f64]) -> Option<usize> {
    let changes = changes(inputs).filter(|it| it.len() <= CHANGES)?;
    changes.first().copied()
}

/// The samples at which the steps of an input begin; `None` if it moves in between.
fn changes(inputs: &[f64]) -> Option<Vec<usize>> {
    let all = range(inputs);
    if all == 0.0 {
        return Some(Vec::new());
    }
    let moves = |k: usize| (inputs[k] - inputs[k - 1]).abs() > STEPS * all;
    let (mut steps, mut stands_from) = (Vec::new(), 0);
    for k in 1..inputs.len() {
        if !moves(k) {
            continue;
        }
        // A step may take several samples.
        if k == 1 || !moves(k - 1) {
            steps.push(k);
            if range(&inputs[stands_from..k]) > STANDS * all {
                return None;
            }
        }
        stands_from = k;
    }
    (range(&inputs[stands_from..]) <= STANDS * all).then_some(steps)
}

/// The errors of an estimate's simulation of each record, without the first samples.
fn errors(found: &Estimate, runs: &[Run<'_>], lead: &[usize]) -> Vec<Vec<f64>> {
    let of = |((number, run), lead): ((usize, &Run<'_>), &usize)| {
        let errors = found.simulation_errors(number, *run);
        errors.get(*lead..).unwrap_or_default().to_vec()
    };
    runs.iter().enumerate().zip(lead).map(of).collect()
}

/// The Bayesian criterion of errors.
fn criterion(errors: &[Vec<f64>], parameters: usize) -> f64 {
    let d = whitening(errors.iter().map(Vec::as_slice));
    let lead = d.len() - 1;
    let white = errors.iter().flat_map(|it| whitened(&d, it));
    let squares: Vec<f64> = white.map(|e| e * e).collect();
    let variance = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    let n = errors.iter().map(Vec::len).sum::<usize>().max(1) as f64;
    n * libm::log(variance.max(f64::MIN_POSITIVE)) + (parameters + lead) as f64 * libm::log(n)
}

/// The fit of simulations on the parts left out, %.
fn cross_validated(estimator: &Process, problem: &Problem<'_>) -> Option<f64> {
    let errors = estimator.left_out(problem, PARTS).ok()?;
    let squares: f64 = errors.iter().flatten().map(|e| e * e).sum();
    let spread = problem.runs.iter().map(|run| {
        let mut spread = FitRange::default();
        run.outputs.iter().for_each(|y| spread.update(*y, 1.0));
        spread.sum_of_squares()
    });
    fit(squares, spread.sum())
}
