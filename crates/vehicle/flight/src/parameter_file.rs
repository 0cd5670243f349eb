//! The nodes' parameters as a ROS 2 parameter file, with units and ranges as comments.

use planesman_parameters::{Declaration, Value};

use crate::error::Result;
use crate::nodes::{chosen, declarations};
use crate::scenario::Scenario;

/// Returns all parameters of one node, or of all nodes, as a ROS 2 parameter file for any namespace. The values are the scenario's, or else
/// the defaults; a comment gives unit and range.
///
/// # Errors
/// If no such node exists.
pub fn parameter_file(node: Option<&str>, scenario: Option<&Scenario>) -> Result<String> {
    let nodes = chosen(node)?;
    let mut text = match scenario {
        None => "# Every parameter of every node at its default: a ROS 2 parameter file, as\n\
                 # `planesman params` writes it.\n"
            .to_owned(),
        Some(scenario) => format!(
            "# {}: a ROS 2 parameter file.\n",
            scenario.description().replace('\n', " ")
        ),
    };
    for name in nodes {
        let values = scenario.map(|s| s.values(name)).transpose()?;
        text += &format!("\n/**/{name}:\n  ros__parameters:\n");
        for d in declarations(name).unwrap_or_default() {
            let value = values
                .as_ref()
                .and_then(|v| v.get(&d.name))
                .unwrap_or(&d.default);
            let sentence = d.description.trim_end_matches('.');
            text += &format!("    # {sentence}.\n    {}: {}", d.name, yaml(value));
            let rules = rules(&d);
            if !rules.is_empty() {
                text += &format!("  # {rules}");
            }
            text.push('\n');
        }
    }
    Ok(text)
}

/// Unit, range and mutability of a parameter: `m/s, 0 to 5, fixed at start`.
#[must_use]
pub fn rules(d: &Declaration) -> String {
    let mut rules = Vec::new();
    if !d.unit.is_empty() {
        rules.push(d.unit.to_owned());
    }
    match d.range {
        Some((low, high)) if matches!(d.default, Value::Integer(_)) && high >= i64::MAX as f64 => {
            rules.push(format!("{low} or more"));
        }
        Some((low, high)) => rules.push(format!("{} to {}", brief(low), brief(high))),
        None => {}
    }
    if !d.choices.is_empty() {
        rules.push(d.choices.join(" | "));
    }
    if d.read_only {
        rules.push("fixed at start".to_owned());
    }
    rules.join(", ")
}

/// A bound as text, without long rows of zeros; angles such as pi by name.
fn brief(bound: f64) -> String {
    use std::f64::consts::{FRAC_PI_2, PI, TAU};
    let sign = if bound < 0.0 { "-" } else { "" };
    if bound.abs() == TAU {
        return format!("{sign}2 pi");
    }
    if bound.abs() == PI {
        return format!("{sign}pi");
    }
    if bound.abs() == FRAC_PI_2 {
        return format!("{sign}pi/2");
    }
    let (plain, short) = (format!("{bound}"), format!("{bound:e}"));
    if plain.len() > short.len() + 3 {
        short
    } else {
        plain
    }
}

/// A value that every YAML parser reads correctly; parsers of YAML 1.1 do not read `1e18` as a number.
fn yaml(value: &Value) -> String {
    let text = value.to_string();
    match (value, text.split_once('e')) {
        (Value::Double(_), Some((digits, exponent))) => {
            let point = if digits.contains('.') { "" } else { ".0" };
            let sign = if exponent.starts_with('-') { "" } else { "+" };
            format!("{digits}{point}e{sign}{exponent}")
        }
        _ => text,
    }
}
