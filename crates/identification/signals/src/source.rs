//! The sources of samples: a bag, whole or split, tables, a log of a vehicle, or columns in memory.
//!
//! All stream: a sample is handed on as it is read and forgotten. What cannot be read does not
//! end the rest; it is listed in [`Reading::notes`].

use planesman_text::option;
use std::path::{Path, PathBuf};

use crate::bag_source::BagSource;
use crate::column_source::ColumnSource;
use crate::csv_source::{CsvSource, TableTime};
use crate::error::{Result, SourceError};
use crate::joined_tables::JoinedTables;
use crate::log_source::{LogKind, LogSource};
use crate::request::{Clock, Reading, Request, Take};
use crate::ulog_source::UlogSource;

/// Where data lies, and how its time is read.
#[derive(Clone, Debug)]
pub struct Data {
    /// A bag folder, a metadata.yaml, one or several .mcap files of a split bag, tables (.csv, .tsv, .txt, .dat, .lvm), or
    /// a log of PX4 (.ulg), ArduPilot (.bin), MAVLink (.tlog) or MOOS (.alog).
    pub paths: Vec<PathBuf>,
    /// The clock of a bag's stamps; `None` for the messages' own if all have one.
    pub stamp: Option<Clock>,
    /// How the time of a table is read.
    pub time: TableTime,
    /// Bytes that the chunks of each file of a bag may unpack to in all; `None` without a limit.
    pub most_unpacked: Option<u64>,
}

/// The endings of tables.
const TABLES: [&str; 9] = [
    "csv", "tsv", "txt", "dat", "lvm", "log", "asc", "prn", "tab",
];

/// Whether a file is a table, by its ending.
#[must_use]
pub fn is_table(path: &Path) -> bool {
    ends_in(path, &TABLES)
}

fn ends_in(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().unwrap_or_default();
    endings.iter().any(|it| ending.eq_ignore_ascii_case(it))
}

/// A kind of file that is known and not read, by its endings.
struct Foreign {
    endings: &'static [&'static str],
    kind: &'static str,
    /// The command that converts it, FILE and NEW for the files.
    command: &'static str,
}

const FOREIGN: &[Foreign] = &[
    Foreign {
        endings: &["mat"],
        kind: "a MATLAB file",
        command: "python -c \"import scipy.io, pandas; pandas.DataFrame({k: v.ravel() for k, v in scipy.io.loadmat('FILE').items() \
                  if k[0] != '_'}).to_csv('NEW.csv', index=False)\"",
    },
    Foreign {
        endings: &["xlsx", "xls", "ods"],
        kind: "a spreadsheet",
        command: "python -c \"import pandas; pandas.read_excel('FILE').to_csv('NEW.csv', index=False)\"",
    },
    Foreign {
        endings: &["parquet"],
        kind: "a Parquet file",
        command: "python -c \"import pandas; pandas.read_parquet('FILE').to_csv('NEW.csv', index=False)\"",
    },
    Foreign {
        endings: &["feather", "arrow"],
        kind: "an Arrow file",
        command: "python -c \"import pandas; pandas.read_feather('FILE').to_csv('NEW.csv', index=False)\"",
    },
    Foreign {
        endings: &["h5", "hdf5", "hdf"],
        kind: "an HDF5 file",
        command: "python -c \"import h5py, pandas; pandas.DataFrame({k: v[()].ravel() for k, v in h5py.File('FILE').items()}).to_csv('NEW.csv', \
                  index=False)\"",
    },
    Foreign {
        endings: &["npz"],
        kind: "an archive of numpy",
        command: "python -c \"import numpy, pandas; pandas.DataFrame(dict(numpy.load('FILE'))).to_csv('NEW.csv', index=False)\"",
    },
    Foreign {
        endings: &["npy"],
        kind: "an array of numpy",
        command: "python -c \"import numpy; numpy.savetxt('NEW.csv', numpy.load('FILE'), delimiter=',')\"",
    },
    Foreign {
        endings: &["pkl", "pickle"],
        kind: "a pickle of Python",
        command: "python -c \"import pandas; pandas.read_pickle('FILE').to_csv('NEW.csv')\"",
    },
    Foreign {
        endings: &["bag"],
        kind: "a bag of ROS 1",
        command: "rosbags-convert --src FILE --dst NEW --dst-storage mcap",
    },
    Foreign {
        endings: &["active"],
        kind: "a bag of ROS 1 that was not closed",
        command: "rosbag reindex FILE && mv FILE NEW && rosbags-convert --src NEW --dst NEW.ros2 --dst-storage mcap",
    },
];

/// The kind of that ending, if it is known and not read.
fn foreign(ending: &str) -> Option<&'static Foreign> {
    let is_its = |it: &&Foreign| it.endings.iter().any(|it| it.eq_ignore_ascii_case(ending));
    FOREIGN.iter().find(is_its)
}

impl Foreign {
    /// Why the file is not read, and the command that makes of it one that is.
    fn remedy(&self, path: &Path) -> String {
        let command = self.command.replace("FILE", &path.display().to_string());
        let new = path.with_extension("");
        let command = command.replace("NEW", &new.display().to_string());
        format!(
            "{}: {}, which is not read; convert it: `{command}`",
            path.display(),
            self.kind
        )
    }
}

/// An open bag, table or log, or columns in memory.
#[derive(Debug)]
pub enum Source {
    /// A bag.
    Bag(Box<BagSource>),
    /// A table.
    Csv(CsvSource),
    /// Several tables, joined by time.
    Tables(JoinedTables),
    /// A PX4 log.
    Ulog(UlogSource),
    /// A log of ArduPilot, MAVLink or MOOS.
    Log(LogSource),
    /// Columns in memory.
    Columns(ColumnSource),
    /// Samples of some signals of another source, which have been read.
    Kept(Box<KeptSource>),
}

impl Source {
    /// Opens the data.
    ///
    /// # Errors
    /// One line: what is no bag or table, with its path.
    pub fn open(data: &Data) -> Result<Self> {
        let exists = |path: &&PathBuf| path.is_file();
        if let Some((path, kind)) = (data.paths.iter().filter(exists))
            .find_map(|path| Some((path, foreign(path.extension()?.to_str()?)?)))
        {
            return Err(SourceError::Data(kind.remedy(path)));
        }
        let is_csv = |path: &PathBuf| is_table(path);
        let is_log =
            |path: &PathBuf| ends_in(path, &["ulg", "ulog"]) || LogKind::of(path).is_some();
        match &data.paths[..] {
            paths @ [first, others @ ..] if paths.iter().all(is_csv) => {
                if data.stamp.is_some() {
                    return Err(SourceError::Request(format!(
                        "{} is for bags; a table's time is its column's ({})",
                        option("stamp"),
                        option("time")
                    )));
                }
                Ok(match others {
                    [] => Self::Csv(CsvSource::open(first, &data.time)?),
                    _ => Self::Tables(JoinedTables::open(paths, &data.time)?),
                })
            }
            [path] if is_log(path) => {
                if data.stamp.is_some() || data.time != TableTime::default() {
                    return Err(SourceError::Request(format!(
                        "a log has its own stamps: neither {} nor {}, {} and {} apply",
                        option("stamp"),
                        option("time"),
                        option("time_unit"),
                        option("sample_time")
                    )));
                }
                Ok(match LogKind::of(path) {
                    Some(kind) => Self::Log(LogSource::open(path, kind)?),
                    None => Self::Ulog(UlogSource::open(path)?),
                })
            }
            paths if paths.iter().any(|it| is_csv(it) || is_log(it)) => Err(SourceError::Request(
                "tables are joined with tables only, and a log stands alone: no bag or log is taken beside them".to_owned(),
            )),
            _ if data.time != TableTime::default() => Err(SourceError::Request(format!(
                "{} is for .csv files, as {} and {} are; a bag has stamps ({})",
                option("time"),
                option("time_unit"),
                option("sample_time"),
                option("stamp")
            ))),
            paths => Ok(Self::Bag(Box::new(BagSource::open(paths, data.stamp, data.most_unpacked)?))),
        }
    }

    /// Its files, for people.
    #[must_use]
    pub fn name(&self) -> String {
        let path = match self {
            Self::Bag(bag) => bag.bag().path(),
            Self::Csv(table) => table.path(),
            Self::Tables(tables) => {
                let paths = tables.tables().iter();
                let paths: Vec<_> = paths.map(|it| it.path().display().to_string()).collect();
                return paths.join(", ");
            }
            Self::Ulog(log) => log.path(),
            Self::Log(log) => log.path(),
            Self::Columns(_) => return "columns in memory".to_owned(),
            Self::Kept(kept) => return kept.source.name(),
        };
        path.display().to_string()
    }

    /// Bytes to be read.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Bag(bag) => bag.bytes(),
            Self::Csv(table) => table.bytes(),
            Self::Tables(tables) => tables.bytes(),
            Self::Ulog(log) => log.bytes(),
            Self::Log(log) => log.bytes(),
            Self::Columns(_) | Self::Kept(_) => 0,
        }
    }

    /// Seconds from sample to sample, where the data has no time and they were given.
    #[must_use]
    pub fn sample_time(&self) -> Option<f64> {
        match self {
            Self::Bag(_) | Self::Ulog(_) | Self::Log(_) => None,
            Self::Csv(table) => table.sample_time(),
            Self::Tables(tables) => tables.tables().iter().find_map(CsvSource::sample_time),
            Self::Columns(columns) => columns.sample_time(),
            Self::Kept(kept) => kept.source.sample_time(),
        }
    }

    /// Whether the data tells the time of its samples, or the interval between them was given.
    #[must_use]
    pub fn has_time(&self) -> bool {
        match self {
            Self::Bag(_) | Self::Ulog(_) | Self::Log(_) | Self::Columns(_) => true,
            Self::Csv(table) => table.has_time(),
            Self::Tables(tables) => tables.tables().iter().all(CsvSource::has_time),
            Self::Kept(kept) => kept.source.has_time(),
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
            Self::Tables(tables) => tables.read(requests, take, progress),
            Self::Ulog(log) => log.read(requests, take, progress),
            Self::Log(log) => log.read(requests, take, progress),
            Self::Columns(columns) => columns.read(requests, take),
            Self::Kept(kept) => kept.read(requests, take),
        }
    }
}

/// Samples of some signals of a source in memory: read once, so that records of any of them are made without reading again.
#[derive(Debug)]
pub struct KeptSource {
    pub(crate) source: Source,
    requests: Vec<Request>,
    /// Number of the signal, stamp in ns, value or NaN, in the order in which they were read.
    samples: Vec<(usize, i64, f64)>,
    reading: Reading,
}

impl KeptSource {
    /// Reads the signals, `most` samples of all together.
    ///
    /// # Errors
    /// As [`Source::read`].
    pub fn new(source: Source, requests: Vec<Request>, most: usize) -> Result<Self> {
        let mut samples = Vec::new();
        let mut take = |signal, stamp, value: Option<f64>| {
            samples.push((signal, stamp, value.unwrap_or(f64::NAN)));
            samples.len() < most
        };
        let reading = source.read(&requests, &mut take, &|_| ())?;
        Ok(Self {
            source,
            requests,
            samples,
            reading,
        })
    }

    /// Hands the samples of the signals to `take`.
    pub(crate) fn read(&self, requests: &[Request], take: &mut Take<'_>) -> Result<Reading> {
        let mut wanted = vec![None; self.requests.len()];
        for (signal, request) in requests.iter().enumerate() {
            let place = self.requests.iter().position(|it| it == request);
            let unread = || SourceError::Request(format!("'{}' was not read", request.name));
            wanted[place.ok_or_else(unread)?] = Some(signal);
        }
        for (place, stamp, value) in &self.samples {
            let value = Some(*value).filter(|it| !it.is_nan());
            if wanted[*place].is_some_and(|signal| !take(signal, *stamp, value)) {
                break;
            }
        }
        Ok(self.reading.clone())
    }
}
