//! The numbers of Brunner 1988, computed anew by this crate's models.
//!
//! `data/brunner_1988.json` holds what the thesis prints and what came of computing it again. Each part
//! here gives pairs of an entry's name there and its value now, in that entry's unit.

pub mod programs;
pub mod transfer_functions;
