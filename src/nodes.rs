//! The nodes by name: run in this process, their parameters declared and checked.

use std::ffi::OsString;
use std::process::ExitCode;

use planesman_control::{Controller, ControllerParameters};
use planesman_hydraulics::{Actuator, ActuatorParameters};
use planesman_identifier::{Identifier, IdentifierParameters};
use planesman_parameters::{Declaration, Parameters, Values};
use planesman_plant::{Plant, PlantParameters};
use planesman_recording::parameters::{RecorderParameters, writer_options};
use planesman_text::did_you_mean;
use rustix::process::{Signal, set_parent_process_death_signal};

/// The nodes whose parameters a scenario sets, in the order in which they are started.
pub const NODES: [&str; 5] = [
    "recorder",
    "sysid",
    "dha_actuator",
    "depth_controller",
    "plant_sim",
];

/// The default namespace. Its time is on `/clock`; other namespaces have a clock topic of their own, so that several
/// vehicles can run in one domain.
pub const NAMESPACE: &str = "/auv";

/// Set for a node that a launcher started: it stops when the launcher is gone.
pub const LAUNCHED: &str = "PLANESMAN_LAUNCHED";

/// Runs the node `name` with its arguments (`--ros-args` and all) until it is asked to stop.
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
                "planesman: there is no node '{other}'{}; there are {}",
                did_you_mean(other, NODES),
                NODES.join(", ")
            );
            ExitCode::FAILURE
        }
    })
}

/// Runs a launched node: it ends with its launcher, whatever becomes of that.
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
        planesman_console::err!("this node will outlive its launcher if that is killed: {error}");
    }
}

/// The parameters that the node `name` declares, `None` when there is no such node.
#[must_use]
pub fn declarations(name: &str) -> Option<Vec<Declaration>> {
    Some(match name {
        "plant_sim" => PlantParameters::declarations(),
        "depth_controller" => ControllerParameters::declarations(),
        "dha_actuator" => ActuatorParameters::declarations(),
        "sysid" => IdentifierParameters::declarations(),
        "recorder" => RecorderParameters::declarations(),
        _ => return None,
    })
}

/// Whether the node `name` would start with these parameters; true of an unknown node.
///
/// # Errors
/// The refusal, with its reason.
pub fn validate(name: &str, values: &Values) -> Result<(), String> {
    match name {
        "plant_sim" => Plant::new(&read(values)?)
            .map(drop)
            .map_err(|e| e.to_string()),
        "depth_controller" => Controller::new(&read(values)?)
            .map(drop)
            .map_err(|e| e.to_string()),
        "dha_actuator" => {
            let parameters: ActuatorParameters = read(values)?;
            let tick = (parameters.tick * 1e9).round() as i64;
            Actuator::new(&parameters, tick)
                .map(drop)
                .map_err(|e| e.to_string())
        }
        "sysid" => Identifier::new(&read(values)?)
            .map(drop)
            .map_err(|e| e.to_string()),
        "recorder" => writer_options(&read(values)?)
            .map(drop)
            .map_err(|e| e.to_string()),
        _ => Ok(()),
    }
}

fn read<P: Parameters>(values: &Values) -> Result<P, String> {
    P::from_values(values).map_err(|refusal| refusal.to_string())
}
