//! Planesman: simulates, controls and identifies an underwater vehicle.
//!
//! This package is the program around the nodes and the libraries. From a scenario it flies the vehicle two
//! ways that agree bit for bit: as separate processes over DDS ([`dive`]), or in one process
//! ([`planesman_flight`]). Either way a bag remains, from which [`planesman_show::pages`] tells what happened. [`sweep`] flies a scenario many
//! times.
//!
//! Beside flying: [`coefficients_command`] computes a vehicle's coefficients from its geometry, [`dha`]
//! sizes the actuator and designs its circuits; [`design`] has the loops on paper,
//! [`sysid`] the identifier's pages, [`tune`] gains for its models, [`review`] both on one page; [`export_command`] takes them to other simulators; [`watch`] shows what flies.
//! The two historical reports are another program's, `planesman-reports`, which [`reports_program`] runs.

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
pub mod six_dof_fit;
pub mod sweep;
pub mod sysid;
pub mod tf_command;
pub mod tune;
pub mod watch;
