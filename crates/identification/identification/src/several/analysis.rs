//! Analyses a record with several inputs and one output: the choice of the channels, the fit, tests and a verdict.

use planesman_record::{Record, Segment, StraightLine};

use super::delays::lags;
use super::equations::Equations;
use super::estimate::{Fitted, InUnits};
use super::excitation::{IndependentShare, own};
use super::finding::Finding;
use super::layout::Channel;
use super::options::Options;
use super::scaled::{Scaled, used};
use super::selection::{Candidate, Chooser, Effect};
use crate::analysis::{HeldOutFits, Lag, Verdict};
use crate::error::{IdentificationError, Result};
use crate::estimators::{Estimate, radius_of_memory};
use crate::fit::fit;
use crate::free_motion::without_free_motion;
use crate::selection::Kind;
use crate::selection::criteria::FITTED_SHARE;
use crate::structure::{InitialState, PART, range, variance};
use crate::uncertainty::Reading;
use crate::validation::residuals::ResidualTests;

/// Number of initial samples in which an input may move and still count as at rest, because an initial motion can explain the effect.
const FIRST: usize = 2;

/// The transfer function of an input with an effect.
#[derive(Clone, Debug)]
pub struct ChannelModel {
    /// The channel's parameters, with their covariance including the other channels; no offset.
    pub estimate: Estimate,
    /// The delay's interval, from the longest run.
    pub lag: Option<Lag>,
    /// The test of the residual against the channel's input, for the longest run.
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

/// Findings about an input.
#[derive(Clone, Debug)]
pub struct InputFindings {
    /// Its name.
    pub name: String,
    /// Whether the input has an effect.
    pub effect: Effect,
    /// The share of the input that the other inputs do not explain.
    pub own: IndependentShare,
    /// The channel's model; `None` if the input has no effect.
    pub model: Option<ChannelModel>,
}

/// The analysis of one output, with all results.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The options of the analysis.
    pub options: Options,
    /// The output's name.
    pub output: String,
    /// Every input.
    pub inputs: Vec<InputFindings>,
    /// The kind of model: output error, or Box-Jenkins.
    pub kind: Kind,
    /// The interval between samples, s.
    pub sample_time: f64,
    /// The offset of each run, with every input at its level.
    pub offsets_at_level: Vec<f64>,
    /// The noise's variance, output unit squared.
    pub noise_variance: f64,
    /// `d1 ... dk` of the noise `e/D` on the output; empty for white noise.
    pub noise_denominator: Vec<f64>,
    /// Number of first samples of the longest run to ignore, since they depend on unknown inputs.
    pub unknown: usize,
    /// The residuals of each run, output unit.
    pub residuals: Vec<Vec<f64>>,
    /// Residual tests of the longest run.
    pub residual_tests: Option<ResidualTests>,
    /// Each run simulated from the inputs alone, with its offset and initial motion.
    pub simulated: Vec<Vec<f64>>,
    /// The simulated fit on the longest run, %.
    pub fit: Option<f64>,
    /// The fits on held-out data, or on the validation data.
    pub held_out: HeldOutFits,
    /// Number of samples of the validation data.
    pub validated: Option<usize>,
    /// The share of the output's variation in the longest run that a straight line explains, 0 to 1.
    pub drift: f64,
    /// The models that were cross-validated, the chosen one first.
    pub candidates: Vec<Candidate>,
    /// Number of samples used for the search.
    pub searched: usize,
    /// Number of samples of the record.
    pub samples: usize,
    /// The number of the record's segment for each run.
    pub segments: Vec<usize>,
    /// Number of segments of the record.
    pub all_segments: usize,
    /// The longest run's number.
    pub longest: usize,
    /// The verdict on the use of the model.
    pub verdict: Verdict,
    /// Why.
    pub reasons: Vec<Finding>,
}

/// Fits a model from all inputs to one output of a record.
///
/// # Errors
/// [`IdentificationError`]: a record without inputs or that output, an input that never moves, a record that determines no
/// model.
pub fn analyse(record: &Record, output: usize, options: &Options) -> Result<Analysis> {
    judged_on(record, output, options, None)
}

/// Fits a model and validates it on a second record on the same grid, which is not used for the fit.
///
/// # Errors
/// Like [`analyse`]; also if the validation record has other signals or another sampling interval.
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
    let segments = checked(record, output, options)?;
    let scaled = Scaled::of(&segments, output, (options.offset, options.start));
    let part = searched_part(&scaled.segments);
    let chooser = Chooser::new(part.as_deref().unwrap_or(&scaled.segments), *options);
    let undetermined = IdentificationError::Undetermined(
        "the record does not determine a model of these inputs. Record for longer, and move every input",
    );
    let choice = chooser.choice().ok_or(undetermined)?;
    let samples = scaled.segments.iter().map(Segment::len).sum();
    let fitter = Fitter {
        scaled: &scaled,
        offset: options.offset,
        sample_time: record.sample_time,
        radius: radius_of_memory(samples),
    };
    let mut candidates = choice.candidates;
    let (fitted, in_units) = fitter.best(&mut candidates)?;
    let chosen = &candidates[0];
    let lengths = scaled.segments.iter().map(Segment::len).enumerate();
    let longest = lengths.rev().max_by_key(|it| it.1).map_or(0, |it| it.0);
    let plain = fitted.equations(&scaled.segments, &[1.0]);
    let simulated = segments.iter().enumerate().map(|(run, segment)| {
        let errors = plain.errors(&fitted.theta, run);
        let pairs = segment.outputs[output].iter().zip(errors);
        pairs
            .map(|(measured, e)| measured - e * scaled.output.size)
            .collect()
    });
    let measured = &segments[longest].outputs[output];
    let errors = &plain.counted_errors(&fitted.theta)[longest];
    let unknown = measured.len() - errors.len();
    let tests_against = |input: usize| {
        let inputs = &segments[longest].inputs[input];
        let lead = unknown + fitted.whitening.len() - 1;
        ResidualTests::new(in_units.residuals[longest].get(lead..)?, &inputs[lead..])
    };
    let (left, outputs) = match validation {
        None => fitter.held_out(chosen, &plain, longest, measured),
        Some(validation) => fitter.on(&fitted, longest, (validation, output, record))?,
    };
    let noise = choice.innovation.map(|it| it * outputs.len() as f64);
    let attainable = |noise| fitter.fit(noise, &outputs).unwrap_or_default().max(0.0);
    let mut held_out = HeldOutFits {
        attainable: noise.map(attainable),
        ..HeldOutFits::default()
    };
    let fit = left.and_then(|left| fitter.fit(left, &outputs));
    held_out.fit = fit.filter(|_| !held_out.is_noise());
    let own = own(&scaled.segments);
    let mut models: Vec<Option<ChannelModel>> = vec![None; record.inputs.len()];
    let lags = lags(&fitted, &scaled.segments[longest], fitter.radius);
    for ((channel, estimate), lag) in in_units.channels.iter().zip(lags) {
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
        output: record.outputs[output].clone(),
        inputs: inputs.collect(),
        kind: chosen.kind,
        sample_time: record.sample_time,
        noise_variance: in_units.noise_variance,
        noise_denominator: fitted.whitening[1..].to_vec(),
        residual_tests: tests_against(0),
        offsets_at_level: in_units.offsets,
        residuals: in_units.residuals,
        simulated: simulated.collect(),
        unknown,
        fit: fitter.fit(errors.iter().map(|e| e * e).sum(), &measured[unknown..]),
        held_out,
        validated: validation.map(|_| outputs.len()),
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
    found.judge(&segments);
    Ok(found)
}

/// The segments used of a record with inputs and that output.
fn checked<'a>(record: &'a Record, output: usize, options: &Options) -> Result<Vec<&'a Segment>> {
    let refused = |reason: &str| Err(IdentificationError::Record(reason.to_owned()));
    if record.outputs.len() <= output || record.inputs.is_empty() {
        return refused("a record with an input and an output is needed");
    }
    record.check()?;
    let segments = used(record);
    if segments.is_empty() {
        return refused("the record has no segments");
    }
    if options.start == InitialState::Estimated {
        still_input(record, &segments)?;
    }
    Ok(segments)
}

/// Fits candidates to a record that is scaled relative to its levels.
struct Fitter<'a> {
    scaled: &'a Scaled,
    offset: bool,
    sample_time: f64,
    /// The largest magnitude of a pole.
    radius: f64,
}

impl Fitter<'_> {
    /// A candidate fitted to segments.
    fn near(&self, candidate: &Candidate, segments: &[Segment]) -> Result<Fitted> {
        let noise = candidate.kind == Kind::BoxJenkins;
        let model = candidate.model();
        Fitted::near(segments, (&model, self.offset, noise), self.radius)
    }

    /// A candidate fitted to all the data.
    fn whole(&self, candidate: &Candidate) -> Result<(Fitted, InUnits)> {
        let fitted = self.near(candidate, &self.scaled.segments)?;
        let in_units = InUnits::of(&fitted, self.scaled, self.sample_time)?;
        Ok((fitted, in_units))
    }

    /// The fit of the chosen model, which becomes the first of the candidates.
    fn best(&self, candidates: &mut Vec<Candidate>) -> Result<(Fitted, InUnits)> {
        // One that all the data does not determine gives way to the next.
        let whole = |(at, it)| Some((at, self.whole(it).ok()?));
        let (at, mut found) = match candidates.iter().enumerate().find_map(whole) {
            Some(found) => found,
            None => (0, self.whole(&candidates[0])?),
        };
        candidates.drain(..at);
        // A pole that a zero may cancel is left out where a model with fewer parameters is nearly as good.
        let best = candidates[0].clone();
        while found.1.cancels()
            && let Some(at) = best.simpler(candidates)
            && let Ok(simpler) = self.whole(&candidates[at])
        {
            let chosen = candidates.remove(at);
            candidates.insert(0, chosen);
            found = simpler;
        }
        Ok(found)
    }

    /// The fit, %, for a sum of squared errors of outputs.
    fn fit(&self, errors: f64, outputs: &[f64]) -> Option<f64> {
        let size = self.scaled.output.size;
        let about_mean = variance(outputs) * outputs.len() as f64;
        fit(errors * size * size, about_mean)
    }

    /// The squared errors on the held-out part of the longest run, by a model of the first part of each, and the outputs there.
    fn held_out(
        &self,
        chosen: &Candidate,
        plain: &Equations,
        longest: usize,
        measured: &[f64],
    ) -> (Option<f64>, Vec<f64>) {
        let first_part = |it: &Segment| {
            let kept = (it.len() as f64 * FITTED_SHARE) as usize;
            it.part(0, kept, self.sample_time)
        };
        let first: Vec<Segment> = self.scaled.segments.iter().map(first_part).collect();
        let kept = first[longest].len();
        let left = self.near(chosen, &first).ok().map(|it| {
            let left = plain.errors_from_rest(&it.theta, longest, kept..measured.len());
            without_free_motion(&left, &plain.free(&it.theta))
        });
        (left, measured[kept..].to_vec())
    }

    /// The squared errors on the validation data, and the outputs there.
    fn on(
        &self,
        fitted: &Fitted,
        longest: usize,
        (validation, output, record): (&Record, usize, &Record),
    ) -> Result<(Option<f64>, Vec<f64>)> {
        let signals = |of: &Record| (of.inputs.len(), of.outputs.len());
        if signals(validation) != signals(record) {
            let reason = "the validation data has different signals".to_owned();
            return Err(IdentificationError::Record(reason));
        }
        let of: Vec<Segment> = (used(validation).iter())
            .map(|it| self.scaled.scaled(it, output))
            .collect();
        let (equations, theta) = fitted.on(&of, longest);
        let (mut left, mut outputs) = (0.0, Vec::new());
        for (run, segment) in of.iter().enumerate() {
            let first = equations.layout.unknown(&segment.past).min(segment.len());
            let errors = equations.errors_from_rest(&theta, run, first..segment.len());
            left += without_free_motion(&errors, &equations.free(&theta));
            let y = self.scaled.output;
            let in_units = segment.outputs[0][first..].iter();
            outputs.extend(in_units.map(|v| v * y.size + y.level));
        }
        Ok((Some(left), outputs))
    }
}

/// Refuses an input that is constant in every segment: its effect cannot be separated from the offset.
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
                (true, _) => {
                    "moves only in the first samples, when the earlier motion of the input is not known"
                }
                (false, 1) => "is constant",
                (false, _) => "is constant in every segment, and each segment has its own offset",
            };
            return Err(IdentificationError::Record(format!(
                "{name} {when}, so the data does not determine its effect. Leave it out, or record data in which it moves"
            )));
        }
    }
    Ok(())
}

/// The part of long records that is searched: in the longest record, where the least moving input moves most.
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

    /// The offset of a run's output with every input at 0; with a pole at z = 1, with the inputs at their levels.
    #[must_use]
    pub fn offset(&self, run: usize) -> f64 {
        let channels = self.channels().map(|(.., model)| {
            let gain = model.estimate.model(0).steady_state_gain().unwrap_or(0.0);
            model.estimate.input_level * gain
        });
        self.offsets_at_level[run] - channels.sum::<f64>()
    }
}
