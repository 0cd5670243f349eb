//! Arguments shared by several commands: data, signals, a grid.

use std::path::PathBuf;

use clap::{Arg, Args};
use planesman_console::progress::Bars;
use planesman_fit::rules::{self, EXCLUDES, NEEDS, Rule, RuleError, Span};
use planesman_fit::{DataOptions, GridOptions, PreparationOptions, SignalOptions, Sources};
use planesman_parallel::Progress;
use planesman_signals::{
    Band, Clock, Method, Outliers, SegmentChoice, TableTime, TimeUnit, Trend, Unwrap,
};
use planesman_units::Dimension;

use crate::arguments::{choice, quantity};

/// An argument with the others that the library's rules let it be given with.
pub(crate) fn together(argument: Arg) -> Arg {
    let id = argument.get_id().clone();
    let of = |(option, _): &(&str, &str)| id == *option;
    let needs = NEEDS.into_iter().filter(of);
    let argument = needs.fold(argument, |it, (_, needed)| it.requires(needed));
    let excludes = EXCLUDES.into_iter().filter(of);
    excludes.fold(argument, |it, (_, other)| it.conflicts_with(other))
}

/// The data that a command is given.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Data")]
pub(crate) struct DataArgs {
    /// A bag folder, a metadata.yaml, one or several .mcap or .db3 files of a split bag, one or several tables (.csv), or a
    /// log of PX4 (.ulg), ArduPilot (.bin), MAVLink (.tlog) or MOOS (.alog)
    #[arg(required = true, value_name = "DATA", help_heading = None::<&str>)]
    pub(crate) data: Vec<PathBuf>,
    /// Time stamps: of the message headers, or of the recorder (log) [default: header if all messages have one]
    #[arg(long, value_parser = choice(&Clock::ALL, Clock::described))]
    stamp: Option<Clock>,
    /// CSV column of time [default: time, t, stamp or timestamp, else a first column that rises from row to row]
    #[arg(long, value_name = "COLUMN")]
    time: Option<String>,
    /// Unit of the time column of a CSV file [default: the one that its name ends in, as t_ms; else s]
    #[arg(long, value_parser = choice(&TimeUnit::ALL, TimeUnit::described))]
    time_unit: Option<TimeUnit>,
    /// Interval between two rows of a CSV file without a time (s, or with its unit: 100ms)
    #[arg(long, value_name = "TIME", value_parser = quantity(Dimension::Time, rules::SAMPLE_TIME.least, rules::SAMPLE_TIME.most))]
    sample_time: Option<f64>,
    /// Read of each file of a bag at most so many MB once it is unpacked: a small file can unpack to thousands of times its size
    #[arg(long, value_name = "MB", value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    most_unpacked: Option<u32>,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
}

impl DataArgs {
    /// Who is told of progress: standard error, unless it is not wanted.
    pub(crate) fn progress(&self) -> Box<dyn Progress> {
        match self.quiet {
            true => Box::new(()),
            false => Box::new(Bars::default()),
        }
    }

    /// The options they stand for, of these paths.
    pub(crate) fn options(&self, paths: Vec<PathBuf>) -> DataOptions {
        DataOptions {
            sources: Sources::Files(paths),
            stamp: self.stamp,
            time: TableTime {
                column: self.time.clone(),
                unit: self.time_unit,
                sample_time: self.sample_time,
            },
            most_unpacked: self.most_unpacked.map(|it| u64::from(it) * 1_000_000),
        }
    }
}

impl From<&DataArgs> for DataOptions {
    fn from(args: &DataArgs) -> Self {
        args.options(args.data.clone())
    }
}

/// Signals of some data, on one grid.
#[derive(Clone, Debug, Args)]
pub(crate) struct SignalArgs {
    #[command(flatten)]
    pub(crate) data: DataArgs,
    /// Input signal: TOPIC:FIELD, or a CSV column; one that was not recorded in words, 'VALUE[UNIT] from TIME': '12V from 0.1s',
    /// '0 to 12V at 0.1s', '5 from 1s, 0 from 4s'. Given again for each further input: one model has them all
    #[arg(
        long,
        short,
        required = true,
        value_name = "SIGNAL",
        allow_hyphen_values = true,
        help_heading = "Signals"
    )]
    pub(crate) input: Vec<String>,
    /// Output signal; given again for each further output
    #[arg(
        long,
        short,
        required = true,
        value_name = "SIGNAL",
        help_heading = "Signals"
    )]
    pub(crate) output: Vec<String>,
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
pub(crate) struct PreparationArgs {
    /// Outliers: samples far from the median of those around them
    #[arg(long, value_parser = choice(&Outliers::ALL, Outliers::described), default_value = "outputs")]
    outliers: Outliers,
    /// Band of frequencies that is used, of every signal: LOW..HIGH, or LOW.. against drift, or ..HIGH against noise (Hz)
    /// [default: all]
    #[arg(long, value_name = "LOW..HIGH", value_parser = span(rules::BAND))]
    prefilter: Option<Band>,
    /// Which data is used
    #[arg(long, value_parser = choice(&SegmentChoice::ALL, SegmentChoice::described), default_value = "all")]
    segment: SegmentChoice,
    /// What is subtracted from each signal
    #[arg(long, value_parser = choice(&Trend::ALL, Trend::described), default_value = "none")]
    detrend: Trend,
}

impl From<&SignalArgs> for SignalOptions {
    fn from(args: &SignalArgs) -> Self {
        let first = |names: &[String]| names.first().cloned().unwrap_or_default();
        Self {
            data: (&args.data).into(),
            input: first(&args.input),
            output: first(&args.output),
            other_inputs: args.input.iter().skip(1).cloned().collect(),
            other_outputs: args.output.iter().skip(1).cloned().collect(),
            reference: args.reference.clone(),
            grid: (&args.grid).into(),
            preparation: (&args.preparation).into(),
        }
    }
}

impl From<&PreparationArgs> for PreparationOptions {
    fn from(args: &PreparationArgs) -> Self {
        Self {
            outliers: args.outliers,
            prefilter: args.prefilter,
            segment: args.segment,
            detrend: args.detrend,
        }
    }
}

/// How samples are put on a grid.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Grid")]
pub(crate) struct GridArgs {
    /// Sampling rate of the grid [default: that of the slowest output]
    #[arg(long, value_name = "HZ", value_parser = by(rules::RATE))]
    rate: Option<f64>,
    /// Use only data between these times, in seconds from the first output's first sample; several windows are
    /// runs of one model
    #[arg(long, value_name = "FROM..TO", value_parser = span(rules::WINDOW))]
    window: Vec<(f64, f64)>,
    /// Resampling of inputs
    #[arg(long, value_parser = choice(&Method::ALL, Method::described), default_value = "mean")]
    input_method: Method,
    /// Resampling of outputs
    #[arg(long, value_parser = choice(&Method::ALL, Method::described), default_value = "linear")]
    output_method: Method,
    /// Longest interval between two samples that is not a gap [default: five sample intervals; none for a held input]
    #[arg(long, value_name = "SECONDS", value_parser = by(rules::MAX_GAP))]
    max_gap: Option<f64>,
    /// Angles and counters that wrap: unwrapped where the jump is unmistakable, with this period, or not
    #[arg(long, value_name = "360|2pi|65536|no", value_parser = rules::unwrap, default_value = "automatic", allow_hyphen_values = true)]
    unwrap: Unwrap,
}

impl From<&GridArgs> for GridOptions {
    fn from(args: &GridArgs) -> Self {
        Self {
            rate: args.rate,
            window: args.window.clone(),
            input_method: args.input_method,
            output_method: args.output_method,
            max_gap: args.max_gap,
            unwrap: args.unwrap,
        }
    }
}

/// A parser of numbers that a rule lets.
pub(crate) fn by(rule: Rule) -> impl Fn(&str) -> Result<f64, RuleError> + Clone {
    move |text| rule.parse(text)
}

/// A parser of pairs of edges that a rule lets.
pub(crate) fn span(rule: Span) -> impl Fn(&str) -> Result<(f64, f64), RuleError> + Clone {
    move |text| rule.parse(text)
}
