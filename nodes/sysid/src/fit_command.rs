//! `sysid fit`: from a bag or a table to a record, and from the record to a model.
//!
//! The model is the equation-error model of [`crate::regression`], by least squares over the
//! whole record, row by row in the triangular form of [`crate::rls`]: memory does not grow with the rows.

use anyhow::{Result, anyhow};
use clap::Parser;
use serde::Serialize;

use crate::fit as explained;
use crate::model::Model;
use crate::record::{Channel, Method, Record};
use crate::regression::{History, Input, Shape};
use crate::resample::{Options, Resampler};
use crate::rls::RecursiveLeastSquares;
use crate::source::{DataArgs, Reading, Request, Role, Source, progress_bar};

/// A prior covariance so large that nothing of it is seen.
const NO_PRIOR: f64 = 1e60;

/// Singular values below this share of the largest count as zero.
const RANK_TOLERANCE: f64 = 1e-13;

/// Find a model between two signals of any bag or table.
#[derive(Clone, Debug, Parser)]
#[command(name = "sysid fit")]
pub struct FitArgs {
    #[command(flatten)]
    signals: SignalArgs,
    /// The model's order
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=20))]
    order: u8,
    /// Fit a constant too, for signals with an offset
    #[arg(long)]
    bias: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Two signals of some data, on one grid.
#[derive(Clone, Debug, clap::Args)]
pub struct SignalArgs {
    #[command(flatten)]
    data: DataArgs,
    /// The signal that drives: TOPIC:FIELD, or a CSV column
    #[arg(long, short, value_name = "SIGNAL")]
    input: String,
    /// The signal that responds
    #[arg(long, short, value_name = "SIGNAL")]
    output: String,
    #[command(flatten)]
    grid: GridArgs,
}

impl SignalArgs {
    /// Reads them as a record.
    ///
    /// # Errors
    /// As [`record`].
    pub fn record(&self) -> Result<Taken> {
        record(
            &self.data,
            std::slice::from_ref(&self.input),
            std::slice::from_ref(&self.output),
            self.grid.options(),
        )
    }
}

/// How samples are put on a grid.
#[derive(Clone, Debug, clap::Args)]
pub struct GridArgs {
    /// Instants per second [default: that of the slowest output]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    rate: Option<f64>,
    /// Only what lies between these times, in seconds from the first output's first sample
    #[arg(long, value_name = "FROM..TO", value_parser = window, allow_hyphen_values = true)]
    window: Option<(f64, f64)>,
    /// How inputs are put on the grid
    #[arg(long, value_enum, default_value = "mean")]
    input_method: Method,
    /// How outputs are put on the grid
    #[arg(long, value_enum, default_value = "linear")]
    output_method: Method,
    /// The longest pause that is no gap [default: five sample intervals]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    max_gap: Option<f64>,
}

impl GridArgs {
    /// The options they stand for.
    #[must_use]
    pub fn options(&self) -> Options {
        let (from, to) = self.window.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        Options {
            rate: self.rate,
            window: from..=to,
            input_method: self.input_method,
            output_method: self.output_method,
            max_gap: self.max_gap,
        }
    }
}

fn number(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| format!("'{text}' is no number"))
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = number(text)?;
    if (1e-6..=1e6).contains(&rate) {
        Ok(rate)
    } else {
        Err("a rate lies between 1e-6 and 1e6 Hz".to_owned())
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = number(text)?;
    if seconds > 0.0 && seconds <= 1e9 {
        Ok(seconds)
    } else {
        Err("a time between 0 and 1e9 s is expected".to_owned())
    }
}

fn window(text: &str) -> Result<(f64, f64), String> {
    let rule =
        || format!("'{text}' is no window; one is written FROM..TO, as 10..60, 10.. or ..60");
    let (from, to) = text.split_once("..").ok_or_else(rule)?;
    let edge = |text: &str, open: f64| match text {
        "" => Ok(open),
        text => number(text).map_err(|_| rule()),
    };
    let (from, to) = (edge(from, f64::NEG_INFINITY)?, edge(to, f64::INFINITY)?);
    if from < to {
        Ok((from, to))
    } else {
        Err(rule())
    }
}

/// A record made from data, and what there is to say of the making.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Taken {
    /// The record.
    pub record: Record,
    /// How the data was read.
    pub reading: Reading,
}

/// Reads the named inputs and outputs of the data as a record.
///
/// # Errors
/// One line: data that cannot be read, a signal that is not in it, signals that have no instant in common.
pub fn record(
    data: &DataArgs,
    inputs: &[String],
    outputs: &[String],
    options: Options,
) -> Result<Taken> {
    let source = Source::open(data)?;
    let requests: Vec<Request> = [(inputs, Role::Input), (outputs, Role::Output)]
        .into_iter()
        .flat_map(|(names, role)| {
            names.iter().map(move |name| Request {
                name: name.clone(),
                role,
            })
        })
        .collect();
    let mut resampler = Resampler::new(inputs, outputs, options);
    let bar = progress_bar(source.bytes(), data);
    let reading = source.read(
        &requests,
        &mut |signal, stamp, value| resampler.take(signal, stamp, value),
        &|bytes| bar.set_position(bytes),
    )?;
    bar.finish_and_clear();
    let record = resampler
        .finish()
        .map_err(|reason| match &reading.notes[..] {
            [] => anyhow!(reason),
            notes => anyhow!("{reason} ({})", notes.join("; ")),
        })?;
    Ok(Taken { record, reading })
}

/// A model and how well it explains the record it was made from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fitted {
    /// The sampling interval, s.
    pub sample_time: f64,
    /// `a1 ... an`.
    pub a: Vec<f64>,
    /// `b1 ... bn`, output unit per input unit.
    pub b: Vec<f64>,
    /// Output unit; 0 when none was fitted.
    pub bias: f64,
    /// Rows of the regression.
    pub rows: u64,
    /// Poles in z: real part, imaginary part.
    pub poles: Vec<[f64; 2]>,
    /// Steady output per steady input; none with a pole at z = 1.
    pub dc_gain: Option<f64>,
    /// One step ahead, %.
    pub fit_one_step: Option<f64>,
    /// Run on the input alone over the longest stretch, from rest, %.
    pub fit_simulated: Option<f64>,
}

/// Fits the first output of a record to its first input, by least squares.
///
/// # Errors
/// A sentence, when the record does not determine the model.
pub fn least_squares(record: &Record, shape: Shape) -> Result<Fitted, String> {
    let mut problem = RecursiveLeastSquares::new(shape.parameters(), 1.0, NO_PRIOR)?;
    let mut history = History::new(shape);
    let mut spread = explained::Spread::default();
    for stretch in &record.stretches {
        let (Some(inputs), Some(outputs)) = (stretch.inputs.first(), stretch.outputs.first())
        else {
            return Err("a record with an input and an output is needed".to_owned());
        };
        for (k, output) in outputs.iter().enumerate() {
            let Some(before) = k.checked_sub(1) else {
                history.begin(*output);
                continue;
            };
            if let Some(row) = history.push(Input::held(inputs[before]), *output) {
                problem.update(row, *output);
                spread.update(*output, 1.0);
            }
        }
    }
    let determined = problem.rank(RANK_TOLERANCE);
    if determined < shape.parameters() {
        return Err(format!(
            "the record's {} rows determine {} of {} parameters; a lower --order, or data in which the input moves more, may help",
            problem.rows(),
            determined,
            shape.parameters()
        ));
    }
    let theta: Vec<f64> = problem.parameters().iter().copied().collect();
    let model = Model::from_parameters(shape, &theta, record.sample_time);
    let longest = record.longest().and_then(|stretch| {
        let inputs: Vec<Input> = stretch
            .inputs
            .first()?
            .iter()
            .map(|u| Input::held(*u))
            .collect();
        explained::simulated(&model, &inputs, stretch.outputs.first()?)
    });
    Ok(Fitted {
        sample_time: record.sample_time,
        poles: model.poles()?.iter().map(|z| [z.re, z.im]).collect(),
        dc_gain: model.dc_gain(),
        rows: problem.rows(),
        fit_one_step: explained::fit(problem.cost(), spread.sum_of_squares()),
        fit_simulated: longest,
        a: model.a,
        b: model.b,
        bias: model.bias,
    })
}

/// What `sysid fit` found.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The record the model is of.
    pub record: Record,
    /// How the data was read.
    pub reading: Reading,
    /// The model.
    pub fitted: Fitted,
}

/// Reads the data and fits the model.
///
/// # Errors
/// As [`record`] and [`least_squares`].
pub fn fit(args: &FitArgs) -> Result<Found> {
    let Taken { record, reading } = args.signals.record()?;
    let shape = Shape {
        order: usize::from(args.order),
        moment: false,
        bias: args.bias,
    };
    let fitted = least_squares(&record, shape).map_err(|reason| anyhow!(reason))?;
    Ok(Found {
        record,
        reading,
        fitted,
    })
}

/// Runs `sysid fit` and prints the model.
///
/// # Errors
/// As [`fit`].
pub fn run(args: &FitArgs) -> Result<()> {
    let found = fit(args)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&told(&found))?);
    } else {
        let account = account(&found.record, &found.reading);
        print!("{account}{}", table(&found.fitted));
    }
    Ok(())
}

/// Everything but the record's numbers.
fn told(found: &Found) -> serde_json::Value {
    let Found {
        record,
        reading,
        fitted,
    } = found;
    serde_json::json!({
        "model": fitted,
        "record": {
            "sample_time": record.sample_time,
            "samples": record.samples(),
            "stretches": record.stretches.iter().map(|it| (it.start, it.len())).collect::<Vec<_>>(),
            "inputs": record.inputs,
            "outputs": record.outputs,
        },
        "reading": reading,
    })
}

/// The making of a record, for people.
#[must_use]
pub fn account(record: &Record, reading: &Reading) -> String {
    let mut text = format!(
        "{:.6} Hz, {} samples in {} stretch{}, {:.3} s; stamps {}\n",
        1.0 / record.sample_time,
        record.samples(),
        record.stretches.len(),
        if record.stretches.len() == 1 {
            ""
        } else {
            "es"
        },
        record.duration(),
        reading.stamps
    );
    for (kind, channels) in [("input ", &record.inputs), ("output", &record.outputs)] {
        for channel in channels {
            text += &format!("{kind}  {}: {}\n", channel.name, channel_account(channel));
        }
    }
    for note in &reading.notes {
        text += &format!("note    {note}\n");
    }
    text
}

fn channel_account(channel: &Channel) -> String {
    let timing = &channel.timing;
    let mut text = format!(
        "{} samples at {:.3} Hz, jitter {:.3} ms, {}",
        timing.samples,
        timing.rate(),
        timing.jitter * 1e3,
        channel.method
    );
    if timing.gaps > 0 {
        text += &format!(
            "; {} gaps, the longest {:.3} s",
            timing.gaps, timing.longest
        );
    }
    for (count, what) in [
        (timing.duplicates, "with a stamp that came before"),
        (timing.late, "too late to be put in order"),
        (timing.not_finite, "not finite"),
        (timing.absent, "messages without it"),
    ] {
        if count > 0 {
            text += &format!("; {count} {what}");
        }
    }
    text
}

/// The model, for people.
#[must_use]
pub fn table(fitted: &Fitted) -> String {
    let list = |values: &[f64]| {
        let values: Vec<String> = values.iter().map(|v| format!("{v:.9}")).collect();
        values.join("  ")
    };
    let poles: Vec<String> = fitted
        .poles
        .iter()
        .map(|[re, im]| match im {
            0.0 => format!("{re:.5}"),
            im => format!("{re:.5}{im:+.5}i"),
        })
        .collect();
    let mut text = format!("a       {}\nb       {}\n", list(&fitted.a), list(&fitted.b));
    if fitted.bias != 0.0 {
        text += &format!("bias    {:.9}\n", fitted.bias);
    }
    text += &format!("z poles {}\n", poles.join("  "));
    if let Some(gain) = fitted.dc_gain {
        text += &format!("dc gain {gain:.6}\n");
    }
    for (fit, how) in [
        (fitted.fit_one_step, "one step ahead"),
        (fitted.fit_simulated, "simulated"),
    ] {
        if let Some(fit) = fit {
            text += &format!("fit     {fit:.3} %, {how}\n");
        }
    }
    text
}
