//! Parameters of the nodes, numbers of the reports.

use planesman::nodes::{NODES, declarations};
use planesman::params_command;
use planesman::reproduce::rows;
use planesman::scenario::Scenario;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::error::{raised, released};

/// Every parameter of every node, as JSON.
#[pyfunction]
pub(crate) fn parameters() -> String {
    let of = |node: &&'static str| {
        let declared = declarations(node).unwrap_or_default();
        let node = *node;
        declared.into_iter().map(move |it| {
            json!({
                "name": format!("{node}.{}", it.name),
                "unit": it.unit,
                "default": it.default.to_string(),
                "range": it.range,
                "choices": it.choices,
                "description": it.description,
            })
        })
    };
    Value::Array(NODES.iter().flat_map(of).collect()).to_string()
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
