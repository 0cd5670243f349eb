//! Outputs of the loop in one process: a bag, or a CSV file.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use crate::error::{During, Error, Result, refuse};
use planesman_bag::Topic;
use planesman_bag::writer::{BagWriter, WriteError, WriterOptions};
use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::loop_topics::{Sink, named};
use planesman_msgs::planesman_msgs::msg::DhaState;
use planesman_msgs::{Message, cdr};
use planesman_plant::Instruments;
use planesman_recording::in_bag;
use planesman_text::Draft;

use crate::compose::Tick;

/// Full name of a loop topic in a namespace.
#[must_use]
pub fn full_name(namespace: &str, topic: &str) -> String {
    if topic.starts_with('/') {
        topic.to_owned()
    } else {
        format!("{}/{topic}", namespace.trim_end_matches('/'))
    }
}

/// Opens the draft of a file that does not exist, or that it `replaces`.
fn draft_of(path: &Path, replaces: bool) -> Result<Draft> {
    if path.exists() && !(replaces && path.is_file()) {
        refuse!("'{}' exists already; name another path", path.display());
    }
    Draft::of(path).during(|| cannot_write(path))
}

fn cannot_write(path: &Path) -> String {
    format!("cannot write '{}'", path.display())
}

/// Writes a file's content, completely or not at all.
///
/// # Errors
/// If it cannot be written; the error names the file.
pub fn write_text(path: &Path, text: impl AsRef<[u8]>) -> Result<()> {
    planesman_text::write_text(path, text).during(|| cannot_write(path))
}

/// Writes the loop's messages into one MCAP file. The calling thread serializes them; another thread compresses and writes them in the same
/// order, so the file is deterministic.
pub struct McapSink {
    batch: Batch,
    to_writer: SyncSender<Batch>,
    /// Returns the writer at the end; `None` after the thread was joined.
    writer: Option<JoinHandle<Result<BagWriter, WriteError>>>,
    draft: Draft,
    path: PathBuf,
    namespace: String,
    /// Topics so far, in order of appearance.
    topics: Vec<&'static str>,
}

/// Messages on their way to the writer.
#[derive(Default)]
struct Batch {
    entries: Vec<Entry>,
    /// Payloads, one after the other.
    bytes: Vec<u8>,
}

enum Entry {
    /// A new topic.
    Topic(Box<Topic>),
    /// A message: number of its topic, and its length.
    Message {
        topic: usize,
        stamp: i64,
        length: usize,
    },
}

/// Size in bytes at which a batch goes to the writer.
const BATCH: usize = 128 * 1024;
/// Number of batches that may wait for the writer.
const WAITING: usize = 8;

/// Writes batches until the channel closes.
fn write_all(mut writer: BagWriter, batches: Receiver<Batch>) -> Result<BagWriter, WriteError> {
    let mut topics = Vec::new();
    for Batch { entries, bytes } in batches {
        let mut rest = bytes.as_slice();
        for entry in entries {
            match entry {
                Entry::Topic(topic) => topics.push(writer.add_topic(&topic)?),
                Entry::Message {
                    topic,
                    stamp,
                    length,
                } => {
                    let (payload, after) = rest.split_at(length);
                    writer.write_raw(topics[topic], payload, stamp, stamp)?;
                    rest = after;
                }
            }
        }
    }
    Ok(writer)
}

impl McapSink {
    /// Creates the file.
    ///
    /// # Errors
    /// If the path exists or cannot be written.
    pub fn create(path: &Path, namespace: &str, replaces: bool) -> Result<Self> {
        let mut draft = draft_of(path, replaces)?;
        let file = draft.file().try_clone()?;
        let writer = BagWriter::create_in(
            file,
            path,
            WriterOptions {
                flush_interval: None,
                ..WriterOptions::default()
            },
        )?;
        let (to_writer, batches) = sync_channel(WAITING);
        let writer = std::thread::Builder::new()
            .spawn(move || write_all(writer, batches))
            .during(|| "cannot start the thread that writes the bag")?;
        Ok(Self {
            batch: Batch::default(),
            to_writer,
            writer: Some(writer),
            draft,
            path: path.to_owned(),
            namespace: namespace.to_owned(),
            topics: Vec::new(),
        })
    }

    /// Finishes the file and moves it to its path.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> Result<()> {
        self.hand_over()?;
        drop(self.to_writer);
        returned(self.writer)?.close()?;
        self.draft.finish().during(|| cannot_write(&self.path))
    }

    /// Sends the collected batch to the writer.
    fn hand_over(&mut self) -> Result<()> {
        let next = Batch {
            entries: Vec::with_capacity(self.batch.entries.len()),
            bytes: Vec::with_capacity(2 * BATCH),
        };
        let full = std::mem::replace(&mut self.batch, next);
        if self.to_writer.send(full).is_err() {
            // It takes no more only after an error, which it returns.
            returned(self.writer.take())?;
        }
        Ok(())
    }
}

/// Result of the writing thread.
fn returned(writer: Option<JoinHandle<Result<BagWriter, WriteError>>>) -> Result<BagWriter> {
    match writer.map(JoinHandle::join) {
        Some(Ok(outcome)) => Ok(outcome?),
        Some(Err(panic)) => std::panic::resume_unwind(panic),
        None => refuse!("an earlier write to the bag has failed"),
    }
}

impl Sink for McapSink {
    type Error = Error;

    fn put<M: Message>(&mut self, topic: &str, stamp: &Time, message: &M) -> Result<()> {
        let place = match self.topics.iter().position(|known| *known == topic) {
            Some(place) => place,
            None => {
                let Some(known) = named(topic) else {
                    refuse!("'{topic}' is not a topic of the loop");
                };
                let in_bag = in_bag(known, &full_name(&self.namespace, topic));
                self.batch.entries.push(Entry::Topic(Box::new(in_bag)));
                self.topics.push(known.name);
                self.topics.len() - 1
            }
        };
        let before = self.batch.bytes.len();
        cdr::append(&mut self.batch.bytes, message);
        self.batch.entries.push(Entry::Message {
            topic: place,
            stamp: stamp.nanos(),
            length: self.batch.bytes.len() - before,
        });
        if self.batch.bytes.len() >= BATCH {
            self.hand_over()?;
        }
        Ok(())
    }
}

/// Writes the flight as one row per tick, with SI units in the header.
pub struct CsvSink {
    out: BufWriter<File>,
    draft: Draft,
    path: PathBuf,
}

/// A column: its name with unit, its source, its signal in a bag (`TOPIC:FIELD`, with `-` for the opposite sign), and the function for its
/// value.
pub type Column = (&'static str, &'static str, fn(&Tick) -> f64);

/// Value of the first actuator; NaN without an actuator.
fn first(tick: &Tick, of: fn(&DhaState) -> f64) -> f64 {
    tick.states.first().map_or(f64::NAN, of)
}

/// Value of the instruments; NaN without instruments.
fn read(tick: &Tick, of: fn(&Instruments) -> f64) -> f64 {
    tick.observation.instruments.as_ref().map_or(f64::NAN, of)
}

/// Columns of the table of a flight.
pub const COLUMNS: &[Column] = &[
    ("time [s]", "", |t| t.stamp.nanos() as f64 * 1e-9),
    ("depth [m]", "state:depth", |t| t.observation.state.depth),
    ("depth_rate [m/s]", "state:depth_rate", |t| {
        t.observation.state.depth_rate
    }),
    ("distance [m]", "state:distance", |t| {
        t.observation.state.distance
    }),
    ("pitch [rad]", "state:pitch", |t| t.observation.state.pitch),
    ("pitch_rate [rad/s]", "state:pitch_rate", |t| {
        t.observation.state.pitch_rate
    }),
    ("surge [m/s]", "state:surge", |t| t.observation.state.surge),
    ("heave [m/s]", "state:heave", |t| t.observation.state.heave),
    ("dive_planes [rad]", "state:dive_planes", |t| {
        t.observation.state.dive_planes
    }),
    ("plane_command [rad]", "plane_command:dive_planes", |t| {
        t.command.dive_planes
    }),
    ("depth_setpoint [m]", "control_state:depth_setpoint", |t| {
        t.control.depth_setpoint
    }),
    ("pitch_command [rad]", "control_state:pitch_command", |t| {
        t.control.pitch_command
    }),
    (
        "identification [rad]",
        "control_state:identification",
        |t| t.control.identification,
    ),
    ("ram [m]", "dha_state:ram", |t| first(t, |it| it.ram)),
    ("pressure [Pa]", "dha_state:pressure", |t| {
        first(t, |it| it.pressure)
    }),
    ("pulses [1]", "dha_state:pulses", |t| {
        first(t, |it| it.pulses as f64)
    }),
    (
        "depth_pressure [Pa]",
        "depth_pressure:fluid_pressure",
        |t| read(t, |it| it.depth_pressure.fluid_pressure),
    ),
    ("gyro_pitch_rate [rad/s]", "-imu:angular_velocity.y", |t| {
        read(t, |it| -it.imu.angular_velocity.y)
    }),
];

impl CsvSink {
    /// Creates the table with its header row.
    ///
    /// # Errors
    /// If the path exists or cannot be written.
    pub fn create(path: &Path, replaces: bool) -> Result<Self> {
        let mut draft = draft_of(path, replaces)?;
        let mut out = BufWriter::new(draft.file().try_clone()?);
        let names: Vec<&str> = COLUMNS.iter().map(|(name, ..)| *name).collect();
        let begun = writeln!(out, "{}", names.join(","));
        let sink = Self {
            out,
            draft,
            path: path.to_owned(),
        };
        sink.written(begun)?;
        Ok(sink)
    }

    /// Writes one tick. Numbers are written so that they read back to the same bits.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn put(&mut self, tick: &Tick) -> Result<()> {
        let row = self.row(tick);
        self.written(row)
    }

    fn row(&mut self, tick: &Tick) -> std::io::Result<()> {
        for (place, (_, _, of)) in COLUMNS.iter().enumerate() {
            let comma = if place > 0 { "," } else { "" };
            write!(self.out, "{comma}{}", of(tick))?;
        }
        writeln!(self.out)
    }

    /// Adds the file's name to an error.
    fn written(&self, result: std::io::Result<()>) -> Result<()> {
        result.during(|| cannot_write(&self.path))
    }

    /// Finishes the table and moves it to its path.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> Result<()> {
        let flushed = self.out.flush();
        self.written(flushed)?;
        self.draft.finish().during(|| cannot_write(&self.path))
    }
}
