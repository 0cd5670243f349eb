//! A vehicle's coefficients computed from its geometry beside those of its file, as tables for a terminal.

use std::fmt::Write as _;

use planesman_console::Format;
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

/// Both tables, within the terminal.
#[must_use]
pub fn narrow(found: &Table, name: &str, speed: f64) -> String {
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
        coefficients.text(Format::Table),
        figures.text(Format::Table),
        planesman_console::wrapped(&missing.collect::<String>())
    )
}

/// The table as text.
#[must_use]
pub fn text(table: &Table, name: &str, speed: f64) -> String {
    let mut text = format!(
        "{name} at {speed:.4} m/s ({:.3} ft/s)\n\n{:<13} {:<40} {:>10} {:>10} {:>8} {:>11} {:<11} {:>11}\n",
        speed / FOOT,
        "coefficient",
        "method",
        "computed",
        "file",
        "off",
        "imperial",
        "",
        "SI"
    );
    for row in &table.rows {
        let file = row
            .in_the_file
            .map_or_else(|| "-".into(), |v| format!("{v:.4}"));
        let off = row
            .difference()
            .map_or_else(|| "-".into(), |d| format!("{:+.1} %", 100.0 * d));
        // Writing to a String does not fail.
        let _ = writeln!(
            text,
            "{:<13} {:<40} {:>10.4} {file:>10} {off:>8} {:>11.4} {:<11} {:>11.4} {}",
            row.coefficient,
            row.method,
            row.computed,
            row.imperial(),
            row.unit.imperial,
            row.si(),
            row.unit.si
        );
    }
    let _ = writeln!(
        text,
        "\n{:<22} {:<30} {:>11} {:<11} {:>11}",
        "quantity", "method", "imperial", "", "SI"
    );
    for figure in &table.figures {
        let uncertainty = figure
            .uncertainty
            .map_or_else(String::new, |u| format!("  +- {u:.4}"));
        let _ = writeln!(
            text,
            "{:<22} {:<30} {:>11.4} {:<11} {:>11.4} {}{uncertainty}",
            figure.quantity,
            figure.method,
            figure.si / figure.unit.size,
            figure.unit.imperial,
            figure.si,
            figure.unit.si
        );
    }
    for missing in &table.missing {
        let _ = writeln!(text, "not computed: {missing}");
    }
    text
}
