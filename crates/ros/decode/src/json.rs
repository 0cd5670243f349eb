//! Messages that are JSON objects, for example in MCAP files of programs other than ROS; their type is inferred from the first few messages.

use std::collections::BTreeMap;

use planesman_rosidl::definition::is_name;
use serde_json::{Map, Value};

use crate::cursor::DecodeError;
use crate::schema::{self, SchemaError, Types};

/// Largest object that is parsed, bytes; parsing takes some twenty times its size in memory.
const LONGEST: usize = 1 << 20;

/// Name of the root type.
const ROOT: &str = "json/msg/Object";

/// The type of these objects, with all members that occur in at least one of them. Numbers are `float64`; a `header` with a stamp becomes ROS's
/// header.
///
/// # Errors
/// No objects, a value that is not an object, or members nested too deeply.
pub fn types<P: AsRef<[u8]>>(objects: impl IntoIterator<Item = P>) -> Result<Types, SchemaError> {
    let mut all = Map::new();
    for object in objects {
        let Ok(Value::Object(members)) = object_of(object.as_ref()) else {
            return Err(SchemaError::NotJson);
        };
        merge(&mut all, members);
    }
    let mut texts = vec![String::new()];
    define(&all, 0, &mut texts);
    let mut text = texts.remove(0);
    let mut named = BTreeMap::new();
    for (number, fields) in texts.iter().enumerate() {
        named.insert(name_of(number + 1, fields), fields);
    }
    for (name, fields) in named {
        text += &format!("{}\nMSG: {name}\n{fields}", "=".repeat(80));
    }
    let mut types = schema::read(ROOT, "ros2msg", &text)?;
    types.is_json = true;
    Ok(types)
}

/// Parses a payload as an object.
pub(crate) fn object_of(payload: &[u8]) -> Result<Value, DecodeError> {
    match payload.len() > LONGEST {
        true => Err(DecodeError::Json),
        false => serde_json::from_slice(payload).map_err(|_| DecodeError::Json),
    }
}

fn merge(into: &mut Map<String, Value>, from: Map<String, Value>) {
    for (name, value) in from {
        match (into.get_mut(&name), value) {
            (Some(Value::Object(known)), Value::Object(new)) => merge(known, new),
            (Some(Value::Array(known)), Value::Array(new)) if known.is_empty() => *known = new,
            (Some(Value::Null) | None, value) => drop(into.insert(name, value)),
            _ => {}
        }
    }
}

/// Writes the definition of an object's type at `place`, followed by the definitions of its members.
fn define(object: &Map<String, Value>, place: usize, texts: &mut Vec<String>) {
    for (name, value) in object.iter().filter(|it| is_name(it.0)) {
        let (one, list) = match value {
            Value::Array(elements) => (elements.first(), "[]"),
            one => (Some(one), ""),
        };
        let type_name = match one {
            Some(Value::Number(_)) => "float64".to_owned(),
            Some(Value::Bool(_)) => "bool".to_owned(),
            Some(Value::String(_)) => "string".to_owned(),
            Some(Value::Object(members)) => {
                let place = texts.len();
                texts.push(String::new());
                define(members, place, texts);
                name_of(place, &texts[place])
            }
            _ => continue,
        };
        texts[place] += &format!("{type_name}{list} {name}\n");
    }
}

/// Name of a type; header and stamp get the names of ROS.
fn name_of(number: usize, fields: &str) -> String {
    match fields {
        "float64 nanosec\nfloat64 sec\n" => "builtin_interfaces/Time".to_owned(),
        "string frame_id\nbuiltin_interfaces/Time stamp\n" => "std_msgs/Header".to_owned(),
        _ => format!("json/Object{number}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Catalogue, Decoder, Values};

    #[test]
    fn numbers_of_objects_are_read_by_the_paths_of_messages() {
        let objects = [
            r#"{"header": {"stamp": {"sec": 3, "nanosec": 5}, "frame_id": "a"}, "on": null, "t": {"sec": 1, "nanosec": 2}}"#,
            r#"{"v": [1, 2.5], "on": true, "list": [{"name": "x", "k": 1}, {"name": "y", "k": 2}], "odd name": 1}"#,
        ];
        let types = types(objects).unwrap();
        assert_eq!(types.stamp().unwrap().to_string(), "header.stamp");
        let fields = Catalogue::of(&types, 100).fields;
        assert!(fields.iter().any(|it| it.to_string() == "list[0].k"));
        let paths = ["v[1]", "on", "list[y].k", "header.stamp.sec"];
        let paths = paths.map(|it| it.parse().unwrap());
        let decoder = Decoder::compile_with_identities(&types, &paths).unwrap();
        let mut values = Values::default();
        decoder.read(objects[1].as_bytes(), &mut values).unwrap();
        let numbers = [0, 1, 2, 3].map(|it| values.number(it));
        assert_eq!(numbers, [Some(2.5), Some(1.0), Some(2.0), None]);
        assert_eq!(decoder.read(b"{", &mut values), Err(DecodeError::Json));
        assert!(types_of("[1]").is_err() && types_of(&"[".repeat(1000)).is_err());
        let deep = (0..100).fold("1".to_owned(), |of, _| format!("{{\"a\": {of}}}"));
        assert!(types_of(&deep).is_err());
    }

    fn types_of(text: &str) -> Result<Types, SchemaError> {
        types([text])
    }
}
