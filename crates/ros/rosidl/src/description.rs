//! Descriptions of a message's fields in the form of `type_description_interfaces/msg/Field`.

use crate::definition::{Arity, Element, Field, Message, Primitive, Value};

/// Description of one field, as in `type_description_interfaces/msg/Field` and `FieldType`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldDescription {
    /// The field's name.
    pub name: String,
    /// Type number, one of the constants of `FieldType`.
    pub type_id: u8,
    /// Size of an array, bound of a bounded sequence, else 0.
    pub capacity: u32,
    /// Bound of a bounded string, else 0.
    pub string_capacity: u32,
    /// Name of a used message, else empty.
    pub nested_type_name: String,
    /// Default as written by rosidl's Python code (`True`, `1.0`); empty if there is no default.
    pub default_value: String,
}

/// The fields of `message`, in order.
pub fn described_fields(message: &Message) -> impl Iterator<Item = FieldDescription> {
    message.fields.iter().map(described)
}

fn described(field: &Field) -> FieldDescription {
    let (offset, capacity) = match field.field_type.arity {
        Arity::One => (0, 0),
        Arity::Array(size) => (48, size),
        Arity::BoundedSequence(bound) => (96, bound),
        Arity::Sequence => (144, 0),
    };
    let (type_id, string_capacity, nested_type_name) = match &field.field_type.element {
        Element::Primitive(primitive) => (primitive_id(*primitive), 0, String::new()),
        Element::String { wide, bound } => {
            let unbounded_id = if *wide { 18 } else { 17 };
            let id = unbounded_id + if bound.is_some() { 4 } else { 0 };
            (id, bound.unwrap_or(0), String::new())
        }
        Element::Message(name) => (1, 0, name.to_string()),
    };
    FieldDescription {
        name: field.name.clone(),
        type_id: type_id + offset,
        capacity,
        string_capacity,
        nested_type_name,
        default_value: field.default.as_ref().map(literal).unwrap_or_default(),
    }
}

fn literal(value: &Value) -> String {
    match value {
        Value::Bool(true) => "True".to_owned(),
        Value::Bool(false) => "False".to_owned(),
        Value::Integer(value) => value.to_string(),
        Value::Float(value) => format!("{value:?}"),
        Value::String(value) => value.clone(),
        Value::List(values) => {
            let values: Vec<String> = values.iter().map(literal).collect();
            format!("[{}]", values.join(", "))
        }
    }
}

/// Constants of `type_description_interfaces/msg/FieldType`. rosidl converts `char` to `uint8` before it describes a type, so 13
/// (`FIELD_TYPE_CHAR`) never results from a `.msg` file.
fn primitive_id(primitive: Primitive) -> u8 {
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
