//! The nodes by name, with declaration and check of their parameters.

use planesman_control::{Controller, ControllerParameters};
use planesman_hydraulics::{Actuator, ActuatorParameters};
use planesman_identifier::{Identifier, IdentifierParameters};
use planesman_parameters::{Declaration, Parameters, Values};
use planesman_plant::{Plant, PlantParameters};
use planesman_recording::parameters::{RecorderParameters, writer_options};
use planesman_text::did_you_mean;

use crate::error::{PartError, Result, refuse};

/// A node in a scenario.
struct Node {
    name: &'static str,
    declarations: fn() -> Vec<Declaration>,
    /// Checks that the node would start with these parameters.
    check: fn(&Values) -> Result<(), PartError>,
    /// Parameters that name a file, or something built in.
    files: &'static [&'static str],
}

/// The nodes in the order of their start.
const TABLE: [Node; 5] = [
    Node {
        name: "recorder",
        declarations: RecorderParameters::declarations,
        check: |values| check(values, writer_options),
        files: &[],
    },
    Node {
        name: "sysid",
        declarations: IdentifierParameters::declarations,
        check: |values| check(values, Identifier::new),
        files: &[],
    },
    Node {
        name: "dha_actuator",
        declarations: ActuatorParameters::declarations,
        check: |values| {
            check(values, |parameters: &ActuatorParameters| {
                Actuator::new(parameters, (parameters.tick * 1e9).round() as i64)
            })
        },
        files: &[
            "actuator",
            "bow.actuator",
            "stern.actuator",
            "roll.actuator",
            "rudder.actuator",
        ],
    },
    Node {
        name: "depth_controller",
        declarations: ControllerParameters::declarations,
        check: |values| check(values, Controller::new),
        files: &["gains.file", "hover.vehicle"],
    },
    Node {
        name: "plant_sim",
        declarations: PlantParameters::declarations,
        check: |values| check(values, Plant::new),
        files: &["vehicle", "vehicle_base"],
    },
];

/// The nodes whose parameters a scenario sets, in the order of their start.
pub const NODES: [&str; 5] = [
    TABLE[0].name,
    TABLE[1].name,
    TABLE[2].name,
    TABLE[3].name,
    TABLE[4].name,
];

/// The default namespace. The namespace's time is on `/clock`; other namespaces have their own clock topic, so several vehicles can run in one
/// domain.
pub const NAMESPACE: &str = "/auv";

/// The node of that name, or all nodes.
///
/// # Errors
/// If no such node exists.
pub fn chosen(node: Option<&str>) -> Result<Vec<&'static str>> {
    let nodes = NODES.into_iter();
    let nodes: Vec<_> = nodes
        .filter(|name| node.is_none_or(|only| only == *name))
        .collect();
    if let (Some(name), []) = (node, nodes.as_slice()) {
        refuse!(
            "unknown node '{name}'; known: {}{}",
            NODES.join(", "),
            did_you_mean(name, NODES)
        );
    }
    Ok(nodes)
}

/// Parameters that the node `name` declares; `None` if no such node exists.
#[must_use]
pub fn declarations(name: &str) -> Option<Vec<Declaration>> {
    named(name).map(|node| (node.declarations)())
}

/// Checks that the node `name` would start with these parameters; accepts an unknown node.
///
/// # Errors
/// The node's refusal.
pub fn validate(name: &str, values: &Values) -> Result<(), PartError> {
    named(name).map_or(Ok(()), |node| (node.check)(values))
}

/// Parameters that name a file, or something built in, each with its node.
pub(crate) fn files() -> impl Iterator<Item = (&'static str, &'static str)> {
    let nodes = TABLE.iter();
    nodes.flat_map(|node| node.files.iter().map(|parameter| (node.name, *parameter)))
}

fn named(name: &str) -> Option<&'static Node> {
    TABLE.iter().find(|node| node.name == name)
}

/// Checks that a node can be created from these parameters.
fn check<P: Parameters, T, E: Into<PartError>>(
    values: &Values,
    make: impl Fn(&P) -> Result<T, E>,
) -> Result<(), PartError> {
    make(&P::from_values(values)?).map(drop).map_err(Into::into)
}
