//! A static curve before or after the linear dynamics, if the evidence suggests one.
//!
//! The cause found in the linear model's error ([`super::Analysis::finding`]) determines which curve is tried, unless the user chooses one. The
//! curve's parameters are fitted together with the dynamics. The curve is kept if it simulates the held-out data clearly better.

use super::curve::{
    CurveChoice, Front, SEARCHED, WORTH_A_TRY, clipped_at, dwelt_at, fitted, of_cause, of_inputs,
    problem,
};
use super::{Analysis, CurvePlacement, Options, Reason, USABLE, judged_on};
use crate::error::{IdentificationError, Result};
use crate::estimators::{Estimate, Estimator, LeastSquares, Method, Wiener, of_least_criterion};
use crate::static_curve::{Side, StaticCurve};
use crate::structure::{Problem, Structure};
use crate::validation::identifiability::Following;
use crate::validation::nonlinearity::Cause;
use planesman_record::{Record, Run};
use planesman_wording::setting;

/// Maximum order of the dynamics in the first search for a curve.
const SIMPLE: usize = 2;
/// A simulation whose error is at least this, %, is not usable.
const UNUSABLE: f64 = 100.0 - USABLE;
/// Maximum error of the held-out simulation with a curve, relative to the linear model's error.
const BETTER: f64 = 0.8;

/// The model between the first input and the first output of a record; a second input is the reference of the
/// loop they are in. If the options or the evidence suggest a static curve, it is fitted together with the dynamics.
///
/// # Errors
/// [`IdentificationError`]: a record without input or output, or one that determines no model asked for.
pub fn analyse(record: &Record, options: &Options) -> Result<Analysis> {
    analysed(record, options, None)
}

/// Analyses with a separate validation record on the same grid: the held-out fit and the predictions are computed on that record, and the model does
/// not use it.
///
/// # Errors
/// Same as [`analyse`]; also for a validation record without input or output, or with another sampling interval.
pub fn analyse_validated(
    record: &Record,
    options: &Options,
    validation: &Record,
) -> Result<Analysis> {
    analysed(record, options, Some(validation))
}

/// The analysis with the requested curve, or that of the linear model if no curve simulates better.
///
/// # Errors
/// Those of the linear analysis; of a curve that was asked for, its own.
fn analysed(record: &Record, options: &Options, validation: Option<&Record>) -> Result<Analysis> {
    let is_named = ![CurveChoice::Automatic, CurveChoice::None].contains(&options.curve);
    let linear = match is_named {
        true => judged_on(
            record,
            &for_structure(options),
            validation,
            CurvePlacement::None,
        )?,
        false => judged_on(record, options, validation, CurvePlacement::None)?,
    };
    let run = record.segments[linear.segments[linear.longest]].run();
    let Run {
        inputs, outputs, ..
    } = run.unwrap_or_default();
    match options.curve {
        CurveChoice::None => Ok(linear),
        CurveChoice::Automatic => {
            let attempts = match options.method {
                Method::Automatic => tried(&linear, inputs, outputs),
                _ => Vec::new(),
            };
            let missed = |it: &Analysis| it.held_out.fit.map(|fit| 100.0 - fit);
            let missed_in_all = |it: &Analysis| it.fit.map(|fit| 100.0 - fit);
            let is_better = |it: &Analysis, attempt: &Attempt| {
                let is_told = attempt.is_told;
                let is_exact = it.is_exact() && !it.is_step_test;
                let pair = match missed(it) {
                    Some(curved) => Some(curved).zip(missed(&linear)),
                    // The first part alone does not determine the curve.
                    None if is_told || is_exact => missed_in_all(it).zip(missed_in_all(&linear)),
                    None => None,
                };
                let is_better =
                    pair.is_some_and(|(curved, linear)| curved < BETTER * linear.min(UNUSABLE));
                let is_enough = is_told || it.curve_misses().is_none();
                is_better && is_enough && (is_exact || !attempt.must_be_exact)
            };
            let found = attempts.iter().filter_map(|attempt| {
                let found = beside(record, options, validation, &linear, attempt);
                let found = found.ok().filter(|it| is_better(it, attempt))?;
                let curve = found.curved.as_ref()?.fitted.curve.parameters().len();
                let parameters = found.estimate.theta.len() + curve;
                Some((parameters, found.estimate.residuals.concat(), found))
            });
            Ok(of_least_criterion(found.collect()).unwrap_or(linear))
        }
        choice => {
            let starts = choice.starts(match choice.side() {
                Side::Input => inputs,
                Side::Output => outputs,
            });
            if starts.is_empty() {
                return Err(IdentificationError::Option(format!(
                    "{}: the signal has too few distinct values for this curve",
                    setting("curve", choice.name())
                )));
            }
            let attempt = Attempt {
                side: choice.side(),
                starts,
                is_told: true,
                must_be_exact: false,
            };
            beside(record, options, validation, &linear, &attempt)
        }
    }
}

/// The options for a model that is needed only for its structure.
fn for_structure(options: &Options) -> Options {
    Options {
        bootstrap: None,
        ..options.clone()
    }
}

/// The curves to try on one side of the dynamics.
struct Attempt {
    side: Side,
    starts: Vec<StaticCurve>,
    /// Whether the linear model's error suggests these curves; if not, a curve must reduce the error to the noise.
    is_told: bool,
    /// Whether nothing suggests a curve: then it must leave nothing but rounding errors, because it may also describe a disturbance.
    must_be_exact: bool,
}

/// The curves worth trying: those of the cause that was found; and, if the noise would allow a better fit, limits at which the output dwells, and
/// input curves.
fn tried(linear: &Analysis, inputs: &[f64], outputs: &[f64]) -> Vec<Attempt> {
    let finding = linear.finding.as_ref();
    let large = finding.filter(|it| it.gain.is_some_and(|(share, _)| share > WORTH_A_TRY));
    let told = large.and_then(|it| of_cause(&it.cause, inputs, outputs));
    let is_told_of = |side: Side| told.as_ref().is_some_and(|it| it.0 == side);
    // In a loop the linear model's error may be noise that goes round.
    let is_asked = linear.is_below_noise() && linear.following != Following::Yes;
    let clipped = clipped_at(outputs).filter(|_| !linear.is_exact());
    let limits = clipped.or_else(|| dwelt_at(outputs).filter(|_| is_asked));
    let limits = limits.filter(|_| !is_told_of(Side::Output));
    let of_inputs = (is_asked && !is_told_of(Side::Input)).then(|| of_inputs(inputs).collect());
    let of_outputs = (is_asked && !is_told_of(Side::Output)).then(|| {
        let choices = [CurveChoice::OutputDeadZone, CurveChoice::OutputSaturation];
        choices.iter().flat_map(|it| it.starts(outputs)).collect()
    });
    let attempt = |is_told, must_be_exact| {
        move |(side, starts)| Attempt {
            side,
            starts,
            is_told,
            must_be_exact,
        }
    };
    let is_curve = |cause: &Cause| matches!(cause, Cause::Input(_) | Cause::Output(_));
    let may_be_curved = finding.is_some_and(|it| is_curve(&it.cause));
    let limits = limits.map(|it| (Side::Output, vec![it]));
    let of_inputs = of_inputs.map(|it| (Side::Input, it));
    let of_outputs = of_outputs.map(|it| (Side::Output, it));
    (told.into_iter().map(attempt(true, false)))
        .chain(limits.map(attempt(false, false)))
        .chain(of_inputs.map(attempt(false, false)))
        .chain(of_outputs.map(attempt(false, !may_be_curved)))
        .collect()
}

/// The structure for the first search for a curve: the linear model's, but with an order of at most 2, because a linear model of a curve has more
/// poles than the plant.
fn simple(linear: &Analysis) -> Structure {
    let own = &linear.estimate.layout.structure;
    match own.poles > SIMPLE && linear.options.order.is_none() {
        true => Structure {
            start: own.start,
            offset: own.offset,
            delay: own.delay.max(1),
            ..linear.options.structure(SIMPLE)
        },
        false => own.clone(),
    }
}

fn beside(
    record: &Record,
    options: &Options,
    validation: Option<&Record>,
    linear: &Analysis,
    attempt: &Attempt,
) -> Result<Analysis> {
    let mut found = match attempt.side {
        Side::Input => hammerstein(record, options, validation, linear, attempt)?,
        Side::Output => wiener(record, options, validation, linear, &attempt.starts)?,
    };
    if let Some(curved) = &mut found.curved {
        curved.linear_fit = linear.held_out.fit;
        let reason = Reason::Curve(curved.clone());
        found.reasons.insert(0, reason);
    }
    Ok(found)
}

/// Alternates between curve and dynamics: chooses order and delay of the dynamics again after the curve, then refits the curve before these dynamics.
fn hammerstein(
    record: &Record,
    options: &Options,
    validation: Option<&Record>,
    linear: &Analysis,
    attempt: &Attempt,
) -> Result<Analysis> {
    let of = |structure: &Structure, starts: &[StaticCurve]| {
        fitted(record, structure, starts, attempt.is_told)
    };
    let first = of(&simple(linear), &attempt.starts)?.curve;
    let behind = first.of_input(record);
    let behind = judged_on(&behind, &for_structure(options), None, CurvePlacement::None)?;
    let curve = of(&behind.estimate.layout.structure, &[first])?;
    let through = curve.curve.of_input(record);
    let validation = validation.map(|it| curve.curve.of_input(it));
    let front = Front {
        record,
        curve: &curve,
    };
    judged_on(
        &through,
        options,
        validation.as_ref(),
        CurvePlacement::AtInput(front),
    )
}

/// The structure of dynamics in front of a curve: the levels of a dead zone take the place of an offset of the signal in front.
fn before(curve: &StaticCurve, of: &Structure) -> Structure {
    let is_dead_zone = matches!(curve, StaticCurve::DeadZone { .. });
    Structure {
        offset: of.offset && !is_dead_zone,
        ..of.clone()
    }
}

/// Chooses order and delay of the dynamics for the outputs before the curve, as estimated by a first model.
fn wiener(
    record: &Record,
    options: &Options,
    validation: Option<&Record>,
    linear: &Analysis,
    starts: &[StaticCurve],
) -> Result<Analysis> {
    let poles = |of: &Estimate| of.theta.as_slice()[of.layout.a()].to_vec();
    let none = IdentificationError::Search("the search for the curve found no minimum");
    let nearest = |problem: &Problem<'_>, begin: &[f64], starts: &[StaticCurve]| {
        let runs = problem.runs.iter();
        let signal: Vec<f64> = runs.flat_map(|it| it.outputs).copied().collect();
        let fitted = starts.iter().filter_map(|start| {
            let estimator = Wiener {
                start: start.clone(),
                poles: begin.to_vec(),
            };
            let problem = Problem {
                structure: before(start, &problem.structure),
                ..problem.clone()
            };
            let found = estimator.fit(&problem).ok()?;
            let curve = found.output_curve.as_ref()?;
            let parameters = curve.curve.parameters().len();
            let is_determined = curve.is_determined(&signal);
            is_determined.then_some((parameters, found.residuals.concat(), found))
        });
        of_least_criterion(fitted.collect()).ok_or(none.clone())
    };
    let of_structure = |structure: &Structure| {
        let all = problem(record, structure)?;
        let begin = match linear.estimate.layout.structure == *structure {
            true => poles(&linear.estimate),
            false => poles(&LeastSquares.fit(&all)?),
        };
        let first = match starts {
            [_] => nearest(&all, &begin, starts)?,
            // Which of them, a part of the record tells.
            _ => {
                let of_part = nearest(&all.last_samples(SEARCHED), &begin, starts)?;
                let curve = of_part.output_curve.map(|it| it.curve);
                nearest(&all, &begin, &curve.into_iter().collect::<Vec<_>>())?
            }
        };
        Ok((all, first))
    };
    // Without noise the right curve leaves nothing for more poles than the plant's.
    let structure = simple(linear);
    let (all, mut first) =
        of_structure(&structure).or_else(|error: IdentificationError| match structure.poles {
            0 | 1 => Err(error),
            _ if linear.options.order.is_some() => Err(error),
            _ => of_structure(&linear.options.structure(1)),
        })?;
    let start = first.output_curve.take().ok_or(none.clone())?.curve;
    let start = start.normalised();
    let simulated: Vec<_> = (all.runs.iter().enumerate())
        .map(|(number, run)| first.simulate(number, *run))
        .collect();
    let outputs = Wiener::in_front_of(&start, &all.runs, &simulated);
    let mut in_front = record.clone();
    for (number, outputs) in linear.segments.iter().zip(outputs) {
        if let Some(first) = in_front.segments[*number].outputs.first_mut() {
            *first = outputs;
        }
    }
    let chosen = judged_on(
        &in_front,
        &for_structure(options),
        None,
        CurvePlacement::None,
    )?
    .estimate;
    // What the outputs in front of the curve owe to the first model does not ask for fewer poles: the curve's own criterion does.
    let most = chosen.layout.structure.poles;
    let orders = match options.order {
        Some(_) => most..=most,
        None => 1.min(most)..=most,
    };
    let of_orders = orders.filter_map(|order| {
        let structure = Structure {
            poles: order,
            numerator: chosen.layout.structure.numerator.min(order.max(1)),
            ..before(&start, &chosen.layout.structure)
        };
        let estimator = Wiener {
            poles: poles(&chosen),
            start: start.clone(),
        };
        let found = estimator.fit(&problem(record, &structure).ok()?).ok()?;
        let estimator = Wiener {
            poles: poles(&found),
            ..estimator
        };
        Some((
            found.theta.len(),
            found.residuals.concat(),
            (structure, estimator),
        ))
    });
    let (structure, estimator) = of_least_criterion(of_orders.collect()).ok_or(
        IdentificationError::Search("the search for the curve found no minimum"),
    )?;
    judged_on(
        record,
        options,
        validation,
        CurvePlacement::AtOutput(structure, estimator),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{analyse, analyse_validated};
    use crate::comparison::GivenModel;
    use planesman_parallel::on_all_cores;
    use planesman_record::{filter, noise};

    const SAMPLES: usize = 600;
    const A: [f64; 3] = [1.0, -1.6, 0.68];
    const GAIN: f64 = 0.08;

    /// Levels of -2 to 2, held for 5 to 30 samples.
    fn levels(seed: u32) -> Vec<f64> {
        let random = noise(seed, SAMPLES);
        let mut input = Vec::new();
        for pair in random.chunks(2) {
            let long = 5 + (pair[1].abs() * 10.0) as usize;
            input.extend(std::iter::repeat_n(1.2 * pair[0].clamp(-1.7, 1.7), long));
        }
        input.truncate(SAMPLES);
        input
    }

    /// `y = f(G u) + noise` or `y = G f(u) + noise`, G of second order with the gain 1.
    fn record(seed: u32, side: Side, curve: &StaticCurve) -> Record {
        let input = levels(seed);
        let linear = |u: &[f64]| filter(&[0.0, GAIN], &A, u);
        let output = match side {
            Side::Input => linear(&curve.of(&input)),
            Side::Output => curve.of(&linear(&input)),
        };
        let output = output.iter().zip(noise(seed + 50, SAMPLES));
        let output = output.map(|(y, e)| y + 0.02 * e).collect();
        Record::of_run(0.1, vec![("u", input)], vec![("y", output)]).unwrap()
    }

    fn all() -> Vec<(Side, StaticCurve, CurveChoice)> {
        let dead_zone = StaticCurve::DeadZone {
            lower: -0.6,
            upper: 0.4,
        };
        let saturation = StaticCurve::Saturation {
            lower: Some(-0.8),
            upper: Some(0.7),
        };
        let bent = StaticCurve::Piecewise {
            levels: vec![0.4],
            slopes: vec![1.0, 0.3],
        };
        let square = StaticCurve::Square { linear: None };
        let backlash = StaticCurve::Backlash { width: 0.8 };
        vec![
            (Side::Input, dead_zone.clone(), CurveChoice::DeadZone),
            (Side::Input, saturation.clone(), CurveChoice::Saturation),
            (Side::Input, square, CurveChoice::Square),
            (Side::Input, backlash, CurveChoice::Backlash),
            (Side::Input, bent.clone(), CurveChoice::Piecewise),
            (Side::Output, saturation, CurveChoice::OutputSaturation),
            (Side::Output, dead_zone, CurveChoice::OutputDeadZone),
            (Side::Output, bent, CurveChoice::OutputPiecewise),
        ]
    }

    #[test]
    fn a_curve_is_found_by_default_with_intervals_that_hold_it_and_judges_other_data() {
        on_all_cores(&all(), |(side, curve, _)| {
            let (side, curve) = (*side, curve.clone());
            let (first, second) = (record(3, side, &curve), record(8, side, &curve));
            let found = analyse_validated(&first, &Options::default(), &second).unwrap();
            let curved = found.curved.as_ref().unwrap();
            assert_eq!(curved.side, side, "{curve:?}");
            assert_eq!(curved.fitted.curve.name(), curve.name());
            let pairs = curved.fitted.named().zip(curve.parameters());
            for ((name, value, deviation), (_, truth)) in pairs {
                let told = format!("{name} {value} {deviation} {curve:?}");
                assert!((value - truth).abs() < 3.5 * deviation, "{told}");
                assert!(deviation < 0.02, "{told}");
            }
            let gain = found.reading().steady_state_gain().unwrap();
            let (value, deviation) = (gain.value.re, gain.real_deviation());
            let told = format!("{value} {deviation} {curve:?}");
            assert!((value - 1.0).abs() < 3.5 * deviation, "{told}");
            let (held, linear) = (found.held_out.fit.unwrap(), curved.linear_fit.unwrap());
            assert!(held > 90.0 && linear < 85.0, "{held} {linear} {curve:?}");
            let given = GivenModel {
                curve: Some((side, curved.fitted.curve.clone())),
                ..GivenModel::new(&found.estimate, 0)
            };
            let judged = given.on(&second, &[1]).unwrap().fit.unwrap();
            assert!((judged - held).abs() < 0.1, "{judged} {held} {curve:?}");
            let run = first.segments[0].run().unwrap();
            let simulated = found.simulate(0, run);
            let missed: f64 = (run.outputs.iter().zip(simulated).skip(5))
                .map(|(y, x)| (y - x).powi(2))
                .sum();
            let rms = (missed / SAMPLES as f64).sqrt();
            assert!((rms - 0.02).abs() < 0.003, "{rms} {curve:?}");
        });
    }

    #[test]
    fn a_curve_that_is_asked_for_is_sought_from_levels_of_its_own() {
        for (side, curve, choice) in all().into_iter().step_by(2) {
            let options = Options {
                curve: choice,
                order: Some(2),
                delay: Some(1),
                ..Options::default()
            };
            let found = analyse(&record(5, side, &curve), &options).unwrap();
            assert!(
                found.held_out.fit.unwrap() > 90.0,
                "{curve:?} {:?}",
                found.curved
            );
        }
    }

    #[test]
    fn a_linear_plant_has_no_curve_and_neither_has_one_without_levels() {
        let straight = StaticCurve::Piecewise {
            levels: Vec::new(),
            slopes: vec![1.0],
        };
        let linear = record(4, Side::Input, &straight);
        assert_eq!(analyse(&linear, &Options::default()).unwrap().curved, None);
        let none = Options {
            curve: CurveChoice::None,
            ..Options::default()
        };
        let (side, curve, _) = &all()[0];
        let found = analyse(&record(3, *side, curve), &none).unwrap();
        assert!(found.curved.is_none() && found.finding.is_some());
        let mut two = linear;
        let input = &mut two.segments[0].inputs[0];
        input.iter_mut().for_each(|u| *u = u.signum());
        let dead_zone = Options {
            curve: CurveChoice::Saturation,
            ..Options::default()
        };
        let refusal = analyse(&two, &dead_zone).map(drop);
        assert!(refusal.is_err(), "two levels tell of no curve");
    }
}
