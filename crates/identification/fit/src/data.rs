//! The data source: files to open, or columns in memory.

use std::path::PathBuf;

use planesman_bag::{is_bag_file, sorted_into_bags};
use planesman_parallel::{Progress, stop_point};
use planesman_signals::{Clock, ColumnSource, Data, Source, TableTime, TimeUnit, is_table, open};
use planesman_units::Dimension;

use crate::declaration::{OptionGroup, Range, options};
use crate::error::FitError;

/// Columns by name, all of the same length; NaN is a missing sample.
pub type Columns = Vec<(String, Vec<f64>)>;

/// The data source.
#[derive(Clone, Debug)]
pub enum Sources {
    /// Bag folders, `metadata.yaml` files, `.mcap` and `.db3` files of a split bag, tables, logs.
    Files(Vec<PathBuf>),
    /// Columns in memory.
    Columns(Columns),
}

impl Default for Sources {
    fn default() -> Self {
        Self::Files(Vec::new())
    }
}

options! {
    /// The data source, and how its time stamps are read.
    #[derive(Clone, Debug)]
    pub struct DataOptions in "Data" {
        /// The data.
        sources: Sources;
        /// Time stamps: from the message headers, or from the recorder (log) [default: header if all messages have one]
        stamp: Option<Clock> = None;
        /// CSV column of time [default: time, t, stamp or timestamp, else a first column that increases from row to row]
        time: Option<String> = None, value: "COLUMN", excludes: Some("sample_time");
        /// Unit of the time column of a CSV file [default: the unit at the end of its name, such as t_ms; else s]
        time_unit: Option<TimeUnit> = None, excludes: Some("sample_time");
        /// Interval between two rows of a CSV file without a time (s, or with its unit: 100ms)
        sample_time: Option<f64> = None, value: "TIME", range: Range::Quantity(Dimension::Time, 1e-6, 1e6);
        /// Read at most this many MB (decompressed) of each file of a bag: a small file can unpack to thousands of times its size
        most_unpacked: Option<usize> = None, value: "MB", range: Range::Count(1..=1_000_000_000);
    }
}

/// Each front end takes the data as an argument.
impl OptionGroup for Sources {}

/// Runs `read` with a callback that reports bytes read and bytes in total.
pub(crate) fn reading<R>(
    of: u64,
    progress: &dyn Progress,
    read: impl FnOnce(&dyn Fn(u64)) -> R,
) -> R {
    progress.read(0, of);
    let result = read(&|bytes| {
        progress.read(bytes, of);
        stop_point();
    });
    progress.end();
    result
}

impl DataOptions {
    /// Data from these files and folders.
    pub fn files<P: Into<PathBuf>>(paths: impl IntoIterator<Item = P>) -> Self {
        Self {
            sources: Sources::Files(paths.into_iter().map(Into::into).collect()),
            ..Self::default()
        }
    }

    /// Data from columns in memory.
    #[must_use]
    pub fn columns(columns: Columns) -> Self {
        Self {
            sources: Sources::Columns(columns),
            ..Self::default()
        }
    }

    /// Replaces the files and folders; the other options are kept.
    #[must_use]
    pub fn for_files(&self, paths: Vec<PathBuf>) -> Self {
        Self {
            sources: Sources::Files(paths),
            time: self.time.clone(),
            ..*self
        }
    }

    /// All data as one source.
    pub(crate) fn open(&self) -> Result<Box<dyn Source>, FitError> {
        self.opened(match &self.sources {
            Sources::Files(paths) => paths.clone(),
            Sources::Columns(_) => Vec::new(),
        })
    }

    /// Splits the data into sources. The parts of a split bag are one source, and so are tables that have different signals; every other
    /// path is a separate source.
    pub(crate) fn each(&self, signals: &[String]) -> Result<Vec<Box<dyn Source>>, FitError> {
        let paths = match &self.sources {
            Sources::Files(paths) if !paths.iter().all(|path| is_table(path)) => paths,
            _ => {
                let source = self.open()?;
                let experiments = source.experiments(signals);
                return Ok(match experiments.is_empty() {
                    true => vec![source],
                    false => experiments,
                });
            }
        };
        let (parts, others): (Vec<PathBuf>, Vec<PathBuf>) =
            paths.iter().cloned().partition(|path| is_bag_file(path));
        let mut groups = sorted_into_bags(&parts);
        groups.extend(others.into_iter().map(|path| vec![path]));
        groups.into_iter().map(|paths| self.opened(paths)).collect()
    }

    fn opened(&self, paths: Vec<PathBuf>) -> Result<Box<dyn Source>, FitError> {
        self.check_values()?;
        let time = TableTime {
            column: self.time.clone(),
            unit: self.time_unit,
            sample_time: self.sample_time,
        };
        let opened = match &self.sources {
            Sources::Columns(columns) => {
                let source = ColumnSource::new(columns.clone(), &time);
                source.map(|it| Box::new(it) as Box<dyn Source>)
            }
            Sources::Files(_) if paths.iter().all(|it| it.as_os_str().is_empty()) => {
                return Err(FitError::NoData);
            }
            Sources::Files(_) => open(&Data {
                paths,
                stamp: self.stamp,
                time,
                most_unpacked: self.most_unpacked.map(|it| it as u64 * 1_000_000),
            }),
        };
        opened.map_err(FitError::data)
    }
}
