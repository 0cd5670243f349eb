//! Which crate recomputes which numbers of the 1988 report.

use planesman_book::{Book, BookError};

/// All shares as one book.
///
/// # Errors
/// When a share cannot be read, or two of them hold a number of the same name.
pub fn book() -> Result<Book, BookError> {
    Book::of_shares([
        plant_sim::book::brunner_1988()?,
        depth_controller::book::brunner_1988()?,
        sysid::book::brunner_1988()?,
    ])
}

/// The numbers of all shares, computed again.
#[must_use]
pub fn recomputed() -> planesman_book::Recomputed {
    [
        plant_sim::book::recomputed(),
        depth_controller::book::recomputed(),
        sysid::book::recomputed(),
    ]
    .concat()
    .into_iter()
    .map(|(id, value)| (id.to_owned(), value))
    .collect()
}
