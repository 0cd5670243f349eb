//! Names of messages, which identify them in a list or on a topic.
//!
//! The first field of [`NAMES`] in a message, a text or an integer, is its name: the frame `base_link`, the motor `motor_id=3`. A frame follows
//! its parent frame (`odom->base_link`), a marker's number follows its namespace. A message without such a field is named by its header's frame.

use planesman_msgs as msgs;
use planesman_rosidl::TypeName;
use planesman_rosidl::definition::{Arity, Element, Field, Primitive};

use crate::{FieldPath, Types, path::Step};

/// Fields that name messages, in order of priority.
const NAMES: [&str; 14] = [
    "child_frame_id",
    "name",
    "id",
    "key",
    "label",
    "joint_name",
    "motor_name",
    "motor_id",
    "thruster_id",
    "esc_id",
    "servo_id",
    "node_id",
    "sensor_id",
    "device_id",
];

/// Separator between a parent frame and its child.
const WITHIN: &str = "->";

/// Paths to a frame: a name by itself, or the parent.
const FRAMES: [&[&str]; 2] = [&["header", "frame_id"], &["frame_id"]];

/// Paths to the parts of a message's name, in order; `has` returns whether a path leads to a text or integer.
fn parts(has: impl Fn(&[&'static str]) -> bool) -> Vec<Vec<&'static str>> {
    let own = NAMES.into_iter().find(|name| has(&[name]));
    let frame = || FRAMES.into_iter().find(|path| has(path)).map(<[_]>::to_vec);
    let around = match own {
        None | Some("child_frame_id") => frame(),
        Some("id") => has(&["ns"]).then(|| vec!["ns"]),
        Some(_) => None,
    };
    around.into_iter().chain(own.map(|own| vec![own])).collect()
}

/// The fields that make up the name of a message of that type.
pub(crate) fn fields(types: &Types, message: &TypeName) -> Vec<FieldPath> {
    let has = |path: &[&str]| element(types, message, path).is_some_and(is_name);
    let path = |names: Vec<&str>| FieldPath {
        steps: names
            .into_iter()
            .map(|it| Step::Field(it.to_owned()))
            .collect(),
    };
    parts(has).into_iter().map(path).collect()
}

/// Type of a single-valued field.
fn element<'t>(types: &'t Types, message: &TypeName, path: &[&str]) -> Option<&'t Element> {
    let (first, rest) = path.split_first()?;
    let is_it = |field: &&Field| field.name == *first && field.field_type.arity == Arity::One;
    let field = types.message(message)?.fields.iter().find(is_it)?;
    match (&field.field_type.element, rest) {
        (element, []) => Some(element),
        (Element::Message(inner), rest) => self::element(types, inner, rest),
        _ => None,
    }
}

fn is_name(element: &Element) -> bool {
    match element {
        Element::String { wide, .. } => !wide,
        Element::Primitive(primitive) => !matches!(
            primitive,
            Primitive::Bool | Primitive::Float32 | Primitive::Float64
        ),
        Element::Message(_) => false,
    }
}

/// Kind of a name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum NameKind {
    /// A text, possibly empty.
    #[default]
    Named,
    /// An integer, possibly after a text: `motor_id=3`.
    Numbered,
    /// Length of a list without names: `3 numbers`.
    Counted,
}

/// Name of a message or an element.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Name {
    /// Text as written in a path; empty if there is no name.
    pub text: String,
    /// Kind of the text. Foreign names may contain blanks and `=`, so the text alone is ambiguous.
    pub kind: NameKind,
}

impl Name {
    /// No name.
    pub(crate) const NONE: &Self = &Self {
        text: String::new(),
        kind: NameKind::Named,
    };

    /// Clears the name, keeping its memory.
    pub(crate) fn clear(&mut self) {
        self.set("", NameKind::Named);
    }

    /// Appends a part: a text, or a number with its field's name.
    pub(crate) fn append(&mut self, part: Result<&str, (&str, f64)>) {
        if !self.text.is_empty() {
            self.text.push_str(WITHIN);
        }
        match part {
            // As frames of tf's first version, which other programs take for the same.
            Ok(text) => self.text.push_str(text.trim_start_matches('/')),
            Err((field, number)) => {
                self.text += &format!("{field}={number}");
                self.kind = NameKind::Numbered;
            }
        }
    }

    /// Sets the name, reusing its memory.
    pub(crate) fn set(&mut self, text: &str, kind: NameKind) {
        self.text.clear();
        self.text.push_str(text);
        self.kind = kind;
    }
}

/// Name of a message in memory.
pub(crate) fn of_message(of: &dyn msgs::Field) -> Name {
    let at = |path: &[&str]| path.iter().try_fold(of, |of, name| of.field(name));
    let number = |of: &dyn msgs::Field| {
        let mut numbers = Vec::new();
        of.append_to(&mut numbers);
        numbers.first().copied()
    };
    let mut name = Name::default();
    for path in parts(|path| at(path).is_some_and(|it| it.text().is_some() || number(it).is_some()))
    {
        let Some(field) = at(&path) else { continue };
        match (field.text(), number(field)) {
            (Some(text), _) => name.append(Ok(text)),
            (None, Some(number)) => name.append(Err((path[0], number))),
            (None, None) => {}
        }
    }
    name
}

/// Whether `wanted` matches a name: the whole name, `odom->base_link`, or its last part, `base_link`.
#[must_use]
pub fn is_called(name: &str, wanted: &str) -> bool {
    let wanted = wanted.trim_start_matches('/');
    let last = name.rsplit(WITHIN).next();
    name == wanted || last == Some(wanted)
}
