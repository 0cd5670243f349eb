//! Program that walks a payload: skips and reads fields in their order.
//!
//! Consecutive skipped fields of fixed size are merged into one step; nothing is walked after the last requested number.

use std::collections::BTreeMap;
use std::sync::Arc;

use planesman_msgs::Field;
use planesman_rosidl::TypeName;
use planesman_rosidl::definition::{Arity, Element, FieldType, Primitive};

use crate::cursor::{Cursor, DecodeError};
use crate::key::{self, NameKind};
use crate::layout::{Advance, size_of};
use crate::path::Step;
use crate::values::Values;
use crate::{FieldPath, Types};

/// One step through a payload. `slot`: the list that a number is written to.
#[derive(Clone, Debug)]
pub(crate) enum Op {
    /// Skips fields of fixed size.
    Pass(Advance),
    /// Skips a string.
    PassText { wide: bool },
    /// Reads a number.
    Number { primitive: Primitive, slot: usize },
    /// Reads the number in a text.
    NumberInText { slot: usize },
    /// Reads some or all elements of a list of numbers, or skips the list.
    Numbers {
        count: Count,
        primitive: Primitive,
        whole: Option<usize>,
        /// Index and slot of each element to read.
        picks: Vec<(usize, usize)>,
        length: Option<usize>,
    },
    /// Reads a list of texts.
    Texts(TextList),
    /// Appends a text, or a number with its field's name, to the message's name.
    Name {
        primitive: Option<Primitive>,
        field: String,
    },
    /// Reads within the elements of a list (or the single message) that have certain names; does not advance.
    Named(NamedElements),
    /// Reads within the element whose index is in the slot; does not advance.
    At {
        count: Count,
        slot: usize,
        pass: Pass,
        within: Vec<Op>,
    },
    /// Stores the name of the message that begins here; does not advance.
    Identity { key: Arc<[Op]>, slots: Vec<usize> },
    /// Reads within some elements of a list of messages or strings, and skips the others.
    Elements {
        count: Count,
        pass: Pass,
        /// Index of each element and the steps within it, in ascending order.
        picks: Vec<(usize, Vec<Op>)>,
        /// Whether something after the list is requested.
        to_the_end: bool,
    },
}

/// Requests for a list of texts: the index of the first text with a certain value goes to a slot.
#[derive(Clone, Debug)]
pub(crate) struct TextList {
    count: Count,
    wanted: Vec<(String, usize)>,
    /// Whether all texts are kept.
    are_kept: bool,
    /// Index of a text, and its slot.
    picks: Vec<(usize, usize)>,
}

/// Requests for messages by name.
#[derive(Clone, Debug)]
pub(crate) struct NamedElements {
    count: Count,
    key: Arc<[Op]>,
    pass: Pass,
    picks: Vec<(String, Vec<Op>)>,
    /// Whether all names are kept.
    are_kept: bool,
}

/// Number of elements of a list.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Count {
    Fixed(u32),
    /// The length is given in the payload.
    Written,
}

/// The way to skip an element.
#[derive(Clone, Debug)]
pub(crate) enum Pass {
    Fixed(Advance),
    Walked(Arc<[Op]>),
}

/// The requested numbers, as a tree of path steps.
#[derive(Clone, Default, Debug)]
pub(crate) struct FieldSelection {
    slot: Option<usize>,
    /// Texts whose index in this list of texts is requested, with their slots.
    names: Vec<(String, usize)>,
    /// Whether all texts of this list are requested.
    all_names: bool,
    /// Slots for the name of this message or text.
    identity: Vec<usize>,
    /// Slot for the length of this list.
    length: Option<usize>,
    /// Whether this is the name of its message.
    is_name: bool,
    fields: BTreeMap<String, FieldSelection>,
    elements: BTreeMap<usize, FieldSelection>,
    /// For a list of messages: requests by name; for a single message: requests if it has this name.
    named: BTreeMap<String, FieldSelection>,
    /// For a list of messages named by a list of texts: slots for the indices, by name.
    numbers: BTreeMap<String, usize>,
}

impl FieldSelection {
    /// Requests the number or list at `path` in `slot`; returns its slot if it was requested before.
    pub(crate) fn add(&mut self, path: &FieldPath, slot: usize) -> usize {
        *self.at(path).slot.get_or_insert(slot)
    }

    /// Requests the index of the text `name` in the list of texts at `path` in `slot`.
    pub(crate) fn add_name(&mut self, path: &FieldPath, name: &str, slot: usize) {
        self.at(path).names.push((name.to_owned(), slot));
    }

    /// Requests the index of the element `name` of the list at `path`.
    pub(crate) fn add_number(&mut self, path: &FieldPath, name: &str, slot: usize) {
        self.at(path).numbers.insert(name.to_owned(), slot);
    }

    /// Requests all texts of the list at `path`.
    pub(crate) fn add_all_names(&mut self, path: &FieldPath) {
        self.at(path).all_names = true;
    }

    /// Requests the name of the message (or the text) at `path` in a text slot.
    pub(crate) fn add_identity(&mut self, path: &FieldPath, slot: usize) {
        self.at(path).identity.push(slot);
    }

    /// Requests the length of the list of numbers at `path` in a text slot.
    pub(crate) fn add_length(&mut self, path: &FieldPath, slot: usize) {
        self.at(path).length = Some(slot);
    }

    /// Reads the requests from a message in memory, or from one of its fields. A slot without a value stays unchanged.
    pub(crate) fn pick(&self, of: &dyn Field, values: &mut Values) {
        if let Some(list) = self.slot.and_then(|slot| values.slots.get_mut(slot)) {
            of.append_to(list);
            list.extend(of.text().and_then(number_in));
        }
        // Names first: messages stand where theirs stand.
        let of_names = |are_names: bool| {
            let fields = self.fields.iter();
            fields.filter(move |it| it.1.names.is_empty() != are_names)
        };
        for (name, wanted) in of_names(true).chain(of_names(false)) {
            if let Some(field) = of.field(name) {
                wanted.pick(field, values);
            }
        }
        for (number, wanted) in &self.elements {
            if let Some(element) = of.element(*number) {
                wanted.pick(element, values);
            }
        }
        let texts = values.texts.len();
        for slot in self.identity.iter().filter(|it| **it < texts) {
            match of.text() {
                Some(text) => values.put_name(*slot, text, NameKind::Named),
                None => values.texts[*slot] = key::of_message(of),
            }
        }
        if let Some(slot) = self.length.filter(|it| *it < texts) {
            let count = (0..).map_while(|number| of.element(number)).count();
            values.put_length(slot, count as u64);
        }
        // A message that is none of a list is the only one.
        let elements = || {
            let listed = (0..).map_while(|number| of.element(number));
            std::iter::once(of)
                .take(usize::from(of.element(0).is_none()))
                .chain(listed)
        };
        for (name, wanted) in &self.named {
            if let Some(slot) = self.numbers.get(name) {
                let number = values.number(*slot).map(|it| it as usize);
                if let Some(of) = number.and_then(|number| of.element(number)) {
                    wanted.pick(of, values);
                }
                continue;
            }
            if let Some(of) = elements().find(|it| key::is_called(&key::of_message(*it).text, name))
            {
                wanted.pick(of, values);
            }
        }
        let texts = || (0..).map_while(|number| of.element(number)?.text());
        for (name, slot) in &self.names {
            if let (Some(number), Some(list)) = (
                texts().position(|text| text == name),
                values.slots.get_mut(*slot),
            ) {
                list.push(number as f64);
            }
        }
        if self.all_names {
            let name = |of: &dyn Field| {
                let text = of.text().map(str::to_owned);
                text.unwrap_or_else(|| key::of_message(of).text)
            };
            values.names.extend(elements().map(name));
        }
    }

    fn at(&mut self, path: &FieldPath) -> &mut Self {
        let mut at = self;
        for step in &path.steps {
            at = match step {
                Step::Field(name) => at.fields.entry(name.clone()).or_default(),
                Step::Named(name) => at.named.entry(name.clone()).or_default(),
                Step::Index(index) => at.elements.entry(*index).or_default(),
            };
        }
        at
    }
}

/// The steps that read the requests from a message of the root type. The paths lead to numbers or lists of numbers.
pub(crate) fn compile(types: &Types, wanted: &FieldSelection) -> Vec<Op> {
    let mut ops = walk(types, wanted);
    trim(&mut ops);
    ops
}

/// Like `compile`, and then continues to the end of the message.
pub(crate) fn walk(types: &Types, wanted: &FieldSelection) -> Vec<Op> {
    let mut compiler = Compiler {
        types,
        passes: BTreeMap::new(),
    };
    let mut ops = Vec::new();
    let root = Element::Message(types.root().clone());
    compiler.called(Count::Fixed(1), &root, wanted, &mut ops);
    compiler.message(types.root(), wanted, &mut ops);
    ops
}

/// Removes steps at the end that only skip.
fn trim(ops: &mut Vec<Op>) {
    while let Some(last) = ops.last_mut() {
        match last {
            Op::Number { .. }
            | Op::Name { .. }
            | Op::Texts(_)
            | Op::Named(_)
            | Op::At { .. }
            | Op::Identity { .. } => return,
            Op::Numbers { whole, picks, .. } if whole.is_some() || !picks.is_empty() => return,
            Op::Elements {
                picks, to_the_end, ..
            } if !picks.is_empty() => {
                *to_the_end = false;
                return;
            }
            _ => {
                ops.pop();
            }
        }
    }
}

struct Compiler<'t> {
    types: &'t Types,
    /// Steps to skip each message type, computed once however often it is nested.
    passes: BTreeMap<&'t TypeName, Pass>,
}

impl<'t> Compiler<'t> {
    fn message(&mut self, name: &TypeName, wanted: &FieldSelection, ops: &mut Vec<Op>) {
        let types = self.types;
        if !wanted.identity.is_empty()
            && let Some(key) = self.key(name)
        {
            let slots = wanted.identity.clone();
            ops.push(Op::Identity { key, slots });
        }
        for field in types.message(name).into_iter().flat_map(|it| &it.fields) {
            match wanted.fields.get(&field.name) {
                Some(wanted) if wanted.is_name => ops.push(Op::Name {
                    primitive: match field.field_type.element {
                        Element::Primitive(primitive) => Some(primitive),
                        _ => None,
                    },
                    field: field.name.clone(),
                }),
                Some(wanted) => self.read(&field.field_type, wanted, ops),
                None => self.pass(&field.field_type, ops),
            }
        }
    }

    fn read(&mut self, field: &'t FieldType, wanted: &FieldSelection, ops: &mut Vec<Op>) {
        let Some(count) = count(field.arity) else {
            return self.read_one(&field.element, wanted, ops);
        };
        if let Element::Primitive(primitive) = field.element {
            let picks = wanted
                .elements
                .iter()
                .filter_map(|(index, wanted)| Some((*index, wanted.slot?)))
                .collect();
            return ops.push(Op::Numbers {
                count,
                primitive,
                whole: wanted.slot,
                picks,
                length: wanted.length,
            });
        }
        if matches!(field.element, Element::String { .. }) {
            return ops.push(Op::Texts(TextList {
                count,
                wanted: wanted.names.clone(),
                are_kept: wanted.all_names,
                picks: (wanted.elements.iter())
                    .flat_map(|(index, it)| it.identity.iter().map(|slot| (*index, *slot)))
                    .collect(),
            }));
        }
        self.called(count, &field.element, wanted, ops);
        let picks = wanted
            .elements
            .iter()
            .map(|(index, wanted)| {
                let mut within = Vec::new();
                self.read_one(&field.element, wanted, &mut within);
                (*index, within)
            })
            .collect();
        ops.push(Op::Elements {
            count,
            pass: self.pass_of(&field.element),
            picks,
            to_the_end: true,
        });
    }

    /// Steps that read within the messages with certain names, and then return to the position before these messages.
    fn called(
        &mut self,
        count: Count,
        of: &'t Element,
        wanted: &FieldSelection,
        ops: &mut Vec<Op>,
    ) {
        if wanted.named.is_empty() && !wanted.all_names {
            return;
        }
        let Element::Message(name) = of else { return };
        for (called, slot) in &wanted.numbers {
            let mut within = Vec::new();
            if let Some(wanted) = wanted.named.get(called) {
                self.message(name, wanted, &mut within);
            }
            ops.push(Op::At {
                count,
                slot: *slot,
                pass: self.pass_of(of),
                within,
            });
        }
        let Some(key) = self.key(name).filter(|_| wanted.numbers.is_empty()) else {
            return;
        };
        let picks = wanted.named.iter().map(|(called, wanted)| {
            let mut within = Vec::new();
            self.message(name, wanted, &mut within);
            (called.clone(), within)
        });
        let picks = picks.collect();
        ops.push(Op::Named(NamedElements {
            count,
            key,
            pass: self.pass_of(of),
            picks,
            are_kept: wanted.all_names,
        }));
    }

    /// The steps that determine the name of a message of that type; `None` for a type without names.
    fn key(&mut self, name: &TypeName) -> Option<Arc<[Op]>> {
        let mut wanted = FieldSelection::default();
        for path in key::fields(self.types, name) {
            wanted.at(&path).is_name = true;
        }
        let mut ops = Vec::new();
        self.message(name, &wanted, &mut ops);
        trim(&mut ops);
        (!ops.is_empty()).then(|| ops.into())
    }

    fn read_one(&mut self, element: &'t Element, wanted: &FieldSelection, ops: &mut Vec<Op>) {
        match (element, wanted.slot) {
            (Element::Message(name), _) => self.message(name, wanted, ops),
            (Element::Primitive(primitive), Some(slot)) => ops.push(Op::Number {
                primitive: *primitive,
                slot,
            }),
            (Element::String { wide: false, .. }, Some(slot)) => {
                ops.push(Op::NumberInText { slot });
            }
            _ => self.pass_one(element, ops),
        }
    }

    fn pass(&mut self, field: &'t FieldType, ops: &mut Vec<Op>) {
        let Some(count) = count(field.arity) else {
            return self.pass_one(&field.element, ops);
        };
        match (count, &field.element) {
            (Count::Written, Element::Primitive(primitive)) => ops.push(Op::Numbers {
                count,
                primitive: *primitive,
                whole: None,
                picks: Vec::new(),
                length: None,
            }),
            (_, element) => match (count, self.pass_of(element)) {
                (Count::Fixed(count), Pass::Fixed(one)) => {
                    push_pass(ops, one.times(u64::from(count)));
                }
                (count, pass) => ops.push(Op::Elements {
                    count,
                    pass,
                    picks: Vec::new(),
                    to_the_end: true,
                }),
            },
        }
    }

    fn pass_one(&mut self, element: &'t Element, ops: &mut Vec<Op>) {
        match self.pass_of(element) {
            Pass::Fixed(part) => push_pass(ops, part),
            Pass::Walked(steps) => match &*steps {
                [step] => ops.push(step.clone()),
                _ => ops.push(Op::Elements {
                    count: Count::Fixed(1),
                    pass: Pass::Walked(steps),
                    picks: Vec::new(),
                    to_the_end: true,
                }),
            },
        }
    }

    fn pass_of(&mut self, element: &'t Element) -> Pass {
        match element {
            Element::Primitive(primitive) => Pass::Fixed(Advance::number(size_of(*primitive))),
            Element::String { wide, .. } => Pass::Walked([Op::PassText { wide: *wide }].into()),
            Element::Message(name) => {
                if let Some(known) = self.passes.get(name) {
                    return known.clone();
                }
                let mut ops = Vec::new();
                self.message(name, &FieldSelection::default(), &mut ops);
                let pass = match ops[..] {
                    [Op::Pass(part)] => Pass::Fixed(part),
                    _ => Pass::Walked(ops.into()),
                };
                self.passes.insert(name, pass.clone());
                pass
            }
        }
    }
}

fn count(arity: Arity) -> Option<Count> {
    match arity {
        Arity::One => None,
        Arity::Array(size) => Some(Count::Fixed(size)),
        Arity::Sequence | Arity::BoundedSequence(_) => Some(Count::Written),
    }
}

fn push_pass(ops: &mut Vec<Op>, part: Advance) {
    match ops.last_mut() {
        Some(Op::Pass(before)) => *before = before.then(part),
        _ => ops.push(Op::Pass(part)),
    }
}

/// The number in a text, with or without a unit: `11.9 V`.
fn number_in(text: &str) -> Option<f64> {
    let is_of_unit =
        |sign: char| sign.is_alphabetic() || sign.is_whitespace() || "%°/".contains(sign);
    text.trim_end_matches(is_of_unit).trim_start().parse().ok()
}

fn put(values: &mut Values, slot: usize, number: Option<f64>) {
    if let (Some(list), Some(number)) = (values.slots.get_mut(slot), number) {
        list.push(number);
    }
}

/// Walks a payload. A slot without a value stays unchanged.
pub(crate) fn run(
    ops: &[Op],
    cursor: &mut Cursor<'_>,
    values: &mut Values,
) -> Result<(), DecodeError> {
    for op in ops {
        match op {
            Op::Pass(part) => cursor.pass(part)?,
            Op::PassText { wide } => cursor.pass_text(*wide)?,
            Op::Number { primitive, slot } => {
                let number = cursor.numbers(*primitive, 1)?.get(0);
                put(values, *slot, number);
            }
            Op::NumberInText { slot } => {
                let text = std::str::from_utf8(cursor.text()?).ok();
                put(values, *slot, text.and_then(number_in));
            }
            Op::Numbers {
                count,
                primitive,
                whole,
                picks,
                length,
            } => {
                let count = count.read(cursor)?;
                if let Some(slot) = length {
                    values.put_length(*slot, count);
                }
                let numbers = cursor.numbers(*primitive, count)?;
                if let Some(list) = whole.and_then(|slot| values.slots.get_mut(slot)) {
                    numbers.append_to(list);
                }
                for (index, slot) in picks {
                    put(values, *slot, numbers.get(*index));
                }
            }
            Op::Texts(names) => names.read(cursor, values)?,
            Op::Name { primitive, field } => {
                let mut name = std::mem::take(&mut values.name);
                match primitive {
                    None => name.append(Ok(&String::from_utf8_lossy(cursor.text()?))),
                    Some(primitive) => {
                        let number = cursor.numbers(*primitive, 1)?.get(0).unwrap_or(0.0);
                        name.append(Err((field, number)));
                    }
                }
                values.name = name;
            }
            Op::Identity { key, slots } => {
                named(key, cursor, values)?;
                let name = std::mem::take(&mut values.name);
                for slot in slots {
                    values.put_name(*slot, &name.text, name.kind);
                }
                values.name = name;
            }
            Op::Named(called) => called.read(cursor.clone(), values)?,
            Op::At {
                count,
                slot,
                pass,
                within,
            } => {
                let mut at = cursor.clone();
                let count = count.read(&mut at)?;
                if let Some(number) = values.number(*slot).map(|it| it as u64)
                    && number < count
                {
                    pass.pass(number, &mut at)?;
                    run(within, &mut at, values)?;
                }
            }
            Op::Elements {
                count,
                pass,
                picks,
                to_the_end,
            } => {
                let count = count.read(cursor)?;
                let mut passed = 0;
                for (index, within) in picks {
                    let index = *index as u64;
                    if index >= count {
                        break;
                    }
                    pass.pass(index - passed, cursor)?;
                    run(within, cursor, values)?;
                    passed = index + 1;
                }
                if *to_the_end {
                    pass.pass(count - passed, cursor)?;
                }
            }
        }
    }
    Ok(())
}

impl TextList {
    fn read(&self, cursor: &mut Cursor<'_>, values: &mut Values) -> Result<(), DecodeError> {
        for number in 0..self.count.read(cursor)? {
            let text = cursor.text()?;
            for (_, slot) in self.picks.iter().filter(|it| it.0 as u64 == number) {
                values.put_name(*slot, &String::from_utf8_lossy(text), NameKind::Named);
            }
            for (name, slot) in &self.wanted {
                let is_first = values.list(*slot).is_empty();
                if is_first && name.as_bytes() == text {
                    put(values, *slot, Some(number as f64));
                }
            }
            if self.are_kept {
                let text = String::from_utf8_lossy(text).into_owned();
                values.names.push(text);
            }
        }
        Ok(())
    }
}

impl NamedElements {
    fn read(&self, mut start: Cursor<'_>, values: &mut Values) -> Result<(), DecodeError> {
        let count = self.count.read(&mut start)?;
        // Each looks from the first: most lists are short, and the first that is so called counts.
        for (called, within) in &self.picks {
            let mut at = start.clone();
            for _ in 0..count {
                named(&self.key, &at, values)?;
                if key::is_called(&values.name.text, called) {
                    run(within, &mut at, values)?;
                    break;
                }
                self.pass.pass(1, &mut at)?;
            }
        }
        for _ in 0..if self.are_kept { count } else { 0 } {
            named(&self.key, &start, values)?;
            values.names.push(values.name.text.clone());
            self.pass.pass(1, &mut start)?;
        }
        Ok(())
    }
}

/// Reads the name of the message at the cursor.
fn named(key: &[Op], cursor: &Cursor<'_>, values: &mut Values) -> Result<(), DecodeError> {
    values.name.clear();
    run(key, &mut cursor.clone(), values)
}

impl Count {
    fn read(self, cursor: &mut Cursor<'_>) -> Result<u64, DecodeError> {
        match self {
            Self::Fixed(count) => Ok(u64::from(count)),
            Self::Written => cursor.length(),
        }
    }
}

impl Pass {
    /// Skips `count` elements. Each takes at least one byte, so the end of the payload ends the loop.
    fn pass(&self, count: u64, cursor: &mut Cursor<'_>) -> Result<(), DecodeError> {
        match self {
            Self::Fixed(one) => cursor.pass(&one.times(count)),
            Self::Walked(steps) => {
                for _ in 0..count {
                    run(steps, cursor, &mut Values::default())?;
                }
                Ok(())
            }
        }
    }
}
