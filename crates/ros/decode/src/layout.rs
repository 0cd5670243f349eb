//! Sizes in CDR, which depend on where a part begins.
//!
//! Plain CDR (XCDR version 1; OMG CORBA 3.0.3, section 15.3) aligns each number to its own size, counted from the end of the encapsulation
//! header. A struct is its fields, an array its elements. The largest number has 8 bytes, so the size of a part depends only on its start modulo
//! 8. Eight numbers describe this ([`Advance`]), and consecutive parts compose.

use planesman_rosidl::definition::Primitive;

/// Size of a part, with padding, as a function of its offset modulo 8.
///
/// Saturates at the maximum of `u64`, which no payload reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Advance([u64; 8]);

impl Advance {
    /// An empty part.
    pub(crate) const NONE: Self = Self([0; 8]);

    /// A number of `size` bytes: 1, 2, 4 or 8.
    pub(crate) fn number(size: usize) -> Self {
        Self(std::array::from_fn(|at| {
            (at.next_multiple_of(size) - at + size) as u64
        }))
    }

    /// This part followed by `next`.
    pub(crate) fn then(self, next: Self) -> Self {
        Self(std::array::from_fn(|at| {
            let first = self.0[at];
            first.saturating_add(next.from(at.wrapping_add(first as usize)))
        }))
    }

    /// `count` such parts in a row, by repeated squaring.
    pub(crate) fn times(self, mut count: u64) -> Self {
        let (mut product, mut power) = (Self::NONE, self);
        while count > 0 {
            if count % 2 == 1 {
                product = product.then(power);
            }
            power = power.then(power);
            count /= 2;
        }
        product
    }

    /// Size of a part that begins at byte `at`.
    pub(crate) fn from(&self, at: usize) -> u64 {
        self.0[at % 8]
    }
}

/// Size of a number, bytes.
pub(crate) fn size_of(primitive: Primitive) -> usize {
    match primitive {
        Primitive::Bool
        | Primitive::Byte
        | Primitive::Char
        | Primitive::Int8
        | Primitive::Uint8 => 1,
        Primitive::Int16 | Primitive::Uint16 => 2,
        Primitive::Int32 | Primitive::Uint32 | Primitive::Float32 => 4,
        Primitive::Int64 | Primitive::Uint64 | Primitive::Float64 => 8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_in_a_row_take_what_they_take_one_by_one() {
        // A byte, a double, a short: 1 + 7 + 8 + 2 from the beginning.
        let part = Advance::number(1)
            .then(Advance::number(8))
            .then(Advance::number(2));
        assert_eq!(part.from(0), 18);
        assert_eq!(part.from(7), 1 + 8 + 2);
        for start in 0..8 {
            let mut at = start;
            for count in 0..100 {
                assert_eq!(part.times(count).from(start), (at - start) as u64);
                at += part.from(at) as usize;
            }
        }
    }

    #[test]
    fn what_no_file_could_hold_saturates() {
        let mut part = Advance::number(8);
        for _ in 0..64 {
            part = part.times(u64::from(u32::MAX));
        }
        assert_eq!(part.from(0), u64::MAX);
    }
}
