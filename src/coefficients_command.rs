//! `planesman coefficients`: a vehicle's coefficients computed from its geometry, compared with its file.

use anyhow::{Result, bail};
use planesman_units::FOOT;
use planesman_vehicle::coefficients::Table;
use planesman_vehicle::vehicle_file;

use crate::arguments::speed;
use planesman_console::Format;
use planesman_show::pages::coefficients::{in_one, text};

/// Compute a vehicle's hydrodynamic coefficients from its geometry, and compare them with the vehicle file
#[derive(Clone, Debug, clap::Args)]
pub struct CoefficientsArgs {
    /// A built-in vehicle (brunner), a vehicle file, or a model file
    vehicle: String,
    /// Base vehicle of an identified model: supplies everything except the pitch dynamics
    #[arg(long, default_value = vehicle_file::BRUNNER)]
    base: String,
    /// Speed for the dimensional values (m/s, or with its unit: 1ft/s)
    #[arg(long, default_value_t = FOOT, value_parser = speed(0.001, 100.0))]
    speed: f64,
    /// One table in this format [default: two tables with the speed above them]
    #[arg(long, value_parser = crate::arguments::format())]
    format: Option<Format>,
}

/// Prints the tables.
///
/// # Errors
/// The file is not a vehicle file, or has no geometry; the message says what is missing.
pub fn run(args: &CoefficientsArgs) -> Result<()> {
    let vehicle = vehicle_file::load_on(&args.vehicle, &args.base)?;
    let Some(geometry) = vehicle_file::geometry_on(&args.vehicle, &args.base)? else {
        bail!(
            "vehicle '{}' has no section 'geometry', which is needed to compute coefficients (the built-in vehicle '{}' has one)",
            args.vehicle,
            vehicle_file::BRUNNER
        );
    };
    let table = Table::of(&vehicle, &geometry, args.speed);
    let text = match args.format {
        Some(format) => in_one(&table).text(format),
        None => text(&table, &vehicle.name, args.speed),
    };
    Ok(planesman_console::print(text)?)
}
