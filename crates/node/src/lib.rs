//! The node runtime, shared by all nodes of the suite.
//!
//! A node's program is a `match` over its events:
//!
//! ```no_run
//! use std::process::ExitCode;
//!
//! use planesman_msgs::std_msgs::msg::Float64;
//! use planesman_node::{Flow, NodeSpec, Qos, Runtime, args};
//! use planesman_parameters::Parameters;
//!
//! #[derive(Parameters)]
//! struct Doubler {
//!     /// Output over input.
//!     #[parameter(default = 2.0, range = 0.0..=10.0)]
//!     gain: f64,
//! }
//!
//! enum Event {
//!     Input(Float64),
//!     Parameters(Doubler),
//! }
//!
//! fn main() -> ExitCode {
//!     planesman_node::exit_code("doubler", run)
//! }
//!
//! fn run() -> anyhow::Result<()> {
//!     let spec = NodeSpec {
//!         name: "doubler",
//!         namespace: "/",
//!         validate: |_: &Doubler| Ok(()),
//!         on_parameters: Event::Parameters,
//!     };
//!     let (rt, mut parameters) = Runtime::start(spec, args::from_environment()?)?;
//!     let output = rt.publisher::<Float64>("output", Qos::reliable(10))?;
//!     rt.subscribe("input", Qos::reliable(10), Event::Input)?;
//!     rt.run(|_, event| {
//!         match event {
//!             Event::Input(input) => {
//!                 output.publish(&Float64 { data: parameters.gain * input.data });
//!             }
//!             Event::Parameters(changed) => parameters = changed,
//!         }
//!         Ok(Flow::Continue)
//!     })
//! }
//! ```
//!
//! | module | what it holds |
//! |---|---|
//! | [`runtime`] | the node: one thread, one event at a time |
//! | [`args`] | `--ros-args` |
//! | [`names`], `name_rules` | expanding and remapping names; their form |
//! | [`domain`], `unsupported` | `ROS_DOMAIN_ID` and the discovery range; what of ROS's variables there is not |
//! | `security` | `ROS_SECURITY_*` and enclaves |
//! | `parameters` | the six parameter services |
//! | `type_description` | `~/get_type_description` |
//! | [`qos`] | quality of service as ROS conventions have it |
//! | [`publisher`], `subscription`, [`raw`] | topics out, in, and undecoded |
//! | [`service`], `answers`, `waiting` | services served and called; answers on their way |
//! | `share` | how much of its time a node gives to requests |
//! | `intake` | how many bytes of messages a node holds, and how much of its time it gives to large ones |
//! | [`action_server`], [`action_client`], `goals` | actions served and asked; the server's book |
//! | `endpoint` | one end of a topic: peers and counts |
//! | `clock`, `clock_source` | wall time or `/clock` |
//! | [`logging`], `log_format`, `log_file` | console, file and `/rosout`; a line's form |
//! | `lifecycle` | managed nodes |
//! | `logger_levels` | the two services that tell and set levels |
//! | [`diagnostics`] | `/diagnostics`, written and read |
//! | `discovered` | what others publish |
//! | `definition` | the definitions of its types |
//! | `losses` | how many messages are missing |
//! | `discovery_news` | QoS that does not fit, readers that do not acknowledge |
//! | [`claim`] | being the only one that does something |
//! | [`report`] | the account at exit |
//! | [`memory`], [`file_size`], [`shutdown`], `timers` | the ceilings; the signals; the timers' thread |
//! | `shared` | what these parts share |
//! | `watchdog` | whether the middleware still runs |
//! | [`testing`] | a DDS domain of one's own |

pub mod action_client;
pub mod action_server;
mod answers;
pub mod args;
mod bad_argument;
pub mod claim;
mod clock;
mod clock_source;
mod definition;
pub mod diagnostics;
mod discovered;
mod discovery_news;
pub mod domain;
mod endpoint;
pub mod file_size;
mod goals;
mod intake;
mod lifecycle;
mod log_file;
mod log_format;
mod logger_levels;
pub mod logging;
mod losses;
pub mod memory;
mod name_rules;
pub mod names;
mod parameters;
pub mod publisher;
pub mod qos;
pub mod raw;
pub mod report;
pub mod runtime;
mod security;
pub mod service;
mod share;
mod shared;
pub mod shutdown;
mod subscription;
pub mod testing;
mod timers;
mod type_description;
mod waiting;
mod watchdog;

use std::process::ExitCode;

use planesman_text::shown;

pub use action_client::ActionClient;
pub use action_server::{Goal, GoalId, GoalStatus};
pub use args::RosArguments;
pub use claim::Claim;
pub use definition::{Definition, Definitions};
pub use diagnostics::{Connection, Connections, Level};
pub use discovered::{Offer, PublishedTopic};
pub use domain::Domain;
pub use endpoint::Direction;
pub use intake::Intake;
pub use lifecycle::{Change, Lifecycle};
pub use losses::Losses;
pub use parameters::{STRICT_PARAMETERS, message_of, value_of};
pub use publisher::Publisher;
pub use qos::Qos;
pub use raw::RawSample;
pub use report::ExitReport;
pub use runtime::{Flow, Next, NodeSpec, Runtime, Timer};
pub use service::{Client, Responder};

/// Runs a program: what it fails with becomes one line on stderr and exit status 1.
#[must_use]
pub fn exit_code(program: &str, run: impl FnOnce() -> anyhow::Result<()>) -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain!("{program}: {}", shown(in_one_line(&error)));
            ExitCode::FAILURE
        }
    }
}

/// What an error has to say at most, in characters: a value of a file is quoted whole, however long it is.
const ERROR: usize = 4000;

/// An error with its causes, each said once: many a message ends with its cause already. Of more than 4,000
/// characters the middle is left out.
#[must_use]
pub fn in_one_line(error: &anyhow::Error) -> String {
    let said = error
        .chain()
        .map(ToString::to_string)
        .fold(String::new(), |said, cause| {
            if said.is_empty() {
                cause
            } else if said.ends_with(&cause) {
                said
            } else {
                format!("{said}: {cause}")
            }
        });
    let omitted = said.chars().count().saturating_sub(ERROR);
    if omitted == 0 {
        return said;
    }
    let place = |character: usize| {
        said.char_indices()
            .nth(character)
            .map_or(said.len(), |(at, _)| at)
    };
    let (end, start) = (place(ERROR / 2), place(ERROR / 2 + omitted));
    format!("{} [{omitted} characters] {}", &said[..end], &said[start..])
}

/// Prints a line of what a command has to say, as [`print()`] does.
#[macro_export]
macro_rules! say {
    ($($argument:tt)*) => {
        $crate::print(format_args!("{}\n", format_args!($($argument)*)))
    };
}

/// Writes a line to standard error, as `eprintln!` does; where that cannot be written, as on a full
/// disk, nobody is left to tell, and the program goes on.
#[macro_export]
macro_rules! complain {
    ($($argument:tt)*) => {
        $crate::write_complaint(format_args!("{}\n", format_args!($($argument)*)))
    };
}

/// Writes to standard error what [`complain!`] has to say.
pub fn write_complaint(text: std::fmt::Arguments<'_>) {
    use std::io::Write as _;
    let _ = std::io::stderr().write_fmt(text);
}

/// Prints the output of a command, with foreign names and texts made harmless ([`shown`]). A reader that has read
/// enough (`| head`) is no error, nor is a terminal that was closed.
///
/// # Errors
/// When standard output cannot be written, as on a full disk.
pub fn print(text: impl std::fmt::Display) -> std::io::Result<()> {
    use std::io::Write as _;
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    match write!(out, "{}", shown(text)).and_then(|()| out.flush()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe || is_gone(&error) => Ok(()),
        result => result,
    }
}

/// Whether standard output is a terminal that was closed. Of a file the same error is the disk's.
fn is_gone(error: &std::io::Error) -> bool {
    use rustix::{fs, io::Errno};
    let kind = |it: fs::Stat| fs::FileType::from_raw_mode(it.st_mode);
    error.raw_os_error() == Some(Errno::IO.raw_os_error())
        && fs::fstat(std::io::stdout()).is_ok_and(|it| kind(it) == fs::FileType::CharacterDevice)
}

#[cfg(test)]
mod tests {
    use super::in_one_line;
    use anyhow::anyhow;

    #[test]
    fn a_cause_that_the_message_ends_with_is_said_once() {
        let twice = anyhow!("missing field")
            .context("file: missing field")
            .context("scenario");
        assert_eq!(in_one_line(&twice), "scenario: file: missing field");
        assert_eq!(in_one_line(&anyhow!("b").context("a")), "a: b");
    }

    #[test]
    fn of_a_long_error_its_start_and_its_end_are_said() {
        let value = "ü".repeat(100_000);
        let error = anyhow!("{value}, expected f64").context("file");
        let said = in_one_line(&error);
        assert!(said.starts_with("file: ü"), "{said}");
        assert!(said.ends_with("ü, expected f64"), "{said}");
        assert!(said.contains(" [96020 characters] "), "{said}");
    }
}
