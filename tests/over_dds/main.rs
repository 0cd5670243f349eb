//! The loop over real DDS: dives, lockstep, time, recording, faults that are told, services, the live page.

#![allow(clippy::unwrap_used)]

#[path = "../browser/mod.rs"]
mod browser;
mod clock;
mod ctrl_c;
mod dive;
#[path = "../faked/mod.rs"]
mod faked;
#[path = "../foreign/mod.rs"]
mod foreign;
mod forged;
mod kill;
mod lockstep;
mod lost_messages;
mod manoeuvre;
#[path = "../page/mod.rs"]
mod page;
mod parameters;
mod real_time;
#[path = "../recorded/mod.rs"]
mod recorded;
mod recording;
mod replay;
mod run_nodes;
mod safety;
#[cfg(feature = "security")]
mod security;
#[path = "../stage/mod.rs"]
mod stage;
mod sysid_live;
mod two_of_a_kind;
mod watch;
