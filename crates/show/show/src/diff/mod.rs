//! Two recordings compared message by message, each topic for itself.
//!
//! Payloads are compared as bytes first; only those that differ are decoded, by the schema in the bag, and compared field by field.
//! Messages are paired by their own stamps (`pairing`), so that a missing message is missing and no shift of all that follow it.
//! The time at which a recorder received a message is not compared.
//!
//! - [`diff`]: compares; [`Options`]: what counts as a difference.
//! - [`Comparison`], [`TopicResult`], [`FieldResult`], [`First`]: what was found; as text by `text`.
//! - [`histories`]: the fields that differ, over time.
//! - [`CanonicalOrder`]: a topic's messages in an order that does not depend on the recorder.
//!
//! Inside: `recording` reads bags and tables alike, `rules` are tolerances and what is ignored.

mod comparison;
mod histories;
mod merge;
mod options;
mod pairing;
mod recording;
mod rules;
mod text;

pub use comparison::{Comparison, FieldResult, First, Largest, TopicResult, What};
pub use histories::{History, histories};
pub use merge::diff;
pub use options::{ColumnOf, DiffError, Options, WALL_TIME};
pub use pairing::CanonicalOrder;
pub use recording::stamp_decoder;
pub use rules::{Rule, RuleError, Tolerance};
