//! `planesman dha size`: sizes and rates of an actuator, or an actuator for a load.

use std::f64::consts::PI;
use std::fmt::Write as _;

use anyhow::{Result, anyhow};
use ibm_1966::flight_control::FlightControl;
use ibm_1966::{Gains, Surrogate};
use planesman_hydraulics::describing_function::toggling;
use planesman_hydraulics::linearised::Ram;
use planesman_hydraulics::sizing::{Load, for_load, sizes};
use planesman_hydraulics::{ActuatorSet, Demand, actuator_file};
use planesman_linear::Complex;
use planesman_units::{DEGREE, Dimension, INCH, Quantity};

use super::depth_loop::{Loop, MOST_RESIDUAL};
use planesman_console::number;
use planesman_console::{Format, Table, print_wrapped};

/// The arguments. A quantity is a number and its unit, as in an actuator file.
#[derive(Clone, Debug, clap::Args)]
pub struct SizeArgs {
    /// A built-in actuator or an actuator file; with --resolution an actuator is sized for a load instead, that
    /// takes from this one what is not given
    #[arg(default_value = "auv")]
    actuator: String,
    /// delta_q, the step wanted at the planes, such as '0.5 deg'
    #[arg(long, help_heading = "Load")]
    resolution: Option<String>,
    /// Plane rate, required, in deg/s or rad/s
    #[arg(long, requires = "resolution", help_heading = "Load")]
    slew: Option<String>,
    /// The planes' travel to either side, such as '30 deg'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    stroke: Option<String>,
    /// M, load and ram lumped at the ram, such as '0.35 kg'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    mass: Option<String>,
    /// C at the ram, such as '350 N s/m'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    viscous: Option<String>,
    /// Delta F at the ram, such as '2.2 N'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    coulomb: Option<String>,
    /// R, such as '12.7 mm'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    moment_arm: Option<String>,
    /// P_h, such as '1 MPa'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    supply: Option<String>,
    /// P_R, such as '0.07 MPa'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    return_pressure: Option<String>,
    /// beta/V, the oil's bulk modulus over its volume, such as '2e5 lb/in^5'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    stiffness: Option<String>,
    /// T_v, such as '5.5 ms'
    #[arg(long, requires = "resolution", help_heading = "Load")]
    valve_time: Option<String>,
    /// Print the sizes alone, as a table in this format [default: a list, and the limit cycles foreseen]
    #[arg(long, value_parser = crate::arguments::format())]
    format: Option<Format>,
}

/// Prints the sizes and the limit cycles foreseen.
///
/// # Errors
/// One line: the file, quantity or load that is refused.
pub fn run(args: &SizeArgs) -> Result<()> {
    let given = actuator_file::load(&args.actuator)?;
    let set = match &args.resolution {
        None => given,
        Some(resolution) => {
            for_load(&args.load(resolution, &given)?).map_err(|refusal| anyhow!(refusal))?
        }
    };
    let text = match args.format {
        Some(format) => table(&set).text(format),
        None => text(&set),
    };
    Ok(print_wrapped(text)?)
}

impl SizeArgs {
    /// The load of the command line, the rest as the actuator `given` has it.
    fn load(&self, resolution: &str, given: &ActuatorSet) -> Result<Load> {
        use Dimension as D;
        let read = |name: &str, text: &Option<String>, dimension: D, otherwise: f64| {
            text.as_ref()
                .map_or(Ok(otherwise), |text| quantity(name, text, dimension))
        };
        let stop = given.stop / given.moment_arm;
        let slew = match &self.slew {
            Some(slew) => quantity("slew", slew, D::Rate)?,
            None => given.slew_rate() / given.moment_arm,
        };
        Ok(Load {
            mass: read("mass", &self.mass, D::Mass, given.mass)?,
            viscous: read("viscous", &self.viscous, D::Damping, given.viscous)?,
            coulomb: read("coulomb", &self.coulomb, D::Force, given.coulomb)?,
            moment_arm: read("moment-arm", &self.moment_arm, D::Length, given.moment_arm)?,
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
            supply: read("supply", &self.supply, D::Pressure, given.supply)?,
            return_pressure: read(
                "return-pressure",
                &self.return_pressure,
                D::Pressure,
                given.return_pressure,
            )?,
            stiffness: read(
                "stiffness",
                &self.stiffness,
                D::OilStiffness,
                given.stiffness,
            )?,
            valve_time: read("valve-time", &self.valve_time, D::Time, given.valve_time)?,
        })
    }
}

fn quantity(name: &str, text: &str, dimension: Dimension) -> Result<f64> {
    text.parse::<Quantity>()?
        .argument(dimension)
        .map_err(|rule| anyhow!("--{name}: '{text}' refused: {rule}"))
}

/// The sizes in a table.
fn table(set: &ActuatorSet) -> Table {
    let mut table = Table::new(["quantity", "SI", "unit", "report", "report's unit"]);
    for size in sizes(set) {
        let report = match size.report_unit {
            "" => String::new(),
            _ => number(size.value / size.report_size),
        };
        table.row([
            size.quantity.to_string(),
            number(size.value),
            size.unit.to_string(),
            report,
            size.report_unit.to_string(),
        ]);
    }
    table
}

/// The sizes, and the limit cycles foreseen in two loops.
#[must_use]
pub fn text(set: &ActuatorSet) -> String {
    let mut text = format!("{}\n{}\n\n", set.name, set.source);
    for size in sizes(set) {
        let report = match size.report_unit {
            "" => String::new(),
            unit => format!("{:>12.5} {unit}", size.value / size.report_size),
        };
        // Writing to a String does not fail.
        let _ = writeln!(
            text,
            "{:<40} {:>12} {:<6} {report}",
            size.quantity,
            significant(size.value),
            size.unit,
        );
    }
    let _ = writeln!(
        text,
        "\nLimit cycles foreseen by describing functions, open loop, single-speed:"
    );
    let _ = writeln!(
        text,
        "  AUV's depth loop (Brunner, T6), no leakage: {}",
        depth_cycle(set)
    );
    let _ = writeln!(
        text,
        "  missile's yaw loop (surrogate PS-2), leaking: {}",
        yaw_cycle(set)
    );
    text
}

/// Five digits, whatever the size.
fn significant(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        format!("{value:.5}")
    } else {
        format!("{value:.4e}")
    }
}

fn depth_cycle(set: &ActuatorSet) -> String {
    let tight = ActuatorSet {
        rate_gain: 0.0,
        error_rate: 0.0,
        ..set.clone()
    };
    let amplitudes = (set.threshold, 4.0 * set.threshold);
    let cycle = Loop::default().predict(&tight, amplitudes, |angle| Demand {
        position_loop: false,
        ..Demand::angle(angle)
    });
    if cycle.residual > MOST_RESIDUAL {
        return format!("none (1 + N H stays {:.2} from 0)", cycle.residual);
    }
    format!(
        "{:.3} Hz, depth {:.3} in ({:.2} mm) peak to peak",
        cycle.frequency,
        cycle.depth / INCH,
        cycle.depth * 1e3
    )
}

fn yaw_cycle(set: &ActuatorSet) -> String {
    let surrogate = Surrogate::Ps2;
    let (plant, gains) = (surrogate.plant(), Gains::of(surrogate));
    let Ok(control) = FlightControl::new(&plant, &gains, set, Ram::Rigid) else {
        return "none".to_owned();
    };
    let cycle = toggling(&control.open_loop, set.quantum, set.threshold);
    let Ok(plant) = plant.transfer_function() else {
        return "none".to_owned();
    };
    if cycle.residual > MOST_RESIDUAL {
        return format!("none (1 + N H stays {:.2} from 0)", cycle.residual);
    }
    // The first harmonic of a square wave of half a quantum.
    let nozzle = 2.0 / PI * set.quantum;
    let yaw = 2.0 * nozzle * plant.value_at(Complex::new(0.0, cycle.frequency)).norm();
    format!(
        "{:.2} volumes a second, yaw {:.4} deg peak to peak (dead time alone; friction slows it)",
        cycle.frequency / PI,
        yaw / DEGREE
    )
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
        assert_eq!(set.mass, actuator_file::load("auv").unwrap().mass);
    }

    #[test]
    fn a_quantity_in_a_foreign_unit_is_refused_by_name() {
        let refusal = sized(&["--resolution", "1 psi"]).unwrap_err().to_string();
        assert!(
            refusal.starts_with("--resolution: '1 psi' refused"),
            "{refusal}"
        );
    }

    #[test]
    fn polaris_is_shown_in_both_units_with_its_cycles() {
        let text = text(&actuator_file::load("table_4_1").unwrap());
        let quantum = text.lines().find(|l| l.contains("V_c/A_L")).unwrap();
        assert!(
            quantum.contains("0.15200 in") && quantum.contains("0.00386 m"),
            "{quantum}"
        );
        assert!(text.contains("10.45 volumes a second"), "{text}");
    }
}
