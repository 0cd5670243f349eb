//! Programs T2 to T5 (App. A), as printed and with the dimensional vehicle in seconds.

use std::sync::LazyLock;

use planesman_units::FOOT;
use planesman_vehicle::{
    Derivatives, Diverged, Environment, Motion, Restoring, Variant, vehicle_file::brunner,
};

use crate::brunner_1988::{
    programs::{FEET_PER_LENGTH, PLANE_ANGLE, T2, T3, T4, T5, derivation},
    track::Track,
};

/// Duration after which every dive has come to rest \[L/U\] or \[s\].
const LONG: f64 = 60.0;

/// Values of the families T2 to T5, A1, C1, C2, and T2dim to T5dim.
#[must_use]
pub(super) fn recomputed() -> Vec<(&'static str, f64)> {
    let mut all = vec![
        ("A1", derivation::a1()),
        ("C1", derivation::c1()),
        ("C2.correct", derivation::c2()),
        ("C2.program", derivation::c2_in_inches()),
    ];
    all.extend(as_printed());
    all.extend(t2_trajectory());
    all.extend(CONSISTENT.iter().flatten().copied());
    all
}

fn as_printed() -> Vec<(&'static str, f64)> {
    let feet = |length: f64| length * FEET_PER_LENGTH;
    let one_foot = 1.0 / FEET_PER_LENGTH;
    let [t2, t3, t4, t5] = [T2, T3, T4, T5].map(|program| program.run(LONG));
    let held_pitch = |track: &Track| track.at(T2.released_at).pitch.to_degrees();
    let mut values = vec![
        ("T2.depth_final", feet(t2.end().depth)),
        ("T2.pitch_ss", held_pitch(&t2)),
        ("T2.pitch_min", t2.steepest_pitch().to_degrees()),
        ("T2.z_at_4", feet(t2.at(4.0).depth)),
        ("T2.settle5", t2.pitch_settles_at(0.05, T2.released_at)),
        ("T2.settle2", t2.pitch_settles_at(0.02, T2.released_at)),
        ("T2.qdot0", T2.first_pitch_acceleration()),
        ("T2.qmax", t2.fastest_pitch_rate()),
        ("T2.wn_pitch", T2.pitch_frequency()),
        ("T2.zeta_pitch", T2.pitch_damping_ratio()),
        ("T3.depth_final", feet(t3.end().depth)),
        ("T3.pitch_ss", held_pitch(&t3)),
        (
            "T3.reduction",
            100.0 * (1.0 - t3.end().depth / t2.end().depth),
        ),
        ("T4.pitch_fin", t4.end().pitch.to_degrees()),
        ("T4.qmax", t4.fastest_pitch_rate()),
        (
            "T4.qmax_ratio",
            t4.fastest_pitch_rate() / t2.fastest_pitch_rate(),
        ),
        (
            "T4.qdot_ratio",
            T4.first_pitch_acceleration() / T2.first_pitch_acceleration(),
        ),
        ("T5.depth_30", feet(t5.at(30.0).depth)),
        ("T5.pitch_min", t5.steepest_pitch().to_degrees()),
        ("T5.pitch_pp_5_10", t5.pitch_swing(5.0, 10.0).to_degrees()),
        ("T5.wn_pitch", T5.pitch_frequency()),
        ("T5.zeta_pitch", T5.pitch_damping_ratio()),
    ];
    values.extend(t2.time_to_depth(one_foot).map(|t| ("T2.t_1ft", t)));
    values.extend(t3.time_to_depth(one_foot).map(|t| ("T3.t_1ft", t)));
    values
}

/// Pitch \[deg\] and depth \[L\] of T2 at several times \[L/U\].
fn t2_trajectory() -> Vec<(&'static str, f64)> {
    macro_rules! at {
        ($($time:literal)*) => {
            [$((
                f64::from($time),
                concat!("T2.traj.theta_", $time),
                concat!("T2.traj.z_", $time),
            )),*]
        };
    }
    let track = T2.run(20.0);
    at![1 2 4 6 8 10 12 15 20]
        .into_iter()
        .flat_map(|(time, theta, z)| {
            let sample = track.at(time);
            [(theta, sample.pitch.to_degrees()), (z, sample.depth)]
        })
        .collect()
}

/// A dive of the dimensional vehicle at 1 ft/s from rest at the surface.
struct Dive {
    names: Names,
    derivatives: Derivatives,
    restoring: Restoring,
    /// Time until the planes are released \[s\].
    held_for: f64,
    /// Duration of the simulation \[s\].
    watched_for: f64,
}

/// Names of one dive's entries.
struct Names {
    pitch_at_release: &'static str,
    steepest_pitch: &'static str,
    final_depth: &'static str,
    time_to_one_foot: &'static str,
}

macro_rules! names {
    ($dive:literal) => {
        Names {
            pitch_at_release: concat!($dive, ".pitch_off"),
            steepest_pitch: concat!($dive, ".pitch_min"),
            final_depth: concat!($dive, ".z_final"),
            time_to_one_foot: concat!($dive, ".t_1ft"),
        }
    };
}

impl Dive {
    /// The entries, in degrees, feet and seconds.
    fn fly(&self) -> Result<Vec<(&'static str, f64)>, Diverged> {
        let motion = Motion {
            derivatives: self.derivatives,
            restoring: self.restoring,
            environment: Environment {
                density: 999.835,
                gravity: 9.81456,
                atmospheric_pressure: 101_325.0,
            },
            step: 0.001,
        };
        let track = Track::of_dive(&motion, PLANE_ANGLE, self.held_for, self.watched_for)?;
        let names = &self.names;
        let mut values = vec![
            (
                names.pitch_at_release,
                track.at(self.held_for).pitch.to_degrees(),
            ),
            (names.steepest_pitch, track.steepest_pitch().to_degrees()),
            (names.final_depth, track.end().depth / FOOT),
        ];
        values.extend(
            track
                .time_to_depth(FOOT)
                .map(|t| (names.time_to_one_foot, t)),
        );
        Ok(values)
    }
}

/// Manoeuvres of the programs with the dimensional vehicle; computed once because they take a while.
static CONSISTENT: LazyLock<Vec<Vec<(&'static str, f64)>>> = LazyLock::new(|| {
    consistent()
        .iter()
        // A dive that diverges gives no values, which the check of the book reports.
        .filter_map(|dive| dive.fly().ok())
        .collect()
});

fn consistent() -> Vec<Dive> {
    let vehicle = brunner().derivatives(FOOT);
    let pitch_alone = Variant {
        heave: false,
        heave_moment: false,
        ..Variant::default()
    };
    let unrestored = Variant {
        restoring_moment: false,
        ..pitch_alone
    };
    let inches_for_feet = Derivatives {
        restoring: 12.0 * vehicle.restoring,
        ..vehicle
    };
    let t5 = Derivatives {
        m_q: vehicle.m_q * T5.b2 / T2.b2,
        ..vehicle
    };
    let ten_seconds = |names, derivatives, restoring| Dive {
        names,
        derivatives,
        restoring,
        held_for: 10.0,
        watched_for: LONG,
    };
    use Restoring::{Sine, SmallAngle};
    vec![
        ten_seconds(names!("T2dim"), vehicle, SmallAngle),
        ten_seconds(names!("T2dim_sin"), vehicle, Sine),
        ten_seconds(names!("T2dim_inch"), inches_for_feet, SmallAngle),
        Dive {
            // Ten units of time, L / U each.
            held_for: T2.released_at * FEET_PER_LENGTH,
            ..ten_seconds(names!("T2dim_inch23"), inches_for_feet, SmallAngle)
        },
        ten_seconds(names!("T3dim"), pitch_alone.apply(vehicle), SmallAngle),
        ten_seconds(names!("T3dim_sin"), pitch_alone.apply(vehicle), Sine),
        Dive {
            held_for: 1.0,
            // It never levels out: nothing rights it.
            watched_for: 15.0,
            ..ten_seconds(names!("T4dim"), unrestored.apply(vehicle), Sine)
        },
        ten_seconds(names!("T5dim_sin"), t5, Sine),
    ]
}
