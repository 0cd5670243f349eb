//! Planesman: simulates, controls and identifies an underwater vehicle.
//!
//! This package contains the program, which uses the nodes and the libraries. The program flies a scenario in two ways that agree bit for bit: as
//! separate processes over DDS ([`dive`]), or in one process ([`planesman_flight`]). Both write a bag, which [`planesman_show::pages`] shows as a
//! page. [`sweep`] flies a scenario many times.
//!
//! Other commands: [`coefficients_command`] computes a vehicle's coefficients from its geometry. [`dha`] sizes the actuator and designs its
//! circuits. [`design`] analyses and designs the loops. [`sysid`] identifies models, [`tune`] finds gains for these models, and [`review`] shows both
//! on one page. [`export_command`] writes FMUs for other simulators. [`watch`] shows running vehicles. The two historical reports are in another
//! program, `planesman-reports`, which [`reports_program`] runs.

pub mod arguments;
pub mod bag_command;
pub mod bag_play;
pub mod coefficients_command;
pub mod design;
pub mod dha;
pub mod dive;
pub mod doctor;
pub mod export_command;
pub mod nodes;
pub mod params_command;
pub mod processes;
pub mod report;
pub mod reports_program;
pub mod review;
pub mod run_folder;
pub mod six_dof_command;
pub mod six_dof_exchange;
pub mod six_dof_fit;
pub mod sweep;
pub mod sysid;
pub mod tf_command;
pub mod tune;
pub mod watch;
