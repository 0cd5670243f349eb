//! `planesman sysid compare`: model files of any origin judged on data, beside each other.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Parser;
use planesman_identification::{SIGMAS_95, Uncertain};
use planesman_model_file::ModelFile;
use planesman_signals::Taken;

use super::arguments::{DataArgs, GridArgs, PreparationArgs, SignalArgs};
use super::compared::{Compared, fits, frequency_responses};
use super::{compare_page, model_file};
use crate::arguments::output_file;
use planesman_console::{Format, Table, print_wrapped};
use planesman_flight::sink::write_text;

/// Frequencies in the table, of a frequency response.
const FREQUENCIES: usize = 6;

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
    #[arg(long, value_parser = crate::arguments::format(), help_heading = "Output")]
    format: Option<Format>,
    /// Write an HTML page: simulated outputs, frequency and step responses, poles, residual tests
    #[arg(long, value_name = "FILE", value_parser = output_file, help_heading = "Output")]
    html: Option<PathBuf>,
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
        Some(format) => planesman_console::print(found.numbers().text(format))?,
        None => {
            print_wrapped(found.taken.account())?;
            for table in found.tables() {
                planesman_console::print(format!("\n{}", table.text(Format::Table)))?;
            }
        }
    }
    if let Some(path) = &args.html {
        let page = compare_page::page(&found.models, &found.taken);
        write_text(path, page)?;
        planesman_console::err!("{}: the page", path.display());
    }
    Ok(())
}

fn five(value: f64) -> String {
    format!("{value:.5}")
}

impl Comparison {
    /// A table for each question: fits, residual tests, poles, steady gain, frequency response.
    #[must_use]
    pub fn tables(&self) -> Vec<Table> {
        vec![
            fits(&self.models),
            self.tests(),
            self.poles(),
            self.gains(),
            self.responses(),
        ]
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
        let responses = frequency_responses(&self.models);
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
                    format!("{:.4}", it.omega),
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
        for (model, responses) in self.models.iter().zip(frequency_responses(&self.models)) {
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
            for it in responses {
                let omega = it.omega;
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
