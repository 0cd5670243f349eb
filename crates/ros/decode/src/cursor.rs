//! A position in a payload; reading beyond the end is an error.
//!
//! A payload begins with four bytes of encapsulation (RTPS 2.3, section 10.2): the first two give the encoding and the byte order. Lengths are
//! 32-bit numbers; a wrong length is detected when its bytes are read, before memory is reserved for them.

use planesman_rosidl::definition::Primitive;

use crate::layout::{Advance, size_of};

/// The reason why a payload cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// A payload shorter than the encapsulation header.
    #[error("a payload of {0} bytes has no encapsulation header")]
    NoHeader(usize),
    /// An encoding other than plain CDR.
    #[error("encapsulation {id:#06x} ({name}) is not plain CDR (0x0000 or 0x0001)", name = encoding_name(*id))]
    Encapsulation {
        /// Encoding number in the header.
        id: u16,
    },
    /// A message that is not a JSON object.
    #[error("the message is not JSON, or longer than 1 MiB")]
    Json,
    /// The message continues after the payload's end.
    #[error("the message is cut off or has another type: it ends at byte {at} of {length}")]
    Short {
        /// Position of the read, bytes.
        at: usize,
        /// Size of the payload without header, bytes.
        length: usize,
    },
}

fn encoding_name(id: u16) -> &'static str {
    match id {
        2 | 3 => "parameter list",
        6 | 7 => "XCDR2",
        8 | 9 => "delimited XCDR2",
        10 | 11 => "parameter list, XCDR2",
        4 | 5 => "XML",
        // The beginning of a zstd frame.
        0x28b5 => {
            "zstd: rosbag2 compressed each message; open the bag's folder with its metadata.yaml instead"
        }
        _ => "unknown",
    }
}

/// A position in a payload.
#[derive(Clone, Debug)]
pub(crate) struct Cursor<'a> {
    /// The payload after the encapsulation header.
    body: &'a [u8],
    at: usize,
    little_endian: bool,
    /// Bytes per character of a wide string.
    wide: u64,
}

impl<'a> Cursor<'a> {
    /// Starts at the beginning of a payload.
    pub(crate) fn new(payload: &'a [u8]) -> Result<Self, DecodeError> {
        let Some((&[first, second, _, _], body)) = payload.split_first_chunk::<4>() else {
            return Err(DecodeError::NoHeader(payload.len()));
        };
        let id = u16::from_be_bytes([first, second]);
        if id > 1 {
            return Err(DecodeError::Encapsulation { id });
        }
        Ok(Self {
            body,
            at: 0,
            little_endian: id == 1,
            wide: 2,
        })
    }

    /// The same position, for wide strings with this many bytes per character instead of the usual two.
    pub(crate) fn with_wide_characters(mut self, bytes: u64) -> Self {
        self.wide = bytes;
        self
    }

    fn short(&self) -> DecodeError {
        DecodeError::Short {
            at: self.at,
            length: self.body.len(),
        }
    }

    /// Number of remaining bytes.
    pub(crate) fn left(&self) -> usize {
        self.body.len() - self.at
    }

    /// Skips `bytes` bytes.
    fn pass_bytes(&mut self, bytes: u64) -> Result<(), DecodeError> {
        if bytes > self.left() as u64 {
            return Err(self.short());
        }
        self.at += bytes as usize;
        Ok(())
    }

    /// Skips a part of fixed size.
    pub(crate) fn pass(&mut self, part: &Advance) -> Result<(), DecodeError> {
        self.pass_bytes(part.from(self.at))
    }

    /// Skips a string with its length; wide strings have no terminator.
    pub(crate) fn pass_text(&mut self, wide: bool) -> Result<(), DecodeError> {
        let length = self.length()?;
        self.pass_bytes(length * if wide { self.wide } else { 1 })
    }

    /// Reads a string of one-byte characters, without its terminator.
    pub(crate) fn text(&mut self) -> Result<&'a [u8], DecodeError> {
        let length = self.length()?;
        let start = self.at;
        self.pass_bytes(length)?;
        let bytes = &self.body[start..self.at];
        Ok(bytes.strip_suffix(&[0]).unwrap_or(bytes))
    }

    /// Reads any string, without its terminator; invalid characters are replaced.
    pub(crate) fn string(&mut self, wide: bool) -> Result<String, DecodeError> {
        if !wide {
            return Ok(String::from_utf8_lossy(self.text()?).into_owned());
        }
        let count = self.length()?;
        let unit = match self.wide {
            2 => Primitive::Uint16,
            _ => Primitive::Uint32,
        };
        let characters = self.numbers(unit, count)?;
        let characters = (0..count as usize).filter_map(|index| characters.get(index));
        if unit == Primitive::Uint16 {
            let units: Vec<u16> = characters.map(|it| it as u16).collect();
            return Ok(String::from_utf16_lossy(&units));
        }
        let read = |it: f64| char::from_u32(it as u32).unwrap_or(char::REPLACEMENT_CHARACTER);
        Ok(characters.map(read).collect())
    }

    /// Reads the length of a string or sequence.
    pub(crate) fn length(&mut self) -> Result<u64, DecodeError> {
        self.numbers(Primitive::Uint32, 1)?
            .get(0)
            .map(|length| length as u64)
            .ok_or_else(|| self.short())
    }

    /// Reads `count` consecutive numbers; zero numbers need no padding.
    pub(crate) fn numbers(
        &mut self,
        primitive: Primitive,
        count: u64,
    ) -> Result<Numbers<'a>, DecodeError> {
        let size = size_of(primitive);
        let mut bytes: &[u8] = &[];
        if count > 0 {
            let start = self.at.next_multiple_of(size);
            let length = usize::try_from(count)
                .ok()
                .and_then(|count| count.checked_mul(size))
                .ok_or_else(|| self.short())?;
            bytes = self
                .body
                .get(start..)
                .and_then(|rest| rest.get(..length))
                .ok_or_else(|| self.short())?;
            self.at = start + length;
        }
        Ok(Numbers {
            bytes,
            primitive,
            little_endian: self.little_endian,
        })
    }
}

/// Consecutive numbers of one type.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbers<'a> {
    bytes: &'a [u8],
    primitive: Primitive,
    little_endian: bool,
}

impl<'a> Numbers<'a> {
    /// The numbers' bytes, and whether they are little endian.
    pub(crate) fn bytes(&self) -> (&'a [u8], bool) {
        (self.bytes, self.little_endian)
    }

    /// Their type.
    pub(crate) fn primitive(&self) -> Primitive {
        self.primitive
    }

    /// The bits of the eight-byte number `index`.
    pub(crate) fn wide(&self, index: usize) -> Option<u64> {
        let bytes = *self.bytes.as_chunks().0.get(index)?;
        Some(match self.little_endian {
            true => u64::from_le_bytes(bytes),
            false => u64::from_be_bytes(bytes),
        })
    }

    /// Number `index`; 64-bit integers are rounded to the nearest `f64`.
    pub(crate) fn get(&self, index: usize) -> Option<f64> {
        let size = size_of(self.primitive);
        let bytes = self.bytes.get(index.checked_mul(size)?..)?.get(..size)?;
        macro_rules! number {
            ($number:ty) => {{
                let bytes = bytes.try_into().ok()?;
                if self.little_endian {
                    <$number>::from_le_bytes(bytes)
                } else {
                    <$number>::from_be_bytes(bytes)
                }
            }};
        }
        Some(match self.primitive {
            Primitive::Bool => f64::from(u8::from(number!(u8) != 0)),
            Primitive::Byte | Primitive::Char | Primitive::Uint8 => f64::from(number!(u8)),
            Primitive::Int8 => f64::from(number!(i8)),
            Primitive::Int16 => f64::from(number!(i16)),
            Primitive::Uint16 => f64::from(number!(u16)),
            Primitive::Int32 => f64::from(number!(i32)),
            Primitive::Uint32 => f64::from(number!(u32)),
            Primitive::Int64 => number!(i64) as f64,
            Primitive::Uint64 => number!(u64) as f64,
            Primitive::Float32 => f64::from(number!(f32)),
            Primitive::Float64 => number!(f64),
        })
    }

    /// Appends all numbers to `list`.
    pub(crate) fn append_to(self, list: &mut Vec<f64>) {
        if self.primitive == Primitive::Float64 && self.little_endian {
            // The usual ones, without looking at each what it is.
            let (numbers, _) = self.bytes.as_chunks();
            list.extend(numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)));
            return;
        }
        let count = self.bytes.len() / size_of(self.primitive);
        list.extend((0..count).filter_map(|index| self.get(index)));
    }
}
