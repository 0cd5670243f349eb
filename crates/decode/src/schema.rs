//! A message type with all it refers to, read from the text that a bag's channel holds.

use planesman_rosidl::definition::{Arity, Element, Field, Kind};
use planesman_rosidl::{Error, Library, Message, TypeName, parse_idl_schema, parse_schema};

use crate::{Decoder, FieldPath};

/// A message type and every type it refers to, checked: all are defined, none contains itself.
#[derive(Clone, Debug)]
pub struct Types {
    library: Library,
    root: TypeName,
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
        Ok(Self { library, root })
    }

    /// The type's name.
    #[must_use]
    pub fn root(&self) -> &TypeName {
        &self.root
    }

    /// Where messages of this type carry their stamp: `header.stamp`, or else the first field that
    /// is a `builtin_interfaces/Time`. It holds `sec` and `nanosec`. `None` for a type without, or one whose
    /// schema has a header or time of its own making.
    #[must_use]
    pub fn stamp(&self) -> Option<FieldPath> {
        let one = |field: &Field, package: &str, name: &str| {
            let wanted = TypeName::new(package, Kind::Msg, name);
            field.field_type.arity == Arity::One
                && field.field_type.element == Element::Message(wanted)
        };
        let fields = &self.message(&self.root)?.fields;
        let path = |field: &Field| field.name.parse::<FieldPath>().ok();
        let header = fields.iter().find(|it| one(it, "std_msgs", "Header"));
        let time = fields
            .iter()
            .find(|it| one(it, "builtin_interfaces", "Time"));
        let places = [
            header.and_then(path).map(|header| header.field("stamp")),
            time.and_then(path),
        ];
        let is_stamp = |place: &FieldPath| {
            let parts = ["sec", "nanosec"].map(|name| place.field(name));
            Decoder::compile(self, &parts).is_ok()
        };
        places.into_iter().flatten().find(is_stamp)
    }

    /// The field with the names of what the numbers of the list at `path` belong to, as in a
    /// `sensor_msgs/JointState`; `None` if `path` leads to a number, or a list whose elements have no names.
    #[must_use]
    pub fn names_of(&self, path: &FieldPath) -> Option<&str> {
        crate::decoder::names_of(self, path)
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
