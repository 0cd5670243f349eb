//! Errors of an interface definition, for its author.

use std::fmt;

/// How deep messages may be nested; keeps every walk over a definition shallow, also a foreign one.
pub const MAX_DEPTH: usize = 64;

/// An interface definition was refused: where, and by which rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// The definition: a file's path, or `package/msg/Name` for a text that came without one.
    pub file: String,
    /// The line, counted from 1; 0 where the whole file is meant.
    pub line: usize,
    /// The rule that was broken.
    pub rule: Rule,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line == 0 {
            write!(f, "{}: {}", self.file, self.rule)
        } else {
            write!(f, "{}:{}: {}", self.file, self.line, self.rule)
        }
    }
}

impl std::error::Error for Error {}

/// The rules a definition is held to.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Rule {
    /// A line that is neither a comment, a field nor a constant.
    #[error("`{0}` is neither a field (`type name [default]`) nor a constant (`type NAME=value`)")]
    NotADeclaration(String),
    /// A package, type, field or constant name with characters ROS does not allow.
    #[error("`{0}` is not a name: letters, digits and underscores, starting with a letter")]
    BadName(String),
    /// A type that is neither primitive nor a message name.
    #[error("`{0}` is not a type: a primitive, `Type` or `package/Type`")]
    BadType(String),
    /// An array or string bound that is not a positive 32-bit number.
    #[error("`{0}` is not a bound: a whole number from 1 to 4294967295")]
    BadBound(String),
    /// A constant or default that its type cannot hold.
    #[error("`{value}` is not a value of type {expected}")]
    BadValue {
        /// The text as written.
        value: String,
        /// The ROS type it should have been.
        expected: String,
    },
    /// A constant of a message or array type.
    #[error("a constant must be of a primitive type, not {0}")]
    BadConstantType(String),
    /// A default given to a field of a message type.
    #[error("a field of type {0} takes no default")]
    NoDefault(String),
    /// Two fields, two constants, or two definitions with one name.
    #[error("`{0}` is defined twice")]
    Duplicate(String),
    /// A service without one, or an action without two, separator lines.
    #[error("{found} separator lines (---) where {expected} belong")]
    Separators {
        /// How many the text has.
        found: usize,
        /// How many the kind of definition needs.
        expected: usize,
    },
    /// A schema section headed by something else than `MSG: package/Type`.
    #[error("`{0}` does not head a definition: `MSG: package/Type` does")]
    BadSectionHead(String),
    /// Something in an IDL text that is no IDL, or that ROS has no form for.
    #[error("`{0}` is not expected here, or is IDL that ROS has no form for")]
    NotIdl(String),
    /// A field whose type is defined nowhere.
    #[error("{0} is not defined")]
    Unknown(String),
    /// A message that contains itself, directly or through others.
    #[error("{0} contains itself")]
    Recursive(String),
    /// Messages nested deeper than [`MAX_DEPTH`].
    #[error("messages are nested more than {max} deep", max = MAX_DEPTH)]
    TooDeep,
    /// A definition that is valid but has no Rust counterpart here.
    #[error("no Rust source is generated for {0}")]
    NoRust(String),
    /// A file or folder that cannot be read.
    #[error("{0}")]
    Unreadable(String),
}

impl Rule {
    /// This rule, broken at `line` of `file`.
    pub(crate) fn at(self, file: &str, line: usize) -> Error {
        Error {
            file: file.to_owned(),
            line,
            rule: self,
        }
    }
}
