//! The results as text for the terminal.

use std::fmt::{Display, Write as _};

use super::{AHEAD, Analysis, ClosedLoop, HeldOutFits, Lag, Verdict};
use planesman_linear::digits::{significant, with_interval};
use planesman_wording::option;

use crate::estimators::Property;
use crate::uncertainty::{Reading, SIGMAS_95, Uncertain};

/// Maximum number of candidates, and of offsets, printed.
const SHOWN: usize = 8;

/// Options for showing results.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown<'a> {
    /// Lines about the record, printed below the numbers.
    pub record: &'a str,
    /// Next step to print if the verdict recommends writing the model, but it has already been written.
    pub once_written: Option<&'a str>,
    /// Whether to print also candidates, coefficients, poles, zeros and the reasons of the choice.
    pub verbose: bool,
}

impl Shown<'_> {
    /// The verdict, the numbers that support it, the record, the reasons and the next step.
    pub(crate) fn arranged(
        &self,
        verdict: Verdict,
        numbers: &str,
        reasons: &[impl Display],
        next: impl FnOnce() -> String,
    ) -> String {
        let reasons: String = reasons.iter().map(|it| format!("- {it}\n")).collect();
        let next = verdict.next_once(self.once_written, next);
        let words = verdict.words();
        let record = self.record;
        format!("verdict: {words}\n\n{numbers}{record}\n{reasons}\nNext: {next}\n")
    }
}

impl Analysis {
    /// Verdict, results, reasons and next step, with all details.
    #[must_use]
    pub fn text(&self) -> String {
        self.text_as(Shown {
            verbose: true,
            ..Shown::default()
        })
    }

    /// The results as text, with a choice of what to show.
    #[must_use]
    pub fn text_as(&self, shown: Shown<'_>) -> String {
        let numbers = match shown.verbose {
            true => self.all_numbers(),
            false => self.numbers(),
        };
        let reasons = self.reasons.iter();
        let reasons = reasons.filter(|it| shown.verbose || !it.is_of_the_choice());
        let reasons: Vec<_> = reasons.collect();
        shown.arranged(self.verdict, &numbers, &reasons, || self.next())
    }

    /// The model in numbers, with candidates, coefficients, poles and zeros.
    #[must_use]
    pub fn all_numbers(&self) -> String {
        self.numbers() + "\n" + &self.detail()
    }

    /// The model in numbers: fit, gain, modes, delay.
    fn numbers(&self) -> String {
        let structure = &self.estimate.layout.structure;
        let known = match structure.known_denominator.len() {
            1 => String::new(),
            known => format!(" and {} known", known - 1),
        };
        let size = match (structure.poles, structure.numerator, &known[..]) {
            (0, 1, "") => "a static gain".to_owned(),
            (poles, numerator, known) => {
                format!("{poles} poles{known}, {numerator} numerator coefficients")
            }
        };
        let mut text = format!(
            "{:<12} {} -> {}: {}, {size}, delay {}, sample time {} s\n",
            "model",
            self.input,
            self.output,
            self.method_name(),
            structure.delay,
            to_a_nanosecond(self.estimate.sample_time)
        );
        if let Some(ClosedLoop { reference, .. }) = &self.closed_loop {
            let how = match self.estimate.frequency {
                Some(_) => "by the response to the reference, S_ry / S_ru",
                None => "in two stages, from",
            };
            let _ = writeln!(text, "{:<12} {how} {reference}", "loop");
        }
        text += &self.process();
        text += &self.frequency();
        let _ = writeln!(
            text,
            "{:<12} {} simulated, {} on held-out data, {} predicted {AHEAD} samples ahead",
            "fit",
            percent(self.fit),
            percent(self.held_out.fit),
            percent(self.predicted_fit)
        );
        text += &limit_by_noise(&self.held_out);
        if let Some(curved) = &self.curved {
            let _ = writeln!(text, "{:<12} {}", curved.label(), curved.in_words());
        }
        text += &self.gain();
        text += &modes(&self.reading());
        text += &self.vehicle();
        text + &interval_of_delay(self.lag)
    }

    /// Candidates, coefficients, all modes, poles and zeros, offset and noise.
    fn detail(&self) -> String {
        let mut text = self.tried();
        for mode in self.reading().modes() {
            let _ = writeln!(text, "{:<12} {mode}", "all modes");
        }
        text += &self.coefficients();
        text += &self.places();
        let _ = writeln!(text, "{:<12} {}", "offset", self.offsets());
        let estimate = &self.estimate;
        text += &noise(estimate.noise_variance, &estimate.noise_denominator);
        if let Some(part) = self.input_part {
            let _ = writeln!(
                text,
                "{:<12} {:.1} % of the output's variance comes from the input",
                "variance",
                100.0 * part.share
            );
        }
        text
    }

    /// The models tried.
    fn tried(&self) -> String {
        if !self.search.selected.is_empty() {
            let mut text = String::from("candidate     order  delay   cross-validated fit\n");
            for c in self.search.selected.iter().take(SHOWN) {
                let integrator = if c.integrators() > 0 {
                    ", integrator"
                } else {
                    ""
                };
                let _ = writeln!(
                    text,
                    "{:<13} {:<6} {:<7} {:.2} %{integrator}",
                    c.kind.name(),
                    c.order(),
                    c.structure.delay,
                    c.fit()
                );
            }
            return text + "\n";
        }
        if !self.search.processes.is_empty() {
            let mut text = String::from("process       begins     parameters  BIC\n");
            for c in &self.search.processes {
                let begins = if c.is_at_rest { "at rest" } else { "in motion" };
                let (form, sought) = (c.form.name(), c.parameters);
                let _ = writeln!(text, "{form:<13} {begins:<10} {sought:<11} {:.1}", c.bic);
            }
            return text + "\n";
        }
        if let Some(fit) = &self.estimate.frequency
            && fit.candidates.len() > 1
        {
            let mut text = String::from("poles  zeros  dead time, s cost J     BIC\n");
            for c in fit.candidates.iter().take(SHOWN) {
                let (delay, cost) = (significant(c.delay, 4), significant(c.cost, 4));
                let (poles, zeros) = (c.orders.poles, c.orders.zeros);
                let _ = writeln!(
                    text,
                    "{poles:<6} {zeros:<6} {delay:<12} {cost:<10} {:.1}",
                    c.bic
                );
            }
            return text + "\n";
        }
        if self.search.candidates.is_empty() {
            return String::new();
        }
        // A finite impulse response chooses its length for each delay.
        let has_no_poles = self.options.method.has(Property::HasNoPoles);
        let of_order = |order: &dyn std::fmt::Display| match has_no_poles {
            true => String::new(),
            false => format!("{order:<6} "),
        };
        let head = of_order(&"order");
        let mut text = format!("{head}delay   AIC        BIC        held-out fit\n");
        for c in self.search.candidates.iter().take(SHOWN) {
            let fit = c.held_out_fit;
            let fit = fit.map_or("-".to_owned(), |fit| format!("{fit:.2} %"));
            let _ = writeln!(
                text,
                "{}{:<7} {:<10.1} {:<10.1} {fit}",
                of_order(&c.order),
                c.delay,
                c.aic,
                c.bic
            );
        }
        text + "\n"
    }

    /// The offset of each segment, if the segments have separate offsets.
    fn offsets(&self) -> String {
        let one = |run: usize| significant(self.estimate.offset(run), 5);
        let runs = self.segments.len();
        if runs <= 1 || self.estimate.layout.offset(0).is_none() {
            return one(self.longest);
        }
        let each = self.segments.iter().enumerate().take(SHOWN);
        let each = each.map(|(run, number)| format!("{} (segment {})", one(run), number + 1));
        let mut each: Vec<String> = each.collect();
        if runs > SHOWN {
            each.push(format!("{} more", runs - SHOWN));
        }
        each.join(", ")
    }

    /// Numerator and denominator; if the segments have separate numerators, all of them.
    fn coefficients(&self) -> String {
        let own = self.estimate.layout.structure.own_numerators && self.segments.len() > 1;
        let runs = if own {
            0..self.segments.len()
        } else {
            self.longest..self.longest + 1
        };
        let mut text = String::new();
        for run in runs {
            let at_once = self.estimate.layout.structure.delay == 0;
            let b = self.estimate.model(run).numerator(at_once);
            text += &numerator(&b);
            if own {
                let gain = Reading::new(&self.estimate, run).steady_state_gain();
                let _ = write!(text, ", segment {}", self.segments[run] + 1);
                if let Some(gain) = gain {
                    let _ = write!(text, ", steady-state gain {}", interval(&gain));
                }
            }
            text.push('\n');
        }
        text + &denominator(&self.model().a)
    }

    /// Whether the impulse response is finite: all poles are at z = 0.
    fn is_finite(&self) -> bool {
        self.model().a.iter().all(|a| *a == 0.0)
    }

    /// Prints the modes of the poles, see [`Reading::modes`].
    #[must_use]
    pub fn modes(&self) -> Vec<String> {
        self.reading().modes()
    }

    /// Poles and zeros, each with its 95 % interval.
    fn places(&self) -> String {
        let reading = self.reading();
        let mut text = String::new();
        // The zeros of a finite impulse response are many, and say little.
        let zeros = reading.zeros().ok().filter(|_| !self.is_finite());
        let of_poles = self.bootstrap.as_ref().map_or(&[][..], |it| &it.poles);
        for (name, places, bootstrap) in [
            ("z pole", reading.poles().ok(), &[][..]),
            ("s pole", reading.continuous_poles().ok(), of_poles),
            ("z zero", zeros, &[]),
        ] {
            let places = places.unwrap_or_default();
            for (at, it) in places
                .iter()
                .enumerate()
                .filter(|(_, it)| it.value.im >= 0.0)
            {
                let _ = writeln!(text, "{name:<12} {}", interval(it));
                if let Some((re, im)) = bootstrap.get(at) {
                    let im = match it.value.im {
                        0.0 => String::new(),
                        _ => format!(", ± ({}) i", span(im)),
                    };
                    let _ = writeln!(text, "{:<12} {}{im}", "  bootstrap", span(re));
                }
            }
        }
        text
    }

    /// The gain with its 95 % interval.
    fn gain(&self) -> String {
        let reading = self.reading();
        let mut text = String::new();
        if let Some(gain) = reading.steady_state_gain() {
            let _ = writeln!(text, "{:<12} {}, steady state", "gain", interval(&gain));
        }
        if let Some(gain) = reading.integrator_gain_text() {
            let _ = writeln!(text, "{:<12} {gain}", "gain");
        }
        if let Some(gain) = self.bootstrap.as_ref().and_then(|it| it.gain.as_ref()) {
            let _ = writeln!(text, "{:<12} {}", "  bootstrap", span(gain));
        }
        text
    }

    /// The parameters of a process model.
    fn process(&self) -> String {
        let Some(model) = &self.estimate.process else {
            return String::new();
        };
        let mut text = format!("{:<12} {}\n", "process", model.form.equation());
        for (name, unit, value, deviation) in model.named() {
            let value = with_interval(value, SIGMAS_95 * deviation);
            let _ = writeln!(text, "{}", format!("{name:<12} {value} {unit}").trim_end());
        }
        text
    }

    /// A summary of the frequency response, and the transfer function fitted to it.
    fn frequency(&self) -> String {
        let Some(fit) = &self.estimate.frequency else {
            return String::new();
        };
        let windows = fit.windows.iter().map(|it| {
            let seconds = *it as f64 * self.estimate.sample_time;
            significant(seconds, 3)
        });
        let windows: Vec<String> = windows.collect();
        let mut rows = fit.rows(self.estimate.sample_time);
        rows.retain(|it| it.is_used);
        let step = rows.len().div_ceil(SHOWN).max(1);
        let mut text = format!(
            "{:<12} at {} frequencies, by windows of {} s; {} writes it\n\nrad/s     Hz        dB, 95 %           deg, 95 %          coherence\n",
            "response",
            fit.points.len(),
            windows.join(", "),
            option("response")
        );
        for it in rows.iter().step_by(step) {
            let _ = writeln!(
                text,
                "{:<9} {:<9} {:<18} {:<18} {:.3}",
                significant(it.omega, 4),
                significant(it.omega / std::f64::consts::TAU, 4),
                with_interval(it.decibels, it.sigmas_95 * it.decibel_deviation),
                with_interval(it.phase, it.sigmas_95 * it.phase_deviation),
                it.coherence
            );
        }
        let _ = writeln!(text, "\n{:<12} {}", "in s", fit.equation());
        for (name, value, deviation) in fit.named() {
            let value = with_interval(value, SIGMAS_95 * deviation);
            let unit = if name == "theta" { " s" } else { "" };
            let _ = writeln!(text, "{name:<12} {value}{unit}");
        }
        text
    }

    /// The vehicle's coefficients, of the methods that estimate them.
    fn vehicle(&self) -> String {
        let Some(found) = self.physical() else {
            return String::new();
        };
        let by_inertia = self.options.inertia.map(|it| found.with_inertia(it));
        let named = found.named().into_iter();
        let mut text = String::new();
        for (name, value, deviation) in named.chain(by_inertia.into_iter().flatten()) {
            let interval = SIGMAS_95 * deviation;
            let _ = writeln!(text, "{name:<12} {}", with_interval(value, interval));
        }
        text
    }
}

/// A number with its 95 % interval; for a conjugate pair, the pole with positive imaginary part.
pub(crate) fn interval(it: &Uncertain) -> String {
    let real = with_interval(it.value.re, SIGMAS_95 * it.real_deviation());
    if it.value.im == 0.0 {
        return real;
    }
    let imaginary = with_interval(it.value.im, SIGMAS_95 * it.imaginary_deviation());
    format!("{real}, ± ({imaginary}) i")
}

/// Prints the lower and upper end of an interval.
fn span((least, most): &(f64, f64)) -> String {
    format!("{} to {}", significant(*least, 5), significant(*most, 5))
}

/// A numerator, the highest power of z first.
pub(crate) fn numerator(b: &[f64]) -> String {
    format!("numerator    {}   (z^{} first)", list(b), b.len() - 1)
}

/// The denominator `1, a1 ... an`.
pub(crate) fn denominator(a: &[f64]) -> String {
    match a.iter().all(|a| *a == 0.0) {
        true => format!("denominator  z^{}\n", a.len()),
        false => format!("denominator  1  {}\n", list(a)),
    }
}

fn list(values: &[f64]) -> String {
    let values: Vec<String> = values.iter().map(|v| significant(*v, 9)).collect();
    values.join("  ")
}

/// The interval of a delay, if there is one.
pub(crate) fn interval_of_delay(lag: Option<Lag>) -> String {
    lag.map_or(String::new(), |lag| {
        let (least, most) = lag.interval;
        format!(
            "{:<12} {least} to {most} samples (95 % confidence), best estimate {}\n",
            "delay", lag.best
        )
    })
}

/// The noise as variance and `d1 ... dk`.
pub(crate) fn noise(variance: f64, denominator: &[f64]) -> String {
    let size = significant(variance.sqrt(), 4);
    let mut text = format!("{:<12} {size}, one standard deviation\n", "noise");
    if !denominator.is_empty() {
        let d: Vec<String> = denominator.iter().map(|d| significant(*d, 5)).collect();
        let _ = writeln!(
            text,
            "{:<12} e / (1, {}) in z^-1",
            "noise model",
            d.join(", ")
        );
    }
    text
}

/// The fit that the noise allows any model to reach, %.
pub(crate) fn limit_by_noise(held_out: &HeldOutFits) -> String {
    held_out.attainable.map_or(String::new(), |most| {
        let limit = match held_out.is_noise() {
            true => "the output stays within the noise".to_owned(),
            false => format!("noise limits any model to about {most:.1} %"),
        };
        format!("{:<12} {limit} on the held-out data\n", "limit")
    })
}

/// The modes, one per line; modes that the record does not determine are only counted.
fn modes(reading: &Reading<'_>) -> String {
    let (known, others) = reading.determined_modes();
    let mut text: String = known
        .iter()
        .map(|it| format!("{:<12} {it}\n", "mode"))
        .collect();
    if others > 0 {
        let _ = writeln!(
            text,
            "{:<12} {others} more, not determined: the interval is larger than the pole itself ({} lists them)",
            "mode",
            option("verbose")
        );
    }
    text
}

/// A fit, %.
pub(crate) fn percent(fit: Option<f64>) -> String {
    fit.map_or("none".to_owned(), |fit| format!("{fit:.2} %"))
}

/// Prints a time, s, without digits below a nanosecond.
pub(crate) fn to_a_nanosecond(seconds: f64) -> f64 {
    (seconds * 1e9).round() / 1e9
}

#[cfg(test)]
mod tests {
    use crate::analysis::{Options, analyse};
    use planesman_record::Record;
    use planesman_record::filter;
    use planesman_record::{noise, with_noise};

    #[test]
    fn poles_are_named_by_what_they_do() {
        // A pair of natural frequency 5 rad/s and damping ratio 0.6, and a time constant of 2 s.
        let (sample_time, u) = (0.05_f64, noise(4, 4000));
        let (size, angle) = (libm::exp(-3.0 * sample_time), libm::cos(4.0 * sample_time));
        let pair = [1.0, -2.0 * size * angle, size * size];
        let slow = [1.0, -libm::exp(-0.5 * sample_time)];
        for (den, expected) in [
            (
                &pair[..],
                vec![("natural frequency ", 5.0), ("damping ratio ", 0.6)],
            ),
            (&slow[..], vec![("time constant ", 2.0)]),
        ] {
            let y = with_noise(&filter(&[0.0, 1.0], den, &u), 5, 0.002);
            let signals = (vec![("u", u.clone())], vec![("y", y)]);
            let record = Record::of_run(sample_time, signals.0, signals.1).unwrap();
            let options = Options {
                order: Some(den.len() - 1),
                delay: Some(1),
                ..Options::default()
            };
            let text = analyse(&record, &options).unwrap().text();
            let mode = text.lines().find(|line| line.starts_with("mode ")).unwrap();
            for (name, expected) in expected {
                let number = mode.split(name).nth(1).and_then(|it| it.split(' ').next());
                let found: f64 = number.unwrap().parse().unwrap();
                assert!((found / expected - 1.0).abs() < 0.01, "{mode}");
            }
        }
    }
}
