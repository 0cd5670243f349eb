//! Message payloads as DDS sends them and bags store them: plain CDR after a 4-byte header.
//!
//! The header names the encoding (RTPS 2.3, section 10): `00 01 00 00` is CDR in little-endian order,
//! which this module writes; it also reads `00 00 00 00`, big-endian. Numbers are aligned to their
//! own size, counted from the end of the header.

use byteorder::{BigEndian, LittleEndian};

use crate::Message;

/// The length of the encapsulation header, bytes.
pub const HEADER: usize = 4;
const LITTLE_ENDIAN: [u8; HEADER] = [0, 1, 0, 0];
/// Writers may fill a payload up to a multiple of four bytes.
const MOST_PADDING: usize = 3;

/// The reason why a payload is not a message of the expected type.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Shorter than the encapsulation header.
    #[error("a payload of {0} bytes has no encapsulation header")]
    NoHeader(usize),
    /// An encoding that is not plain CDR.
    #[error("encapsulation {0:#06x} is not plain CDR (0x0000 or 0x0001)")]
    Encapsulation(u16),
    /// Bytes that do not decode to the message's fields, or too few bytes.
    #[error("not a {type_name}: {source}")]
    Fields {
        /// The message that was expected.
        type_name: &'static str,
        /// The reason.
        source: cdr_encoding::Error,
    },
    /// More bytes than the message's fields need.
    #[error("not a {type_name}: {count} bytes are left over at the end")]
    LeftOver {
        /// The message that was expected.
        type_name: &'static str,
        /// Number of remaining bytes.
        count: usize,
    },
}

/// The payload of a message: header and little-endian CDR.
#[must_use]
pub fn to_bytes<M: Message>(message: &M) -> Vec<u8> {
    let mut bytes = Vec::new();
    append(&mut bytes, message);
    bytes
}

/// Like [`to_bytes`], but appends to `bytes`, so that many messages need no allocation each.
pub fn append<M: Message>(bytes: &mut Vec<u8>, message: &M) {
    bytes.extend(LITTLE_ENDIAN);
    // Writing to a Vec cannot fail, and generated structs hold nothing that CDR has no form for.
    let written = cdr_encoding::to_writer::<M, LittleEndian, _>(bytes, message);
    debug_assert!(written.is_ok(), "{} does not fit CDR", M::TYPE_NAME);
}

/// Decodes the message in a payload.
///
/// A false length costs no memory: elements are decoded one by one, until the payload ends.
///
/// # Errors
/// [`Error`] if the payload is not exactly one message of this type.
pub fn from_bytes<M: Message>(bytes: &[u8]) -> Result<M, Error> {
    let type_name = M::TYPE_NAME;
    let Some((&[first, second, _, _], body)) = bytes.split_first_chunk::<HEADER>() else {
        return Err(Error::NoHeader(bytes.len()));
    };
    let (message, used) = match u16::from_be_bytes([first, second]) {
        0 => cdr_encoding::from_bytes::<M, BigEndian>(body),
        1 => cdr_encoding::from_bytes::<M, LittleEndian>(body),
        other => return Err(Error::Encapsulation(other)),
    }
    .map_err(|source| Error::Fields { type_name, source })?;
    match body.len() - used {
        count if count > MOST_PADDING => Err(Error::LeftOver { type_name, count }),
        _ => Ok(message),
    }
}
