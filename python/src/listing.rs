//! Parameters of the nodes.

use planesman_flight::nodes::{chosen, declarations};
use planesman_flight::parameter_file::parameter_file as file_of;
use planesman_flight::scenario::Scenario;
use planesman_parameters::Value as Parameter;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::error::raised;

/// Every parameter of every node, or of one node, as JSON.
///
/// # Errors
/// An unknown node.
#[pyfunction]
pub(crate) fn parameters(node: Option<&str>) -> PyResult<String> {
    let nodes = chosen(node).map_err(raised)?;
    let of = |node: &'static str| {
        let declared = declarations(node).unwrap_or_default();
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
    Ok(Value::Array(nodes.into_iter().flat_map(of).collect()).to_string())
}

/// A parameter's value as JSON.
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

/// Converts a scenario's text to a ROS 2 parameter file.
#[pyfunction]
pub(crate) fn parameter_file(scenario: &str, node: Option<&str>) -> PyResult<String> {
    let scenario = Scenario::parse(scenario).map_err(raised)?;
    file_of(node, Some(&scenario)).map_err(raised)
}
