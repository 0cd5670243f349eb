//! Compares two recordings message by message, each topic separately.
//!
//! Payloads are first compared as bytes; only different payloads are decoded by the bag's schema and compared field by field. Messages are paired by
//! their own stamps (`pairing`), so a missing message does not shift all later pairs. The time of reception is not compared.
//!
//! - [`diff`]: compares; [`Options`]: what counts as a difference.
//! - [`Comparison`], [`TopicResult`], [`FieldResult`], [`First`]: the result; `text` prints it.
//! - [`histories`]: time histories of differing fields.
//! - [`CanonicalOrder`]: a topic's messages in an order that does not depend on the recorder.
//!
//! Internal: `recording` reads bags and tables in the same way, `rules` has tolerances and ignored fields.

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
