//! Numbers of a single calibrated volume, and of drift against friction, by simulation.

use crate::book::Recomputed;
use planesman_hydraulics::actuator_file::{ActuatorFileError, load};
use planesman_hydraulics::{ActuatorSet, PulseTrain};
use planesman_units::INCH;

/// Values of the families `quantum` and `drift`.
///
/// # Errors
/// [`ActuatorFileError`] if a built-in actuator cannot be read.
pub(super) fn recomputed() -> Result<Recomputed, ActuatorFileError> {
    let mut all = Recomputed::new();
    for (id, actuator, friction, sign) in [
        ("T31+", "table_3_1", true, 1),
        ("T31-", "table_3_1", true, -1),
        ("T41+", "table_4_1", true, 1),
        ("T41 dF=0+", "table_4_1", false, 1),
        ("AUV+", "auv", true, 1),
    ] {
        let mut set = load(actuator)?;
        (set.rate_gain, set.error_rate) = (0.0, 0.0);
        if !friction {
            set.load.coulomb = 0.0;
        }
        all.extend(quantum(id, &set, sign));
    }
    for (id, actuator) in [("T31", "table_3_1"), ("T41", "table_4_1"), ("AUV", "auv")] {
        let set = load(actuator)?;
        for sign in [1, -1] {
            let creep = PulseTrain::settled(&set, sign, &[]).at(4.0).ram.velocity;
            all.push((format!("drift.{id}drift{sign}"), creep / INCH));
        }
    }
    Ok(all)
}

/// Time to half of the stroke (to 0.1 ms), overshoot, and ram position after one second.
fn quantum(id: &str, set: &ActuatorSet, sign: i8) -> Recomputed {
    let mut train = PulseTrain::settled(set, sign, &[sign]);
    let (mut half_way, mut peak, mut rest) = (f64::NAN, 0.0f64, 0.0);
    for i in 0..10_000 {
        let time = f64::from(i) * 1e-4;
        rest = train.at(time).ram.position;
        let moved = rest.abs() / set.ram_quantum();
        if half_way.is_nan() && moved >= 0.5 {
            half_way = time;
        }
        peak = peak.max(moved);
    }
    vec![
        (format!("quantum.{id}.t50"), half_way),
        (format!("quantum.{id}.peak"), peak),
        (format!("quantum.{id}.rest"), rest / INCH),
    ]
}
