//! Log: the macros of `log`, written to the console in rcl's format, to a file, and to `/rosout`.
//!
//! `[INFO] [1700000000.123456789] [auv.plant_sim]: text`. The middleware's errors are shown as errors, with limited frequency. The middleware's warnings
//! are about internals (a lost datagram, a peer that left) and count as debug; its other messages are dropped unless a level is set for the middleware
//! (`--log-level rustdds:=debug`). If one place in the code logs very often, for example for each message of a faulty peer, a limited number of lines is
//! written and the rest is counted.

use crate::error::Result;
use std::{
    collections::BTreeMap,
    fs::File,
    io::{IsTerminal as _, Write as _},
    sync::{
        Arc, Mutex, OnceLock, PoisonError,
        atomic::{AtomicBool, Ordering::Relaxed},
    },
    thread::{self, ThreadId},
    time::{Duration, Instant, SystemTime, UNIX_EPOCH},
};

use log::{Level, LevelFilter, Log, Metadata, Record};
use planesman_msgs::rcl_interfaces::msg::LoggerLevel;
use ros2_client::{
    builtin_interfaces,
    log::LogLevel,
    rosout::{NodeLoggingHandle, RosoutRaw as _},
};

use crate::{
    args::RosArguments,
    clock::Clock,
    log_file,
    log_format::{Entry, Format, colored},
};

/// Crates whose warnings count as debug.
const MIDDLEWARE: [&str; 5] = ["rustdds", "ros2_client", "cdr_encoding", "mio", "polling"];

/// Minimum time between two of the middleware's errors from one place.
const MIDDLEWARE_PERIOD: Duration = Duration::from_secs(5);

/// Maximum number of lines from one place per [`FLOOD_PERIOD`], without debug lines.
const MAX_LINES: u32 = 100;
const FLOOD_PERIOD: Duration = Duration::from_secs(10);

/// Log levels of the loggers.
#[derive(Clone, Debug)]
struct Levels {
    /// Level of loggers without their own level.
    default: LevelFilter,
    /// Levels by logger, including the node's.
    set: Vec<(String, LevelFilter)>,
}

/// Destination of the console's lines.
#[derive(Clone, Copy, Debug)]
struct Console {
    stdout: bool,
    colored: bool,
}

/// A node with a handle of `/rosout`, if it logs there.
struct LoggingNode {
    clock: Arc<Clock>,
    rosout: Option<NodeLoggingHandle>,
    /// Lines from this thread belong to the node.
    thread: ThreadId,
}

/// The log of the process.
struct Logger {
    /// Name of the node's logger, such as `auv.plant_sim`.
    name: String,
    levels: Mutex<Levels>,
    format: Format,
    console: Option<Console>,
    file: Option<File>,
    /// Running nodes that log: usually one per process, several in tests.
    nodes: Mutex<Vec<LoggingNode>>,
    /// The middleware's errors, by place in the code.
    throttle: Mutex<Throttle>,
    /// All lines except debug lines, by place in the code.
    flood: Mutex<Throttle>,
    /// Whether the node is shutting down: errors between parts of the middleware are then expected.
    ends: AtomicBool,
}

static LOGGER: OnceLock<Logger> = OnceLock::new();

/// Starts the log of the process under the node's name, to the console and if requested to a file. Only the first call has an effect.
///
/// # Errors
/// The log file cannot be written.
pub(crate) fn install(name: &str, arguments: &RosArguments) -> Result<()> {
    if LOGGER.get().is_some() {
        return Ok(());
    }
    let logger = Logger::new(name, arguments, |name| std::env::var(name).ok())?;
    if LOGGER.set(logger).is_ok()
        && let Some(logger) = LOGGER.get()
        && log::set_logger(logger).is_ok()
    {
        log::set_max_level(lock(&logger.levels).highest());
    }
    Ok(())
}

/// Level of the logger `name`, numbered as in `rcl_interfaces/msg/LoggerLevel`; 0 if unset.
pub(crate) fn level(name: &str) -> u32 {
    let Some(logger) = LOGGER.get() else {
        return 0;
    };
    let set = lock(&logger.levels).set_exactly_for(name);
    set.map_or(0, |level| u32::from(number_of(level)))
}

/// The reason why a level cannot be set.
#[derive(Clone, Copy, Debug, thiserror::Error)]
pub(crate) enum LevelError {
    #[error("invalid level {0}; allowed: 0, 10, 20, 30, 40, 50")]
    Unknown(u32),
    #[error("the log has not been started")]
    NoLog,
}

/// Sets the level of the logger `name`; 0 unsets it.
///
/// # Errors
/// [`LevelError`].
pub(crate) fn set_level(name: &str, number: u32) -> Result<(), LevelError> {
    let level = match u8::try_from(number) {
        Ok(LoggerLevel::LOG_LEVEL_UNKNOWN) => None,
        Ok(LoggerLevel::LOG_LEVEL_DEBUG) => Some(LevelFilter::Debug),
        Ok(LoggerLevel::LOG_LEVEL_INFO) => Some(LevelFilter::Info),
        Ok(LoggerLevel::LOG_LEVEL_WARN) => Some(LevelFilter::Warn),
        Ok(LoggerLevel::LOG_LEVEL_ERROR) => Some(LevelFilter::Error),
        Ok(LoggerLevel::LOG_LEVEL_FATAL) => Some(LevelFilter::Off),
        _ => return Err(LevelError::Unknown(number)),
    };
    let Some(logger) = LOGGER.get() else {
        return Err(LevelError::NoLog);
    };
    let mut levels = lock(&logger.levels);
    levels.set.retain(|(known, _)| known != name);
    levels
        .set
        .extend(level.map(|level| (name.to_owned(), level)));
    log::set_max_level(levels.highest());
    Ok(())
}

fn number_of(level: LevelFilter) -> u8 {
    match level {
        LevelFilter::Off => LoggerLevel::LOG_LEVEL_FATAL,
        LevelFilter::Error => LoggerLevel::LOG_LEVEL_ERROR,
        LevelFilter::Warn => LoggerLevel::LOG_LEVEL_WARN,
        LevelFilter::Info => LoggerLevel::LOG_LEVEL_INFO,
        LevelFilter::Debug | LevelFilter::Trace => LoggerLevel::LOG_LEVEL_DEBUG,
    }
}

/// Called when the node with this clock has started in this thread: also sends the log to `/rosout`, if enabled.
pub(crate) fn begin(rosout: Option<NodeLoggingHandle>, clock: &Arc<Clock>) {
    if let Some(logger) = LOGGER.get() {
        lock(&logger.nodes).push(LoggingNode {
            clock: Arc::clone(clock),
            rosout,
            thread: thread::current().id(),
        });
        logger.ends.store(false, Relaxed);
    }
}

/// Called when the node with this clock shuts down: returns its handle of `/rosout`, whose writer must be dropped before the participant.
pub(crate) fn end(clock: &Arc<Clock>) {
    if let Some(logger) = LOGGER.get() {
        let mut nodes = lock(&logger.nodes);
        nodes.retain(|node| !Arc::ptr_eq(&node.clock, clock));
        logger.ends.store(nodes.is_empty(), Relaxed);
    }
}

/// Publishes the final error on `/rosout` and writes it to the file; [`exit_code`](crate::exit_code) prints it on the console.
/// [`exit_code`](crate::exit_code).
pub(crate) fn log_final_error(error: &impl std::fmt::Display) {
    if let Some(logger) = LOGGER.get() {
        let text = format_args!("{error:#}");
        let record = Record::builder().level(Level::Error).args(text).build();
        logger.write_to_file(&logger.line(Level::Error, &record));
        logger.send(Level::Error, &record);
    }
}

/// Locks the mutex, ignoring poisoning: a panic leaves the data consistent.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn is_middleware(target: &str) -> bool {
    MIDDLEWARE.iter().any(|name| {
        target
            .strip_prefix(name)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
    })
}

/// Name of a logger without the namespace.
fn bare(name: &str) -> &str {
    name.rsplit('.').next().unwrap_or(name)
}

impl Levels {
    /// Level set last for exactly this logger.
    fn set_exactly_for(&self, name: &str) -> Option<LevelFilter> {
        let set = self.set.iter().rev().find(|(logger, _)| logger == name);
        set.map(|(_, level)| *level)
    }

    /// Level set for `name` or its nearest parent logger.
    fn set_for(&self, name: &str) -> Option<LevelFilter> {
        let above = |logger: &str| {
            name.strip_prefix(logger)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', ':']))
        };
        self.set
            .iter()
            .filter(|(logger, _)| above(logger))
            .max_by_key(|(logger, _)| logger.len())
            .map(|(_, level)| *level)
    }

    /// Level of the node `name`, also found by its name without the namespace.
    fn of_node(&self, name: &str) -> LevelFilter {
        self.set_exactly_for(name)
            .or_else(|| self.set_exactly_for(bare(name)))
            .or_else(|| self.set_for(name))
            .unwrap_or(self.default)
    }

    fn highest(&self) -> LevelFilter {
        let set = self.set.iter().map(|(_, level)| *level);
        set.fold(self.default, std::cmp::max)
    }
}

impl Logger {
    fn new(
        name: &str,
        arguments: &RosArguments,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Self> {
        let is_on = |name: &str| variable(name).as_deref() == Some("1");
        let stdout = is_on("RCUTILS_LOGGING_USE_STDOUT");
        let colored = match variable("RCUTILS_COLORIZED_OUTPUT").as_deref() {
            Some("0") => false,
            Some("1") => true,
            _ if variable("NO_COLOR").is_some_and(|it| !it.is_empty()) => false,
            _ if stdout => std::io::stdout().is_terminal(),
            _ => std::io::stderr().is_terminal(),
        };
        let prefix = arguments.log_file_prefix.as_deref();
        let prefix = prefix.unwrap_or_else(|| bare(name));
        let folder = log_file::folder(arguments, &variable);
        Ok(Self {
            name: name.to_owned(),
            levels: Mutex::new(Levels {
                default: arguments.log_level,
                set: arguments.logger_levels.clone(),
            }),
            format: variable("RCUTILS_CONSOLE_OUTPUT_FORMAT")
                .filter(|format| !format.is_empty())
                .map_or_else(Format::default, |format| Format::new(&format)),
            console: arguments.console.then_some(Console { stdout, colored }),
            file: folder
                .map(|folder| log_file::open(&folder, prefix))
                .transpose()?,
            nodes: Mutex::default(),
            throttle: Mutex::new(Throttle::new(MIDDLEWARE_PERIOD)),
            flood: Mutex::new(Throttle::of(MAX_LINES, FLOOD_PERIOD)),
            ends: AtomicBool::new(false),
        })
    }

    /// Level at which a record is logged; `None` if it is not.
    fn admitted(&self, metadata: &Metadata<'_>) -> Option<Level> {
        let levels = lock(&self.levels);
        let (level, limit) = if is_middleware(metadata.target()) {
            match (levels.set_for(metadata.target()), metadata.level()) {
                (Some(limit), level) => (level, limit),
                (None, Level::Error) if !self.ends.load(Relaxed) => (Level::Error, levels.default),
                (None, Level::Error | Level::Warn) => (Level::Debug, levels.default),
                (None, _) => return None,
            }
        } else {
            (metadata.level(), levels.of_node(&self.name))
        };
        (level <= limit).then_some(level)
    }

    /// Line of a record.
    fn line(&self, level: Level, record: &Record<'_>) -> String {
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH);
        self.format.line(&Entry {
            level,
            name: match is_middleware(record.target()) {
                true => record.target(),
                false => &self.name,
            },
            message: planesman_text::shown(record.args()).to_string(),
            function: record.module_path().unwrap_or_default(),
            file: record.file().unwrap_or_default(),
            line: record.line().unwrap_or_default(),
            since_1970: since_1970.unwrap_or_default(),
        })
    }

    /// Prints a line at once, so that processes sharing a terminal do not mix their lines. A closed console is ignored.
    fn print(&self, line: &str, level: Level) {
        let Some(console) = self.console else {
            return;
        };
        let line = match console.colored {
            true => colored(line, level) + "\n",
            false => format!("{line}\n"),
        };
        let _ = match console.stdout {
            true => std::io::stdout().write_all(line.as_bytes()),
            false => std::io::stderr().write_all(line.as_bytes()),
        };
    }

    /// Writes a line to the file. A full disk is ignored.
    fn write_to_file(&self, line: &str) {
        if let Some(mut file) = self.file.as_ref() {
            let _ = file.write_all(format!("{line}\n").as_bytes());
        }
    }

    /// Writes a record to all destinations.
    fn write(&self, level: Level, record: &Record<'_>) {
        let line = self.line(level, record);
        self.print(&line, level);
        self.write_to_file(&line);
        // What sending a record to /rosout logs must not be sent there.
        if !is_middleware(record.target()) {
            self.send(level, record);
        }
    }

    /// Sends a record to `/rosout` of the node in whose thread it was logged, or else of the node started last.
    fn send(&self, level: Level, record: &Record<'_>) {
        let nodes = lock(&self.nodes);
        let thread = thread::current().id();
        let own = nodes.iter().rfind(|node| node.thread == thread);
        if let Some(LoggingNode {
            clock,
            rosout: Some(rosout),
            ..
        }) = own.or(nodes.last())
        {
            rosout.rosout_raw(
                builtin_interfaces::Time::from_nanos(clock.now().nanos()),
                ros_level(level),
                &self.name,
                &record.args().to_string(),
                record.file().unwrap_or_default(),
                record.module_path().unwrap_or_default(),
                record.line().unwrap_or_default(),
            );
        }
    }
}

impl Log for Logger {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        self.admitted(metadata).is_some()
    }

    fn log(&self, record: &Record<'_>) {
        let Some(level) = self.admitted(record.metadata()) else {
            return;
        };
        let place = || format!("{}:{}", record.target(), record.line().unwrap_or_default());
        if is_middleware(record.target())
            && level == Level::Error
            && lock(&self.throttle).admit(&place()).is_none()
        {
            return;
        }
        let left_out = match level {
            Level::Error | Level::Warn | Level::Info => lock(&self.flood).admit(&place()),
            Level::Debug | Level::Trace => Some(0),
        };
        match left_out {
            None => {}
            Some(0) => self.write(level, record),
            Some(count) => self.write(
                level,
                &Record::builder()
                    .metadata(record.metadata().clone())
                    .args(format_args!(
                        "{} ({count} similar lines omitted)",
                        record.args()
                    ))
                    .module_path(record.module_path())
                    .file(record.file())
                    .line(record.line())
                    .build(),
            ),
        }
    }

    fn flush(&self) {}
}

fn ros_level(level: Level) -> LogLevel {
    match level {
        Level::Error => LogLevel::Error,
        Level::Warn => LogLevel::Warn,
        Level::Info => LogLevel::Info,
        Level::Debug | Level::Trace => LogLevel::Debug,
    }
}

/// Passes a limited number of lines per subject and period, and counts the others.
#[derive(Debug)]
pub struct Throttle {
    most: u32,
    period: Duration,
    subjects: BTreeMap<String, Lately>,
}

/// Lines of one subject in the present period.
#[derive(Debug)]
struct Lately {
    since: Instant,
    lines: u32,
    passed_over: u64,
}

impl Throttle {
    /// Limits the warnings to one per subject and `period`.
    #[must_use]
    pub fn new(period: Duration) -> Self {
        Self::of(1, period)
    }

    fn of(most: u32, period: Duration) -> Self {
        Self {
            most,
            period,
            subjects: BTreeMap::new(),
        }
    }

    /// Whether to log about `subject` now; returns the number of lines skipped since the last one.
    pub fn admit(&mut self, subject: &str) -> Option<u64> {
        self.admit_at(subject, Instant::now())
    }

    fn admit_at(&mut self, subject: &str, now: Instant) -> Option<u64> {
        let Some(lately) = self.subjects.get_mut(subject) else {
            let lately = Lately {
                since: now,
                lines: 1,
                passed_over: 0,
            };
            self.subjects.insert(subject.to_owned(), lately);
            return Some(0);
        };
        if now.duration_since(lately.since) >= self.period {
            (lately.since, lately.lines) = (now, 0);
        }
        if lately.lines == self.most {
            lately.passed_over += 1;
            return None;
        }
        lately.lines += 1;
        Some(std::mem::take(&mut lately.passed_over))
    }

    /// Warns about `subject`, unless there was such a warning within the period.
    pub fn warn(&mut self, subject: &str, text: &str) {
        match self.admit(subject) {
            Some(0) => log::warn!("{subject}: {text}"),
            Some(more) => log::warn!("{subject}: {text} ({more} more since the last warning)"),
            None => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn logger(arguments: &str) -> Logger {
        let line_of_arguments = format!("x --ros-args {arguments}");
        let (_, arguments) =
            crate::args::split(line_of_arguments.split_whitespace().map(str::to_owned))
                .expect("good arguments");
        Logger::new("auv.plant_sim", &arguments, |_| None).expect("no file is asked for")
    }

    fn admitted(logger: &Logger, target: &str, level: Level) -> Option<Level> {
        logger.admitted(&Metadata::builder().target(target).level(level).build())
    }

    #[test]
    fn the_middlewares_errors_are_errors_its_warnings_debug_and_the_rest_is_to_be_asked_for() {
        let plain = logger("");
        assert_eq!(
            admitted(&plain, "plant_sim::node", Level::Info),
            Some(Level::Info)
        );
        assert_eq!(admitted(&plain, "plant_sim::node", Level::Debug), None);
        assert_eq!(
            admitted(&plain, "rustdds::rtps", Level::Error),
            Some(Level::Error)
        );
        assert_eq!(admitted(&plain, "rustdds::rtps", Level::Warn), None);
        assert_eq!(admitted(&plain, "cdr_encoding::de", Level::Info), None);
        for debug in [
            "--log-level debug",
            "--log-level plant_sim:=debug --log-level debug",
        ] {
            let debug = logger(debug);
            assert_eq!(
                admitted(&debug, "rustdds::rtps", Level::Warn),
                Some(Level::Debug)
            );
            assert_eq!(admitted(&debug, "rustdds::rtps", Level::Debug), None);
        }
        let asked = logger("--log-level rustdds:=warn");
        assert_eq!(
            admitted(&asked, "rustdds::rtps", Level::Warn),
            Some(Level::Warn)
        );
    }

    #[test]
    fn the_node_is_meant_by_its_logger_or_its_bare_name() {
        for name in ["auv.plant_sim", "plant_sim", "auv"] {
            let logger = logger(&format!("--log-level {name}:=debug"));
            assert_eq!(
                admitted(&logger, "plant_sim", Level::Debug),
                Some(Level::Debug)
            );
            assert_eq!(
                admitted(&logger, "rustdds::rtps", Level::Warn),
                None,
                "{name}"
            );
        }
        let both = logger("--log-level auv.plant_sim:=warn --log-level plant_sim:=debug");
        assert_eq!(admitted(&both, "plant_sim", Level::Info), None);
    }

    #[test]
    fn a_level_for_a_logger_holds_for_those_below_it() {
        let quiet = logger("--log-level auv:=error --log-level auv.plant_sim:=debug");
        assert_eq!(
            admitted(&quiet, "plant_sim", Level::Debug),
            Some(Level::Debug)
        );
        let other = logger("--log-level auv:=error --log-level auv.plant:=debug");
        assert_eq!(admitted(&other, "plant_sim", Level::Warn), None);
    }

    #[test]
    fn of_a_flood_so_many_lines_are_written_and_the_rest_is_counted() {
        let mut flood = Throttle::of(MAX_LINES, FLOOD_PERIOD);
        let began = Instant::now();
        let place = |line| format!("plant_sim::node:{line}");
        for _ in 0..MAX_LINES {
            assert_eq!(flood.admit_at(&place(1), began), Some(0));
        }
        for _ in 0..7 {
            assert_eq!(flood.admit_at(&place(1), began), None);
        }
        assert_eq!(flood.admit_at(&place(2), began), Some(0));
        assert_eq!(flood.admit_at(&place(1), began + FLOOD_PERIOD), Some(7));
        assert_eq!(flood.admit_at(&place(1), began + FLOOD_PERIOD), Some(0));
    }

    #[test]
    fn a_throttle_speaks_once_per_subject() {
        let mut throttle = Throttle::new(Duration::from_secs(3600));
        assert_eq!(throttle.admit("a"), Some(0));
        assert_eq!(throttle.admit("a"), None);
        assert_eq!(throttle.admit("b"), Some(0));
    }
}
