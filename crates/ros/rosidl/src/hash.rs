//! RIHS01, the type hash of ROS 2 (REP-2011 and REP-2016).
//!
//! The hash is the SHA-256 of a JSON text that describes the type and all types it uses, sorted by name. The JSON has the layout of
//! `type_description_interfaces/msg/TypeDescription` without default values, with the spacing of Python's `json.dumps`. Constants, defaults and
//! comments are not included.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

use crate::definition::{Message, TypeName};
use crate::description::described_fields;
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
    let fields: Vec<String> = described_fields(message)
        .map(|field| {
            format!(
                concat!(
                    r#"{{"name": "{}", "type": {{"type_id": {}, "capacity": {}, "#,
                    r#""string_capacity": {}, "nested_type_name": "{}"}}}}"#
                ),
                field.name,
                field.type_id,
                field.capacity,
                field.string_capacity,
                field.nested_type_name
            )
        })
        .collect();
    format!(
        r#"{{"type_name": "{}", "fields": [{}]}}"#,
        message.name,
        fields.join(", ")
    )
}
