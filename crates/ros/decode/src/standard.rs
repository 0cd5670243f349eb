//! The definitions of the standard messages, for bags that hold none: those of Humble's sqlite3 storage, and MCAP files with an empty schema.
//!
//! Every message of Jazzy's packages from `std_msgs` to `control_msgs`, and those that Humble had otherwise. The texts are made by
//! `standard/make.py`, and parsed when a type is asked for.

use planesman_rosidl::definition::Kind;
use planesman_rosidl::{Library, TypeName, parse_message};

use crate::Types;

/// A message a line: `package/Type=TYPE NAME;TYPE NAME`.
const JAZZY: &str = include_str!("../standard/jazzy.txt");

/// Those that differ.
const HUMBLE: &str = include_str!("../standard/humble.txt");

/// The versions of a standard message type, the newest first; none of another type.
#[must_use]
pub fn versions(type_name: &str) -> Vec<Types> {
    let Some(root) = TypeName::parse(type_name).filter(|it| it.kind == Kind::Msg) else {
        return Vec::new();
    };
    let texts = [JAZZY, HUMBLE].into_iter();
    let versions = texts.filter(|text| fields(text, &root).is_some());
    versions.filter_map(|text| version(text, &root)).collect()
}

/// The names of all of them, as in `sensor_msgs/msg/Imu`.
pub fn names() -> impl Iterator<Item = String> {
    let names = JAZZY.lines().filter_map(|line| line.split_once('='));
    names.map(|(name, _)| name.replace('/', "/msg/"))
}

/// A type's fields in a text.
fn fields<'t>(text: &'t str, name: &TypeName) -> Option<&'t str> {
    let short = name.short();
    let mut lines = text.lines();
    lines.find_map(|line| line.strip_prefix(short.as_str())?.strip_prefix('='))
}

/// The type with all it refers to, by that text and else by the newest.
fn version(text: &str, root: &TypeName) -> Option<Types> {
    let mut library = Library::new();
    let mut wanted = vec![root.clone()];
    while let Some(name) = wanted.pop() {
        if library.message(&name).is_some() {
            continue;
        }
        let fields = fields(text, &name).or_else(|| fields(JAZZY, &name))?;
        let text = fields.replace(';', "\n");
        let message = parse_message(&name.package, &name.name, &text).ok()?;
        wanted.extend(message.references().into_iter().map(|it| it.0.clone()));
        library.add_message(message).ok()?;
    }
    Types::of(library, &root.to_string()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_standard_message_is_there_with_all_it_refers_to() {
        assert!(names().count() > 170);
        for name in names() {
            let types = versions(&name);
            assert!(!types.is_empty(), "{name}");
            assert_eq!(types[0].root().to_string(), name);
        }
        assert_eq!(versions("sensor_msgs/msg/Range").len(), 2);
        assert!(versions("sensor_msgs/msg/Rang").is_empty());
    }

    #[test]
    fn those_that_the_project_uses_itself_are_the_same() {
        let mut compared = 0;
        for info in planesman_msgs::registry() {
            if let Some(types) = versions(info.type_name).first() {
                assert_eq!(types.hash(), info.type_hash, "{}", info.type_name);
                compared += 1;
            }
        }
        assert!(compared > 30, "{compared}");
    }
}
