//! The nodes by name, their parameters declared and checked.

use planesman_control::{Controller, ControllerParameters};
use planesman_hydraulics::{Actuator, ActuatorParameters};
use planesman_identifier::{Identifier, IdentifierParameters};
use planesman_parameters::{Declaration, Parameters, Values};
use planesman_plant::{Plant, PlantParameters};
use planesman_recording::parameters::{RecorderParameters, writer_options};
use planesman_text::did_you_mean;

use crate::error::{Result, refuse};

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

/// The node of that name, or all.
///
/// # Errors
/// When there is no such node.
pub fn chosen(node: Option<&str>) -> Result<Vec<&'static str>> {
    let nodes = NODES.into_iter();
    let nodes: Vec<_> = nodes
        .filter(|name| node.is_none_or(|only| only == *name))
        .collect();
    if let (Some(name), []) = (node, nodes.as_slice()) {
        refuse!(
            "there is no node '{name}'{}; there are {}",
            did_you_mean(name, NODES),
            NODES.join(", ")
        );
    }
    Ok(nodes)
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
pub fn validate(name: &str, values: &Values) -> std::result::Result<(), String> {
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

fn read<P: Parameters>(values: &Values) -> std::result::Result<P, String> {
    P::from_values(values).map_err(|refusal| refusal.to_string())
}
