//! Which node recomputes which numbers of the 1988 report.

use planesman_book::{Book, BookError};

/// What a node has of the report.
struct Share {
    /// The node.
    node: &'static str,
    /// The numbers of the part of the report that it models.
    book: fn() -> Result<Book, BookError>,
    /// What they come to: name and value, in the entry's unit.
    recomputed: fn() -> Vec<(&'static str, f64)>,
}

const SHARES: &[Share] = &[
    Share {
        node: "plant_sim",
        book: brunner_1988::vehicle::book,
        recomputed: brunner_1988::vehicle::recomputed,
    },
    Share {
        node: "depth_controller",
        book: depth_controller::book::brunner_1988,
        recomputed: depth_controller::book::recomputed,
    },
    Share {
        node: "the identification",
        book: brunner_1988::identification::book,
        recomputed: brunner_1988::identification::recomputed,
    },
];

/// All shares as one book.
///
/// # Errors
/// When a share cannot be read, or two of them hold a number of the same name.
pub fn book() -> anyhow::Result<Book> {
    let shares: Vec<Book> = SHARES
        .iter()
        .map(|share| {
            (share.book)().map_err(|e| anyhow::anyhow!("the numbers of {}: {e}", share.node))
        })
        .collect::<anyhow::Result<_>>()?;
    Ok(Book::of_shares(shares)?)
}

/// What all shares come to.
#[must_use]
pub fn recomputed() -> Vec<(&'static str, f64)> {
    SHARES
        .iter()
        .flat_map(|share| (share.recomputed)())
        .collect()
}
