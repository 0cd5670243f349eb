//! A message type with all it refers to, read from the text that a bag's channel holds.

use planesman_rosidl::definition::Element;
use planesman_rosidl::{Error, Library, Message, TypeName, parse_idl_schema, parse_schema};

/// A message type and every type it refers to, checked: all are defined, none contains itself.
#[derive(Clone, Debug)]
pub struct Types {
    library: Library,
    root: TypeName,
    /// Whether the messages are JSON objects.
    pub(crate) is_json: bool,
}

/// The longest text taken, bytes; the longest of the standard messages has 30 000 with all it refers to.
const LONGEST: usize = 1 << 20;

/// Why a schema cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SchemaError {
    /// Another language than `ros2msg` and `ros2idl`.
    #[error("its schema is written in '{0}'; ros2msg and ros2idl are read")]
    Encoding(String),
    /// A text longer than any definition.
    #[error("its schema has {0} bytes; at most {LONGEST} are taken")]
    TooLong(usize),
    /// A message that is to be a JSON object, and is none.
    #[error("its messages are no JSON objects")]
    NotJson,
    /// The text breaks a rule.
    #[error(transparent)]
    Text(#[from] Error),
}

/// Reads the schema of `type_name` (`std_msgs/msg/Float64`), written in `encoding` (`ros2msg` or `ros2idl`).
///
/// # Errors
/// Another encoding, or a text that breaks a rule, with its line.
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
    /// When the library does not pass [`Library::check`] or has no such type.
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

    /// The type's hash, `RIHS01_...`, by which versions of a type are told apart.
    #[must_use]
    pub fn hash(&self) -> String {
        // The library was checked, and the root is in it.
        self.library.type_hash(&self.root).unwrap_or_default()
    }

    /// Whether there is a wide string anywhere.
    pub(crate) fn has_wide_text(&self) -> bool {
        let fields = self.library.messages().flat_map(|message| &message.fields);
        let mut elements = fields.map(|field| &field.field_type.element);
        elements.any(|element| matches!(element, Element::String { wide: true, .. }))
    }

    /// The definition of a type that is referred to; `None` for no other.
    #[must_use]
    pub(crate) fn message(&self, name: &TypeName) -> Option<&Message> {
        self.library.message(name)
    }
}
