//! Parameters of the nodes, numbers of the reports.

use planesman::params_command;
use planesman::reproduce::rows;
use planesman_flight::nodes::{NODES, declarations};
use planesman_flight::scenario::Scenario;
use planesman_parameters::Value as Parameter;
use planesman_text::did_you_mean;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::error::{PlanesmanError, raised, released};

/// Every parameter of every node, or of one, as JSON.
///
/// # Errors
/// A node that is not there.
#[pyfunction]
pub(crate) fn parameters(node: Option<&str>) -> PyResult<String> {
    if let Some(node) = node
        && !NODES.contains(&node)
    {
        let meant = did_you_mean(node, NODES);
        let all = NODES.join(", ");
        return Err(PlanesmanError::new_err(format!(
            "there is no node '{node}'{meant}; there are {all}"
        )));
    }
    let of = |node: &&'static str| {
        let declared = declarations(node).unwrap_or_default();
        let node = *node;
        declared.into_iter().map(move |it| {
            json!({
                "name": format!("{node}.{}", it.name),
                "unit": it.unit,
                "default": plain(&it.default),
                "range": it.range,
                "choices": it.choices,
                "description": it.description,
            })
        })
    };
    let wanted = NODES
        .iter()
        .filter(|it| node.is_none_or(|node| node == **it));
    Ok(Value::Array(wanted.flat_map(of).collect()).to_string())
}

/// A value as JSON has it.
fn plain(value: &Parameter) -> Value {
    match value {
        Parameter::Bool(it) => json!(it),
        Parameter::Integer(it) => json!(it),
        Parameter::Double(it) => json!(it),
        Parameter::String(it) => json!(it),
        Parameter::ByteArray(it) => json!(it),
        Parameter::BoolArray(it) => json!(it),
        Parameter::IntegerArray(it) => json!(it),
        Parameter::DoubleArray(it) => json!(it),
        Parameter::StringArray(it) => json!(it),
    }
}

/// The parameters of a scenario, given as text, as a ROS 2 parameter file.
#[pyfunction]
pub(crate) fn parameter_file(scenario: &str, node: Option<&str>) -> PyResult<String> {
    let scenario = Scenario::parse(scenario).map_err(raised)?;
    params_command::parameter_file(node, Some(&scenario)).map_err(raised)
}

/// Every number of the reports, printed and recomputed, as JSON.
#[pyfunction]
pub(crate) fn reproduced(py: Python<'_>) -> PyResult<String> {
    released(py, || rows::json(&rows::all()?))
}
