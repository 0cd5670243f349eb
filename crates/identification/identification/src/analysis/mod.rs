//! The analysis of a record: order search, fit, residual tests and verdict.
//!
//! Each segment of the record is a separate run of the same model. The order is searched unless it is given. The model is fitted to the first 70 % of
//! each segment and validated on the rest by simulation, or on a separate record; the reported model is fitted to all data. In a long record the
//! order is searched in the part where the input varies most ([`Problem::part`]).
//!
//! - `options`, `level`, `data`: the requested analysis, and the record as used for the fit.
//! - `search`: order, delay and kind of model; `held_out`: the fits on data that was not used for the model.
//! - `verdict`: the model's suitability; `judgement`: how the verdict is reached; `reason`: each reason with its numbers; `sentences`: verdict and
//!   reasons in words.
//! - `text`: the results for the terminal.
//! - `lag`: the delay's interval.
//! - `bootstrap`: intervals of poles and gain from refits.
//! - `curve`: static curves before or after the dynamics; `curved`: the analysis with a curve, if the evidence suggests one.
//! - `checks`: the quantities behind the verdict.

mod bootstrap;
mod checks;
mod curve;
mod curved;
mod data;
mod held_out;
pub(crate) mod judgement;
pub(crate) mod lag;
mod level;
mod options;
mod reason;
mod search;
mod sentences;
pub(crate) mod text;
mod trajectory;
mod verdict;

pub use crate::prediction::AHEAD;
pub use crate::selection::process::may_integrate;
pub use bootstrap::{Bootstrap, Interval};
pub use checks::InputPart;
pub use curve::{CurveChoice, Curved};
pub use curved::{analyse, analyse_validated};
pub use held_out::HeldOutFits;
pub use judgement::SAMPLES_PER_PARAMETER;
pub use lag::Lag;
pub use options::Options;
pub use reason::{FitRemark, Reason, ResidualFinding};
pub use search::{FirstOrderHold, OtherOrder, Search};
pub use text::Shown;
pub use trajectory::Trajectory;
pub use verdict::{GOOD, Standing, USABLE, Verdict};

use std::borrow::Cow;

use data::{Data, caused_by_reference};
use level::Level;
use search::{Chosen, search};

use crate::comparison::{GivenModel, Judgement};
use crate::conversion;
use crate::error::Result;
use crate::estimators::{
    Estimate, Estimator, Method, Physical, Property, TwoStages, WarmStarted, Wiener,
};
use crate::model::Model;
use crate::prediction;
use crate::selection::criteria::first_part;
use crate::selection::{Kind, process};
use crate::static_curve::Side;
use crate::structure::{InitialState, Problem, Structure};
use crate::uncertainty::Reading;
use crate::validation::identifiability::{self, Doubt, Following};
use crate::validation::nonlinearity::{self, Cause, Finding};
use crate::validation::residuals::ResidualTests;
use planesman_record::{Record, Run};

/// Another kind of model is tried if the fit is this much, %, below the limit set by noise.
const BELOW_NOISE: f64 = 5.0;
/// The cause of the error is searched if the fit is this much, %, below the limit set by noise.
const ASKED_FROM: f64 = 2.0;

/// The closed loop that contains the input.
#[derive(Clone, Debug)]
pub struct ClosedLoop {
    /// The name of the loop's reference.
    pub reference: String,
    /// The model fitted directly, without the reference.
    pub direct: Option<Estimate>,
}

/// A model with all results of the analysis.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The options of the analysis.
    pub options: Options,
    /// The input's name.
    pub input: String,
    /// The output's name.
    pub output: String,
    /// The closed loop that contains the input, if its reference was given.
    pub closed_loop: Option<ClosedLoop>,
    /// The model.
    pub estimate: Estimate,
    /// The search that found the model's structure.
    pub search: Search,
    /// A static curve before or after the dynamics, if one was fitted; the record and all fits are then those of the signal after the curve.
    pub curved: Option<Curved>,
    /// For each run, the number of its segment in the record.
    pub segments: Vec<usize>,
    /// The simulated fit on the longest run, %.
    pub fit: Option<f64>,
    /// Fits on the held-out part.
    pub held_out: HeldOutFits,
    /// The fit of predictions [`AHEAD`] samples ahead on the longest run, or on the validation data, %.
    pub predicted_fit: Option<f64>,
    /// The part of the output that the input explains, beyond constant and free motion.
    pub input_part: Option<InputPart>,
    /// Whether the input is constant except for one or two steps.
    pub is_step_test: bool,
    /// Share (0 to 1) of the output's variation in the longest run that a straight line explains, beyond the response to the input.
    pub drift: f64,
    /// Whether the input of the longest run follows its output.
    pub following: Following,
    /// Interval of the delay from the longest run, for an output-error model.
    pub lag: Option<Lag>,
    /// Intervals from a bootstrap, if requested.
    pub bootstrap: Option<Bootstrap>,
    /// Results on the validation record, if one was given.
    pub validation: Option<Judgement>,
    /// Residual tests of the longest run.
    pub residuals: Option<ResidualTests>,
    /// The cause of the longest run's error, if the fit is well below the limit set by noise: nonlinearity, variation or a disturbance.
    pub finding: Option<Finding>,
    /// The longest run's number.
    pub longest: usize,
    /// The model's verdict.
    pub verdict: Verdict,
    /// Why.
    pub reasons: Vec<Reason>,
    /// Parameters of the recursive form over time.
    pub trajectory: Trajectory,
}

/// Position of a static curve relative to the linear dynamics.
enum CurvePlacement<'a> {
    None,
    /// A curve at the input, which the record's input has passed.
    AtInput(curve::Front<'a>),
    /// A curve at the output, after dynamics of a given structure.
    AtOutput(Structure, Wiener),
}

impl CurvePlacement<'_> {
    fn is_at_output(&self) -> bool {
        matches!(self, Self::AtOutput(..))
    }

    /// The curve, together with fitted dynamics.
    fn curve(&self, estimate: &Estimate) -> Option<Curved> {
        let (side, fitted) = match self {
            Self::None => return None,
            Self::AtInput(front) => (Side::Input, front.curve.clone()),
            Self::AtOutput(..) => (Side::Output, estimate.output_curve.clone()?),
        };
        Some(Curved {
            side,
            fitted,
            linear_fit: None,
        })
    }
}

fn judged_on(
    record: &Record,
    options: &Options,
    validation: Option<&Record>,
    beside: CurvePlacement<'_>,
) -> Result<Analysis> {
    let stood = input_before_step(record, options).filter(|_| !beside.is_at_output());
    let at_rest = Options {
        start: InitialState::Rest,
        ..options.clone()
    };
    let (options, level) = match stood {
        Some(input) => (&at_rest, Level { input, output: 0.0 }),
        // A curve has levels of its own.
        None if beside.is_at_output() => (options, Level::default()),
        None => (options, Level::of(record, options)),
    };
    let measured = record;
    let record = &*level.taken_off(record);
    let data = Data::of(record, options)?;
    let chosen = match &beside {
        CurvePlacement::AtOutput(structure, estimator) => {
            Chosen::of(structure.clone(), Box::new(estimator.clone()))
        }
        _ => search(&data, options, stood.is_some())?,
    };
    let problem = Problem {
        structure: chosen.structure.clone(),
        ..data.problem.clone()
    };
    let mut found = fitted(&data, &problem, options, chosen, &beside, validation)?;
    let own = std::iter::once(&mut found.estimate);
    own.chain(found.closed_loop.iter_mut().flat_map(|it| &mut it.direct))
        .for_each(|it| level.restore_units(it));
    let validated = validation.map(|it| found.validated(it, &problem));
    let validated = validated.transpose()?;
    found.finding = found.beyond_linear(measured);
    let doubts = found.doubts(&problem);
    found.verdict = found.judged(!doubts.is_empty());
    let step = stood.map(|_| Reason::AtRest);
    found.reasons = (validated.into_iter().chain(step))
        .chain(found.reasons(doubts, record))
        .collect();
    Ok(found)
}

/// The input level before the step of a step test, if the output is constant until then and the options allow this.
fn input_before_step(record: &Record, options: &Options) -> Option<f64> {
    let of_steps = options.method.has(Property::KnowsStepTests);
    let is_asked = of_steps && options.start == InitialState::Estimated && options.offset;
    is_asked
        .then(|| checks::level_before_step(record))
        .flatten()
}

/// Fits the chosen structure and computes its results; held-out results are computed if there is no validation data.
fn fitted(
    data: &Data<'_>,
    problem: &Problem<'_>,
    options: &Options,
    chosen: Chosen,
    beside: &CurvePlacement<'_>,
    validation: Option<&Record>,
) -> Result<Analysis> {
    let longest = data.longest();
    let method = chosen.estimator.as_ref();
    let staged = TwoStages {
        second: method,
        references: data.references.clone(),
    };
    let estimator: &dyn Estimator = match &chosen.joint {
        Some(joint) => joint,
        None if data.is_in_a_loop() => &staged,
        None => method,
    };
    let mut estimate = match chosen.estimate {
        Some(fitted) => fitted,
        None => estimator.fit(problem)?,
    };
    if let CurvePlacement::AtInput(front) = beside {
        front.widen(&mut estimate, estimator, problem)?;
    }
    // In a loop the output follows the part of the input that the reference causes, and noise that went round.
    let second = data.on_noise_free_inputs(problem);
    let run = second.runs[longest];
    let tested_against = data.references.get(longest).copied();
    let tested_against = tested_against.unwrap_or(problem.runs[longest].inputs);
    let residuals = estimate.residuals.get(longest);
    let nothing_held_out = HeldOutFits {
        from: first_part(&run).outputs.len(),
        ..HeldOutFits::default()
    };
    let held_out = match beside {
        _ if validation.is_some() => nothing_held_out,
        CurvePlacement::AtInput(front) => match front.of_first_part(&problem.structure) {
            Ok(through) => {
                let by_first_part = Problem {
                    runs: through.runs().unwrap_or_default(),
                    ..problem.clone()
                };
                HeldOutFits::of(estimator, &by_first_part, longest)
            }
            // The first part alone does not determine the curve.
            Err(_) => nothing_held_out,
        },
        _ => HeldOutFits::of(estimator, problem, longest),
    };
    let refits = |refits| {
        // The minimum of a simulated record is near the estimate.
        let near = WarmStarted {
            poles: estimate.theta.as_slice()[estimate.layout.a()].to_vec(),
            noise: options.method == Method::BoxJenkins,
        };
        let again: &dyn Estimator = match options.method.has(Property::StartsFromPoles) {
            true => &near,
            false => method,
        };
        bootstrap::bootstrap(again, &estimate, &second, longest, refits)
    };
    let lag =
        || lag::lag(&estimate, &second, data.following).filter(|_| estimate.output_curve.is_none());
    let lag = chosen.lag.or_else(lag);
    let lag = lag.map(|it| {
        let it = lag::with_lags(it, &estimate, &second, data.following);
        it.with_candidates(&chosen.search.selected)
    });
    Ok(Analysis {
        options: options.clone(),
        input: data.name(0).unwrap_or_default(),
        output: data.record.outputs.first().cloned().unwrap_or_default(),
        closed_loop: data.name(1).map(|reference| ClosedLoop {
            reference,
            direct: method.fit(problem).ok(),
        }),
        search: chosen.search,
        curved: beside.curve(&estimate),
        segments: data.record.used(),
        fit: estimate.simulated_fit(longest, run, 0),
        held_out,
        predicted_fit: prediction::missed(&estimate, longest, run, AHEAD).fit(),
        input_part: checks::part_of_input(&estimate, longest, run),
        is_step_test: process::is_step_test(&second),
        drift: checks::drift(&estimate, run),
        following: data.following,
        lag,
        bootstrap: options.bootstrap.map(refits).transpose()?,
        validation: None,
        residuals: residuals.and_then(|it| ResidualTests::new(it, tested_against)),
        finding: checks::oscillation(&estimate, longest, run),
        longest,
        verdict: Verdict::Undetermined,
        reasons: Vec::new(),
        trajectory: Trajectory::of(method, &second),
        estimate,
    })
}

impl Analysis {
    /// Adds the fits on a validation record.
    fn validated(&mut self, validation: &Record, fitted: &Problem<'_>) -> Result<Reason> {
        let validation = &*match self.estimate.frequency {
            // Its model was not fitted to what the reference causes.
            Some(_) => Cow::Borrowed(validation),
            None => caused_by_reference(validation)?,
        };
        let judgement = GivenModel::new(&self.estimate, self.longest).on(validation, &[AHEAD])?;
        let outputs = validation.segments[judgement.segments[judgement.longest]]
            .outputs
            .first();
        self.held_out.attainable = outputs.and_then(|it| checks::attainable_fit(fitted, it));
        self.held_out.fit = judgement.fit.filter(|_| !self.held_out.is_noise());
        self.predicted_fit = judgement.predicted[0].1;
        let reason = Reason::Validated(judgement.samples, judgement.fit, self.predicted_fit);
        self.validation = Some(judgement);
        Ok(reason)
    }

    /// The reason why the record may not determine the model.
    fn doubts(&self, problem: &Problem<'_>) -> Vec<Doubt> {
        let vehicle = &self.options.knowledge.vehicle;
        let mut doubts = match self.options.method.is_of_the_vehicle() {
            // One step determines the one, the coherence tells where the other is: as their intervals say.
            _ if self.estimate.process.is_some() || self.estimate.frequency.is_some() => Vec::new(),
            true => identifiability::of_inputs(problem, vehicle.unknowns(), true),
            false => identifiability::doubts(problem),
        };
        // An input that hardly excites some direction determines it where there is little noise.
        if self.response_is_determined() {
            doubts.retain(|it| !matches!(it, Doubt::Excitation(..)));
        }
        // The user knows that the plant answers at once.
        if self.options.delay == Some(0) {
            doubts.retain(|it| !matches!(it, Doubt::FeedbackAlone(..)));
        }
        doubts
    }

    /// The cause of the longest run's error, if the noise would allow a better fit.
    fn beyond_linear(&self, data: &Record) -> Option<Finding> {
        let run = data.segments[self.segments[self.longest]].run()?;
        let finding = || nonlinearity::finding(&self.estimate, self.longest, run);
        let oscillation = self.finding.clone();
        let is_asked = self.may_be_disturbed() && self.is_caused();
        let beyond = self.is_below_noise().then(finding).flatten();
        // A simulation that is worse than the mean drifts: its error bends with any signal.
        let simulates = self.held_out.fit.is_some_and(|fit| fit > 0.0);
        let beyond = beyond.filter(|it| simulates || it.cause.is_disturbance());
        let clipped = || {
            // An output that settles in finite time looks clipped too, but a linear model simulates it as well as the noise lets it.
            let misses = self.held_out.fit.is_none() || self.is_below_noise();
            let is_open = self.curved.is_none() && !self.is_exact() && misses;
            let limits = curve::clipped_at(run.outputs).filter(|_| is_open)?;
            Some(Finding {
                cause: Cause::Output(limits),
                gain: None,
            })
        };
        beyond.or_else(|| clipped().or(oscillation).filter(|_| is_asked))
    }

    /// Whether the fit is below the limit set by noise, so that another model could fit better.
    fn is_below_noise(&self) -> bool {
        let fits = self.held_out.attainable.zip(self.held_out.fit);
        fits.is_some_and(|(attainable, held)| attainable - held > ASKED_FROM)
            && self.may_be_disturbed()
    }

    /// Whether the residual may be searched for a disturbance.
    fn may_be_disturbed(&self) -> bool {
        self.closed_loop.is_none()
            && self.estimate.process.is_none()
            && self.estimate.output_curve.is_none()
            && !self.is_unstable()
            && !self.options.method.is_of_the_vehicle()
    }

    /// The simulated output of a run, from its input alone, with the curve if there is one.
    #[must_use]
    pub fn simulate(&self, number: usize, run: Run<'_>) -> Vec<f64> {
        match &self.curved {
            Some(curved) if curved.side == Side::Input => {
                let (past, inputs) = curved.fitted.curve.of_run(&run);
                let through = Run {
                    past: &past,
                    inputs: &inputs,
                    outputs: run.outputs,
                };
                self.estimate.simulate(number, through)
            }
            _ => self.estimate.simulate(number, run),
        }
    }

    /// A record for the linear dynamics: its input has passed the input curve, if there is one.
    #[must_use]
    pub fn of_dynamics<'a>(&self, record: &'a Record) -> Cow<'a, Record> {
        match &self.curved {
            Some(curved) if curved.side == Side::Input => {
                Cow::Owned(curved.fitted.curve.of_input(record))
            }
            _ => Cow::Borrowed(record),
        }
    }

    /// The reasons, followed by the verdict.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let reasons = self.reasons.iter().map(Reason::to_string);
        reasons.chain([self.verdict_text()]).collect()
    }

    /// The kind of model that cross-validation chose.
    #[must_use]
    pub fn kind(&self) -> Option<Kind> {
        self.search.selected.first().map(|chosen| chosen.kind)
    }

    /// The method's name: that of the chosen kind of model, or of the requested method.
    #[must_use]
    pub fn method_name(&self) -> &'static str {
        match self.estimate.process {
            Some(_) => Method::Process.name(),
            None if self.estimate.output_curve.is_some() => Method::OutputError.name(),
            None => self.kind().map_or(self.options.method.name(), Kind::name),
        }
    }

    /// The model of the longest run.
    #[must_use]
    pub fn model(&self) -> Model {
        self.estimate.model(self.longest)
    }

    /// Poles, zeros, gain and response of the longest run's model.
    #[must_use]
    pub fn reading(&self) -> Reading<'_> {
        Reading::new(&self.estimate, self.longest)
    }

    /// The vehicle's coefficients, if they were estimated or follow from a second-order model with a zero at z = 1.
    #[must_use]
    pub fn physical(&self) -> Option<Physical> {
        let sought = self.estimate.physical.clone();
        sought.or_else(|| conversion::pitch_equation(&self.estimate).ok())
    }
}
