//! The nodes by name: run in this process, and their parameters listed.

use std::process::ExitCode;

use anyhow::{Result, bail};
use planesman_parameters::Declaration;

use crate::crew::launched;
use crate::scenario::NODES;

/// Runs the node `name` with its arguments (`--ros-args` and all) until it is told to stop.
#[must_use]
pub fn run(name: &str, args: Vec<String>) -> ExitCode {
    launched(|| match name {
        "plant_sim" => plant_sim::node::main(args),
        "depth_controller" => depth_controller::node::main(args),
        "dha_actuator" => dha_actuator::node::main(args),
        "sysid" => sysid::node::main(args),
        "recorder" => recorder::node::main(args),
        other => {
            eprintln!(
                "planesman: there is no node '{other}'; there are {}",
                NODES.join(", ")
            );
            ExitCode::FAILURE
        }
    })
}

/// The parameters that the node `name` declares, `None` when there is no such node.
#[must_use]
pub fn declarations(name: &str) -> Option<Vec<Declaration>> {
    Some(match name {
        "plant_sim" => plant_sim::parameters::declarations(),
        "depth_controller" => depth_controller::parameters::declarations(),
        "dha_actuator" => dha_actuator::parameters::declarations(),
        "sysid" => sysid::parameters::declarations(),
        "recorder" => recorder::parameters::declarations(),
        _ => return None,
    })
}

/// Prints the parameters of one node, or of all.
///
/// # Errors
/// When there is no such node.
pub fn list_parameters(node: Option<&str>) -> Result<()> {
    for name in NODES.iter().filter(|n| node.is_none_or(|only| only == **n)) {
        println!("{name}:");
        for d in declarations(name).unwrap_or_default() {
            let range = d
                .range
                .map(|(low, high)| format!(" in [{low}, {high}]"))
                .unwrap_or_default();
            let choices = if d.choices.is_empty() {
                String::new()
            } else {
                format!(" one of {}", d.choices.join(", "))
            };
            let fixed = if d.read_only { " (fixed at start)" } else { "" };
            println!(
                "  {}: {} {}{range}{choices}{fixed}\n      {}",
                d.name, d.default, d.unit, d.description
            );
        }
    }
    match node {
        Some(name) if !NODES.contains(&name) => {
            bail!("there is no node '{name}'; there are {}", NODES.join(", "))
        }
        _ => Ok(()),
    }
}
