//! The errors of the identifier.

use planesman_decode::{CompileError, DecodeError, schema::SchemaError};
use planesman_identification::IdentificationError;
use planesman_signals::SignalError;

/// A rejected input of the identifier; nothing changes then.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A parameter, or one that does not go together with others.
    #[error("parameter '{name}': {reason}")]
    Parameter {
        /// The parameter.
        name: &'static str,
        /// The value, and what would be accepted.
        reason: String,
    },
    /// An entry of the parameter `pairs`.
    #[error(
        "parameter 'pairs': '{text}' refused: {reason}; it is written NAME: INPUT -> OUTPUT [PARAMETER=VALUE ...], as in \
         heave: plane_motion:dive_planes -> state:heave order=2"
    )]
    Entry {
        /// The entry.
        text: String,
        /// The rule that it breaks.
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
    /// Messages of the type hold no such signal; the topic and the reason.
    #[error("{0}: {1}")]
    NoSignal(String, Box<CompileError>),
    /// The signal is a list with a name for each number; topic, field, field of the names.
    #[error(
        "{topic}: {path} is a list of numbers, one for each '{names}'; name one by its index or name, as {path}[0]"
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
    /// A message does not hold the signal as a finite number, or a list of such.
    #[error(transparent)]
    Signal(#[from] SignalError),
    /// A message that is refused; the sentence that names the signal.
    #[error("{0}")]
    Message(String),
}
