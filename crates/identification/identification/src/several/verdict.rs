//! The verdict on a model of several inputs, with the same limits as for one input, and its reasons.

use planesman_record::Segment;

use super::analysis::{Analysis, ChannelModel, InputFindings};
use super::finding::Finding;
use super::selection::{Candidate, MAX_DELAY, MAX_ORDER};
use planesman_wording::{option, setting};

use crate::analysis::judgement::{
    DRIFTS, PRECISE, STEADY, feeds_back, few_samples, misses_dynamics, residual_finding,
    response_is_determined, undetermined_gain,
};
use crate::analysis::{GOOD, Reason, USABLE, Verdict};
use crate::uncertainty::{SIGMAS_95, Uncertain};
use crate::validation::identifiability::{Doubt, excitation_order};
use crate::validation::residuals::ResidualTests;

/// Minimum independent share of an input's variation that is needed to separate its effect from other inputs, if the data contains little information
/// on one of them.
const OWN: f64 = 0.1;
/// The same limit for any data: below this share, only the channels' orders separate the inputs.
const RIGID: f64 = 1e-3;

impl Analysis {
    /// Sets verdict and reasons.
    pub(super) fn judge(&mut self, segments: &[&Segment]) {
        let doubts = self.doubts(segments);
        self.verdict = self.judged(!doubts.is_empty());
        self.reasons = self.findings(doubts);
    }

    /// The reasons, followed by the verdict.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let reasons = self.reasons.iter().map(Finding::to_string);
        reasons.chain([self.verdict_text()]).collect()
    }

    /// The verdict, and the next step.
    #[must_use]
    pub fn verdict_text(&self) -> String {
        self.verdict.text(self.next())
    }

    /// Recommended next step for a fit with several inputs.
    #[must_use]
    pub fn next(&self) -> String {
        match self.verdict {
            Verdict::ClosedLoop { .. } => format!(
                "record with steps added to each input from outside the loop, or fit one input at a time with {}",
                option("reference")
            ),
            Verdict::Undetermined => format!(
                "record again with every input moving separately (PRBS, several steps), or use a \
                 lower order: {}",
                setting("order", 1)
            ),
            Verdict::DynamicsMissing => format!(
                "try a higher {}, or name another input that affects the output too",
                option("order")
            ),
            Verdict::Usable => format!(
                "record for longer, with every input moving separately, or write the plots with {}",
                setting("html", "model.html")
            ),
            _ => self.verdict.next(),
        }
    }

    fn judged(&self, undetermined: bool) -> Verdict {
        let held = self.held_out.fit;
        let any = |finds: &dyn Fn(&ResidualTests) -> bool| {
            let mut tests = self.channels().filter_map(|it| it.2.residuals.as_ref());
            tests.any(finds)
        };
        let (feedback, missing) = (any(&feeds_back), any(&|it| misses_dynamics(it, self.fit)));
        let unsteady = self.is_unsteady();
        let limited = self.held_out.is_limited_by_noise() && held.is_some_and(|held| held < GOOD);
        let gain = self
            .channels()
            .any(|(_, _, it)| it.undetermined_gain().is_some());
        match held {
            _ if self.channels().all(|(_, it, _)| !it.effect.is_there()) => Verdict::NoEffect,
            _ if self.inputs.iter().any(|it| self.is_inseparable(it)) => Verdict::Inseparable,
            _ if undetermined => Verdict::Undetermined,
            None => Verdict::NotValidated,
            Some(_) if self.few_samples().is_some() => Verdict::FewSamples,
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
            Some(_) if gain => Verdict::GainUndetermined,
            Some(_) if missing => Verdict::DynamicsMissing,
            Some(held) if held < GOOD => Verdict::Usable,
            Some(_) => Verdict::Good,
        }
    }

    fn findings(&self, doubts: Vec<(String, Doubt)>) -> Vec<Finding> {
        let of = |name: &str, reason: Reason| Finding {
            input: Some(name.to_owned()),
            reason,
        };
        let mut found: Vec<Finding> = Vec::new();
        let (used, all) = (self.segments.len(), self.all_segments);
        if used < all {
            let kept: usize = self.residuals.iter().map(Vec::len).sum();
            let share = 100.0 * kept as f64 / self.samples.max(1) as f64;
            found.push(Reason::SegmentsLeftOut(used, all, share).into());
        }
        let parted = self.searched < self.samples;
        let parted = parted.then_some(Reason::SearchedInPart(self.searched, self.samples));
        found.extend(parted.map(Finding::from));
        found.extend(
            doubts
                .into_iter()
                .map(|(name, it)| of(&name, Reason::Doubt(it))),
        );
        for it in &self.inputs {
            let is_in = it.model.is_some();
            let effect = Reason::InputEffect(it.effect.f, it.effect.needed, is_in);
            if self.is_inseparable(it)
                && let Some(other) = it.own.other.map(|other| self.inputs[other].name.clone())
            {
                found.push(of(&it.name, Reason::Inseparable(other, it.own.share)));
            } else if !is_in || !it.effect.is_there() {
                found.push(of(&it.name, effect));
            }
        }
        found.extend(self.selection().map(Finding::from));
        found.extend(self.fits().into_iter().map(Finding::from));
        for (_, input, model) in self.channels() {
            let reasons = self.of_channel(model);
            found.extend(reasons.into_iter().map(|it| of(&input.name, it)));
        }
        found.extend(self.few_samples().map(Finding::from));
        found
    }

    /// Inputs with insufficient excitation.
    fn doubts(&self, segments: &[&Segment]) -> Vec<(String, Doubt)> {
        let of = |(number, input, model): (usize, &InputFindings, &ChannelModel)| {
            let structure = &model.estimate.layout.structure;
            let needed = structure.poles + structure.numerator;
            let inputs = segments.iter().map(|it| &it.inputs[number]);
            let order = inputs.map(|it| excitation_order(it, needed)).max()?;
            let is_poor = order < needed
                && !response_is_determined(&model.reading(), model.estimate.sample_time);
            is_poor.then(|| (input.name.clone(), Doubt::Excitation(order, needed)))
        };
        self.channels().filter_map(of).collect()
    }

    /// Whether the effect of an input cannot be separated from the others' effects.
    fn is_inseparable(&self, input: &InputFindings) -> bool {
        let says_little = match &input.model {
            None => true,
            Some(model) => model.undetermined_gain().is_some() || !input.effect.is_there(),
        };
        let own = input.own.share;
        own < RIGID || own < OWN && says_little
    }

    fn selection(&self) -> Option<Reason> {
        let chosen = self.candidates.first()?;
        let best = (self.candidates.iter()).max_by(|p, q| p.fit().total_cmp(&q.fit()))?;
        let mut text = format!(
            "chosen from {} models by cross-validation: {}, fit {:.1} %",
            self.candidates.len(),
            self.in_words(chosen),
            chosen.fit()
        );
        if best.fit() > chosen.fit() + 0.05 {
            text += &format!(
                "; the highest fit, {:.1} % ({}), is not significantly higher",
                best.fit(),
                self.in_words(best)
            );
        }
        Some(Reason::SelectedOfSeveral(text))
    }

    /// A candidate as text.
    pub(super) fn in_words(&self, of: &Candidate) -> String {
        let channels = of.channels.iter().map(|it| {
            let name = &self.inputs[it.input].name;
            format!("{name} of order {} and delay {}", it.order(), it.delay())
        });
        let channels: Vec<String> = channels.collect();
        format!("{}, {}", of.kind.name(), channels.join(", "))
    }

    fn fits(&self) -> Vec<Reason> {
        let fit = match (self.held_out.reason(self.fit), self.validated) {
            (_, Some(samples)) => Reason::Data(format!(
                "evaluated on the validation data, {samples} samples that were not fitted: simulated fit {}",
                (self.held_out.fit).map_or("none".to_owned(), |fit| format!("{fit:.1} %"))
            )),
            (Some(held), _) => held,
            (None, _) if self.held_out.is_noise() => Reason::HeldOutIsNoise(None),
            (None, _) => Reason::FirstPartUndetermined,
        };
        let unsteady = self.is_unsteady().then_some(Reason::Unsteady);
        [fit].into_iter().chain(unsteady).collect()
    }

    fn of_channel(&self, model: &ChannelModel) -> Vec<Reason> {
        let structure = &model.estimate.layout.structure;
        let mut found = Vec::new();
        if self.options.order.is_none() && structure.poles >= MAX_ORDER {
            found.push(Reason::LargestOrder(structure.poles));
        }
        if self.options.delay.is_none() && structure.delay >= MAX_DELAY {
            found.push(Reason::LongestDelay(structure.delay));
        }
        found.extend(model.undetermined_gain().map(Reason::GainUndetermined));
        if let Some(lag) = model.lag {
            let at_once = structure.delay == 0 && lag.interval.1 == 0 && structure.poles > 0;
            if lag.is_another {
                found.push(Reason::OtherDelay(lag.best, structure.delay));
            } else if at_once {
                found.push(Reason::DirectFeedthrough);
            }
        }
        if let Some(tests) = &model.residuals {
            let fit = self.held_out.fit.or(self.fit);
            let explains = fit.is_some_and(|fit| fit >= USABLE);
            let finding = residual_finding(tests, self.fit, explains, true);
            found.push(Reason::Residuals(finding, false));
            if feeds_back(tests) {
                found.push(Reason::Feedback(tests.of_later_inputs()));
            }
        }
        let reading = model.reading();
        let poles = reading.poles().unwrap_or_default().into_iter();
        for pole in poles.filter(|pole| pole.value.im >= 0.0 && pole.value.re < 0.0) {
            if SIGMAS_95 * pole.magnitude_deviation() > PRECISE {
                found.push(Reason::NegativePole(pole));
            }
        }
        let cancelled = reading.cancelled_poles().into_iter();
        found.extend(cancelled.map(Reason::CancelledPole));
        found
    }

    fn few_samples(&self) -> Option<Reason> {
        let parameters: usize = self
            .channels()
            .map(|(.., it)| it.estimate.theta.len())
            .sum::<usize>()
            + self.segments.len();
        few_samples(&self.residuals, parameters)
    }

    fn is_unsteady(&self) -> bool {
        let chosen = self.candidates.first();
        chosen.is_some_and(|of| of.half_data_error_ratio() > STEADY)
    }
}

impl ChannelModel {
    /// The steady-state gain, if it is poorly determined.
    fn undetermined_gain(&self) -> Option<Uncertain> {
        undetermined_gain(&self.reading(), self.estimate.sample_time)
    }
}
