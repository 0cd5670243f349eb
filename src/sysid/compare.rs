//! `planesman sysid compare`: model files of any origin judged on data, beside each other.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Parser;
use maud::{Markup, html};
use planesman_identification::estimators::Estimate;
use planesman_identification::validation::residuals::Correlation;
use planesman_identification::{Judgement, Reading, SIGMAS_95, Uncertain, filter};
use planesman_model_file::ModelFile;
use planesman_plot::{Series, Style};
use planesman_signals::Taken;

use super::arguments::{DataArgs, GridArgs, PreparationArgs, SignalArgs};
use super::model_file;
use super::page::{LOG_OMEGA, Response, bound, drawn, frequency_response, line, plot, unit_circle};
use crate::arguments::output_file;
use crate::page::document;
use crate::table::{Format, Table, print_wrapped};

/// Frequencies in the table, of a frequency response.
const FREQUENCIES: usize = 6;
/// Samples of a step response: at least, and at most.
const STEP: (usize, usize) = (20, 2000);
/// The share of its range that a step response may still be off where it counts as settled.
const SETTLED: f64 = 0.02;
/// Poles farther from 0 are not drawn.
const FAR: f64 = 4.0;

/// Judge model files on data, beside each other: simulation, predictions, residual tests, poles, frequency response.
///
/// Each model is simulated from a state fitted to the beginning of each segment; its offset is its own. Without --rate the
/// data is put on the grid of the first model.
#[derive(Clone, Debug, Parser)]
#[command(
    name = "sysid compare",
    override_usage = "planesman sysid compare [OPTIONS] <MODEL>... <DATA>...",
    mut_arg("data", |arg| arg.value_name("MODEL|DATA").help(
        "Model files (*.json, *.yaml), then the data: a bag folder, one or several .mcap or .db3 files of a split bag, \
         a .csv file, or a PX4 log (.ulg)"
    ))
)]
pub struct CompareArgs {
    #[command(flatten)]
    data: DataArgs,
    /// Input signal: TOPIC:FIELD, or a CSV column [default: that of the models]
    #[arg(long, short, value_name = "SIGNAL", help_heading = "Signals")]
    input: Option<String>,
    /// Output signal [default: that of the models]
    #[arg(long, short, value_name = "SIGNAL", help_heading = "Signals")]
    output: Option<String>,
    #[command(flatten)]
    grid: GridArgs,
    #[command(flatten)]
    preparation: PreparationArgs,
    /// How many samples ahead predictions are judged
    #[arg(long, value_name = "SAMPLES", value_delimiter = ',', default_value = "1,10",
        value_parser = clap::value_parser!(u16).range(1..=1000), help_heading = "Judgement")]
    ahead: Vec<u16>,
    /// As one table in this format, a row per number [default: a table for each question]
    #[arg(long, value_enum, help_heading = "Output")]
    format: Option<Format>,
    /// Write an HTML page: simulated outputs, frequency and step responses, poles, residual tests
    #[arg(long, value_name = "FILE", value_parser = output_file, help_heading = "Output")]
    html: Option<PathBuf>,
}

/// A model and the judgement on it.
#[derive(Clone, Debug)]
pub struct Compared {
    /// Its name in the tables.
    pub name: String,
    /// The method that found it.
    pub method: String,
    /// What it does on the data.
    pub judgement: Judgement,
}

impl Compared {
    fn reading(&self) -> Reading<'_> {
        Reading::of(&self.judgement.estimate, self.judgement.longest)
    }

    fn order(&self) -> String {
        order(&self.judgement.estimate)
    }

    fn delay(&self) -> usize {
        self.judgement.estimate.layout.structure.delay
    }

    /// The poles in s, the slowest first, of a pair the upper one.
    fn poles(&self) -> Vec<Uncertain> {
        let mut poles = self.reading().continuous_poles().unwrap_or_default();
        poles.retain(|pole| pole.value.im >= 0.0);
        poles.sort_by(|p, q| p.value.norm().total_cmp(&q.value.norm()));
        poles
    }

    /// The tests of the residual: what is tested, and the correlations.
    fn tests(&self) -> Vec<(&'static str, &Correlation)> {
        let tests = self.judgement.residuals.iter();
        tests
            .flat_map(|it| [("white", &it.whiteness), ("free of the input", &it.input)])
            .collect()
    }

    fn frequency_response(&self) -> Vec<Response> {
        frequency_response(&self.reading(), self.judgement.estimate.sample_time)
    }
}

/// Models on one record.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The record, and how it was made.
    pub taken: Taken,
    /// The models, in the order in which they were given.
    pub models: Vec<Compared>,
}

/// Reads models and data, and judges.
///
/// # Errors
/// One line: a model file that is refused, models of different signals, data without the signals, a model of another
/// sampling interval.
pub fn compare(args: &CompareArgs) -> Result<Comparison> {
    let mut data = args.data.clone();
    let paths = data.take_models();
    let files: Vec<ModelFile> = paths
        .iter()
        .map(|path| Ok(ModelFile::read(path)?))
        .collect::<Result<_>>()?;
    let Some(first) = files.first() else {
        bail!("a model file is needed, *.json or *.yaml, as sysid fit --model writes it");
    };
    if data.is_empty() {
        bail!("data is needed behind the model files: a bag, a .csv file or a PX4 log");
    }
    let signals = [
        (
            &args.input,
            "--input",
            (|it| &it.input) as fn(&ModelFile) -> &String,
        ),
        (&args.output, "--output", |it| &it.output),
    ];
    let signals = signals.map(|(asked, option, of)| match asked {
        Some(name) => Ok(name.clone()),
        None => {
            let other = files.iter().zip(&paths).find(|(it, _)| of(it) != of(first));
            match other {
                None => Ok(of(first).clone()),
                Some((other, path)) => bail!(
                    "{} is of '{}', {} of '{}': {option} SIGNAL says which of the data's signals they are judged on",
                    paths[0].display(),
                    of(first),
                    path.display(),
                    of(other)
                ),
            }
        }
    });
    let [input, output] = signals;
    let (grid, preparation) = (args.grid.clone(), args.preparation.clone());
    let signals = SignalArgs::named([input?, output?], data, grid, preparation);
    let rate = 1.0 / first.sample_time;
    let refused = || {
        format!(
            "{} asks for a grid of {} s",
            paths[0].display(),
            first.sample_time
        )
    };
    let read = |signals: SignalArgs| signals.at_rate(rate).record(0, false).with_context(refused);
    let mut taken = read(signals.clone())?;
    // A model of decimated data is of means.
    if let Some(averaged) = signals.averaged_where_decimated(&taken) {
        taken = read(averaged)?;
    }
    let ahead: Vec<usize> = args.ahead.iter().map(|it| usize::from(*it)).collect();
    let models = files.iter().zip(names(&paths)).zip(&paths);
    let models = models
        .map(|((file, name), path)| {
            let judgement = model_file::given(file)
                .on(&taken.resampled.record, &ahead)
                .with_context(|| {
                    let rate = 1.0 / file.sample_time;
                    format!("{} (--rate {rate} makes a grid for it)", path.display())
                })?;
            Ok(Compared {
                name,
                method: file.method.clone(),
                judgement,
            })
        })
        .collect::<Result<_>>()?;
    Ok(Comparison { taken, models })
}

/// Names as short as they can be: the files' without folder and ending, or their paths where two are the same.
fn names(paths: &[PathBuf]) -> Vec<String> {
    let stem = |path: &Path| {
        let stem = path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    };
    let unique = |path: &&PathBuf| paths.iter().filter(|it| stem(it) == stem(path)).count() == 1;
    let name = |path: &PathBuf| match unique(&path) {
        true => stem(path),
        false => path.display().to_string(),
    };
    paths.iter().map(name).collect()
}

/// Runs the command: prints the tables, writes the page.
///
/// # Errors
/// As [`compare`]; a page that cannot be written.
pub fn run(args: &CompareArgs) -> Result<()> {
    let found = compare(args)?;
    match args.format {
        Some(format) => planesman_node::print(found.numbers().text(format)?)?,
        None => {
            print_wrapped(found.taken.account())?;
            for table in found.tables() {
                planesman_node::print(format!("\n{}", table.text(Format::Table)?))?;
            }
        }
    }
    if let Some(path) = &args.html {
        let page = page(&found.models, &found.taken)?;
        std::fs::write(path, page).with_context(|| format!("{}", path.display()))?;
        planesman_node::complain!("{}: the page", path.display());
    }
    Ok(())
}

/// A fit as a cell.
pub(super) fn percent(fit: Option<f64>) -> String {
    match fit {
        None => "-".to_owned(),
        Some(fit) if fit < -1e5 => format!("{fit:.1e}"),
        Some(fit) => format!("{fit:.2}"),
    }
}

/// The poles that are not 0; of a finite impulse response, which has no others, its coefficients.
pub(super) fn order(of: &Estimate) -> String {
    let a = &of.theta.as_slice()[of.layout.a()];
    match a.iter().rposition(|a| *a != 0.0) {
        None => format!("{} (fir)", of.layout.structure.numerator),
        Some(last) => (last + 1).to_string(),
    }
}

fn five(value: f64) -> String {
    format!("{value:.5}")
}

impl Comparison {
    /// A table for each question: fits, residual tests, poles, steady gain, frequency response.
    #[must_use]
    pub fn tables(&self) -> Vec<Table> {
        let mut tables = vec![fits(&self.models), self.tests(), self.poles(), self.gains()];
        tables.push(self.responses());
        tables
    }

    fn tests(&self) -> Table {
        let columns = [
            "model",
            "residual",
            "passes",
            "lags outside",
            "largest",
            "99 % bound",
        ];
        let mut table = Table::new(columns);
        for model in &self.models {
            for (what, found) in model.tests() {
                table.row([
                    model.name.clone(),
                    what.to_owned(),
                    if found.passes() { "yes" } else { "no" }.to_owned(),
                    format!("{} of {}", found.outside(), found.values.len()),
                    format!("{:.3}", found.largest()),
                    format!("{:.3}", found.bound),
                ]);
            }
        }
        table
    }

    fn poles(&self) -> Table {
        let columns = [
            "pole",
            "model",
            "real, 1/s",
            "± 95 %",
            "imaginary, 1/s",
            "± 95 %",
        ];
        let mut table = Table::new(columns);
        let poles: Vec<Vec<Uncertain>> = self.models.iter().map(Compared::poles).collect();
        for number in 0..poles.iter().map(Vec::len).max().unwrap_or(0) {
            for (model, poles) in self.models.iter().zip(&poles) {
                let Some(pole) = poles.get(number) else {
                    continue;
                };
                table.row([
                    (number + 1).to_string(),
                    model.name.clone(),
                    five(pole.value.re),
                    five(SIGMAS_95 * pole.real_deviation()),
                    five(pole.value.im),
                    five(SIGMAS_95 * pole.imaginary_deviation()),
                ]);
            }
        }
        table
    }

    fn gains(&self) -> Table {
        let mut table = Table::new(["model", "steady gain", "± 95 %"]);
        for model in &self.models {
            let gain = model.reading().dc_gain();
            table.row([
                model.name.clone(),
                gain.map_or("none".to_owned(), |it| five(it.value.re)),
                gain.map_or("-".to_owned(), |it| five(SIGMAS_95 * it.real_deviation())),
            ]);
        }
        table
    }

    fn responses(&self) -> Table {
        let columns = [
            "rad/s",
            "model",
            "magnitude, dB",
            "± 95 %",
            "phase, deg",
            "± 95 %",
        ];
        let mut table = Table::new(columns);
        let responses: Vec<Vec<Response>> = self
            .models
            .iter()
            .map(Compared::frequency_response)
            .collect();
        let most = responses.iter().map(Vec::len).max().unwrap_or(0);
        let stride = (most / FREQUENCIES).max(1);
        for at in (0..most)
            .rev()
            .step_by(stride)
            .take(FREQUENCIES)
            .collect::<Vec<_>>()
            .into_iter()
            .rev()
        {
            for (model, responses) in self.models.iter().zip(&responses) {
                let Some(it) = responses.get(at) else {
                    continue;
                };
                let up = it.magnitude(SIGMAS_95) - it.magnitude(0.0);
                let turn = SIGMAS_95 * it.value.phase_deviation().to_degrees();
                table.row([
                    format!("{:.4}", 10f64.powf(it.log_omega)),
                    model.name.clone(),
                    format!("{:.2}", it.magnitude(0.0)),
                    format!("{up:.2}"),
                    format!("{:.1}", it.phase),
                    format!("{turn:.1}"),
                ]);
            }
        }
        table
    }

    /// Every number in a row of its own.
    #[must_use]
    pub fn numbers(&self) -> Table {
        let mut table = Table::new(["model", "quantity", "value", "deviation"]);
        for model in &self.models {
            let mut row = |quantity: String, value: String, deviation: Option<f64>| {
                let deviation = deviation.map_or(String::new(), |it| it.to_string());
                table.row([model.name.clone(), quantity, value, deviation]);
            };
            let fit = |fit: Option<f64>| fit.map_or(String::new(), |it| it.to_string());
            row("method".to_owned(), model.method.clone(), None);
            row("order".to_owned(), model.order(), None);
            row("delay".to_owned(), model.delay().to_string(), None);
            row(
                "samples".to_owned(),
                model.judgement.samples.to_string(),
                None,
            );
            row(
                "simulated fit, %".to_owned(),
                fit(model.judgement.fit),
                None,
            );
            for (ahead, of) in &model.judgement.predicted {
                row(format!("fit {ahead} ahead, %"), fit(*of), None);
            }
            for (what, found) in model.tests() {
                row(format!("residual {what}"), found.passes().to_string(), None);
                row(
                    format!("residual {what}: lags outside"),
                    found.outside().to_string(),
                    None,
                );
                row(
                    format!("residual {what}: largest"),
                    found.largest().to_string(),
                    None,
                );
                row(
                    format!("residual {what}: bound"),
                    found.bound.to_string(),
                    None,
                );
            }
            for (i, pole) in (1..).zip(model.poles()) {
                let [re, im] = [pole.value.re, pole.value.im].map(|it| it.to_string());
                row(
                    format!("pole {i} real, 1/s"),
                    re,
                    Some(pole.real_deviation()),
                );
                row(
                    format!("pole {i} imaginary, 1/s"),
                    im,
                    Some(pole.imaginary_deviation()),
                );
            }
            if let Some(gain) = model.reading().dc_gain() {
                let deviation = gain.real_deviation();
                row(
                    "steady gain".to_owned(),
                    gain.value.re.to_string(),
                    Some(deviation),
                );
            }
            for it in model.frequency_response() {
                let omega = 10f64.powf(it.log_omega);
                let size = it.value.value.norm().to_string();
                let deviation = it.value.magnitude_deviation();
                row(
                    format!("magnitude at {omega:.6} rad/s"),
                    size,
                    Some(deviation),
                );
                let deviation = it.value.phase_deviation().to_degrees();
                row(
                    format!("phase at {omega:.6} rad/s, deg"),
                    it.phase.to_string(),
                    Some(deviation),
                );
            }
        }
        table
    }
}

/// What each model is, and how well it simulates and predicts.
fn fits(models: &[Compared]) -> Table {
    let ahead = models.first().map_or(&[][..], |it| &it.judgement.predicted);
    let ahead: Vec<String> = ahead
        .iter()
        .map(|(it, _)| format!("{it} ahead, %"))
        .collect();
    let columns = ["model", "method", "order", "delay", "simulated, %"].into_iter();
    let mut table = Table::of(columns.chain(ahead.iter().map(String::as_str)));
    for model in models {
        let first = [
            model.name.clone(),
            model.method.clone(),
            model.order(),
            model.delay().to_string(),
            percent(model.judgement.fit),
        ];
        let predicted = model.judgement.predicted.iter();
        table.row(
            first
                .into_iter()
                .chain(predicted.map(|(_, fit)| percent(*fit))),
        );
    }
    table
}

/// A page with the models drawn over each other.
///
/// # Errors
/// When a plot cannot be drawn.
pub(super) fn page(models: &[Compared], taken: &Taken) -> Result<String> {
    let record = &taken.resampled.record;
    let title = format!(
        "Models of {} to {}",
        record.inputs.first().map_or("", String::as_str),
        record.outputs.first().map_or("", String::as_str)
    );
    let plots = plots(models, taken)?;
    let body = html! {
        h1 { (title) }
        p.lead { "Each model is simulated from a state fitted to the beginning of the data; its offset is its own." }
        (fits(models).html())
        pre { (taken.account()) }
        @for plot in plots { (plot) }
    };
    Ok(document(&title, "", &body))
}

fn plots(models: &[Compared], taken: &Taken) -> Result<Vec<Markup>> {
    let record = &taken.resampled.record;
    let Some(longest) = models
        .first()
        .map(|it| it.judgement.segments[it.judgement.longest])
    else {
        return Ok(Vec::new());
    };
    let segment = &record.segments[longest];
    let timed = |values: &[f64]| -> Vec<(f64, f64)> {
        let values = values.iter().enumerate();
        values
            .map(|(k, v)| (k as f64 * record.sample_time, *v))
            .collect()
    };
    let measured = &segment.outputs[0];
    let range = |pick: fn(f64, f64) -> f64| measured.iter().copied().fold(measured[0], pick);
    let (low, high) = (range(f64::min), range(f64::max));
    // A simulation that diverges would flatten all others.
    let near =
        |value: f64| (value - low).abs().max((value - high).abs()) < FAR * (high - low).max(1e-9);
    // Models first, so that each has one colour on the whole page.
    let each = |of: &dyn Fn(&Compared) -> Vec<(f64, f64)>| -> Vec<Series<'_>> {
        models
            .iter()
            .map(|model| line(&model.name, of(model)))
            .collect()
    };
    let mut simulated = each(&|model| {
        let mut points = timed(&model.judgement.simulated[model.judgement.longest]);
        points.retain(|(_, value)| near(*value));
        points
    });
    simulated.push(bound("measured", timed(measured)));
    let output = &record.outputs[0];
    let mut drawings = vec![
        drawn(
            "Measured, and simulated on the input alone. What lies far beyond the measured range is not shown.",
            plot(
                "Measured and simulated output",
                "time [s]",
                output,
                simulated,
            ),
        )?,
        drawn(
            "Input over each sampling interval.",
            plot(
                "Input",
                "time [s]",
                &record.inputs[0],
                vec![line("input", timed(&segment.inputs[0]))],
            ),
        )?,
        drawn(
            "Frequency responses up to half the sampling rate.",
            plot(
                "Magnitude",
                LOG_OMEGA,
                "magnitude [dB]",
                each(&|model| {
                    let of = |it: &Response| (it.log_omega, it.magnitude(0.0));
                    model.frequency_response().iter().map(of).collect()
                }),
            ),
        )?,
        drawn(
            "The same for the phase.",
            plot(
                "Phase",
                LOG_OMEGA,
                "phase [deg]",
                each(&|model| {
                    let of = |it: &Response| (it.log_omega, it.phase);
                    model.frequency_response().iter().map(of).collect()
                }),
            ),
        )?,
    ];
    let mut poles: Vec<Series<'_>> = models.iter().map(pole_map).collect();
    poles.push(unit_circle());
    drawings.push(drawn(
        "In the z plane; points beyond |z| = 4 are not shown.",
        plot("Poles", "real part", "imaginary part", poles).one_scale(),
    )?);
    // Longer than about half of them take, so that one slow mode does not hide the others' beginning.
    let mut settled: Vec<usize> = models.iter().filter_map(settling).collect();
    settled.sort_unstable();
    let usual = settled
        .get(settled.len().saturating_sub(1) / 2)
        .copied()
        .unwrap_or_default();
    let count = (usual + usual / 2).clamp(STEP.0, STEP.1);
    drawings.push(drawn(
        "From rest, without offset. Unstable models are left out.",
        plot(
            "Step responses",
            "time [s]",
            output,
            each(&|model| match settling(model) {
                Some(_) => timed(&step_response(model, count)),
                None => Vec::new(),
            }),
        ),
    )?);
    drawings.push(correlations(
        models,
        "Residuals with themselves",
        "Over the bound that 99 % of white residuals stay within.",
        |tests| &tests.whiteness,
    )?);
    drawings.push(correlations(
        models,
        "Residuals with the input",
        "Over the same bound. Outside at positive lags: missing dynamics; at negative lags: feedback.",
        |tests| &tests.input,
    )?);
    Ok(drawings)
}

fn pole_map(model: &Compared) -> Series<'_> {
    let poles = model.reading().poles().unwrap_or_default();
    let points = poles.iter().map(|it| (it.value.re, it.value.im));
    Series {
        name: model.name.as_str().into(),
        points: points.filter(|p| p.0.hypot(p.1) < FAR).collect(),
        style: Style::Crosses,
    }
}

/// Samples after which a step response stays within a share of its range about its end; `None` for an unstable model,
/// whose response has none.
fn settling(model: &Compared) -> Option<usize> {
    let poles = model.reading().poles().ok()?;
    if poles.iter().any(|it| it.value.norm() > 1.0 + 1e-6) {
        return None;
    }
    let response = step_response(model, STEP.1);
    let end = *response.last()?;
    let most = response
        .iter()
        .fold(0.0_f64, |most, y| most.max((y - end).abs()));
    let far = response
        .iter()
        .rposition(|y| (y - end).abs() > SETTLED * most.max(end.abs()));
    Some(far.map_or(0, |last| last + 1))
}

fn step_response(model: &Compared, count: usize) -> Vec<f64> {
    let estimate = &model.judgement.estimate;
    let layout = &estimate.layout;
    let theta = estimate.theta.as_slice();
    let mut a = vec![1.0];
    a.extend(&theta[layout.a()]);
    let mut b = vec![0.0; layout.structure.delay];
    b.extend(&theta[layout.b(model.judgement.longest)]);
    filter(&b, &a, &vec![1.0; count])
}

fn correlations(
    models: &[Compared],
    title: &str,
    note: &str,
    of: fn(&planesman_identification::validation::residuals::ResidualTests) -> &Correlation,
) -> Result<Markup> {
    let mut series: Vec<Series<'_>> = models
        .iter()
        .map(|model| {
            let found = model.judgement.residuals.as_ref().map(of);
            let points = found.iter().flat_map(|it| {
                let values = it.values.iter();
                values.map(|(lag, r)| (*lag as f64, r / it.bound))
            });
            line(&model.name, points.collect())
        })
        .collect();
    let lags: Vec<f64> = series
        .iter()
        .flat_map(|it| it.points.iter().map(|p| p.0))
        .collect();
    let ends = [f64::min, f64::max].map(|pick| lags.iter().copied().reduce(pick));
    for (name, level) in [("99 %", 1.0), ("-99 %", -1.0)] {
        let ends = ends.iter().flatten();
        series.push(bound(name, ends.map(|lag| (*lag, level)).collect()));
    }
    drawn(
        note,
        plot(title, "lag [samples]", "correlation / bound", series),
    )
}
