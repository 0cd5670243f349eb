//! Planesman: dives, breaks and identifies an underwater vehicle.
//!
//! This package is the program around the nodes. From a [`scenario`] it flies the vehicle two
//! ways that agree bit for bit: as separate processes over DDS ([`dive`]), or in one process
//! ([`sim`], through [`compose`]). Either way a bag remains, from which [`flight`], [`summary`] and
//! [`page`] tell what happened.

pub mod compose;
pub mod crew;
pub mod dive;
pub mod flight;
pub mod nodes;
pub mod page;
pub mod plot;
pub mod run_folder;
pub mod scenario;
pub mod sim;
pub mod sink;
pub mod summary;
pub mod tf_command;
