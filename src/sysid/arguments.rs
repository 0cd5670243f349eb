//! Arguments shared by several commands: data, signals, a grid.

use std::io::IsTerminal;
use std::path::PathBuf;

use anyhow::{Result, anyhow, bail};
use clap::Args;
use planesman_bag::{is_bag_file, metadata, sorted_into_bags};
use planesman_console::progress::{ProgressBar, ProgressStyle};
use planesman_identification::stop_point;
use planesman_model_file::ModelFile;
use planesman_signals::{
    Band, Clock, ColumnSource, DECIMATION, Data, Method, Options, Outliers, Preparation,
    SegmentChoice, Source, TableTime, Taken, TimeUnit, Trend, take, unreachable, without_dynamics,
};
use planesman_units::Dimension;

use crate::arguments::{choice, quantity};

/// Half the shortest sampling interval, s.
const EDGE: f64 = 0.5e-6;

/// The data that a command is given.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Data")]
pub(super) struct DataArgs {
    /// A bag folder, a metadata.yaml, one or several .mcap or .db3 files of a split bag, a .csv file, or a PX4
    /// log (.ulg)
    #[arg(required = true, value_name = "DATA", help_heading = None::<&str>)]
    data: Vec<PathBuf>,
    /// Time stamps: of the message headers, or of the recorder (log) [default: header if all messages have one]
    #[arg(long, value_parser = choice(&Clock::ALL, Clock::described))]
    stamp: Option<Clock>,
    /// CSV column of time [default: time, t, stamp or timestamp, else a first column that rises from row to row]
    #[arg(long, value_name = "COLUMN", conflicts_with = "sample_time")]
    time: Option<String>,
    /// Unit of the time column of a CSV file [default: the one that its name ends in, as t_ms; else s]
    #[arg(long, value_parser = choice(&TimeUnit::ALL, TimeUnit::described), conflicts_with = "sample_time")]
    time_unit: Option<TimeUnit>,
    /// Interval between two rows of a CSV file without a time (s, or with its unit: 100ms)
    #[arg(long, value_name = "TIME", value_parser = quantity(Dimension::Time, 1e-6, 1e6))]
    sample_time: Option<f64>,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    /// Columns in memory in place of the data.
    #[arg(skip)]
    columns: Option<Columns>,
}

/// Columns by name.
pub type Columns = Vec<(String, Vec<f64>)>;

impl DataArgs {
    /// All of the data as one source.
    pub(super) fn open(&self) -> Result<Source> {
        self.opened(&self.of(self.data.clone()))
    }

    fn opened(&self, data: &Data) -> Result<Source> {
        match &self.columns {
            None => Ok(Source::open(data)?),
            Some(columns) => {
                let source = ColumnSource::new(columns.clone(), &data.time)?;
                Ok(Source::Columns(source))
            }
        }
    }

    /// Takes the model files out of what was given: *.json and *.yaml, but for a bag's metadata.yaml.
    pub(super) fn take_models(&mut self) -> Vec<PathBuf> {
        let is_model = |path: &PathBuf| {
            ModelFile::takes_name(path).is_ok()
                && path
                    .file_name()
                    .is_some_and(|name| name != metadata::FILE_NAME)
        };
        let given = std::mem::take(&mut self.data);
        let (models, data) = given.into_iter().partition(is_model);
        self.data = data;
        models
    }

    /// Whether nothing was given.
    pub(super) fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// One by one: the parts of a split bag belong together; every other path is a source of its own.
    fn sources(&self) -> Vec<Data> {
        let (parts, others): (Vec<PathBuf>, Vec<PathBuf>) = self
            .data
            .iter()
            .cloned()
            .partition(|path| is_bag_file(path));
        let others = others.into_iter().map(|path| vec![path]);
        sorted_into_bags(&parts)
            .into_iter()
            .chain(others)
            .map(|paths| self.of(paths))
            .collect()
    }

    fn of(&self, paths: Vec<PathBuf>) -> Data {
        Data {
            paths,
            stamp: self.stamp,
            time: TableTime {
                column: self.time.clone(),
                unit: self.time_unit,
                sample_time: self.sample_time,
            },
        }
    }

    /// A progress bar on the terminal, unless --quiet.
    pub(super) fn progress_bar(&self, bytes: u64) -> ProgressBar {
        if self.quiet || !std::io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let style = "{bar:40} {bytes}/{total_bytes} {bytes_per_sec} {eta}";
        match ProgressStyle::with_template(style) {
            Ok(style) => ProgressBar::new(bytes).with_style(style),
            Err(_) => ProgressBar::new(bytes),
        }
    }
}

/// Signals of some data, on one grid.
#[derive(Clone, Debug, Args)]
pub(super) struct SignalArgs {
    #[command(flatten)]
    data: DataArgs,
    /// Input signal: TOPIC:FIELD, or a CSV column
    #[arg(long, short, value_name = "SIGNAL", help_heading = "Signals")]
    input: String,
    /// Output signal
    #[arg(long, short, value_name = "SIGNAL", help_heading = "Signals")]
    output: String,
    /// Reference (setpoint) of the control loop, for closed-loop data: the model is then fitted in two stages
    #[arg(long, short, value_name = "SIGNAL", help_heading = "Signals")]
    reference: Option<String>,
    #[command(flatten)]
    grid: GridArgs,
    #[command(flatten)]
    preparation: PreparationArgs,
}

/// How a record is prepared before a model is fitted.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Preparation")]
pub(super) struct PreparationArgs {
    /// Outliers: samples far from the median of those around them
    #[arg(long, value_parser = choice(&Outliers::ALL, Outliers::described), default_value = "outputs")]
    outliers: Outliers,
    /// Band of frequencies that is used, of every signal: LOW..HIGH, or LOW.. against drift, or ..HIGH against noise (Hz)
    /// [default: all]
    #[arg(long, value_name = "LOW..HIGH", value_parser = band)]
    prefilter: Option<Band>,
    /// Which data is used
    #[arg(long, value_parser = choice(&SegmentChoice::ALL, SegmentChoice::described), default_value = "all")]
    segment: SegmentChoice,
    /// What is subtracted from each signal
    #[arg(long, value_parser = choice(&Trend::ALL, Trend::described), default_value = "none")]
    detrend: Trend,
}

/// Data to judge a model on.
#[derive(Clone, Debug)]
pub(super) enum Validation {
    /// Of a file or folder of its own.
    Data(PathBuf),
    /// Between two times, s, of the data given.
    Window(f64, f64),
}

/// A file, a folder or a window.
pub(super) fn validation(text: &str) -> Result<Validation, String> {
    let path = PathBuf::from(text);
    if path.exists() {
        return Ok(Validation::Data(path));
    }
    match window(text) {
        Ok((from, to)) => Ok(Validation::Window(from, to)),
        Err(rule) if text.contains("..") && !text.contains('/') => Err(rule),
        Err(_) => Err(format!(
            "there is no file or folder '{text}', and it is no window FROM..TO either"
        )),
    }
}

impl SignalArgs {
    /// An input and an output by their names.
    pub(super) fn named(
        [input, output]: [String; 2],
        data: DataArgs,
        grid: GridArgs,
        preparation: PreparationArgs,
    ) -> Self {
        Self {
            data,
            input,
            output,
            reference: None,
            grid,
            preparation,
        }
    }

    /// Whether no progress is to be shown.
    pub(super) fn is_quiet(&self) -> bool {
        self.data.quiet
    }

    /// The same with columns in memory in place of the data.
    pub(super) fn of_columns(mut self, columns: Columns) -> Self {
        self.data.columns = Some(columns);
        self
    }

    /// The same on a grid of that rate, Hz, where none was asked for.
    pub(super) fn at_rate(mut self, rate: f64) -> Self {
        self.grid.rate.get_or_insert(rate);
        self
    }

    /// The same without a window for validation, in the ways to read it of which the first that finds samples counts:
    /// from before it and behind it, or from one of both.
    ///
    /// # Errors
    /// A sentence, when a window to fit overlaps it.
    pub(super) fn outside(&self, (from, to): (f64, f64)) -> Result<Vec<Self>> {
        let windows = &self.grid.window;
        if let Some((a, b)) = windows.iter().find(|(a, b)| *a < to && from < *b) {
            bail!(
                "--window {a}..{b} overlaps --validation {from}..{to}: samples that were fitted validate nothing"
            );
        }
        // Samples on the window's edges are in it.
        let (before, behind) = ((f64::NEG_INFINITY, from - EDGE), (to + EDGE, f64::INFINITY));
        let ways = match (windows.is_empty(), from > 0.0) {
            (false, _) => vec![windows.clone()],
            (true, true) => vec![vec![before, behind], vec![before], vec![behind]],
            (true, false) => vec![vec![behind]],
        };
        Ok(ways
            .into_iter()
            .map(|windows| self.within(windows))
            .collect())
    }

    /// The validation data on the grid of the data that was fitted, decimated as that was.
    pub(super) fn validation(&self, given: &Validation, fitted: &Taken) -> Self {
        let other = match given {
            Validation::Window(from, to) => self.within(vec![(*from, *to)]),
            Validation::Data(path) => {
                let mut other = self.within(Vec::new());
                other.data.data = vec![path.clone()];
                other.data.columns = None;
                other
            }
        };
        let rate = 1.0 / fitted.resampled.record.sample_time;
        let averaged = other.averaged_where_decimated(fitted);
        averaged.unwrap_or(other).at_rate(rate)
    }

    /// The same with means of the outputs about each instant, if a record was decimated though no rate was asked for.
    pub(super) fn averaged_where_decimated(&self, record: &Taken) -> Option<Self> {
        let decimated = record.steps.iter().any(|it| it.name == DECIMATION);
        let linear = self.grid.rate.is_none() && self.grid.output_method == Method::Linear;
        (decimated && linear).then(|| {
            let mut averaged = self.clone();
            averaged.grid.output_method = Method::Centred;
            averaged
        })
    }

    fn within(&self, window: Vec<(f64, f64)>) -> Self {
        let mut other = self.clone();
        other.grid.window = window;
        other
    }

    /// Reads them as a record: the input, then the reference if there is one. Each window of each source is a
    /// segment, or several. So many zeros are put in front of each. If it may be decimated, it is where it is sampled far
    /// faster than it moves, unless a rate was asked for.
    ///
    /// # Errors
    /// One line: data that cannot be read, a signal that is not in it, signals that have no instant in common or are never of
    /// one time, a grid finer than the data, signals without dynamics.
    pub(super) fn record(&self, prewindow: usize, decimate: bool) -> Result<Taken> {
        let inputs: Vec<String> = std::iter::once(&self.input)
            .chain(&self.reference)
            .cloned()
            .collect();
        let outputs = [self.output.clone()];
        let mut taken: Option<Taken> = None;
        for data in self.data.sources() {
            let rate = taken
                .as_ref()
                .map(|taken| 1.0 / taken.resampled.record.sample_time);
            let source = self.data.opened(&data)?;
            let windows = self
                .grid
                .options(rate.or(source.sample_time().map(f64::recip)));
            let bar = self.data.progress_bar(source.bytes());
            let next = take(&source, &inputs, &outputs, &windows, &|bytes| {
                bar.set_position(bytes);
                stop_point();
            })?;
            bar.finish_and_clear();
            taken = Some(match taken {
                None => next,
                Some(before) => before.followed_by(next),
            });
        }
        let taken = taken.ok_or_else(|| anyhow!("no data"))?;
        let record = &taken.resampled.record;
        let unfit = (self.preparation.prefilter).and_then(|band| unreachable(record, band));
        if let Some(reason) = without_dynamics(record).or(unfit) {
            bail!(reason);
        }
        Ok(taken.prepared(&Preparation {
            decimate: decimate && self.grid.rate.is_none(),
            outliers: self.preparation.outliers,
            band: self.preparation.prefilter,
            segment: self.preparation.segment,
            trend: self.preparation.detrend,
            prewindow,
        }))
    }
}

/// How samples are put on a grid.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Grid")]
pub(super) struct GridArgs {
    /// Sampling rate of the grid [default: that of the slowest output]
    #[arg(long, value_name = "HZ", value_parser = rate, allow_hyphen_values = true)]
    rate: Option<f64>,
    /// Use only data between these times, in seconds from the first output's first sample; several windows are
    /// runs of one model
    #[arg(long, value_name = "FROM..TO", value_parser = window, allow_hyphen_values = true)]
    window: Vec<(f64, f64)>,
    /// Resampling of inputs
    #[arg(long, value_parser = choice(&Method::ALL, Method::described), default_value = "mean")]
    input_method: Method,
    /// Resampling of outputs
    #[arg(long, value_parser = choice(&Method::ALL, Method::described), default_value = "linear")]
    output_method: Method,
    /// Longest interval between two samples that is not a gap [default: five sample intervals; none for a held input]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_hyphen_values = true)]
    max_gap: Option<f64>,
}

impl GridArgs {
    /// The options they stand for, one for each window; `rate` where none was asked for.
    fn options(&self, rate: Option<f64>) -> Vec<Options> {
        let all = [(f64::NEG_INFINITY, f64::INFINITY)];
        let windows = match &self.window[..] {
            [] => &all[..],
            windows => windows,
        };
        let of = |(from, to): &(f64, f64)| Options {
            rate: self.rate.or(rate),
            window: *from..=*to,
            input_method: self.input_method,
            output_method: self.output_method,
            max_gap: self.max_gap,
        };
        windows.iter().map(of).collect()
    }
}

fn number(text: &str) -> Result<f64, String> {
    text.parse()
        .map_err(|_| format!("'{text}' is not a number"))
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = number(text)?;
    if (1e-6..=1e6).contains(&rate) {
        Ok(rate)
    } else {
        Err("expected a rate between 1e-6 and 1e6 Hz".to_owned())
    }
}

fn seconds(text: &str) -> Result<f64, String> {
    let seconds = number(text)?;
    if seconds > 0.0 && seconds <= 1e9 {
        Ok(seconds)
    } else {
        Err("expected a time between 0 and 1e9 s".to_owned())
    }
}

fn window(text: &str) -> Result<(f64, f64), String> {
    let open = (f64::NEG_INFINITY, f64::INFINITY);
    span(text, open, || {
        format!("'{text}' is not a window; write FROM..TO, as 10..60, 10.. or ..60")
    })
}

fn band(text: &str) -> Result<Band, String> {
    let rule =
        || format!("'{text}' is not a band; write LOW..HIGH in Hz, as 0.01..2, 0.01.. or ..2");
    match span(text, (0.0, f64::INFINITY), rule)? {
        (0.0, f64::INFINITY) => Err(rule()),
        (low, _) if low < 0.0 => Err(rule()),
        band => Ok(band),
    }
}

/// Two edges, those that are not written open.
fn span(text: &str, open: (f64, f64), rule: impl Fn() -> String) -> Result<(f64, f64), String> {
    let (from, to) = text.split_once("..").ok_or_else(&rule)?;
    let edge = |text: &str, open: f64| match text {
        "" => Ok(open),
        text => number(text).map_err(|_| rule()),
    };
    let (from, to) = (edge(from, open.0)?, edge(to, open.1)?);
    if from < to {
        Ok((from, to))
    } else if from > to {
        Err(format!("'{text}' is reversed; write {to}..{from}"))
    } else {
        Err(rule())
    }
}
