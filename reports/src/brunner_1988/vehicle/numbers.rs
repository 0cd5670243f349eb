//! The book of the vehicle's numbers.

use std::sync::LazyLock;

use crate::book::{Book, BookError};

/// The book in a static variable, so that values may borrow the entries' names.
pub(super) static BOOK: LazyLock<Option<Book>> = LazyLock::new(|| book().ok());

/// Recomputed numbers: name and value, in the entry's unit.
pub(super) type Recomputed = Vec<(&'static str, f64)>;

/// Numbers of the vehicle and its instruments, with the report's errata.
///
/// # Errors
/// [`BookError`]; a test reads the compiled-in files.
pub fn book() -> Result<Book, BookError> {
    Book::parse(
        include_str!("../../../data/brunner_1988/vehicle.json"),
        include_str!("../../../data/brunner_1988/errata.json"),
    )
}
