//! Reasons in words.

use std::f64::consts::TAU;
use std::fmt;

use planesman_linear::digits::{significant, with_interval};
use planesman_wording::{option, setting};

use super::reason::{FitRemark, Reason, ResidualFinding};
use super::text::interval;
use super::{Curved, FirstOrderHold, OtherOrder};
use crate::estimators::Form;
use crate::prediction::AHEAD;
use crate::selection::{Candidate, criteria, process};
use crate::static_curve::{Side, StaticCurve};
use crate::uncertainty::{SIGMAS_95, Uncertain};
use crate::validation::identifiability::Doubt;
use crate::validation::nonlinearity::{Cause, Finding};
use crate::validation::residuals::Correlation;

/// The cost J up to which a transfer function is called good (Tischler and Remple 2012, ch. 11).
const ACCEPTED: f64 = 100.0;

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text())
    }
}

impl Reason {
    fn text(&self) -> String {
        match self {
            Self::Validated(samples, fit, predicted) => validated(*samples, *fit, *predicted),
            Self::Data(text) | Self::SelectedOfSeveral(text) => text.clone(),
            Self::Doubt(doubt) => doubt.to_string(),
            Self::SegmentsLeftOut(used, all, share) => {
                format!("the {used} longest of {all} segments were used, {share:.1} % of the samples")
            }
            Self::SearchedInPart(searched, samples) => format!(
                "order and delay were chosen from {searched} of {samples} samples, those in which the input varies most; the model was fitted to all samples"
            ),
            Self::Selected(tried, chosen, largest) => selected(*tried, chosen, largest.as_deref()),
            Self::Order(chosen, next) => order(chosen, next.as_ref()),
            Self::Process(chosen, next) => process(chosen, *next),
            Self::LargestOrder(order) => format!(
                "order {order} is the highest searched: a higher order may fit better ({})",
                setting("order", order + 2)
            ),
            Self::LongestDelay(delay) => format!(
                "delay {delay} is the longest searched: a longer delay may fit better ({})",
                setting("delay", delay + 5)
            ),
            Self::TwoStages { frequency, reference, staged, direct, apart } => {
                two_stages(*frequency, reference, *staged, *direct, *apart)
            }
            Self::PredictedFit(fit) => format!(
                "the model is unstable, so any simulation diverges: predictions {AHEAD} samples ahead fit {fit:.1} %"
            ),
            Self::HeldOutFit(fit, remark) => format!("simulated fit on held-out data {fit:.1} %{remark}"),
            Self::AtRest => format!(
                "the output is constant until the input steps, so the system is assumed to be at rest before, as with {}",
                option("at_rest")
            ),
            Self::HeldOutIsNoise(None) => "not validated: in the held-out data the output stays within the noise".to_owned(),
            Self::HeldOutIsNoise(Some(fit)) => format!(
                "in the held-out last part the output stays within the noise: the verdict uses the cross-validated fit, {fit:.1} %"
            ),
            Self::ErrorAsElsewhere(fit) => format!(
                "the output moves less in the held-out last part, but the error there is no larger than elsewhere. So the verdict uses the cross-validated fit, {:.1} %",
                fit.unwrap_or_default()
            ),
            Self::FirstPartUndetermined => "not validated: the first 70 % of the record alone do not determine the model".to_owned(),
            Self::WholeRecord(fit) => format!(
                "the first 70 % of the record alone do not excite the band. So the verdict uses the simulated fit on the complete record, {}. To test the model on other data, use {}",
                percent(*fit),
                option("validation")
            ),
            Self::Band { band, coherence, cost } => in_band(*band, *coherence, *cost),
            Self::NotLinear { finding, sample_time, segment } => not_linear(finding, *sample_time, *segment),
            Self::Curve(curved) => through_curve(curved),
            Self::CurveMisses(missed) => format!(
                "with the curve, the fit is still {missed:.1} % below the limit set by noise, so another part of the system is not linear"
            ),
            Self::Carried(fit) => format!(
                "a simulation that starts from the state before the held-out data fits {fit:.1} %. Slow modes drift, and a known initial state does not improve the fit"
            ),
            Self::Unsteady => "a model fitted to one half of the record does not fit the other half. The system or its operating point changes, or the halves excite different dynamics"
                .to_owned(),
            Self::InputShare(share, is_too_little) => input_share(*share, *is_too_little),
            Self::GainUndetermined(gain) => gain_undetermined(gain),
            Self::InputEffect(f, needed, is_in) => format!(
                "F {f:.1} ({needed:.1} needed): this input has no visible effect on the output{}",
                if *is_in { "" } else { "; the input is left out" }
            ),
            Self::Inseparable(other, share) => format!(
                "only {:.2} % of this input's variance is independent, and the rest follows {other}, so their effects cannot be separated",
                100.0 * share
            ),
            Self::ProcessF(f, least) => format!("F-test of the input's effect: {f:.0}, at least {least:.0} needed: {}", match f < least {
                true => "the output's own noise and drift could explain the motion as well",
                false => "the input clearly moves the output",
            }),
            Self::Early(samples) => early(*samples),
            Self::OtherDelay(better, delay) => format!("delay {better} fits better than {delay} ({})", setting("delay", better)),
            Self::DirectFeedthrough => "the output responds to its input within one sample. Either there is direct feedthrough, or the input moves between its samples, or the output's stamps are too early"
                .to_owned(),
            Self::FirstOrderHold(FirstOrderHold { lines, held }) => format!(
                "the input moves on straight lines between its samples (first-order hold): cross-validated fit {:.2} %, {} \
                 parameters; with a zero-order hold: {:.2} %, {} parameters",
                lines.1, lines.0, held.1, held.0
            ),
            Self::NoNoise => "the residuals are rounding errors: the data has no noise".to_owned(),
            Self::Residuals(finding, true) => residuals(finding, "the reference"),
            Self::Residuals(finding, false) => residuals(finding, "the input"),
            Self::Feedback(later) => feedback(later),
            Self::NegativePole(pole) => negative_pole(pole),
            Self::UnstablePole(pole) => format!("the pole at z = {} is unstable, because its whole 95 % interval lies outside the unit circle", interval(pole)),
            Self::CancelledPole(pole) => format!("near pole-zero cancellation at z = {}: try a lower order", interval(pole)),
            Self::OtherOrder(other) => other_order(other),
            Self::FewSamples(samples, parameters) => format!(
                "{samples} samples are few for {parameters} parameters, so the model partly fits the noise. Record for longer"
            ),
        }
    }
}

impl fmt::Display for FitRemark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => Ok(()),
            Self::WorseThanMean => f.write_str(": worse than the mean of the output"),
            Self::NoiseLimited(attainable) => write!(
                f,
                ": noise prevents a better fit by any model (limit {attainable:.1} %)"
            ),
            Self::VeryGood => f.write_str(": very good"),
            Self::Overfitted(whole) => write!(
                f,
                ", on the complete record {whole:.1} %: the model is overfitted, or the system changed"
            ),
        }
    }
}

/// A fit, %, by a digit.
fn percent(fit: Option<f64>) -> String {
    fit.map_or("none".to_owned(), |fit| format!("{fit:.1} %"))
}

fn validated(samples: usize, fit: Option<f64>, predicted: Option<f64>) -> String {
    let (fit, predicted) = (percent(fit), percent(predicted));
    format!(
        "evaluated on the validation data, {samples} samples that were not fitted: simulated fit {fit}, predicted {AHEAD} samples ahead {predicted}"
    )
}

fn selected(tried: usize, chosen: &Candidate, largest: Option<&Candidate>) -> String {
    let largest = largest.map_or(String::new(), |it| {
        format!(
            "; the largest fit, {:.1} % ({}), is not significantly larger",
            it.fit(),
            candidate(it)
        )
    });
    let (name, fit) = (candidate(chosen), chosen.fit());
    format!("chosen from {tried} models by cross-validation: {name}, fit {fit:.1} %{largest}")
}

fn process(chosen: &process::Candidate, next: Option<(Form, f64)>) -> String {
    let begins = match chosen.is_at_rest {
        true => "at rest",
        false => "in motion",
    };
    let next = next.map_or(String::new(), |(next, bic)| {
        format!("; next {}, BIC {bic:+.1}", next.name())
    });
    let (name, equation) = (chosen.form.name(), chosen.form.equation());
    format!("process model {name}, {equation}, {begins} at the beginning of the record{next}")
}

/// Magnitudes with their standard deviations, and their difference in standard deviations.
fn two_stages(
    frequency: f64,
    reference: &str,
    staged: (f64, f64),
    direct: (f64, f64),
    apart: Option<f64>,
) -> String {
    let [staged, direct] =
        [staged, direct].map(|(size, deviation)| with_interval(size, SIGMAS_95 * deviation));
    let difference = match apart {
        Some(apart) => {
            format!("{apart:.1} standard deviations apart, so noise that returns through the feedback biases the direct fit")
        }
        None => {
            "no significant difference: noise that returns through the feedback does not bias the direct fit".to_owned()
        }
    };
    format!(
        "magnitude of the response at {frequency:.3} rad/s: {staged} from the reference {reference}, {direct} from a direct fit; {difference}"
    )
}

/// A transfer function near the response in a band, rad/s.
fn in_band(band: (f64, f64), coherence: f64, cost: f64) -> String {
    let [low, high] = [band.0, band.1].map(|it| significant(it, 3));
    let [low_hz, high_hz] = [band.0, band.1].map(|it| significant(it / TAU, 3));
    let is_near = match cost <= ACCEPTED {
        true => "the transfer function matches the response",
        false => {
            "the transfer function does not match the response. Try another order, or the system is not linear"
        }
    };
    format!(
        "the coherence is {coherence} or more from {low} to {high} rad/s ({low_hz} to {high_hz} Hz), and the model describes this band; cost J {}, a good value is at most {ACCEPTED:.0}: {is_near}",
        significant(cost, 3)
    )
}

/// The cause of an error, with its segment if there are several.
fn not_linear(finding: &Finding, sample_time: f64, segment: Option<usize>) -> String {
    let segment = segment.map_or(String::new(), |it| {
        format!(" in segment {it}, time counted from its beginning")
    });
    let gain = finding.gain.map_or(String::new(), |(share, test)| {
        let percent = 100.0 * share;
        format!(": this explains {percent:.0} % of the squared simulation error (F {test:.0})")
    });
    cause(&finding.cause, sample_time) + &segment + &gain
}

fn through_curve(curved: &Curved) -> String {
    let (signal, place, model) = match curved.side {
        Side::Input => ("input", "in front of", "Hammerstein"),
        Side::Output => ("output", "behind", "Wiener"),
    };
    let linear = curved.linear_fit.map_or(String::new(), |fit| {
        format!("; a linear model simulates {fit:.1} % of the held-out data")
    });
    format!(
        "the {signal} goes through a static curve {place} the linear dynamics ({model} model): {}; gain, poles and zeros are those \
         of the linear dynamics{linear}",
        curved.in_words()
    )
}

fn input_share(share: f64, is_too_little: bool) -> String {
    let percent = 100.0 * share.max(0.0);
    let rest = "the rest is free motion, drift or disturbance";
    match is_too_little {
        true => format!(
            "{percent:.1} % of the output's variance comes from the input: {rest}. Do not trust the gain"
        ),
        false => format!("{percent:.0} % of the output's variance comes from the input: {rest}"),
    }
}

fn gain_undetermined(gain: &Uncertain) -> String {
    let share = SIGMAS_95 * gain.real_deviation() / gain.value.re.abs();
    let known = match share > 1.0 {
        true => "not significantly different from 0".to_owned(),
        false => format!("known to {:.0} % only", 100.0 * share),
    };
    format!("the steady-state gain, {}, is {known}", interval(gain))
}

fn early(samples: i64) -> String {
    format!(
        "the model fits better if the output is {samples} sample{} before the input. Possible causes: the output is stamped too early, the input moves between its samples ({}), the data is closed-loop, or the system is not linear",
        if samples == 1 { "" } else { "s" },
        setting("input_method", "foh")
    )
}

fn feedback(later: &Correlation) -> String {
    format!(
        "residuals correlate with later inputs ({}). Either the data is closed-loop, so the model may be biased, or the output is stamped too early. Give the loop's reference ({}) or use {}",
        evidence(later),
        option("reference"),
        setting("method", "armax")
    )
}

fn negative_pole(pole: &Uncertain) -> String {
    let kind = match pole.value.im {
        0.0 => "a negative real pole",
        _ => "a pole pair with negative real part",
    };
    format!(
        "{kind}, z = {}: probably an artefact of noise",
        interval(pole)
    )
}

fn other_order(other: &OtherOrder) -> String {
    let without = if other.cancels { "with a" } else { "without a" };
    let gain = match &other.gain {
        Some(gain) => format!("a steady-state gain of {}", interval(gain)),
        None => "no steady-state gain".to_owned(),
    };
    format!(
        "an order-{} model, {without} near pole-zero cancellation, has a cross-validated fit of {:.1} % and {gain}",
        other.order, other.fit
    )
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Excitation(order, needed) => write!(
                f,
                "the input is persistently exciting of order {order} only, for {needed} parameters: the model is not \
                 determined away from the frequencies of the input"
            ),
            Self::FeedbackAlone(record, share) => {
                f.write_str("the input ")?;
                if let Some(record) = record {
                    write!(f, "of record {record} ")?;
                }
                write!(
                    f,
                    "is feedback of the output alone ({share:.1e} of its power is not): either a controller produces the input, and the model is the inverse of the controller, or the plant responds at once. The record cannot decide between the two"
                )
            }
            Self::Rank(known, parameters, ratio) => write!(
                f,
                "rank deficiency: the record determines {known} of {parameters} parameters (ratio of singular values \
                 {ratio:.1e}): poles and zeros cancel, or the order is too high"
            ),
        }
    }
}

/// The cause of an error; times in seconds.
fn cause(cause: &Cause, sample_time: f64) -> String {
    let seconds = |sample: &usize| format!("{:.2}", *sample as f64 * sample_time);
    match cause {
        Cause::Input(curve) => format!("the input {}", in_words("acts", curve)),
        Cause::Output(curve) => format!("the output {}", in_words("follows", curve)),
        Cause::Drag => "damping grows with the output, y|y|, as drag does".to_owned(),
        Cause::Friction => {
            "damping does not grow with the output's rate, as in dry friction".to_owned()
        }
        Cause::Gain(times) => {
            let change = |(time, gain): &(usize, f64)| {
                let from = seconds(time);
                format!(" from {from} s on the gain is {gain:.2} times its initial value")
            };
            let changes: Vec<String> = times.iter().map(change).collect();
            format!("the gain changes:{}", changes.join(","))
        }
        Cause::Steps(times) => {
            let times: Vec<String> = times.iter().map(seconds).collect();
            format!(
                "something that is not recorded steps at about {} s",
                times.join(", ")
            )
        }
        Cause::Oscillation(rate) => format!(
            "something that is not recorded oscillates at {} rad/s: the model has a mode there that the input hardly moves",
            significant(rate / sample_time, 3)
        ),
        Cause::While(from, to, times) => format!(
            "from {} to {} s the error is {times:.1} times the error elsewhere: something else acts in this interval, or the system changes",
            seconds(from),
            seconds(to)
        ),
    }
}

/// The effect of a static curve on a signal.
fn in_words(verb: &str, curve: &StaticCurve) -> String {
    let number = |it: &f64| significant(*it, 3);
    match curve {
        StaticCurve::DeadZone { lower, upper } => format!(
            "{verb} only beyond a dead zone from about {} to {}",
            number(lower),
            number(upper)
        ),
        StaticCurve::Saturation { lower, upper } => {
            let side = |word: &str, level: &Option<f64>| {
                level.map(|it| format!("{word} about {}", number(&it)))
            };
            let sides = [side("below", lower), side("above", upper)];
            let sides: Vec<String> = sides.into_iter().flatten().collect();
            format!("{verb} no more {}: it saturates", sides.join(" and "))
        }
        StaticCurve::Piecewise { levels, slopes } => {
            let list = |values: &[f64]| values.iter().map(number).collect::<Vec<_>>().join(", ");
            format!(
                "{verb} by a curve that bends at about {}, with slopes in the ratio {}",
                list(levels),
                list(slopes)
            )
        }
        StaticCurve::Square { .. } => {
            format!("{verb} by its square, u|u|, as a propeller's speed does")
        }
        StaticCurve::Backlash { width } => format!("has backlash of about {}", number(width)),
    }
}

fn candidate(of: &Candidate) -> String {
    let integrator = match of.integrators() {
        0 => "",
        _ => " with an integrator",
    };
    let (kind, delay) = (of.kind.name(), of.structure.delay);
    format!("{kind}, order {}{integrator}, delay {delay}", of.order())
}

fn order(chosen: &criteria::Candidate, next: Option<&criteria::Candidate>) -> String {
    let fit = |of: &criteria::Candidate| match of.held_out_fit {
        None => "not validated".to_owned(),
        Some(fit) => format!("{fit:.1} % on held-out data"),
    };
    let (order, own) = (chosen.order, fit(chosen));
    match next {
        Some(next) => format!(
            "order {} is no better than {order}: {} against {own}, BIC {:+.1}",
            next.order,
            fit(next),
            next.bic - chosen.bic
        ),
        // A finite impulse response.
        None if order == 0 => format!("delay {}: {own}", chosen.delay),
        None => format!("order {order}, delay {}: {own}", chosen.delay),
    }
}

fn residuals(finding: &ResidualFinding, against: &str) -> String {
    match finding {
        ResidualFinding::White(explains) => format!(
            "residuals are white and uncorrelated with {against}{}",
            if *explains {
                ": the model explains the data"
            } else {
                ""
            }
        ),
        ResidualFinding::Coloured(whiteness, is_allowed_for) => format!(
            "residuals are uncorrelated with {against} but not white ({}): the standard deviations {}",
            evidence(whiteness),
            if *is_allowed_for {
                "allow for it"
            } else {
                "are not reliable"
            }
        ),
        ResidualFinding::LittleCorrelation(earlier) => format!(
            "residuals correlate with {against} significantly, but little ({})",
            evidence(earlier)
        ),
        ResidualFinding::InLoop(earlier) => format!(
            "residuals correlate with {against} ({}): the input follows the output, and with it its noise",
            evidence(earlier)
        ),
        ResidualFinding::Correlated(earlier) => format!(
            "residuals correlate with {against} ({}): dynamics are missing, or not linear. Try a higher order or another delay",
            evidence(earlier)
        ),
    }
}

/// The result of a correlation test in numbers.
fn evidence(of: &Correlation) -> String {
    format!(
        "largest correlation {:.2}, 99 % bound {:.2}, exceeded at {} of {} lags",
        of.largest(),
        of.bound,
        of.outside(),
        of.values.len()
    )
}
