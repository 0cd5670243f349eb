//! The thesis: its numbers, its program T6 and its kinds of runs.

mod book;
mod estimators;
mod program_t6;
mod support;
mod thesis_runs;
mod vehicle;
