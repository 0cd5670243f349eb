//! Recomputed numbers of the loops of ch. II: pitch, depth, roll and heading.

use std::f64::consts::{FRAC_PI_4, TAU};

use planesman_linear::{Domain, Error, StepMetrics, TransferFunction};

use planesman_control::design::step;

use super::axis::{DampedInertia, Gains, damping_for_ratio, damping_ratio};
use super::depth::{DepthDesign, p_for_limit};
use super::values::{Values, or_nan};
use super::{heading, pitch, roll};

/// `wn` of the pitch loop as rounded by the report before further use, rad/s (p. 9).
const ROUNDED_FREQUENCY: f64 = 0.4;

/// Values of the families pitch, depth, roll and yaw.
#[must_use]
pub(super) fn recomputed() -> Values {
    let mut all = pitch_loop();
    all.extend(depth_bounds());
    all.extend(depth_damping());
    all.extend(depth_steps());
    all.extend(roll_loop());
    all.extend(heading_loop());
    all
}

fn pitch_loop() -> Values {
    let axis = pitch::AXIS;
    let critical = axis.p_for_damping_ratio(1.0, 0.0);
    let five_seconds = TAU / 5.0;
    let frequency = axis.natural_frequency(pitch::GAINS.p);
    let ratio_of = |damping| damping_ratio(axis.inertia, ROUNDED_FREQUENCY, damping);
    let damping_08 = damping_for_ratio(axis.inertia, ROUNDED_FREQUENCY, 0.8);
    let chosen = axis.effective_damping(pitch::GAINS.rate);
    let more_rate = axis.rate_gain_for_damping(pitch::MORE_DAMPING);
    vec![
        ("pitch.Kpy_zeta1", critical),
        ("pitch.period_zeta1", TAU / axis.natural_frequency(critical)),
        ("pitch.wn_5s", five_seconds),
        ("pitch.Kpy_5s", axis.p_for_frequency(five_seconds)),
        ("pitch.wn", frequency),
        ("pitch.period", TAU / frequency),
        (
            "pitch.err30",
            pitch::error_at_plane_limit(pitch::GAINS.p, 30.0),
        ),
        ("pitch.Kr_zeta.8", axis.rate_gain_for_damping(damping_08)),
        ("pitch.Beff", chosen),
        ("pitch.zeta", ratio_of(chosen)),
        ("pitch.Kr_B.72", more_rate),
        ("pitch.zeta_B.72", ratio_of(pitch::MORE_DAMPING)),
        (
            "pitch.zeta_B.72_unrounded",
            axis.damping_ratio(Gains {
                rate: more_rate,
                ..pitch::GAINS
            }),
        ),
    ]
}

/// The report's depth loop: `Kpz = 0.25` rad/ft at 1 ft/s, without derivative action.
const DEPTH: DepthDesign = DepthDesign {
    axis: pitch::AXIS,
    pitch: pitch::GAINS,
    speed: 1.0,
    p: 0.25,
    d: 0.0,
};

/// The depth loop with the effective damping of the report's second design.
fn with_more_damping() -> DepthDesign {
    DepthDesign {
        pitch: Gains {
            rate: pitch::AXIS.rate_gain_for_damping(pitch::MORE_DAMPING),
            ..pitch::GAINS
        },
        ..DEPTH
    }
}

/// The depth loop of p. 48, with the restoring moment.
fn with_restoring() -> DepthDesign {
    DepthDesign {
        axis: DampedInertia {
            restoring: pitch::RESTORING,
            ..pitch::AXIS
        },
        ..DEPTH
    }
}

fn depth_bounds() -> Values {
    let smallest_d = |p, speed| DepthDesign { p, speed, ..DEPTH }.smallest_d();
    vec![
        ("depth.Kpz_45", p_for_limit(FRAC_PI_4, 3.0)),
        ("depth.Kpz_limit_U1", DEPTH.largest_p()),
        ("depth.Kpz_limit_Me", with_restoring().largest_p()),
        ("depth.Ucrit_B.34", or_nan(DEPTH.critical_speed())),
        (
            "depth.Ucrit_B.72",
            or_nan(with_more_damping().critical_speed()),
        ),
        ("depth.Kdz_min_Kpz1_U0.5", smallest_d(1.0, 0.5)),
        ("depth.Kdz_min_Kpz1_U1", smallest_d(1.0, 1.0)),
        ("depth.Kdz_min_Kpz0.5_U0.5", smallest_d(0.5, 0.5)),
        ("depth.Kdz_min_Kpz0.25_U1", smallest_d(0.25, 1.0)),
    ]
}

fn depth_damping() -> Values {
    let ratio = |design: DepthDesign| or_nan(design.damping_ratio().ok().flatten());
    let restored = with_restoring();
    vec![
        ("depth.zeta_Kdz.5", ratio(DepthDesign { d: 0.5, ..DEPTH })),
        ("depth.zeta_Me", ratio(DepthDesign { d: 0.6, ..restored })),
    ]
}

/// Metrics of a step response of the depth loop over 120 s.
type Figure = fn(&StepMetrics) -> Option<f64>;
const OVERSHOOT: Figure = |metrics| Some(metrics.overshoot);
const TS2: Figure = |metrics| metrics.settling_time;
const TS5: Figure = |metrics| metrics.settling_time_5;

/// A closed loop, and the entries for metrics of its step response.
type Stepped = (
    Result<TransferFunction, Error>,
    &'static [(&'static str, Figure)],
);

fn depth_steps() -> Values {
    let damped = with_more_damping();
    let fig11 = DepthDesign { d: 5.0, ..DEPTH };
    let fig12 = DepthDesign { d: 0.5, ..DEPTH };
    let fig15 = DepthDesign { d: 1.5, ..damped };
    let fig16 = DepthDesign {
        speed: 3.0,
        ..fig15
    };
    let free = DepthDesign { d: 0.6, ..DEPTH };
    let restored = DepthDesign {
        d: 0.6,
        ..with_restoring()
    };
    let steps: [Stepped; 10] = [
        (
            fig11.closed_loop_of_error_rate(),
            &[
                ("depth.Fig11.ts5_PDerr", TS5),
                ("depth.Fig11.over_PDerr", OVERSHOOT),
                ("depth.Fig11.ts2_PDerr", TS2),
            ],
        ),
        (
            fig11.closed_loop(),
            &[
                ("depth.Fig11.ts5_PDmeas", TS5),
                ("depth.Fig11.ts2_PDmeas", TS2),
            ],
        ),
        (
            fig12.closed_loop_of_error_rate(),
            &[
                ("depth.Fig12.ts5_PDerr", TS5),
                ("depth.Fig12.over_PDerr", OVERSHOOT),
            ],
        ),
        (
            fig12.closed_loop(),
            &[
                ("depth.Fig12.over_PDmeas", OVERSHOOT),
                ("depth.Fig12.ts2_PDmeas", TS2),
            ],
        ),
        (
            fig15.closed_loop_of_error_rate(),
            &[
                ("depth.Fig15.ts5_PDerr", TS5),
                ("depth.Fig15.over_PDerr", OVERSHOOT),
                ("depth.Fig15.ts2_PDerr", TS2),
            ],
        ),
        (
            fig15.closed_loop(),
            &[
                ("depth.Fig15.ts5_PDmeas", TS5),
                ("depth.Fig15.over_PDmeas", OVERSHOOT),
                ("depth.Fig15.ts2_PDmeas", TS2),
            ],
        ),
        (
            fig16.closed_loop_of_error_rate(),
            &[
                ("depth.Fig16.ts5_PDerr", TS5),
                ("depth.Fig16.over_PDerr", OVERSHOOT),
            ],
        ),
        (
            fig16.closed_loop(),
            &[
                ("depth.Fig16.over_PDmeas", OVERSHOOT),
                ("depth.Fig16.ts2_PDmeas", TS2),
            ],
        ),
        (
            free.closed_loop(),
            &[
                ("depth.Kdz.6_noMe.over", OVERSHOOT),
                ("depth.Kdz.6_noMe.ts2", TS2),
            ],
        ),
        (
            restored.closed_loop(),
            &[
                ("depth.Kdz.6_Me.over", OVERSHOOT),
                ("depth.Kdz.6_Me.ts2", TS2),
            ],
        ),
    ];
    steps
        .into_iter()
        .flat_map(|(closed_loop, figures)| {
            let metrics = stepped(closed_loop);
            figures
                .iter()
                .map(move |(id, figure)| (*id, or_nan(metrics.as_ref().and_then(figure))))
        })
        .collect()
}

/// Metrics of a unit step response, with a sampling fine enough for six digits of the overshoot.
fn stepped(closed_loop: Result<TransferFunction, planesman_linear::Error>) -> Option<StepMetrics> {
    step::response(&closed_loop.ok()?, 0.002, 120.0).ok()
}

fn roll_loop() -> Values {
    let axis = roll::AXIS;
    let restored = |restoring| DampedInertia { restoring, ..axis };
    let in_fig_20 = restored(roll::RESTORING);
    let Gains { p, rate } = roll::GAINS;
    let damping_09 = damping_for_ratio(axis.inertia, axis.natural_frequency(p), 0.9);
    let steady = in_fig_20
        .closed_loop(roll::GAINS)
        .and_then(|g| g.steady_state_gain(Domain::Continuous));
    vec![
        ("roll.Beff_zeta.9", damping_09),
        ("roll.Kdx_zeta.9", axis.rate_gain_for_ratio(0.9, p)),
        ("roll.Beff", axis.effective_damping(rate)),
        ("roll.zeta", axis.damping_ratio(roll::GAINS)),
        ("roll.wn", axis.natural_frequency(p)),
        ("roll.ts", axis.settling_time(rate)),
        ("roll.wn_Me", in_fig_20.natural_frequency(p)),
        ("roll.ts_Me", in_fig_20.settling_time(rate)),
        (
            "roll.wn_Me.163",
            restored(roll::WEIGHT_RESTORING).natural_frequency(p),
        ),
        ("roll.dc_Me", or_nan(steady.ok())),
    ]
}

fn heading_loop() -> Values {
    let axis = heading::AXIS;
    let Gains { p, rate } = heading::GAINS;
    let step = stepped(axis.closed_loop_of_error_rate(heading::GAINS));
    vec![
        ("yaw.Kdy_zeta.9", axis.rate_gain_for_ratio(0.9, p)),
        ("yaw.zeta", axis.damping_ratio(heading::GAINS)),
        ("yaw.ts", axis.settling_time(rate)),
        ("yaw.wn", axis.natural_frequency(p)),
        ("yaw.Beff", axis.effective_damping(rate)),
        (
            "yaw.ts2_sim_PDerr",
            or_nan(step.and_then(|s| s.settling_time)),
        ),
        ("yaw.over_PDerr", or_nan(step.map(|s| s.overshoot))),
    ]
}
