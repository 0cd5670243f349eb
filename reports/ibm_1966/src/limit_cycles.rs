//! `planesman dha limit-cycles`: limit cycles of the depth loop with the digital hydraulic actuator, predicted
//! and simulated, in one table.

use std::path::PathBuf;

use anyhow::Result;
use maud::html;
use planesman_plot::{Plot, Style};
use planesman_units::INCH;

use super::depth_loop::{Case, Figure, LimitCycle, MOST_RESIDUAL, Prediction, cases};
use crate::arguments::output_file;
use planesman_console::progress::{end_with_reader, on_all_cores};
use planesman_console::{Format, Table, wrapped};
use planesman_flight::sink::write_text;
use planesman_pages::{document, figures};

/// The arguments.
#[derive(Clone, Debug, clap::Args)]
pub struct LimitCyclesArgs {
    /// Only configurations whose name contains this
    pub name: Option<String>,
    /// Without the prediction by harmonic balance, which takes most of the time
    #[arg(long)]
    pub no_prediction: bool,
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
    let row = |case: &Case| -> Result<Row> {
        Ok(Row {
            case: case.clone(),
            cycle: case.run()?,
            prediction: (!args.no_prediction).then(|| case.predict()).transpose()?,
        })
    };
    let rows = on_all_cores("limit cycles", &cases, row);
    let rows = rows.into_iter().collect::<Result<Vec<_>>>()?;
    let format = Format::or_by_output(args.format);
    planesman_console::print(format_args!("{}", text(&rows, format)?))?;
    if let Some(file) = &args.html {
        write_text(file, page(&rows))?;
        if matches!(format, Format::Table | Format::Md) {
            planesman_console::out!("{}", file.display())?;
        }
    }
    Ok(())
}

fn page(rows: &[Row]) -> String {
    let (table, compared, deviating) = table(rows);
    let of = |plot: Plot<'static>, pair: &dyn Fn(&Row) -> Option<(f64, f64)>| {
        let points: Vec<(f64, f64)> = rows.iter().filter_map(pair).collect();
        let most = points
            .iter()
            .fold(0.0_f64, |most, p| most.max(p.0).max(p.1));
        plot.plane()
            .with(Style::Crosses, "configuration", points)
            .with(Style::Bound, "equal", [(0.0, 0.0), (most, most)])
    };
    let cycle = |row: &Row| {
        let found = row.prediction.filter(|it| it.residual <= MOST_RESIDUAL)?;
        Some((row.cycle.frequency, found.frequency))
    };
    let depth = |row: &Row| {
        let expected = row.case.expected?.depth?;
        Some((row.cycle.depth / INCH, expected))
    };
    let plots = [
        of(
            Plot::new(
                "Frequency of the limit cycle",
                ["simulated [Hz]", "predicted by harmonic balance [Hz]"],
            ),
            &cycle,
        ),
        of(
            Plot::new(
                "Depth, peak to peak",
                ["simulated [in]", "by an independent simulation [in]"],
            ),
            &depth,
        ),
    ];
    let shown: Vec<_> = plots
        .into_iter()
        .filter(|plot| !plot.series[0].points.is_empty())
        .collect();
    let title = "Limit cycles of the depth loop";
    let body = html! {
        h1 { (title) }
        ul.verdict { li { (rows.len()) " configurations; " (deviating) " of " (compared) " figures deviate by more than 15 % from an independent simulation (*)." } }
        (figures(&shown))
        (table.html())
        p { "Found (expected). Predicted where 1 + N H comes within " (MOST_RESIDUAL) " of 0; otherwise no cycle of the loop is foreseen." }
    };
    document(title, "", &body, "")
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

/// The table, a deviation marked with an asterisk; for people also what the marks mean.
///
/// # Errors
/// Those of [`Table::text`].
pub fn text(rows: &[Row], format: Format) -> Result<String> {
    let (table, compared, deviating) = table(rows);
    let mut text = table.text(format);
    if matches!(format, Format::Table | Format::Md) {
        text += &wrapped(&format!(
            "\nFound (expected by an independent simulation); {deviating} of {compared} figures deviate by more than 15 % (*).\n\
             Predicted where 1 + N H comes within {MOST_RESIDUAL} of 0; otherwise no cycle of the loop is foreseen.\n"
        ));
    }
    Ok(text)
}

/// The table; how many figures are compared, and how many of them deviate.
fn table(rows: &[Row]) -> (Table, usize, usize) {
    let mut table = Table::new([
        "configuration",
        "M_theta",
        "depth pp, in",
        "mean error, in",
        "planes pp, deg",
        "volumes/s",
        "t95, s",
        "f, Hz",
        "predicted f, Hz: depth pp, in",
    ]);
    let (mut compared, mut deviating) = (0, 0);
    for row in rows {
        let expected = row.case.expected.unwrap_or_default();
        let mut cells = vec![row.case.name.clone(), row.case.restoring.to_string()];
        for figure in row.cycle.figures(&expected) {
            compared += usize::from(figure.expected.is_some());
            deviating += usize::from(!figure.agrees());
            cells.push(cell(&figure));
        }
        cells.push(format!("{:.3}", row.cycle.frequency));
        cells.push(foreseen(row.prediction.as_ref()));
        table.row(cells);
    }
    (table, compared, deviating)
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
