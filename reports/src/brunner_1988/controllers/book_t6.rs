//! Recomputed numbers of program T6: the step response for each derivative gain, and the report's statements about it.

use super::program_t6::{Program, Track};
use super::values::{Values, or_nan};

/// A metric of a simulated program, in the unit of its entries.
type Figure = fn(&Track) -> Option<f64>;

const OVERSHOOT: Figure = |track| Some(track.overshoot());
const T90: Figure = |track| track.reached(0.9);
const T965: Figure = |track| track.reached(0.965);
const FIRST_MAX: Figure = |track| Some(track.first_maximum()?.1);
const T_FIRST_MAX: Figure = |track| Some(track.first_maximum()?.0);
const DIP: Figure = |track| Some(track.first_dip()?.1);
const STEEPEST: Figure = |track| Some(track.largest_dive_angle());

const fn as_coded(setpoint: f64, derivative: f64) -> Program {
    Program {
        setpoint,
        derivative,
        limited: false,
        impulse: false,
        small_angles: false,
    }
}

const fn with_impulse(setpoint: f64, derivative: f64) -> Program {
    Program {
        impulse: true,
        ..as_coded(setpoint, derivative)
    }
}

const fn limited(setpoint: f64, derivative: f64) -> Program {
    Program {
        limited: true,
        ..as_coded(setpoint, derivative)
    }
}

/// Programs with the entries for their metrics.
const FLOWN: &[(Program, &[(&str, Figure)])] = &[
    (
        as_coded(5.0, 0.25),
        &[
            ("T6.ZC5.noimp.Kdz0.25.t90", T90),
            ("T6.ZC5.noimp.Kdz0.25.dip", DIP),
        ],
    ),
    (
        as_coded(5.0, 0.5),
        &[
            ("T6.ZC5.noimp.Kdz0.5.over", OVERSHOOT),
            ("T6.ZC5.noimp.Kdz0.5.t90", T90),
            ("T6.ZC5.noimp.Kdz0.5.t965", T965),
            ("T6.ZC5.noimp.Kdz0.5.first_max", FIRST_MAX),
            ("T6.ZC5.noimp.Kdz0.5.t_first_max", T_FIRST_MAX),
            ("T6.ZC5.noimp.Kdz0.5.dip", DIP),
            ("T6.ZC5.noimp.Kdz0.5.Tmax", STEEPEST),
        ],
    ),
    (
        as_coded(5.0, 0.6),
        &[
            ("T6.ZC5.noimp.Kdz0.6.over", OVERSHOOT),
            ("T6.ZC5.noimp.Kdz0.6.t90", T90),
            ("T6.ZC5.noimp.Kdz0.6.t965", T965),
            ("T6.ZC5.noimp.Kdz0.6.first_max", FIRST_MAX),
            ("T6.ZC5.noimp.Kdz0.6.t_first_max", T_FIRST_MAX),
        ],
    ),
    (
        as_coded(5.0, 0.75),
        &[
            ("T6.ZC5.noimp.Kdz0.75.t90", T90),
            ("T6.ZC5.noimp.Kdz0.75.first_max", FIRST_MAX),
            ("T6.ZC5.noimp.Kdz0.75.t_first_max", T_FIRST_MAX),
            ("T6.ZC5.noimp.Kdz0.75.dip", DIP),
            ("T6.ZC5.noimp.Kdz0.75.Tmax", STEEPEST),
        ],
    ),
    (
        as_coded(5.0, 1.0),
        &[
            ("T6.ZC5.noimp.Kdz1.over", OVERSHOOT),
            ("T6.ZC5.noimp.Kdz1.t965", T965),
            ("T6.ZC5.noimp.Kdz1.Tmax", STEEPEST),
        ],
    ),
    (
        with_impulse(5.0, 0.6),
        &[
            ("T6.ZC5.imp.Kdz0.6.t90", T90),
            ("T6.ZC5.imp.Kdz0.6.t965", T965),
            ("T6.ZC5.imp.Kdz0.6.first_max", FIRST_MAX),
            ("T6.ZC5.imp.Kdz0.6.dip", DIP),
            ("T6.ZC5.imp.Kdz0.6.Tmax", STEEPEST),
        ],
    ),
    (
        limited(5.0, 0.6),
        &[
            ("T6.ZC5.lim.Kdz0.6.t965", T965),
            ("T6.ZC5.lim.Kdz0.6.first_max", FIRST_MAX),
            ("T6.ZC5.lim.Kdz0.6.t_first_max", T_FIRST_MAX),
            ("T6.ZC5.lim.Kdz0.6.dip", DIP),
        ],
    ),
    (
        as_coded(3.0, 0.25),
        &[
            ("T6.ZC3.noimp.Kdz0.25.over", OVERSHOOT),
            ("T6.ZC3.noimp.Kdz0.25.t90", T90),
            ("T6.ZC3.noimp.Kdz0.25.t965", T965),
            ("T6.ZC3.noimp.Kdz0.25.first_max", FIRST_MAX),
            ("T6.ZC3.noimp.Kdz0.25.t_first_max", T_FIRST_MAX),
            ("T6.ZC3.noimp.Kdz0.25.dip", DIP),
            ("T6.ZC3.noimp.Kdz0.25.Tmax", STEEPEST),
        ],
    ),
    (
        as_coded(3.0, 0.5),
        &[
            ("T6.ZC3.noimp.Kdz0.5.over", OVERSHOOT),
            ("T6.ZC3.noimp.Kdz0.5.t90", T90),
            ("T6.ZC3.noimp.Kdz0.5.t965", T965),
            ("T6.ZC3.noimp.Kdz0.5.first_max", FIRST_MAX),
            ("T6.ZC3.noimp.Kdz0.5.t_first_max", T_FIRST_MAX),
        ],
    ),
    (
        as_coded(3.0, 0.6),
        &[
            ("T6.ZC3.noimp.Kdz0.6.t90", T90),
            ("T6.ZC3.noimp.Kdz0.6.t965", T965),
            ("T6.ZC3.noimp.Kdz0.6.first_max", FIRST_MAX),
            ("T6.ZC3.noimp.Kdz0.6.dip", DIP),
            ("T6.ZC3.noimp.Kdz0.6.Tmax", STEEPEST),
        ],
    ),
    (
        as_coded(3.0, 0.75),
        &[
            ("T6.ZC3.noimp.Kdz0.75.over", OVERSHOOT),
            ("T6.ZC3.noimp.Kdz0.75.t90", T90),
            ("T6.ZC3.noimp.Kdz0.75.t965", T965),
            ("T6.ZC3.noimp.Kdz0.75.first_max", FIRST_MAX),
        ],
    ),
    (
        as_coded(3.0, 1.0),
        &[
            ("T6.ZC3.noimp.Kdz1.t90", T90),
            ("T6.ZC3.noimp.Kdz1.Tmax", STEEPEST),
        ],
    ),
    (
        with_impulse(3.0, 0.6),
        &[
            ("T6.ZC3.imp.Kdz0.6.over", OVERSHOOT),
            ("T6.ZC3.imp.Kdz0.6.t965", T965),
            ("T6.ZC3.imp.Kdz0.6.first_max", FIRST_MAX),
            ("T6.ZC3.imp.Kdz0.6.Tmax", STEEPEST),
        ],
    ),
    (
        limited(3.0, 0.6),
        &[
            ("T6.ZC3.lim.Kdz0.6.over", OVERSHOOT),
            ("T6.ZC3.lim.Kdz0.6.t90", T90),
            ("T6.ZC3.lim.Kdz0.6.t_first_max", T_FIRST_MAX),
            ("T6.ZC3.lim.Kdz0.6.dip", DIP),
            ("T6.ZC3.lim.Kdz0.6.Tmax", STEEPEST),
        ],
    ),
];

/// The report's choice: 5 ft, `Kdz = 0.6` rad s/ft.
const CHOSEN: Program = as_coded(5.0, 0.6);

/// Values of the family T6.
#[must_use]
pub(super) fn recomputed() -> Values {
    let mut all = steps();
    all.extend(of_the_chosen());
    all.extend(first_commands());
    all.push(("T6.Kdz_zero_overshoot_first", smallest_without_overshoot()));
    all
}

fn steps() -> Values {
    FLOWN
        .iter()
        .flat_map(|(program, figures)| {
            let track = program.fly().ok();
            figures
                .iter()
                .map(move |(id, figure)| (*id, or_nan(track.as_ref().and_then(figure))))
        })
        .collect()
}

fn of_the_chosen() -> Values {
    let (Ok(track), Ok(linear)) = (
        CHOSEN.fly(),
        Program {
            small_angles: true,
            ..CHOSEN
        }
        .fly(),
    ) else {
        return Values::new();
    };
    let rise = track.reached(0.98);
    vec![
        ("T6.rise", or_nan(rise)),
        ("T6.band", or_nan(rise.map(|t| track.deviation_since(t)))),
        ("T6.linear.t965", or_nan(linear.reached(0.965))),
        ("T6.traj.z_2.5", track.depth(2.5)),
        ("T6.traj.z_5", track.depth(5.0)),
        ("T6.traj.T_5", track.dive_angle(5.0)),
        ("T6.traj.T_7.5", track.dive_angle(7.5)),
        ("T6.traj.T_10", track.dive_angle(10.0)),
        ("T6.traj.z_12.5", track.depth(12.5)),
        ("T6.traj.T_12.5", track.dive_angle(12.5)),
        ("T6.traj.T_15", track.dive_angle(15.0)),
        ("T6.traj.z_20", track.depth(20.0)),
        ("T6.traj.T_20", track.dive_angle(20.0)),
        ("T6.traj.z_30", track.depth(30.0)),
        ("T6.traj.T_30", track.dive_angle(30.0)),
        ("T6.traj.z_40", track.depth(40.0)),
        ("T6.traj.T_40", track.dive_angle(40.0)),
        ("T6.traj.z_50", track.depth(50.0)),
        ("T6.traj.T_50", track.dive_angle(50.0)),
    ]
}

fn first_commands() -> Values {
    let (Ok(five), Ok(three)) = (CHOSEN.first_command(), as_coded(3.0, 0.6).first_command()) else {
        return Values::new();
    };
    vec![
        ("T6.TC0_ZC5", five.dive_angle.to_degrees()),
        ("T6.TC0_ZC3", three.dive_angle.to_degrees()),
        ("T6.DEL0_ZC3", three.planes.to_degrees()),
    ]
}

/// Smallest `Kdz`, in steps of 0.01 rad s/ft, with a practically invisible overshoot of 0.25 %. At 0.5 the overshoot is still 3 %.
fn smallest_without_overshoot() -> f64 {
    (50..100)
        .map(|hundredths| f64::from(hundredths) / 100.0)
        .find(|kdz| {
            as_coded(5.0, *kdz)
                .fly()
                .is_ok_and(|track| track.overshoot() <= 0.25)
        })
        .unwrap_or(f64::NAN)
}
