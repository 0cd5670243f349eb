//! Numbers in binary log messages, little-endian, by the letters of Python's `struct`.

/// The size of a number, bytes.
pub(crate) fn size(letter: u8) -> Option<usize> {
    Some(match letter {
        b'b' | b'B' | b'c' | b'?' => 1,
        b'h' | b'H' => 2,
        b'i' | b'I' | b'f' => 4,
        b'q' | b'Q' | b'd' => 8,
        _ => return None,
    })
}

/// The number at the beginning of the bytes; `None` if there are too few bytes.
pub(crate) fn number(letter: u8, bytes: &[u8]) -> Option<f64> {
    macro_rules! of {
        ($number:ty) => {
            <$number>::from_le_bytes(*bytes.first_chunk()?)
        };
    }
    Some(match letter {
        b'b' => f64::from(of!(i8)),
        b'B' => f64::from(of!(u8)),
        b'?' => f64::from(u8::from(of!(u8) != 0)),
        b'h' => f64::from(of!(i16)),
        b'H' => f64::from(of!(u16)),
        b'i' => f64::from(of!(i32)),
        b'I' => f64::from(of!(u32)),
        b'q' => of!(i64) as f64,
        b'Q' => of!(u64) as f64,
        b'f' => f64::from(of!(f32)),
        b'd' => of!(f64),
        _ => return None,
    })
}
