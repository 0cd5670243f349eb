//! Which crate recomputes which numbers of the 1988 report.

use planesman_book::{Book, BookError};

/// All shares as one book.
///
/// # Errors
/// When a share cannot be read, or two of them hold a number of the same name.
pub fn book() -> Result<Book, BookError> {
    Book::of_shares([
        brunner_1988::vehicle::book()?,
        brunner_1988::controllers::book()?,
        sysid::book::brunner_1988()?,
    ])
}

/// The numbers of all shares, computed again.
#[must_use]
pub fn recomputed() -> planesman_book::Recomputed {
    let named = |(id, value): (&str, f64)| (id.to_owned(), value);
    let vehicle = brunner_1988::vehicle::recomputed().into_iter().map(named);
    let identification = sysid::book::recomputed().into_iter().map(named);
    vehicle
        .chain(brunner_1988::controllers::recomputed())
        .chain(identification)
        .collect()
}
