//! Logs as people have them: each is made here from a plant that is known, and is read right or refused with the way out.
//!
//! ```text
//! cargo test --test field
//! ```

#![allow(clippy::unwrap_used)]

mod answer;
mod bags;
mod logs;
mod plant;
#[path = "../bags/mod.rs"]
mod raw_bags;
mod records;
mod survey;
mod tables;
mod time;
mod words;
