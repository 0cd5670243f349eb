//! A vehicle's coefficients, computed from its geometry and from its file, as tables for a terminal.

use planesman_text::number;
use planesman_units::FOOT;
use planesman_vehicle::coefficients::Table;

/// Coefficients and quantities in one table.
#[must_use]
pub fn in_one(found: &Table) -> planesman_console::Table {
    let mut table = planesman_console::Table::new([
        "quantity", "method", "computed", "file", "off, %", "imperial", "unit", "SI", "SI unit",
    ]);
    let written = |value: Option<f64>| value.map_or_else(String::new, number);
    for row in &found.rows {
        table.row([
            row.coefficient.to_string(),
            row.method.to_string(),
            number(row.computed),
            written(row.in_the_file),
            written(row.difference().map(|d| 100.0 * d)),
            number(row.imperial()),
            row.unit.imperial.to_string(),
            number(row.si()),
            row.unit.si.to_string(),
        ]);
    }
    for figure in &found.figures {
        let none = String::new;
        table.row([
            figure.quantity.to_string(),
            figure.method.to_string(),
            none(),
            none(),
            none(),
            number(figure.si / figure.unit.size),
            figure.unit.imperial.to_string(),
            number(figure.si),
            figure.unit.si.to_string(),
        ]);
    }
    table
}

/// Both tables, wrapped to the terminal's width if standard output is one.
#[must_use]
pub fn text(found: &Table, name: &str, speed: f64) -> String {
    let written = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), number);
    let both = |value: f64, unit: &str| format!("{} {unit}", number(value));
    let columns = [
        "coefficient",
        "method",
        "computed",
        "file",
        "off, %",
        "imperial",
        "SI",
    ];
    let mut coefficients = planesman_console::Table::new(columns);
    for row in &found.rows {
        coefficients.row([
            row.coefficient.to_string(),
            row.method.to_string(),
            number(row.computed),
            written(row.in_the_file),
            row.difference()
                .map_or_else(|| "-".to_owned(), |d| format!("{:+.1}", 100.0 * d)),
            both(row.imperial(), row.unit.imperial),
            both(row.si(), row.unit.si),
        ]);
    }
    let mut figures = planesman_console::Table::new(["quantity", "method", "imperial", "SI", "+-"]);
    for figure in &found.figures {
        figures.row([
            figure.quantity.to_string(),
            figure.method.to_string(),
            both(figure.si / figure.unit.size, figure.unit.imperial),
            both(figure.si, figure.unit.si),
            figure.uncertainty.map_or_else(String::new, number),
        ]);
    }
    let missing = found
        .missing
        .iter()
        .map(|it| format!("not computed: {it}\n"));
    format!(
        "{name} at {speed:.4} m/s ({:.3} ft/s)\n\n{}\n{}{}",
        speed / FOOT,
        coefficients.aligned(),
        figures.aligned(),
        planesman_console::wrapped(&missing.collect::<String>())
    )
}
