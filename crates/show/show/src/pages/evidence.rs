//! Sources of the numbers of a review: the samples of each file by segment; and for each kind of number its method, reference, samples and
//! plots.

use std::fmt::Write as _;

use crate::plot::{Plot, Style};
use maud::{Markup, html};
use planesman_console::Table;
use planesman_fit::{FitData, Simulated};
use planesman_identification::Segment;
use planesman_identification::analysis::Analysis;
use planesman_identification::frequency::COHERENCE;
use planesman_linear::TimeHistory;
use planesman_signals::{PreparedRecord, hertz};

use crate::pages::fit::{TIME, is_near, range};
use crate::pages::tuning::number;

/// Anchors of the samples used for the fit, and of the samples on which the fit is judged.
pub(crate) const FIT: &str = "samples-fitted";
pub(crate) const HELD_OUT: &str = "samples-held-out";

/// Maximum number of points of a plotted signal: a printed plot has fewer pixels.
const COLUMNS: usize = 600;
/// Maximum number of samples of a close-up.
const CLOSE: usize = 500;
/// Maximum number of plotted files, and of segments listed.
const FILES: usize = 4;
const ROWS: usize = 24;

/// Uses of segments.
const FITTED: &str = "fitted";
const KEPT: &str = "held out only to compute the fit on held-out data; the printed model is fitted to these samples too";
const JUDGED: &str = "held out: used for validation, not for the fit";
const READ: &str = "read, but no model was found";
const UNUSED: &str = "not used: much shorter than the other segments";

/// A kind of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Entry {
    Data,
    Excitation,
    Response,
    Model,
    Validation,
    Residuals,
    Margins,
    Causes,
    Steps,
}

impl Entry {
    const ALL: [Self; 9] = [
        Self::Data,
        Self::Excitation,
        Self::Response,
        Self::Model,
        Self::Validation,
        Self::Residuals,
        Self::Margins,
        Self::Causes,
        Self::Steps,
    ];

    /// Anchor of the entry.
    pub(crate) const fn id(self) -> &'static str {
        self.described().0
    }

    /// Anchor, name, and method with its reference.
    const fn described(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::Data => (
                "by-data",
                "counts, times, cleaning",
                "From the recorded stamps: the rate is the inverse of the median interval; an interval above 1.5 times the median is a gap. Outliers by \
                 the Hampel filter (deviation from the local median).",
            ),
            Self::Excitation => (
                "by-excitation",
                "spectrum of the input, its band",
                "Welch's method: Hann windows, half overlapping, of several lengths weighted by their random errors (Tischler and Remple, Aircraft and \
                 Rotorcraft System Identification, 2nd ed., ch. 10).",
            ),
            Self::Response => (
                "by-response",
                "frequency response, coherence",
                "H = S_uy / S_uu with the same windows, in a closed loop S_ry / S_ru; random error sqrt(1 - coherence) / sqrt(2 n coherence) for n averages \
                 (Bendat and Piersol, Random Data, 4th ed., eq. 9.90). The model's band follows from its covariance, to first order.",
            ),
            Self::Model => (
                "by-model",
                "parameters, poles, gain, delay",
                "Prediction-error method; 95 % intervals are 1.96 standard deviations from the covariance of the estimate, which allows for coloured \
                 residuals (Ljung, System Identification, 2nd ed., ch. 9).",
            ),
            Self::Validation => (
                "by-validation",
                "fits, findings, verdict",
                "fit = 100 (1 - |y - yhat| / |y - mean y|) %, simulated from the input only. On held-out data: fit of a model of the same structure that was \
                 fitted to the other samples only.",
            ),
            Self::Residuals => (
                "by-residuals",
                "residual tests",
                "Correlations of the residual with itself and with the input, bounds of 99 % (Ljung, 2nd ed., sec. 16.6).",
            ),
            Self::Margins => (
                "by-margins",
                "gains, margins",
                "Margins of the sampled loop with exact hold, dead time and computing delay, for the model and each drawn plant. The worst of 95 % is the 5 % \
                 quantile of a margin, the 95 % quantile of Ms (Astrom and Hagglund, Advanced PID Control, ch. 4 and 7).",
            ),
            Self::Causes => (
                "by-causes",
                "causes of uncertainty",
                "The squared correlation of a property with the phase margin, to first order: the share by which the margin's variance would fall if this property were known exactly.",
            ),
            Self::Steps => (
                "by-steps",
                "responses to steps",
                "The loop simulated tick by tick with its limits, for the model and each drawn plant; quantiles 5, 50 and 95 %.",
            ),
        }
    }
}

/// Text with a link to an entry.
pub(crate) fn linked(text: &str, to: Entry) -> Markup {
    html! { @if !text.is_empty() { a.n href=(format!("#{}", to.id())) { (text) } } }
}

/// Samples of one file.
struct Part {
    id: String,
    /// Index of its file.
    file: usize,
    role: &'static str,
    /// First and last sample of the file on the grid, counted from 1.
    samples: (usize, usize),
    /// The samples' times, s from the output's first sample.
    times: (f64, f64),
}

/// A file of the fitted record, or of the validation record.
struct File<'a> {
    prepared: &'a PreparedRecord,
    /// Index of the file within its record.
    source: usize,
    is_validation: bool,
}

impl File<'_> {
    fn name(&self) -> &str {
        &self.prepared.sources[self.source].name
    }

    /// Indices of the file's segments.
    fn segments(&self) -> impl Iterator<Item = usize> {
        let all = self.prepared.resampled.record.segments.iter().enumerate();
        all.filter(|it| it.1.source == self.source).map(|it| it.0)
    }

    /// Time of a segment's first sample, s from the output's first sample, the same as for `--window`.
    fn begin(&self, segment: usize) -> f64 {
        let record = &self.prepared.resampled.record;
        let channels = &self.prepared.sources[self.source].channels;
        let output = channels
            .iter()
            .rfind(|it| record.outputs.first() == Some(&it.name));
        let origin = output.and_then(|it| it.timing.span).map_or(0, |it| it.0);
        record.segments[segment].start.saturating_sub(origin) as f64 * 1e-9
    }
}

/// The samples, and the results computed from them.
pub(crate) struct Evidence<'a> {
    data: &'a FitData,
    files: Vec<File<'a>>,
    parts: Vec<Part>,
    /// Plots of each entry: anchor and title.
    plots: Vec<(Entry, String, String)>,
    plants: String,
    left_out: usize,
}

impl<'a> Evidence<'a> {
    pub(crate) fn new(data: &'a FitData, analysis: Option<&Analysis>) -> Self {
        let of = |prepared: &'a PreparedRecord, is_validation| {
            (0..prepared.sources.len()).map(move |source| File {
                prepared,
                source,
                is_validation,
            })
        };
        let validation = data.validation.iter().flat_map(|it| of(it, true));
        let mut evidence = Self {
            data,
            files: of(&data.prepared, false).chain(validation).collect(),
            parts: Vec::new(),
            plots: Vec::new(),
            plants: String::new(),
            left_out: 0,
        };
        evidence.find(analysis);
        evidence
    }

    /// Lists the samples of each segment, and the held-out samples.
    fn find(&mut self, analysis: Option<&Analysis>) {
        let longest = analysis.map(|it| it.segments[it.longest]);
        let mut parts = Vec::new();
        for (number, file) in self.files.iter().enumerate() {
            let record = &file.prepared.resampled.record;
            let used = record.used();
            let mut before = 0;
            for segment in file.segments() {
                let count = record.segments[segment].len();
                let at = |k: usize| file.begin(segment) + k as f64 * record.sample_time;
                let mut part = |role: &'static str, from: usize| {
                    parts.push(Part {
                        id: format!("samples-{}", parts.len() + 1),
                        file: number,
                        role,
                        samples: (before + from + 1, before + count),
                        times: (at(from), at(count.saturating_sub(1))),
                    });
                };
                part(
                    match (file.is_validation, used.contains(&segment)) {
                        (_, false) => UNUSED,
                        (true, true) => JUDGED,
                        (false, true) if analysis.is_none() => READ,
                        (false, true) => FITTED,
                    },
                    0,
                );
                if let Some(found) = analysis
                    && self.data.validation.is_none()
                    && longest == Some(segment)
                {
                    part(KEPT, found.held_out.from.min(count.saturating_sub(1)));
                }
                before += count;
            }
        }
        let mut name = |id: &str, roles: &[&str]| {
            let first = parts.iter_mut().find(|it| roles.contains(&it.role));
            first.into_iter().for_each(|it| id.clone_into(&mut it.id));
        };
        name(FIT, &[FITTED, READ]);
        name(HELD_OUT, &[JUDGED, KEPT]);
        // The first of them, and what was held out.
        let all = parts.len();
        let mut row = 0;
        parts.retain(|it| {
            row += 1;
            row <= ROWS || it.id == HELD_OUT || it.role == KEPT
        });
        self.left_out = all - parts.len();
        self.parts = parts;
    }

    /// Registers a plot of an entry; returns its anchor.
    pub(crate) fn plot(&mut self, entry: Entry, title: &str) -> String {
        let id = format!("plot-{}", self.plots.len() + 1);
        self.plots.push((entry, id.clone(), title.to_owned()));
        id
    }

    /// Sets the description of the plants over which the gains are judged.
    pub(crate) fn plants(&mut self, plants: &str) {
        plants.clone_into(&mut self.plants);
    }

    /// Table of every signal of every file.
    pub(crate) fn channels(&self) -> Table {
        let mut table = Table::of([
            "file",
            "signal",
            "samples",
            "from, s",
            "to, s",
            "rate, Hz",
            "gaps",
            "longest, s",
            "repeated",
            "late",
            "not a number",
        ]);
        for file in &self.files {
            for channel in &file.prepared.sources[file.source].channels {
                let timing = &channel.timing;
                let span = timing.span.unwrap_or_default();
                let second = |it: i64| format!("{:.3}", it as f64 * 1e-9);
                table.row([
                    file.name().to_owned(),
                    channel.name.clone(),
                    timing.samples.to_string(),
                    second(span.0),
                    second(span.1),
                    hertz(timing.rate()),
                    timing.gaps.to_string(),
                    format!("{:.3}", timing.longest),
                    timing.duplicates.to_string(),
                    timing.late.to_string(),
                    (timing.not_finite + timing.absent).to_string(),
                ]);
            }
        }
        table
    }

    /// Sentences about findings in the data and how the data was cleaned.
    pub(crate) fn cleaned(&self) -> Vec<String> {
        let mut told = Vec::new();
        let records = std::iter::once(&self.data.prepared).chain(&self.data.validation);
        for prepared in records {
            for channel in prepared.sources.iter().flat_map(|it| &it.channels) {
                let changes = channel.changes.iter();
                told.extend(changes.map(|it| format!("{}: {it}", channel.name)));
            }
            let reading = &prepared.reading;
            told.extend(
                reading
                    .clock
                    .iter()
                    .chain(&reading.mixed)
                    .chain(&reading.notes)
                    .cloned(),
            );
            told.extend(prepared.steps.iter().map(|it| it.text.clone()));
        }
        let mut once: Vec<String> = Vec::new();
        told.retain(|it| {
            let is_new = !once.contains(it);
            once.push(it.clone());
            is_new
        });
        told
    }

    /// Plots of the first files over time: input and output, measured and simulated; held-out samples are shaded.
    pub(crate) fn of_files<'p>(
        &mut self,
        [input, output]: [&'p str; 2],
        analysis: Option<&Analysis>,
    ) -> Vec<(String, Plot<'p>)> {
        let mut plots = Vec::new();
        for number in 0..self.files.len().min(FILES) {
            for (kind, plot) in
                ["input", "output"]
                    .into_iter()
                    .zip(self.of_file(number, [input, output], analysis))
            {
                if !plot.is_empty() {
                    plots.push((format!("file-{}-{kind}", number + 1), plot));
                }
            }
        }
        plots
    }

    fn of_file<'p>(
        &self,
        number: usize,
        [input, output]: [&'p str; 2],
        analysis: Option<&Analysis>,
    ) -> [Plot<'p>; 2] {
        let file = &self.files[number];
        let record = &file.prepared.resampled.record;
        let used = record.used();
        let segments: Vec<usize> = file.segments().filter(|it| used.contains(it)).collect();
        let columns = COLUMNS / segments.len().max(1);
        let name = file.name().rsplit('/').next().unwrap_or_default();
        let all = |of: fn(&Segment) -> Option<&Vec<f64>>| {
            let values = segments.iter().filter_map(|it| of(&record.segments[*it]));
            range(&values.flatten().copied().collect::<Vec<_>>())
        };
        let (inputs, outputs) = (all(|it| it.inputs.first()), all(|it| it.outputs.first()));
        let mut plots = [
            Plot::new(format!("Input, {name}"), [TIME, input]),
            Plot::new(format!("Output, {name}"), [TIME, output])
                .note("Measured, and simulated from the input only. Shaded: held-out samples."),
        ];
        let held = self
            .parts
            .iter()
            .filter(|it| it.file == number && [KEPT, JUDGED].contains(&it.role));
        for part in held {
            let [of_input, of_output] = plots;
            plots = [
                of_input.shaded("held out", part.times, inputs),
                of_output.shaded("held out", part.times, outputs),
            ];
        }
        let judged = analysis.and_then(|it| it.validation.as_ref());
        let mut simulated: Vec<Vec<(f64, f64)>> = Vec::new();
        for (at, segment) in segments.iter().enumerate() {
            let begin = file.begin(*segment);
            let values = &record.segments[*segment];
            let thin = |values: &[f64]| {
                let mut history = TimeHistory::within(columns);
                let timed = values.iter().enumerate();
                timed.for_each(|(k, it)| history.take(begin + k as f64 * record.sample_time, *it));
                history.points().collect::<Vec<_>>()
            };
            // The second and later parts of a line have no name.
            let named = |name: &'static str| if at == 0 { name } else { "" };
            let [of_input, of_output] = plots;
            let of_first = |lists: &[Vec<f64>]| lists.first().map_or_else(Vec::new, |it| thin(it));
            plots = [
                of_input.line(named("input"), of_first(&values.inputs)),
                of_output.with(Style::Broad, named("measured"), of_first(&values.outputs)),
            ];
            let own = match (file.is_validation, analysis, judged) {
                (false, Some(found), _) => (found.segments.iter().position(|it| it == segment))
                    .and_then(|run| Simulated::of_run(found, record, run).ok())
                    .map(|it| (it.unknown, it.simulated)),
                (true, _, Some(judged)) => (judged.segments.iter().position(|it| it == segment))
                    .and_then(|run| Some((0, judged.simulated.get(run)?.clone()))),
                _ => None,
            };
            if let Some((unknown, values)) = own {
                let known = begin + unknown as f64 * record.sample_time;
                // A simulation that diverges would flatten what was measured.
                let mut points = thin(&values);
                points.retain(|(t, it)| *t >= known && is_near(*it, outputs.0, outputs.1));
                simulated.push(points);
            }
        }
        let [mut of_input, mut of_output] = plots;
        for (at, points) in simulated.into_iter().enumerate() {
            of_output = of_output.line(if at == 0 { "simulated" } else { "" }, points);
        }
        // A long record hides the shade.
        let held = self
            .parts
            .iter()
            .filter(|it| it.file == number && [KEPT, JUDGED].contains(&it.role));
        for (at, _) in held.map(|it| it.times) {
            of_input = of_input.with(Style::Bound, "", [(at, inputs.0), (at, inputs.1)]);
            of_output = of_output.with(Style::Bound, "", [(at, outputs.0), (at, outputs.1)]);
        }
        [of_input, of_output]
    }

    /// Measured and simulated output at the beginning of the held-out samples, sample by sample.
    pub(crate) fn close_up<'p>(&self, analysis: &Analysis, output: &'p str) -> Option<Plot<'p>> {
        let (prepared, segment, from, simulated) =
            match (&analysis.validation, &self.data.validation) {
                (Some(judged), Some(validation)) => (
                    validation,
                    judged.segments[judged.longest],
                    0,
                    judged.simulated[judged.longest].clone(),
                ),
                _ => {
                    let fitted = &self.data.prepared;
                    let simulated = Simulated::new(analysis, &fitted.resampled.record).ok()?;
                    (
                        fitted,
                        analysis.segments[analysis.longest],
                        analysis.held_out.from,
                        simulated.simulated,
                    )
                }
            };
        let record = &prepared.resampled.record;
        let source = record.segments[segment].source;
        let is_its = |it: &&File<'_>| std::ptr::eq(it.prepared, prepared) && it.source == source;
        let begin = self.files.iter().find(is_its)?.begin(segment);
        let timed = |values: &[f64]| {
            let values = values.iter().enumerate().skip(from).take(CLOSE);
            let timed = values.map(|(k, it)| (begin + k as f64 * record.sample_time, *it));
            timed.collect::<Vec<_>>()
        };
        let measured = timed(record.segments[segment].outputs.first()?);
        let (low, high) = range(&measured.iter().map(|it| it.1).collect::<Vec<_>>());
        let mut simulated = timed(&simulated);
        simulated.retain(|it| is_near(it.1, low, high));
        Some(
            Plot::new(
                "Output at the beginning of the held-out samples",
                [TIME, output],
            )
            .note("For each sample: the measured output, and the output simulated by the printed model from the input only.")
            .with(Style::Broad, "measured", measured)
            .line("simulated", simulated),
        )
    }

    /// Table of methods and samples.
    pub(crate) fn table(&self) -> Markup {
        let plotted = self.files.len().min(FILES);
        html! {
            div.scroll { table.words {
                thead { tr { @for head in ["numbers", "method and source", "samples", "plots"] { th { (head) } } } }
                @for entry in Entry::ALL { tr #(entry.id()) {
                    td { (entry.described().1) }
                    td { (entry.described().2) @if matches!(entry, Entry::Margins | Entry::Steps) && !self.plants.is_empty() { " Here: " (self.plants) "." } }
                    td.links { (self.samples_of(entry)) }
                    td.links {
                        @if entry == Entry::Data || entry == Entry::Validation {
                            @for number in 1..=plotted { a href=(format!("#file-{number}-output")) { "file " (number) } " " }
                        }
                        @for (_, id, title) in self.plots.iter().filter(|it| it.0 == entry) { a href=(format!("#{id}")) { (title) } br; }
                    }
                } }
            } }
            p { (format!(
                "Samples are on a grid of {} s and counted from 1 in each file; times start at the output's first sample in the file.",
                number(self.data.prepared.resampled.record.sample_time)
            )) }
            div.scroll { table.words {
                thead { tr { @for head in ["row", "file", "samples", "time, s", "role", "shown in"] { th { (head) } } } }
                @for (row, part) in (1..).zip(&self.parts) { tr #(part.id) {
                    td { (row) }
                    td { (self.files[part.file].name()) }
                    td { (part.samples.0) " to " (part.samples.1) }
                    td { (format!("{:.3} to {:.3}", part.times.0, part.times.1)) }
                    td { (part.role) }
                    td.links { @if part.file < plotted { @for kind in ["input", "output"] {
                        a href=(format!("#file-{}-{kind}", part.file + 1)) data-from=(part.times.0) data-to=(part.times.1) { (kind) } " "
                    } } }
                } }
            } }
            @if self.left_out > 0 { p { (self.left_out) " further segments are not listed." } }
        }
    }

    /// Links to the samples of an entry.
    fn samples_of(&self, entry: Entry) -> Markup {
        let has = |id: &str| self.parts.iter().any(|it| it.id == id);
        let fitted = self.parts.iter().filter(|it| it.role == FITTED).count();
        let mut text = String::new();
        let _ = write!(
            text,
            "all fitted samples ({fitted} segment{})",
            if fitted == 1 { "" } else { "s" }
        );
        html! {
            @match entry {
                Entry::Data => a href="#samples-fitted" { "every sample of each file" },
                Entry::Excitation | Entry::Response => a href="#samples-fitted" { (format!("every used segment, at frequencies with a coherence of {COHERENCE} or more")) },
                Entry::Validation => {
                    @if has(HELD_OUT) { a href="#samples-held-out" { "held out" } "; " }
                    a href="#samples-fitted" { (text) }
                }
                Entry::Residuals => a href="#samples-fitted" { "the longest segment" },
                Entry::Model => a href="#samples-fitted" { (text) },
                Entry::Margins | Entry::Causes | Entry::Steps => { "the model and its covariance, which are computed from these samples: " a href="#samples-fitted" { (text) } }
            }
        }
    }
}
