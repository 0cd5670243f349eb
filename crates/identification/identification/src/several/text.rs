//! The results as text for the terminal.

use std::fmt::Write as _;

use planesman_linear::digits::significant;

use super::analysis::{Analysis, ChannelModel};
use crate::analysis::Shown;
use crate::analysis::text::{
    denominator, interval, interval_of_delay, limit_by_noise, noise, numerator, percent,
    to_a_nanosecond,
};

/// Heading of the F statistic of an input's effect, with the value from which the input counts.
pub const HEAD_OF_F: &str = "effect F (needed)";

/// Maximum number of candidates printed, and of offsets.
const SHOWN: usize = 8;

impl Analysis {
    /// Verdict, results, reasons and next steps, with all details.
    #[must_use]
    pub fn text(&self) -> String {
        self.text_as(Shown {
            verbose: true,
            ..Shown::default()
        })
    }

    /// Prints the parts that `shown` selects.
    #[must_use]
    pub fn text_as(&self, shown: Shown<'_>) -> String {
        let numbers = match shown.verbose {
            true => self.numbers() + "\n" + &self.detail(),
            false => self.numbers(),
        };
        let reasons = self.reasons.iter();
        let reasons = reasons.filter(|it| shown.verbose || !it.reason.is_of_the_choice());
        let reasons: Vec<_> = reasons.collect();
        shown.arranged(self.verdict, &numbers, &reasons, || self.next())
    }

    /// The model in numbers: fit and a table of the channels.
    fn numbers(&self) -> String {
        let names: Vec<&str> = self.inputs.iter().map(|it| it.name.as_str()).collect();
        let mut text = format!(
            "{:<12} {} -> {}: {}, sample time {} s\n",
            "model",
            names.join(", "),
            self.output,
            self.kind.name(),
            to_a_nanosecond(self.sample_time)
        );
        let _ = writeln!(
            text,
            "{:<12} {} simulated, {} on held-out data",
            "fit",
            percent(self.fit),
            percent(self.held_out.fit)
        );
        text + &limit_by_noise(&self.held_out) + "\n" + &self.table()
    }

    /// Candidates, each channel's coefficients, poles and zeros, offsets and noise.
    fn detail(&self) -> String {
        let mut text = self.tried();
        for (_, input, model) in self.channels() {
            let _ = writeln!(text, "{} -> {}", input.name, self.output);
            text += &of_channel(model);
            text.push('\n');
        }
        let runs = self.segments.iter().enumerate().take(SHOWN);
        let offsets = runs.map(|(run, number)| {
            let offset = significant(self.offset(run), 5);
            match self.segments.len() {
                1 => offset,
                _ => format!("{offset} (segment {})", number + 1),
            }
        });
        let offsets: Vec<String> = offsets.collect();
        let more = match self.segments.len().saturating_sub(SHOWN) {
            0 => String::new(),
            more => format!(", {more} more"),
        };
        let _ = writeln!(text, "{:<12} {}{more}", "offset", offsets.join(", "));
        text + &noise(self.noise_variance, &self.noise_denominator)
    }

    fn tried(&self) -> String {
        let mut text = String::from("cross-validated fit\n");
        for it in self.candidates.iter().take(SHOWN) {
            let _ = writeln!(text, "{:>9.2} %  {}", it.fit(), self.in_words(it));
        }
        text + "\n"
    }

    /// A row for each input.
    #[must_use]
    pub fn rows(&self) -> Vec<[String; 6]> {
        let row = |it: &super::InputFindings| {
            let f = match it.effect.needed.is_finite() {
                true => format!(
                    "{} ({})",
                    significant(it.effect.f, 3),
                    significant(it.effect.needed, 2)
                ),
                false => significant(it.effect.f, 3),
            };
            let Some(model) = &it.model else {
                let none = "-".to_owned();
                let nothing = "left out".to_owned();
                return [
                    it.name.clone(),
                    none.clone(),
                    none.clone(),
                    nothing,
                    none,
                    f,
                ];
            };
            let gain = model.reading().steady_state_gain();
            let (mut modes, others) = model.reading().determined_modes();
            if others > 0 {
                modes.push(format!("{others} not determined"));
            }
            [
                it.name.clone(),
                model.estimate.layout.structure.poles.to_string(),
                delay(model),
                gain.map_or("integrates".to_owned(), |gain| interval(&gain)),
                match modes.is_empty() {
                    true => "-".to_owned(),
                    false => modes.join("; "),
                },
                f,
            ]
        };
        self.inputs.iter().map(row).collect()
    }

    fn table(&self) -> String {
        let head = [
            "input",
            "order",
            "delay",
            "steady-state gain",
            "modes",
            HEAD_OF_F,
        ];
        let rows = self.rows();
        let all = || std::iter::once(head.map(str::to_owned)).chain(rows.iter().cloned());
        let widths = [0, 1, 2, 3, 4, 5].map(|at| {
            let widths = all().map(|row| row[at].chars().count());
            widths.max().unwrap_or(0)
        });
        let mut text = String::new();
        for row in all() {
            let cells = row.iter().zip(widths);
            let cells: Vec<String> = cells
                .map(|(cell, width)| format!("{cell:<width$}"))
                .collect();
            let _ = writeln!(text, "{}", cells.join("  ").trim_end());
        }
        text
    }
}

/// The delay with its 95 % interval, samples.
fn delay(model: &ChannelModel) -> String {
    let of = |lag: crate::analysis::Lag| match lag.interval {
        (least, most) if least == most => String::new(),
        (least, most) => format!(" ({least} to {most})"),
    };
    format!("{}{}", model.delay(), model.lag.map_or(String::new(), of))
}

fn of_channel(model: &ChannelModel) -> String {
    let reading = model.reading();
    let of = model.estimate.model(0);
    let b = of.numerator(model.delay() == 0);
    let mut text = format!("{}\n{}", numerator(&b), denominator(&of.a));
    for mode in reading.modes() {
        let _ = writeln!(text, "{:<12} {mode}", "mode");
    }
    for (name, places) in [
        ("z pole", reading.poles()),
        ("s pole", reading.continuous_poles()),
        ("z zero", reading.zeros()),
    ] {
        let places = places.unwrap_or_default();
        for it in places.iter().filter(|it| it.value.im >= 0.0) {
            let _ = writeln!(text, "{name:<12} {}", interval(it));
        }
    }
    if let Some(gain) = reading.steady_state_gain() {
        let _ = writeln!(text, "{:<12} {}, steady state", "gain", interval(&gain));
    }
    text + &interval_of_delay(model.lag)
}
