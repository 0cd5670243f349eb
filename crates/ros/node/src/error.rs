//! Errors of nodes.

use std::{fmt::Display, io, time::Duration};

use planesman_parameters::Refusal;

use crate::bad_argument::BadArgument;

/// Result type of this crate.
pub(crate) type Result<T, E = Error> = std::result::Result<T, E>;

/// Any error of a program built on this crate.
pub type BoxedError = Box<dyn std::error::Error + Send + Sync>;

/// The reason why a node did not start, or why an operation failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An invalid argument or name.
    #[error(transparent)]
    Argument(#[from] BadArgument),
    /// A parameter value is not allowed by the parameter's declaration.
    #[error(transparent)]
    Parameter(#[from] Refusal),
    /// Parameter values violate a rule of the node.
    #[error("parameters: {0}")]
    Parameters(BoxedError),
    /// A parameter file cannot be read, or is invalid.
    #[error("--params-file {path}: {reason}")]
    ParameterFile {
        /// As given.
        path: String,
        /// The reason.
        reason: String,
    },
    /// An invalid environment variable.
    #[error("{variable}: {reason}")]
    Environment {
        /// Name of the variable, with a refused value.
        variable: String,
        /// What is expected.
        reason: String,
    },
    /// An error of the operating system.
    #[error("{what}: {reason}")]
    System {
        /// What failed.
        what: String,
        /// Error of the system.
        reason: io::Error,
    },
    /// The system provides no thread or no file for timers.
    #[error("the system does not allow another thread or file for timers (see ulimit -u and -n)")]
    Timers,
    /// The machine's time cannot be represented in DDS timestamps.
    #[error("this machine's clock is {0}: set it")]
    Clock(&'static str),
    /// The middleware refuses a name.
    #[error("{name}: {reason}")]
    Name {
        /// The name.
        name: String,
        /// The reason.
        reason: String,
    },
    /// Invalid ROS type name.
    #[error("'{name}': {form}")]
    TypeName {
        /// As given.
        name: String,
        /// Expected form.
        form: &'static str,
    },
    /// The loop has no topic with this name and type.
    #[error("the loop has no topic '{topic}' of {type_name}")]
    NotOfTheLoop {
        /// The topic.
        topic: String,
        /// The requested type.
        type_name: &'static str,
    },
    /// An error of the middleware.
    #[error("{what}: {reason}")]
    Middleware {
        /// What failed.
        what: String,
        /// Error of the middleware.
        reason: String,
    },
    /// The node has been shut down.
    #[error("the node has shut down")]
    ShutDown,
    /// A fatal error of the middleware or the system.
    #[error("{0}")]
    Failed(String),
    /// A request contains a number that is not finite.
    #[error("{service}: request not {done}, because {field} is not finite")]
    NotFinite {
        /// The service or action.
        service: String,
        /// `called` or `asked`.
        done: &'static str,
        /// The field that is not finite.
        field: String,
    },
    /// There was no answer within the timeout.
    #[error("{service}: no answer within {timeout:?}")]
    NoAnswer {
        /// The service.
        service: String,
        /// The timeout.
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

    /// For `map_err`: converts an error of the operating system that occurred while doing `what`.
    pub(crate) fn system<E: Into<io::Error>>(what: impl Into<String>) -> impl FnOnce(E) -> Self {
        move |reason| Self::System {
            what: what.into(),
            reason: reason.into(),
        }
    }

    /// For `map_err`: converts the refusal of a name by the middleware.
    pub(crate) fn name<E: Display>(name: &str) -> impl FnOnce(E) -> Self {
        move |reason| Self::Name {
            name: name.to_owned(),
            reason: reason.to_string(),
        }
    }

    /// For `map_err`: converts an error of the middleware.
    pub(crate) fn middleware(reason: impl std::fmt::Debug) -> Self {
        Self::Middleware {
            what: "the middleware refuses".to_owned(),
            reason: format!("{reason:?}"),
        }
    }

    /// For `map_err`: converts the failure of a service call.
    pub(crate) fn call<E: Display>(service: &str) -> impl FnOnce(E) -> Self {
        move |reason| Self::Call {
            service: service.to_owned(),
            reason: reason.to_string(),
        }
    }
}
