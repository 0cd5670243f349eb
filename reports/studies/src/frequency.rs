//! The linear model of Section V beside the full one under sinusoids.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use planesman_hydraulics::frequency_response::{self, Periods};
use planesman_hydraulics::linearised::{self, Ram};
use planesman_hydraulics::{ActuatorSet, Demand};
use planesman_linear::{Complex, ComplexFunctions as _};
use planesman_units::DEGREE;

use ibm_1966::flight_control::{self, FlightControl};
use ibm_1966::{Case, Gains, PULSE, Start, Surrogate};

/// Gain and phase.
fn cell(response: Complex<f64>) -> String {
    format!(
        "{:>6.2} dB {:>5.0} deg",
        20.0 * libm::log10(response.modulus()),
        response.argument() / DEGREE
    )
}

/// The actuator's own response, for amplitudes counted in quanta, as text.
///
/// # Errors
/// An actuator without a linear model.
pub fn alone(set: &ActuatorSet) -> Result<String, planesman_linear::Error> {
    let model = linearised::actuator(set, Ram::OnItsOil)?;
    let quanta = [1.0, 4.0, 16.0];
    let mut text = format!(
        "{}: plane angle over plane command, in the position loop\n\n{:>4} {:>18}",
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
            cell(model.at(TAU * hertz)).trim_start()
        );
        for n in quanta {
            let demand = Demand::angle(n * set.quantum);
            let response =
                frequency_response::actuator(set, demand, TAU * hertz, Periods::default());
            let _ = write!(text, " {:>18}", cell(response).trim_start());
        }
        let _ = writeln!(text);
    }
    Ok(text)
}

/// The missile's closed loop with the actuator, as text.
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
            cell(control.response(TAU * hertz))
        );
        for pulses in [2.0, 4.0] {
            let full =
                flight_control::full_response(&case, pulses, TAU * hertz, Periods::default());
            let _ = write!(text, " {:>20}", cell(full));
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

/// The highest of values at times, and when.
fn peak(values: impl Iterator<Item = (f64, f64)>) -> (f64, f64) {
    values.fold((0.0, f64::MIN), |a, b| if b.1 > a.1 { b } else { a })
}
