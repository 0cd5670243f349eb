//! A message type with all types it uses, read from the text in a bag's channel.

use planesman_rosidl::definition::Element;
use planesman_rosidl::{Error, Library, Message, TypeName, parse_idl_schema, parse_schema};

/// A message type with all types it uses, checked: all are defined, none contains itself.
#[derive(Clone, Debug)]
pub struct Types {
    library: Library,
    root: TypeName,
    /// Whether the messages are JSON objects.
    pub(crate) is_json: bool,
}

/// Largest schema that is read, bytes; the largest standard message has 30 000 with all types it uses.
const LONGEST: usize = 1 << 20;

/// The reason why a schema cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SchemaError {
    /// A language other than `ros2msg` and `ros2idl`.
    #[error("the schema language '{0}' is not supported; supported: ros2msg, ros2idl")]
    Encoding(String),
    /// A text larger than the limit.
    #[error("the schema has {0} bytes; the limit is {LONGEST}")]
    TooLong(usize),
    /// A message that should be a JSON object and is not.
    #[error("the topic's messages are not JSON objects")]
    NotJson,
    /// A text that violates a rule.
    #[error(transparent)]
    Text(#[from] Error),
}

/// Reads the schema of `type_name` (`std_msgs/msg/Float64`), written in `encoding` (`ros2msg` or `ros2idl`).
///
/// # Errors
/// An unsupported language, or a text that violates a rule, with its line.
pub fn read(type_name: &str, encoding: &str, text: &str) -> Result<Types, SchemaError> {
    if text.len() > LONGEST {
        return Err(SchemaError::TooLong(text.len()));
    }
    let library = match encoding {
        "ros2msg" => parse_schema(type_name, text)?,
        "ros2idl" => parse_idl_schema(type_name, text)?,
        other => return Err(SchemaError::Encoding(other.escape_default().to_string())),
    };
    Ok(Types::of(library, type_name)?)
}

impl Types {
    /// The type `root` of a library.
    ///
    /// # Errors
    /// The library fails [`Library::check`] or does not contain the type.
    pub fn of(library: Library, root: &str) -> Result<Self, Error> {
        let not_defined = || Error {
            file: root.to_owned(),
            line: 0,
            rule: planesman_rosidl::Rule::Unknown(root.to_owned()),
        };
        let root = TypeName::parse(root).ok_or_else(not_defined)?;
        library.check()?;
        library.expect_message(&root)?;
        Ok(Self {
            library,
            root,
            is_json: false,
        })
    }

    /// The type's name.
    #[must_use]
    pub fn root(&self) -> &TypeName {
        &self.root
    }

    /// Type hash, `RIHS01_...`, which identifies the version of a type.
    #[must_use]
    pub fn hash(&self) -> String {
        // The library was checked, and the root is in it.
        self.library.type_hash(&self.root).unwrap_or_default()
    }

    /// Whether the type contains a wide string at any depth.
    pub(crate) fn has_wide_text(&self) -> bool {
        let fields = self.library.messages().flat_map(|message| &message.fields);
        let mut elements = fields.map(|field| &field.field_type.element);
        elements.any(|element| matches!(element, Element::String { wide: true, .. }))
    }

    /// Definition of a type that is used here; `None` for others.
    #[must_use]
    pub(crate) fn message(&self, name: &TypeName) -> Option<&Message> {
        self.library.message(name)
    }
}
