//! Selection of the topics that a recorder writes into its bag, and the recording options.
//!
//! - [`parameters`]: folder, compression, flush interval, splitting, topics.
//! - [`in_bag()`]: a topic of the loop with its QoS.
//! - [`selection`]: selection among the domain's topics.
//! - [`names`]: name of a bag from date and time.

mod in_bag;
pub mod names;
pub mod parameters;
pub mod selection;

pub use in_bag::in_bag;
