//! The verdict on a model, and its reasons: conclusions from fit, residuals and uncertainty.

use std::f64::consts::PI;
use std::fmt;

use nalgebra::Matrix2;

use super::account::interval;
use super::{
    AHEAD, Analysis, MAX_DELAY, MAX_ORDER, METHOD_MAX_DELAY, METHOD_MAX_ORDER, UNINFORMATIVE_FIT,
};
use crate::estimators::{Error, Method};
use crate::selection::{Candidate, criteria};
use crate::uncertainty::{Reading, SIGMAS_95, Uncertain};
use crate::validation::residuals::{Correlation, ResidualTests};
use planesman_record::Record;

/// Standard deviations between two responses, at the worst of [`FREQUENCIES`], above which the estimates are of
/// different systems.
const APART: f64 = 4.0;
const FREQUENCIES: usize = 20;

/// Held-out fits, %, from which a model is called very good, good, and usable.
const VERY_GOOD: f64 = 90.0;
const GOOD: f64 = 80.0;
const USABLE: f64 = 50.0;
/// By how much a fit, %, may be below what the noise leaves to the best of models, and be as good.
const AS_GOOD: f64 = 3.0;
/// The share of the output's variation from which a straight line is called drift.
const DRIFTS: f64 = 0.1;
/// The share of the output that the input must account for.
const CAUSED: f64 = 0.1;
/// Correlations that matter, however surely they are there.
const MATTERS: f64 = 0.05;
/// Samples for each parameter, below which a fit is partly memory.
const SAMPLES_PER_PARAMETER: usize = 10;
/// How many times larger the error with half the record left out may be than with a fifth.
const STEADY: f64 = 4.0;
/// The share of the largest response below which a steady-state gain is next to nothing.
const SMALL: f64 = 0.05;
/// The fit, %, of data without noise.
const ALL_BUT_ROUNDING: f64 = 99.9999;
/// The 95 % interval of a pole in z that is precisely known.
const PRECISE: f64 = 0.1;

/// What a model is good for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The input accounts for too little of the output.
    NoEffect,
    /// The record does not determine a model.
    Undetermined,
    /// There is nothing to judge it on.
    NotValidated,
    /// It has few samples for its parameters.
    FewSamples,
    /// The output drifts.
    Drift {
        /// Whether it simulates well enough to be used with care.
        usable: bool,
    },
    /// The data seems closed-loop.
    ClosedLoop {
        /// Whether it simulates well enough to be used with care.
        usable: bool,
    },
    /// No model could fit better than it does.
    NoiseLimited {
        /// Whether it simulates well for all that.
        good: bool,
    },
    /// It does not simulate.
    Unusable,
    /// It does not hold all along the record.
    Unsteady,
    /// The output seems to come before its input.
    Early,
    /// Its steady-state gain is not determined.
    GainUndetermined,
    /// Dynamics are missing.
    DynamicsMissing,
    /// It simulates.
    Usable,
    /// It simulates well.
    Good,
}

impl Verdict {
    /// In a word, and what to do next.
    const fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::NoEffect => (
                "no model of what the input does",
                "excite the system more: a PRBS or steps that move the output well beyond its noise",
            ),
            Self::Undetermined => (
                "the record does not determine a model",
                "record again with a richer input (PRBS, several steps), or ask for a lower order: --order 1",
            ),
            Self::NotValidated => (
                "not validated",
                "record for longer, with the input moving to the end",
            ),
            Self::FewSamples => (
                "usable with care: few samples for so many parameters",
                "record for longer",
            ),
            Self::Drift { usable } => (
                match usable {
                    false => "not usable for simulation: the output drifts",
                    true => "usable with care: the output drifts",
                },
                "subtract the drift: --detrend line",
            ),
            Self::ClosedLoop { usable } => (
                match usable {
                    false => "not usable for simulation: the data seems closed-loop",
                    true => "usable with care: the data seems closed-loop",
                },
                "give the reference of the loop: --reference TOPIC:FIELD, or compare --method armax",
            ),
            Self::NoiseLimited { good } => (
                match good {
                    false => "usable: the noise limits its fit",
                    true => "good: the noise limits its fit",
                },
                "record for longer or excite more, for narrower intervals; or write it: --model model.yaml",
            ),
            Self::Unusable => (
                "not usable for simulation",
                "look at the page for where it fails: --html model.html; then choose a segment: --window FROM..TO",
            ),
            Self::Unsteady => (
                "usable with care: it does not hold all along the record",
                "fit segments apart: --window FROM..TO, once for each",
            ),
            Self::Early => (
                "usable with care: the output seems to come before its input",
                "look at the stamps (--stamp, --time), or give the reference of the loop: --reference TOPIC:FIELD",
            ),
            Self::GainUndetermined => (
                "usable with care: the steady-state gain is not determined",
                "record steps that are held until the output settles",
            ),
            Self::DynamicsMissing => (
                "usable with care: dynamics are missing",
                "let order, delay and method be chosen: --method automatic",
            ),
            Self::Usable => (
                "usable",
                "compare with another method: --method armax; page: --html model.html",
            ),
            Self::Good => (
                "good",
                "write it for the simulator and the controller: --model model.yaml",
            ),
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (word, next) = self.words();
        write!(f, "verdict: {word}. Next: {next}")
    }
}

impl Analysis {
    /// What speaks for the model and against it, a sentence each, behind the doubts whether the record determines one.
    pub(super) fn reasons(&self, doubts: Vec<String>, record: &Record) -> Vec<String> {
        let mut said = doubts;
        said.extend(self.left_out(record));
        said.extend(self.of_selection());
        said.extend(criteria::verdict(&self.candidates));
        said.extend(self.at_the_edge());
        said.extend(self.of_two_stages());
        said.extend(self.of_fit());
        said.extend(self.of_cause());
        said.extend(self.of_delay());
        said.extend(self.of_residuals());
        said.extend(self.suspicious_poles());
        said.extend(self.of_samples());
        said
    }

    /// What was chosen, and beside what.
    fn of_selection(&self) -> Option<String> {
        let chosen = self.selected.first()?;
        let best = self
            .selected
            .iter()
            .max_by(|p, q| p.fit().total_cmp(&q.fit()))?;
        let named = |of: &Candidate| {
            let integrator = match of.integrators() {
                0 => "",
                _ => " with an integrator",
            };
            format!(
                "{}, order {}{integrator}, delay {}",
                of.kind.name(),
                of.order(),
                of.structure.delay
            )
        };
        let mut text = format!(
            "of {} models cross-validated: {}, fit {:.1} %",
            self.selected.len(),
            named(chosen),
            chosen.fit()
        );
        if best.fit() > chosen.fit() + 0.05 {
            text += &format!(
                "; the largest fit, {:.1} % ({}), is not significantly larger for its parameters",
                best.fit(),
                named(best)
            );
        }
        Some(text)
    }

    /// A choice at the end of what was searched.
    fn at_the_edge(&self) -> Vec<String> {
        let s = &self.estimate.layout.structure;
        let (orders, delays) = match (self.selected.is_empty(), self.candidates.is_empty()) {
            (false, _) => (MAX_ORDER, MAX_DELAY),
            (true, false) => (METHOD_MAX_ORDER, METHOD_MAX_DELAY),
            _ => return Vec::new(),
        };
        let mut said = Vec::new();
        if self.options.order.is_none() && s.poles >= orders {
            said.push(format!(
                "order {} is the largest searched: a higher one may fit better (--order {})",
                s.poles,
                s.poles + 2
            ));
        }
        let delay = self
            .selected
            .first()
            .map_or(s.delay, |it| it.structure.delay);
        if self.options.delay.is_none() && delay >= delays {
            said.push(format!(
                "delay {delay} is the longest searched: a longer one may fit better (--delay {})",
                delay + 5
            ));
        }
        said
    }

    fn is_unstable(&self) -> bool {
        let poles = self.reading().poles().unwrap_or_default();
        poles
            .iter()
            .any(|pole| pole.value.norm() - SIGMAS_95 * pole.magnitude_deviation() > 1.0 + 1e-9)
    }

    fn of_fit(&self) -> Vec<String> {
        let mut said = Vec::new();
        if self.is_unstable() {
            if let Some(fit) = self.predicted_fit {
                said.push(format!(
                    "the model is unstable, and a simulation diverges whatever the model: predictions {AHEAD} samples \
                     ahead fit {fit:.1} %"
                ));
            }
            return said;
        }
        said.push(match (self.held_out_fit, self.fit) {
            (Some(held), _) if held < 0.0 => format!(
                "simulated fit on held-out data {held:.1} %: worse than the mean of the output"
            ),
            (Some(held), _) if self.is_limited_by_noise() && held < GOOD => format!(
                "simulated fit on held-out data {held:.1} %: as good as the noise lets a model be ({:.1} %)",
                self.attainable_fit.unwrap_or(held)
            ),
            (Some(held), _) if held >= VERY_GOOD => {
                format!("simulated fit on held-out data {held:.1} %: very good")
            }
            (Some(held), Some(fit)) if held < fit - 20.0 => format!(
                "simulated fit on held-out data {held:.1} %, on the whole record {fit:.1} %: the model is overfitted, or the system changed"
            ),
            (Some(held), _) => format!("simulated fit on held-out data {held:.1} %"),
            (None, _) if self.attainable_fit.is_some_and(|fit| fit <= UNINFORMATIVE_FIT) => {
                "not validated: in the held-out data the output stays within the noise".to_owned()
            }
            (None, _) => {
                "not validated: the first seven tenths alone do not determine the model".to_owned()
            }
        });
        if self.is_unsteady() {
            said.push(
                "fitted to one half of the record the model does not hold in the other: the system or its level \
                 changes along the record, or the halves excite different dynamics"
                    .to_owned(),
            );
        }
        said
    }

    /// A delay that no plant has, or another than the model's.
    fn of_delay(&self) -> Option<String> {
        let (lag, delay) = (self.lag?, self.estimate.layout.structure.delay);
        if self.is_early() {
            return Some(format!(
                "the model fits better with the output {} sample{} before the input: the output is stamped too early, \
                 the input moves between its samples (--input-method foh), the data is closed-loop, or the system is not \
                 linear",
                -lag.best,
                if lag.best == -1 { "" } else { "s" }
            ));
        }
        if lag.is_another {
            return Some(format!(
                "delay {0} fits better than {delay} (--delay {0})",
                lag.best
            ));
        }
        (delay == 0 && lag.interval.1 == 0).then(|| {
            "the output answers its input within one sample: direct feedthrough, or its stamps are too early".to_owned()
        })
    }

    /// How much of the output the input accounts for.
    fn of_cause(&self) -> Vec<String> {
        let mut said = Vec::new();
        if let Some(share) = self.share.filter(|share| *share < 0.5) {
            let rest = "the rest is free motion, drift or disturbance";
            said.push(if share < CAUSED {
                format!(
                    "the input accounts for {:.1} % of the output's variation: {rest}; the gain is not to be trusted",
                    100.0 * share.max(0.0)
                )
            } else {
                format!("the input accounts for {:.0} % of the output's variation: {rest}", 100.0 * share)
            });
        }
        if let Some(gain) = self.reading().steady_state_gain() {
            let interval = SIGMAS_95 * gain.real_deviation();
            if self.is_undetermined(&gain) {
                said.push(format!(
                    "the steady-state gain, {:.4} ± {interval:.4}, is not significantly different from 0",
                    gain.value.re
                ));
            }
        }
        said
    }

    /// Whether the record is long enough.
    fn of_samples(&self) -> Option<String> {
        let parameters = self.estimate.theta.len();
        let samples: usize = self.estimate.residuals.iter().map(Vec::len).sum();
        (samples > 0 && samples < SAMPLES_PER_PARAMETER * parameters).then(|| {
            format!("{samples} samples for {parameters} parameters: part of the fit is memory; record for longer")
        })
    }

    /// What the model is good for; `undetermined` where the record does not determine one.
    pub(super) fn judged(&self, undetermined: bool) -> Verdict {
        let held = match self.is_unstable() {
            true => self.predicted_fit,
            false => self.held_out_fit,
        };
        let tests = self.residuals.as_ref();
        let missing = tests.is_some_and(|it| {
            let earlier = it.of_earlier_inputs();
            !earlier.passes() && earlier.largest() > MATTERS
        });
        let feedback = tests.is_some_and(|it| self.has_feedback(it));
        let unsteady = self.is_unsteady();
        let limited = self.is_limited_by_noise() && held.is_some_and(|held| held < GOOD);
        let gain = (self.reading().steady_state_gain()).is_some_and(|it| self.is_undetermined(&it));
        match held {
            _ if !self.is_caused() => Verdict::NoEffect,
            _ if undetermined => Verdict::Undetermined,
            None => Verdict::NotValidated,
            Some(_) if self.of_samples().is_some() => Verdict::FewSamples,
            Some(held) if self.drift > DRIFTS && (feedback || unsteady || gain) => Verdict::Drift {
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
            Some(_) if missing && self.options.method != Method::Automatic => {
                Verdict::DynamicsMissing
            }
            Some(held) if held < GOOD => Verdict::Usable,
            Some(_) => Verdict::Good,
        }
    }

    /// Whether a steady-state gain cannot be told from 0, nor is known to be next to nothing beside the largest response.
    fn is_undetermined(&self, gain: &Uncertain) -> bool {
        let interval = SIGMAS_95 * gain.real_deviation();
        let reading = self.reading();
        let nyquist = PI / self.estimate.sample_time;
        let largest = (0..=FREQUENCIES)
            .filter_map(|i| {
                reading.response(nyquist * 10_f64.powf(-3.0 * i as f64 / FREQUENCIES as f64))
            })
            .fold(0.0_f64, |largest, it| largest.max(it.value.norm()));
        interval > gain.value.re.abs() && interval > SMALL * largest
    }

    fn is_caused(&self) -> bool {
        self.share.is_none_or(|share| share >= CAUSED) || self.is_unstable()
    }

    /// Whether what one half of the record says does not hold in the other.
    fn is_unsteady(&self) -> bool {
        let chosen = self.selected.first();
        !self.is_unstable() && chosen.is_some_and(|of| of.halves_over_fifths() > STEADY)
    }

    /// Whether the standard deviations are those of a residual of any colour.
    fn allows_for_colour(&self) -> bool {
        self.estimate.error == Error::Output || self.options.method == Method::Fir
    }

    fn is_early(&self) -> bool {
        self.lag.is_some_and(|lag| lag.is_another && lag.best < 0)
    }

    /// Whether a better fit than the one on held-out data is out of any model's reach.
    fn is_limited_by_noise(&self) -> bool {
        let pair = self.held_out_fit.zip(self.attainable_fit);
        pair.is_some_and(|(held, attainable)| held > attainable - AS_GOOD)
    }

    fn has_feedback(&self, tests: &ResidualTests) -> bool {
        let later = tests.of_later_inputs();
        self.reference.is_none() && !later.passes() && later.largest() > MATTERS
    }

    /// Poles that are probably artefacts of noise, are unstable, or cancel.
    fn suspicious_poles(&self) -> Vec<String> {
        let reading = self.reading();
        let (Ok(poles), Ok(mut zeros)) = (reading.poles(), reading.zeros()) else {
            return Vec::new();
        };
        if self.estimate.physical.is_some() {
            // Its order is the equations', which cannot be lower.
            zeros.clear();
        }
        let mut said = Vec::new();
        for pole in poles.iter().filter(|pole| pole.value.im >= 0.0) {
            let at = interval(pole);
            let imprecise = SIGMAS_95 * pole.magnitude_deviation() > PRECISE;
            if pole.value.re < 0.0 && pole.covariance != Matrix2::zeros() && imprecise {
                let kind = match pole.value.im {
                    0.0 => "a negative real pole",
                    _ => "a pole pair with negative real part",
                };
                said.push(format!("{kind}, z = {at}: probably an artefact of noise"));
            } else if pole.value.norm() - SIGMAS_95 * pole.magnitude_deviation() > 1.0 {
                said.push(format!(
                    "the pole at z = {at} is unstable, beyond its 95 % interval"
                ));
            }
            let cancels = zeros.iter().any(|zero| {
                let apart = (zero.value - pole.value).norm();
                let joint = zero.magnitude_deviation().hypot(pole.magnitude_deviation());
                joint > 0.0 && apart < SIGMAS_95 * joint && apart < 0.2
            });
            if cancels {
                said.push(format!(
                    "a zero may cancel the pole at z = {at}: try a lower order"
                ));
            }
        }
        said
    }

    /// The parts of the record that were not used, or only for the fit.
    fn left_out(&self, record: &Record) -> Vec<String> {
        let mut said = Vec::new();
        let all = record.segments.len();
        if self.segments.len() < all {
            let kept = self.segments.iter().map(|it| record.segments[*it].len());
            said.push(format!(
                "of {all} segments the {} longest were used, {:.1} % of the samples",
                self.segments.len(),
                100.0 * kept.sum::<usize>() as f64 / record.samples().max(1) as f64
            ));
        }
        if !self.candidates.is_empty() && self.searched < record.samples() {
            said.push(format!(
                "order and delay were searched on the {} of {} samples where the input varies most; the model was fitted to all",
                self.searched,
                record.samples()
            ));
        }
        said
    }

    /// The effect of the two stages: both magnitudes of the response, where they differ most.
    fn of_two_stages(&self) -> Option<String> {
        let (direct, reference) = (self.direct.as_ref()?, self.reference.as_ref()?);
        let (staged, direct) = (self.reading(), Reading::of(direct, self.longest));
        let nyquist = PI / self.estimate.sample_time;
        let share = |i: usize| 10_f64.powf(-3.0 * i as f64 / FREQUENCIES as f64);
        let moved = (0..=FREQUENCIES).filter_map(|i| {
            let omega = nyquist * share(i);
            let pair = [staged.response(omega)?, direct.response(omega)?];
            let [found, other] = pair.map(|it| (it.value.norm(), it.magnitude_deviation()));
            let joint = found.1.hypot(other.1);
            let apart = (found.0 - other.0).abs() / joint;
            (joint > 0.0).then_some((apart, omega, found, other))
        });
        let (apart, omega, found, other) = moved.max_by(|p, q| p.0.total_cmp(&q.0))?;
        let size =
            |(size, deviation): (f64, f64)| format!("{size:.4} ± {:.4}", SIGMAS_95 * deviation);
        let verdict = if apart > APART {
            format!("{apart:.1} standard deviations away: feedback of noise biases the direct fit")
        } else {
            "no significant difference: feedback of noise does not bias the direct fit".to_owned()
        };
        Some(format!(
            "magnitude of the response at {omega:.3} rad/s: {} in two stages from {reference}, {} by a direct fit; {verdict}",
            size(found),
            size(other)
        ))
    }

    /// The results of the residual tests.
    fn of_residuals(&self) -> Vec<String> {
        let Some(tests) = &self.residuals else {
            return Vec::new();
        };
        let against = match self.reference {
            Some(_) => "the reference",
            None => "the input",
        };
        let (earlier, later) = (tests.of_earlier_inputs(), tests.of_later_inputs());
        let fits = self.is_caused()
            && self
                .held_out_fit
                .or(self.fit)
                .is_some_and(|fit| fit >= USABLE);
        if self.fit.is_some_and(|fit| fit > ALL_BUT_ROUNDING) {
            return vec!["the residuals are rounding: the data is free of noise".to_owned()];
        }
        let mut said = vec![match (earlier.passes(), tests.whiteness.passes()) {
            (true, true) if fits => format!(
                "residuals are white and uncorrelated with {against}: the model explains the data"
            ),
            (true, true) => format!("residuals are white and uncorrelated with {against}"),
            (true, false) if self.allows_for_colour() => format!(
                "residuals are uncorrelated with {against} but not white ({}): the standard deviations allow for it",
                evidence(&tests.whiteness)
            ),
            (true, false) => format!(
                "residuals are uncorrelated with {against} but not white ({}): the standard deviations are not reliable",
                evidence(&tests.whiteness)
            ),
            (false, _) if earlier.largest() < MATTERS => format!(
                "residuals correlate with {against} significantly, but little ({})",
                evidence(&earlier)
            ),
            (false, _) => format!(
                "residuals correlate with {against} ({}): dynamics are missing, or not linear; try a higher order or another delay",
                evidence(&earlier)
            ),
        }];
        if self.has_feedback(tests) {
            said.push(format!(
                "residuals correlate with later inputs ({}): the data is closed-loop, and the model may be biased, or the \
                 output is stamped too early; give the loop's reference (--reference) or use --method armax",
                evidence(&later)
            ));
        }
        said
    }
}

/// The result of a correlation test in numbers.
fn evidence(found: &Correlation) -> String {
    let largest = found.largest();
    format!(
        "max {largest:.2}, 99 % bound {:.2}, exceeded at {} of {} lags",
        found.bound,
        found.outside(),
        found.values.len()
    )
}
