//! `planesman dha limit-cycles`: limit cycles of the depth loop with the digital hydraulic actuator, predicted
//! and simulated, in one table.

use std::fmt::Write as _;

use anyhow::Result;
use planesman_units::INCH;

use super::MOST_RESIDUAL;
use super::depth_loop::{Case, Figure, LimitCycle, Prediction, cases};

/// The arguments.
#[derive(Clone, Debug, clap::Args)]
pub struct LimitCyclesArgs {
    /// Only configurations whose name contains this
    pub name: Option<String>,
    /// Without the prediction by harmonic balance, which takes most of the time
    #[arg(long)]
    pub no_prediction: bool,
}

/// Prints the table.
///
/// # Errors
/// When no configuration has such a name.
pub fn run(args: &LimitCyclesArgs) -> Result<()> {
    let wanted = args.name.as_deref().unwrap_or_default();
    let mut rows = Vec::new();
    for case in cases()? {
        if !case.name.contains(wanted) {
            continue;
        }
        let cycle = case.run()?;
        let prediction = (!args.no_prediction).then(|| case.predict()).transpose()?;
        rows.push(Row {
            case,
            cycle,
            prediction,
        });
    }
    if rows.is_empty() {
        anyhow::bail!(
            "no configuration has '{wanted}' in its name; without a name all are printed"
        );
    }
    planesman_node::print(format_args!("{}", text(&rows)))?;
    Ok(())
}

/// A configuration with its results.
#[derive(Clone, Debug)]
pub struct Row {
    /// The configuration.
    pub case: Case,
    /// Simulated.
    pub cycle: LimitCycle,
    /// Predicted, if asked for.
    pub prediction: Option<Prediction>,
}

/// The table in Markdown, a deviation marked with an asterisk.
#[must_use]
pub fn text(rows: &[Row]) -> String {
    let mut text = "| configuration | M_theta | depth pp, in | mean error, in | planes pp, deg | volumes/s | t95, s | f, Hz | predicted f, Hz: depth pp, in |\n|---|---|---|---|---|---|---|---|---|\n".to_owned();
    let (mut compared, mut deviating) = (0, 0);
    for row in rows {
        let expected = row.case.expected.unwrap_or_default();
        let mut cells = String::new();
        for figure in row.cycle.figures(&expected) {
            compared += usize::from(figure.expected.is_some());
            deviating += usize::from(!figure.agrees());
            // Writing to a String does not fail.
            let _ = write!(cells, " {} |", cell(&figure));
        }
        let _ = writeln!(
            text,
            "| {} | {} |{cells} {:.3} | {} |",
            row.case.name,
            row.case.restoring,
            row.cycle.frequency,
            foreseen(row.prediction.as_ref())
        );
    }
    let _ = writeln!(
        text,
        "\nFound (expected by an independent simulation); {deviating} of {compared} figures deviate by more than 15 % (*).\n\
         Predicted where 1 + N H comes within {MOST_RESIDUAL} of 0; otherwise no cycle of the loop is foreseen."
    );
    text
}

fn cell(figure: &Figure) -> String {
    let number = |value: f64| format!("{value:.3}");
    let found = figure.found.map_or_else(|| "never".to_owned(), number);
    let mark = if figure.agrees() { "" } else { "*" };
    match figure.expected {
        Some(expected) => format!("{found}{mark} ({expected:.3})"),
        None => found,
    }
}

fn foreseen(prediction: Option<&Prediction>) -> String {
    match prediction {
        None => "-".to_owned(),
        Some(p) if p.residual > MOST_RESIDUAL => format!("none ({:.2})", p.residual),
        Some(p) => format!("{:.3}: {:.3}", p.frequency, p.depth / INCH),
    }
}
