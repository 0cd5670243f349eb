//! The sources of samples: a bag, whole or split, or a CSV file.
//!
//! Both stream: a sample is handed on as it is read and forgotten. What cannot be read does not
//! end the rest; it is listed in [`Reading::notes`].

use std::path::PathBuf;

use anyhow::{Result, bail};

use crate::bag_source::BagSource;
use crate::csv_source::CsvSource;
use crate::request::{Clock, Reading, Request, Take, TimeUnit};

/// Where data lies, and how its time is read.
#[derive(Clone, Debug)]
pub struct Data {
    /// A bag folder, a metadata.yaml, one or several .mcap files of a split bag, or a .csv file.
    pub paths: Vec<PathBuf>,
    /// The clock of a bag's stamps; `None` for the messages' own if all have one.
    pub stamp: Option<Clock>,
    /// A table's column with the time; `None` for the one that seems so.
    pub time: Option<String>,
    /// The unit of that column.
    pub time_unit: TimeUnit,
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
    pub fn open(data: &Data) -> Result<Self> {
        let is_csv = |path: &PathBuf| {
            let ending = path.extension().unwrap_or_default();
            ["csv", "tsv", "txt"]
                .iter()
                .any(|it| ending.eq_ignore_ascii_case(it))
        };
        match &data.paths[..] {
            [path] if is_csv(path) => {
                if data.stamp.is_some() {
                    bail!("--stamp is for bags; a table's time is its column's (--time)");
                }
                let source = CsvSource::open(path, data.time.as_deref(), data.time_unit)?;
                Ok(Self::Csv(source))
            }
            paths if paths.iter().any(is_csv) => {
                bail!("one .csv file is taken at a time, and none beside a bag")
            }
            _ if data.time.is_some() => {
                bail!("--time is for .csv files; a bag has stamps (--stamp)")
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
        }
    }
}
