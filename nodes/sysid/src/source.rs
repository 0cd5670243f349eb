//! Where samples come from: a bag, whole or split, or a table in CSV.
//!
//! Both stream: a sample is handed on as it is read and forgotten. What cannot be read does not
//! end the rest; it is told in [`Reading::notes`].

use std::io::IsTerminal;
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::bag_source::BagSource;
use crate::csv_source::CsvSource;

/// Which stamps are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Clock {
    /// That of the message, in its header.
    Header,
    /// When the recorder received it.
    Log,
}

/// What a signal is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It drives: a list is its course over the coming interval, and gives its mean.
    Input,
    /// It responds: a list gives its first element.
    Output,
}

/// One signal, as asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// `TOPIC:FIELD` in a bag, a column's name in a table.
    pub name: String,
    /// What it is for.
    pub role: Role,
}

/// What came of reading.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Reading {
    /// Which stamps were taken, in words.
    pub stamps: String,
    /// What could not be read, and why.
    pub notes: Vec<String>,
}

/// Takes samples: the signal's number, its stamp in ns, its value if it has one. Returns whether more are wanted.
pub type Take<'a> = dyn FnMut(usize, i64, Option<f64>) -> bool + 'a;

/// The data that a command is given.
#[derive(Clone, Debug, Args)]
pub struct DataArgs {
    /// A bag folder, a metadata.yaml, one or several .mcap files of a split bag, or a .csv file
    #[arg(required = true, value_name = "DATA")]
    pub data: Vec<PathBuf>,
    /// Whose stamps: the messages' own, or the recorder's [default: header if all messages have one]
    #[arg(long, value_enum)]
    pub stamp: Option<Clock>,
    /// The CSV column with the time [default: time, t, stamp or timestamp, else the first]
    #[arg(long, value_name = "COLUMN")]
    pub time: Option<String>,
    /// What the CSV column with the time counts
    #[arg(long, value_enum, default_value = "s")]
    pub time_unit: TimeUnit,
    /// Show no progress
    #[arg(long)]
    pub quiet: bool,
}

/// What a CSV file's time counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TimeUnit {
    /// Seconds.
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
    /// Nanoseconds.
    Ns,
}

impl TimeUnit {
    /// Decimal places from this unit to nanoseconds.
    #[must_use]
    pub fn places(self) -> u32 {
        match self {
            Self::S => 9,
            Self::Ms => 6,
            Self::Us => 3,
            Self::Ns => 0,
        }
    }
}

/// An open bag or table.
#[derive(Debug)]
pub enum Source {
    /// A bag.
    Bag(Box<BagSource>),
    /// A table.
    Csv(CsvSource),
}

impl Source {
    /// Opens the data.
    ///
    /// # Errors
    /// One line: what is no bag or table, with its path.
    pub fn open(args: &DataArgs) -> Result<Self> {
        let is_csv = |path: &PathBuf| {
            let ending = path.extension().unwrap_or_default();
            ["csv", "tsv", "txt"]
                .iter()
                .any(|it| ending.eq_ignore_ascii_case(it))
        };
        match &args.data[..] {
            [path] if is_csv(path) => {
                if args.stamp.is_some() {
                    bail!("--stamp is for bags; a table's time is its column's (--time)");
                }
                let source = CsvSource::open(path, args.time.as_deref(), args.time_unit)?;
                Ok(Self::Csv(source))
            }
            paths if paths.iter().any(is_csv) => {
                bail!("one .csv file is taken at a time, and none beside a bag")
            }
            _ if args.time.is_some() => {
                bail!("--time is for .csv files; a bag has stamps (--stamp)")
            }
            paths => Ok(Self::Bag(Box::new(BagSource::open(paths, args.stamp)?))),
        }
    }

    /// Bytes to be read.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Bag(bag) => bag.bytes(),
            Self::Csv(table) => table.bytes(),
        }
    }

    /// Hands every sample of the signals to `take`; `progress` hears of the bytes read.
    ///
    /// # Errors
    /// One line: a signal that is not there, or data of which nothing can be read.
    pub fn read(
        &self,
        requests: &[Request],
        take: &mut Take<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<Reading> {
        match self {
            Self::Bag(bag) => bag.read(requests, take, progress),
            Self::Csv(table) => table.read(requests, take, progress),
        }
    }
}

/// A bar on the terminal, if there is one and it is wanted.
#[must_use]
pub fn progress_bar(bytes: u64, args: &DataArgs) -> ProgressBar {
    if args.quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style = "{bar:40} {bytes}/{total_bytes} {bytes_per_sec} {eta}";
    match ProgressStyle::with_template(style) {
        Ok(style) => ProgressBar::new(bytes).with_style(style),
        Err(_) => ProgressBar::new(bytes),
    }
}
