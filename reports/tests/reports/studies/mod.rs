//! The actuator in the loops of both reports.

mod actuator_faults;
mod limit_cycles;
