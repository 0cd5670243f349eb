//! What a message is called, among the others of its list or its topic.
//!
//! The first of [`NAMES`] that it holds, as a text or whole number, is its name: the frame `base_link`, the motor `motor_id=3`. A frame stands
//! behind the one that it lies in (`odom->base_link`), a marker's number behind its namespace. A message with none of them is called by the
//! frame of its header.

use planesman_msgs as msgs;
use planesman_rosidl::TypeName;
use planesman_rosidl::definition::{Arity, Element, Field, Primitive};

use crate::{FieldPath, Types, path::Step};

/// The fields by which messages are told apart, the first that is there.
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

/// Between the frame that another lies in and that other.
const WITHIN: &str = "->";

/// The path to a frame, as a name or around one.
const FRAMES: [&[&str]; 2] = [&["header", "frame_id"], &["frame_id"]];

/// Paths to the parts of a message's name, in their order; `has` tells whether there is a text or whole number.
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

/// The fields whose texts or numbers are what a message of that type is called.
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

/// What a field holds that is one thing.
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

/// What tells a message or an element from the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum NameKind {
    /// A text, or nothing.
    #[default]
    Named,
    /// A whole number, perhaps behind a text: `motor_id=3`.
    Numbered,
    /// The length of its list, whose elements have no names: `3 numbers`.
    Counted,
}

/// What a message or an element is called.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Name {
    /// As it is written in a path; empty where there is no name.
    pub text: String,
    /// What the text is made of. Foreign names may have blanks and `=`, so the text does not tell.
    pub kind: NameKind,
}

impl Name {
    /// Of what has no name.
    pub(crate) const NONE: &Self = &Self {
        text: String::new(),
        kind: NameKind::Named,
    };

    /// Sets it to none, in the same memory.
    pub(crate) fn clear(&mut self) {
        self.set("", NameKind::Named);
    }

    /// Appends a part: a text, or a number with the field that holds it.
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

    /// Sets it, in the memory of the one before.
    pub(crate) fn set(&mut self, text: &str, kind: NameKind) {
        self.text.clear();
        self.text.push_str(text);
        self.kind = kind;
    }
}

/// What a message at hand is called.
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

/// Whether a message of that name is meant by `wanted`: the whole, `odom->base_link`, or the last part, `base_link`.
#[must_use]
pub fn is_called(name: &str, wanted: &str) -> bool {
    let wanted = wanted.trim_start_matches('/');
    let last = name.rsplit(WITHIN).next();
    name == wanted || last == Some(wanted)
}
