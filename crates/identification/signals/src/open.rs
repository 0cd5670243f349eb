//! Opens files as a source of samples: a bag, whole or split, tables, or a log of a vehicle.

use planesman_bag::is_bag_file;
use planesman_text::option;
use std::path::{Path, PathBuf};

use crate::bag_source::BagSource;
use crate::csv_source::{CsvSource, TableTime};
use crate::error::{Result, SourceError};
use crate::joined_tables::JoinedTables;
use crate::log_source::{LogKind, LogSource, ends_in};
use crate::request::Clock;
use crate::source::Source;

/// Where data lies, and how its time is read.
#[derive(Clone, Debug)]
pub struct Data {
    /// A bag folder, a metadata.yaml, one or several .mcap or .db3 files of a split bag, tables ([`TABLES`]), or a log ([`LogKind::all`]).
    pub paths: Vec<PathBuf>,
    /// The clock of a bag's stamps; `None` for the messages' own if all have one.
    pub stamp: Option<Clock>,
    /// How the time of a table is read.
    pub time: TableTime,
    /// Bytes that the chunks of each file of a bag may unpack to in all; `None` without a limit.
    pub most_unpacked: Option<u64>,
}

/// The endings of tables.
pub const TABLES: [&str; 9] = [
    "csv", "tsv", "txt", "dat", "lvm", "log", "asc", "prn", "tab",
];

/// Whether a file is a table, by its ending.
#[must_use]
pub fn is_table(path: &Path) -> bool {
    ends_in(path, &TABLES)
}

/// Whether a file is a table or a log, by its ending.
#[must_use]
pub fn is_record(path: &Path) -> bool {
    is_table(path) || LogKind::of(path).is_some()
}

/// Whether a file of a folder is data by itself, by its ending: a bag's file, a table or a log. A packed file beside the same unpacked is
/// no other data.
#[must_use]
pub fn is_data(path: &Path) -> bool {
    let unpacked = path.with_extension("");
    let is_again = is_bag_file(&unpacked) && unpacked.is_file();
    (is_bag_file(path) && !is_again) || is_record(path)
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

/// The kind of a file, by its ending, if it is known and not read.
fn foreign(path: &Path) -> Option<&'static Foreign> {
    FOREIGN.iter().find(|it| ends_in(path, it.endings))
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

/// Opens the data.
///
/// # Errors
/// One line: what is no bag or table, with its path.
pub fn open(data: &Data) -> Result<Box<dyn Source>> {
    let exists = |path: &&PathBuf| path.is_file();
    if let Some((path, kind)) =
        (data.paths.iter().filter(exists)).find_map(|path| Some((path, foreign(path)?)))
    {
        return Err(SourceError::Data(kind.remedy(path)));
    }
    let is_csv = |path: &PathBuf| is_table(path);
    let log = data.paths.iter().find_map(|path| LogKind::of(path));
    match (&data.paths[..], log) {
        (paths @ [first, others @ ..], _) if paths.iter().all(is_csv) => {
            if data.stamp.is_some() {
                return Err(SourceError::Request(format!(
                    "{} is for bags; a table's time is its column's ({})",
                    option("stamp"),
                    option("time")
                )));
            }
            Ok(match others {
                [] => Box::new(CsvSource::open(first, &data.time)?),
                _ => Box::new(JoinedTables::open(paths, &data.time)?),
            })
        }
        ([path], Some(kind)) => {
            if data.stamp.is_some() || data.time != TableTime::default() {
                return Err(SourceError::Request(format!(
                    "a log has its own stamps: neither {} nor {}, {} and {} apply",
                    option("stamp"),
                    option("time"),
                    option("time_unit"),
                    option("sample_time")
                )));
            }
            Ok(Box::new(LogSource::open(path, kind)?))
        }
        (paths, log) if log.is_some() || paths.iter().any(is_csv) => Err(SourceError::Request(
            "tables are joined with tables only, and a log stands alone: no bag or log is taken beside them".to_owned(),
        )),
        _ if data.time != TableTime::default() => Err(SourceError::Request(format!(
            "{} is for .csv files, as {} and {} are; a bag has stamps ({})",
            option("time"),
            option("time_unit"),
            option("sample_time"),
            option("stamp")
        ))),
        (paths, _) => Ok(Box::new(BagSource::open(paths, data.stamp, data.most_unpacked)?)),
    }
}
