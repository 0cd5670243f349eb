//! Sizes of an actuator, its frequency response in the position loop, and the limit cycle it causes in the depth loop.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use planesman_console::Table;
use planesman_hydraulics::frequency_response::{self, Periods};
use planesman_hydraulics::linearised::{self, Ram};
use planesman_hydraulics::sizing::sizes;
use planesman_hydraulics::{ActuatorSet, Demand};
use planesman_linear::{Complex, ComplexFunctions as _};
use planesman_text::number;
use planesman_units::{DEGREE, FOOT, INCH};

use crate::design::harmonic_balance::{DepthLoop, Describing, MOST_RESIDUAL};
use crate::design::subject::TABLE_3;

/// An actuator's sizes in SI and in the report's units.
#[must_use]
pub fn size_table(set: &ActuatorSet) -> Table {
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

/// The sizes, and the predicted limit cycle of the depth loop.
#[must_use]
pub fn size_text(set: &ActuatorSet) -> String {
    format!(
        "{}\n{}\n\n{}\n\
         Limit cycle predicted by describing functions, actuator in open loop, single-speed:\n  \
         AUV's depth loop (Brunner, T6), no leakage: {}\n",
        set.name,
        set.source,
        size_table(set).aligned(),
        depth_cycle(set)
    )
}

fn depth_cycle(set: &ActuatorSet) -> String {
    let tight = ActuatorSet {
        rate_gain: 0.0,
        error_rate: 0.0,
        ..set.clone()
    };
    let around = DepthLoop {
        model: TABLE_3,
        speed: FOOT,
        integral: 0.0,
    };
    let amplitudes = (set.threshold, 4.0 * set.threshold);
    let cycle = around.predict(&tight, amplitudes, &Describing::default(), |angle| Demand {
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

/// Gain and phase.
#[must_use]
pub fn gain_and_phase(response: Complex<f64>) -> String {
    format!(
        "{:>6.2} dB {:>5.0} deg",
        20.0 * libm::log10(response.modulus()),
        response.argument() / DEGREE
    )
}

/// The actuator's frequency response as text, for amplitudes given in quanta.
///
/// # Errors
/// An actuator without a linear model.
pub fn frequency_text(set: &ActuatorSet) -> Result<String, planesman_linear::Error> {
    let model = linearised::actuator(set, Ram::OnItsOil)?;
    let quanta = [1.0, 4.0, 16.0];
    let mut text = format!(
        "{}: plane angle divided by plane command, in the position loop\n\n{:>4} {:>18}",
        set.name, "Hz", "linear"
    );
    for n in quanta {
        let quanta = if n == 1.0 { "quantum" } else { "quanta" };
        let _ = write!(text, " {:>18}", format!("{n} {quanta}"));
    }
    let _ = writeln!(text);
    for hertz in [0.1, 0.2, 0.5, 1.0, 2.0, 4.0] {
        let _ = write!(
            text,
            "{hertz:>4} {:>18}",
            gain_and_phase(model.at(TAU * hertz)).trim_start()
        );
        for n in quanta {
            let demand = Demand::angle(n * set.quantum);
            let response =
                frequency_response::actuator(set, demand, TAU * hertz, Periods::default());
            let _ = write!(text, " {:>18}", gain_and_phase(response).trim_start());
        }
        let _ = writeln!(text);
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_hydraulics::actuator_file;

    #[test]
    fn an_actuator_is_shown_in_both_units_with_the_limit_cycle_that_it_leaves() {
        let text = size_text(&actuator_file::load("table_4_1").unwrap());
        let quantum = text.lines().find(|l| l.contains("V_c/A_L")).unwrap();
        assert!(
            quantum.contains("0.0038608 m") && quantum.contains("0.152 in"),
            "{quantum}"
        );
        assert!(
            text.contains("no leakage: none (1 + N H stays 0.55 from 0)"),
            "{text}"
        );
        let text = size_text(&actuator_file::load("auv").unwrap());
        assert!(text.contains("no leakage: 0.0"), "{text}");
    }
}
