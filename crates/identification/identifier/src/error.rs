//! The errors of the identifier.

use planesman_decode::{CompileError, DecodeError, schema::SchemaError};
use planesman_identification::IdentificationError;
use planesman_signals::SignalError;

/// A refused input of the identifier; then nothing changes.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An invalid parameter, or a conflict with others.
    #[error("parameter '{name}': {reason}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// The value, and the allowed values.
        reason: String,
    },
    /// An entry of the parameter `pairs`.
    #[error(
        "invalid entry '{text}' of parameter 'pairs': {reason}; write NAME: INPUT -> OUTPUT \
         [PARAMETER=VALUE ...], as in heave: plane_motion:dive_planes -> state:heave order=2"
    )]
    Entry {
        /// The entry.
        text: String,
        /// The violated rule.
        reason: String,
    },
    /// A parameter of a further pair.
    #[error("pair '{name}': {reason}")]
    Pair {
        /// The pair.
        name: String,
        /// The error.
        reason: Box<Error>,
    },
    /// The estimator refuses its settings.
    #[error(transparent)]
    Estimator(#[from] IdentificationError),
    /// Messages of the type have no such signal; the topic and the reason.
    #[error("{0}: {1}")]
    NoSignal(String, Box<CompileError>),
    /// The signal is a list with a name for each number; topic, field, field of the names.
    #[error(
        "{topic}: {path} is a list with one number for each '{names}'. Choose one number by index or name, for example {path}[0]"
    )]
    List {
        /// The topic.
        topic: String,
        /// The field.
        path: String,
        /// The field with the names.
        names: String,
    },
    /// The definition of a message type cannot be read.
    #[error(transparent)]
    Schema(#[from] SchemaError),
    /// A payload is not a message of the type.
    #[error(transparent)]
    Payload(#[from] DecodeError),
    /// A message has no finite number or list for the signal.
    #[error(transparent)]
    Signal(#[from] SignalError),
    /// A refused message; the sentence names the signal.
    #[error("{0}")]
    Message(String),
}
