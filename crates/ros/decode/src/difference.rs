//! Compares two payloads of one type field by field.
//!
//! Both payloads are walked in step, so an equal field costs little. Values are exact: 64-bit integers are not rounded, and floating-point
//! numbers are equal if their bits are. Padding and byte order do not matter.

use std::fmt;

use planesman_rosidl::TypeName;
use planesman_rosidl::definition::{Arity, EMPTY_MESSAGE_FIELD, Element, Primitive};

use crate::Types;
use crate::cursor::{Cursor, DecodeError};

/// A value of a message, printed as by `ros2 topic echo`.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A `float64`.
    Float(f64),
    /// A `float32`.
    Single(f32),
    /// An integer.
    Integer(i128),
    /// A `bool`.
    Bool(bool),
    /// A string.
    Text(String),
    /// Length of a list.
    Length(u64),
}

impl Value {
    /// The value as a number; `None` for a text.
    #[must_use]
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Float(value) => Some(*value),
            Self::Single(value) => Some(f64::from(*value)),
            Self::Integer(value) => Some(*value as f64),
            Self::Bool(value) => Some(f64::from(u8::from(*value))),
            Self::Length(count) => Some(*count as f64),
            Self::Text(_) => None,
        }
    }

    /// Whether both are equal; floating-point numbers by their bits: NaN equals itself, and -0.0 differs from 0.0.
    #[must_use]
    pub fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Float(a), Self::Float(b)) => a.to_bits() == b.to_bits(),
            (Self::Single(a), Self::Single(b)) => a.to_bits() == b.to_bits(),
            _ => self == other,
        }
    }

    /// Number of floating-point numbers between the two (ulps); `None` for other values and for NaN.
    #[must_use]
    pub fn ulps(&self, other: &Self) -> Option<u64> {
        // Bits in the order of the numbers: -0.0 is next to 0.0.
        fn place(bits: i64, sign: i64) -> i64 {
            if bits < 0 { sign - bits - 1 } else { bits }
        }
        match (self, other) {
            (Self::Float(a), Self::Float(b)) if !a.is_nan() && !b.is_nan() => {
                let place = |it: &f64| place(it.to_bits() as i64, i64::MIN);
                Some(place(a).abs_diff(place(b)))
            }
            (Self::Single(a), Self::Single(b)) if !a.is_nan() && !b.is_nan() => {
                let place = |it: &f32| place(i64::from(it.to_bits() as i32), i64::from(i32::MIN));
                Some(place(a).abs_diff(place(b)))
            }
            _ => None,
        }
    }
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Float(value) => float(f, *value),
            Self::Single(value) => float(f, f64::from(*value)),
            Self::Integer(value) => write!(f, "{value}"),
            Self::Bool(value) => write!(f, "{value}"),
            Self::Text(text) => write!(f, "'{text}'"),
            Self::Length(1) => write!(f, "1 element"),
            Self::Length(count) => write!(f, "{count} elements"),
        }
    }
}

/// A number in Python's form: the fewest digits that give the same bits.
fn float(f: &mut fmt::Formatter<'_>, value: f64) -> fmt::Result {
    let size = value.abs();
    if !value.is_finite() {
        return match value {
            it if it.is_nan() => write!(f, "nan"),
            it if it > 0.0 => write!(f, "inf"),
            _ => write!(f, "-inf"),
        };
    }
    if size != 0.0 && !(1e-4..1e16).contains(&size) {
        let text = format!("{value:e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let sign = if exponent.starts_with('-') { '-' } else { '+' };
        let exponent = exponent.trim_start_matches('-');
        return write!(f, "{digits}e{sign}{exponent:0>2}");
    }
    write!(f, "{value:?}")
}

/// Position of a difference.
#[derive(Clone, Debug)]
pub struct Place<'t> {
    steps: Vec<Step<'t>>,
}

#[derive(Clone, Copy, Debug)]
enum Step<'t> {
    Field(&'t str),
    Index(u64),
}

impl Place<'_> {
    /// The path with `[]` for each list index, such as `rates[]`; the same for all elements.
    #[must_use]
    pub fn of_list(&self) -> String {
        self.written(false)
    }

    fn written(&self, with_indices: bool) -> String {
        let mut text = String::new();
        for step in &self.steps {
            match step {
                Step::Field(name) if text.is_empty() => text += name,
                Step::Field(name) => {
                    text.push('.');
                    text += name;
                }
                Step::Index(index) if with_indices => text += &format!("[{index}]"),
                Step::Index(_) => text += "[]",
            }
        }
        text
    }
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.written(true))
    }
}

/// Calls `take` for every differing field, in the order of the definition, with both values. For lists of different length the length
/// differs, and the common elements are compared.
///
/// # Errors
/// A payload that is not plain CDR, or ends before its last field; any payload of JSON types.
pub fn differences(
    types: &Types,
    [a, b]: [&[u8]; 2],
    take: &mut dyn FnMut(&Place<'_>, Value, Value),
) -> Result<(), DecodeError> {
    if types.is_json {
        return Err(DecodeError::Json);
    }
    let mut walk = Walk {
        types,
        a: cursor(types, a)?,
        b: cursor(types, b)?,
        place: Place { steps: Vec::new() },
        take,
    };
    walk.message(types.root())
}

/// The beginning of a payload, with the width of its wide strings that leaves fewer remaining bytes.
fn cursor<'p>(types: &Types, payload: &'p [u8]) -> Result<Cursor<'p>, DecodeError> {
    let cursor = Cursor::new(payload)?;
    if !types.has_wide_text() {
        return Ok(cursor);
    }
    let left = |cursor: &Cursor<'p>| {
        let mut walk = Walk {
            types,
            a: cursor.clone(),
            b: cursor.clone(),
            place: Place { steps: Vec::new() },
            take: &mut |_, _, _| {},
        };
        walk.message(types.root())
            .map_or(usize::MAX, |()| walk.a.left())
    };
    let other = cursor.clone().with_wide_characters(4);
    Ok(if left(&other) < left(&cursor) {
        other
    } else {
        cursor
    })
}

struct Walk<'t, 'p, 'f> {
    types: &'t Types,
    a: Cursor<'p>,
    b: Cursor<'p>,
    place: Place<'t>,
    take: &'f mut dyn FnMut(&Place<'_>, Value, Value),
}

impl<'t> Walk<'t, '_, '_> {
    fn message(&mut self, name: &TypeName) -> Result<(), DecodeError> {
        let fields = self.types.message(name).map_or(&[][..], |it| &it.fields);
        for field in fields {
            if field.name == EMPTY_MESSAGE_FIELD {
                self.element(&field.field_type.element)?;
                continue;
            }
            self.place.steps.push(Step::Field(&field.name));
            let element = &field.field_type.element;
            match field.field_type.arity {
                Arity::One => self.element(element)?,
                Arity::Array(count) => self.list(element, [count.into(); 2])?,
                Arity::Sequence | Arity::BoundedSequence(_) => {
                    let counts = [self.a.length()?, self.b.length()?];
                    let [a, b] = counts.map(Value::Length);
                    self.compare(a, b);
                    self.list(element, counts)?;
                }
            }
            self.place.steps.pop();
        }
        Ok(())
    }

    fn list(&mut self, element: &'t Element, counts: [u64; 2]) -> Result<(), DecodeError> {
        let [in_a, in_b] = counts;
        if let Element::Primitive(primitive) = element {
            let a = self.a.numbers(*primitive, in_a)?;
            let b = self.b.numbers(*primitive, in_b)?;
            if a.bytes() == b.bytes() {
                return Ok(());
            }
            for index in 0..in_a.min(in_b) {
                let at = index as usize;
                if let (Some(a), Some(b)) = (a.value(at), b.value(at)) {
                    self.place.steps.push(Step::Index(index));
                    self.compare(a, b);
                    self.place.steps.pop();
                }
            }
            return Ok(());
        }
        // Each element takes a byte at least, so that the payload's end ends the walk.
        for index in 0..in_a.max(in_b) {
            self.place.steps.push(Step::Index(index));
            if index >= in_b {
                // Passed in one payload: that is walked beside itself.
                let b = std::mem::replace(&mut self.b, self.a.clone());
                self.element(element)?;
                self.b = b;
            } else if index >= in_a {
                let a = std::mem::replace(&mut self.a, self.b.clone());
                self.element(element)?;
                self.a = a;
            } else {
                self.element(element)?;
            }
            self.place.steps.pop();
        }
        Ok(())
    }

    fn element(&mut self, element: &'t Element) -> Result<(), DecodeError> {
        match element {
            Element::Primitive(primitive) => {
                let a = self.a.numbers(*primitive, 1)?.value(0);
                let b = self.b.numbers(*primitive, 1)?.value(0);
                if let (Some(a), Some(b)) = (a, b) {
                    self.compare(a, b);
                }
            }
            Element::String { wide, .. } => {
                let (a, b) = (self.a.string(*wide)?, self.b.string(*wide)?);
                if a != b {
                    self.compare(Value::Text(a), Value::Text(b));
                }
            }
            Element::Message(name) => self.message(name)?,
        }
        Ok(())
    }

    fn compare(&mut self, a: Value, b: Value) {
        if !a.is(&b) {
            (self.take)(&self.place, a, b);
        }
    }
}

impl Types {
    /// Whether messages of this type have a field at this path; list elements are written `[]`, `[3]`, or without brackets.
    #[must_use]
    pub fn has_field(&self, path: &str) -> bool {
        let mut at = Some(self.root());
        path.split('.').all(|step| {
            let name = step.split('[').next().unwrap_or(step);
            let message = at.and_then(|it| self.message(it));
            let field = message.and_then(|it| it.fields.iter().find(|it| it.name == name));
            at = field.and_then(|it| match &it.field_type.element {
                Element::Message(name) => Some(name),
                _ => None,
            });
            field.is_some()
        })
    }
}

/// Exact numbers of a payload.
impl crate::cursor::Numbers<'_> {
    fn value(&self, index: usize) -> Option<Value> {
        let number = self.get(index)?;
        Some(match self.primitive() {
            Primitive::Bool => Value::Bool(number != 0.0),
            Primitive::Float64 => Value::Float(number),
            Primitive::Float32 => Value::Single(number as f32),
            Primitive::Int64 => Value::Integer((self.wide(index)? as i64).into()),
            Primitive::Uint64 => Value::Integer(self.wide(index)?.into()),
            _ => Value::Integer(number as i128),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema;

    const TEXT: &str = "float64 x\nuint64 count\nstring name\nfloat32[] rates\nPart[] parts\nwstring wide\n\
        ================================================================================\nMSG: demo/Part\nint8 k\nfloat64 y\n";

    /// x, count, name, rates, parts and a wide text, in little endian.
    fn payload(x: f64, count: u64, name: &str, rates: &[f32], parts: &[(i8, f64)]) -> Vec<u8> {
        let mut body = Vec::new();
        body.extend(x.to_le_bytes());
        body.extend(count.to_le_bytes());
        body.extend((name.len() as u32 + 1).to_le_bytes());
        body.extend(name.as_bytes());
        body.push(0);
        let align = |body: &mut Vec<u8>, size: usize| {
            // What lies between is nobody's, as in a payload of Cyclone DDS.
            body.resize(body.len().next_multiple_of(size), name.len() as u8);
        };
        align(&mut body, 4);
        body.extend((rates.len() as u32).to_le_bytes());
        rates.iter().for_each(|it| body.extend(it.to_le_bytes()));
        body.extend((parts.len() as u32).to_le_bytes());
        for (k, y) in parts {
            body.push(*k as u8);
            align(&mut body, 8);
            body.extend(y.to_le_bytes());
        }
        align(&mut body, 4);
        body.extend(1_u32.to_le_bytes());
        body.extend([b'w', 0]);
        [&[0, 1, 0, 0], &body[..]].concat()
    }

    fn found(a: &[u8], b: &[u8]) -> Vec<String> {
        let types = schema::read("demo/msg/Whole", "ros2msg", TEXT).unwrap();
        let mut found = Vec::new();
        differences(&types, [a, b], &mut |place, a, b| {
            found.push(format!("{place}: {a}, {b}"));
        })
        .unwrap();
        found
    }

    #[test]
    fn each_field_that_differs_is_named_with_both_values_exactly() {
        let a = payload(0.1, u64::MAX, "a", &[1.0, 2.0], &[(1, 0.5), (2, 1.5)]);
        assert!(found(&a, &a).is_empty());
        let up = 0.1_f64.next_up();
        let b = payload(
            up,
            u64::MAX - 1,
            "bcd",
            &[1.0, 2.5],
            &[(1, 0.5), (-2, 1.5), (3, 1.0)],
        );
        assert_eq!(
            found(&a, &b),
            [
                "x: 0.1, 0.10000000000000002",
                "count: 18446744073709551615, 18446744073709551614",
                "name: 'a', 'bcd'",
                "rates[1]: 2.0, 2.5",
                "parts: 2 elements, 3 elements",
                "parts[1].k: 2, -2",
            ]
        );
        assert_eq!(Value::Float(0.1).ulps(&Value::Float(up)), Some(1));
    }

    #[test]
    fn numbers_are_the_same_when_their_bits_are() {
        let (nan, zero) = (Value::Float(f64::NAN), Value::Float(0.0));
        assert!(nan.is(&nan) && !nan.is(&zero));
        let minus = Value::Float(-0.0);
        assert!(!zero.is(&minus));
        assert_eq!(zero.ulps(&minus), Some(1));
        let tiny = [f64::from_bits(1), -f64::from_bits(1)].map(Value::Float);
        assert_eq!(tiny[0].ulps(&tiny[1]), Some(3));
        let ends = [f64::MAX, f64::MIN].map(Value::Float);
        assert_eq!(ends[0].ulps(&ends[1]), Some(2 * f64::MAX.to_bits() + 1));
        let singles = [1.0_f32, 1.0_f32.next_down()].map(Value::Single);
        assert_eq!(singles[0].ulps(&singles[1]), Some(1));
    }

    #[test]
    fn numbers_are_written_as_python_writes_them() {
        for (value, text) in [
            (0.0, "0.0"),
            (-0.0, "-0.0"),
            (1e22, "1e+22"),
            (1e16, "1e+16"),
            (9_999_999_999_999_998.0, "9999999999999998.0"),
            (1.5e-7, "1.5e-07"),
            (1e-4, "0.0001"),
            (-1e-300, "-1e-300"),
            (f64::NAN, "nan"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(Value::Float(value).to_string(), text);
        }
        assert_eq!(Value::Single(0.1).to_string(), "0.10000000149011612");
    }

    #[test]
    fn a_payload_that_ends_early_is_refused_and_fields_are_found_by_path() {
        let a = payload(0.1, 1, "a", &[1.0], &[(1, 0.5)]);
        let types = schema::read("demo/msg/Whole", "ros2msg", TEXT).unwrap();
        for end in 0..a.len() {
            assert!(differences(&types, [&a, &a[..end]], &mut |_, _, _| {}).is_err());
        }
        for (path, is_there) in [
            ("x", true),
            ("parts.k", true),
            ("parts[].y", true),
            ("rates[1]", true),
            ("parts.z", false),
            ("x.y", false),
        ] {
            assert_eq!(types.has_field(path), is_there, "{path}");
        }
    }
}
