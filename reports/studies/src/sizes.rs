//! Sizes and rates of an actuator, and the limit cycles foreseen with it.

use std::f64::consts::PI;
use std::fmt::Write as _;

use planesman_console::Table;
use planesman_hydraulics::describing_function::toggling;
use planesman_hydraulics::linearised::Ram;
use planesman_hydraulics::sizing::sizes;
use planesman_hydraulics::{ActuatorSet, Demand};
use planesman_linear::{Complex, ComplexFunctions as _};
use planesman_text::number;
use planesman_units::{DEGREE, INCH};

use crate::depth_loop::{Describing, Loop, MOST_RESIDUAL};
use ibm_1966::flight_control::FlightControl;
use ibm_1966::{Gains, Surrogate};

/// The sizes in a table.
#[must_use]
pub fn table(set: &ActuatorSet) -> Table {
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
    let mut text = format!("{}\n{}\n\n{}", set.name, set.source, table(set).aligned());
    // Writing to a String does not fail.
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

fn depth_cycle(set: &ActuatorSet) -> String {
    let tight = ActuatorSet {
        rate_gain: 0.0,
        error_rate: 0.0,
        ..set.clone()
    };
    let amplitudes = (set.threshold, 4.0 * set.threshold);
    let known = Describing::default();
    let cycle = Loop::default().predict(&tight, amplitudes, &known, |angle| Demand {
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
    let (plant, gains) = (surrogate.plant(), Gains::new(surrogate));
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
    let yaw = 2.0 * nozzle * plant.value_at(Complex::new(0.0, cycle.frequency)).modulus();
    format!(
        "{:.2} volumes a second, yaw {:.4} deg peak to peak (dead time alone; friction slows it)",
        cycle.frequency / PI,
        yaw / DEGREE
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_hydraulics::actuator_file;

    #[test]
    fn polaris_is_shown_in_both_units_with_its_cycles() {
        let text = text(&actuator_file::load("table_4_1").unwrap());
        let quantum = text.lines().find(|l| l.contains("V_c/A_L")).unwrap();
        assert!(
            quantum.contains("0.0038608 m") && quantum.contains("0.152 in"),
            "{quantum}"
        );
        assert!(text.contains("10.45 volumes a second"), "{text}");
    }
}
