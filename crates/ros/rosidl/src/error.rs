//! Errors in an interface definition.

use std::fmt;

/// Maximum nesting depth of messages; limits recursion also for foreign definitions.
pub const MAX_DEPTH: usize = 64;

/// An error in an interface definition: place and rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    /// File path, or `package/msg/Name` for a text without a file.
    pub file: String,
    /// Line number, from 1; 0 for the whole file.
    pub line: usize,
    /// Violated rule.
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

/// Rules that a definition must satisfy.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Rule {
    /// A line that is neither a comment, a field nor a constant.
    #[error("`{0}` is neither a field (`type name [default]`) nor a constant (`type NAME=value`)")]
    NotADeclaration(String),
    /// A package, type, field or constant name with characters ROS does not allow.
    #[error(
        "`{0}` is not a name; letters, digits and underscores, starting with a letter, are expected"
    )]
    BadName(String),
    /// A type that is neither primitive nor a message name.
    #[error("`{0}` is not a type; expected: a primitive type, `Type` or `package/Type`")]
    BadType(String),
    /// An array or string bound that is not a positive 32-bit number.
    #[error("`{0}` is not a bound; a whole number from 1 to 4294967295 is expected")]
    BadBound(String),
    /// A constant or default that its type cannot hold.
    #[error("`{value}` is not a value of type {expected}")]
    BadValue {
        /// The text as written.
        value: String,
        /// Expected ROS type.
        expected: String,
    },
    /// A constant that is not of a primitive type.
    #[error("a constant must be of a primitive type, not {0}")]
    BadConstantType(String),
    /// A default for a field of a message type.
    #[error("a field of type {0} cannot have a default")]
    NoDefault(String),
    /// Two fields, constants or definitions with the same name.
    #[error("`{0}` is defined twice")]
    Duplicate(String),
    /// A wrong number of separator lines in a service (one) or an action (two).
    #[error("found {found} separator lines (---), expected {expected}")]
    Separators {
        /// Number found.
        found: usize,
        /// Number required.
        expected: usize,
    },
    /// A schema section without the heading `MSG: package/Type`.
    #[error("`{0}` is not the heading of a definition; `MSG: package/Type` is expected")]
    BadSectionHead(String),
    /// Invalid IDL, or IDL without an equivalent in ROS.
    #[error("`{0}` is not expected here, or has no equivalent in ROS")]
    NotIdl(String),
    /// A field of an undefined type.
    #[error("{0} is not defined")]
    Unknown(String),
    /// A message that contains itself, directly or through others.
    #[error("{0} contains itself")]
    Recursive(String),
    /// Messages nested deeper than [`MAX_DEPTH`].
    #[error("messages are nested more than {max} deep", max = MAX_DEPTH)]
    TooDeep,
    /// A valid definition for which no Rust code can be generated.
    #[error("no Rust code can be generated for {0}")]
    NoRust(String),
    /// A file or folder that cannot be read.
    #[error("{0}")]
    Unreadable(String),
}

impl Rule {
    /// An error for this rule at `line` of `file`.
    pub(crate) fn at(self, file: &str, line: usize) -> Error {
        Error {
            file: file.to_owned(),
            line,
            rule: self,
        }
    }
}
