//! The log: `log`'s macros to stderr in `rclcpp`'s form, and to `/rosout`.
//!
//! `[INFO] [1700000000.123456789] [auv.plant_sim]: text`. The middleware's own warnings
//! tell of its inner life (a lost datagram, a peer that left) more than of the node, so
//! they count as debug unless a level is set for them (`--log-level rustdds:=warn`).

use std::{
    collections::BTreeMap,
    io::Write as _,
    sync::{Arc, Mutex, OnceLock, PoisonError},
    time::{Duration, Instant, SystemTime, UNIX_EPOCH},
};

use log::{Level, LevelFilter, Log, Metadata, Record};
use ros2_client::{
    builtin_interfaces,
    log::LogLevel,
    rosout::{NodeLoggingHandle, RosoutRaw as _},
};

use crate::{args::RosArguments, clock::Clock};

/// Crates whose warnings count as debug.
const MIDDLEWARE: [&str; 4] = ["rustdds", "ros2_client", "mio", "polling"];

/// The process's log.
struct Logger {
    /// The node's logger name, `auv.plant_sim`.
    name: String,
    /// The level for the node.
    level: LevelFilter,
    /// Levels for loggers by name, the node's included.
    levels: Vec<(String, LevelFilter)>,
    /// Whether it goes to stderr.
    console: bool,
    /// Where it goes besides, while the node lives.
    rosout: Mutex<Option<(NodeLoggingHandle, Arc<Clock>)>>,
}

static LOGGER: OnceLock<Logger> = OnceLock::new();

/// Sends the process's log to stderr under the node's name. Only the first call counts.
pub(crate) fn install(name: &str, arguments: &RosArguments) {
    let mut fresh = false;
    let logger = LOGGER.get_or_init(|| {
        fresh = true;
        Logger {
            name: name.to_owned(),
            level: arguments.log_level,
            levels: arguments.logger_levels.clone(),
            console: arguments.console,
            rosout: Mutex::new(None),
        }
    });
    if fresh && log::set_logger(logger).is_ok() {
        let highest = logger.levels.iter().map(|(_, level)| *level).max();
        log::set_max_level(logger.level.max(highest.unwrap_or(LevelFilter::Off)));
    }
}

/// Sends the log to `/rosout` too, with the time of this clock, or no longer: a node going down takes its handle back,
/// since the middleware shuts down only when nobody holds it.
pub(crate) fn set_rosout(handle: Option<(NodeLoggingHandle, Arc<Clock>)>) {
    if let Some(logger) = LOGGER.get() {
        *lock(&logger.rosout) = handle;
    }
}

/// Publishes the final error on `/rosout`; the console gets it from
/// [`exit_code`](crate::exit_code).
pub(crate) fn last_words(error: &anyhow::Error) {
    if let Some(logger) = LOGGER.get() {
        let text = format_args!("{error:#}");
        let record = Record::builder().level(Level::Error).args(text).build();
        logger.send(Level::Error, &record);
    }
}

/// Whoever panicked while holding the lock left nothing half done.
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

impl Logger {
    /// The level set for `name` or the nearest logger above it.
    fn level_set_for(&self, name: &str) -> Option<LevelFilter> {
        let above = |logger: &str| {
            name.strip_prefix(logger)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', ':']))
        };
        self.levels
            .iter()
            .filter(|(logger, _)| above(logger))
            .max_by_key(|(logger, _)| logger.len())
            .map(|(_, level)| *level)
    }

    /// Whether a record passes, and at which level.
    fn admitted(&self, metadata: &Metadata<'_>) -> Option<Level> {
        let (level, limit) = if is_middleware(metadata.target()) {
            match self.level_set_for(metadata.target()) {
                Some(limit) => (metadata.level(), limit),
                None => (metadata.level().max(Level::Debug), self.level),
            }
        } else {
            let limit = self.level_set_for(&self.name).unwrap_or(self.level);
            (metadata.level(), limit)
        };
        (level <= limit).then_some(level)
    }
}

impl Logger {
    /// Sends a record of the node to `/rosout`.
    fn send(&self, level: Level, record: &Record<'_>) {
        if let Some((rosout, clock)) = lock(&self.rosout).as_ref() {
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
        let now = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .unwrap_or_default();
        let middleware = is_middleware(record.target());
        let name = if middleware {
            record.target()
        } else {
            &self.name
        };
        if self.console {
            // In one piece, so that processes sharing a terminal do not mix their lines.
            let line = format!(
                "[{level}] [{}.{:09}] [{name}]: {}\n",
                now.as_secs(),
                now.subsec_nanos(),
                planesman_text::shown(record.args()),
            );
            // A closed stderr is no reason to stop.
            let _ = std::io::stderr().write_all(line.as_bytes());
        }
        // What sending a record to /rosout logs must not be sent there.
        if !middleware {
            self.send(level, record);
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

/// Lets one warning per subject and period through, and counts the rest.
#[derive(Debug)]
pub struct Throttle {
    period: Duration,
    last: BTreeMap<String, (Instant, u64)>,
}

impl Throttle {
    /// One warning per subject in `period`.
    #[must_use]
    pub fn new(period: Duration) -> Self {
        Self {
            period,
            last: BTreeMap::new(),
        }
    }

    /// Whether to speak of `subject` now, and how often it was passed over since the last time.
    pub fn admit(&mut self, subject: &str) -> Option<u64> {
        let now = Instant::now();
        match self.last.get_mut(subject) {
            Some((last, passed_over)) if now.duration_since(*last) < self.period => {
                *passed_over += 1;
                None
            }
            known => {
                let passed_over = known.map_or(0, |(_, count)| *count);
                self.last.insert(subject.to_owned(), (now, 0));
                Some(passed_over)
            }
        }
    }

    /// Warns about `subject`, unless it did so less than a period ago.
    pub fn warn(&mut self, subject: &str, text: &str) {
        match self.admit(subject) {
            Some(0) => log::warn!("{subject}: {text}"),
            Some(more) => log::warn!("{subject}: {text} ({more} more since the last such warning)"),
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
        Logger {
            name: "auv.plant_sim".to_owned(),
            level: arguments.log_level,
            levels: arguments.logger_levels,
            console: false,
            rosout: Mutex::new(None),
        }
    }

    fn admitted(logger: &Logger, target: &str, level: Level) -> Option<Level> {
        logger.admitted(&Metadata::builder().target(target).level(level).build())
    }

    #[test]
    fn the_middlewares_warnings_count_as_debug_unless_asked_for() {
        let plain = logger("");
        assert_eq!(
            admitted(&plain, "plant_sim::node", Level::Info),
            Some(Level::Info)
        );
        assert_eq!(admitted(&plain, "plant_sim::node", Level::Debug), None);
        assert_eq!(admitted(&plain, "rustdds::rtps", Level::Warn), None);
        let debug = logger("--log-level debug");
        assert_eq!(
            admitted(&debug, "rustdds::rtps", Level::Warn),
            Some(Level::Debug)
        );
        let asked = logger("--log-level rustdds:=warn");
        assert_eq!(
            admitted(&asked, "rustdds::rtps", Level::Warn),
            Some(Level::Warn)
        );
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
    fn a_throttle_speaks_once_per_subject() {
        let mut throttle = Throttle::new(Duration::from_secs(3600));
        assert_eq!(throttle.admit("a"), Some(0));
        assert_eq!(throttle.admit("a"), None);
        assert_eq!(throttle.admit("b"), Some(0));
    }
}
