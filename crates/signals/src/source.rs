//! The sources of samples: a bag, whole or split, a CSV file, a PX4 log, or columns in memory.
//!
//! All stream: a sample is handed on as it is read and forgotten. What cannot be read does not
//! end the rest; it is listed in [`Reading::notes`].

use std::path::PathBuf;

use anyhow::{Result, bail};

use crate::bag_source::BagSource;
use crate::column_source::ColumnSource;
use crate::csv_source::{CsvSource, TableTime};
use crate::request::{Clock, Reading, Request, Take};
use crate::ulog_source::UlogSource;

/// Where data lies, and how its time is read.
#[derive(Clone, Debug)]
pub struct Data {
    /// A bag folder, a metadata.yaml, one or several .mcap files of a split bag, a table (.csv, .tsv, .txt or .dat), or a PX4 log (.ulg).
    pub paths: Vec<PathBuf>,
    /// The clock of a bag's stamps; `None` for the messages' own if all have one.
    pub stamp: Option<Clock>,
    /// How the time of a table is read.
    pub time: TableTime,
}

/// An open bag, table or log, or columns in memory.
#[derive(Debug)]
pub enum Source {
    /// A bag.
    Bag(Box<BagSource>),
    /// A table.
    Csv(CsvSource),
    /// A PX4 log.
    Ulog(UlogSource),
    /// Columns in memory.
    Columns(ColumnSource),
}

impl Source {
    /// Opens the data.
    ///
    /// # Errors
    /// One line: what is no bag or table, with its path.
    pub fn open(data: &Data) -> Result<Self> {
        let ends_in = |path: &PathBuf, endings: &[&str]| {
            let ending = path.extension().unwrap_or_default();
            endings.iter().any(|it| ending.eq_ignore_ascii_case(it))
        };
        let is_csv = |path: &PathBuf| ends_in(path, &["csv", "tsv", "txt", "dat"]);
        let is_ulog = |path: &PathBuf| ends_in(path, &["ulg", "ulog"]);
        match &data.paths[..] {
            [path] if is_csv(path) => {
                if data.stamp.is_some() {
                    bail!("--stamp is for bags; a table's time is its column's (--time)");
                }
                Ok(Self::Csv(CsvSource::open(path, &data.time)?))
            }
            [path] if is_ulog(path) => {
                if data.stamp.is_some() || data.time != TableTime::default() {
                    bail!(
                        "a ULog has its own stamps: neither --stamp nor --time, --time-unit and --sample-time apply"
                    )
                }
                Ok(Self::Ulog(UlogSource::open(path)?))
            }
            paths if paths.iter().any(|it| is_csv(it) || is_ulog(it)) => {
                bail!("one .csv file or log is taken at a time, and none beside a bag")
            }
            _ if data.time != TableTime::default() => {
                bail!(
                    "--time is for .csv files, as --time-unit and --sample-time are; a bag has stamps (--stamp)"
                )
            }
            paths => Ok(Self::Bag(Box::new(BagSource::open(paths, data.stamp)?))),
        }
    }

    /// Bytes to be read.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Bag(bag) => bag.bytes(),
            Self::Csv(table) => table.bytes(),
            Self::Ulog(log) => log.bytes(),
            Self::Columns(_) => 0,
        }
    }

    /// Seconds from sample to sample, where the data has no time and they were given.
    #[must_use]
    pub fn sample_time(&self) -> Option<f64> {
        match self {
            Self::Bag(_) | Self::Ulog(_) => None,
            Self::Csv(table) => table.sample_time(),
            Self::Columns(columns) => columns.sample_time(),
        }
    }

    /// Hands every sample of the signals to `take`; `progress` is called with the bytes read.
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
            Self::Ulog(log) => log.read(requests, take, progress),
            Self::Columns(columns) => columns.read(requests, take),
        }
    }
}
