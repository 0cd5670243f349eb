//! The actuator study: its numbers and its flight-control loop.

mod book;
mod missile_loop;
