//! Limits poles to a circle.

pub(crate) use planesman_linear::polynomial::lies_within;
use planesman_linear::{Complex, ComplexFunctions as _, polynomial};

use crate::structure::monic;

/// The largest magnitude of a pole whose memory is at most this many samples.
pub(crate) fn radius_of_memory(samples: usize) -> f64 {
    1.0 - 1.0 / samples.max(2) as f64
}

/// A pole that turns by at least this many radians within the memory of the radius is a resonance: its phase is visible, and its memory may
/// be ten times as long. A slower one cannot be distinguished from drift.
const RESONANCE: f64 = 6.0 * std::f64::consts::PI;

/// The largest magnitude that a pole may have.
fn limit(pole: Complex<f64>, radius: f64) -> f64 {
    let room = 1.0 - radius;
    match pole.argument().abs() > RESONANCE * room {
        true => 1.0 - 0.1 * room,
        false => radius,
    }
}

/// `a1 ... an` with every pole beyond `radius` (a resonance: beyond ten times its memory) moved inwards along its ray. The inner `None` if
/// there is no such pole, the outer if the roots cannot be found.
pub(crate) fn held_within(a: &[f64], radius: f64) -> Option<Option<Vec<f64>>> {
    if lies_within(a, radius) {
        return Some(None);
    }
    let mut roots = polynomial::roots(&monic(a)).ok()?;
    let mut held = false;
    for root in &mut roots {
        let limit = limit(*root, radius);
        if root.modulus() > limit {
            *root *= limit / root.modulus();
            held = true;
        }
    }
    if !held {
        return Some(None);
    }
    let mut drawn_in = polynomial::from_roots(&roots).ok()?;
    drawn_in.remove(0);
    Some(Some(drawn_in))
}

/// Moves poles inwards as [`held_within`] does; returns `a` unchanged if no pole is moved or the roots cannot be found.
pub(super) fn drawn_within(a: &[f64], radius: f64) -> Vec<f64> {
    held_within(a, radius)
        .flatten()
        .unwrap_or_else(|| a.to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pole_outside_is_drawn_in_and_the_others_stay() {
        // Poles 1.2 and 0.5.
        let drawn_in = held_within(&[-1.7, 0.6], 0.9).unwrap().unwrap();
        assert!((drawn_in[0] + 1.4).abs() < 1e-12 && (drawn_in[1] - 0.45).abs() < 1e-12);
        assert_eq!(held_within(&[-0.5], 0.9), Some(None));
        // A resonance may ring for longer than a real pole may remember.
        let resonance = [-2.0 * 0.9995 * libm::cos(0.3_f64), 0.9995 * 0.9995];
        assert_eq!(held_within(&resonance, 0.999), Some(None));
        assert!(held_within(&resonance, 0.99).unwrap().is_some());
    }
}
