//! Opens files as a source of samples: a bag, whole or split, tables, or a log of a vehicle.

use planesman_bag::{ReadError, is_bag_file};
use planesman_text::option;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use crate::bag_source::BagSource;
use crate::csv_source::{CsvSource, TableTime};
use crate::error::{Result, SourceError};
use crate::joined_tables::JoinedTables;
use crate::log_source::{LogKind, LogSource, ends_in};
use crate::request::Clock;
use crate::source::Source;

/// The location of data, and how its time is read.
#[derive(Clone, Debug)]
pub struct Data {
    /// A bag folder, a metadata.yaml, one or several .mcap or .db3 files of a split bag, tables ([`TABLES`]), or a log ([`LogKind::all`]).
    pub paths: Vec<PathBuf>,
    /// The clock of a bag's stamps; `None` for the messages' own if all have one.
    pub stamp: Option<Clock>,
    /// Time of the rows of a table.
    pub time: TableTime,
    /// The maximum number of bytes to which the chunks of each file of a bag may unpack; `None` without a limit.
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

/// Whether a file in a folder is data by itself, by its ending: a bag's file, a table or a log. A compressed copy next to its uncompressed file does
/// not count.
#[must_use]
pub fn is_data(path: &Path) -> bool {
    let unpacked = path.with_extension("");
    let is_again = is_bag_file(&unpacked) && unpacked.is_file();
    (is_bag_file(path) && !is_again) || is_record(path)
}

/// A known kind of file that is not read: its endings, its first bytes, its name, and a command or an instruction that converts FILE to
/// NEW.
type Foreign = (
    &'static [&'static str],
    &'static [&'static [u8]],
    &'static str,
    Remedy,
);

#[derive(Clone, Copy)]
enum Remedy {
    Command(&'static str),
    Words(&'static str),
}
use Remedy::{Command, Words};

const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
const OF_HDF5: Remedy = Command(
    r#"python -c "import h5py, pandas; pandas.DataFrame({k: v[()].ravel() for k, v in h5py.File('FILE').items()}).to_csv('NEW.csv', index=False)""#,
);

/// Reads the frames of any log with the names of a DBC file.
const FRAMES: Remedy = Command(
    r#"python -c "import can, cantools, pandas; d = cantools.database.load_file('SIGNALS.dbc'); ids = {m.frame_id for m in d.messages}; pandas.DataFrame({'time': m.timestamp, **d.decode_message(m.arbitration_id, m.data, decode_choices=False)} for m in can.LogReader('FILE') if m.arbitration_id in ids).to_csv('NEW.csv', index=False)""#,
);

/// The first two are also recognised by their text.
#[rustfmt::skip]
const FOREIGN: [Foreign; 23] = [
    (&["blf", "trc"], &[b"LOGG", b";$FILEVERSION"], "a log of CAN frames, which contain undecoded bytes and no signals", FRAMES),
    (&[], &[], "the output of `ros2 topic echo`", Words("record a bag, `ros2 bag record TOPIC`, or print a table, `ros2 topic echo --csv TOPIC > NEW.csv`")),
    (&["mat"], &[b"MATLAB 5.0"], "a MATLAB file", Command(r#"python -c "import scipy.io, pandas; pandas.DataFrame({k: v.ravel() for k, v in scipy.io.loadmat('FILE').items() if k[0] != '_'}).to_csv('NEW.csv', index=False)""#)),
    (&["mat"], &[b"MATLAB 7.3"], "a MATLAB file of version 7.3", OF_HDF5),
    (&["xlsx", "xls", "ods"], &[], "a spreadsheet", Command(r#"python -c "import pandas; pandas.read_excel('FILE').to_csv('NEW.csv', index=False)""#)),
    (&["parquet"], &[b"PAR1"], "a Parquet file", Command(r#"python -c "import pandas; pandas.read_parquet('FILE').to_csv('NEW.csv', index=False)""#)),
    (&["feather", "arrow"], &[b"ARROW1"], "an Arrow file", Command(r#"python -c "import pandas; pandas.read_feather('FILE').to_csv('NEW.csv', index=False)""#)),
    (&["nc", "nc4", "cdf"], &[b"CDF\x01", b"CDF\x02", b"CDF\x05", HDF5], "a netCDF file", Command(r#"python -c "import xarray; xarray.open_dataset('FILE').to_dataframe().to_csv('NEW.csv')""#)),
    (&["h5", "hdf5", "hdf"], &[HDF5], "an HDF5 file", OF_HDF5),
    (&["npz"], &[], "an archive of numpy", Command(r#"python -c "import numpy, pandas; pandas.DataFrame(dict(numpy.load('FILE'))).to_csv('NEW.csv', index=False)""#)),
    (&["npy"], &[b"\x93NUMPY"], "an array of numpy", Command(r#"python -c "import numpy; numpy.savetxt('NEW.csv', numpy.load('FILE'), delimiter=',')""#)),
    (&["pkl", "pickle"], &[], "a pickle of Python", Command(r#"python -c "import pandas; pandas.read_pickle('FILE').to_csv('NEW.csv')""#)),
    (&["jsonl", "ndjson"], &[], "JSON, an object a line", Command(r#"python -c "import json, pandas; pandas.json_normalize([json.loads(line) for line in open('FILE')]).to_csv('NEW.csv', index=False)""#)),
    (&["json"], &[], "JSON", Command(r#"python -c "import json, pandas; pandas.json_normalize(json.load(open('FILE'))).to_csv('NEW.csv', index=False)""#)),
    (&["tdms"], &[b"TDSm"], "a TDMS file of LabVIEW", Command(r#"python -c "import nptdms; nptdms.TdmsFile.read('FILE').as_dataframe(time_index=True).to_csv('NEW.csv', index_label='time')""#)),
    (&["mf4", "mdf"], &[b"MDF     ", b"UnFinMF "], "an MDF file", Command(r#"python -c "import asammdf; asammdf.MDF('FILE').to_dataframe().to_csv('NEW.csv', index_label='time')""#)),
    (&["rrd"], &[b"RRF"], "a recording of Rerun", Command(r#"python -c "import os, rerun; server = rerun.server.Server(datasets={'d': [os.path.abspath('FILE')]}); client = server.client(); data = client.get_dataset('d'); data.reader(index='log_time').to_pandas().map(lambda v: v[0] if hasattr(v, 'ndim') and len(v) else v).to_csv('NEW.csv', index=False)""#)),
    (&["bbl", "bfl"], &[b"H Product:Blackbox"], "a log of Betaflight's or INAV's blackbox", Command("blackbox_decode FILE")),
    (&["wpilog", "rlog", "revlog", "dslog", "hoot"], &[b"WPILOG"], "a log of an FRC robot", Words("open it in AdvantageScope, and save it with File > Export Data... as CSV (List)")),
    (&["bag"], &[b"#ROSBAG V"], "a bag of ROS 1", Command("rosbags-convert --src FILE --dst NEW --dst-storage mcap")),
    (&["active"], &[], "a bag of ROS 1 that was not closed", Command("rosbag reindex FILE && mv FILE NEW && rosbags-convert --src NEW --dst NEW.ros2 --dst-storage mcap")),
    (&["gz"], &[b"\x1f\x8b"], "packed", Command("gunzip -k FILE")),
    (&["zip"], &[b"PK\x03\x04"], "packed", Command("unzip FILE")),
];

/// Number of bytes by which a file's kind is recognised.
const BEGINNING: u64 = 4096;
/// Letters identify a kind only if there is a control character among this many bytes.
const LETTERS: usize = 6;
const TEXT: usize = 64;

/// The share of lines that are a key with its value in printed messages.
const KEYS: f64 = 0.6;

/// The kind of a file, if it is known but not read: by its text, its first bytes or its ending.
fn foreign(path: &Path) -> Option<&'static Foreign> {
    let mut bytes = Vec::new();
    // A file that cannot be read is refused when it is opened.
    let _ = std::fs::File::open(path)
        .ok()?
        .take(BEGINNING)
        .read_to_end(&mut bytes);
    let text = String::from_utf8_lossy(&bytes);
    // A few letters may begin a table's first name too.
    let is_binary = bytes.iter().take(TEXT).any(|it| *it < b'\t');
    let tells = |magic: &&[u8]| magic.len() > LETTERS || is_binary || !magic.is_ascii();
    let begins = |it: &&Foreign| {
        it.1.iter()
            .any(|magic| bytes.starts_with(magic) && tells(magic))
    };
    let is_called = |it: &&Foreign| ends_in(path, it.0);
    let is_both = |it: &&Foreign| is_called(it) && (it.1.is_empty() || begins(it));
    let by_text = FOREIGN.iter().zip([are_frames(&text), are_messages(&text)]);
    let by_text = by_text.filter(|it| it.1).map(|it| it.0).next();
    let found = by_text.or_else(|| FOREIGN.iter().find(is_both));
    found
        .or_else(|| FOREIGN.iter().find(begins))
        .or_else(|| FOREIGN.iter().find(is_called))
}

/// Whether the text contains CAN frames: with a heading that names the base of their numbers (Vector's tools), or in the form of candump,
/// `(1436509052.249713) can0 044#2A36`.
fn are_frames(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim_start);
    let is_base = |line: &str| {
        let words: Vec<String> = line.split_whitespace().map(str::to_lowercase).collect();
        matches!(&words[..], [base, of, times, ..] if base == "base" && (of == "hex" || of == "dec") && times == "timestamps")
    };
    let is_frame = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        matches!(words[..], [time, _, frame, ..] if time.starts_with('(') && time.ends_with(')') && frame.contains('#'))
    };
    lines.clone().take(10).any(is_base) || lines.next().is_some_and(is_frame)
}

/// Whether the text contains messages in YAML, separated by `---`.
fn are_messages(text: &str) -> bool {
    let lines = || {
        text.lines()
            .map(str::trim)
            .filter(|it| !it.is_empty() && *it != "---")
    };
    let is_key = |line: &&str| {
        let key = line.trim_start_matches("- ").split_once(':');
        key.is_some_and(|(key, value)| {
            key.bytes()
                .all(|it| it.is_ascii_alphanumeric() || it == b'_')
                && (value.is_empty() || value.starts_with(' '))
                && !value.contains(": ")
        })
    };
    let keys = lines().filter(is_key).count();
    text.lines().any(|it| it == "---")
        && keys as f64 > KEYS * lines().count() as f64
        && !text.starts_with("rosbag2_bagfile_information")
}

/// The reason why a file of that kind is not read, with a way to convert it.
fn refusal(kind: &Foreign, path: &Path) -> String {
    let (file, new) = (
        path.display().to_string(),
        path.with_extension("").display().to_string(),
    );
    let filled = |text: &str| text.replace("FILE", &file).replace("NEW", &new);
    let remedy = match kind.3 {
        Command(command) => format!("convert it: `{}`", filled(command)),
        Words(words) => filled(words),
    };
    format!("{file}: {}, which is not read; {remedy}", kind.2)
}

/// Opens the data.
///
/// # Errors
/// One line with the path, if it is neither a bag nor a table or log.
pub fn open(data: &Data) -> Result<Box<dyn Source>> {
    let exists = |path: &&PathBuf| path.is_file();
    if let Some((path, kind)) =
        (data.paths.iter().filter(exists)).find_map(|path| Some((path, foreign(path)?)))
    {
        return Err(SourceError::Data(refusal(kind, path)));
    }
    let is_csv = |path: &PathBuf| is_table(path);
    let log = data.paths.iter().find_map(|path| LogKind::of(path));
    match (&data.paths[..], log) {
        (paths @ [first, others @ ..], _) if paths.iter().all(is_csv) => {
            if data.stamp.is_some() {
                return Err(SourceError::Request(format!(
                    "{} is for bags; a table's time is in its column ({})",
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
                    "{}, {}, {} and {} do not apply to a log, because it contains its own stamps",
                    option("stamp"),
                    option("time"),
                    option("time_unit"),
                    option("sample_time")
                )));
            }
            Ok(Box::new(LogSource::open(path, kind)?))
        }
        (paths, log) if log.is_some() || paths.iter().any(is_csv) => Err(SourceError::Request(
            "a table can be joined only with other tables, so leave out the bag or log".to_owned(),
        )),
        _ if data.time != TableTime::default() => Err(SourceError::Request(format!(
            "{}, like {} and {}, is for .csv files; a bag has stamps ({})",
            option("time"),
            option("time_unit"),
            option("sample_time"),
            option("stamp")
        ))),
        (paths, _) => match BagSource::open(paths, data.stamp, data.most_unpacked) {
            Err(SourceError::Bag(error @ ReadError::NotABag { .. })) => {
                Err(SourceError::Data(format!(
                    "{error}; a table is a .{}, a log a .{}",
                    TABLES.join(", ."),
                    LogKind::all()
                        .iter()
                        .flat_map(|it| it.endings)
                        .copied()
                        .collect::<Vec<_>>()
                        .join(", .")
                )))
            }
            opened => Ok(Box::new(opened?)),
        },
    }
}
