//! The controllers of ch. II and program T6: designs, step responses, root loci, numbers.
//!
//! - [`axis`]: an axis of the vehicle as a damped inertia; [`pitch`], [`roll`], [`heading`]: its constants.
//! - [`depth`]: the depth loop around the pitch loop: stability, critical speed, closed loop.
//! - [`program_t6`]: program T6, flown through the controller's loops.
//! - [`root_loci`], [`time_responses`]: the lost figures.
//! - [`book`], [`recomputed`]: `data/brunner_1988/controllers.json`, and its numbers computed again.
//!
//! Angles are dive-positive here, as in program T6. Every equation is homogeneous, so any consistent units will do;
//! the constants are the report's, in feet, pounds-force and seconds.

use crate::book::{Book, BookError, Recomputed};

pub mod axis;
mod book_loops;
mod book_t6;
pub mod depth;
pub mod heading;
pub mod pitch;
pub mod program_t6;
pub mod roll;
pub mod root_loci;
pub mod time_responses;
mod values;

/// The report's numbers on the controllers, and its errata.
///
/// # Errors
/// [`BookError`]; a test reads the files that are compiled in.
pub fn book() -> Result<Book, BookError> {
    Book::parse(
        include_str!("../../../data/brunner_1988/controllers.json"),
        include_str!("../../../data/brunner_1988/errata.json"),
    )
}

/// The numbers as this crate computes them.
#[must_use]
pub fn recomputed() -> Recomputed {
    let mut all = book_t6::recomputed();
    all.extend(book_loops::recomputed());
    all.into_iter()
        .map(|(id, value)| (id.to_owned(), value))
        .collect()
}
