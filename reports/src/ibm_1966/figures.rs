//! Figures of the actuator study (IBM 66-L03-005), Sections III to V, missing in the copy and simulated again.
//!
//! The contents are known from captions and text. The missile is the surrogate PS-2 throughout. The laboratory hardware no longer exists: where the
//! report compared it with the mathematical model, only the model is drawn. Axes are the report's: degrees, inches, psi.

use std::f64::consts::TAU;

use crate::ibm_1966::analog_loop::AnalogLoop;
use crate::ibm_1966::autopilot::{Gains, PULSE};
use crate::ibm_1966::case::Case;
use crate::ibm_1966::digital_loop::Start;
use crate::ibm_1966::flight_control::{self, FlightControl};
use crate::ibm_1966::missile::Surrogate;
use crate::ibm_1966::tables::{Row, TABLE_3_2, TABLE_4_2};
use planesman_hydraulics::frequency_response::Periods;
use planesman_hydraulics::linearised::Ram;
use planesman_hydraulics::{ActuatorSet, Condition, PulseTrain};
use planesman_linear::ComplexFunctions as _;
use planesman_units::{DEGREE, INCH};

use crate::book::{Chapter, ReportError};
use planesman_show::plot::{Plot, Style};

/// Surrogate missile of all figures.
const SURROGATE: Surrogate = Surrogate::Ps2;
/// Duration of a plotted transient, s.
const TRANSIENT: f64 = 10.0;
/// Time after which only a limit cycle remains, and its plotted duration, s.
const SETTLED: f64 = 20.0;
const CYCLES: f64 = 4.0;
/// Friction as made by the report's latch, which releases the load only above Delta F.
const LATCH: Condition = Condition {
    stepping: 0.05,
    ..Condition::SOUND
};
/// Yaw angle beyond which the missile counts as lost, degrees.
const LOST: f64 = 10.0;
/// Amplitudes of the sinusoids, pulses of steering.
const AMPLITUDES: [(f64, &str); 2] = [(2.0, "N_y = 2 sin wt"), (4.0, "N_y = 4 sin wt")];
/// Frequencies of the sinusoids, Hz.
const FREQUENCIES: [f64; 10] = [0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 1.0, 1.2, 1.5, 2.0];

/// Input of a flight control.
#[derive(Clone, Copy)]
enum Input {
    /// Steering pulses, from the start.
    Step(f64),
    /// Initial yaw angle psi_0, degrees.
    Yaw(f64),
}

/// Input of most figures.
const STEP: Input = Input::Step(10.0);
const HALF_A_DEGREE: Input = Input::Yaw(-0.5);

/// Axes of most figures.
const YAW: [&str; 2] = ["time [s]", "psi [deg]"];
const RAM: [&str; 2] = ["time [s]", "X_1 [in]"];

/// All figures, by the report's sections.
///
/// # Errors
/// A built-in actuator cannot be read.
pub fn figures() -> Result<Vec<Chapter>, ReportError> {
    Ok(vec![
        Chapter {
            title: "Sections I and II: arrangement and logic",
            note: "Fig. 1-1 is a block diagram. An IBM 709 and an analog computer solve the equations of the flight control, with the actuator's model or the hardware in the loop. Figs. 2-8 (timing of the converter) and 2-12 (Coulomb friction from a bang-bang amplifier) cannot be drawn, because the report omits the necessary details of the analog computer. The curve of Fig. 2-2 is missing too; the text mentions only its discontinuity, which accurate positioning uses.",
            figures: section_2()?,
        },
        Chapter {
            title: "Section III: mathematical model and hardware",
            note: "The recorded curves are missing in the copy of the report. These are simulations of the surrogate missile PS-2 with the actuator of Table 3-1; the data of the report's own missile and of the hardware are lost. Figures 3-3 and 3-4 are block diagrams. In Fig. 3-3, either the hardware or the model closes the loop, and the other receives the same commands; Fig. 3-4 shows the equations of the ram with its load.",
            figures: section_3()?,
        },
        Chapter {
            title: "Section IV: digital and analog flight control",
            note: "Simulations of the surrogate missile PS-2 with the actuator of Table 4-1.",
            figures: section_4()?,
        },
        Chapter {
            title: "Section V: linear model",
            note: "Results for the surrogate missile PS-2. Figs. 5-1 to 5-5 are block diagrams, each derived from the previous one; the last diagram is the linear model of Figs. 5-6 and 5-7.",
            figures: section_5()?,
        },
    ])
}

/// Mean flow as a function of a constant error, for actuators with one volume and with two.
///
/// # Errors
/// A built-in actuator cannot be read.
fn section_2() -> Result<Vec<Plot<'static>>, ReportError> {
    let actuator =
        planesman_hydraulics::actuator_file::load("table_4_1").map_err(ReportError::computed)?;
    Ok(vec![flow_curve(&actuator)])
}

/// Flow curve: one volume per cycle with the error's sign beyond the threshold; within it only leakage.
fn flow_curve(actuator: &ActuatorSet) -> Plot<'static> {
    let cubic_inches = |volume: f64| volume / (INCH * INCH * INCH);
    let widest = 4.0 * actuator.threshold;
    let flow = |error: f64| {
        let of_volume = match &actuator.small {
            _ if error.abs() > actuator.threshold => actuator.volume,
            Some(small) if error.abs() > small.threshold => small.volume,
            _ => 0.0,
        };
        let drift = if error < 0.0 {
            -actuator.rate_gain
        } else {
            actuator.rate_gain
        };
        cubic_inches(error.signum() * of_volume / actuator.cycle() + drift)
    };
    let points = (-200..=200).map(|k| widest * (f64::from(k) + 0.5) / 200.0);
    Plot::new("Fig. 2-2: flow curve for digital unit", ["error [deg]", "flow [in^3/s]"])
        .note("The missing curve is computed here from the logic in Table 4-1. Beyond the threshold, one volume flows in each cycle; an actuator with two volumes begins with the small one. Within the threshold only the drift flows, in the direction of the sign pulse. The report's precision mode (accurate positioning) uses this jump of the drift at zero error.")
        .line("one volume per cycle, drift with the error's sign", points.map(|error| (error / DEGREE, flow(error))))
}

/// Figures of Section III: parameters of the hardware.
///
/// # Errors
/// A built-in actuator cannot be read.
fn section_3() -> Result<Vec<Plot<'static>>, ReportError> {
    let base = Case::table_3_1(SURROGATE).map_err(ReportError::computed)?;
    let row = |id: &str| changed(&TABLE_3_2, id, &base);
    let (supple, damped) = (row("C=6"), row("C=18"));
    let (soft, stiff) = (row("beta_V=13300"), row("beta_V=100000"));
    let of_hardware = base.clone().adjusted();
    let cycle = |case: &Case, length: f64| ram(flown(case, HALF_A_DEGREE, SETTLED, length));
    let [step_yaw, step_ram] =
        transients("3-6", "step of 10 pulses, mathematical model", &base, STEP);
    let mut figures = vec![
        Plot::new("Fig. 3-1: motion of the ram for steps of either sign", RAM)
            .note("A positive step is stopped by negative ram motion, in which the pressure force is larger. For the negative step the ram's speed is limited more.")
            .line("N_y = +8", ram(flown(&base, Input::Step(8.0), 0.0, 3.0)))
            .line("N_y = -8", ram(flown(&base, Input::Step(-8.0), 0.0, 3.0))),
        Plot::new("Fig. 3-2: motion of the ram for a step of 10 pulses", RAM)
            .note("The report compared this curve of the model with the curve recorded on the hardware: they were parallel, so q_LC was about right.")
            .line("model", ram(flown(&base, STEP, 0.0, 3.0))),
        Plot::new("Fig. 3-5: limit cycle of the ram", RAM)
            .note("Actuator of Table 3-1. The report compared the hardware's record with the model's.")
            .line("model", cycle(&base, 1.5)),
        Plot::new("Fig. 3-5, detail: the ram on its drift", RAM)
            .note("The report's model crept in steps because of the latch that made its friction. The hardware creeps smoothly, and so does the model with exact friction.")
            .line("with the report's latch", drifting(&base, LATCH))
            .line("exact friction", drifting(&base, Condition::SOUND)),
        step_yaw.note("Table 3-1."),
        step_ram,
        Plot::new("Fig. 3-7: limit cycle, mathematical model", RAM)
            .note("Twenty seconds after half a degree of yaw.")
            .line("model", cycle(&base, CYCLES)),
        Plot::new("Fig. 3-8: step of 10 pulses, the loop closed on the hardware", YAW)
            .note("The hardware no longer exists; the curves show the unchanged model, and the model with D1's delay and friction, which would explain Table 3-2.")
            .line("with T_D = 10 ms and 8 % more friction", yaw(after_step(&of_hardware)))
            .line("unchanged model", yaw(after_step(&base))),
    ];
    for (title, case) in [
        ("Fig. 3-9: step of 10 pulses, C = 6 lb s/in", &supple),
        ("Fig. 3-10: step of 10 pulses, C = 18 lb s/in", &damped),
    ] {
        figures.push(
            Plot::new(title, YAW)
                .note("The response does not change significantly.")
                .line("C changed", yaw(after_step(case)))
                .line("C = 12 lb s/in", yaw(after_step(&base))),
        );
    }
    figures.extend([
        Plot::new("Fig. 3-11: limit cycle, C = 6 and 18 lb s/in", RAM)
            .note("With less damping the ram overshoots more.")
            .line("(a) C = 6", cycle(&supple, CYCLES))
            .line("(b) C = 18", cycle(&damped, CYCLES)),
        Plot::new("Fig. 3-12: step of 10 pulses, beta/V = 13 300 and 100 000 lb/in^5", YAW)
            .note("The first swing is the same, but the settling differs; the report also finds this, and attributes it to changed conditions in the loop.")
            .line("(a) 13 300", yaw(after_step(&soft)))
            .line("(b) 100 000", yaw(after_step(&stiff))),
        Plot::new("Fig. 3-13: limit cycle, beta/V = 13 300 and 100 000 lb/in^5", RAM)
            .note("The cycle's frequency hardly changes.")
            .line("(a) 13 300", cycle(&soft, 1.5))
            .line("(b) 100 000", cycle(&stiff, 1.5)),
        Plot::new("Fig. 3-13, detail: the ram on its drift", RAM)
            .note("With the report's latch: the stiffer the oil, the faster the steps.")
            .line("(a) 13 300", drifting(&soft, LATCH))
            .line("(b) 100 000", drifting(&stiff, LATCH)),
    ]);
    figures.extend(bode(
        "3-14",
        "the loop closed on the hardware",
        "The hardware no longer exists; the curve shows the model with D1's delay and friction. Above 1.2 Hz this missile diverges when the amplitude is four pulses.",
        &frequency_curves(&of_hardware),
    ));
    figures.extend(bode(
        "3-15",
        "mathematical model",
        "Actuator of Table 3-1, with amplitudes too small to reach the ram's rate limit.",
        &frequency_curves(&base),
    ));
    Ok(figures)
}

/// Figures of Section IV: the Polaris flight control, digital and analog.
///
/// # Errors
/// A built-in actuator cannot be read.
fn section_4() -> Result<Vec<Plot<'static>>, ReportError> {
    let base = Case::table_4_1(SURROGATE).map_err(ReportError::computed)?;
    let row = |id: &str| changed(&TABLE_4_2, id, &base);
    let of = |number, what, note: &'static str, case: &Case, input| {
        let [yaw, ram] = transients(number, what, case, input);
        [yaw.note(note), ram]
    };
    let (step, yaw) = (STEP, HALF_A_DEGREE);
    let (tight, worst) = (row("qL=qLC=0"), row("worst"));
    let (slow, quick, middle) = (row("K=2^-16"), row("K=2^-5"), row("K=2^-9"));
    let mut figures: Vec<_> = [
        of(
            "4-1",
            "step of 10 pulses",
            "Actuator of Table 4-1. This is the largest stable step.",
            &base,
            step,
        ),
        of(
            "4-2",
            "half a degree of yaw",
            "Actuator of Table 4-1. The limit cycle has 0.013 degrees (report: about 0.03).",
            &base,
            yaw,
        ),
        of(
            "4-3",
            "half a degree of yaw, no leakage",
            "The limit cycle is five times larger and slower: 0.067 degrees (I5).",
            &tight,
            yaw,
        ),
        of(
            "4-4",
            "half a degree of yaw, worst leakage",
            "The response is not noticeably different from Fig. 4-2.",
            &worst,
            yaw,
        ),
        of(
            "4-5",
            "step of 10 pulses, K = 2^-16",
            "Without integral compensation the leakage causes a steady-state error of psi.",
            &slow,
            step,
        ),
        of(
            "4-6",
            "half a degree of yaw, K = 2^-5",
            "Highly oscillatory.",
            &quick,
            yaw,
        ),
    ]
    .into_iter()
    .flatten()
    .collect();
    figures.extend(analog());
    figures.extend(
        [
            of(
                "4-9",
                "step of 10 pulses, K = 2^-9",
                "The response is similar to that of the analog flight control, Fig. 4-7.",
                &middle,
                step,
            ),
            of(
                "4-10",
                "half a degree of yaw, K = 2^-9",
                "The response is similar to that of the analog flight control, Fig. 4-8, except for the remaining limit cycle.",
                &middle,
                yaw,
            ),
        ]
        .into_iter()
        .flatten(),
    );
    figures.extend(bode(
        "4-11",
        "Polaris flight control",
        "Actuator of Table 4-1, small amplitudes. At 2 Hz four pulses exceed the ram's rate limit.",
        &frequency_curves(&base),
    ));
    Ok(figures)
}

/// Figures of Section V: the linear model.
///
/// # Errors
/// A built-in actuator cannot be read, or the model cannot be computed.
fn section_5() -> Result<Vec<Plot<'static>>, ReportError> {
    let base = Case::table_4_1(SURROGATE).map_err(ReportError::computed)?;
    let linear = FlightControl::new(&SURROGATE.plant(), &base.gains, &base.set, Ram::Rigid)
        .map_err(ReportError::computed)?;
    let response = (1..=200)
        .map(|i| {
            let hertz = f64::from(i) * 0.01;
            (hertz, linear.response(TAU * hertz))
        })
        .collect();
    let mut curves = vec![Curve {
        name: "linear model",
        style: Style::Line,
        points: response,
    }];
    curves.extend(frequency_curves(&base));
    let note = "The response of the full model (Fig. 4-11) is shown for comparison.";
    let mut figures = bode("5-6", "linear model", note, &curves)
        .into_iter()
        .collect::<Vec<_>>();
    let dt = 0.01;
    let steps = linear.step(dt, TRANSIENT).map_err(ReportError::computed)?;
    let line = steps
        .iter()
        .enumerate()
        .map(|(i, y)| (i as f64 * dt, y * 10.0 * PULSE / DEGREE));
    figures.push(
        Plot::new("Fig. 5-7: step of 10 pulses, linear model", YAW)
            .note("The full model (Fig. 4-1) is shown for comparison; its larger overshoot is caused by the ram's rate limit.")
            .line("linear model", line)
            .dashed("full model", yaw(after_step(&base))),
    );
    Ok(figures)
}

/// A point of a simulation: s, degrees, inches.
struct Point {
    time: f64,
    yaw: f64,
    ram: f64,
}

/// Simulated points from the time `from`, for `length` s.
fn flown(case: &Case, input: Input, from: f64, length: f64) -> Vec<Point> {
    /// Number of simulated instants per plotted point.
    const STRIDE: usize = 6;
    let (steering, yaw) = match input {
        Input::Step(pulses) => (pulses, 0.0),
        Input::Yaw(degrees) => (0.0, degrees * DEGREE),
    };
    let mut flight = case.fly(Start { yaw, ram: 0.0 });
    let (mut points, mut seen) = (Vec::new(), 0);
    while flight.time() < from + length {
        flight.cycle(steering, |now| {
            seen += 1;
            if now.time >= from && seen % STRIDE == 0 {
                points.push(Point {
                    time: now.time,
                    yaw: now.yaw.angle / DEGREE,
                    ram: now.ram / INCH,
                });
            }
        });
    }
    points
}

/// A simulation after [`STEP`], for the duration of a transient.
fn after_step(case: &Case) -> Vec<Point> {
    flown(case, STEP, 0.0, TRANSIENT)
}

/// The ram alone, drifting in negative direction from rest: inches over s.
fn drifting(case: &Case, condition: Condition) -> Vec<(f64, f64)> {
    let mut train = PulseTrain::worn(&case.set, condition, -1, &[]);
    let times = (0..=1000).map(|i| 5e-4 * f64::from(i));
    times
        .map(|time| (time, train.at(time).ram.position / INCH))
        .collect()
}

/// The case changed by the row with this id; unchanged if there is no such row.
fn changed(rows: &[Row], id: &str, base: &Case) -> Case {
    rows.iter()
        .find(|row| row.id == id)
        .map_or_else(|| base.clone(), |row| row.of(base))
}

/// Yaw and ram of one simulation: two plots of Fig. `number`.
fn transients(number: &str, what: &str, case: &Case, input: Input) -> [Plot<'static>; 2] {
    let points = flown(case, input, 0.0, TRANSIENT);
    [
        Plot::new(format!("Fig. {number}: {what} (yaw)"), YAW).line("psi", yaw(&points)),
        Plot::new(format!("Fig. {number}: {what} (ram)"), RAM).line("X_1", ram(&points)),
    ]
}

fn yaw(points: impl AsRef<[Point]>) -> Vec<(f64, f64)> {
    let points = points.as_ref().iter();
    points.map(|p| (p.time, p.yaw)).collect()
}

fn ram(points: impl AsRef<[Point]>) -> Vec<(f64, f64)> {
    let points = points.as_ref().iter();
    points.map(|p| (p.time, p.ram)).collect()
}

/// The analog flight control: a step, and half a degree of yaw in either direction.
fn analog() -> [Plot<'static>; 3] {
    let fly = |steering: f64, degrees: f64| {
        let mut flight = AnalogLoop::new(SURROGATE, Gains::new(SURROGATE), degrees * DEGREE);
        let (mut yaw, mut nozzle) = (Vec::new(), Vec::new());
        while flight.time() < TRANSIENT {
            yaw.push((flight.time(), flight.yaw().angle / DEGREE));
            nozzle.push((flight.time(), flight.nozzle() / DEGREE));
            (0..50).for_each(|_| flight.step(steering));
        }
        (yaw, nozzle)
    };
    let (step, step_nozzle) = fly(10.0, 0.0);
    let (left, _) = fly(0.0, -0.5);
    let (right, _) = fly(0.0, 0.5);
    [
        Plot::new(
            "Fig. 4-7: analog flight control, step of 10 pulses (yaw)",
            YAW,
        )
        .note("The actuator is of second order, calibrated on Table 4-3.")
        .line("psi", step),
        Plot::new(
            "Fig. 4-7: analog flight control, step of 10 pulses (nozzle)",
            ["time [s]", "nozzle [deg]"],
        )
        .line("nozzle", step_nozzle),
        Plot::new("Fig. 4-8: analog flight control, half a degree of yaw", YAW)
            .note("No limit cycle remains.")
            .line("psi_0 = +1/2 deg", right)
            .line("psi_0 = -1/2 deg", left),
    ]
}

/// A frequency response: Hz, and psi/(K_2 N_y).
struct Curve {
    name: &'static str,
    style: Style,
    points: Vec<(f64, planesman_linear::Complex<f64>)>,
}

/// Response of the full model to sinusoids of two amplitudes, where the missile does not diverge.
fn frequency_curves(case: &Case) -> Vec<Curve> {
    AMPLITUDES
        .into_iter()
        .zip([Style::Circles, Style::Crosses])
        .map(|((pulses, name), style)| Curve {
            name,
            style,
            points: FREQUENCIES
                .iter()
                .map(|hertz| {
                    let response = flight_control::full_response(
                        case,
                        pulses,
                        TAU * hertz,
                        Periods::default(),
                    );
                    (*hertz, response)
                })
                .filter(|(_, response)| response.modulus() < LOST)
                .collect(),
        })
        .collect()
}

/// Amplitude and phase: two plots of Fig. `number`.
fn bode(number: &str, what: &str, note: &'static str, curves: &[Curve]) -> [Plot<'static>; 2] {
    let drawn = |title: String, axis, value: fn(planesman_linear::Complex<f64>) -> f64| {
        let plot = Plot::new(title, ["frequency [Hz]", axis]);
        curves.iter().fold(plot, |plot, curve| {
            let points = curve.points.iter().map(|(f, r)| (*f, value(*r)));
            plot.with(curve.style, curve.name, points)
        })
    };
    let amplitude = format!("Fig. {number}: closed-loop amplitude, {what}");
    let phase = format!("Fig. {number}: closed-loop phase");
    [
        drawn(amplitude, "psi/(K_2 N_y) [dB]", |r| {
            20.0 * libm::log10(r.modulus())
        })
        .note(note),
        drawn(phase, "phase [deg]", |r| {
            // The phase only ever lags.
            let phase = r.argument() / DEGREE;
            if phase > 20.0 { phase - 360.0 } else { phase }
        }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_of_the_study_can_be_drawn() {
        let all = [section_3(), section_4(), section_5()];
        for figure in all.into_iter().flat_map(|figures| figures.expect("flown")) {
            assert!(figure.data().is_ok(), "{}", figure.title);
        }
    }
}
