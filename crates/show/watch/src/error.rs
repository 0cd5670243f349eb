//! Errors of the page's server and of its requests.

use std::{io, net::SocketAddr};

use planesman_decode::{CompileError, path::PathError, schema::SchemaError};
use planesman_node::{BoxedError, DefinitionError};

/// The reason why the server failed, or why a request was refused.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An error of the node.
    #[error(transparent)]
    Node(#[from] planesman_node::Error),
    /// The server cannot listen on this address.
    #[error("cannot listen on {0}: {1}")]
    Listen(SocketAddr, io::Error),
    /// The system provides no socket or thread.
    #[error(transparent)]
    System(#[from] io::Error),
    /// The system provides no random number for the token.
    #[error(transparent)]
    Random(#[from] getrandom::Error),
    /// The definition of a topic's type is unknown.
    #[error(transparent)]
    Definition(#[from] DefinitionError),
    /// A type's definition cannot be read.
    #[error(transparent)]
    Schema(#[from] SchemaError),
    /// A type has no such field.
    #[error(transparent)]
    Field(#[from] CompileError),
    /// The text is not a field path.
    #[error("'{0}': {1}")]
    Path(String, PathError),
    /// The name of a channel has no colon.
    #[error("TOPIC:FIELD is expected as the name of a channel")]
    Channel,
    /// A channel's name is too long; contains the limit in bytes.
    #[error("the channel's name is too long: at most {0} bytes are allowed")]
    ChannelName(usize),
    /// The limit of channels is reached.
    #[error("at most {0} channels are allowed")]
    Channels(usize),
    /// The topic was refused before; contains the reason.
    #[error("{0}")]
    Refused(String),
    /// A service without a server.
    #[error("no node serves {0}")]
    NotServed(String),
    /// A node's answers contradict each other.
    #[error("the node returned parameters different from those it lists")]
    Parameters,
    /// The program cannot load the vehicle.
    #[error(transparent)]
    Vehicle(#[from] BoxedError),
    /// An error in a quantity of a manoeuvre, with its name.
    #[error("{0}: {1}")]
    Quantity(&'static str, Box<Self>),
    /// The text is not a number.
    #[error("'{0}' is not a number")]
    Number(String),
    /// The text is not a finite number.
    #[error("'{0}' is not a finite number")]
    NotFinite(String),
    /// The text is not a quantity of the dimension.
    #[error("'{text}': a number in {unit} is expected, or a number with one of the units {units}")]
    Unit {
        /// Text as sent by the page.
        text: String,
        /// Units of the dimension.
        units: String,
        /// Unit of the page.
        unit: String,
    },
    /// The text is not a Boolean value.
    #[error("'{0}' is neither true nor false")]
    Bool(String),
    /// The text is not an integer.
    #[error("'{0}' is not a whole number")]
    Integer(String),
    /// The text is not a list of the expected type.
    #[error("'{0}' is not a list of {1}, such as [.., ..]")]
    List(String, &'static str),
    /// An unknown type of `rcl_interfaces/msg/ParameterType`.
    #[error("unknown parameter type {0}")]
    ParameterType(u8),
}
