//! Numbers of the instruments: gyros, pressure cells, plane signals, acquisition, tank.
//!
//! Source: Brunner 1988, ch. III.E to IV.H.

use std::f64::consts::PI;

use super::numbers::{BOOK, Recomputed};
use planesman_units::{FOOT, INCH};

use planesman_plant::{
    gyro, plane_signal,
    pressure_cell::{self, BOTTOM_PORT, FULL_SCALE, MANOMETER_WATER, SIDE_PORTS, TANK_WATER},
};
use planesman_vehicle::Port;

use crate::brunner_1988::plane_forces;

/// Sampling time \[s\] (p. 97).
const SAMPLING_TIME: f64 = 0.05;
/// Range of the gyro drift \[mV\] (p. 90).
const DRIFT: f64 = 25.0;
/// Depth of full scale in the bench calibration \[in\] (p. 76).
const BENCH_FULL_SCALE: f64 = 39.0;
/// Full scale of the speed cell \[in of water\] (p. 75).
const SPEED_FULL_SCALE: f64 = 0.8;

/// Recomputable numbers of the families gyro, press, plane, daq and tank; the families rollplane and tx have no such numbers. [`carried`] has the
/// printed numbers used as model constants.
#[must_use]
pub(super) fn recomputed() -> Recomputed {
    [gyros(), pressure_cells(), planes(), acquisition()].concat()
}

fn gyros() -> Recomputed {
    let swing = &gyro::SWING;
    let mut gyros = preliminary(&["sens"]);
    gyros.extend([
        ("gyro.pitch_SI", swing.pitch.sensitivity()),
        ("gyro.roll_SI", swing.roll.sensitivity()),
        (
            "gyro.bias_rate",
            DRIFT * 1e-3 / (swing.pitch.sensitivity() * 1_f64.to_radians()),
        ),
        ("gyro.ref_sens", gyro::reference_sensitivity()),
    ]);
    gyros
}

/// Numbers of the preliminary calibrations, named `gyro.prelim.GYRO_RAIL.DIRECTION.QUANTITY` in the book, such as
/// `gyro.prelim.pitch_4.35V.CCW.slope`.
fn preliminary(quantities: &[&str]) -> Recomputed {
    let value = |id: &str| -> Option<f64> {
        let (gyro, id) = id.strip_prefix("gyro.prelim.")?.split_once('_')?;
        let (rail, id) = id.split_once("V.")?;
        let (direction, quantity) = id.split_once('.')?;
        let gyros = match rail {
            "4.8" => &gyro::PRELIMINARY,
            "4.35" => &gyro::PRELIMINARY_LOW,
            _ => return None,
        };
        let calibration = match gyro {
            "pitch" => &gyros.pitch,
            "roll" => &gyros.roll,
            "yaw" => &gyros.yaw,
            _ => return None,
        };
        let line = match direction {
            "CW" => &calibration.clockwise,
            "CCW" => &calibration.counterclockwise,
            _ => return None,
        };
        match quantity {
            _ if !quantities.contains(&quantity) => None,
            "slope" => Some(line.slope),
            "offset" => Some(line.offset),
            "sens" => Some(line.sensitivity()),
            _ => None,
        }
    };
    let entries = BOOK.iter().flat_map(|book| book.entries());
    entries
        .filter_map(|entry| Some((entry.id.as_str(), value(&entry.id)?)))
        .collect()
}

fn pressure_cells() -> Recomputed {
    let (depth, speed) = (&pressure_cell::DEPTH, &pressure_cell::SPEED);
    let inch_of_depth = INCH * TANK_WATER;
    let per_metre = depth.volts(TANK_WATER, 0.0) - depth.zero;
    let saturation = depth.pressure(FULL_SCALE) / inch_of_depth;
    let zeroed = pressure_cell::PressureCell {
        zero: 0.0,
        ..*depth
    };

    // Dynamic pressure at 1 ft/s, with the report's density.
    let stagnation = 0.5 * 999.835 * FOOT * FOOT;
    let inch_of_manometer = INCH * MANOMETER_WATER;
    let full_scale = speed.pressure(FULL_SCALE);
    let upright = pressure_cell::dry_line_pressure(SIDE_PORTS * INCH, -0.5 * PI, MANOMETER_WATER);

    let port = |aft: f64| Port {
        forward: (15.0 - aft) * INCH,
        below: 0.0,
    };
    let ten_degrees = 10_f64.to_radians();
    let depth_at = |aft: f64| pressure_cell::depth_of(&port(aft), 0.0, ten_degrees);
    let shift = (depth_at(BOTTOM_PORT) - depth_at(SIDE_PORTS)) / INCH;
    vec![
        ("press.depth_bench", FULL_SCALE / BENCH_FULL_SCALE),
        ("press.speed_fs_slope", FULL_SCALE / SPEED_FULL_SCALE),
        ("press.depth_slope_ft", per_metre * FOOT),
        ("press.depth_slope_SI", per_metre),
        (
            "press.offset_in",
            (depth.zero / depth.slope) / inch_of_depth,
        ),
        ("press.depth_max_in", saturation),
        ("press.depth_max_SI", saturation * INCH),
        (
            "press.depth_max_bench_in",
            zeroed.pressure(FULL_SCALE) / inch_of_depth,
        ),
        ("press.q_1fps", stagnation / inch_of_manometer),
        ("press.V_1fps", speed.volts(stagnation, 0.0)),
        (
            "press.pitch_sat",
            libm::asin(full_scale / upright).to_degrees(),
        ),
        ("press.port_shift_err", shift),
        (
            "press.depth_V_per_Uqs",
            per_metre * FOOT / gyro::SWING.pitch.sensitivity(),
        ),
    ]
}

fn planes() -> Recomputed {
    let dive = &plane_signal::DIVE;
    let angle = |degrees: f64| degrees.to_radians();
    // The report's effective angles and its rounded forces, as it goes on with them.
    let turned = |degrees: f64| {
        plane_forces::effective_angle(angle(degrees), plane_forces::JET_SPEED, 1.0).to_degrees()
    };
    vec![
        ("plane.aeff15", turned(15.0)),
        ("plane.aeff30", turned(30.0)),
        (
            "plane.momreq",
            plane_forces::required_moment(0.6, 1.5, 1.0, 8.0),
        ),
        // As the report does it for 15 degrees: with the half angle of 30.
        (
            "plane.A1_15",
            plane_forces::forward_area(0.064, angle(30.0)),
        ),
        ("plane.F2_15", plane_forces::aft_force(angle(11.5))),
        ("plane.F2_30", plane_forces::aft_force(angle(23.0))),
        ("plane.F1_15", plane_forces::forward_force(0.022)),
        ("plane.F1_30", plane_forces::forward_force(0.048)),
        (
            "plane.A1_15_sin7.5",
            plane_forces::forward_area(0.064, angle(15.0)),
        ),
        (
            "plane.A1_30",
            plane_forces::forward_area(0.007, angle(30.0)),
        ),
        ("plane.slope_SI", dive.slope_si()),
        (
            "plane.comp_mismatch",
            plane_signal::PlaneSignal {
                compensation: plane_signal::PRINTED_COMPENSATION,
                ..*dive
            }
            .volts(0.0, 0.0),
        ),
        (
            "plane.limit_V",
            dive.volts(angle(plane_signal::LARGEST_ANGLE), 0.0),
        ),
    ]
}

/// Printed numbers used as model constants, read back from the models.
#[must_use]
pub(super) fn carried() -> Recomputed {
    let (depth, speed) = (&pressure_cell::DEPTH, &pressure_cell::SPEED);
    let (dive, roll) = (&plane_signal::DIVE, &plane_signal::ROLL);
    let mut carried = preliminary(&["slope", "offset"]);
    carried.extend([
        ("gyro.pitch", gyro::SWING.pitch.clockwise.sensitivity()),
        ("gyro.roll", gyro::SWING.roll.clockwise.sensitivity()),
        ("gyro.ref_hi", gyro::REFERENCE),
        ("gyro.ref_lo", gyro::LOW_REFERENCE),
        ("press.speed_slope", speed.slope * INCH * MANOMETER_WATER),
        ("press.depth_slope", depth.slope * INCH * TANK_WATER),
        ("press.depth_offset", depth.zero),
        ("press.port_old", BOTTOM_PORT),
        ("press.port_new", SIDE_PORTS),
        ("plane.slope", dive.slope),
        ("plane.offset", dive.zero),
        ("plane.comp", plane_signal::PRINTED_COMPENSATION),
        ("plane.limit", plane_signal::LARGEST_ANGLE),
        ("rollplane.slope", roll.slope),
        ("rollplane.offset", roll.zero),
        ("rollplane.offset_comp", roll.volts(0.0, 0.0)),
    ]);
    carried
}

fn acquisition() -> Recomputed {
    vec![
        ("daq.fs", 1.0 / SAMPLING_TIME),
        ("daq.nyq", PI / SAMPLING_TIME),
        ("tank.len_SI", 40.0 * FOOT),
    ]
}
