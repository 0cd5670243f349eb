//! Contents of one `.mcap` or `.db3` file.
//!
//! The contents are in the file's summary if the file was closed; otherwise, or if the whole file is compressed, the file is read once and counted.
//! In both cases [`Recording`] contains the position up to which it is readable.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::{self, Read},
    path::{Path, PathBuf},
    sync::Arc,
};

use tempfile::{NamedTempFile, TempPath};

use crate::{
    defect::Defect,
    definitions::Channels,
    fields::{Header, op},
    input::Input,
    limits::Limits,
    read_error::ReadError,
    records::{Damage, Records, read_up_to},
    sqlite::{self, Rows},
    summary,
    walk::{Raw, Walk},
};

/// Number of further bytes used to guess the format of an unknown file.
const GUESSED_BY: u64 = 8;

/// Contents of a file.
#[derive(Clone, Debug)]
pub(crate) struct Recording {
    pub(crate) path: PathBuf,
    /// Size of the file when it was opened, unpacked if compressed, bytes.
    pub(crate) size: u64,
    /// Number of readable bytes.
    pub(crate) readable: u64,
    /// Topics by channel.
    pub(crate) channels: Arc<Channels>,
    /// Number of topics beyond the memory limit.
    pub(crate) omitted: u64,
    /// Number of messages on all topics.
    pub(crate) messages: u64,
    /// Earliest and latest log time, ns.
    pub(crate) span: Option<(i64, i64)>,
    /// The reason why the file is incomplete, if it is.
    pub(crate) cut: Option<Defect>,
    /// Set for a database file.
    database: Option<Database>,
    /// Memory limits.
    limits: Limits,
}

/// The file that a database is read from.
#[derive(Clone, Debug)]
enum Database {
    /// The recording's own file.
    Plain,
    /// A temporary unpacked copy, since SQLite cannot read compressed files. The unpacked file is removed when it is no longer used.
    Unpacked(Arc<TempPath>),
}

/// Stream of a file's messages.
pub(crate) enum Stream {
    Mcap(Box<Walk>),
    Database(Box<Rows>),
}

impl Stream {
    /// The next message; `None` after the last one.
    pub(crate) fn next(&mut self) -> Result<Option<Raw<'_>>, Damage> {
        match self {
            Self::Mcap(walk) => walk.next(),
            Self::Database(rows) => rows.next(),
        }
    }

    /// Number of bytes read.
    pub(crate) fn offset(&self) -> u64 {
        match self {
            Self::Mcap(walk) => walk.offset(),
            Self::Database(rows) => rows.offset(),
        }
    }

    /// Number of messages so far, including those of omitted topics.
    pub(crate) fn met(&self) -> u64 {
        match self {
            Self::Mcap(walk) => walk.met,
            Self::Database(rows) => rows.met,
        }
    }
}

/// Number of messages by channel.
pub(crate) type Counts = BTreeMap<u16, u64>;

impl Recording {
    /// Finds out the contents of the file at `path`, with the number of messages per channel.
    pub(crate) fn open(path: &Path, limits: Limits) -> Result<(Self, Counts), ReadError> {
        let unreadable = |source| ReadError::open(path, source);
        // Asked before it is opened: a pipe would be waited for.
        let about = fs::metadata(path).map_err(unreadable)?;
        if !about.is_file() {
            return Err(ReadError::NotABag {
                path: path.to_owned(),
                found: "not a regular file",
            });
        }
        let size = about.len();
        let mut beginning = Vec::new();
        File::open(path)
            .and_then(|file| {
                file.take(sqlite::MAGIC.len() as u64)
                    .read_to_end(&mut beginning)
            })
            .map_err(unreadable)?;
        if beginning == sqlite::MAGIC {
            return Self::of_database(path, Database::Plain, size, limits);
        }
        let open = || Input::open(path).map_err(unreadable);
        let mut input = open()?;
        if input.is_packed() {
            beginning.clear();
            let magic = sqlite::MAGIC.len() as u64;
            // What cannot be unpacked is refused below.
            let _ = (&mut input).take(magic).read_to_end(&mut beginning);
            if beginning == sqlite::MAGIC {
                let unpacked = unpack(open()?).map_err(unreadable)?;
                let size = fs::metadata(&*unpacked).map_err(unreadable)?.len();
                return Self::of_database(path, Database::Unpacked(unpacked), size, limits);
            }
            input = open()?;
        }
        check_beginning(path, &mut input)?;
        if input.is_packed() {
            let walk = Walk::new(open()?, u64::MAX, &limits, None);
            return Ok(Self::counted(path, walk.map_err(unreadable)?, None, limits));
        }
        let mut file = File::open(path).map_err(unreadable)?;
        let summary_start = summary::start(&mut file, size).map_err(unreadable)?;
        if let Some(start) = summary_start
            && let Some(summary) = summary::read(&mut file, start, size, &limits)
        {
            let (channels, omitted) = summary.definitions.into_channels();
            let recording = Self {
                path: path.to_owned(),
                size,
                readable: size,
                channels: Arc::new(channels),
                omitted,
                messages: summary.counts.values().sum(),
                span: summary.span,
                cut: None,
                database: None,
                limits,
            };
            return Ok((recording, summary.counts));
        }
        let walk = Walk::new(open()?, size, &limits, None).map_err(unreadable)?;
        let closed = Some((size, summary_start.is_some()));
        Ok(Self::counted(path, walk, closed, limits))
    }

    /// Opens a file of the sqlite3 storage.
    fn of_database(
        path: &Path,
        database: Database,
        size: u64,
        limits: Limits,
    ) -> Result<(Self, Counts), ReadError> {
        let file = database.file(path);
        let found =
            sqlite::contents(file, &limits).map_err(|error| ReadError::database(path, &error))?;
        let recording = Self {
            path: path.to_owned(),
            size,
            readable: size,
            channels: Arc::new(found.channels),
            omitted: found.omitted,
            messages: found.counts.values().sum(),
            span: found.span,
            cut: None,
            database: Some(database),
            limits,
        };
        Ok((recording, found.counts))
    }

    /// Reads the whole file and counts its messages. `size` and whether it was closed are unknown for a compressed file.
    fn counted(
        path: &Path,
        mut walk: Walk,
        known: Option<(u64, bool)>,
        limits: Limits,
    ) -> (Self, Counts) {
        let mut counts = Counts::new();
        let mut span: Option<(i64, i64)> = None;
        let damage = loop {
            match walk.next() {
                Ok(Some(raw)) => {
                    let time = raw.message.log_time;
                    *counts.entry(raw.message.channel_id).or_default() += 1;
                    span = Some(match span {
                        None => (time, time),
                        Some((first, last)) => (first.min(time), last.max(time)),
                    });
                }
                Ok(None) => break None,
                Err(damage) => break Some(damage),
            }
        };
        let (size, was_closed) = known.unwrap_or((walk.offset(), walk.data_ended));
        let cut = damage.or_else(|| {
            let reason = if walk.data_ended {
                Defect::IndexCut
            } else {
                Defect::NotClosed
            };
            (!was_closed).then_some(Damage {
                offset: size,
                reason,
            })
        });
        let messages = walk.met;
        let (channels, omitted) = walk.definitions.into_channels();
        let recording = Self {
            path: path.to_owned(),
            size,
            readable: cut.as_ref().map_or(size, |damage| damage.offset),
            channels: Arc::new(channels),
            omitted,
            messages,
            span,
            cut: cut.map(|damage| damage.reason),
            database: None,
            limits,
        };
        (recording, counts)
    }

    /// Stream of the file's messages, up to the last readable message.
    pub(crate) fn stream(&self) -> Result<Stream, ReadError> {
        if let Some(database) = &self.database {
            let channels = Arc::clone(&self.channels);
            return Rows::new(database.file(&self.path), channels, &self.limits)
                .map(|rows| Stream::Database(Box::new(rows)))
                .map_err(|error| ReadError::database(&self.path, &error));
        }
        let found = Some(Arc::clone(&self.channels));
        Input::open(&self.path)
            .and_then(|input| Walk::new(input, self.readable, &self.limits, found))
            .map(|walk| Stream::Mcap(Box::new(walk)))
            .map_err(|source| ReadError::open(&self.path, source))
    }
}

impl Database {
    /// The file to open for the recording at `path`.
    fn file<'a>(&'a self, path: &'a Path) -> &'a Path {
        match self {
            Self::Plain => path,
            Self::Unpacked(file) => file,
        }
    }
}

/// Unpacks a compressed file into a temporary file.
fn unpack(mut packed: Input) -> io::Result<Arc<TempPath>> {
    let mut file = NamedTempFile::with_suffix(".db3")?;
    io::copy(&mut packed, &mut file)?;
    Ok(Arc::new(file.into_temp_path()))
}

/// Checks that the input begins like an MCAP file: the magic, then a complete header record.
fn check_beginning(path: &Path, input: &mut Input) -> Result<(), ReadError> {
    const LONGEST_HEADER: u64 = 1 << 20;
    let unreadable = |source| ReadError::open(path, source);
    let mut beginning = [0; mcap::MAGIC.len()];
    let read = read_up_to(input, &mut beginning).map_err(unreadable)?;
    let beginning = &beginning[..read];
    if beginning.is_empty() {
        return Err(ReadError::Empty {
            path: path.to_owned(),
        });
    }
    if !mcap::MAGIC.starts_with(beginning) {
        let mut beginning = beginning.to_vec();
        input
            .take(GUESSED_BY)
            .read_to_end(&mut beginning)
            .map_err(unreadable)?;
        return Err(ReadError::NotABag {
            path: path.to_owned(),
            found: guess(&beginning),
        });
    }
    match Records::new(input, mcap::MAGIC.len() as u64, LONGEST_HEADER).next(|_| true) {
        Ok(Some(record)) if record.opcode == op::HEADER && Header::read(record.body).is_ok() => {
            Ok(())
        }
        _ => Err(ReadError::NoHeader {
            path: path.to_owned(),
        }),
    }
}

/// Probable format of a file that is not MCAP, from its first bytes.
fn guess(beginning: &[u8]) -> &'static str {
    const KINDS: [(&[u8], &str); 6] = [
        (b"\xFF\xD8\xFF", "a JPEG picture"),
        (b"\x89PNG", "a PNG picture"),
        (b"PK", "a ZIP archive"),
        (b"\x1F\x8B", "a gzip archive"),
        (
            b"#ROSBAG",
            "a ROS 1 bag (convert it with 'rosbags-convert')",
        ),
        (b"rosbag2_bagfile", "the metadata of a bag"),
    ];
    KINDS
        .iter()
        .find(|(first, _)| beginning.starts_with(first))
        .map_or("something else", |(_, kind)| kind)
}
