//! Flight control of Section V: the linear model compared with the full model under sinusoids.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use planesman_hydraulics::ActuatorSet;
use planesman_hydraulics::describing_function::toggling;
use planesman_hydraulics::frequency_response::Periods;
use planesman_hydraulics::linearised::Ram;
use planesman_linear::{Complex, ComplexFunctions as _};
use planesman_show::design::{MOST_RESIDUAL, gain_and_phase};
use planesman_units::DEGREE;

use crate::ibm_1966::flight_control::{self, FlightControl};
use crate::ibm_1966::{Case, Gains, PULSE, Start, Surrogate};

/// Text on the missile's closed loop with the actuator.
///
/// # Errors
/// An actuator without a linear model.
pub fn steered(set: &ActuatorSet) -> Result<String, planesman_linear::Error> {
    let surrogate = Surrogate::Ps2;
    let case = Case::new(surrogate, set.clone());
    let control = FlightControl::new(&surrogate.plant(), &case.gains, set, Ram::Rigid)?;
    let mut text = format!("{} with surrogate {surrogate}, K = 2^-7\n", set.name);
    for margin in control.open_loop.phase_margins()? {
        let _ = writeln!(
            text,
            "crossover {:.3} rad/s, phase margin {:.2} deg",
            margin.frequency,
            margin.margin / DEGREE
        );
    }
    for margin in control.open_loop.gain_margins(0.5, 150.0) {
        let _ = writeln!(
            text,
            "gain limit K_g = {:.3} at {:.2} rad/s",
            margin.factor, margin.frequency
        );
    }
    let _ = writeln!(
        text,
        "limit cycle predicted by describing functions, with leakage: {}",
        yaw_cycle(set, &control, surrogate)?
    );
    for (k, gains) in [5, 7, 9, 16].map(|k| {
        let compensation = 0.5f64.powi(k);
        (
            k,
            Gains {
                compensation,
                ..case.gains
            },
        )
    }) {
        let control = FlightControl::new(&surrogate.plant(), &gains, set, Ram::Rigid)?;
        let (at, peak) = control.peak(0.5, 30.0);
        let _ = writeln!(text, "K = 2^-{k}: peak {peak:.3} at {at:.2} rad/s");
    }
    let _ = writeln!(
        text,
        "\npsi/(K_2 N_y)\n{:>6} {:>20} {:>20} {:>20}",
        "f, Hz", "linear", "full, N_y = 2", "full, N_y = 4"
    );
    for hertz in [0.2, 0.5, 0.8, 1.0, 1.5] {
        let _ = write!(
            text,
            "{hertz:>6} {:>20}",
            gain_and_phase(control.response(TAU * hertz))
        );
        for pulses in [2.0, 4.0] {
            let full =
                flight_control::full_response(&case, pulses, TAU * hertz, Periods::default());
            let _ = write!(text, " {:>20}", gain_and_phase(full));
        }
        let _ = writeln!(text);
    }
    let dt = 1e-3;
    let linear = peak(
        control
            .step(dt, 3.0)?
            .into_iter()
            .enumerate()
            .map(|(i, y)| (i as f64 * dt, y)),
    );
    let _ = writeln!(
        text,
        "\nstep of steering: peak psi/(K_2 N_y) and when\n  linear {:.3} at {:.3} s",
        linear.1, linear.0
    );
    for pulses in [2.0, 4.0, 6.0, 8.0, 10.0] {
        let mut flight = case.fly(Start::default());
        let mut yaws = Vec::new();
        while flight.time() < 3.0 {
            flight.cycle(pulses, |i| {
                yaws.push((i.time, i.yaw.angle / (pulses * PULSE)))
            });
        }
        let (time, highest) = peak(yaws.into_iter());
        let _ = writeln!(text, "  full, N_y = {pulses}: {highest:.3} at {time:.3} s");
    }
    Ok(text)
}

/// Largest value and its time.
fn peak(values: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    values.fold((0.0, f64::MIN), |a, b| if b.1 > a.1 { b } else { a })
}

/// Limit cycle of the yaw loop with leakage.
fn yaw_cycle(
    set: &ActuatorSet,
    control: &FlightControl,
    surrogate: Surrogate,
) -> Result<String, planesman_linear::Error> {
    let cycle = toggling(&control.open_loop, set.quantum, set.threshold);
    if cycle.residual > MOST_RESIDUAL {
        return Ok(format!("none (1 + N H stays {:.2} from 0)", cycle.residual));
    }
    let plant = surrogate.plant().transfer_function()?;
    // The first harmonic of a square wave of half a quantum.
    let nozzle = 2.0 / PI * set.quantum;
    let yaw = 2.0 * nozzle * plant.value_at(Complex::new(0.0, cycle.frequency)).modulus();
    Ok(format!(
        "{:.2} volumes per second, yaw {:.4} deg peak to peak (dead time only; friction makes it slower)",
        cycle.frequency / PI,
        yaw / DEGREE
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_hydraulics::actuator_file;

    #[test]
    fn polaris_is_shown_with_the_limit_cycle_of_the_yaw_loop() {
        let text = steered(&actuator_file::load("table_4_1").unwrap()).unwrap();
        assert!(text.contains("10.45 volumes per second"), "{text}");
    }
}
