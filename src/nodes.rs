//! The nodes by name: run in this process, and their parameters listed.

use std::fmt::Write as _;
use std::process::ExitCode;

use anyhow::{Result, bail};
use depth_controller::{Controller, ControllerParameters};
use dha_actuator::{Actuator, ActuatorParameters};
use planesman_parameters::{Declaration, Parameters, Value, Values};
use plant_sim::{Plant, PlantParameters};
use recorder::parameters::{RecorderParameters, writer_options};
use sysid::{Identifier, IdentifierParameters};

use crate::crew::launched;
use crate::scenario::{NODES, Scenario};

/// Runs the node `name` with its arguments (`--ros-args` and all) until it is asked to stop.
#[must_use]
pub fn run(name: &str, args: Vec<String>) -> ExitCode {
    launched(|| match name {
        "plant_sim" => plant_sim::main(args),
        "depth_controller" => depth_controller::main(args),
        "dha_actuator" => dha_actuator::main(args),
        "sysid" => sysid::main(args),
        "recorder" => recorder::node::main(args),
        other => {
            planesman_node::complain!(
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
        "plant_sim" => Plant::new(&read(values)?).map(drop),
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
        "sysid" => Identifier::new(&read(values)?).map(drop),
        "recorder" => writer_options(&read(values)?).map(drop),
        _ => Ok(()),
    }
}

fn read<P: Parameters>(values: &Values) -> Result<P, String> {
    P::from_values(values).map_err(|refusal| refusal.to_string())
}

/// Prints the parameters of one node, or of all.
///
/// # Errors
/// When there is no such node.
pub fn list_parameters(node: Option<&str>) -> Result<()> {
    for name in NODES.iter().filter(|n| node.is_none_or(|only| only == **n)) {
        planesman_node::say!("{name}:")?;
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
            planesman_node::say!(
                "  {}: {} {}{range}{choices}{fixed}\n      {}",
                d.name,
                d.default,
                d.unit,
                d.description
            )?;
        }
    }
    match node {
        Some(name) if !NODES.contains(&name) => {
            bail!("there is no node '{name}'; there are {}", NODES.join(", "))
        }
        _ => Ok(()),
    }
}

/// Every parameter of one node, or of all, as a ROS 2 parameter file for any namespace: at its
/// default, or at the scenario's value; unit and range beside it.
///
/// # Errors
/// When there is no such node.
pub fn parameter_file(node: Option<&str>, scenario: Option<&Scenario>) -> Result<String> {
    if let Some(name) = node
        && declarations(name).is_none()
    {
        bail!("there is no node '{name}'; there are {}", NODES.join(", "));
    }
    let mut text = match scenario {
        None => "# Every parameter of every node at its default: a ROS 2 parameter file, as\n\
                 # `planesman params --yaml` writes it.\n"
            .to_owned(),
        Some(scenario) => format!(
            "# {}: a ROS 2 parameter file.\n",
            scenario.description.replace('\n', " ")
        ),
    };
    for name in NODES.iter().filter(|n| node.is_none_or(|only| only == **n)) {
        let values = scenario.map(|s| s.values(name)).transpose()?;
        write!(text, "\n/**/{name}:\n  ros__parameters:\n")?;
        for d in declarations(name).unwrap_or_default() {
            let value = values
                .as_ref()
                .and_then(|v| v.get(&d.name))
                .unwrap_or(&d.default);
            let sentence = d.description.trim_end_matches('.');
            writeln!(text, "    # {sentence}.")?;
            write!(text, "    {}: {}", d.name, yaml(value))?;
            let rules = rules(&d);
            if !rules.is_empty() {
                write!(text, "  # {rules}")?;
            }
            text.push('\n');
        }
    }
    Ok(text)
}

/// Unit, range and mutability of a value: `m/s, 0 to 5, fixed at start`.
fn rules(d: &Declaration) -> String {
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

/// A bound for a reader: angles by their names, and no rows of zeros.
fn brief(bound: f64) -> String {
    use std::f64::consts::{FRAC_PI_2, PI};
    let sign = if bound < 0.0 { "-" } else { "" };
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

/// A value as every YAML reader takes it; those of YAML 1.1 see no number in `1e18`.
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
