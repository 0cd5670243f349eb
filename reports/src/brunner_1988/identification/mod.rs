//! Identification of ch. V: the procedure on synthetic records, Tables 8 and 9, Figures 45 to 56.
//!
//! - [`synthetic`]: five synthetic runs that replace the lost records.
//! - [`procedure`]: the steps of p. 94 f., as printed; [`procedure_text()`] carries them out run by run.
//! - [`book()`], [`recomputed`], [`table_9`]: the printed numbers of Table 9.
//! - [`figures()`]: Figures 45 to 56.

mod book;
mod figures;
pub mod procedure;
mod procedure_text;
pub mod synthetic;

pub use book::{book, recomputed, table_9};
pub use figures::figures;
pub use procedure_text::procedure_text;
