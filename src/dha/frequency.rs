//! `planesman dha frequency`: the linear model of Section V compared with the full model under sinusoids.

use anyhow::Result;
use planesman_console::print_wrapped;
use planesman_hydraulics::actuator_file;
use planesman_show::design::frequency_text;

use crate::reports_program;

/// Arguments of `dha frequency`.
#[derive(Clone, Debug, clap::Args)]
pub struct FrequencyArgs {
    /// A built-in actuator or an actuator file
    #[arg(default_value = "table_4_1")]
    actuator: String,
    /// Only the actuator in its position loop; the flight control with surrogate PS-2 needs planesman-reports
    #[arg(long)]
    alone: bool,
}

/// Prints the tables.
///
/// # Errors
/// A refused file.
pub fn run(args: &FrequencyArgs) -> Result<()> {
    if !args.alone {
        return reports_program::run("frequency", 2);
    }
    let set = actuator_file::load(&args.actuator)?;
    Ok(print_wrapped(frequency_text(&set)?)?)
}
