//! Which topics a recorder writes into its bag, and how.
//!
//! - [`parameters`]: where to, how compressed, how often flushed, how split, which topics.
//! - [`in_bag()`]: a topic of the loop with its QoS.
//! - [`selection`]: which of the domain's topics.
//! - [`names`]: a bag's name from the time of day.

mod in_bag;
pub mod names;
pub mod parameters;
pub mod selection;

pub use in_bag::in_bag;
