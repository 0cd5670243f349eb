//! A message definition as data: names, fields, constants and their comments.

use std::collections::BTreeSet;
use std::fmt;

/// Kind of a definition; the middle part of a type's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// From, or derived from, an `.action` file.
    Action,
    /// From a `.msg` file.
    Msg,
    /// From, or derived from, a `.srv` file.
    Srv,
}

impl Kind {
    /// All kinds, in alphabetical order.
    pub const ALL: [Self; 3] = [Self::Action, Self::Msg, Self::Srv];

    /// Name of the folder, the file extension and the name part: `msg`, `srv` or `action`.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Action => "action",
            Self::Msg => "msg",
            Self::Srv => "srv",
        }
    }

    fn parse(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.as_str() == text)
    }
}

/// A full ROS type name, such as `std_msgs/msg/Header`. Sorts like its text.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TypeName {
    /// The package, `std_msgs`.
    pub package: String,
    /// The kind, `msg`.
    pub kind: Kind,
    /// Name within the package, such as `Header`; derived types contain an underscore (`Fit_Request`).
    pub name: String,
}

impl TypeName {
    /// The name of a type in a package.
    #[must_use]
    pub fn new(package: &str, kind: Kind, name: &str) -> Self {
        Self {
            package: package.to_owned(),
            kind,
            name: name.to_owned(),
        }
    }

    /// Parses `package/Type` or `package/kind/Type`; `None` for anything else.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let parts: Vec<&str> = text.split('/').collect();
        let (package, kind, name) = match parts[..] {
            [package, name] => (package, Kind::Msg, name),
            [package, kind, name] => (package, Kind::parse(kind)?, name),
            _ => return None,
        };
        (is_name(package) && is_name(name)).then(|| Self::new(package, kind, name))
    }

    /// The name in schema texts: `package/Type` for messages, the full name for others.
    #[must_use]
    pub fn short(&self) -> String {
        match self.kind {
            Kind::Msg => format!("{}/{}", self.package, self.name),
            _ => self.to_string(),
        }
    }

    /// DDS type name, such as `std_msgs::msg::dds_::Header_`.
    #[must_use]
    pub fn dds(&self) -> String {
        format!(
            "{}::{}::dds_::{}_",
            self.package,
            self.kind.as_str(),
            self.name
        )
    }

    /// The name with a suffix, for derived types: `Fit` and `Request` give `Fit_Request`.
    #[must_use]
    pub fn derived(&self, suffix: &str) -> Self {
        Self {
            name: format!("{}_{suffix}", self.name),
            ..self.clone()
        }
    }
}

impl fmt::Display for TypeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.package, self.kind.as_str(), self.name)
    }
}

/// Whether a text is an identifier: a letter, then letters, digits and underscores.
///
/// This rule is wider than rosidl's rule for new definitions (lower-case fields, upper-case constants), because foreign bags contain older
/// definitions.
#[must_use]
pub fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic())
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// The primitive types other than strings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Primitive {
    /// `bool`
    Bool,
    /// `byte`: an opaque octet.
    Byte,
    /// `char`: in ROS 2 an unsigned 8-bit number.
    Char,
    /// `int8`
    Int8,
    /// `uint8`
    Uint8,
    /// `int16`
    Int16,
    /// `uint16`
    Uint16,
    /// `int32`
    Int32,
    /// `uint32`
    Uint32,
    /// `int64`
    Int64,
    /// `uint64`
    Uint64,
    /// `float32`
    Float32,
    /// `float64`
    Float64,
}

impl Primitive {
    const NAMES: [(&'static str, Self); 13] = [
        ("bool", Self::Bool),
        ("byte", Self::Byte),
        ("char", Self::Char),
        ("int8", Self::Int8),
        ("uint8", Self::Uint8),
        ("int16", Self::Int16),
        ("uint16", Self::Uint16),
        ("int32", Self::Int32),
        ("uint32", Self::Uint32),
        ("int64", Self::Int64),
        ("uint64", Self::Uint64),
        ("float32", Self::Float32),
        ("float64", Self::Float64),
    ];

    /// The primitive with this ROS name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        let (_, found) = Self::NAMES.into_iter().find(|(text, _)| *text == name)?;
        Some(found)
    }

    /// The ROS name.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        Self::NAMES
            .into_iter()
            .find(|(_, primitive)| *primitive == self)
            .map_or("", |(name, _)| name)
    }

    /// Smallest and largest value of integer types; `None` for others.
    #[must_use]
    pub fn integer_range(self) -> Option<(i128, i128)> {
        match self {
            Self::Byte | Self::Char | Self::Uint8 => Some((0, u8::MAX.into())),
            Self::Int8 => Some((i8::MIN.into(), i8::MAX.into())),
            Self::Int16 => Some((i16::MIN.into(), i16::MAX.into())),
            Self::Uint16 => Some((0, u16::MAX.into())),
            Self::Int32 => Some((i32::MIN.into(), i32::MAX.into())),
            Self::Uint32 => Some((0, u32::MAX.into())),
            Self::Int64 => Some((i64::MIN.into(), i64::MAX.into())),
            Self::Uint64 => Some((0, u64::MAX.into())),
            Self::Bool | Self::Float32 | Self::Float64 => None,
        }
    }
}

/// The type of one element of a field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Element {
    /// A number or a Boolean.
    Primitive(Primitive),
    /// `string` or `wstring`, with its bound.
    String {
        /// Whether the string is a `wstring`: UTF-16 on the wire.
        wide: bool,
        /// The bound of `string<=N`.
        bound: Option<u32>,
    },
    /// Another message.
    Message(TypeName),
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Primitive(primitive) => f.write_str(primitive.as_str()),
            Self::String { wide, bound } => {
                f.write_str(if *wide { "wstring" } else { "string" })?;
                bound.map_or(Ok(()), |bound| write!(f, "<={bound}"))
            }
            Self::Message(name) => f.write_str(&name.short()),
        }
    }
}

/// Number of elements of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arity {
    /// A single value: `T`.
    One,
    /// A fixed number: `T[3]`.
    Array(u32),
    /// Any number: `T[]`.
    Sequence,
    /// At most this number: `T[<=3]`.
    BoundedSequence(u32),
}

/// The type of a field.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldType {
    /// Type of each element.
    pub element: Element,
    /// Number of elements.
    pub arity: Arity,
}

impl fmt::Display for FieldType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.element)?;
        match self.arity {
            Arity::One => Ok(()),
            Arity::Array(size) => write!(f, "[{size}]"),
            Arity::Sequence => f.write_str("[]"),
            Arity::BoundedSequence(bound) => write!(f, "[<={bound}]"),
        }
    }
}

/// A constant's value or a field's default.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A `bool`.
    Bool(bool),
    /// An integer, within the range of its type.
    Integer(i128),
    /// A `float32` or `float64`; may be infinite or NaN.
    Float(f64),
    /// A `string` or `wstring`.
    String(String),
    /// An array or sequence.
    List(Vec<Value>),
}

/// A field of a message.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// The field's name.
    pub name: String,
    /// The field's type.
    pub field_type: FieldType,
    /// Initial value, if it is not the type's zero.
    pub default: Option<Value>,
    /// Comment lines of the field, without `#`.
    pub comment: Vec<String>,
    /// Line number, from 1; 0 for derived fields.
    pub line: usize,
}

/// One constant of a message.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// The constant's name.
    pub name: String,
    /// Type of the constant, a primitive or a string.
    pub element: Element,
    /// Its value.
    pub value: Value,
    /// Comment lines of the constant, without `#`.
    pub comment: Vec<String>,
}

/// The field that rosidl adds to an empty message, because a C struct cannot be empty.
pub const EMPTY_MESSAGE_FIELD: &str = "structure_needs_at_least_one_member";

/// A message, or a part of a service or action.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// The full name.
    pub name: TypeName,
    /// Comment block at the top, without `#`.
    pub comment: Vec<String>,
    /// Constants in the order of the text.
    pub constants: Vec<Constant>,
    /// Fields in the order of the text; never empty (see [`EMPTY_MESSAGE_FIELD`]).
    pub fields: Vec<Field>,
    /// Text of the definition.
    pub text: String,
    /// Source of the text, for error messages.
    pub file: String,
}

impl Message {
    /// The messages used by the fields, each with the line of the first such field.
    #[must_use]
    pub fn references(&self) -> Vec<(&TypeName, usize)> {
        let mut seen = BTreeSet::new();
        let mut found = Vec::new();
        for field in &self.fields {
            if let Element::Message(name) = &field.field_type.element
                && seen.insert(name)
            {
                found.push((name, field.line));
            }
        }
        found
    }
}

/// A service: a request and a response.
#[derive(Debug, Clone, PartialEq)]
pub struct Service {
    /// The full name, `package/srv/Name`.
    pub name: TypeName,
    /// The request of the client.
    pub request: Message,
    /// The response of the server.
    pub response: Message,
}

/// An action: goal, result and feedback.
#[derive(Debug, Clone, PartialEq)]
pub struct Action {
    /// The full name, `package/action/Name`.
    pub name: TypeName,
    /// The request.
    pub goal: Message,
    /// The result.
    pub result: Message,
    /// The feedback.
    pub feedback: Message,
}
