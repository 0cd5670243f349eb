//! Time responses of the depth loop: Figs. 11, 12, 15 and 16 (Brunner 1988, pp. 19 f.) and C2 to C9 (p. 47 f., program T6).
//!
//! The first four are step responses of the linear loop to three feet, with the derivative of the error. The others are the output of program T6
//! for four derivative gains. The values 0.25, 0.5, 0.6 and 1.0 are assumed: the report states only the first, the last and the best.

use crate::book::ReportError;
use planesman_control::LimitError;
use planesman_control::design::step;
use planesman_linear::Error;

use planesman_show::plot::Plot;

use super::axis::Gains;
use super::depth::DepthDesign;
use super::pitch;
use super::program_t6::{self as t6, Program};

/// Setpoint step of Figs. 11 to 16, ft.
const STEP: f64 = 3.0;
/// Duration of these figures, s.
const DURATION: f64 = 50.0;
/// Time between two plotted points, s.
const INTERVAL: f64 = 0.1;
/// Setpoint of Figs. C2 to C9, ft, from the listing on p. 132.
const SETPOINT: f64 = 5.0;

/// Figures of the linear loop: number, `Kdz`, `U` \[ft/s\], `B` \[ft lbf s\], and a note.
const STEPS: [(u8, f64, f64, f64, &str); 4] = [
    (
        11,
        5.0,
        1.0,
        0.34,
        "Overshoot 22 %, settling to 2 % in 47 s: a larger derivative gain does not settle sooner (E20). The list of figures gives Kdz = 5.",
    ),
    (
        12,
        0.5,
        1.0,
        0.34,
        "Overshoot 8.7 %, settling to 2 % in 21 s. The list of figures gives Kdz = 0.5.",
    ),
    (
        15,
        1.5,
        1.0,
        pitch::MORE_DAMPING,
        "Negligible overshoot (0.5 %).",
    ),
    (16, 1.5, 3.0, pitch::MORE_DAMPING, "Some overshoot: 10 %."),
];

/// Figures of program T6, two for each `Kdz`: number of the first, and gain.
const PROGRAMS: [(u8, f64); 4] = [(2, 0.25), (4, 0.5), (6, 0.6), (8, 1.0)];

/// All time responses of the controllers.
///
/// # Errors
/// A response that overflows, or an error of a simulation.
pub fn figures() -> Result<Vec<Plot<'static>>, ReportError> {
    let mut figures = Vec::new();
    for (number, derivative, speed, damping, note) in STEPS {
        let design = DepthDesign {
            axis: pitch::AXIS,
            pitch: Gains {
                rate: pitch::AXIS.rate_gain_for_damping(damping),
                ..pitch::GAINS
            },
            speed,
            p: t6::DEPTH_GAIN,
            d: derivative,
        };
        let depth = step_of(&design).map_err(ReportError::computed)?;
        let title = format!("Fig. {number}: Kdz = {derivative}, U = {speed} ft/s, B = {damping}");
        figures.push(depth_figure(title, STEP, depth).note(note));
    }
    for (number, derivative) in PROGRAMS {
        figures.extend(program_t6(number, derivative).map_err(ReportError::computed)?);
    }
    Ok(figures)
}

/// Depth after a setpoint step of [`STEP`] from zero, ft over s.
fn step_of(design: &DepthDesign) -> Result<Vec<(f64, f64)>, Error> {
    let response = step::samples(&design.closed_loop_of_error_rate()?, INTERVAL, DURATION)?;
    Ok(response.into_iter().map(|(t, z)| (t, STEP * z)).collect())
}

/// Depth and angles of program T6: Fig. C`number` and the next one.
fn program_t6(number: u8, derivative: f64) -> Result<[Plot<'static>; 2], LimitError> {
    let program = Program::new(SETPOINT, derivative);
    let track = program.fly()?;
    let times: Vec<f64> = (0..=500).map(|k| f64::from(k) * INTERVAL).collect();
    let over_time = |value: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        times.iter().map(|t| (*t, value(*t))).collect()
    };
    let commanded = |time: f64| program.command(track.motion(time));
    commanded(0.0)?;
    let angle = |time: f64, of: fn(&t6::Command) -> f64| {
        commanded(time).map_or(f64::NAN, |command| of(&command).to_degrees())
    };
    let title = |number: u8, what| format!("Fig. C{number}: Kdz = {derivative}, {what}");
    let depth = depth_figure(
        title(number, "depth"),
        SETPOINT,
        over_time(&|t| track.depth(t)),
    )
    .note("Program T6 as listed, without limits: the first plane command is 50 degrees (E9).");
    let angles = Plot::new(title(number + 1, "angles"), [TIME, "angle [deg], bow down"])
        .note("Positive to dive, as in the program.")
        .from_zero()
        .line("pitch", over_time(&|t| track.dive_angle(t)))
        .dashed(
            "commanded pitch",
            over_time(&|t| angle(t, |c| c.dive_angle)),
        )
        .line("planes", over_time(&|t| angle(t, |c| c.planes)));
    Ok([depth, angles])
}

const TIME: &str = "time [s]";

fn depth_figure(title: String, setpoint: f64, depth: Vec<(f64, f64)>) -> Plot<'static> {
    Plot::new(title, [TIME, "depth [ft]"])
        .y_down()
        .from_zero()
        .line("depth", depth)
        .dashed("setpoint", [0.0, DURATION].map(|t| (t, setpoint)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn deepest(figure: &Plot<'_>) -> f64 {
        let points = figure.series[0].points.iter();
        points.map(|p| p.1).fold(0.0, f64::max)
    }

    #[test]
    fn the_overshoots_are_those_written_above_the_figures() {
        let figures = figures().expect("flown");
        for (i, percent) in [(0, 22.4), (1, 8.7), (2, 0.5), (3, 10.2)] {
            let overshoot = 100.0 * (deepest(&figures[i]) / STEP - 1.0);
            assert!((overshoot - percent).abs() < 0.1, "{i}: {overshoot}");
        }
        // Program T6: overshoot for 0.25 and 0.5, none to speak of from 0.6 on.
        for (i, percent) in [(4, 14.9), (6, 3.3), (8, 0.2)] {
            let overshoot = 100.0 * (deepest(&figures[i]) / SETPOINT - 1.0);
            assert!((overshoot - percent).abs() < 0.1, "{i}: {overshoot}");
        }
    }

    #[test]
    fn every_figure_can_be_drawn() {
        for figure in figures().expect("flown") {
            assert!(figure.data().is_ok(), "{}", figure.title);
        }
    }
}
