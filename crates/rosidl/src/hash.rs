//! RIHS01, the type hash of ROS 2 (REP-2011 and REP-2016).
//!
//! The hash is the SHA-256 of a JSON text that describes the type and, sorted by name, every type it
//! refers to; its layout is that of `type_description_interfaces/msg/TypeDescription` without default
//! values, its spacing that of Python's `json.dumps`. Constants, defaults and comments do not enter.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use crate::definition::{Arity, Element, Message, Primitive, TypeName};
use crate::error::Error;
use crate::library::Library;

impl Library {
    /// The type hash of a message, service or action: `RIHS01_` and 64 hexadecimal digits.
    ///
    /// # Errors
    /// A type that is not in the library.
    pub fn type_hash(&self, name: &TypeName) -> Result<String, Error> {
        let mut hash = String::from("RIHS01_");
        for byte in Sha256::digest(self.type_description(name)?) {
            // Writing to a String cannot fail.
            let _ = write!(hash, "{byte:02x}");
        }
        Ok(hash)
    }

    /// The JSON text that [`Library::type_hash`] hashes.
    ///
    /// # Errors
    /// A type that is not in the library.
    pub fn type_description(&self, name: &TypeName) -> Result<String, Error> {
        let own = describe(self.expect_message(name)?);
        let mut referenced = Vec::new();
        for reference in self.dependencies(name)? {
            referenced.push(describe(self.expect_message(reference)?));
        }
        Ok(format!(
            r#"{{"type_description": {own}, "referenced_type_descriptions": [{}]}}"#,
            referenced.join(", ")
        ))
    }
}

// Names hold nothing that JSON would escape: they are identifiers.
fn describe(message: &Message) -> String {
    let fields: Vec<String> = message
        .fields
        .iter()
        .map(|field| {
            let (offset, capacity) = match field.field_type.arity {
                Arity::One => (0, 0),
                Arity::Array(size) => (48, size),
                Arity::BoundedSequence(bound) => (96, bound),
                Arity::Sequence => (144, 0),
            };
            let (type_id, string_capacity, nested) = match &field.field_type.element {
                Element::Primitive(primitive) => (primitive_id(*primitive), 0, String::new()),
                Element::String { wide, bound } => {
                    let unbounded_id = if *wide { 18 } else { 17 };
                    let bounded_id = unbounded_id + 4;
                    let id = if bound.is_some() {
                        bounded_id
                    } else {
                        unbounded_id
                    };
                    (id, bound.unwrap_or(0), String::new())
                }
                Element::Message(name) => (1, 0, name.to_string()),
            };
            format!(
                concat!(
                    r#"{{"name": "{}", "type": {{"type_id": {}, "capacity": {}, "#,
                    r#""string_capacity": {}, "nested_type_name": "{}"}}}}"#
                ),
                field.name,
                type_id + offset,
                capacity,
                string_capacity,
                nested
            )
        })
        .collect();
    format!(
        r#"{{"type_name": "{}", "fields": [{}]}}"#,
        message.name,
        fields.join(", ")
    )
}

/// The constants of `type_description_interfaces/msg/FieldType`. rosidl turns `char` into `uint8`
/// before it describes a type, so 13 (`FIELD_TYPE_CHAR`) never comes from a `.msg` file.
fn primitive_id(primitive: Primitive) -> u32 {
    match primitive {
        Primitive::Int8 => 2,
        Primitive::Uint8 | Primitive::Char => 3,
        Primitive::Int16 => 4,
        Primitive::Uint16 => 5,
        Primitive::Int32 => 6,
        Primitive::Uint32 => 7,
        Primitive::Int64 => 8,
        Primitive::Uint64 => 9,
        Primitive::Float32 => 10,
        Primitive::Float64 => 11,
        Primitive::Bool => 15,
        Primitive::Byte => 16,
    }
}
