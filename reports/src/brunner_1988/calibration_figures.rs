//! The calibration curves (Brunner 1988, ch. IV.B, C, G): Figures 29 to 36, 38 and 40 to 43.
//!
//! The measured points are missing in the copy; the printed fitted lines are drawn over the range of each figure's axis. Fig. 37, vessel speed
//! over command voltage, has no printed line and is omitted.

use planesman_plant::gyro::{self, Calibration};
use planesman_plant::plane_signal::{self, PlaneSignal};
use planesman_plant::pressure_cell::{self, FULL_SCALE, MANOMETER_WATER, TANK_WATER};
use planesman_show::plot::Plot;
use planesman_units::INCH;

/// Depth of full scale in the bench calibration \[in\] (p. 76).
const BENCH_FULL_SCALE: f64 = 39.0;

/// The figures, in the report's order.
#[must_use]
pub fn figures() -> Vec<Plot<'static>> {
    let (high, low) = (&gyro::PRELIMINARY, &gyro::PRELIMINARY_LOW);
    let mut figures: Vec<Plot<'static>> = [
        ("Fig. 29: pitch-rate gyro", &high.pitch, 4.0),
        ("Fig. 30: yaw-rate gyro", &high.yaw, 6.0),
        ("Fig. 31: roll-rate gyro", &high.roll, 4.0),
        (
            "Fig. 32: pitch-rate gyro at low reference voltage",
            &low.pitch,
            4.0,
        ),
        (
            "Fig. 33: yaw-rate gyro at low reference voltage",
            &low.yaw,
            4.0,
        ),
        (
            "Fig. 34: roll-rate gyro at low reference voltage",
            &low.roll,
            4.0,
        ),
    ]
    .into_iter()
    .map(|(title, gyro, fastest)| of_gyro(title, gyro, fastest))
    .collect();
    let (speed, depth) = (&pressure_cell::SPEED, &pressure_cell::DEPTH);
    let volts = |x: f64| move |inch: f64| (inch, x * inch);
    let inches = |most: f64| (0..=8).map(move |k| most * f64::from(k) / 8.0);
    let of_depth = |inch: f64| (inch, depth.volts(inch * INCH * TANK_WATER, 0.0));
    let of_speed = |inch: f64| (inch, speed.volts(inch * INCH * MANOMETER_WATER, 0.0));
    figures.extend([
        Plot::new("Fig. 35: velocity cell calibration", ["manometer level [in of water]", "output [V]"])
            .note("Printed: y = 12.453 x.")
            .line("cell", inches(0.8).map(of_speed)),
        Plot::new("Fig. 36: depth cell calibration, bench test", ["manometer level [in of water]", "output [V]"])
            .note("No line is printed; according to the text it passes through 0 and through 10 V at 39 in.")
            .line("as set", inches(BENCH_FULL_SCALE).map(volts(FULL_SCALE / BENCH_FULL_SCALE))),
        Plot::new("Fig. 38: depth cell calibration, in the vehicle", ["depth [in of water]", "output [V]"])
            .note("Printed: y = 1.627 + 0.257 x. The zero has shifted; the slope is that of the bench test.")
            .line("cell", inches(40.0).map(of_depth))
            .dashed("bench, Fig. 36", inches(BENCH_FULL_SCALE).map(volts(FULL_SCALE / BENCH_FULL_SCALE))),
        of_planes("Fig. 40: uncompensated roll control signal", &plane_signal::ROLL, 20.0, false)
            .note("Printed: y = 2.483 + 0.004 x."),
        of_planes("Fig. 41: compensated roll control signal", &plane_signal::ROLL, 20.0, true)
            .note("Printed: y = 0.061 + 0.004 x. One potentiometer sets the gain of all summing amplifiers; it was set for the dive planes."),
        of_planes("Fig. 42: uncompensated dive plane control signal", &plane_signal::DIVE, 40.0, false)
            .note("Printed: y = 2.44 + 0.010 x."),
        of_planes("Fig. 43: compensated dive plane control signal", &plane_signal::DIVE, 40.0, true)
            .note("Printed: y = 0.01 x."),
    ]);
    figures
}

/// Calibration lines of a gyro in both directions.
fn of_gyro(title: &'static str, gyro: &Calibration, fastest: f64) -> Plot<'static> {
    let line = |of: gyro::Line| {
        (0..=8).map(move |k| {
            let rpm = fastest * f64::from(k) / 8.0;
            (rpm, of.offset + of.slope * rpm)
        })
    };
    let (one, other) = (gyro.clockwise, gyro.counterclockwise);
    Plot::new(title, ["rate [RPM]", "output [mV]"])
        .note(format!(
            "Printed: y = {} + {} x clockwise, y = {} + {} x counterclockwise.",
            one.offset, one.slope, other.offset, other.slope
        ))
        .line("clockwise", line(one))
        .line("counterclockwise", line(other))
}

fn of_planes(
    title: &'static str,
    signal: &PlaneSignal,
    widest: f64,
    is_compensated: bool,
) -> Plot<'static> {
    let signal = match is_compensated {
        true => *signal,
        false => PlaneSignal {
            compensation: 0.0,
            ..*signal
        },
    };
    let volts = (-4..=4).map(|k| {
        let degrees = widest * f64::from(k) / 4.0;
        (degrees, signal.volts(degrees.to_radians(), 0.0))
    });
    Plot::new(title, ["plane angle [deg]", "signal [V]"]).line("signal", volts)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lines as the figures print them, typed anew: intercept and slope, and where the line is read.
    #[test]
    fn the_lines_are_the_printed_ones() {
        let figures = figures();
        let titles: Vec<String> = figures.iter().map(|it| it.data().expect("data")).collect();
        assert_eq!(titles.len(), 13);
        let ends = |signal: &PlaneSignal| signal.volts(10_f64.to_radians(), 0.0);
        assert!((ends(&plane_signal::ROLL) - (0.061 + 0.04)).abs() < 1e-12);
        assert!((ends(&plane_signal::DIVE) - 0.1).abs() < 1e-12);
        let depth = pressure_cell::DEPTH.volts(20.0 * INCH * TANK_WATER, 0.0);
        assert!((depth - (1.627 + 0.257 * 20.0)).abs() < 1e-9);
        let speed = pressure_cell::SPEED.volts(0.5 * INCH * MANOMETER_WATER, 0.0);
        assert!((speed - 12.453 * 0.5).abs() < 1e-9);
    }
}
