//! The analysis of a record with several inputs: the choice of the channels, the fit, tests and a verdict, of one output.

use planesman_record::{Record, Segment, StraightLine};

use super::delays::lags;
use super::estimate::{Fitted, InUnits};
use super::excitation::{Own, own};
use super::finding::Finding;
use super::layout::Channel;
use super::scaled::{Scaled, used};
use super::selection::{Asked, Candidate, Chooser, Effect};
use crate::analysis::{Lag, Verdict};
use crate::error::{IdentificationError, Result};
use crate::estimators::{Estimate, radius_of_memory};
use crate::fit::fit;
use crate::free_motion::without_free_motion;
use crate::selection::Kind;
use crate::selection::criteria::FITTED_SHARE;
use crate::structure::{InitialState, PART, range, variance};
use crate::uncertainty::Reading;
use crate::validation::residuals::ResidualTests;

/// Samples at the beginning in which an input may move and be at rest for all that: no more than a motion at the
/// beginning accounts for.
const FIRST: usize = 2;

/// Options of the analysis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The order of every channel; `None` for each to have its own.
    pub order: Option<usize>,
    /// The delay of every channel, samples; `None` for each to have its own.
    pub delay: Option<usize>,
    /// Output error or Box-Jenkins; `None` for cross-validation to choose.
    pub kind: Option<Kind>,
    /// Seek an offset of the output.
    pub offset: bool,
    /// How each segment begins.
    pub start: InitialState,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            order: None,
            delay: None,
            kind: None,
            offset: true,
            start: InitialState::Estimated,
        }
    }
}

/// The transfer function of an input that does something.
#[derive(Clone, Debug)]
pub struct ChannelModel {
    /// Its parameters, their covariance with those of the other channels; no offset.
    pub estimate: Estimate,
    /// What the longest run says of its delay.
    pub lag: Option<Lag>,
    /// The residual against its input, of the longest run.
    pub residuals: Option<ResidualTests>,
}

impl ChannelModel {
    /// Poles, gain and responses.
    #[must_use]
    pub fn reading(&self) -> Reading<'_> {
        Reading::new(&self.estimate, 0)
    }

    /// Its delay, samples.
    #[must_use]
    pub fn delay(&self) -> usize {
        self.estimate.layout.structure.delay
    }
}

/// What was found of an input.
#[derive(Clone, Debug)]
pub struct InputFindings {
    /// Its name.
    pub name: String,
    /// Whether it does anything.
    pub effect: Effect,
    /// What of it the other inputs do not explain.
    pub own: Own,
    /// What it does; `None` where that is nothing.
    pub model: Option<ChannelModel>,
}

/// A model of one output and what there is to know of it.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The options it was made with.
    pub options: Options,
    /// The output's name.
    pub output: String,
    /// Every input.
    pub inputs: Vec<InputFindings>,
    /// Output error, or Box-Jenkins.
    pub kind: Kind,
    /// The interval between samples, s.
    pub sample_time: f64,
    /// The offset of each run, with every input at its level.
    pub offsets_at_level: Vec<f64>,
    /// The noise's variance, output unit squared.
    pub noise_variance: f64,
    /// `d1 ... dk` of the noise `e/D` on the output; empty for white noise.
    pub noise_denominator: Vec<f64>,
    /// Of the longest run, the first samples, which inputs act on that are not known: they count for nothing.
    pub unknown: usize,
    /// The residuals of each run, output unit.
    pub residuals: Vec<Vec<f64>>,
    /// Of the longest run.
    pub residual_tests: Option<ResidualTests>,
    /// Each run simulated on the inputs alone, with its offset and the motion it began with.
    pub simulated: Vec<Vec<f64>>,
    /// The simulated fit on the longest run, %.
    pub fit: Option<f64>,
    /// The simulated fit on what was held out of the longest run, or on the validation data, %.
    pub held_out_fit: Option<f64>,
    /// The fit there that the noise leaves to the best of models, %.
    pub attainable_fit: Option<f64>,
    /// Samples of the validation data.
    pub validated: Option<usize>,
    /// The share of the output's variation in the longest run that a straight line explains, 0 to 1.
    pub drift: f64,
    /// The models that were cross-validated, the chosen one first.
    pub candidates: Vec<Candidate>,
    /// Samples they were tried on.
    pub searched: usize,
    /// Samples of the record.
    pub samples: usize,
    /// Of each run, the number of the record's segment.
    pub segments: Vec<usize>,
    /// Segments of the record.
    pub all_segments: usize,
    /// The longest run's number.
    pub longest: usize,
    /// What it is good for.
    pub verdict: Verdict,
    /// Why.
    pub reasons: Vec<Finding>,
}

/// The model of every input together to one output of a record.
///
/// # Errors
/// [`IdentificationError`]: a record without inputs or that output, an input that never moves, a record that determines no
/// model.
pub fn analyse(record: &Record, output: usize, options: &Options) -> Result<Analysis> {
    judged_on(record, output, options, None)
}

/// The same with a record for validation, on the same grid: of which nothing is used for the model.
///
/// # Errors
/// As [`analyse`]; a validation record of other signals or another sampling interval.
pub fn analyse_validated(
    record: &Record,
    output: usize,
    options: &Options,
    validation: &Record,
) -> Result<Analysis> {
    judged_on(record, output, options, Some(validation))
}

fn judged_on(
    record: &Record,
    output: usize,
    options: &Options,
    validation: Option<&Record>,
) -> Result<Analysis> {
    let refused = |reason: String| Err(IdentificationError::Record(reason));
    let name = record.outputs.get(output).cloned();
    let (Some(name), false) = (name, record.inputs.is_empty()) else {
        return refused("a record with an input and an output is needed".to_owned());
    };
    record.check()?;
    let segments = used(record);
    if segments.is_empty() {
        return refused("the record has no segment".to_owned());
    }
    if options.start == InitialState::Estimated {
        still_input(record, &segments)?;
    }
    let scaled = Scaled::of(&segments, output, (options.offset, options.start));
    let asked = Asked {
        order: options.order,
        delay: options.delay,
        kind: options.kind,
        offset: options.offset,
        start: options.start,
    };
    let part = searched_part(&scaled.segments);
    let chooser = Chooser::new(part.as_deref().unwrap_or(&scaled.segments), asked);
    let undetermined = IdentificationError::Undetermined(
        "the record determines no model of these inputs: record for longer, with every input moving",
    );
    let choice = chooser.choice().ok_or(undetermined)?;
    let samples = scaled.segments.iter().map(Segment::len).sum();
    let radius = radius_of_memory(samples);
    let fitted_by = |candidate: &Candidate, segments: &[Segment]| {
        let noise = candidate.kind == Kind::BoxJenkins;
        let model = candidate.model();
        Fitted::near(segments, (&model, options.offset, noise), radius)
    };
    let full = |candidate: &Candidate| {
        let fitted = fitted_by(candidate, &scaled.segments)?;
        let in_units = InUnits::of(&fitted, &scaled, record.sample_time)?;
        Ok::<_, IdentificationError>((fitted, in_units))
    };
    // One that all the data does not determine gives way to the next.
    let mut candidates = choice.candidates;
    let at = candidates.iter().position(|it| full(it).is_ok());
    candidates.drain(..at.unwrap_or_default());
    let (mut fitted, mut in_units) = full(&candidates[0])?;
    // A pole that a zero may cancel is left out where a model with fewer parameters is nearly as good.
    let best = candidates[0].clone();
    while in_units.cancels()
        && let Some(at) = best.simpler(&candidates)
        && let Ok((simpler, units)) = full(&candidates[at])
    {
        let chosen = candidates.remove(at);
        candidates.insert(0, chosen);
        (fitted, in_units) = (simpler, units);
    }
    let chosen = candidates[0].clone();
    let lengths = scaled.segments.iter().map(Segment::len).enumerate();
    let longest = lengths.rev().max_by_key(|it| it.1).map_or(0, |it| it.0);
    let plain = fitted.equations(&scaled.segments, &[1.0]);
    let y = scaled.output;
    let simulated = segments.iter().enumerate().map(|(run, segment)| {
        let errors = plain.errors(&fitted.theta, run);
        let pairs = segment.outputs[output].iter().zip(errors);
        pairs.map(|(measured, e)| measured - e * y.size).collect()
    });
    let simulated: Vec<Vec<f64>> = simulated.collect();
    let measured = &segments[longest].outputs[output];
    let errors = plain.counted_errors(&fitted.theta)[longest].clone();
    let unknown = measured.len() - errors.len();
    let of_fit = |errors: f64, outputs: &[f64]| {
        fit(
            errors * y.size * y.size,
            variance(outputs) * outputs.len() as f64,
        )
    };
    let squares = errors.iter().map(|e| e * e).sum();
    let lag = lags(&fitted, &scaled.segments[longest], radius);
    let tests_against = |input: usize| {
        let inputs = &segments[longest].inputs[input];
        let lead = unknown + fitted.whitening.len() - 1;
        ResidualTests::new(in_units.residuals[longest].get(lead..)?, &inputs[lead..])
    };
    let own = own(&scaled.segments);
    let mut models: Vec<Option<ChannelModel>> = vec![None; record.inputs.len()];
    for ((channel, estimate), lag) in in_units.channels.iter().zip(lag) {
        models[channel.input] = Some(ChannelModel {
            estimate: estimate.clone(),
            lag,
            residuals: tests_against(channel.input),
        });
    }
    let inputs = record.inputs.iter().zip(models).enumerate();
    let inputs = inputs.map(|(number, (name, model))| InputFindings {
        name: name.clone(),
        effect: choice.effects[number],
        own: own[number],
        model,
    });
    let mut found = Analysis {
        options: *options,
        output: name,
        inputs: inputs.collect(),
        kind: chosen.kind,
        sample_time: record.sample_time,
        offsets_at_level: in_units.offsets,
        noise_variance: in_units.noise_variance,
        noise_denominator: fitted.whitening[1..].to_vec(),
        residual_tests: tests_against(0),
        residuals: in_units.residuals,
        simulated,
        unknown,
        fit: of_fit(squares, &measured[unknown..]),
        held_out_fit: None,
        attainable_fit: None,
        validated: None,
        drift: StraightLine::nearest_to(measured).share,
        searched: part.as_ref().map_or(samples, |it| it[0].len()),
        candidates,
        samples: record.samples(),
        segments: record.used(),
        all_segments: record.segments.len(),
        longest,
        verdict: Verdict::Undetermined,
        reasons: Vec::new(),
    };
    let judged = match validation {
        None => {
            let cut = |it: &Segment| {
                it.part(
                    0,
                    (it.len() as f64 * FITTED_SHARE) as usize,
                    record.sample_time,
                )
            };
            let first: Vec<Segment> = scaled.segments.iter().map(cut).collect();
            let kept = first[longest].len();
            let held = &measured[kept..];
            let of_first = fitted_by(&chosen, &first).ok();
            let left = of_first.map(|it| {
                let left = plain.errors_from_rest(&it.theta, longest, kept..measured.len());
                without_free_motion(&left, &plain.free(&it.theta))
            });
            Some((left.and_then(|left| of_fit(left, held)), held.to_vec()))
        }
        Some(validation) => {
            if validation.inputs.len() != record.inputs.len()
                || validation.outputs.len() != record.outputs.len()
            {
                return refused("the validation data has other signals".to_owned());
            }
            let of: Vec<Segment> = (used(validation).iter())
                .map(|it| scaled.scaled(it, output))
                .collect();
            let (equations, theta) = fitted.on(&of, longest);
            let (mut left, mut outputs) = (0.0, Vec::new());
            for (run, segment) in of.iter().enumerate() {
                let first = equations.layout.unknown(&segment.past).min(segment.len());
                let errors = equations.errors_from_rest(&theta, run, first..segment.len());
                left += without_free_motion(&errors, &equations.free(&theta));
                let in_units = segment.outputs[0][first..].iter();
                outputs.extend(in_units.map(|v| v * y.size + y.level));
            }
            found.validated = Some(outputs.len());
            Some((of_fit(left, &outputs), outputs))
        }
    };
    if let Some((held_out_fit, outputs)) = judged {
        let noise = choice.innovation.map(|it| it * outputs.len() as f64);
        found.attainable_fit =
            noise.map(|noise| of_fit(noise, &outputs).unwrap_or_default().max(0.0));
        found.held_out_fit = held_out_fit.filter(|_| !found.held_out_is_noise());
    }
    found.judge(&segments);
    Ok(found)
}

/// Refuses an input that stands still in every segment: its effect is that of the offset.
fn still_input(record: &Record, segments: &[&Segment]) -> Result<()> {
    for (input, name) in record.inputs.iter().enumerate() {
        let of = |segment: &&Segment| -> (f64, f64) {
            let values = &segment.inputs[input];
            let past = segment.past.get(input).map_or(&[][..], Vec::as_slice);
            let later = &values[FIRST.min(values.len())..];
            // An input that is known before the record moves into it.
            let before = range(&[past, values].concat());
            (
                range(later).max(0.0),
                if past.is_empty() { 0.0 } else { before },
            )
        };
        if segments.iter().map(of).all(|it| it == (0.0, 0.0)) {
            let moved = segments.iter().any(|it| range(&it.inputs[input]) > 0.0);
            let when = match (moved, segments.len()) {
                (true, _) => "moves in the first samples alone, where no motion before is known",
                (false, 1) => "is constant",
                (false, _) => "is constant in every segment, where the offset of each is free",
            };
            return Err(IdentificationError::Record(format!(
                "{name} {when}: it determines no model; leave it out, or record it moving"
            )));
        }
    }
    Ok(())
}

/// The part of long records that is searched: of the longest, where the input that moves least there moves most.
#[must_use]
pub fn searched_part(segments: &[Segment]) -> Option<Vec<Segment>> {
    let longest = segments.iter().max_by_key(|it| it.len())?;
    let all: usize = segments.iter().map(Segment::len).sum();
    if all <= PART || longest.len() < PART / 4 {
        return None;
    }
    let count = longest.len().min(PART);
    let least = |first: &usize| {
        let inputs = longest.inputs.iter();
        inputs
            .map(|it| variance(&it[*first..first + count]))
            .fold(f64::INFINITY, f64::min)
    };
    let first = (0..=longest.len() - count)
        .step_by(PART / 4)
        .max_by(|p, q| least(p).total_cmp(&least(q)))?;
    Some(vec![longest.part(first, first + count, 1.0)])
}

impl Analysis {
    /// The channels, with the numbers of their inputs.
    pub fn channels(&self) -> impl Iterator<Item = (usize, &InputFindings, &ChannelModel)> {
        let inputs = self.inputs.iter().enumerate();
        inputs.filter_map(|(number, it)| Some((number, it, it.model.as_ref()?)))
    }

    /// The structure of each channel.
    #[must_use]
    pub fn structures(&self) -> Vec<Channel> {
        let channels = self.channels();
        channels
            .map(|(input, _, model)| Channel {
                input,
                structure: model.estimate.layout.structure.clone(),
            })
            .collect()
    }

    /// The offset of a run's output where every input is 0; with a pole at z = 1, where the inputs are at their levels.
    #[must_use]
    pub fn offset(&self, run: usize) -> f64 {
        let channels = self.channels().map(|(.., model)| {
            let gain = model.estimate.model(0).steady_state_gain().unwrap_or(0.0);
            model.estimate.input_level * gain
        });
        self.offsets_at_level[run] - channels.sum::<f64>()
    }
}
