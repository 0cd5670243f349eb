//! Review of an identified model and its gains, for colleagues: one self-contained page, conclusion first, that prints on a few A4 pages. Each
//! sentence and each cell links to the method and the samples it was computed from (`evidence`). Links from there lead back to the plots, in which
//! the samples' range is shaded.

use crate::plot::Plot;
use maud::{Markup, html};
use planesman_console::Table;
use planesman_fit::{FitData, FitResult};
use planesman_flight::titles;
use planesman_identification::analysis::{Analysis, Standing, Verdict};
use planesman_identification::frequency::{COHERENCE, MeasuredResponse};
use planesman_linear::digits::significant;
use planesman_tuning::{Band, Distribution, MISSED, Tuning};

use crate::pages::cards::{Card, Tone, cards};
use crate::pages::evidence::{Entry, Evidence, linked};
use crate::pages::fit::{FREQUENCY, SINCE_STEP, bode, correlation, map, measured, step, words};
use crate::pages::tables::{TESTS, of_test};
use crate::pages::{document, figure, poles, tuning};

/// Width of a printed plot, px: two fit side by side on A4.
const PAPER: u32 = 345;
/// Style of links: like plain numbers.
const STYLE: &str = "
a.n { color: inherit; text-decoration: underline dotted var(--muted); text-underline-offset: 2px; }
nav a { margin-right: 1rem; display: inline-block; min-height: 24px; }
td.links a { display: inline-block; min-height: 24px; }
:target { scroll-margin-top: 1rem; }
tr:target, .anchor:target { outline: 2px solid var(--accent); outline-offset: 2px; }
code { overflow-wrap: anywhere; background: var(--surface); padding: .1rem .3rem; }
@media print {
  body { font-size: 9pt; line-height: 1.35; }
  h1 { font-size: 15pt; margin-right: 0; } h2 { font-size: 12pt; margin: 1rem 0 .2rem; break-after: avoid; }
  nav { display: none; }
  .plots { display: grid; grid-template-columns: 1fr 1fr; gap: .4rem 1rem; }
  .plots > * { break-inside: avoid; } figure { margin-bottom: 0; } figure > p, .plot .legend { font-size: 7.5pt; line-height: 1.25; }
  .plot .head h2 { font-size: 9pt; } .plot .area { min-height: 0; }
  td.links a { display: inline; }
  th, td { padding: .1rem .5rem .1rem 0; } tr { break-inside: avoid; } p, ul.verdict li { max-width: none; }
}";

/// Gains and their results, for any kind of controller.
pub struct Gains<'a> {
    /// Whether the limits are kept.
    pub keeps_limits: bool,
    /// Sentences: whether the limits are kept, the margins, and the property that limits the margins.
    pub sentences: Vec<String>,
    /// The gains and how they were found: name and value.
    pub lines: Vec<(&'static str, String)>,
    /// Gain crossover frequency, rad/s.
    pub crossover: Option<f64>,
    /// Description of the plants over which the gains are judged.
    pub plants: String,
    /// Table of the margins.
    pub margins: Table,
    /// Table of the step responses.
    pub steps: Table,
    /// Table of the causes of the margins' uncertainty.
    pub causes: Option<Table>,
    /// Plots of margins, and of step responses.
    pub plots: [Vec<Plot<'a>>; 2],
}

impl<'a> Gains<'a> {
    /// Results of a PI or PID controller; `titles` are those of input and output, `seed` is the seed of the drawn plants.
    #[must_use]
    pub fn of_tuning(of: &Tuning, titles: [&'a str; 2], seed: u32) -> Self {
        let robustness = &of.robustness;
        let mut sentences = vec![
            tuning::verdict(of),
            worst(
                [
                    robustness.phase(),
                    robustness.gain(),
                    robustness.sensitivity(),
                ],
                robustness.draws.len(),
            ),
        ];
        if !of.causes.is_empty() {
            sentences.push(tuning::limiting(of));
        }
        let mut lines = vec![
            ("parallel form", tuning::parallel_text(of)),
            ("ideal form", tuning::ideal_text(of)),
            (
                "sample time",
                format!(
                    "{} s, computing delay {} s",
                    tuning::number(of.sampling.tick),
                    tuning::number(of.sampling.computing_delay)
                ),
            ),
            ("method", tuning::method_text(of)),
            ("model", of.model.description.clone()),
        ];
        lines.extend(tuning::reduced_text(of).map(|it| ("reduced", it)));
        lines.extend(of.notes.iter().map(|it| ("note", it.clone())));
        Self {
            keeps_limits: of.keeps_limits(),
            sentences,
            lines,
            crossover: robustness.model.crossover,
            plants: drawn_text(robustness.draws.len(), seed),
            margins: tuning::margins(of),
            steps: tuning::responses(of),
            causes: (!of.causes.is_empty()).then(|| tuning::causes(of)),
            plots: [
                tuning::of_margins(of),
                tuning::after_steps(of, titles[0], titles[1]),
            ],
        }
    }
}

/// Description of the plants over which gains are judged.
#[must_use]
pub fn drawn_text(draws: usize, seed: u32) -> String {
    match draws {
        0 => "only the model itself, which is assumed to be exact".to_owned(),
        n => format!("the model and {n} plants drawn from its covariance, seed {seed}"),
    }
}

/// Sentence with phase margin, degrees, gain margin, dB, and sensitivity peak: worst of 95 % of `draws` plants.
#[must_use]
pub fn worst([phase, gain, peak]: [Distribution; 3], draws: usize) -> String {
    let cell = |value: f64, decimals: usize, unit: &str| match value.is_finite() {
        true => format!("{value:.decimals$}{unit}"),
        false => "none".to_owned(),
    };
    let of = match draws {
        0 => "margins of the model".to_owned(),
        n => format!("worst of 95 % of {n} plants"),
    };
    format!(
        "{of}: phase margin {}, gain margin {}, sensitivity peak Ms {}",
        cell(phase.quantile(MISSED), 1, " deg"),
        cell(gain.quantile(MISSED), 1, " dB"),
        cell(peak.quantile(1.0 - MISSED), 2, "")
    )
}

/// Plots of the dive loops: distribution of the phase margin with its required minimum, rad, and depth after a unit step.
#[must_use]
pub fn of_dive(phase: &Distribution, least: f64, depth: &Band) -> [Vec<Plot<'static>>; 2] {
    let step = Plot::new(
        "Depth after a unit step of its setpoint",
        [SINCE_STEP, "depth [m]"],
    )
    .note(
        "Linear simulation. The band contains 90 % of the vehicles drawn from the model's covariance.",
    )
    .y_down();
    [
        tuning::histogram(phase, least).into_iter().collect(),
        vec![tuning::banded(step, depth)],
    ]
}

/// Contents of a review. A missing part is replaced by the reason and the next step.
pub struct Review<'a> {
    /// The command that repeats the review.
    pub command: &'a str,
    /// The program and version.
    pub program: &'a str,
    /// The data.
    pub data: &'a FitData,
    /// Frequency response of the data.
    pub response: Result<&'a MeasuredResponse, String>,
    /// The model.
    pub model: Result<&'a FitResult, String>,
    /// The gains.
    pub gains: Result<Gains<'a>, String>,
}

impl Review<'_> {
    fn analysis(&self) -> Option<&Analysis> {
        self.model.as_ref().ok().map(|it| &it.analysis)
    }

    /// The verdict: colour, word, reason, and the entry it is based on.
    fn verdict(&self) -> (Tone, &'static str, String, Entry) {
        let verdict = self.analysis().map(|it| it.verdict);
        let words = verdict.map_or("", Verdict::words);
        let next = self.analysis().map(Analysis::next).unwrap_or_default();
        let (tone, word, why) = match (&self.model, &self.gains) {
            (Err(reason), _) => return (Tone::Bad, "NOT USABLE", reason.clone(), Entry::Model),
            (Ok(_), Err(reason)) => {
                return (Tone::Bad, "NOT USABLE", reason.clone(), Entry::Margins);
            }
            (Ok(_), Ok(gains)) => match (gains.keeps_limits, verdict.map(Verdict::standing)) {
                (false, _) => (
                    Tone::Bad,
                    "LIMITS NOT KEPT",
                    format!("the gains do not keep the required limits; the model is {words}"),
                ),
                (_, Some(Standing::Good | Standing::Usable)) => {
                    (Tone::Good, "USABLE", format!("the model is {words}"))
                }
                (_, Some(Standing::UsableWithCare)) => (
                    Tone::Fair,
                    "USABLE WITH CARE",
                    format!("the model is {words}. Next: {next}"),
                ),
                _ => (
                    Tone::Bad,
                    "DOUBTFUL",
                    format!("the model is {words}. Next: {next}"),
                ),
            },
        };
        (tone, word, why, Entry::Validation)
    }

    /// The conclusion as cards.
    fn cards(&self) -> Vec<Card> {
        let (tone, word, why, _) = self.verdict();
        let mut all = vec![Card::new("conclusion", word).toned(tone).note(why)];
        if let Some(fit) = self.analysis().and_then(|it| it.held_out.fit) {
            all.push(Card::new("fit on held-out data", format!("{fit:.1} %")));
        }
        if let Ok(gains) = &self.gains {
            let first = gains.lines.first();
            all.extend(first.map(|(name, value)| Card::new(format!("gains, {name}"), value)));
            let crossover = gains.crossover.map(|it| significant(it, 3) + " rad/s");
            all.extend(crossover.map(|it| Card::new("crossover", it)));
        }
        all
    }

    /// The conclusion as sentences, each with the entry it is based on.
    fn conclusion(&self) -> Vec<(String, Entry)> {
        let mut told = Vec::new();
        let (_, word, why, entry) = self.verdict();
        told.push((format!("{word}: {why}"), entry));
        if let Some(found) = self.analysis() {
            let percent = |it: f64| format!("{it:.1} %");
            let held_out = found.held_out.fit.map_or_else(
                || "the model is not validated on held-out data".to_owned(),
                |it| {
                    format!(
                        "the model simulates held-out data with a fit of {}",
                        percent(it)
                    )
                },
            );
            let all = found.fit.map(|it| {
                format!(
                    ", and the complete longest segment with a fit of {}",
                    percent(it)
                )
            });
            told.push((held_out + &all.unwrap_or_default(), Entry::Validation));
        }
        let Ok(gains) = &self.gains else {
            return told;
        };
        if let Some((name, value)) = gains.lines.first() {
            told.push((format!("gains, {name}: {value}"), Entry::Margins));
        }
        let entries = [Entry::Margins, Entry::Margins, Entry::Causes];
        told.extend(gains.sentences.iter().cloned().zip(entries));
        told.extend(
            self.in_band(gains.crossover)
                .map(|it| (it, Entry::Response)),
        );
        told
    }

    /// The conclusion in sentences.
    pub fn sentences(&self) -> impl Iterator<Item = String> {
        self.conclusion().into_iter().map(|it| it.0)
    }

    /// A sentence on whether the crossover frequency lies in the band where the data supports the model.
    fn in_band(&self, crossover: Option<f64>) -> Option<String> {
        let crossover = crossover?;
        let at = significant(crossover, 3);
        let Some((low, high)) = self.response.as_ref().ok()?.band() else {
            return Some(format!(
                "the data does not support the model at the crossover, {at} rad/s: the coherence is too low at all frequencies"
            ));
        };
        let band = format!(
            "the band where the output follows the input, {} to {} rad/s",
            significant(low, 3),
            significant(high, 3)
        );
        Some(match (low..=high).contains(&crossover) {
            true => format!("the crossover, {at} rad/s, lies within {band}"),
            false => format!(
                "the crossover, {at} rad/s, lies OUTSIDE {band}, where the gains rely on the model's structure only. Next: also excite the plant near {at} rad/s"
            ),
        })
    }
}

/// The HTML page.
#[must_use]
pub fn page(review: &Review<'_>) -> String {
    let record = &review.data.prepared.resampled.record;
    let first = |names: &[String]| names.first().cloned().unwrap_or_default();
    let names = [first(&record.inputs), first(&record.outputs)];
    let columns =
        [&names[0], &names[1]].map(|it| titles::title(review.data.prepared.reading.column(it)));
    let title = format!(
        "Review: {} to {}",
        titles::name(&names[0]),
        titles::name(&names[1])
    );
    let mut evidence = Evidence::new(review.data, review.analysis());
    let mut sections = vec![(
        "Conclusion",
        html! {
            (cards(&review.cards()))
            ul.verdict { @for (text, entry) in review.conclusion().into_iter().skip(1) { li { (linked(&text, entry)) } } }
            p { "Each sentence and each cell has a link to the method and the samples behind its numbers (" a href="#evidence" { "all of them" } "). To repeat the review, run this command:" br; code { (review.command) } br; (review.program) }
        },
    )];
    sections.push((
        "Data",
        data(review, &mut evidence, [&columns[0], &columns[1]]),
    ));
    sections.push(("Excitation", excitation(review, &mut evidence, &columns[0])));
    sections.push(("Frequency response", response(review, &mut evidence)));
    sections.push(("Model", model(review, &mut evidence, &columns[1])));
    sections.push(("Validation", validation(review, &mut evidence, &columns[1])));
    sections.extend(gains(review, &mut evidence));
    sections.push(("Evidence", evidence.table()));
    let id = |name: &str| name.to_lowercase().replace(' ', "-");
    let body = html! {
        div data-paper=(PAPER) {
            h1 { (title) }
            nav { @for (name, _) in &sections { a href=(format!("#{}", id(name))) { (name) } } }
            @for (number, (name, content)) in (1..).zip(&sections) {
                h2 #(id(name)) { (number) " " (name) }
                (content)
            }
        }
    };
    document(&title, STYLE, &body, "")
}

/// A single page to share: the conclusion, the gains with their margins, and the plots of validation and step response.
#[must_use]
pub fn brief(review: &Review<'_>) -> String {
    let record = &review.data.prepared.resampled.record;
    let [input, output] = [&record.inputs, &record.outputs].map(|names| {
        let name = names.first().map_or("", String::as_str);
        titles::title(review.data.prepared.reading.column(name))
    });
    let evidence = Evidence::new(review.data, review.analysis());
    let close_up = (review.analysis()).and_then(|it| evidence.close_up(it, &output));
    let gains = review.gains.as_ref().ok();
    let steps = gains.and_then(|it| it.plots[1].first());
    let title = format!("Review: {input} to {output}");
    let body = html! {
        div data-paper=(PAPER) {
            h1 { (title) }
            (cards(&review.cards()))
            ul.verdict { @for text in review.sentences().skip(1) { li { (text) } } }
            @if let Some(gains) = gains {
                div.scroll { table.words { @for (name, value) in &gains.lines { tr { td { (name) } td { (value) } } } } }
                (gains.margins.html())
            }
            div.plots { @for plot in close_up.iter().chain(steps).filter(|it| !it.is_empty()) { (figure(plot)) } }
            p { "For data, excitation, residuals and the samples behind each number, run the same command without --brief." br;
                code { (review.command) } br; (review.program) }
        }
    };
    document(&title, STYLE, &body, "")
}

/// A paragraph in the place of a missing part: the reason.
fn missing(reason: &str) -> Markup {
    html! { p.warn { "None: " (reason) } }
}

/// Plots side by side, each with its anchor.
fn anchored(plots: &[Plot<'_>], mut id: impl FnMut(&Plot<'_>) -> String) -> Markup {
    html! { div.plots { @for plot in plots.iter().filter(|it| !it.is_empty()) {
        div.anchor #(id(plot)) { (figure(plot)) }
    } } }
}

/// Plots side by side, each registered as a plot of an entry.
fn of_entry(evidence: &mut Evidence<'_>, entry: Entry, plots: &[Plot<'_>]) -> Markup {
    anchored(plots, |plot| evidence.plot(entry, &plot.title))
}

fn data(review: &Review<'_>, evidence: &mut Evidence<'_>, columns: [&str; 2]) -> Markup {
    let cleaned = evidence.cleaned();
    let (ids, plots): (Vec<_>, Vec<_>) = evidence
        .of_files(columns, review.analysis())
        .into_iter()
        .unzip();
    let mut ids = ids.into_iter();
    html! {
        (evidence.channels().html_with(|cell| linked(cell, Entry::Data)))
        @if cleaned.is_empty() { p { "The data was not cleaned: every sample is used as recorded." } }
        @else { ul { @for line in &cleaned { li { (linked(line, Entry::Data)) } } } }
        (anchored(&plots, |_| ids.next().unwrap_or_default()))
    }
}

fn excitation(review: &Review<'_>, evidence: &mut Evidence<'_>, input: &str) -> Markup {
    let found = match &review.response {
        Ok(found) => found,
        Err(reason) => return missing(reason),
    };
    let sample_time = review.data.prepared.resampled.record.sample_time;
    let density = |it: &f64| 10.0 * libm::log10(2.0 * sample_time * it);
    let points = found.points.iter();
    let points = points.filter_map(|it| Some((it.omega, density(it.inputs.first()?))));
    let points: Vec<(f64, f64)> = points.filter(|it| it.1.is_finite()).collect();
    let heights = points.iter().map(|it| it.1);
    let (low, high) = (
        heights.clone().fold(f64::INFINITY, f64::min),
        heights.fold(f64::NEG_INFINITY, f64::max),
    );
    let plot = Plot::new(
        format!("Spectrum of the input, {input}"),
        ["frequency [rad/s]", "power spectral density [dB]"],
    )
    .note("One-sided, in dB relative to the squared unit per Hz. Shaded: the band where the output follows the input.")
    .log_x()
    .linked(FREQUENCY);
    let band = found.band();
    let plot = match band {
        Some(band) => plot.shaded("excited band", band, (low, high)),
        None => plot,
    };
    let text = match band {
        Some((from, to)) => format!(
            "The output follows the input from {} to {} rad/s: the coherence there is at least {COHERENCE} and significant.",
            significant(from, 3),
            significant(to, 3)
        ),
        None => format!(
            "The output follows the input at no frequency: the coherence is below {COHERENCE} or not significant. Next: record a chirp, a PRBS or steps that \
             move the output well beyond its noise, for longer."
        ),
    };
    html! {
        p { (linked(&text, Entry::Excitation)) }
        (of_entry(evidence, Entry::Excitation, &[plot.line("input", points)]))
    }
}

fn response(review: &Review<'_>, evidence: &mut Evidence<'_>) -> Markup {
    let found = match &review.response {
        Ok(found) => found,
        Err(reason) => return missing(reason),
    };
    let plots = match review.analysis() {
        Some(analysis) => {
            let reading = analysis.reading();
            let rows = found.rows(|omega| reading.response(omega).map(|it| it.value));
            bode(analysis, Some((rows, COHERENCE)))
        }
        None => {
            let plot = |title, axes| Plot::new(title, axes).log_x().linked(FREQUENCY);
            let plots = vec![
                plot("Magnitude", crate::pages::fit::MAGNITUDE),
                plot("Phase", crate::pages::fit::PHASE),
            ];
            measured(plots, &found.rows(|_| None), &[], COHERENCE)
        }
    };
    html! {
        p { "The measured response where the coherence is high enough, with 95 % intervals, and the model's response with its 95 % band. Both are computed \
             from the same samples by different methods: where they disagree, the model lacks dynamics or its band is too narrow." }
        (of_entry(evidence, Entry::Response, &plots))
    }
}

fn model(review: &Review<'_>, evidence: &mut Evidence<'_>, output: &str) -> Markup {
    let analysis = match &review.model {
        Ok(found) => &found.analysis,
        Err(reason) => return missing(reason),
    };
    let record = &review.data.prepared.resampled.record;
    let mut plots = vec![step(analysis, record, output)];
    plots.extend(map(analysis));
    let rows = words(analysis);
    html! {
        div.scroll { table.words { @for (name, value) in &rows { tr { td { (name) } td { (linked(value, Entry::Model)) } } } } }
        (poles::table_with_note(&[("", analysis.reading())], |cell| linked(cell, Entry::Model)))
        (of_entry(evidence, Entry::Model, &plots))
    }
}

fn validation(review: &Review<'_>, evidence: &mut Evidence<'_>, output: &str) -> Markup {
    let Some(analysis) = review.analysis() else {
        return html! { p { "No model was identified, so there is nothing to validate." } };
    };
    let mut tests = Table::new(TESTS);
    let mut plots = Vec::new();
    if let Some(found) = &analysis.residuals {
        for (what, it) in found.each() {
            tests.row(of_test(what, &it));
        }
        plots.push(correlation(
            "Residual autocorrelation",
            "White residuals stay within the bound (99 %).",
            &found.whiteness,
        ));
        plots.push(correlation(
            "Cross-correlation of residual and input",
            "Outside the bound at positive lags: missing dynamics; at negative lags: feedback.",
            &found.input,
        ));
    }
    let close_up: Vec<Plot<'_>> = evidence.close_up(analysis, output).into_iter().collect();
    html! {
        ul { @for reason in &analysis.reasons { li { (linked(&reason.to_string(), Entry::Validation)) } }
            li { (analysis.verdict_text()) } }
        @if !tests.is_empty() { (tests.html_with(|cell| linked(cell, Entry::Residuals))) }
        (of_entry(evidence, Entry::Validation, &close_up))
        p { "Measured and simulated output of each file: " a href="#data" { "Data" } "." }
        (of_entry(evidence, Entry::Residuals, &plots))
    }
}

fn gains<'a>(review: &Review<'a>, evidence: &mut Evidence<'_>) -> [(&'static str, Markup); 2] {
    const NAMES: [&str; 2] = ["Margins", "Robustness"];
    let gains = match &review.gains {
        Ok(gains) => gains,
        Err(reason) => return NAMES.map(|it| (it, missing(reason))),
    };
    evidence.plants(&gains.plants);
    let [of_margins, of_steps] = &gains.plots;
    let of_margins = of_entry(evidence, Entry::Margins, of_margins);
    let of_steps = of_entry(evidence, Entry::Steps, of_steps);
    let margins = html! {
        div.scroll { table.words { @for (name, value) in &gains.lines { tr { td { (name) } td { (linked(value, Entry::Margins)) } } } } }
        (gains.margins.html_with(|cell| linked(cell, Entry::Margins)))
        @if let Some(causes) = &gains.causes {
            p { "Causes of the phase margin's uncertainty:" }
            (causes.html_with(|cell| linked(cell, Entry::Causes)))
        }
        (of_margins)
    };
    let robustness = html! {
        p { "Over " (linked(&gains.plants, Entry::Steps)) "." }
        (gains.steps.html_with(|cell| linked(cell, Entry::Steps)))
        (of_steps)
    };
    [(NAMES[0], margins), (NAMES[1], robustness)]
}
