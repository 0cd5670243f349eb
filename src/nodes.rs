//! Runs a node in this process, by its name.

use std::ffi::OsString;
use std::process::ExitCode;

use planesman_flight::nodes::NODES;
use planesman_text::did_you_mean;
use rustix::process::{Signal, set_parent_process_death_signal};

/// Environment variable of a launched node: the node stops when its launcher is gone.
pub const LAUNCHED: &str = "PLANESMAN_LAUNCHED";

/// Runs the node `name` with its arguments (including `--ros-args`) until it is requested to stop.
#[must_use]
pub fn run(name: &str, args: Vec<OsString>) -> ExitCode {
    launched(|| match name {
        "plant_sim" => plant_sim::main(args),
        "depth_controller" => depth_controller::main(args),
        "dha_actuator" => dha_actuator::main(args),
        "sysid" => sysid::main(args),
        "recorder" => recorder::node::main(args),
        other => {
            planesman_console::err!(
                "planesman: unknown node '{other}'; known: {}{}",
                NODES.join(", "),
                did_you_mean(other, NODES)
            );
            ExitCode::FAILURE
        }
    })
}

/// Runs a launched node, which ends with its launcher even if that is killed.
#[must_use]
pub fn launched(node: impl FnOnce() -> ExitCode) -> ExitCode {
    end_with_launcher();
    node()
}

/// Makes this process end with its launcher, if it has one.
pub(crate) fn end_with_launcher() {
    if std::env::var_os(LAUNCHED).is_some()
        && let Err(error) = set_parent_process_death_signal(Some(Signal::TERM))
    {
        planesman_console::err!("this node keeps running if its launcher is killed: {error}");
    }
}
