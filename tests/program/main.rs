//! The program and its library: commands, files, pages, reports, identification.

#![allow(clippy::unwrap_used)]

mod bad_input;
mod bag_diff;
#[path = "../bags/mod.rs"]
mod bags;
mod best_gains;
#[path = "../browser/mod.rs"]
mod browser;
mod circuit;
mod coefficients;
mod command_line;
mod following_gains;
#[path = "../foreign/mod.rs"]
mod foreign;
mod help;
mod hostile_data;
mod messy;
mod pages;
mod params_file;
mod python_options;
#[path = "../recorded/mod.rs"]
mod recorded;
mod remus_100;
mod replay;
mod reports;
mod reports_program;
mod review;
mod same_bits;
mod sensors;
mod six_dof;
#[path = "../stage/mod.rs"]
mod stage;
#[path = "../../reports/src/brunner_1988/identification/synthetic.rs"]
#[allow(dead_code, unreachable_pub)]
mod synthetic;
mod sysid_compare;
mod sysid_data;
mod sysid_fit;
mod topics;
mod tune;
mod walls;

/// What is computed in this process words its messages as the program does.
fn by_command_line() {
    planesman_text::use_wording(planesman_text::Wording::CommandLine);
}
