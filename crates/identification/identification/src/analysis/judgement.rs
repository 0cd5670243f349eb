//! The reason why a model gets its verdict: conclusions from fit, residuals and uncertainty.

use std::f64::consts::PI;

use nalgebra::Matrix2;
use planesman_linear::ComplexFunctions as _;

use super::reason::{Reason, ResidualFinding};
use super::search::{MAX_DELAY, MAX_ORDER, METHOD_MAX_DELAY, METHOD_MAX_ORDER};
use super::verdict::{GOOD, USABLE, VERY_GOOD, Verdict};
use super::{Analysis, BELOW_NOISE, CurveChoice, InputPart};
use crate::estimators::{Error, Method, Property};
use crate::selection::process::may_integrate;
use crate::selection::{Kind, criteria, dead_time};
use crate::uncertainty::{Reading, SIGMAS_95, Uncertain};
use crate::validation::identifiability::{Doubt, Following};
use crate::validation::residuals::{Correlation, ResidualTests};
use planesman_record::Record;
use planesman_wording::{option, setting};

/// Two estimates describe different systems if their responses differ by more than this number of standard deviations at the worst of
/// [`FREQUENCIES`].
const APART: f64 = 4.0;
const FREQUENCIES: usize = 20;

/// If a straight line explains this share of the output's variation, the output is said to drift.
pub(crate) const DRIFTS: f64 = 0.1;
/// Minimum share of the output that the input must explain; the second value is for an unstable model, which moves by itself.
const CAUSED: f64 = 0.1;
const CAUSED_OF_UNSTABLE: f64 = 0.01;
/// The F statistic above which the response of a process model is certain. A random walk, which a step seems to explain in part even in a long
/// record, reaches 20.
const BEYOND_DOUBT: f64 = 50.0;
/// Maximum ratio of the errors on held-out data to those on the fitted data.
const AS_THE_NOISE: f64 = 1.5;
/// Thresholds above which a significant correlation matters: its size, and the share of the output's variation involved.
const MATTERS: f64 = 0.05;
const MATTERS_IN_OUTPUT: f64 = 1e-3;
/// Fit, %, above which the residual is too small to bias a model through feedback.
const LEAVES_LITTLE: f64 = 99.0;
/// Minimum number of samples per parameter; with fewer, the model partly fits the noise.
pub const SAMPLES_PER_PARAMETER: usize = 10;
/// Maximum ratio of the error with half the record left out to the error with a fifth left out.
pub(crate) const STEADY: f64 = 4.0;
/// Maximum 95 % interval of a steady-state gain, relative to the gain, if a zero may cancel a pole.
const KNOWN: f64 = 0.5;
/// A steady-state gain below this share of the largest response counts as small.
const SMALL: f64 = 0.05;
/// Above this fit, %, the data counts as free of noise.
const ALL_BUT_ROUNDING: f64 = 99.9999;
/// A frequency response is determined if its 95 % interval is below this share of the largest response.
const DETERMINED: f64 = 0.25;
/// A pole in z whose 95 % interval is below this size is precisely known.
pub(crate) const PRECISE: f64 = 0.1;

impl Analysis {
    /// Reasons for and against the model, after the doubts whether the record determines a model.
    pub(super) fn reasons(&self, doubts: Vec<Doubt>, record: &Record) -> Vec<Reason> {
        let mut reasons: Vec<Reason> = doubts.into_iter().map(Reason::Doubt).collect();
        reasons.extend(self.left_out(record));
        reasons.extend(self.selection());
        reasons.extend(self.order());
        reasons.extend(self.processes());
        reasons.extend(self.band());
        reasons.extend(self.limits_of_search());
        reasons.extend(self.two_stages());
        reasons.extend(self.fits());
        reasons.extend(self.input_share());
        reasons.extend(self.search.lines.map(Reason::FirstOrderHold));
        reasons.extend(self.delay());
        reasons.extend(self.beyond(record));
        reasons.extend(self.curve_misses().map(Reason::CurveMisses));
        reasons.extend(self.residual_findings());
        reasons.extend(self.suspicious_poles());
        reasons.extend(self.search.other_order.clone().map(Reason::OtherOrder));
        reasons.extend(self.few_samples());
        reasons
    }

    /// The model chosen by cross-validation.
    fn selection(&self) -> Option<Reason> {
        let chosen = self.search.selected.first()?;
        let largest = self
            .search
            .selected
            .iter()
            .max_by(|p, q| p.fit().total_cmp(&q.fit()))
            .filter(|it| it.fit() > chosen.fit() + 0.05);
        Some(Reason::Selected(
            self.search.selected.len(),
            Box::new(chosen.clone()),
            largest.cloned().map(Box::new),
        ))
    }

    /// The order chosen by criteria.
    fn order(&self) -> Option<Reason> {
        let chosen = criteria::choice(&self.search.candidates)?;
        let next = (self.search.candidates.iter())
            .find(|it| it.delay == chosen.delay && it.order == chosen.order + 1);
        Some(Reason::Order(chosen.clone(), next.cloned()))
    }

    /// The process model, and the next form.
    fn processes(&self) -> Option<Reason> {
        let chosen = self.search.processes.first()?;
        let others = self
            .search
            .processes
            .iter()
            .filter(|it| it.form != chosen.form);
        let next = others.min_by(|p, q| p.bic.total_cmp(&q.bic));
        let next = next.map(|next| (next.form, next.bic - chosen.bic));
        Some(Reason::Process(chosen.clone(), next))
    }

    /// The band that a transfer function was fitted in.
    fn band(&self) -> Option<Reason> {
        let fit = self.estimate.frequency.as_ref()?;
        Some(Reason::Band {
            band: fit.band,
            coherence: fit.coherence,
            cost: fit.cost,
        })
    }

    /// Reports an order or delay at the limit of the search range.
    fn limits_of_search(&self) -> Vec<Reason> {
        let s = &self.estimate.layout.structure;
        let (orders, delays) = match (
            self.search.selected.is_empty(),
            self.search.candidates.is_empty(),
        ) {
            (false, _) => (
                MAX_ORDER,
                dead_time::longest(self.search.samples).max(MAX_DELAY),
            ),
            (true, false) => (METHOD_MAX_ORDER, METHOD_MAX_DELAY),
            _ => return Vec::new(),
        };
        let order = (self.options.order.is_none() && s.poles >= orders)
            .then_some(Reason::LargestOrder(s.poles));
        let delay = (self.options.delay.is_none() && s.delay >= delays)
            .then_some(Reason::LongestDelay(s.delay));
        order.into_iter().chain(delay).collect()
    }

    pub(super) fn is_unstable(&self) -> bool {
        let poles = self.reading().poles().unwrap_or_default();
        poles
            .iter()
            .any(|pole| pole.value.modulus() - SIGMAS_95 * pole.magnitude_deviation() > 1.0 + 1e-9)
    }

    fn fits(&self) -> Vec<Reason> {
        if self.is_unstable() {
            return self
                .predicted_fit
                .map(Reason::PredictedFit)
                .into_iter()
                .collect();
        }
        let by_process = self.estimate.process.as_ref().and(self.cross_validated());
        let fit = match self.held_out.reason(self.fit) {
            _ if by_process.is_some() => Reason::ErrorAsElsewhere(by_process),
            Some(held_out) => held_out,
            None if self.estimate.frequency.is_some() => Reason::WholeRecord(self.fit),
            None if self.held_out.is_noise() => Reason::HeldOutIsNoise(self.cross_validated()),
            None => Reason::FirstPartUndetermined,
        };
        let carried = self
            .drifting_fit()
            .filter(|_| by_process.is_none())
            .map(Reason::Carried);
        let unsteady = self.is_unsteady().then_some(Reason::Unsteady);
        std::iter::once(fit)
            .chain(carried)
            .chain(unsteady)
            .collect()
    }

    /// The fit on held-out data with the initial state from the data before, %, if it is clearly lower than with a newly fitted state.
    fn drifting_fit(&self) -> Option<f64> {
        let fit = self
            .held_out
            .carried
            .filter(|_| self.estimate.process.is_none())?;
        self.held_out.fit.filter(|held| fit < held - BELOW_NOISE)?;
        Some(fit)
    }

    /// The cross-validated fit, %, of a model that simulates all data well and whose output has settled in the held-out data, as after a step; for a
    /// process model, if the held-out errors are only noise.
    fn cross_validated(&self) -> Option<f64> {
        if self.estimate.frequency.is_some() {
            // A chirp excites the band over all of its time.
            return self.fit.filter(|_| self.held_out.fit.is_none());
        }
        if self.estimate.process.is_some() {
            // The errors there, and over all of the run.
            let spread = self.held_out.spread?;
            let errors = |fit: f64, spread: f64| (100.0 - fit) * spread;
            let is_noise =
                self.held_out.fit.zip(self.fit).is_none_or(|(held, fit)| {
                    errors(held, spread) <= AS_THE_NOISE * errors(fit, 1.0)
                });
            let is_little = self.held_out.fit.is_none_or(|fit| fit < GOOD);
            return self.search.process_fit.filter(|_| is_noise && is_little);
        }
        let settled = self.held_out.is_noise();
        let simulates = self.fit.is_some_and(|fit| fit >= GOOD);
        let chosen = self
            .search
            .selected
            .first()
            .filter(|_| settled && simulates)?;
        Some(chosen.fit())
    }

    /// Reports the cause of the error, with times relative to the record.
    fn beyond(&self, record: &Record) -> Option<Reason> {
        let finding = self.finding.clone()?;
        let number = self.segments[self.longest];
        Some(Reason::NotLinear {
            finding,
            sample_time: self.estimate.sample_time,
            segment: (record.segments.len() > 1).then_some(number + 1),
        })
    }

    /// Reports a delay that is physically impossible, or that fits better than the model's delay.
    fn delay(&self) -> Option<Reason> {
        let (lag, delay) = (self.lag?, self.estimate.layout.structure.delay);
        if self.is_early() {
            return Some(Reason::Early(-lag.best));
        }
        if lag.is_another {
            return Some(Reason::OtherDelay(lag.best, delay));
        }
        let structure = &self.estimate.layout.structure;
        let is_instant = structure.poles > 0 && !structure.has_lines();
        (delay == 0 && lag.interval.1 == 0 && is_instant).then_some(Reason::DirectFeedthrough)
    }

    /// The share of the output that the input explains.
    fn input_share(&self) -> Vec<Reason> {
        let part = self
            .input_part
            .filter(|part| part.share < 0.5 || !self.is_caused());
        let share = part.map(|part| match self.estimate.process {
            Some(_) => Reason::ProcessF(part.f, BEYOND_DOUBT),
            None => Reason::InputShare(part.share, part.share < CAUSED),
        });
        share
            .into_iter()
            .chain(self.undetermined_gain().map(Reason::GainUndetermined))
            .collect()
    }

    /// Reports a record with too few samples for the number of parameters.
    fn few_samples(&self) -> Option<Reason> {
        let process = self.estimate.process.as_ref();
        let parameters = process.map_or(self.estimate.theta.len(), |it| it.sought);
        few_samples(&self.estimate.residuals, parameters)
    }

    /// Whether the 95 % interval of the response is small at every frequency, compared with the largest response.
    pub(super) fn response_is_determined(&self) -> bool {
        response_is_determined(&self.reading(), self.estimate.sample_time)
    }

    /// The verdict; `undetermined` if the record does not determine a model.
    pub(super) fn judged(&self, undetermined: bool) -> Verdict {
        let held = match self.is_unstable() {
            true => self.predicted_fit,
            false => self.cross_validated().or(self.held_out.fit),
        };
        // What all of a record without noise follows holds for each part of it.
        let is_own = self.validation.is_none() && self.is_exact();
        let held = self.fit.filter(|_| is_own).or(held);
        let tests = self.residuals.as_ref();
        let missing = tests.is_some_and(|it| self.misses_dynamics(it));
        let feedback = tests.is_some_and(|it| self.has_feedback(it));
        let unsteady = self.is_unsteady();
        let limited = self.held_out.is_limited_by_noise() && held.is_some_and(|held| held < GOOD);
        let gain = match self
            .estimate
            .process
            .as_ref()
            .and_then(|it| it.named().next())
        {
            Some((_, _, gain, deviation)) => SIGMAS_95 * deviation > gain.abs(),
            None => self.undetermined_gain().is_some(),
        };
        match held {
            _ if !self.is_caused() => Verdict::NoEffect,
            _ if undetermined => Verdict::Undetermined,
            None => Verdict::NotValidated,
            Some(_) if self.few_samples().is_some() => Verdict::FewSamples,
            Some(held) if self.drift > DRIFTS && (feedback || unsteady || gain) => Verdict::Drift {
                usable: held >= USABLE,
            },
            Some(held) if let Some(finding) = &self.finding => {
                let usable = held >= USABLE;
                match finding.cause.is_disturbance() {
                    true => Verdict::Disturbed { usable },
                    false => Verdict::NotLinear { usable },
                }
            }
            Some(held) if self.curve_misses().is_some() => Verdict::NotLinear {
                usable: held >= USABLE,
            },
            Some(held) if feedback => Verdict::ClosedLoop {
                usable: held >= USABLE,
            },
            Some(held) if limited && !unsteady && !gain => Verdict::NoiseLimited {
                good: held >= USABLE,
            },
            Some(held) if held < USABLE => Verdict::Unusable,
            Some(_) if unsteady => Verdict::Unsteady,
            Some(held) if self.is_early() && held < VERY_GOOD => Verdict::Early,
            Some(_) if gain && !self.is_unstable() => Verdict::GainUndetermined,
            Some(_) if missing => Verdict::DynamicsMissing,
            Some(held) if held < GOOD => Verdict::Usable,
            Some(_) if self.drifting_fit().is_some_and(|fit| fit < USABLE) => Verdict::Usable,
            Some(_) => Verdict::Good,
        }
    }

    /// The amount, %, by which the fit of a model with a curve is below the limit set by noise.
    pub(super) fn curve_misses(&self) -> Option<f64> {
        self.curved.as_ref()?;
        let held = self.held_out.fit?;
        let missed = self.held_out.attainable? - held;
        (missed > BELOW_NOISE).then_some(missed)
    }

    /// The verdict and the next step.
    #[must_use]
    pub fn verdict_text(&self) -> String {
        self.verdict.text(self.next())
    }

    /// The next step for the user.
    #[must_use]
    pub fn next(&self) -> String {
        let is_chosen = self.options.method == Method::Automatic;
        let is_cancelled = |it: &Reason| matches!(it, Reason::CancelledPole(_));
        let is_feedback = |it: &Reason| matches!(it, Reason::Doubt(Doubt::FeedbackAlone(..)));
        let integrates = may_integrate(&self.estimate) && !self.reasons.iter().any(is_cancelled);
        let curve = self
            .finding
            .as_ref()
            .and_then(|it| CurveChoice::of(&it.cause));
        match self.verdict {
            Verdict::NotLinear { .. }
                if let Some(choice) = curve.filter(|_| self.curved.is_none()) =>
            {
                format!(
                    "fit different input levels or times separately with {}, or fit the curve named above together with the dynamics: {} (the input needs more distinct values than the curve has parameters)",
                    setting("window", "FROM..TO"),
                    setting("curve", choice.name())
                )
            }
            Verdict::Drift { .. } if integrates => format!(
                "do not subtract the trend, because a constant at the input of an integrator causes such a drift. Compare with {}, or use {}",
                setting("method", "process"),
                setting("integrators", 1)
            ),
            Verdict::DynamicsMissing if is_chosen => format!(
                "look at the plots to see where the model fails: {}. Then try a higher {}, {}, or another input that moves the output too",
                setting("html", "model.html"),
                option("order"),
                option("curve")
            ),
            Verdict::Undetermined if self.reasons.iter().any(is_feedback) => {
                format!(
                    "if the data comes from a closed loop, record again while the setpoint moves (steps or a PRBS). If the plant responds at once, use {}",
                    setting("delay", "0")
                )
            }
            verdict => verdict.next(),
        }
    }

    fn undetermined_gain(&self) -> Option<Uncertain> {
        undetermined_gain(&self.reading(), self.estimate.sample_time)
    }

    pub(super) fn is_caused(&self) -> bool {
        let is_caused = |part: InputPart| match self.estimate.process {
            Some(_) => part.f >= BEYOND_DOUBT,
            None if self.is_unstable() => part.share >= CAUSED_OF_UNSTABLE,
            None => part.share >= CAUSED,
        };
        self.input_part.is_none_or(is_caused)
    }

    /// Whether the two halves of the record disagree.
    fn is_unsteady(&self) -> bool {
        let chosen = self.search.selected.first();
        // Half of a step test may hold no step; and half of a record without noise may not determine what all of it does.
        let may_tell = !self.is_unstable() && !self.is_step_test && !self.is_exact();
        may_tell && chosen.is_some_and(|of| of.half_data_error_ratio() > STEADY)
    }

    /// Whether the residual correlates with earlier inputs; if the input follows the output, only with inputs before the present sample.
    fn misses_dynamics(&self, tests: &ResidualTests) -> bool {
        match self.following {
            Following::Yes => seen(&tests.of_inputs_before()),
            _ => misses_dynamics(tests, self.fit),
        }
    }

    /// Whether the residual is only rounding error.
    pub(super) fn is_exact(&self) -> bool {
        self.fit.is_some_and(|fit| fit > ALL_BUT_ROUNDING)
    }

    /// Whether the standard deviations are valid for a coloured residual.
    fn allows_for_colour(&self) -> bool {
        self.estimate.error == Error::Output || self.options.method.has(Property::AllowsForColour)
    }

    fn is_early(&self) -> bool {
        self.lag.is_some_and(|lag| lag.is_another && lag.best < 0)
    }

    fn has_feedback(&self, tests: &ResidualTests) -> bool {
        // One step correlates with itself alone: what is left over anywhere correlates with it.
        let may_tell = self.closed_loop.is_none() && !self.is_step_test;
        let may_bias = self.fit.is_none_or(|fit| fit < LEAVES_LITTLE);
        // What a model of a band leaves outside it goes with the input, and so with later inputs that are like earlier ones.
        let is_more = || tests.of_later_inputs().largest() > tests.of_earlier_inputs().largest();
        // White noise that goes round biases no model of the output error, and none of a noise model.
        let is_modelled = self.kind() == Some(Kind::BoxJenkins) || tests.whiteness.passes();
        let is_seen = match self.following {
            Following::Yes => !is_modelled && seen(&tests.of_inputs_from_now()),
            _ => feeds_back(tests),
        };
        may_tell
            && may_bias
            && is_seen
            && self.following != Following::No
            && (self.estimate.frequency.is_none() || is_more())
    }

    /// Poles that are probably artefacts of noise, are unstable, or cancel.
    fn suspicious_poles(&self) -> Vec<Reason> {
        let reading = self.reading();
        let Ok(poles) = reading.poles() else {
            return Vec::new();
        };
        // The order of the vehicle's equations, or a process model's, cannot be lower.
        let cancelled = match self.estimate.physical.is_some() || self.estimate.process.is_some() {
            false => reading.cancelled_poles(),
            true => Vec::new(),
        };
        let mut suspicious = Vec::new();
        for pole in poles.into_iter().filter(|pole| pole.value.im >= 0.0) {
            let imprecise = SIGMAS_95 * pole.magnitude_deviation() > PRECISE;
            if pole.value.re < 0.0 && pole.covariance != Matrix2::zeros() && imprecise {
                suspicious.push(Reason::NegativePole(pole));
            } else if pole.value.modulus() - SIGMAS_95 * pole.magnitude_deviation() > 1.0 {
                suspicious.push(Reason::UnstablePole(pole));
            }
            let cancels = cancelled.contains(&pole);
            suspicious.extend(cancels.then_some(Reason::CancelledPole(pole)));
        }
        suspicious
    }

    /// Reports the parts of the record that were not used, or were used only for the fit.
    fn left_out(&self, record: &Record) -> Vec<Reason> {
        let (used, all) = (self.segments.len(), record.segments.len());
        let segments = (used < all).then(|| {
            let kept = self.segments.iter().map(|it| record.segments[*it].len());
            let share = 100.0 * kept.sum::<usize>() as f64 / record.samples().max(1) as f64;
            Reason::SegmentsLeftOut(used, all, share)
        });
        let part = (!self.search.candidates.is_empty() && self.search.samples < record.samples())
            .then(|| Reason::SearchedInPart(self.search.samples, record.samples()));
        segments.into_iter().chain(part).collect()
    }

    /// The effect of the two-stage method: both magnitudes of the response, at the frequency where they differ most.
    fn two_stages(&self) -> Option<Reason> {
        let closed_loop = self.closed_loop.as_ref()?;
        let direct = Reading::new(closed_loop.direct.as_ref()?, self.longest);
        let staged = self.reading();
        let differences = self.frequencies().filter_map(|omega| {
            let pair = [staged.response(omega)?, direct.response(omega)?];
            let [staged, direct] = pair.map(|it| (it.value.modulus(), it.magnitude_deviation()));
            let joint = libm::hypot(staged.1, direct.1);
            let apart = (staged.0 - direct.0).abs() / joint;
            (joint > 0.0).then_some((apart, omega, staged, direct))
        });
        let (apart, frequency, staged, direct) = differences.max_by(|p, q| p.0.total_cmp(&q.0))?;
        Some(Reason::TwoStages {
            frequency,
            reference: closed_loop.reference.clone(),
            staged,
            direct,
            apart: (apart > APART).then_some(apart),
        })
    }

    /// Frequencies over three decades up to half the sampling rate, rad/s, highest first.
    fn frequencies(&self) -> impl Iterator<Item = f64> + use<> {
        frequencies(self.estimate.sample_time)
    }

    /// The results of the residual tests.
    fn residual_findings(&self) -> Vec<Reason> {
        let Some(tests) = &self.residuals else {
            return Vec::new();
        };
        if self.is_exact() {
            return vec![Reason::NoNoise];
        }
        let fit = self.held_out.fit.or(self.fit);
        let explains = self.is_caused() && fit.is_some_and(|fit| fit >= USABLE);
        let finding = residual_finding(tests, self.fit, explains, self.allows_for_colour());
        let finding = match finding {
            ResidualFinding::Correlated(earlier) if !self.misses_dynamics(tests) => {
                ResidualFinding::InLoop(earlier)
            }
            other => other,
        };
        let feedback = self.has_feedback(tests).then(|| tests.of_later_inputs());
        std::iter::once(Reason::Residuals(finding, self.closed_loop.is_some()))
            .chain(feedback.map(Reason::Feedback))
            .collect()
    }
}

/// Reports that there are too few residuals for the number of parameters.
pub(crate) fn few_samples(residuals: &[Vec<f64>], parameters: usize) -> Option<Reason> {
    let samples: usize = residuals.iter().map(Vec::len).sum();
    (samples > 0 && samples < SAMPLES_PER_PARAMETER * parameters)
        .then_some(Reason::FewSamples(samples, parameters))
}

/// The steady-state gain, if it is not significantly different from 0, or is uncertain by a half where it depends on a pole that a zero may cancel;
/// except if it is certainly small compared with the largest response.
pub(crate) fn undetermined_gain(reading: &Reading<'_>, sample_time: f64) -> Option<Uncertain> {
    let gain = reading.steady_state_gain()?;
    let interval = SIGMAS_95 * gain.real_deviation();
    let share = match reading.cancelled_poles().is_empty() {
        true => 1.0,
        false => KNOWN,
    };
    let is_wide = interval > share * gain.value.re.abs();
    (is_wide && interval > SMALL * largest_response(reading, sample_time)).then_some(gain)
}

/// Whether the 95 % interval of the response is small at every frequency, compared with the largest response.
pub(crate) fn response_is_determined(reading: &Reading<'_>, sample_time: f64) -> bool {
    let largest = largest_response(reading, sample_time);
    frequencies(sample_time).all(|omega| {
        let of_both = |it: Uncertain| libm::hypot(it.real_deviation(), it.imaginary_deviation());
        let deviation = reading.response(omega).map(of_both);
        deviation.is_some_and(|it| SIGMAS_95 * it < DETERMINED * largest)
    })
}

fn largest_response(reading: &Reading<'_>, sample_time: f64) -> f64 {
    frequencies(sample_time)
        .filter_map(|omega| reading.response(omega))
        .fold(0.0_f64, |largest, it| largest.max(it.value.modulus()))
}

/// The result of the residual tests for a model that explains the data (`explains`), and whose intervals may allow for colour.
pub(crate) fn residual_finding(
    tests: &ResidualTests,
    fit: Option<f64>,
    explains: bool,
    allows_for_colour: bool,
) -> ResidualFinding {
    let earlier = tests.of_earlier_inputs();
    match (earlier.passes(), tests.whiteness.passes()) {
        (true, true) => ResidualFinding::White(explains),
        (true, false) => ResidualFinding::Coloured(tests.whiteness.clone(), allows_for_colour),
        (false, _) if misses_dynamics(tests, fit) => ResidualFinding::Correlated(earlier),
        (false, _) => ResidualFinding::LittleCorrelation(earlier),
    }
}

/// Whether the residual correlates with earlier inputs, so that dynamics are missing. `fit` is the simulated fit, %; the residual has the share `1 -
/// fit/100` of the output's variation.
pub(crate) fn misses_dynamics(tests: &ResidualTests, fit: Option<f64>) -> bool {
    let earlier = tests.of_earlier_inputs();
    let of_output = fit.map_or(1.0, |fit| 1.0 - 0.01 * fit) * earlier.largest();
    !earlier.passes() && earlier.largest() >= MATTERS && of_output >= MATTERS_IN_OUTPUT
}

/// Whether later inputs correlate with the residual, as with feedback.
pub(crate) fn feeds_back(tests: &ResidualTests) -> bool {
    seen(&tests.of_later_inputs())
}

/// Whether a correlation is significant and large enough to matter.
fn seen(of: &Correlation) -> bool {
    !of.passes() && of.largest() > MATTERS
}

/// Frequencies over three decades up to half the sampling rate, rad/s, highest first.
fn frequencies(sample_time: f64) -> impl Iterator<Item = f64> {
    let nyquist = PI / sample_time;
    (0..=FREQUENCIES)
        .map(move |i| nyquist * libm::pow(10_f64, -3.0 * i as f64 / FREQUENCIES as f64))
}
