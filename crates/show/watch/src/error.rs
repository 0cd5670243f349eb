//! Why the page is not served, or what it asks for is not done.

use std::{io, net::SocketAddr};

use planesman_decode::{CompileError, path::PathError, schema::SchemaError};
use planesman_node::{BoxedError, DefinitionError};

/// Why the page is not served, or what it asks for is not done.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The node.
    #[error(transparent)]
    Node(#[from] planesman_node::Error),
    /// The address cannot be listened at.
    #[error("cannot listen at {0}: {1}")]
    Listen(SocketAddr, io::Error),
    /// The system gives no socket, or no thread.
    #[error(transparent)]
    System(#[from] io::Error),
    /// The system gives no random number for the token.
    #[error(transparent)]
    Random(#[from] getrandom::Error),
    /// A topic's type is not known.
    #[error(transparent)]
    Definition(#[from] DefinitionError),
    /// A type's definition cannot be read.
    #[error(transparent)]
    Schema(#[from] SchemaError),
    /// A type has no such field.
    #[error(transparent)]
    Field(#[from] CompileError),
    /// A text that is no field's path.
    #[error("'{0}': {1}")]
    Path(String, PathError),
    /// A channel without a colon.
    #[error("a channel is written TOPIC:FIELD")]
    Channel,
    /// A channel's name is too long; the bytes that it may have.
    #[error("a channel's name has at most {0} bytes")]
    ChannelName(usize),
    /// There are as many channels as may be.
    #[error("{0} channels are kept already")]
    Channels(usize),
    /// A topic that was refused before, and why.
    #[error("{0}")]
    Refused(String),
    /// A service that nobody serves.
    #[error("no node serves {0}")]
    NotServed(String),
    /// A node's answers do not belong together.
    #[error("it answers for other parameters than it lists")]
    Parameters,
    /// The program does not know the vehicle.
    #[error(transparent)]
    Vehicle(#[from] BoxedError),
    /// A quantity of a manoeuvre, by its name.
    #[error("{0}: {1}")]
    Quantity(&'static str, Box<Self>),
    /// A text that is no number.
    #[error("'{0}' is no number")]
    Number(String),
    /// A text that is no finite number.
    #[error("'{0}' is no finite number")]
    NotFinite(String),
    /// A text that is no quantity of the dimension.
    #[error("'{text}' is no number of {units}, with its unit or, in {unit}, without")]
    Unit {
        /// As the page has it.
        text: String,
        /// The dimension's units.
        units: String,
        /// The page's unit.
        unit: String,
    },
    /// A text that is no Boolean value.
    #[error("'{0}' is neither true nor false")]
    Bool(String),
    /// A text that is no whole number.
    #[error("'{0}' is no whole number")]
    Integer(String),
    /// A text that is no list of what it should hold.
    #[error("'{0}' is no list of {1}: [.., ..]")]
    List(String, &'static str),
    /// No type of `rcl_interfaces/msg/ParameterType`.
    #[error("there is no parameter type {0}")]
    ParameterType(u8),
}
