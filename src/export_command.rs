//! `planesman export`: writes an actuator, a vehicle or an identified model as an FMU for other simulators ([`planesman_fmu`]).

use std::path::PathBuf;

use anyhow::{Context as _, Result};
use planesman_fmu::{Kind, Options, fmu};
use planesman_text::{shown, write_text};
use planesman_units::Dimension;

use crate::arguments::{default_file, output_file, quantity};

/// Write an FMU (FMI 3.0, co-simulation) for Simulink, OpenModelica, FMPy and other importers
#[derive(Clone, Debug, clap::Args)]
pub struct ExportArgs {
    /// A built-in actuator or vehicle, or the file of an actuator, vehicle or identified model
    #[arg(long, value_name = "ACTUATOR|VEHICLE|MODEL")]
    fmi: String,
    /// The FMU to write; must not exist yet [default: NAME.fmu]
    #[arg(short, long, value_name = "FILE", value_parser = output_file)]
    out: Option<PathBuf>,
    /// Tick: the FMU reads its inputs and changes its outputs at multiples of this time (s, or 1ms) [default: 0.05 s; for a model its sampling time]
    #[arg(long, value_name = "TIME", value_parser = quantity(Dimension::Time, 1e-4, 1.0))]
    step: Option<f64>,
    /// Start value of a parameter, such as speed=1.5 or "load.mass=150 kg"; may be repeated
    #[arg(long = "set", value_name = "PARAMETER=VALUE", value_parser = assignment)]
    set: Vec<(String, String)>,
    /// The shared library that runs the FMU [default: libplanesman_fmu next to the program]
    #[arg(long, value_name = "FILE")]
    library: Option<PathBuf>,
}

fn assignment(text: &str) -> Result<(String, String), String> {
    let parts = text.split_once('=');
    let (name, value) = parts.ok_or("PARAMETER=VALUE is expected")?;
    Ok((name.to_owned(), value.to_owned()))
}

/// Writes the FMU and prints its contents.
///
/// # Errors
/// A refused argument, a file that cannot be written.
pub fn run(args: &ExportArgs) -> Result<()> {
    let made = fmu(&Options {
        subject: args.fmi.clone(),
        tick: args.step,
        start: args.set.clone(),
        library: args.library.clone(),
    })?;
    let out = match &args.out {
        Some(out) => out.clone(),
        None => {
            let name = PathBuf::from(&args.fmi).with_extension("fmu");
            let name = name.file_name().map(PathBuf::from).unwrap_or_default();
            let name = name.display().to_string();
            default_file(&name).map_err(|reason| anyhow::anyhow!("{name}: {reason}; see --out"))?
        }
    };
    write_text(&out, &made.bytes).with_context(|| format!("'{}'", out.display()))?;
    let kind = match made.kind {
        Kind::Actuator => "An actuator",
        Kind::Vehicle => "A vehicle",
        Kind::Model => "An identified model",
    };
    let text = format!(
        "{kind} as an FMU of FMI 3.0, co-simulation, for {}\n\
         inputs      {}\n\
         outputs     {}\n\
         parameters  {}, listed in modelDescription.xml\n\
         tick        {} s\n\
         \n\
         FMU: {}\n",
        made.platform,
        shown(made.inputs.join(", ")),
        shown(made.outputs.join(", ")),
        made.parameters,
        made.tick,
        shown(out.display())
    );
    Ok(planesman_console::print_wrapped(text)?)
}
