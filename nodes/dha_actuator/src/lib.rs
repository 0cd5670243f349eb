//! dha_actuator
pub mod actuator_file;
pub mod actuator_set;
pub mod cycle_clock;
pub mod dha;
pub mod events;
pub mod hydraulics;
pub mod metering;
pub mod modes;
pub mod position_loop;
pub mod pulse_logic;
pub mod ram;
pub mod units;
pub mod valves;
