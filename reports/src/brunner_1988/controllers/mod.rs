//! The controllers of ch. II and program T6: designs, step responses, root loci, numbers.
//!
//! - [`axis`]: an axis of the vehicle as a damped inertia; [`pitch`], [`roll`], [`heading`]: constants of the axes.
//! - [`depth`]: the depth loop around the pitch loop: stability, critical speed, closed loop.
//! - [`program_t6`]: program T6, simulated with the controller's loops.
//! - [`root_loci`], [`time_responses`]: figures missing in the copy.
//! - [`book`], [`recomputed`]: `data/brunner_1988/controllers.json`, and its recomputed numbers.
//!
//! Angles are positive to dive here, as in program T6. All equations are homogeneous, so any consistent units are valid; the constants are the
//! report's, in feet, pounds-force and seconds.

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

/// The report's numbers on controllers, with its errata.
///
/// # Errors
/// [`BookError`]; a test reads the compiled-in files.
pub fn book() -> Result<Book, BookError> {
    Book::parse(
        include_str!("../../../data/brunner_1988/controllers.json"),
        include_str!("../../../data/brunner_1988/errata.json"),
    )
}

/// The numbers as recomputed by this crate.
#[must_use]
pub fn recomputed() -> Recomputed {
    let mut all = book_t6::recomputed();
    all.extend(book_loops::recomputed());
    all.into_iter()
        .map(|(id, value)| (id.to_owned(), value))
        .collect()
}
