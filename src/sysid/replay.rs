//! `planesman replay`: a bag's messages through the identifier ([`planesman_identifier::replay`]).

use std::path::PathBuf;

use anyhow::{Context, Result, anyhow};
use clap::Parser;
use planesman_console::print_wrapped;
use planesman_console::progress::spinner;
use planesman_identifier::IdentifierParameters;
use planesman_identifier::replay::{Replay, replay, text};
use planesman_parameters::{Parameters as _, Values, file};

/// Run the live identifier on a bag and compare with its published estimates.
#[derive(Clone, Debug, Parser)]
#[command(name = "replay")]
pub struct ReplayArgs {
    /// A bag folder, a metadata.yaml or an .mcap file
    bag: PathBuf,
    /// A ROS 2 parameter file; the entries for the node sysid are used
    #[arg(long, value_name = "FILE")]
    params_file: Option<PathBuf>,
    /// A parameter, NAME:=VALUE, after the file's
    #[arg(short = 'p', long = "param", value_name = "NAME:=VALUE")]
    parameters: Vec<String>,
    /// Name of the node in the parameter file
    #[arg(long, default_value = "/auv/sysid")]
    node: String,
}

impl ReplayArgs {
    /// Replays the bag.
    ///
    /// # Errors
    /// As [`run`].
    pub fn replay(&self) -> Result<Replay> {
        Ok(replay(&self.bag, &self.parameters()?)?)
    }

    fn parameters(&self) -> Result<IdentifierParameters> {
        let mut changes = Vec::new();
        if let Some(path) = &self.params_file {
            let text =
                file::read(path).with_context(|| format!("parameter file '{}'", path.display()))?;
            let found = file::overrides_for(&text, &self.node)
                .with_context(|| format!("parameter file '{}'", path.display()))?;
            changes.extend(found.into_iter().filter(|(name, _)| name != "use_sim_time"));
        }
        for text in &self.parameters {
            let (name, value) = text
                .split_once(":=")
                .ok_or_else(|| anyhow!("-p {text}: a parameter is written NAME:=VALUE"))?;
            changes.push((name.to_owned(), file::parse_value(name, value)?));
        }
        let values = Values::of::<IdentifierParameters>().with(changes)?;
        Ok(IdentifierParameters::from_values(&values)?)
    }
}

/// Runs the command and prints what it found.
///
/// # Errors
/// One line for the terminal: a bag, file or parameter that is refused, a bag without the signals.
pub fn run(args: &ReplayArgs) -> Result<()> {
    let working = spinner("messages");
    let found = args.replay();
    working.finish_and_clear();
    let found = found?;
    let tables: Vec<String> = found.estimates.iter().map(text).collect();
    print_wrapped(tables.join("\n"))?;
    if let Some(live) = found.live {
        print_wrapped(format!(
            "live: {} published estimates compared, largest difference {:.1e}{}\n",
            live.compared,
            live.largest_difference,
            if live.missing == 0 {
                String::new()
            } else {
                format!(", {} without a counterpart", live.missing)
            }
        ))?;
    }
    if let Some((count, first)) = found.refused {
        print_wrapped(format!("{count} messages refused, the first: {first}\n"))?;
    }
    if let Some(reason) = found.incomplete {
        print_wrapped(format!("the bag is {reason}\n"))?;
    }
    Ok(())
}
