//! PX4's log format ULog, as far as signals need it: formats, subscriptions, data, dropouts (PX4 user guide, "ULog File Format").
//!
//! A topic is PX4's message name; its second instance is `NAME_1`, and so on. A log that is cut off, for example by a crash, is read up to the cut; a
//! damaged log is read on after the damage.
//!
//! PX4's own parser (crate `px4-ulog` 0.6) is not used: it panics on short messages and lays out every field of every format, 65 535 of
//! them for a line of text. Here a length costs no more than the bytes present, and the fields of a format are laid out once, up to a total
//! limit.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::rc::Rc;

use crate::ahead::Ahead;
use crate::binary::{number, size};
use crate::log_message::{FIELDS, LogMessage, LogReader};

/// The field with the time, microseconds.
const STAMP: &str = "timestamp";

/// The first bytes of a log; a version and a time follow.
const MAGIC: &[u8] = b"ULog\x01\x12\x35";
const HEADER: usize = 16;

/// Maximum number of formats, and of bytes of their texts; PX4 has 300 with 60 000.
const FORMATS: usize = 10_000;
const TEXTS: usize = 4 << 20;

/// Maximum number of laid-out fields over all formats; PX4 has about 5 000.
const NAMES: usize = 100_000;

/// The longest message, bytes: its length has 16 bits.
const LONGEST: usize = u16::MAX as usize;

/// A message of a log.
#[derive(Debug)]
enum Message<'a> {
    /// `NAME:TYPE FIELD;...`
    Format(&'a [u8]),
    /// Assigns a format and an instance to a message number.
    Subscription {
        id: u16,
        instance: u8,
        format: &'a [u8],
    },
    /// Numbers.
    Data { id: u16, body: &'a [u8] },
    /// The logger was too slow for this long, ms.
    Dropout(u16),
    /// A message that is not needed.
    Other,
}

/// The data of a log, from the first.
pub(crate) struct Ulog {
    messages: Messages,
    formats: Formats,
    /// By number.
    subscriptions: BTreeMap<u16, Subscription>,
    plans: Plans,
    is_cut: bool,
    dropouts: u64,
    /// Total time of dropouts, ms.
    lost: u64,
}

struct Subscription {
    topic: String,
    format: String,
    /// The plan, once data has come.
    plan: Option<Rc<Plan>>,
}

/// The settings for reading data.
struct Plan {
    stamp: Option<Place>,
    names: Rc<[String]>,
    places: Vec<Place>,
}

/// The plans of formats whose data has come.
#[derive(Default)]
struct Plans {
    known: BTreeMap<String, Rc<Plan>>,
    /// Number of fields in all plans.
    fields: usize,
}

impl Plans {
    fn of(&mut self, formats: &Formats, format: &str) -> Rc<Plan> {
        if let Some(known) = self.known.get(format) {
            return Rc::clone(known);
        }
        let mut numbers = formats.numbers(format, FIELDS.min(NAMES - self.fields));
        self.fields += numbers.len();
        let stamp = numbers.iter().position(|it| it.0 == STAMP);
        let stamp = stamp.map(|it| numbers.remove(it).1);
        let (names, places): (Vec<String>, Vec<Place>) = numbers.into_iter().unzip();
        let plan = Rc::new(Plan {
            stamp,
            names: names.into(),
            places,
        });
        self.known.insert(format.to_owned(), Rc::clone(&plan));
        plan
    }
}

impl Ulog {
    /// The data of a log; `None` if the file is not a ULog.
    pub(crate) fn of(file: File) -> io::Result<Option<Self>> {
        Ok(Messages::of(file)?.map(|messages| Self {
            messages,
            formats: Formats::default(),
            subscriptions: BTreeMap::new(),
            plans: Plans::default(),
            is_cut: false,
            dropouts: 0,
            lost: 0,
        }))
    }
}

impl LogReader for Ulog {
    fn next(&mut self, message: &mut LogMessage) -> io::Result<bool> {
        loop {
            match self.messages.next() {
                Ok(Some(Message::Format(text))) => self.formats.take(text),
                Ok(Some(Message::Subscription {
                    id,
                    instance,
                    format,
                })) => {
                    let format = String::from_utf8_lossy(format).into_owned();
                    let topic = match instance {
                        0 => format.clone(),
                        instance => format!("{format}_{instance}"),
                    };
                    let plan = None;
                    let of = Subscription {
                        topic,
                        format,
                        plan,
                    };
                    self.subscriptions.insert(id, of);
                }
                Ok(Some(Message::Data { id, body })) => {
                    let Some(of) = self.subscriptions.get_mut(&id) else {
                        continue;
                    };
                    let plan =
                        (of.plan).get_or_insert_with(|| self.plans.of(&self.formats, &of.format));
                    if plan.read(&of.topic, body, message).is_some() {
                        return Ok(true);
                    }
                }
                Ok(Some(Message::Dropout(milliseconds))) => {
                    self.dropouts += 1;
                    self.lost += u64::from(milliseconds);
                }
                Ok(Some(Message::Other)) => {}
                Ok(None) => return Ok(false),
                Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                    self.is_cut = true;
                    return Ok(false);
                }
                Err(error) => return Err(error),
            }
        }
    }

    fn position(&self) -> u64 {
        self.messages.file.position()
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.is_cut {
            notes.push("the log is cut off".to_owned());
        }
        if self.messages.damaged > 0 {
            notes.push(format!(
                "the log is damaged: {} bytes belong to no message and are skipped",
                self.messages.damaged
            ));
        }
        if self.dropouts > 0 {
            notes.push(format!(
                "the logger dropped messages {} times, for {:.3} s in all",
                self.dropouts,
                self.lost as f64 * 1e-3
            ));
        }
        notes
    }
}

impl Plan {
    /// Reads data as a message; `None` if it has no time.
    fn read(&self, topic: &str, body: &[u8], message: &mut LogMessage) -> Option<()> {
        let microseconds = self.stamp?.microseconds(body)?;
        let stamp = i64::try_from(microseconds).ok()?.checked_mul(1000)?;
        message.begin(topic, stamp, &self.names);
        let values = self.places.iter().map(|it| it.read(body));
        message.values.extend(values);
        Some(())
    }
}

/// The kinds of messages that the format has.
const KINDS: &[u8] = b"BFIMPQARDLCSO";

/// Number of consecutive messages needed to resynchronise after damage.
const FOLLOWING: usize = 3;

/// The messages of a log, from the first.
struct Messages {
    file: Ahead,
    /// Positions at which data was appended after a crash; the message before each may be cut off.
    appended: Vec<u64>,
    buffer: Vec<u8>,
    /// Number of bytes that belong to no message.
    damaged: u64,
}

impl Messages {
    fn of(file: File) -> io::Result<Option<Self>> {
        let mut file = Ahead::of(file);
        let head = file.bytes(HEADER)?;
        let is_log = head.len() >= HEADER && head.starts_with(MAGIC);
        file.pass(HEADER);
        Ok(is_log.then_some(Self {
            file,
            appended: Vec::new(),
            buffer: Vec::new(),
            damaged: 0,
        }))
    }

    /// The next message; `None` at the end. An error of the kind `UnexpectedEof` means that the log is cut off.
    fn next(&mut self) -> io::Result<Option<Message<'_>>> {
        let kind = loop {
            let start = self.file.position();
            let bytes = self.file.bytes(2 * 3 + LONGEST)?;
            if bytes.is_empty() {
                return Ok(None);
            }
            if let Some((count, kind)) = header(bytes) {
                let behind = start + (3 + count) as u64;
                let appended = self.appended.iter().copied();
                if let Some(next) = appended.filter(|it| start < *it && *it < behind).min() {
                    self.file.pass((next - start) as usize);
                    continue;
                }
                // Kinds that are not known yet are letters too.
                if follow(bytes, 1, &|kind| kind.is_ascii_uppercase()) {
                    self.buffer.clear();
                    self.buffer.extend_from_slice(&bytes[3..3 + count]);
                    self.file.pass(3 + count);
                    break kind;
                }
            }
            if !self.find_again()? {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            self.damaged += self.file.position() - start;
        };
        if kind == b'B' {
            self.appended = appended(&self.buffer);
        }
        Ok(Some(message(kind, &self.buffer).unwrap_or(Message::Other)))
    }

    /// Skips damaged bytes up to the next readable message; returns whether there is one.
    fn find_again(&mut self) -> io::Result<bool> {
        loop {
            self.file.pass(1);
            let bytes = self.file.bytes(FOLLOWING * (3 + LONGEST) + 3)?;
            if bytes.is_empty() {
                return Ok(false);
            }
            if follow(bytes, FOLLOWING, &|kind| KINDS.contains(&kind)) {
                return Ok(true);
            }
        }
    }
}

/// The length and the kind of a message.
fn header(bytes: &[u8]) -> Option<(usize, u8)> {
    let [low, high, kind, ..] = *bytes else {
        return None;
    };
    Some((usize::from(u16::from_le_bytes([low, high])), kind))
}

/// Whether the bytes contain this many complete messages of such kinds, followed by the beginning of another or the end.
fn follow(bytes: &[u8], count: usize, is_kind: &dyn Fn(u8) -> bool) -> bool {
    let mut rest = bytes;
    for _ in 0..count {
        let next = header(rest).filter(|it| is_kind(it.1));
        let Some(behind) = next.and_then(|(count, _)| rest.get(3 + count..)) else {
            return false;
        };
        rest = behind;
        if rest.is_empty() {
            return true;
        }
    }
    header(rest).is_none_or(|it| is_kind(it.1))
}

/// The positions at which data was appended, from the flags.
fn appended(flags: &[u8]) -> Vec<u64> {
    let (Some(offsets), Some(incompatible)) = (flags.get(16..40), flags.get(8)) else {
        return Vec::new();
    };
    let offsets = offsets.as_chunks().0.iter();
    let offsets = offsets.map(|bytes| u64::from_le_bytes(*bytes));
    offsets
        .filter(|offset| incompatible & 1 != 0 && *offset > 0)
        .collect()
}

fn message(kind: u8, body: &[u8]) -> Option<Message<'_>> {
    let number = |at: usize| Some(u16::from_le_bytes(*body.get(at..)?.first_chunk()?));
    Some(match kind {
        b'F' => Message::Format(body),
        b'A' => Message::Subscription {
            instance: *body.first()?,
            id: number(1)?,
            format: body.get(3..)?,
        },
        b'D' => Message::Data {
            id: number(0)?,
            body: body.get(2..)?,
        },
        b'O' => Message::Dropout(number(0)?),
        _ => return None,
    })
}

/// The letter of a type of numbers.
fn letter(name: &str) -> Option<u8> {
    Some(match name {
        "int8_t" => b'b',
        "uint8_t" => b'B',
        "int16_t" => b'h',
        "uint16_t" => b'H',
        "int32_t" => b'i',
        "uint32_t" => b'I',
        "int64_t" => b'q',
        "uint64_t" => b'Q',
        "float" => b'f',
        "double" => b'd',
        "bool" => b'?',
        "char" => b'c',
        _ => return None,
    })
}

/// The place of a number in the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place {
    offset: usize,
    letter: u8,
}

impl Place {
    /// The number; `None` if there are too few bytes.
    fn read(self, data: &[u8]) -> Option<f64> {
        number(self.letter, data.get(self.offset..)?)
    }

    /// The time there, in microseconds.
    fn microseconds(self, data: &[u8]) -> Option<u64> {
        let bytes = data.get(self.offset..)?.first_chunk()?;
        (self.letter == b'Q').then(|| u64::from_le_bytes(*bytes))
    }
}

#[derive(Debug)]
struct Field {
    type_name: String,
    /// Number of elements, for a list.
    count: Option<usize>,
    name: String,
}

/// The formats of a log.
#[derive(Debug, Default)]
struct Formats {
    by_name: BTreeMap<String, Vec<Field>>,
    texts: usize,
}

impl Formats {
    /// Takes a format; skips one that is invalid or exceeds the limit.
    fn take(&mut self, text: &[u8]) {
        self.texts += text.len();
        if self.by_name.len() < FORMATS
            && self.texts <= TEXTS
            && let Some((name, fields)) = format(text)
        {
            self.by_name.insert(name, fields);
        }
    }

    /// The numbers of a format, at most `most`, each with its path. Padding and texts do not count.
    fn numbers(&self, format: &str, most: usize) -> Vec<(String, Place)> {
        let mut numbers = Vec::new();
        let mut sizes = BTreeMap::new();
        if self.size(format, &mut sizes).is_some() {
            self.lay_out(format, "", 0, &sizes, most, &mut numbers);
        }
        numbers
    }

    /// The size of a type, bytes; `None` if it is not known, contains itself, or is longer than a message.
    fn size<'f>(
        &'f self,
        name: &'f str,
        known: &mut BTreeMap<&'f str, Option<usize>>,
    ) -> Option<usize> {
        if let Some(letter) = letter(name) {
            return size(letter);
        }
        if let Some(size) = known.get(name) {
            return *size;
        }
        // Until it is known, for one that contains itself.
        known.insert(name, None);
        let mut all = 0_usize;
        for field in self.by_name.get(name)? {
            let one = self.size(&field.type_name, known)?;
            all = all.checked_add(one.checked_mul(field.count.unwrap_or(1))?)?;
            if all > LONGEST {
                return None;
            }
        }
        known.insert(name, Some(all));
        Some(all)
    }

    fn lay_out(
        &self,
        format: &str,
        prefix: &str,
        mut offset: usize,
        sizes: &BTreeMap<&str, Option<usize>>,
        most: usize,
        numbers: &mut Vec<(String, Place)>,
    ) {
        for field in self.by_name.get(format).into_iter().flatten() {
            let letter = letter(&field.type_name);
            let nested = || sizes.get(field.type_name.as_str()).copied().flatten();
            let size = letter.and_then(size).or_else(nested).unwrap_or(0);
            let is_none = field.name.starts_with("_padding") || letter == Some(b'c');
            let count = field.count.unwrap_or(1);
            // What has no size has no numbers.
            let elements = if is_none || size == 0 { 0 } else { count };
            for element in 0..elements {
                if numbers.len() >= most {
                    return;
                }
                let path = match field.count {
                    None => format!("{prefix}{}", field.name),
                    Some(_) => format!("{prefix}{}[{element}]", field.name),
                };
                let offset = offset + element * size;
                match letter {
                    Some(letter) => numbers.push((path, Place { offset, letter })),
                    None => {
                        let prefix = path + ".";
                        self.lay_out(&field.type_name, &prefix, offset, sizes, most, numbers);
                    }
                }
            }
            offset += count * size;
        }
    }
}

/// The name and the fields of `NAME:TYPE FIELD;TYPE[COUNT] FIELD;`.
fn format(text: &[u8]) -> Option<(String, Vec<Field>)> {
    let (name, fields) = std::str::from_utf8(text).ok()?.split_once(':')?;
    let field = |text: &str| {
        let (kind, name) = text.split_once(' ')?;
        let (type_name, count) = match kind.split_once('[') {
            None => (kind, None),
            Some((kind, count)) => (kind, Some(count.strip_suffix(']')?.parse().ok()?)),
        };
        Some(Field {
            type_name: type_name.to_owned(),
            count,
            name: name.to_owned(),
        })
    };
    let fields = fields.split(';').filter(|it| !it.is_empty());
    Some((name.to_owned(), fields.map(field).collect::<Option<_>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formats(texts: &[&str]) -> Formats {
        let mut formats = Formats::default();
        texts.iter().for_each(|it| formats.take(it.as_bytes()));
        formats
    }

    #[test]
    fn numbers_are_found_in_nested_formats() {
        let formats = formats(&[
            "arm:uint64_t timestamp;char[3] name;joint[2] joints;bool ok;uint8_t[2] _padding0;",
            "joint:float angle;int16_t[2] raw;",
        ]);
        let found = formats.numbers("arm", 100);
        let names: Vec<&str> = found.iter().map(|it| it.0.as_str()).collect();
        assert_eq!(
            names,
            [
                "timestamp",
                "joints[0].angle",
                "joints[0].raw[0]",
                "joints[0].raw[1]",
                "joints[1].angle",
                "joints[1].raw[0]",
                "joints[1].raw[1]",
                "ok"
            ]
        );
        let mut data = vec![0; 28];
        data[..8].copy_from_slice(&7_u64.to_le_bytes());
        data[19..23].copy_from_slice(&0.5_f32.to_le_bytes());
        data[25..27].copy_from_slice(&(-3_i16).to_le_bytes());
        data[27] = 1;
        let numbers: Vec<_> = found.iter().map(|it| it.1.read(&data)).collect();
        let expected = [7.0, 0.0, 0.0, 0.0, 0.5, 0.0, -3.0, 1.0];
        assert_eq!(numbers, expected.map(Some));
        assert_eq!(found[0].1.microseconds(&data), Some(7));
        assert_eq!(found[7].1.read(&data[..27]), None);
        assert_eq!(formats.numbers("arm", 3).len(), 3);
    }

    #[test]
    fn a_format_is_laid_out_once_and_all_formats_up_to_a_limit() {
        let texts: Vec<String> = (0..200)
            .map(|it| format!("f{it}:uint64_t timestamp;float[1000] x;"))
            .collect();
        let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
        let (formats, mut plans) = (formats(&texts), Plans::default());
        let first = plans.of(&formats, "f0");
        assert!(Rc::ptr_eq(&first, &plans.of(&formats, "f0")));
        let made: Vec<_> = (0..200)
            .map(|it| plans.of(&formats, &format!("f{it}")))
            .collect();
        let names: usize = made.iter().map(|it| it.names.len()).sum();
        assert!(names <= NAMES && plans.fields == NAMES, "{names}");
        assert!(made[199].stamp.is_none());
    }

    #[test]
    fn formats_made_to_hurt_have_no_numbers_or_few() {
        for texts in [
            &["a:a x;"][..],
            &["a:b x;", "b:a x;"],
            &["a:float[99999999999999999999] x;"],
            &["a:double[9000] x;"],
            &[
                "a:b[60000] x;b[60000] y;",
                "b:c[60000] x;",
                "c:d[60000] x;",
                "d:",
            ],
            &["a:nothing x;"],
            &["a:float"],
            &["a:float[ x;"],
            &["a"],
            &[":float x;"],
        ] {
            assert!(formats(texts).numbers("a", 10).is_empty(), "{texts:?}");
        }
        let many = formats(&["a:b[255] x;", "b:uint8_t[255] x;"]);
        assert_eq!(many.numbers("a", 1000).len(), 1000);
        // Each twice the one before: sizes are worked out once.
        let doubled: Vec<String> = (0..1000)
            .map(|k| format!("f{k}:f{0} x;f{0} y;", k + 1))
            .collect();
        let doubled: Vec<&str> = doubled.iter().map(String::as_str).collect();
        assert!(formats(&doubled).numbers("f0", 10).is_empty());
    }
}
