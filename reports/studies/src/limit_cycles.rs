//! Limit cycles of the depth loop with the digital hydraulic actuator, predicted and simulated, in one table.

use maud::html;
use planesman_console::{Format, Table, wrapped};
use planesman_pages::{document, figures};
use planesman_plot::{Plot, Style};
use planesman_units::INCH;

use crate::depth_loop::{Case, DiveError, Figure, LimitCycle, MOST_RESIDUAL, Prediction};

/// The page: predicted beside simulated, and the table.
#[must_use]
pub fn page(rows: &[Row]) -> String {
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

impl Row {
    /// Simulates a configuration, and predicts its cycle if that is asked for.
    ///
    /// # Errors
    /// Those of the actuator's file and of [`Loop::dive`](crate::depth_loop::Loop::dive).
    pub fn of(case: &Case, predicted: bool) -> Result<Self, DiveError> {
        Ok(Self {
            case: case.clone(),
            cycle: case.run()?,
            prediction: predicted.then(|| case.predict()).transpose()?,
        })
    }
}

/// The table, a deviation marked with an asterisk; for people also what the marks mean.
#[must_use]
pub fn text(rows: &[Row], format: Format) -> String {
    let (table, compared, deviating) = table(rows);
    let mut text = table.text(format);
    if matches!(format, Format::Table | Format::Md) {
        text += &wrapped(&format!(
            "\nFound (expected by an independent simulation); {deviating} of {compared} figures deviate by more than 15 % (*).\n\
             Predicted where 1 + N H comes within {MOST_RESIDUAL} of 0; otherwise no cycle of the loop is foreseen.\n"
        ));
    }
    text
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
