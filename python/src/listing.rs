//! Parameters of the nodes, numbers of the reports.

use planesman::nodes::{NODES, declarations};
use planesman::params_command;
use planesman::reproduce::{self, REPORTS, listing::verdict};
use planesman::scenario::Scenario;
use planesman_book::Reckoning;
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
    released(py, || {
        let mut rows = Vec::new();
        for (report, values) in REPORTS.iter().zip(reproduce::recomputed()) {
            let book = (report.book)()?;
            let reckoning = Reckoning::of(&book, values.iter().map(|(id, v)| (id.as_str(), *v)));
            rows.extend(reckoning.lines.iter().map(|line| {
                let erratum = line.entry.erratum.as_ref();
                json!({
                    "report": report.name,
                    "number": line.entry.id,
                    "source": line.entry.source,
                    "unit": line.entry.unit,
                    "printed": line.entry.printed,
                    "recomputed": line.value,
                    "verdict": verdict(line),
                    "erratum": erratum.and_then(|it| book.errata().get(it)),
                })
            }));
        }
        Ok(Value::Array(rows).to_string())
    })
}
