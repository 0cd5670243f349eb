//! PX4's log format ULog, as far as signals need it: formats, subscriptions, data, dropouts (PX4 user guide, "ULog File Format").
//!
//! It is read here rather than by PX4's own parser (crate `px4-ulog` 0.6), which panics on short messages and lays out every field
//! of every format, 65 535 of them for a line of text. Here a length costs no more than the bytes that are there, and
//! only the fields asked for are laid out.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;

use crate::ahead::Ahead;

/// The first bytes of a log; a version and a time follow.
const MAGIC: &[u8] = b"ULog\x01\x12\x35";
const HEADER: usize = 16;

/// Formats, and bytes of their texts, at most; PX4 has 300 with 60 000.
const FORMATS: usize = 10_000;
const TEXTS: usize = 4 << 20;

/// The longest message, bytes: its length has 16 bits.
const LONGEST: usize = u16::MAX as usize;

/// A message of a log.
#[derive(Debug)]
pub(crate) enum Message<'a> {
    /// `NAME:TYPE FIELD;...`
    Format(&'a [u8]),
    /// Data of this number are of that format, and of that instance of it.
    Subscription {
        id: u16,
        instance: u8,
        format: &'a [u8],
    },
    /// Numbers.
    Data { id: u16, body: &'a [u8] },
    /// The logger was too slow for so long, ms.
    Dropout(u16),
    /// Nothing that is needed.
    Other,
}

/// The kinds of messages that the format has.
const KINDS: &[u8] = b"BFIMPQARDLCSO";

/// Messages that must follow each other where a log is found again behind damage.
const FOLLOWING: usize = 3;

/// The messages of a log, from the first.
pub(crate) struct Messages {
    file: Ahead,
    /// Where data was appended after a crash; the message before may be cut off.
    appended: Vec<u64>,
    buffer: Vec<u8>,
    /// Bytes that are of no message.
    pub(crate) damaged: u64,
}

impl Messages {
    /// The messages of a log; `None` if the file is none.
    pub(crate) fn of(file: File) -> io::Result<Option<Self>> {
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

    /// The bytes that have been read.
    pub(crate) fn position(&self) -> u64 {
        self.file.position()
    }

    /// The next message; `None` at the end. An error of the kind `UnexpectedEof` says that the log is cut off.
    pub(crate) fn next(&mut self) -> io::Result<Option<Message<'_>>> {
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

    /// Goes on to where messages follow each other again; returns whether they do.
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

/// Whether so many whole messages of such kinds stand there, and the beginning of another behind them, or the end.
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

/// Where data was appended, as the flags say.
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

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
    Int8,
    Uint8,
    Int16,
    Uint16,
    Int32,
    Uint32,
    Int64,
    Uint64,
    Float,
    Double,
    Bool,
    Char,
}

impl Number {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "int8_t" => Self::Int8,
            "uint8_t" => Self::Uint8,
            "int16_t" => Self::Int16,
            "uint16_t" => Self::Uint16,
            "int32_t" => Self::Int32,
            "uint32_t" => Self::Uint32,
            "int64_t" => Self::Int64,
            "uint64_t" => Self::Uint64,
            "float" => Self::Float,
            "double" => Self::Double,
            "bool" => Self::Bool,
            "char" => Self::Char,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::Int8 | Self::Uint8 | Self::Bool | Self::Char => 1,
            Self::Int16 | Self::Uint16 => 2,
            Self::Int32 | Self::Uint32 | Self::Float => 4,
            Self::Int64 | Self::Uint64 | Self::Double => 8,
        }
    }
}

/// Where a number is in the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    offset: usize,
    number: Number,
}

impl Place {
    /// The number; `None` if the data ends before it.
    pub(crate) fn read(self, data: &[u8]) -> Option<f64> {
        let bytes = data.get(self.offset..)?;
        macro_rules! of {
            ($number:ty) => {
                <$number>::from_le_bytes(*bytes.first_chunk()?)
            };
        }
        Some(match self.number {
            Number::Int8 => f64::from(of!(i8)),
            Number::Uint8 | Number::Char => f64::from(of!(u8)),
            Number::Bool => f64::from(u8::from(of!(u8) != 0)),
            Number::Int16 => f64::from(of!(i16)),
            Number::Uint16 => f64::from(of!(u16)),
            Number::Int32 => f64::from(of!(i32)),
            Number::Uint32 => f64::from(of!(u32)),
            Number::Int64 => of!(i64) as f64,
            Number::Uint64 => of!(u64) as f64,
            Number::Float => f64::from(of!(f32)),
            Number::Double => of!(f64),
        })
    }

    /// The time there, in microseconds.
    pub(crate) fn microseconds(self, data: &[u8]) -> Option<u64> {
        let bytes = data.get(self.offset..)?.first_chunk()?;
        (self.number == Number::Uint64).then(|| u64::from_le_bytes(*bytes))
    }
}

#[derive(Debug)]
struct Field {
    type_name: String,
    /// Elements, of a list.
    count: Option<usize>,
    name: String,
}

/// The formats of a log.
#[derive(Debug, Default)]
pub(crate) struct Formats {
    by_name: BTreeMap<String, Vec<Field>>,
    texts: usize,
}

impl Formats {
    /// Takes a format; one that is not written as it should be, or for which there is no room, is passed over.
    pub(crate) fn take(&mut self, text: &[u8]) {
        self.texts += text.len();
        if self.by_name.len() < FORMATS
            && self.texts <= TEXTS
            && let Some((name, fields)) = format(text)
        {
            self.by_name.insert(name, fields);
        }
    }

    /// The numbers of a format, at most so many: each with its path. Padding and texts are none.
    pub(crate) fn numbers(&self, format: &str, most: usize) -> Vec<(String, Place)> {
        let mut numbers = Vec::new();
        let mut sizes = BTreeMap::new();
        if self.size(format, &mut sizes).is_some() {
            self.lay_out(format, "", 0, &sizes, most, &mut numbers);
        }
        numbers
    }

    /// The bytes of a type; `None` if it is not known, contains itself, or is longer than a message.
    fn size<'f>(
        &'f self,
        name: &'f str,
        known: &mut BTreeMap<&'f str, Option<usize>>,
    ) -> Option<usize> {
        if let Some(number) = Number::named(name) {
            return Some(number.size());
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
            let number = Number::named(&field.type_name);
            let nested = || sizes.get(field.type_name.as_str()).copied().flatten();
            let size = number.map(Number::size).or_else(nested).unwrap_or(0);
            let is_none = field.name.starts_with("_padding") || number == Some(Number::Char);
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
                match number {
                    Some(number) => numbers.push((path, Place { offset, number })),
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
