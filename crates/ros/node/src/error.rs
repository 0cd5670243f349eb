//! Why a node does not start, or cannot do what it is asked for.

use std::{fmt::Display, io, time::Duration};

use planesman_parameters::Refusal;

use crate::bad_argument::BadArgument;

/// The results of this crate.
pub(crate) type Result<T, E = Error> = std::result::Result<T, E>;

/// An error of any kind, of what is built on a node.
pub type BoxedError = Box<dyn std::error::Error + Send + Sync>;

/// Why a node does not start, or cannot do what it is asked for.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An argument, or a name.
    #[error(transparent)]
    Argument(#[from] BadArgument),
    /// A parameter against its declaration.
    #[error(transparent)]
    Parameter(#[from] Refusal),
    /// The parameters together, against the node's own rule.
    #[error("parameters: {0}")]
    Parameters(BoxedError),
    /// A parameter file that cannot be read, or holds something else.
    #[error("--params-file {path}: {reason}")]
    ParameterFile {
        /// As given.
        path: String,
        /// The reason.
        reason: String,
    },
    /// An environment variable.
    #[error("{variable}: {reason}")]
    Environment {
        /// Its name, with its value where that is refused.
        variable: String,
        /// What is expected.
        reason: String,
    },
    /// The operating system refuses.
    #[error("{what}: {reason}")]
    System {
        /// What cannot be done.
        what: String,
        /// The system's words.
        reason: io::Error,
    },
    /// The system gives no thread for timers, or no file.
    #[error("the system gives no thread, or no file, for timers (see ulimit -u and -n)")]
    Timers,
    /// The machine's clock cannot be told in DDS's timestamps.
    #[error("this machine's clock is {0}: set it")]
    Clock(&'static str),
    /// A name that the middleware refuses.
    #[error("{name}: {reason}")]
    Name {
        /// The name.
        name: String,
        /// The reason.
        reason: String,
    },
    /// What is not written as a type's name.
    #[error("'{name}': {form}")]
    TypeName {
        /// As given.
        name: String,
        /// How one is written.
        form: &'static str,
    },
    /// The loop has no such topic.
    #[error("the loop has no topic '{topic}' of {type_name}")]
    NotOfTheLoop {
        /// The topic.
        topic: String,
        /// The type asked for.
        type_name: &'static str,
    },
    /// The middleware refuses.
    #[error("{what}: {reason}")]
    Middleware {
        /// What it was to do.
        what: String,
        /// Its words.
        reason: String,
    },
    /// The node has been shut down.
    #[error("the node has shut down")]
    ShutDown,
    /// What the middleware or the system says as it fails.
    #[error("{0}")]
    Failed(String),
    /// A request with a number that is not finite.
    #[error("{service}: not {done}: {field} is not finite")]
    NotFinite {
        /// The service or action.
        service: String,
        /// `called` or `asked`.
        done: &'static str,
        /// The field.
        field: String,
    },
    /// No answer came in time.
    #[error("{service}: no answer within {timeout:?}")]
    NoAnswer {
        /// The service.
        service: String,
        /// The time waited.
        timeout: Duration,
    },
    /// A call failed.
    #[error("{service}: {reason}")]
    Call {
        /// The service.
        service: String,
        /// The reason.
        reason: String,
    },
}

impl Error {
    pub(crate) fn environment(variable: impl Into<String>, reason: impl Display) -> Self {
        Self::Environment {
            variable: variable.into(),
            reason: reason.to_string(),
        }
    }

    /// For `map_err`: the system refuses to do `what`.
    pub(crate) fn system<E: Into<io::Error>>(what: impl Into<String>) -> impl FnOnce(E) -> Self {
        move |reason| Self::System {
            what: what.into(),
            reason: reason.into(),
        }
    }

    /// For `map_err`: the middleware refuses the name.
    pub(crate) fn name<E: Display>(name: &str) -> impl FnOnce(E) -> Self {
        move |reason| Self::Name {
            name: name.to_owned(),
            reason: reason.to_string(),
        }
    }

    /// For `map_err`: the middleware refuses.
    pub(crate) fn middleware(reason: impl std::fmt::Debug) -> Self {
        Self::Middleware {
            what: "the middleware refuses".to_owned(),
            reason: format!("{reason:?}"),
        }
    }

    /// For `map_err`: the call of the service fails.
    pub(crate) fn call<E: Display>(service: &str) -> impl FnOnce(E) -> Self {
        move |reason| Self::Call {
            service: service.to_owned(),
            reason: reason.to_string(),
        }
    }
}
