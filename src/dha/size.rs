//! `planesman dha size`: sizes and rates of an actuator, or an actuator for a load.

use anyhow::{Result, anyhow};
use planesman_console::{Format, print_wrapped};
use planesman_hydraulics::sizing::{Load, for_load};
use planesman_hydraulics::{ActuatorSet, actuator_file};
use planesman_show::design::{size_table, size_text};
use planesman_units::{DEGREE, Dimension, Quantity};

/// Arguments of `dha size`. A quantity is a number with its unit, as in an actuator file.
#[derive(Clone, Debug, clap::Args)]
pub struct SizeArgs {
    /// A built-in actuator or an actuator file. With --resolution an actuator is sized for a load; values not given are taken from this file
    #[arg(default_value = "auv")]
    actuator: String,
    /// delta_q, the required plane angle per volume, such as '0.5 deg'
    #[arg(long, help_heading = "Load")]
    resolution: Option<String>,
    /// Required plane rate, in deg/s or rad/s
    #[arg(long, requires = "resolution", help_heading = "Load")]
    slew: Option<String>,
    /// Travel of the planes to either side, such as '30 deg'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    stroke: Option<String>,
    /// M, mass of load and ram at the ram, such as '0.35 kg'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    mass: Option<String>,
    /// C, viscous damping at the ram, such as '350 N s/m'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    viscous: Option<String>,
    /// Delta F, Coulomb friction at the ram, such as '2.2 N'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    coulomb: Option<String>,
    /// R, moment arm, such as '12.7 mm'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    moment_arm: Option<String>,
    /// P_h, supply pressure, such as '1 MPa'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    supply: Option<String>,
    /// P_R, return pressure, such as '0.07 MPa'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    return_pressure: Option<String>,
    /// beta/V, the oil's bulk modulus over its volume, such as '2e5 lb/in^5'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    stiffness: Option<String>,
    /// T_v, valve cycle time, such as '5.5 ms'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    valve_time: Option<String>,
    /// Print only the sizes, as a table in this format [default: a list, and the predicted limit cycle]
    #[arg(long, value_parser = crate::arguments::format())]
    format: Option<Format>,
}

/// Prints the sizes and the predicted limit cycle.
///
/// # Errors
/// A refused file, quantity or load.
pub fn run(args: &SizeArgs) -> Result<()> {
    let given = actuator_file::load(&args.actuator)?;
    let set = match &args.resolution {
        None => given,
        Some(resolution) => {
            for_load(&args.load(resolution, &given)?).map_err(|refusal| anyhow!(refusal))?
        }
    };
    let text = match args.format {
        Some(format) => size_table(&set).text(format),
        None => size_text(&set),
    };
    Ok(print_wrapped(text)?)
}

impl SizeArgs {
    /// The load from the command line; values that are not given are taken from the actuator `given`.
    fn load(&self, resolution: &str, given: &ActuatorSet) -> Result<Load> {
        use Dimension as D;
        let read = |name: &str, text: &Option<String>, dimension: D, otherwise: f64| {
            text.as_ref()
                .map_or(Ok(otherwise), |text| quantity(name, text, dimension))
        };
        let stop = given.stop / given.load.moment_arm;
        let slew = match &self.slew {
            Some(slew) => quantity("slew", slew, D::Rate)?,
            None => given.slew_rate() / given.load.moment_arm,
        };
        Ok(Load {
            mass: read("mass", &self.mass, D::Mass, given.load.mass)?,
            viscous: read("viscous", &self.viscous, D::Damping, given.load.viscous)?,
            coulomb: read("coulomb", &self.coulomb, D::Force, given.load.coulomb)?,
            moment_arm: read(
                "moment-arm",
                &self.moment_arm,
                D::Length,
                given.load.moment_arm,
            )?,
            stroke: read(
                "stroke",
                &self.stroke,
                D::Angle,
                if stop.is_finite() {
                    stop / 1.1
                } else {
                    30.0 * DEGREE
                },
            )?,
            resolution: quantity("resolution", resolution, D::Angle)?,
            slew,
            supply: read("supply", &self.supply, D::Pressure, given.oil.supply)?,
            return_pressure: read(
                "return-pressure",
                &self.return_pressure,
                D::Pressure,
                given.oil.return_pressure,
            )?,
            stiffness: read(
                "stiffness",
                &self.stiffness,
                D::OilStiffness,
                given.oil.stiffness,
            )?,
            valve_time: read("valve-time", &self.valve_time, D::Time, given.valve_time)?,
        })
    }
}

fn quantity(name: &str, text: &str, dimension: Dimension) -> Result<f64> {
    text.parse::<Quantity>()?
        .argument(dimension)
        .map_err(|rule| anyhow!("--{name} '{text}' refused: {rule}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Cli {
        #[command(flatten)]
        size: SizeArgs,
    }

    fn sized(args: &[&str]) -> Result<ActuatorSet> {
        let args = Cli::try_parse_from([&["size"], args].concat())?.size;
        let given = actuator_file::load(&args.actuator)?;
        let resolution = args.resolution.clone().unwrap_or_default();
        for_load(&args.load(&resolution, &given)?).map_err(|refusal| anyhow!(refusal))
    }

    #[test]
    fn a_load_takes_from_the_actuator_what_is_not_given() {
        let set = sized(&["auv", "--resolution", "1 deg", "--slew", "60 deg/s"]).unwrap();
        assert_eq!(set.frequency_millihertz, 60_000);
        assert_eq!(set.load.mass, actuator_file::load("auv").unwrap().load.mass);
    }

    #[test]
    fn a_quantity_in_a_foreign_unit_is_refused_by_name() {
        let refusal = sized(&["--resolution", "1 psi"]).unwrap_err().to_string();
        assert!(
            refusal.starts_with("--resolution '1 psi' refused"),
            "{refusal}"
        );
    }
}
