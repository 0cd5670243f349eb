//! `planesman dha limit-cycles`: limit cycles of the depth loop with the digital hydraulic actuator: simulated, as orbits found by
//! shooting, and by harmonic balance, in one table.

use std::path::PathBuf;

use anyhow::Result;
use planesman_console::Format;
use planesman_console::progress::{end_with_reader, on_all_cores};
use planesman_flight::sink::write_text;
use planesman_studies::branches::{Varied, basins, basins_text, branch, branches_text};
use planesman_studies::depth_loop::{Case, cases};
use planesman_studies::limit_cycles::{Row, page, text};
use planesman_studies::position_loop;

use crate::arguments::{choice, output_file};

/// The arguments.
#[derive(Clone, Debug, clap::Args)]
pub struct LimitCyclesArgs {
    /// Only configurations whose name contains this
    pub name: Option<String>,
    /// Without the prediction by harmonic balance, which takes a third of the time
    #[arg(long)]
    pub no_prediction: bool,
    /// Instead, the motions from nine places where the ram may rest at first
    #[arg(long, conflicts_with_all = ["html", "vary"])]
    pub basins: bool,
    /// Instead, the orbit as this parameter changes
    #[arg(long, requires = "to", conflicts_with = "html", value_parser = choice(&Varied::ALL, Varied::described))]
    pub vary: Option<Varied>,
    /// The value to which it changes
    #[arg(long, requires = "vary", allow_negative_numbers = true, value_parser = from_zero)]
    pub to: Option<f64>,
    /// How to print the table [default: table on a terminal, md elsewhere]
    #[arg(long, value_parser = crate::arguments::format())]
    pub format: Option<Format>,
    /// Also write an HTML page with plots
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    pub html: Option<PathBuf>,
}

/// Prints the table.
///
/// # Errors
/// When no configuration has such a name.
pub fn run(args: &LimitCyclesArgs) -> Result<()> {
    let wanted = args.name.as_deref().unwrap_or_default();
    let mut cases = cases()?;
    cases.retain(|case| case.name.contains(wanted));
    if cases.is_empty() {
        anyhow::bail!(
            "no configuration has '{wanted}' in its name; without a name all are printed"
        );
    }
    if args.html.is_none() {
        end_with_reader();
    }
    let format = Format::or_by_output(args.format);
    if args.basins {
        let found = on_all_cores("basins", &cases, basins);
        let found = found.into_iter().collect::<Result<Vec<_>, _>>()?;
        let found: Vec<_> = cases.iter().zip(found).collect();
        return Ok(planesman_console::print(basins_text(&found, format))?);
    }
    if let (Some(varied), Some(to)) = (args.vary, args.to) {
        return follow(&cases, varied, to, format);
    }
    let groups: Vec<_> = cases.chunk_by(Case::same_actuator).collect();
    let rows = on_all_cores("limit cycles", &groups, |group| {
        Row::of(group, !args.no_prediction)
    });
    let rows = rows.into_iter().collect::<Result<Vec<_>, _>>()?.concat();
    planesman_console::print(text(&rows, format))?;
    if wanted.is_empty() && matches!(format, Format::Table | Format::Md) {
        let alone = position_loop::text(&position_loop::rows()?, format);
        planesman_console::print(format!("\n{alone}"))?;
    }
    if let Some(file) = &args.html {
        write_text(file, page(&rows))?;
        if matches!(format, Format::Table | Format::Md) {
            planesman_console::out!("{}", file.display())?;
        }
    }
    Ok(())
}

/// Prints each configuration's orbit over a parameter.
fn follow(cases: &[Case], varied: Varied, to: f64, format: Format) -> Result<()> {
    let followed = on_all_cores("orbits", cases, |case| branch(case, varied, to));
    let followed = followed.into_iter().collect::<Result<Vec<_>, _>>()?;
    let found: Vec<_> = cases
        .iter()
        .zip(followed)
        .filter_map(|(case, branch)| Some((case, branch?)))
        .collect();
    if found.is_empty() {
        anyhow::bail!(
            "none of these configurations has an orbit to follow; `planesman dha limit-cycles` says which have one"
        );
    }
    Ok(planesman_console::print(branches_text(
        &found, varied, format,
    ))?)
}

/// A finite number that is not negative.
fn from_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        _ => Err("a finite number, not below 0".to_owned()),
    }
}
