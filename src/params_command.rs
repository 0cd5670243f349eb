//! `planesman params`: lists the nodes' parameters.

use anyhow::Result;
use planesman_console::{Format, Table, print_wrapped};
use planesman_flight::nodes::{chosen, declarations};
use planesman_flight::parameter_file::rules;

/// Prints the parameters of one node, or of all nodes, as a list or a table.
///
/// # Errors
/// The node is unknown.
pub fn list_parameters(node: Option<&str>, format: Option<Format>) -> Result<()> {
    let nodes = chosen(node)?;
    if let Some(format) = format {
        let mut table = Table::new(["node", "parameter", "default", "rules", "description"]);
        for name in nodes {
            for d in declarations(name).unwrap_or_default() {
                let rules = rules(&d);
                let default = d.default.to_string();
                table.row([
                    name.to_owned(),
                    d.name,
                    default,
                    rules,
                    d.description.to_owned(),
                ]);
            }
        }
        return Ok(planesman_console::print(table.text(format))?);
    }
    for name in nodes {
        planesman_console::out!("{name}:")?;
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
            print_wrapped(format_args!(
                "  {}: {} {}{range}{choices}{fixed}\n      {}\n",
                d.name, d.default, d.unit, d.description
            ))?;
        }
    }
    Ok(())
}
