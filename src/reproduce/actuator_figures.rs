//! The lost figures of the actuator study (IBM 66-L03-005), Sections III to V, flown again.
//!
//! What each one showed is known from its caption and the text. The missile is the surrogate PS-2
//! throughout, and the laboratory hardware is not to be had: where the report laid the hardware's record
//! beside the mathematical model's, only the model is drawn. Axes are the report's: degrees, inches, psi.

use std::f64::consts::TAU;

use anyhow::Result;
use dha_actuator::bench::analog_loop::AnalogLoop;
use dha_actuator::bench::autopilot::{Gains, PULSE};
use dha_actuator::bench::case::Case;
use dha_actuator::bench::digital_loop::Start;
use dha_actuator::bench::missile::Surrogate;
use dha_actuator::bench::pulse_train::PulseTrain;
use dha_actuator::bench::tables::{Row, TABLE_3_2, TABLE_4_2};
use dha_actuator::condition::Condition;
use dha_actuator::frequency_response::{self, Periods};
use dha_actuator::linearised::{FlightControl, Ram};
use dha_actuator::units::{DEGREE, INCH};

use super::figures::Figure;
use crate::plot::{Plot, Series, Style};

/// The missile of all figures.
const SURROGATE: Surrogate = Surrogate::Ps2;
/// How long a transient is drawn, s.
const TRANSIENT: f64 = 10.0;
/// When what remains is a limit cycle, s, and how long it is drawn.
const SETTLED: f64 = 20.0;
const CYCLES: f64 = 4.0;
/// The friction that the report's latch made: it lets go of the load above Delta F only.
const LATCH: Condition = Condition {
    stepping: 0.05,
    ..Condition::SOUND
};
/// A response beyond this is a missile that is lost.
const LOST: f64 = 10.0;
/// Amplitudes of the sinusoids, pulses of steering.
const AMPLITUDES: [(f64, &str); 2] = [(2.0, "N_y = 2 sin wt"), (4.0, "N_y = 4 sin wt")];
/// Frequencies of the sinusoids, Hz.
const FREQUENCIES: [f64; 10] = [0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 1.0, 1.2, 1.5, 2.0];

/// What is done to a flight control.
#[derive(Clone, Copy)]
enum Input {
    /// Steering pulses from the start on.
    Step(f64),
    /// psi_0, degrees.
    Yaw(f64),
}

/// The figures of Section III: the hardware's parameters.
///
/// # Errors
/// When a built-in actuator cannot be read.
pub fn section_3() -> Result<Vec<Figure>> {
    let base = Case::table_3_1(SURROGATE)?;
    let row = |id: &str| changed(&TABLE_3_2, id, &base);
    let mut figures = vec![
        ram(
            "Fig. 3-1: motion of the ram for steps of either sign",
            "A positive step is stopped by negative ram motion, for which the pressure has more force. For the negative step the ram is held to a lower speed.",
            vec![
                ("N_y = +8", flown(&base, Input::Step(8.0), 0.0, 3.0)),
                ("N_y = -8", flown(&base, Input::Step(-8.0), 0.0, 3.0)),
            ],
        ),
        ram(
            "Fig. 3-2: motion of the ram for a step of 10 pulses",
            "The report laid the hardware's record beside this one of the model: they ran parallel, so that q_LC was about right.",
            vec![("model", flown(&base, Input::Step(10.0), 0.0, 3.0))],
        ),
        ram(
            "Fig. 3-5: limit cycle of the ram",
            "Table 3-1. The report laid the hardware's record beside the model's.",
            vec![("model", flown(&base, Input::Yaw(-0.5), SETTLED, 1.5))],
        ),
        ram(
            "Fig. 3-5, detail: the ram on its drift",
            "The report's model crept in steps, by the way its latch made friction. The hardware, and exact friction, creep smoothly.",
            vec![
                ("as with the report's latch", drifting(&base, LATCH)),
                ("exact friction", drifting(&base, Condition::SOUND)),
            ],
        ),
    ];
    figures.extend(transients(
        "Fig. 3-6: step of 10 pulses, mathematical model (yaw)",
        "Fig. 3-6: the same (ram)",
        "Table 3-1.",
        &base,
        Input::Step(10.0),
    ));
    figures.push(ram(
        "Fig. 3-7: limit cycle, mathematical model",
        "Twenty seconds after half a degree of yaw.",
        vec![("model", flown(&base, Input::Yaw(-0.5), SETTLED, CYCLES))],
    ));
    figures.push(yaw(
        "Fig. 3-8: step of 10 pulses, the loop closed on the hardware",
        "The hardware is not to be had. Drawn is the model with the delay and friction that would explain Table 3-2 (D1), beside the model as it is.",
        vec![
            ("with T_D = 10 ms and 8 % more friction", flown(&base.clone().adjusted(), Input::Step(10.0), 0.0, TRANSIENT)),
            ("as it is", flown(&base, Input::Step(10.0), 0.0, TRANSIENT)),
        ],
    ));
    for (title, id) in [
        ("Fig. 3-9: step of 10 pulses, C = 6 lb s/in", "C=6"),
        ("Fig. 3-10: step of 10 pulses, C = 18 lb s/in", "C=18"),
    ] {
        figures.push(yaw(
            title,
            "No significant change of the response.",
            vec![
                (
                    "C changed",
                    flown(&row(id), Input::Step(10.0), 0.0, TRANSIENT),
                ),
                (
                    "C = 12 lb s/in",
                    flown(&base, Input::Step(10.0), 0.0, TRANSIENT),
                ),
            ],
        ));
    }
    figures.push(ram(
        "Fig. 3-11: limit cycle, C = 6 and 18 lb s/in",
        "Less damping lets the ram overshoot further.",
        vec![
            (
                "(a) C = 6",
                flown(&row("C=6"), Input::Yaw(-0.5), SETTLED, CYCLES),
            ),
            (
                "(b) C = 18",
                flown(&row("C=18"), Input::Yaw(-0.5), SETTLED, CYCLES),
            ),
        ],
    ));
    let (soft, stiff) = (row("beta_V=13300"), row("beta_V=100000"));
    figures.push(yaw(
        "Fig. 3-12: step of 10 pulses, beta/V = 13 300 and 100 000 lb/in^5",
        "The first swing is the same. How it settles differs, as in the report, which lays that to changed conditions in the loop.",
        vec![
            (
                "(a) 13 300",
                flown(&soft, Input::Step(10.0), 0.0, TRANSIENT),
            ),
            (
                "(b) 100 000",
                flown(&stiff, Input::Step(10.0), 0.0, TRANSIENT),
            ),
        ],
    ));
    figures.push(ram(
        "Fig. 3-13: limit cycle, beta/V = 13 300 and 100 000 lb/in^5",
        "The cycle's frequency hardly changes.",
        vec![
            ("(a) 13 300", flown(&soft, Input::Yaw(-0.5), SETTLED, 1.5)),
            ("(b) 100 000", flown(&stiff, Input::Yaw(-0.5), SETTLED, 1.5)),
        ],
    ));
    figures.push(ram(
        "Fig. 3-13, detail: the ram on its drift",
        "With the report's latch: the stiffer the oil column, the faster the steps.",
        vec![
            ("(a) 13 300", drifting(&soft, LATCH)),
            ("(b) 100 000", drifting(&stiff, LATCH)),
        ],
    ));
    figures.extend(bode(
        [
            "Fig. 3-14: closed-loop amplitude, the loop closed on the hardware",
            "Fig. 3-14: closed-loop phase",
        ],
        "The hardware is not to be had: the model with the delay and friction of D1. Above 1.2 Hz four pulses lose this missile.",
        frequency_curves(&base.clone().adjusted()),
    ));
    figures.extend(bode(
        [
            "Fig. 3-15: closed-loop amplitude, mathematical model",
            "Fig. 3-15: closed-loop phase",
        ],
        "Small amplitudes, so that the ram's rate limit does not show. Table 3-1.",
        frequency_curves(&base),
    ));
    Ok(figures)
}

/// The figures of Section IV: the Polaris flight control, digital and analog.
///
/// # Errors
/// When a built-in actuator cannot be read.
pub fn section_4() -> Result<Vec<Figure>> {
    let base = Case::table_4_1(SURROGATE)?;
    let row = |id: &str| changed(&TABLE_4_2, id, &base);
    let mut figures = Vec::new();
    for (titles, note, case, input) in [
        (
            [
                "Fig. 4-1: step of 10 pulses (yaw)",
                "Fig. 4-1: the same (ram)",
            ],
            "Table 4-1. The largest stable step.",
            base.clone(),
            Input::Step(10.0),
        ),
        (
            [
                "Fig. 4-2: half a degree of yaw (yaw)",
                "Fig. 4-2: the same (ram)",
            ],
            "Table 4-1. It settles in a cycle of 0.013 degrees (the report: about 0.03).",
            base.clone(),
            Input::Yaw(-0.5),
        ),
        (
            [
                "Fig. 4-3: half a degree of yaw, no leakage (yaw)",
                "Fig. 4-3: the same (ram)",
            ],
            "The cycle is five times larger and slower: 0.067 degrees (I5).",
            row("qL=qLC=0"),
            Input::Yaw(-0.5),
        ),
        (
            [
                "Fig. 4-4: half a degree of yaw, worst leakage (yaw)",
                "Fig. 4-4: the same (ram)",
            ],
            "Not noticeably different from Fig. 4-2.",
            row("worst"),
            Input::Yaw(-0.5),
        ),
        (
            [
                "Fig. 4-5: step of 10 pulses, K = 2^-16 (yaw)",
                "Fig. 4-5: the same (ram)",
            ],
            "Without integral compensation the leakage leaves a steady error of psi.",
            row("K=2^-16"),
            Input::Step(10.0),
        ),
        (
            [
                "Fig. 4-6: half a degree of yaw, K = 2^-5 (yaw)",
                "Fig. 4-6: the same (ram)",
            ],
            "Highly oscillatory.",
            row("K=2^-5"),
            Input::Yaw(-0.5),
        ),
    ] {
        figures.extend(transients(titles[0], titles[1], note, &case, input));
    }
    figures.extend(analog());
    for (titles, note, input) in [
        (
            [
                "Fig. 4-9: step of 10 pulses, K = 2^-9 (yaw)",
                "Fig. 4-9: the same (ram)",
            ],
            "Much like the analog flight control's, Fig. 4-7.",
            Input::Step(10.0),
        ),
        (
            [
                "Fig. 4-10: half a degree of yaw, K = 2^-9 (yaw)",
                "Fig. 4-10: the same (ram)",
            ],
            "Much like the analog flight control's, Fig. 4-8, but for the remaining cycle.",
            Input::Yaw(-0.5),
        ),
    ] {
        figures.extend(transients(
            titles[0],
            titles[1],
            note,
            &row("K=2^-9"),
            input,
        ));
    }
    figures.extend(bode(
        [
            "Fig. 4-11: closed-loop amplitude, Polaris flight control",
            "Fig. 4-11: closed-loop phase",
        ],
        "Table 4-1, small amplitudes. At 2 Hz four pulses are beyond the ram's rate limit.",
        frequency_curves(&base),
    ));
    Ok(figures)
}

/// The figures of Section V: the linear model.
///
/// # Errors
/// When a built-in actuator cannot be read or the model cannot be made.
pub fn section_5() -> Result<Vec<Figure>> {
    let base = Case::table_4_1(SURROGATE)?;
    let linear = FlightControl::new(&SURROGATE.plant(), &base.gains, &base.set, Ram::Rigid)?;
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
    let mut figures = bode(
        [
            "Fig. 5-6: closed-loop amplitude, linear model",
            "Fig. 5-6: closed-loop phase",
        ],
        "Beside it what the full model does (Fig. 4-11).",
        curves,
    );
    let dt = 0.01;
    let steps = linear.step(dt, TRANSIENT)?;
    let line = steps
        .iter()
        .enumerate()
        .map(|(i, y)| (i as f64 * dt, y * 10.0 * PULSE / DEGREE))
        .collect();
    let full = flown(&base, Input::Step(10.0), 0.0, TRANSIENT);
    figures.push(figure(
        "Fig. 5-7: step of 10 pulses, linear model",
        "Beside it the full model (Fig. 4-1), which is at its rate limit here: the larger overshoot is the ram's.",
        ["time [s]", "psi [deg]"],
        vec![
            series("linear model", line, Style::Line),
            series("full model", full.iter().map(|p| (p.time, p.yaw)).collect(), Style::Dashed),
        ],
    ));
    Ok(figures)
}

/// A point of a flight: s, degrees, inches.
struct Point {
    time: f64,
    yaw: f64,
    ram: f64,
}

/// A flight from `from` on, `length` s of it.
fn flown(case: &Case, input: Input, from: f64, length: f64) -> Vec<Point> {
    /// Of the instants that a flight shows, every so many are drawn.
    const STRIDE: usize = 3;
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

/// The ram alone, on its negative drift from rest.
fn drifting(case: &Case, condition: Condition) -> Vec<Point> {
    let mut train = PulseTrain::worn(&case.set, condition, -1, &[]);
    (0..=1000)
        .map(|i| {
            let time = 5e-4 * f64::from(i);
            Point {
                time,
                yaw: 0.0,
                ram: train.at(time).ram.position / INCH,
            }
        })
        .collect()
}

/// The row of that name, applied; the case itself when there is none.
fn changed(rows: &[Row], id: &str, base: &Case) -> Case {
    rows.iter()
        .find(|row| row.id == id)
        .map_or_else(|| base.clone(), |row| row.of(base))
}

/// Yaw and ram of one flight.
fn transients(
    yaw_title: &'static str,
    ram_title: &'static str,
    note: &'static str,
    case: &Case,
    input: Input,
) -> [Figure; 2] {
    let of = || flown(case, input, 0.0, TRANSIENT);
    [
        yaw(yaw_title, note, vec![("psi", of())]),
        ram(ram_title, "", vec![("X_1", of())]),
    ]
}

/// Flights under the names they have in the legend.
type Flights = Vec<(&'static str, Vec<Point>)>;

fn yaw(title: &'static str, note: &'static str, flights: Flights) -> Figure {
    over_time(title, note, "psi [deg]", |p| p.yaw, flights)
}

fn ram(title: &'static str, note: &'static str, flights: Flights) -> Figure {
    over_time(title, note, "X_1 [in]", |p| p.ram, flights)
}

fn over_time(
    title: &'static str,
    note: &'static str,
    axis: &'static str,
    value: fn(&Point) -> f64,
    flights: Flights,
) -> Figure {
    let lines = flights.into_iter().map(|(name, points)| {
        let points = points.iter().map(|p| (p.time, value(p))).collect();
        series(name, points, Style::Line)
    });
    figure(title, note, ["time [s]", axis], lines.collect())
}

/// The analog flight control: a step, and half a degree to either side.
fn analog() -> Vec<Figure> {
    let fly = |steering: f64, degrees: f64| {
        let mut flight = AnalogLoop::new(SURROGATE, Gains::of(SURROGATE), degrees * DEGREE);
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
    let axes = |y| ["time [s]", y];
    vec![
        figure(
            "Fig. 4-7: analog flight control, step of 10 pulses (yaw)",
            "Actuator of second order, calibrated on Table 4-3.",
            axes("psi [deg]"),
            vec![series("psi", step, Style::Line)],
        ),
        figure(
            "Fig. 4-7: the same (nozzle)",
            "",
            axes("nozzle [deg]"),
            vec![series("nozzle", step_nozzle, Style::Line)],
        ),
        figure(
            "Fig. 4-8: analog flight control, half a degree of yaw",
            "No limit cycle remains.",
            axes("psi [deg]"),
            vec![
                series("psi_0 = +1/2 deg", right, Style::Line),
                series("psi_0 = -1/2 deg", left, Style::Line),
            ],
        ),
    ]
}

/// A frequency response: Hz, and psi/(K_2 N_y).
struct Curve {
    name: &'static str,
    style: Style,
    points: Vec<(f64, planesman_linear::Complex<f64>)>,
}

/// The full model's response to sinusoids of two amplitudes, where they do not lose the missile.
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
                    let response = frequency_response::flight_control(
                        case,
                        pulses,
                        TAU * hertz,
                        Periods::default(),
                    );
                    (*hertz, response)
                })
                .filter(|(_, response)| response.norm() < LOST)
                .collect(),
        })
        .collect()
}

fn bode(titles: [&'static str; 2], note: &'static str, curves: Vec<Curve>) -> Vec<Figure> {
    let lines = |value: fn(planesman_linear::Complex<f64>) -> f64| {
        curves
            .iter()
            .map(|curve| {
                let points = curve.points.iter().map(|(f, r)| (*f, value(*r))).collect();
                series(curve.name, points, curve.style)
            })
            .collect()
    };
    let decibels = lines(|r| 20.0 * r.norm().log10());
    let degrees = lines(|r| {
        // The phase only ever lags.
        let phase = r.arg() / DEGREE;
        if phase > 20.0 { phase - 360.0 } else { phase }
    });
    vec![
        figure(
            titles[0],
            note,
            ["frequency [Hz]", "psi/(K_2 N_y) [dB]"],
            decibels,
        ),
        figure(titles[1], "", ["frequency [Hz]", "phase [deg]"], degrees),
    ]
}

fn series(name: &'static str, points: Vec<(f64, f64)>, style: Style) -> Series<'static> {
    Series {
        name,
        points,
        style,
    }
}

fn figure(
    title: &'static str,
    note: &'static str,
    [x, y]: [&'static str; 2],
    series: Vec<Series<'static>>,
) -> Figure {
    Figure {
        note: note.into(),
        plot: Plot {
            title,
            x,
            y,
            y_down: false,
            x_shows: &[],
            series,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_of_the_study_can_be_drawn() {
        let all = [section_3(), section_4(), section_5()];
        for figure in all.into_iter().flat_map(|figures| figures.expect("flown")) {
            assert!(figure.plot.svg().is_ok(), "{}", figure.plot.title);
        }
    }
}
