//! The outputs of the composition: a bag, or a CSV file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use planesman_bag::writer::{BagWriter, TopicId, WriterOptions};
use planesman_msgs::Message;
use planesman_msgs::builtin_interfaces::msg::Time;
use recorder::loop_topics;

use crate::compose::{Sink, Tick};

/// The full name of a loop topic in a namespace.
#[must_use]
pub fn full_name(namespace: &str, topic: &str) -> String {
    if topic.starts_with('/') {
        topic.to_owned()
    } else {
        format!("{}/{topic}", namespace.trim_end_matches('/'))
    }
}

/// A file that is whole or not there: written beside its place, moved there at the end.
struct Draft {
    path: PathBuf,
    draft: PathBuf,
}

impl Draft {
    fn new(path: &Path) -> Result<Self> {
        if path.exists() {
            bail!("'{}' exists already; name another path", path.display());
        }
        let name = path
            .file_name()
            .with_context(|| format!("'{}' names no file", path.display()))?;
        let mut draft = std::ffi::OsString::from(".");
        draft.push(name);
        draft.push(format!(".{}.part", std::process::id()));
        Ok(Self {
            path: path.to_owned(),
            draft: path.with_file_name(draft),
        })
    }

    fn finish(self) -> Result<()> {
        std::fs::rename(&self.draft, &self.path)
            .with_context(|| format!("cannot put '{}' in its place", self.path.display()))
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        // After `finish` nothing is there any more; before, it is a failed run's rest.
        let _ = std::fs::remove_file(&self.draft);
    }
}

/// Composed messages as one MCAP file.
pub struct McapSink {
    writer: BagWriter,
    draft: Draft,
    namespace: String,
    topics: BTreeMap<String, TopicId>,
}

impl McapSink {
    /// Begins the file.
    ///
    /// # Errors
    /// When the path is taken or cannot be written.
    pub fn create(path: &Path, namespace: &str) -> Result<Self> {
        let draft = Draft::new(path)?;
        Ok(Self {
            writer: BagWriter::create_draft(
                &draft.draft,
                &draft.path,
                WriterOptions {
                    flush_interval: None,
                    ..WriterOptions::default()
                },
            )?,
            draft,
            namespace: namespace.to_owned(),
            topics: BTreeMap::new(),
        })
    }

    /// Ends the file and puts it in its place.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(self) -> Result<()> {
        self.writer.close()?;
        self.draft.finish()
    }
}

impl Sink for McapSink {
    fn put<M: Message>(&mut self, topic: &str, stamp: &Time, message: &M) -> Result<()> {
        let id = match self.topics.get(topic) {
            Some(id) => *id,
            None => {
                let Some(known) = loop_topics::ALL.iter().find(|t| t.name == topic) else {
                    bail!("'{topic}' is not a topic of the loop");
                };
                let id = self
                    .writer
                    .add_topic(&known.in_bag(&full_name(&self.namespace, topic)))?;
                self.topics.insert(topic.to_owned(), id);
                id
            }
        };
        self.writer.write(id, message, stamp.nanos())?;
        Ok(())
    }
}

/// The flight as one row a tick, SI units in the header.
pub struct CsvSink {
    out: BufWriter<File>,
    draft: Draft,
}

/// The columns: name with unit, and where the number comes from.
type Column = (&'static str, fn(&Tick) -> f64);

const COLUMNS: &[Column] = &[
    ("time [s]", |t| t.stamp.nanos() as f64 * 1e-9),
    ("depth [m]", |t| t.observation.state.depth),
    ("depth_rate [m/s]", |t| t.observation.state.depth_rate),
    ("distance [m]", |t| t.observation.state.distance),
    ("pitch [rad]", |t| t.observation.state.pitch),
    ("pitch_rate [rad/s]", |t| t.observation.state.pitch_rate),
    ("surge [m/s]", |t| t.observation.state.surge),
    ("heave [m/s]", |t| t.observation.state.heave),
    ("dive_planes [rad]", |t| t.observation.state.dive_planes),
    ("plane_command [rad]", |t| t.command.dive_planes),
    ("depth_setpoint [m]", |t| t.control.depth_setpoint),
    ("pitch_command [rad]", |t| t.control.pitch_command),
    ("identification [rad]", |t| t.control.identification),
    ("ram [m]", |t| t.actuator.states[0].ram),
    ("pressure [Pa]", |t| t.actuator.states[0].pressure),
    ("pulses [1]", |t| t.actuator.states[0].pulses as f64),
    ("depth_pressure [Pa]", |t| {
        t.observation.depth_pressure.fluid_pressure
    }),
    ("gyro_pitch_rate [rad/s]", |t| {
        -t.observation.imu.angular_velocity.y
    }),
];

impl CsvSink {
    /// Begins the table with its header row.
    ///
    /// # Errors
    /// When the path is taken or cannot be written.
    pub fn create(path: &Path) -> Result<Self> {
        let draft = Draft::new(path)?;
        let file = File::create_new(&draft.draft)
            .with_context(|| format!("cannot write '{}'", path.display()))?;
        let mut out = BufWriter::new(file);
        let names: Vec<&str> = COLUMNS.iter().map(|(name, _)| *name).collect();
        writeln!(out, "{}", names.join(","))?;
        Ok(Self { out, draft })
    }

    /// Takes one tick. Numbers are written so that they read back to the same bits.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn put(&mut self, tick: &Tick) -> Result<()> {
        let row: Vec<String> = COLUMNS.iter().map(|(_, of)| of(tick).to_string()).collect();
        writeln!(self.out, "{}", row.join(","))?;
        Ok(())
    }

    /// Ends the table and puts it in its place.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(mut self) -> Result<()> {
        self.out.flush()?;
        self.draft.finish()
    }
}
