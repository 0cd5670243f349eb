//! `planesman coefficients`: a vehicle's coefficients computed from its geometry, compared with its file.

use std::fmt::Write as _;

use anyhow::{Result, bail};
use planesman_units::FOOT;
use planesman_vehicle::coefficients::Table;
use planesman_vehicle::vehicle_file;

use crate::design::subject::within;

/// Compute a vehicle's coefficients from its geometry, and compare with its file.
#[derive(Clone, Debug, clap::Args)]
#[command(allow_negative_numbers = true)]
pub struct CoefficientsArgs {
    /// A built-in vehicle (brunner), a vehicle file, or a model file
    vehicle: String,
    /// Base vehicle of an identified model: gives all but the pitch dynamics
    #[arg(long, default_value = vehicle_file::BRUNNER)]
    base: String,
    /// Speed for the dimensional values (m/s)
    #[arg(long, default_value_t = FOOT, value_parser = within(0.001, 100.0))]
    speed: f64,
}

/// Prints the table.
///
/// # Errors
/// When the file is no vehicle's, or has no geometry: one line says what is missing.
pub fn run(args: &CoefficientsArgs) -> Result<()> {
    let vehicle = vehicle_file::load_on(&args.vehicle, &args.base)?;
    let Some(geometry) = vehicle_file::geometry_on(&args.vehicle, &args.base)? else {
        bail!(
            "vehicle '{}' has no section 'geometry': no coefficients can be computed (the built-in vehicle '{}' has one)",
            args.vehicle,
            vehicle_file::BRUNNER
        );
    };
    planesman_node::print(format_args!(
        "{}",
        text(
            &Table::of(&vehicle, &geometry, args.speed),
            &vehicle.name,
            args.speed
        )
    ))?;
    Ok(())
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
