//! Reasons in words.

use std::f64::consts::TAU;
use std::fmt;

use planesman_linear::digits::{significant, with_interval};
use planesman_wording::{option, setting};

use super::Lines;
use super::reason::{FitRemark, Reason, ResidualFinding};
use super::text::interval;
use crate::prediction::AHEAD;
use crate::selection::{Candidate, criteria};
use crate::static_curve::{Side, StaticCurve};
use crate::uncertainty::SIGMAS_95;
use crate::validation::identifiability::Doubt;
use crate::validation::nonlinearity::Cause;
use crate::validation::residuals::Correlation;

/// The cost J up to which a transfer function is called good (Tischler and Remple 2012, ch. 11).
const ACCEPTED: f64 = 100.0;

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Validated(samples, fit, predicted) => {
                let percent =
                    |fit: &Option<f64>| fit.map_or("none".to_owned(), |fit| format!("{fit:.1} %"));
                write!(
                    f,
                    "judged on the validation data, {samples} samples that were not fitted: simulated fit {}, predicted \
                     {AHEAD} samples ahead {}",
                    percent(fit),
                    percent(predicted)
                )
            }
            Self::Data(told) => f.write_str(told),
            Self::Doubt(doubt) => doubt.fmt(f),
            Self::SegmentsLeftOut(used, all, share) => write!(
                f,
                "of {all} segments the {used} longest were used, {share:.1} % of the samples"
            ),
            Self::SearchedInPart(searched, samples) => write!(
                f,
                "order and delay were searched on the {searched} of {samples} samples where the input varies most; the \
                 model was fitted to all"
            ),
            Self::Selected(tried, chosen, largest) => {
                let (chosen_name, fit) = (candidate(chosen), chosen.fit());
                write!(
                    f,
                    "of {tried} models cross-validated: {chosen_name}, fit {fit:.1} %"
                )?;
                match largest {
                    Some(largest) => write!(
                        f,
                        "; the largest fit, {:.1} % ({}), is not significantly larger for its parameters",
                        largest.fit(),
                        candidate(largest)
                    ),
                    None => Ok(()),
                }
            }
            Self::Order(chosen, next) => order(f, chosen, next.as_ref()),
            Self::Process(chosen, next) => {
                let begins = match chosen.is_at_rest {
                    true => "at rest",
                    false => "in motion",
                };
                let form = chosen.form;
                write!(f, "process model {}, {}, {begins} as the record begins", form.name(), form.equation())?;
                match next {
                    Some((next, bic)) => write!(f, "; next {}, BIC {bic:+.1}", next.name()),
                    None => Ok(()),
                }
            }
            Self::LargestOrder(order) => write!(
                f,
                "order {order} is the largest searched: a higher one may fit better ({})",
                setting("order", order + 2)
            ),
            Self::LongestDelay(delay) => write!(
                f,
                "delay {delay} is the longest searched: a longer one may fit better ({})",
                setting("delay", delay + 5)
            ),
            Self::TwoStages {
                frequency,
                reference,
                staged,
                direct,
                apart,
            } => {
                let size = |(size, deviation): &(f64, f64)| {
                    with_interval(*size, SIGMAS_95 * deviation)
                };
                let (staged, direct) = (size(staged), size(direct));
                write!(
                    f,
                    "magnitude of the response at {frequency:.3} rad/s: {staged} by the reference {reference}, {direct} \
                     by a direct fit; "
                )?;
                match apart {
                    Some(apart) => write!(
                        f,
                        "{apart:.1} standard deviations away: feedback of noise biases the direct fit"
                    ),
                    None => f.write_str(
                        "no significant difference: feedback of noise does not bias the direct fit",
                    ),
                }
            }
            Self::PredictedFit(fit) => write!(
                f,
                "the model is unstable, and a simulation diverges whatever the model: predictions {AHEAD} samples ahead \
                 fit {fit:.1} %"
            ),
            Self::HeldOutFit(fit, remark) => {
                write!(f, "simulated fit on held-out data {fit:.1} %")?;
                match remark {
                    FitRemark::None => Ok(()),
                    FitRemark::WorseThanMean => f.write_str(": worse than the mean of the output"),
                    FitRemark::NoiseLimited(attainable) => write!(
                        f,
                        ": as good as the noise lets a model be ({attainable:.1} %)"
                    ),
                    FitRemark::VeryGood => f.write_str(": very good"),
                    FitRemark::Overfitted(whole) => write!(
                        f,
                        ", on the whole record {whole:.1} %: the model is overfitted, or the system changed"
                    ),
                }
            }
            Self::AtRest => write!(
                f,
                "the output stands still until the input steps: it is taken to have been at rest before, as by {}",
                option("at_rest")
            ),
            Self::HeldOutIsNoise(None) => f.write_str(
                "not validated: in the held-out data the output stays within the noise",
            ),
            Self::HeldOutIsNoise(Some(fit)) => write!(
                f,
                "in the last part the output stays within the noise: judged by the cross-validated fit, {fit:.1} %"
            ),
            Self::ErrorAsElsewhere(fit) => write!(
                f,
                "in the last part the output moves less, and the error is no larger than elsewhere: judged by the cross-validated fit, {:.1} %",
                fit.unwrap_or_default()
            ),
            Self::FirstPartUndetermined => f.write_str(
                "not validated: the first seven tenths alone do not determine the model",
            ),
            Self::WholeRecord(fit) => {
                let fit = fit.map_or("none".to_owned(), |fit| format!("{fit:.1} %"));
                write!(
                    f,
                    "the first seven tenths alone do not excite the band: judged by the simulated fit on all of the record, {fit}; \
                     {} judges it on other data",
                    option("validation")
                )
            }
            Self::Band {
                band,
                coherence,
                cost,
            } => {
                let [low, high] = [band.0, band.1].map(|it| significant(it, 3));
                let [low_hz, high_hz] = [band.0, band.1].map(|it| significant(it / TAU, 3));
                let is_near = match *cost <= ACCEPTED {
                    true => "the transfer function follows the response",
                    false => "the transfer function is not near the response: another order, or not linear",
                };
                write!(
                    f,
                    "the coherence is {coherence} or more from {low} to {high} rad/s ({low_hz} to {high_hz} Hz), and the model is of this \
                     band; cost J {}, {ACCEPTED:.0} at most is good: {is_near}",
                    significant(*cost, 3)
                )
            }
            Self::NotLinear {
                finding,
                sample_time,
                segment,
            } => {
                not_linear(f, &finding.cause, *sample_time)?;
                if let Some(segment) = segment {
                    write!(f, " in segment {segment}, from its beginning")?;
                }
                match finding.gain {
                    Some((share, test)) => write!(
                        f,
                        ": that takes away {:.0} % of the simulated error's squares (F {test:.0})",
                        100.0 * share
                    ),
                    None => Ok(()),
                }
            }
            Self::Curve(curved) => {
                let (signal, place, model) = match curved.side {
                    Side::Input => ("input", "in front of", "Hammerstein"),
                    Side::Output => ("output", "behind", "Wiener"),
                };
                write!(
                    f,
                    "the {signal} goes through a static curve {place} the linear dynamics ({model} model): {}; gain, poles and zeros are \
                     those of the linear dynamics",
                    curved.in_words()
                )?;
                match curved.linear_fit {
                    Some(fit) => write!(f, "; a linear model simulates {fit:.1} % of what is held out"),
                    None => Ok(()),
                }
            }
            Self::Carried(fit) => write!(
                f,
                "with the state from the samples before alone {fit:.1} % of it is simulated: slow modes drift, and a simulation from \
                 a known state is no better"
            ),
            Self::Unsteady => f.write_str(
                "fitted to one half of the record the model does not hold in the other: the system or its level changes \
                 along the record, or the halves excite different dynamics",
            ),
            Self::InputShare(share, is_too_little) => {
                let percent = 100.0 * share.max(0.0);
                let rest = "the rest is free motion, drift or disturbance";
                match is_too_little {
                    true => write!(
                        f,
                        "the input accounts for {percent:.1} % of the output's variation: {rest}; the gain is not to be trusted"
                    ),
                    false => write!(
                        f,
                        "the input accounts for {percent:.0} % of the output's variation: {rest}"
                    ),
                }
            }
            Self::GainUndetermined(gain) => {
                let share = SIGMAS_95 * gain.real_deviation() / gain.value.re.abs();
                write!(f, "the steady-state gain, {}, is ", interval(gain))?;
                match share > 1.0 {
                    true => f.write_str("not significantly different from 0"),
                    false => write!(f, "known to {:.0} % only", 100.0 * share),
                }
            }
            Self::InputEffect(f_statistic, needed, is_in) => {
                let left_out = if *is_in { "" } else { "; it is left out" };
                write!(
                    f,
                    "F {f_statistic:.1}, {needed:.1} needed: nothing that it does is seen in the output{left_out}"
                )
            }
            Self::Inseparable(other, share) => write!(
                f,
                "{:.2} % of its variation is its own, the rest moves with {other}: what each does cannot be told apart",
                100.0 * share
            ),
            Self::ProcessF(f_statistic, least) => {
                let than = match f_statistic < least {
                    true => "the output's own noise and drift explain it as well",
                    false => "the input moves the output beyond doubt",
                };
                write!(f, "F of the input's part {f_statistic:.0}, {least:.0} needed: {than}")
            }
            Self::Early(samples) => write!(
                f,
                "the model fits better with the output {samples} sample{} before the input: the output is stamped too \
                 early, the input moves between its samples ({}), the data is closed-loop, or the system is not linear",
                if *samples == 1 { "" } else { "s" },
                setting("input_method", "foh")
            ),
            Self::OtherDelay(better, delay) => {
                let option = setting("delay", better);
                write!(f, "delay {better} fits better than {delay} ({option})")
            }
            Self::DirectFeedthrough => f.write_str(
                "the output answers its input within one sample: direct feedthrough, or the input moves between its samples, or the output's stamps are too early",
            ),
            Self::Lines(Lines { lines, held }) => write!(
                f,
                "the input moves on straight lines between its samples (foh): cross-validated fit {:.2} % with {} parameters; held \
                 it would be {:.2} % with {}",
                lines.1, lines.0, held.1, held.0
            ),
            Self::NoNoise => {
                f.write_str("the residuals are rounding: the data is free of noise")
            }
            Self::Residuals(finding, is_reference) => {
                let against = match is_reference {
                    true => "the reference",
                    false => "the input",
                };
                residuals(f, finding, against)
            }
            Self::Feedback(later) => write!(
                f,
                "residuals correlate with later inputs ({}): the data is closed-loop, and the model may be biased, or the \
                 output is stamped too early; give the loop's reference ({}) or use {}",
                evidence(later),
                option("reference"),
                setting("method", "armax")
            ),
            Self::NegativePole(pole) => {
                let kind = match pole.value.im {
                    0.0 => "a negative real pole",
                    _ => "a pole pair with negative real part",
                };
                let at = interval(pole);
                write!(f, "{kind}, z = {at}: probably an artefact of noise")
            }
            Self::UnstablePole(pole) => {
                let at = interval(pole);
                write!(f, "the pole at z = {at} is unstable, beyond its 95 % interval")
            }
            Self::CancelledPole(pole) => {
                let at = interval(pole);
                write!(f, "a zero may cancel the pole at z = {at}: try a lower order")
            }
            Self::OtherOrder(other) => {
                let without = if other.cancels { "with" } else { "without" };
                write!(
                    f,
                    "the model of order {}, {without} a pole that a zero may cancel, has a cross-validated fit of {:.1} %",
                    other.order, other.fit
                )?;
                match other.gain {
                    Some(gain) => write!(f, " and a steady-state gain of {}", interval(&gain)),
                    None => f.write_str(" and no steady-state gain"),
                }
            }
            Self::FewSamples(samples, parameters) => write!(
                f,
                "{samples} samples for {parameters} parameters: part of the fit is memory; record for longer"
            ),
        }
    }
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
                    "is feedback of the output alone ({share:.1e} of its power is not): plant and controller cannot be \
                     distinguished"
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

/// What an error points to; times in seconds.
fn not_linear(f: &mut fmt::Formatter<'_>, cause: &Cause, sample_time: f64) -> fmt::Result {
    let seconds = |sample: &usize| format!("{:.2}", *sample as f64 * sample_time);
    match cause {
        Cause::Input(curve) => write!(f, "the input {}", in_words("acts", curve)),
        Cause::Output(curve) => write!(f, "the output {}", in_words("follows", curve)),
        Cause::Drag => f.write_str("damping grows with the output, y|y|, as drag does"),
        Cause::Friction => {
            f.write_str("damping does not grow with the output's rate, as dry friction")
        }
        Cause::Gain(times) => {
            f.write_str("the gain changes:")?;
            for (number, (time, gain)) in times.iter().enumerate() {
                let comma = if number > 0 { "," } else { "" };
                write!(
                    f,
                    "{comma} from {} s on it is {gain:.2} times what it was at first",
                    seconds(time)
                )?;
            }
            Ok(())
        }
        Cause::Steps(times) => {
            let times: Vec<String> = times.iter().map(seconds).collect();
            write!(
                f,
                "something that is not recorded steps at about {} s",
                times.join(", ")
            )
        }
        Cause::While(from, to, times) => write!(
            f,
            "from {} to {} s the error is {times:.1} times what it is elsewhere: something else acts then, or the system changes",
            seconds(from),
            seconds(to)
        ),
    }
}

/// How a signal goes through a curve, with what it does there.
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

fn order(
    f: &mut fmt::Formatter<'_>,
    chosen: &criteria::Candidate,
    next: Option<&criteria::Candidate>,
) -> fmt::Result {
    let fit = |of: &criteria::Candidate| match of.held_out_fit {
        None => "not validated".to_owned(),
        Some(fit) => format!("{fit:.1} % on held-out data"),
    };
    let (order, own) = (chosen.order, fit(chosen));
    match next {
        Some(next) => write!(
            f,
            "order {} is no better than {order}: {} against {own}, BIC {:+.1}",
            next.order,
            fit(next),
            next.bic - chosen.bic
        ),
        // A finite impulse response.
        None if order == 0 => write!(f, "delay {}: {own}", chosen.delay),
        None => write!(f, "order {order}, delay {}: {own}", chosen.delay),
    }
}

fn residuals(f: &mut fmt::Formatter<'_>, finding: &ResidualFinding, against: &str) -> fmt::Result {
    match finding {
        ResidualFinding::White(explains) => {
            write!(f, "residuals are white and uncorrelated with {against}")?;
            f.write_str(match explains {
                true => ": the model explains the data",
                false => "",
            })
        }
        ResidualFinding::Coloured(whiteness, is_allowed_for) => {
            let evidence = evidence(whiteness);
            write!(
                f,
                "residuals are uncorrelated with {against} but not white ({evidence}): the standard deviations {}",
                match is_allowed_for {
                    true => "allow for it",
                    false => "are not reliable",
                }
            )
        }
        ResidualFinding::LittleCorrelation(earlier) => write!(
            f,
            "residuals correlate with {against} significantly, but little ({})",
            evidence(earlier)
        ),
        ResidualFinding::Correlated(earlier) => write!(
            f,
            "residuals correlate with {against} ({}): dynamics are missing, or not linear; try a higher order or another delay",
            evidence(earlier)
        ),
    }
}

/// The result of a correlation test in numbers.
fn evidence(of: &Correlation) -> String {
    format!(
        "max {:.2}, 99 % bound {:.2}, exceeded at {} of {} lags",
        of.largest(),
        of.bound,
        of.outside(),
        of.values.len()
    )
}
