//! Where the data lies: files that are opened, or columns in memory.

use std::path::PathBuf;

use planesman_bag::{is_bag_file, sorted_into_bags};
use planesman_parallel::{Progress, stop_point};
use planesman_signals::{Clock, ColumnSource, Data, Source, TableTime, is_table};

use crate::error::FitError;
use crate::rules::{SAMPLE_TIME, number, together};

/// Columns by name, all of one length; NaN is a sample that is not there.
pub type Columns = Vec<(String, Vec<f64>)>;

/// What is read.
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

/// What is read, and how its time is.
#[derive(Clone, Debug, Default)]
pub struct DataOptions {
    /// The data.
    pub sources: Sources,
    /// The clock of a bag's stamps; `None` for the messages' own if all have one.
    pub stamp: Option<Clock>,
    /// How the time of a table or of columns is read.
    pub time: TableTime,
    /// Bytes that the chunks of each file of a bag may unpack to in all; `None` without a limit.
    pub most_unpacked: Option<u64>,
}

/// The result of `read`, which is handed what it tells of the bytes that it has read of so many.
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
    /// These files and folders.
    pub fn files<P: Into<PathBuf>>(paths: impl IntoIterator<Item = P>) -> Self {
        Self {
            sources: Sources::Files(paths.into_iter().map(Into::into).collect()),
            ..Self::default()
        }
    }

    /// Columns in memory.
    #[must_use]
    pub fn columns(columns: Columns) -> Self {
        Self {
            sources: Sources::Columns(columns),
            ..Self::default()
        }
    }

    /// All of the data as one source.
    pub(crate) fn open(&self) -> Result<Source, FitError> {
        self.opened(match &self.sources {
            Sources::Files(paths) => paths.clone(),
            Sources::Columns(_) => Vec::new(),
        })
    }

    /// One by one: the parts of a split bag belong together, and tables of which each has some of the signals; every other path is
    /// a source of its own.
    pub(crate) fn each(&self, signals: &[String]) -> Result<Vec<Source>, FitError> {
        let Sources::Files(paths) = &self.sources else {
            return Ok(vec![self.opened(Vec::new())?]);
        };
        if let [_, _, ..] = &paths[..]
            && paths.iter().all(|path| is_table(path))
            && let Source::Tables(tables) = self.opened(paths.clone())?
        {
            return Ok(match tables.are_alike(signals) {
                true => tables.apart().into_iter().map(Source::Csv).collect(),
                false => vec![Source::Tables(tables)],
            });
        }
        let (parts, others): (Vec<PathBuf>, Vec<PathBuf>) =
            paths.iter().cloned().partition(|path| is_bag_file(path));
        let mut groups = sorted_into_bags(&parts);
        groups.extend(others.into_iter().map(|path| vec![path]));
        groups.into_iter().map(|paths| self.opened(paths)).collect()
    }

    fn opened(&self, paths: Vec<PathBuf>) -> Result<Source, FitError> {
        let time = &self.time;
        number("sample_time", time.sample_time, &SAMPLE_TIME)?;
        together(|option| match option {
            "time" => time.column.is_some(),
            "time_unit" => time.unit.is_some(),
            "sample_time" => time.sample_time.is_some(),
            _ => false,
        })?;
        let opened = match &self.sources {
            Sources::Columns(columns) => {
                ColumnSource::new(columns.clone(), time).map(Source::Columns)
            }
            Sources::Files(_) if paths.iter().all(|it| it.as_os_str().is_empty()) => {
                return Err(FitError::NoData);
            }
            Sources::Files(_) => Source::open(&Data {
                paths,
                stamp: self.stamp,
                time: time.clone(),
                most_unpacked: self.most_unpacked,
            }),
        };
        opened.map_err(FitError::data)
    }
}
