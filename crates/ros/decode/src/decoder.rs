//! Compiles paths for a message type, and reads payloads.
//!
//! A path may end with a computed name that is not a field:
//!
//! | name | of | meaning |
//! |---|---|---|
//! | `roll`, `pitch`, `yaw` | a message with numbers x, y, z, w | the angles of the quaternion, rad (REP 103: about fixed x, y, z in this order) |
//! | `norm` | a message with numbers x, y, z and no w | `sqrt(x^2 + y^2 + z^2)` |
//!
//! A real field of that name has priority.
//!
//! The text `value` of an element with a name or `key`, as in `diagnostic_msgs/KeyValue`, is read as a number.
//!
//! Characters of wide strings have two bytes as written by Fast DDS since Jazzy (Fast CDR 2), or four as before and as `rmw_cyclonedds` wrote
//! `wchar_t`. A payload does not show which of the two it is. Four bytes are assumed if fewer bytes then remain after the message, otherwise two.

use planesman_rosidl::TypeName;
use planesman_rosidl::definition::{Arity, Element, Field, Kind};
use planesman_text::did_you_mean;

use crate::cursor::{Cursor, DecodeError};
use crate::key::Name;
use crate::path::Step;
use crate::program::{self, FieldSelection, Op};
use crate::values::Values;
use crate::{FieldPath, Types, json, key};

/// Reads numbers of messages of one type.
#[derive(Clone, Debug)]
pub struct Decoder {
    wanted: FieldSelection,
    /// Steps through a payload.
    ops: Vec<Op>,
    /// Number of slots: the requested numbers, then those needed by formulas.
    slots: usize,
    /// Slots computed from other slots.
    computed: Vec<(usize, Formula)>,
    /// For each path, the texts that identify its number.
    identities: Vec<Vec<Identity>>,
    /// Number of texts in the values.
    texts: usize,
    /// Whether the messages are JSON objects.
    is_json: bool,
    /// Steps to skip a whole message, for a type with wide strings.
    whole: Option<Vec<Op>>,
}

/// A position along a path at which a message or an element is named.
#[derive(Clone, Debug)]
struct Identity {
    /// Number of the path's steps up to there.
    steps: usize,
    /// Slot of the name.
    name: Option<usize>,
    /// Slot of the length of its list.
    length: Option<usize>,
}

/// Formula of a computed slot: the slots `[x, y, z]` and `w`; or a list, and the slot of the element's index.
#[derive(Clone, Copy, Debug)]
enum Formula {
    Same(usize),
    Norm([usize; 3]),
    Angle(Axis, [usize; 3], usize),
    Element(usize, usize),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Axis {
    Roll,
    Pitch,
    Yaw,
}

/// Names that can be computed.
const DERIVED: [(&str, Option<Axis>); 4] = [
    ("roll", Some(Axis::Roll)),
    ("pitch", Some(Axis::Pitch)),
    ("yaw", Some(Axis::Yaw)),
    ("norm", None),
];

/// A path that does not lead to a number.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct CompileError {
    /// The path.
    pub path: String,
    /// The reason.
    pub reason: Reason,
}

/// The reason why a path is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Reason {
    /// The message has no such field.
    #[error("{within} has no field '{name}'; it has {fields}{meant}")]
    NoField {
        /// Name of the message.
        within: String,
        /// Requested name.
        name: String,
        /// Names of its fields.
        fields: String,
        /// The most similar name, as a question; empty if no name is similar.
        meant: String,
    },
    /// A name after something that is not a message.
    #[error("'{0}' does not exist in a {1}")]
    NotAMessage(String, String),
    /// An index after something that is not a list.
    #[error("[{0}] cannot index a {1}, which is not a list")]
    NotAList(usize, String),
    /// An index outside the list.
    #[error("{field_type} has no element [{index}]")]
    NoElement {
        /// Requested index.
        index: usize,
        /// The list's type.
        field_type: String,
    },
    /// A name in brackets after a list whose elements have no names.
    #[error(
        "[{name}] of {list}: the message has no names for the elements of this list. Use an index"
    )]
    NoNames {
        /// Requested name.
        name: String,
        /// The path of the list.
        list: String,
    },
    /// The path leads to a text, a message or a list of these.
    #[error("it is a {0}, not a number{1}")]
    NotANumber(String, String),
}

/// Target of a path.
enum Target {
    /// A number or list of numbers.
    Plain,
    /// A number computed from the fields at the path without its last step.
    Norm,
    Angle(Axis),
    /// An element of the list at the path without its last step, found through the list of names at this path.
    Element(FieldPath, String),
}

impl Decoder {
    /// A decoder of the numbers at `paths`, in this order, for messages of the type.
    ///
    /// # Errors
    /// The first path that does not lead to a number, with the reason.
    pub fn compile(types: &Types, paths: &[FieldPath]) -> Result<Self, CompileError> {
        Self::compile_into(types, paths, FieldSelection::default())
    }

    /// Like [`Decoder::compile`]; the decoder also reads the names that identify the numbers ([`Decoder::identity`]).
    ///
    /// # Errors
    /// Same as [`Decoder::compile`].
    pub fn compile_with_identities(
        types: &Types,
        paths: &[FieldPath],
    ) -> Result<Self, CompileError> {
        let mut wanted = FieldSelection::default();
        let mut texts = 0;
        let mut text = || {
            texts += 1;
            texts - 1
        };
        let mut identities = Vec::new();
        for path in paths {
            let mut along = Vec::new();
            for steps in 0..=path.steps.len() {
                let prefix = path.first(steps);
                let mut identity = Identity {
                    steps,
                    name: None,
                    length: None,
                };
                match prefix.steps.last() {
                    None if matches!(path.steps.first(), Some(Step::Named(_))) => continue,
                    Some(Step::Field(_)) => continue,
                    Some(Step::Index(index))
                        if steps == path.steps.len() || !has_key(types, &prefix.parent()) =>
                    {
                        let list = prefix.parent();
                        let names = match steps == path.steps.len() {
                            true => names_of(types, &list),
                            false => names_of_messages(types, &list),
                        };
                        identity.name = names.map(|names| {
                            let slot = text();
                            wanted.add_identity(&names.element(*index), slot);
                            slot
                        });
                        if steps == path.steps.len() {
                            let slot = text();
                            wanted.add_length(&prefix.parent(), slot);
                            identity.length = Some(slot);
                        }
                    }
                    // By its name, of a list of numbers.
                    Some(Step::Named(_)) if steps == path.steps.len() => continue,
                    None | Some(Step::Index(_) | Step::Named(_)) => {
                        let slot = text();
                        wanted.add_identity(&prefix, slot);
                        identity.name = Some(slot);
                    }
                }
                along.push(identity);
            }
            identities.push(along);
        }
        let decoder = Self::compile_into(types, paths, wanted)?;
        Ok(Self {
            identities,
            texts,
            ..decoder
        })
    }

    /// The names that identify the number at path `index` in the message read last: the name of the message, and the names of the list elements on
    /// the path, from outside to inside. A missing name is empty. A number in a list without names is identified by the list's length. Each name is
    /// returned with the path's steps up to it.
    pub fn identity<'v>(
        &'v self,
        index: usize,
        values: &'v Values,
    ) -> impl Iterator<Item = (usize, &'v Name)> {
        let name = |slot: Option<usize>| {
            let name = values.texts.get(slot?)?;
            (!name.text.is_empty()).then_some(name)
        };
        let along = self.identities.get(index).into_iter().flatten();
        along.map(move |it| {
            let known = name(it.name).or_else(|| name(it.length));
            (it.steps, known.unwrap_or(Name::NONE))
        })
    }

    fn compile_into(
        types: &Types,
        paths: &[FieldPath],
        mut wanted: FieldSelection,
    ) -> Result<Self, CompileError> {
        let mut slots = paths.len();
        let mut computed = Vec::new();
        for (slot, path) in paths.iter().enumerate() {
            let target = target(types, path).map_err(|reason| CompileError {
                path: path.to_string(),
                reason,
            })?;
            // Messages of a list that others name stand where their names stand.
            for (list, name) in path
                .named()
                .filter(|it| it.0.steps.len() + 1 < path.steps.len())
            {
                if !has_key(types, &list)
                    && let Some(names) = names_of_messages(types, &list)
                {
                    wanted.add_name(&names, name, slots);
                    wanted.add_number(&list, name, slots);
                    slots += 1;
                }
            }
            let of = path.parent();
            let mut part = |wanted: &mut FieldSelection, path: &FieldPath| {
                let slot = wanted.add(path, slots);
                slots += usize::from(slot == slots);
                slot
            };
            let mut vector = |wanted: &mut FieldSelection| {
                ["x", "y", "z"].map(|name| part(wanted, &of.field(name)))
            };
            match target {
                Target::Plain => {
                    let first = wanted.add(path, slot);
                    if first != slot {
                        computed.push((slot, Formula::Same(first)));
                    }
                }
                Target::Norm => computed.push((slot, Formula::Norm(vector(&mut wanted)))),
                Target::Angle(axis) => {
                    let xyz = vector(&mut wanted);
                    let w = part(&mut wanted, &of.field("w"));
                    computed.push((slot, Formula::Angle(axis, xyz, w)));
                }
                Target::Element(names, name) => {
                    let list = part(&mut wanted, &of);
                    wanted.add_name(&names, &name, slots);
                    computed.push((slot, Formula::Element(list, slots)));
                    slots += 1;
                }
            }
        }
        Ok(Self::of(types, wanted, slots, computed))
    }

    /// A decoder of the names of the elements of the list at `path` (empty path: of the message itself); `None` if they have no names.
    #[must_use]
    pub fn of_names(types: &Types, path: &FieldPath) -> Option<Self> {
        let mut wanted = FieldSelection::default();
        let own = has_key(types, path).then(|| path.clone());
        wanted.add_all_names(&own.or_else(|| names_of(types, path))?);
        Some(Self::of(types, wanted, 0, Vec::new()))
    }

    fn of(
        types: &Types,
        wanted: FieldSelection,
        slots: usize,
        computed: Vec<(usize, Formula)>,
    ) -> Self {
        Self {
            ops: program::compile(types, &wanted),
            wanted,
            slots,
            computed,
            identities: Vec::new(),
            texts: 0,
            is_json: types.is_json,
            whole: types
                .has_wide_text()
                .then(|| program::walk(types, &FieldSelection::default())),
        }
    }

    /// Whether a payload is exactly one message of the type, except for padding.
    #[must_use]
    pub fn fits(types: &Types, payload: &[u8]) -> bool {
        let whole = program::walk(types, &FieldSelection::default());
        Cursor::new(payload).is_ok_and(|cursor| {
            let wide = cursor.clone().with_wide_characters(4);
            left_behind(&whole, &cursor).min(left_behind(&whole, &wide)) < 4
        })
    }

    /// Reads a payload into `values`, reusing their memory.
    ///
    /// # Errors
    /// The payload is not plain CDR, or ends before the last requested number.
    pub fn read(&self, payload: &[u8], values: &mut Values) -> Result<(), DecodeError> {
        self.clear(values, self.texts);
        if self.is_json {
            self.wanted.pick(&json::object_of(payload)?, values);
            self.compute(values);
            return Ok(());
        }
        let mut cursor = Cursor::new(payload)?;
        if let Some(whole) = &self.whole {
            let other = cursor.clone().with_wide_characters(4);
            if left_behind(whole, &other) < left_behind(whole, &cursor) {
                cursor = other;
            }
        }
        program::run(&self.ops, &mut cursor, values)?;
        self.compute(values);
        Ok(())
    }

    /// Like [`Decoder::read`], for a message in memory; no payload is made.
    pub fn pick(&self, message: &dyn planesman_msgs::Field, values: &mut Values) {
        self.clear(values, 0);
        self.wanted.pick(message, values);
        self.compute(values);
    }

    fn clear(&self, values: &mut Values, texts: usize) {
        values.slots.resize(self.slots, Vec::new());
        values.slots.iter_mut().for_each(Vec::clear);
        values.names.clear();
        values.texts.resize_with(texts, Name::default);
        values.texts.iter_mut().for_each(Name::clear);
    }

    /// Fills the computed slots.
    fn compute(&self, values: &mut Values) {
        for (slot, formula) in &self.computed {
            let mut list = std::mem::take(&mut values.slots[*slot]);
            match formula {
                Formula::Same(from) => list.extend_from_slice(values.list(*from)),
                Formula::Norm(xyz) => list.extend(norm(values, xyz)),
                Formula::Angle(axis, xyz, w) => list.extend(angle(*axis, values, xyz, *w)),
                Formula::Element(of, number) => list.extend(element(values, *of, *number)),
            }
            values.slots[*slot] = list;
        }
    }
}

/// Number of bytes that remain after the message; 0 is best, a message longer than the payload is worst.
fn left_behind(whole: &[Op], cursor: &Cursor<'_>) -> usize {
    let mut cursor = cursor.clone();
    match program::run(whole, &mut cursor, &mut Values::default()) {
        Ok(()) => cursor.left(),
        Err(_) => usize::MAX,
    }
}

fn vector(values: &Values, [x, y, z]: &[usize; 3]) -> Option<[f64; 3]> {
    Some([values.number(*x)?, values.number(*y)?, values.number(*z)?])
}

fn norm(values: &Values, xyz: &[usize; 3]) -> Option<f64> {
    let [x, y, z] = vector(values, xyz)?;
    Some(libm::hypot(libm::hypot(x, y), z))
}

/// An angle of the quaternion, of any norm; `None` for zero norm.
fn angle(axis: Axis, values: &Values, xyz: &[usize; 3], w: usize) -> Option<f64> {
    let [x, y, z] = vector(values, xyz)?;
    let w = values.number(w)?;
    let norm = x * x + y * y + z * z + w * w;
    if norm == 0.0 {
        return None;
    }
    Some(match axis {
        Axis::Roll => libm::atan2(2.0 * (w * x + y * z), w * w - x * x - y * y + z * z),
        Axis::Pitch => libm::asin((2.0 * (w * y - z * x) / norm).clamp(-1.0, 1.0)),
        Axis::Yaw => libm::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z),
    })
}

/// The element of a list whose index is in another slot.
fn element(values: &Values, list: usize, number: usize) -> Option<f64> {
    let number = values.number(number)? as usize;
    values.list(list).get(number).copied()
}

/// Target of the steps so far.
enum At<'t> {
    Message(&'t TypeName),
    Field(&'t Field),
    Element(&'t Element),
}

impl<'t> At<'t> {
    /// A field or element that is a single message counts as that message.
    fn entered(self) -> Self {
        match self {
            Self::Field(field) if field.field_type.arity == Arity::One => {
                Self::Element(&field.field_type.element).entered()
            }
            Self::Element(Element::Message(name)) => Self::Message(name),
            other => other,
        }
    }

    fn type_name(&self) -> String {
        match self {
            Self::Message(name) => name.short(),
            Self::Field(field) => field.field_type.to_string(),
            Self::Element(element) => element.to_string(),
        }
    }
}

impl Types {
    /// Path of the stamp in messages of this type: `header.stamp`, or else the first field of type `builtin_interfaces/Time`; it contains `sec` and
    /// `nanosec`. `None` if the type has no stamp, or if the schema redefines the header or time type.
    #[must_use]
    pub fn stamp(&self) -> Option<FieldPath> {
        let one = |field: &Field, package: &str, name: &str| {
            let wanted = TypeName::new(package, Kind::Msg, name);
            field.field_type.arity == Arity::One
                && field.field_type.element == Element::Message(wanted)
        };
        let fields = &self.message(self.root())?.fields;
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

    /// Path of the names for the numbers of the list at `path`, as in `sensor_msgs/JointState`; `None` if `path` leads to a number or a list
    /// without names.
    ///
    /// The names are a list of texts in the same message or an enclosing one, called `name`, `names` or `joint_names`, or named after the list
    /// (`gain_names` for `gain_values`).
    #[must_use]
    pub fn names_of(&self, path: &FieldPath) -> Option<FieldPath> {
        names_of(self, path)
    }
}

/// Follows a path through the definitions.
fn target(types: &Types, path: &FieldPath) -> Result<Target, Reason> {
    let mut at = At::Message(types.root());
    for (number, step) in path.steps.iter().enumerate() {
        at = match (at, step) {
            (At::Message(name), Step::Field(field)) => match find(types, name, field) {
                Some(field) => At::Field(field),
                None => {
                    let is_last = number + 1 == path.steps.len();
                    return derived(types, name, field)
                        .filter(|_| is_last)
                        .ok_or_else(|| Reason::NoField {
                            within: name.short(),
                            name: field.clone(),
                            fields: names(types, name),
                            meant: did_you_mean(field, fields_of(types, name)),
                        });
                }
            },
            (at, Step::Field(name)) => {
                return Err(Reason::NotAMessage(name.clone(), at.type_name()));
            }
            (At::Message(message), Step::Named(name)) if number == 0 => {
                if key::fields(types, message).is_empty() {
                    return Err(Reason::NoNames {
                        name: name.clone(),
                        list: message.short(),
                    });
                }
                At::Message(message)
            }
            (At::Field(field), Step::Named(_))
                if has_key(types, &path.first(number))
                    || matches!(field.field_type.element, Element::Message(_))
                        && names_of_messages(types, &path.first(number)).is_some() =>
            {
                At::Element(&field.field_type.element)
            }
            (At::Field(field), Step::Named(name)) => {
                let list = path.first(number);
                let is_last = number + 1 == path.steps.len();
                let are_numbers = matches!(field.field_type.element, Element::Primitive(_));
                return names_of(types, &list)
                    .filter(|_| is_last && are_numbers)
                    .map(|names| Target::Element(names, name.clone()))
                    .ok_or_else(|| Reason::NoNames {
                        name: name.clone(),
                        list: list.to_string(),
                    });
            }
            (at, Step::Named(name)) => {
                return Err(Reason::NoNames {
                    name: name.clone(),
                    list: at.type_name(),
                });
            }
            (At::Field(field), Step::Index(index)) if field.field_type.arity != Arity::One => {
                if let Arity::Array(most) | Arity::BoundedSequence(most) = field.field_type.arity
                    && *index >= most as usize
                {
                    return Err(Reason::NoElement {
                        index: *index,
                        field_type: field.field_type.to_string(),
                    });
                }
                At::Element(&field.field_type.element)
            }
            (at, Step::Index(index)) => return Err(Reason::NotAList(*index, at.type_name())),
        }
        .entered();
    }
    let hint = match at {
        At::Element(Element::Primitive(_)) => return Ok(Target::Plain),
        At::Element(Element::String { wide: false, .. }) if is_value(types, path) => {
            return Ok(Target::Plain);
        }
        At::Field(field) => match &field.field_type.element {
            Element::Primitive(_) => return Ok(Target::Plain),
            _ => "; choose an element [0], [1], ...".to_owned(),
        },
        At::Message(name) => format!("; it has {}", names(types, name)),
        At::Element(_) => String::new(),
    };
    Err(Reason::NotANumber(at.type_name(), hint))
}

/// Whether the text at `path` is the value of a key, for example in diagnostics.
fn is_value(types: &Types, path: &FieldPath) -> bool {
    matches!(path.steps.last(), Some(Step::Field(name)) if name == "value")
        && has_key(types, &path.parent())
}

/// Whether the elements of the list at `path` (empty path: the message itself) have names.
fn has_key(types: &Types, path: &FieldPath) -> bool {
    let mut message = types.root();
    let mut is_list = true;
    for step in &path.steps {
        if let Step::Field(name) = step {
            let Some(field) = find(types, message, name) else {
                return false;
            };
            let Element::Message(inner) = &field.field_type.element else {
                return false;
            };
            is_list = field.field_type.arity != Arity::One;
            message = inner;
        }
    }
    is_list && !key::fields(types, message).is_empty()
}

/// Like `has_key`, for a list of messages. Points of a trajectory are times, to which the joints' names do not apply.
fn names_of_messages(types: &Types, path: &FieldPath) -> Option<FieldPath> {
    let is_of_points = matches!(path.steps.last(), Some(Step::Field(name)) if name == "points");
    names_of(types, path).filter(|_| !is_of_points)
}

/// Path of the texts that name the elements of the list at `path`.
fn names_of(types: &Types, path: &FieldPath) -> Option<FieldPath> {
    let (Step::Field(list), before) = path.steps.split_last()? else {
        return None;
    };
    // The messages around the list, the outermost first, each with its path.
    let mut around = vec![(types.root(), FieldPath { steps: Vec::new() })];
    for step in before {
        let (message, path) = around.last()?;
        let (next, path) = match step {
            Step::Field(name) => match &find(types, message, name)?.field_type.element {
                Element::Message(inner) => (inner, path.field(name)),
                _ => return None,
            },
            Step::Index(_) | Step::Named(_) => (*message, path.with(step.clone())),
        };
        around.push((next, path));
    }
    let (message, _) = around.last()?;
    if find(types, message, list)?.field_type.arity == Arity::One {
        return None;
    }
    let stem = list.rsplit_once('_').map(|(stem, _)| stem);
    let own = stem
        .into_iter()
        .flat_map(|stem| [format!("{stem}_names"), format!("{stem}_name")]);
    let usual = ["name", "names", "joint_names"].map(str::to_owned);
    let candidates: Vec<String> = own.chain(usual).collect();
    around.iter().rev().find_map(|(message, path)| {
        let are_names = |name: &&String| {
            find(types, message, name).is_some_and(|field| {
                let is_text = matches!(
                    field.field_type.element,
                    Element::String { wide: false, .. }
                );
                is_text && field.field_type.arity != Arity::One
            })
        };
        let found = candidates.iter().find(are_names)?;
        Some(path.field(found))
    })
}

fn find<'t>(types: &'t Types, message: &TypeName, name: &str) -> Option<&'t Field> {
    let message = types.message(message)?;
    message.fields.iter().find(|field| field.name == name)
}

fn fields_of<'t>(types: &'t Types, message: &TypeName) -> impl Iterator<Item = &'t str> {
    let fields = types.message(message).map_or(&[][..], |it| &it.fields);
    fields.iter().map(|it| it.name.as_str())
}

/// Names of a message's fields; only the first if there are many.
fn names(types: &Types, message: &TypeName) -> String {
    const MAX_NAMES: usize = 30;
    let mut names: Vec<&str> = fields_of(types, message).collect();
    if names.len() > MAX_NAMES {
        names.truncate(MAX_NAMES);
        names.push("...");
    }
    names.join(", ")
}

/// The computed meaning of `name` in a message without such a field.
fn derived(types: &Types, message: &TypeName, name: &str) -> Option<Target> {
    let (_, axis) = DERIVED.into_iter().find(|(known, _)| *known == name)?;
    let has = |name| {
        find(types, message, name).is_some_and(|field| {
            field.field_type.arity == Arity::One
                && matches!(field.field_type.element, Element::Primitive(_))
        })
    };
    let is_vector = has("x") && has("y") && has("z");
    match axis {
        Some(axis) => (is_vector && has("w")).then_some(Target::Angle(axis)),
        None => (is_vector && !has("w")).then_some(Target::Norm),
    }
}

/// The names that can be computed from a message.
pub(crate) fn derived_names(types: &Types, message: &TypeName) -> Vec<&'static str> {
    DERIVED
        .into_iter()
        .map(|(name, _)| name)
        .filter(|name| {
            find(types, message, name).is_none() && derived(types, message, name).is_some()
        })
        .collect()
}
