//! The types of this crate as messages of `type_description_interfaces`, with the texts of their definitions.

use std::sync::OnceLock;

use planesman_rosidl::{
    Library, TypeName, described_fields, parse_action, parse_message, parse_service,
};

use crate::type_description_interfaces::msg::{
    Field, FieldType, IndividualTypeDescription, TypeDescription, TypeSource,
};

/// Package, kind, name and text of every definition.
const SOURCES: &[(&str, &str, &str, &str)] = include!(concat!(env!("OUT_DIR"), "/sources.rs"));

/// The description of a type.
#[derive(Debug, Clone, PartialEq)]
pub struct Described {
    /// `RIHS01_...`
    pub hash: String,
    /// The type and all types to which it refers.
    pub description: TypeDescription,
    /// The text of each of these.
    pub sources: Vec<TypeSource>,
}

/// Describes the message, service or action with this name, or a part of it (`std_srvs/srv/SetBool_Request`); `None` if this crate does not contain
/// the type.
#[must_use]
pub fn describe(type_name: &str) -> Option<Described> {
    let library = library();
    let name = TypeName::parse(type_name)?;
    let description = individual(library, &name)?;
    let references = library.dependencies(&name).ok()?;
    let sources = std::iter::once(&name).chain(references.iter().copied());
    Some(Described {
        hash: library.type_hash(&name).ok()?,
        sources: sources.map(|name| source(&name.to_string())).collect(),
        description: TypeDescription {
            type_description: description,
            referenced_type_descriptions: references
                .iter()
                .filter_map(|name| individual(library, name))
                .collect(),
        },
    })
}

/// Every definition, read once. The build has verified that all can be read.
fn library() -> &'static Library {
    static LIBRARY: OnceLock<Library> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let mut library = Library::new();
        for (package, kind, name, text) in SOURCES {
            let _ = match *kind {
                "msg" => parse_message(package, name, text).and_then(|it| library.add_message(it)),
                "srv" => parse_service(package, name, text).and_then(|it| library.add_service(it)),
                _ => parse_action(package, name, text).and_then(|it| library.add_action(it)),
            };
        }
        library
    })
}

fn individual(library: &Library, name: &TypeName) -> Option<IndividualTypeDescription> {
    let message = library.message(name)?;
    let field = |field: planesman_rosidl::FieldDescription| Field {
        name: field.name,
        r#type: FieldType {
            type_id: field.type_id,
            capacity: field.capacity.into(),
            string_capacity: field.string_capacity.into(),
            nested_type_name: field.nested_type_name,
        },
        default_value: field.default_value,
    };
    Some(IndividualTypeDescription {
        type_name: name.to_string(),
        fields: described_fields(message).map(field).collect(),
    })
}

/// The text of a definition; empty for a part of a service or action.
fn source(type_name: &str) -> TypeSource {
    let is_it = |(package, kind, name, _): &&(&str, &str, &str, &str)| {
        format!("{package}/{kind}/{name}") == type_name
    };
    let (encoding, text) = match SOURCES.iter().find(is_it) {
        Some((_, kind, _, text)) => (*kind, *text),
        None => ("implicit", ""),
    };
    TypeSource {
        type_name: type_name.to_owned(),
        encoding: encoding.to_owned(),
        raw_file_contents: text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planesman_msgs::{action::Manoeuvre, srv::Step};
    use crate::{Action, Service, registry};

    #[test]
    fn every_type_is_described_with_its_hash_and_its_source() {
        for info in registry() {
            let found = describe(info.type_name).expect(info.type_name);
            assert_eq!(found.hash, info.type_hash);
            assert_eq!(found.sources[0].encoding, "msg");
            assert!(
                !found.sources[0].raw_file_contents.is_empty(),
                "{}",
                info.type_name
            );
            let described = 1 + found.description.referenced_type_descriptions.len();
            assert_eq!(found.sources.len(), described);
        }
        for (name, hash, encoding) in [
            (Step::TYPE_NAME, Step::TYPE_HASH, "srv"),
            (Manoeuvre::TYPE_NAME, Manoeuvre::TYPE_HASH, "action"),
        ] {
            let found = describe(name).expect(name);
            assert_eq!(found.hash, hash);
            assert_eq!(found.sources[0].encoding, encoding);
            assert!(found.sources.iter().any(|part| part.encoding == "implicit"));
        }
        assert_eq!(describe("std_msgs/msg/Nothing"), None);
        assert_eq!(describe("std_msgs"), None);
    }

    #[test]
    fn a_default_is_written_as_rosidl_writes_it() {
        let fields = |name| {
            describe(name)
                .expect(name)
                .description
                .type_description
                .fields
        };
        let w = &fields("geometry_msgs/msg/Quaternion")[3];
        assert_eq!((w.name.as_str(), w.default_value.as_str()), ("w", "1.0"));
        let request = fields("type_description_interfaces/srv/GetTypeDescription_Request");
        assert_eq!(request[2].default_value, "True");
    }
}
