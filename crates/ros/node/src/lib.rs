//! Runtime shared by all nodes of the suite.
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
//! fn run() -> Result<(), planesman_node::Error> {
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
//! | module | contents |
//! |---|---|
//! | [`runtime`] | the node: one thread, one event at a time |
//! | [`args`] | parsing of `--ros-args` |
//! | [`names`], `name_rules` | expanding, remapping and checking names |
//! | [`domain`] | `ROS_DOMAIN_ID` and the discovery range |
//! | `security` | `ROS_SECURITY_*` and enclaves |
//! | `parameters` | the six parameter services |
//! | `type_description` | `~/get_type_description` |
//! | [`qos`], `qos_overrides` | quality of service of ROS conventions, and overrides by parameters |
//! | [`publisher`], `subscription`, [`raw`] | publishing, subscribing, and subscribing without decoding |
//! | [`service`], `answers`, `waiting` | service servers and clients; pending answers |
//! | `share` | limit of the time spent on requests |
//! | `receive_limits` | limits of received bytes, and of the time spent on large messages |
//! | [`action_server`], [`action_client`], `goals` | action servers and clients; goals of a server |
//! | `endpoint` | a publisher or subscription: peers and counters |
//! | `error` | [`Error`] |
//! | `clock`, `clock_source` | machine time or `/clock` |
//! | [`logging`], `log_format`, `log_file` | console, file and `/rosout`; format of a line |
//! | `lifecycle` | managed nodes |
//! | `logger_levels` | the two services of log levels |
//! | [`diagnostics`] | writing and reading `/diagnostics` |
//! | `discovered` | topics published by others |
//! | `definition` | definitions of types published by others |
//! | `losses` | counting of missing messages |
//! | `discovery_events` | incompatible QoS, readers that do not acknowledge |
//! | [`claim`] | an exclusive role in a domain |
//! | [`report`] | the exit report: messages of each topic |
//! | [`memory`], [`file_size`], [`shutdown`], `timers` | memory and file size limits; signals; the timers' thread |
//! | `shared` | state shared by these modules |
//! | `watchdog` | check that the middleware runs |
//! | [`testing`] | a private DDS domain for tests |

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
mod discovery_events;
pub mod domain;
mod endpoint;
mod error;
pub mod file_size;
mod goals;
mod graph;
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
mod qos_overrides;
pub mod raw;
mod receive_limits;
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

use planesman_text::{in_one_line, shown};

pub use action_client::ActionClient;
pub use action_server::{Goal, GoalId, GoalStatus};
pub use args::RosArguments;
pub use claim::Claim;
pub use clock::wall as wall_time;
pub use definition::{Definition, DefinitionError, Definitions};
pub use diagnostics::{Connection, Connections, Level};
pub use discovered::{Offer, PublishedTopic};
pub use domain::Domain;
pub use endpoint::Direction;
pub use error::{BoxedError, Error};
pub use lifecycle::{Change, Lifecycle};
pub use losses::Losses;
pub use parameters::{STRICT_PARAMETERS, choices_in, message_of, value_of};
pub use publisher::{Publisher, RawPublisher};
pub use qos::Qos;
pub use raw::RawSample;
pub use receive_limits::ReceiveLimits;
pub use report::ExitReport;
pub use runtime::{Flow, Next, NodeSpec, Runtime, Timer};
pub use service::{Client, Responder};

/// Runs a program: prints an error as one line on stderr, with exit status 1.
#[must_use]
pub fn exit_code<E: Into<Box<dyn std::error::Error>>>(
    program: &str,
    run: impl FnOnce() -> Result<(), E>,
) -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            planesman_console::err!("{program}: {}", shown(in_one_line(error.into().as_ref())));
            ExitCode::FAILURE
        }
    }
}
