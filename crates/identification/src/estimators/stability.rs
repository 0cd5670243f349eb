//! Poles held within a circle.

use planesman_linear::{Complex, polynomial};

use crate::structure::monic;

/// The largest magnitude of a pole whose memory is no longer than so many samples.
pub(crate) fn radius_of_memory(samples: usize) -> f64 {
    1.0 - 1.0 / samples.max(2) as f64
}

/// Radians that a pole turns within the memory of the radius from which it is a resonance: its phase shows, and its
/// memory may be ten times as long. A slower one cannot be told from drift.
const RESONANCE: f64 = 6.0 * std::f64::consts::PI;

/// The largest magnitude that a pole may have.
fn limit(pole: Complex<f64>, radius: f64) -> f64 {
    let room = 1.0 - radius;
    match pole.arg().abs() > RESONANCE * room {
        true => 1.0 - 0.1 * room,
        false => radius,
    }
}

/// `a1 ... an` with every pole beyond `radius`, a resonance beyond ten times its memory, drawn in along its ray; the inner `None` when there is none
/// such, the outer when the roots cannot be found.
pub(crate) fn held_within(a: &[f64], radius: f64) -> Option<Option<Vec<f64>>> {
    if lies_within(a, radius) {
        return Some(None);
    }
    let mut roots = polynomial::roots(&monic(a)).ok()?;
    let mut held = false;
    for root in &mut roots {
        let limit = limit(*root, radius);
        if root.norm() > limit {
            *root *= limit / root.norm();
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

/// The same, or `a` as it is where nothing is drawn in or the roots cannot be found.
pub(super) fn drawn_within(a: &[f64], radius: f64) -> Vec<f64> {
    held_within(a, radius)
        .flatten()
        .unwrap_or_else(|| a.to_vec())
}

/// Whether all roots of `z^n + a1 z^(n-1) + ... + an` have a magnitude below `radius` (the recursion of Schur and
/// Cohn).
pub(crate) fn lies_within(a: &[f64], radius: f64) -> bool {
    let mut scale = 1.0;
    let mut p: Vec<f64> = std::iter::once(1.0)
        .chain(a.iter().map(|a| {
            scale /= radius;
            a * scale
        }))
        .collect();
    while let (Some(last), true) = (p.last().copied(), p.len() > 1) {
        if last.is_nan() || last.abs() >= 1.0 {
            return false;
        }
        let n = p.len() - 1;
        p = (0..n)
            .map(|i| (p[i] - last * p[n - i]) / (1.0 - last * last))
            .collect();
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_recursion_agrees_with_the_roots() {
        for (a, radius, within) in [
            (vec![-0.9], 0.95, true),
            (vec![-0.9], 0.85, false),
            (vec![-1.6, 0.8], 0.9, true),
            (vec![-1.6, 0.8], 0.89, false),
            (vec![0.0, 0.0, -0.5], 0.8, true),
            (vec![0.0, 0.0, -0.5], 0.79, false),
        ] {
            assert_eq!(lies_within(&a, radius), within, "{a:?} {radius}");
        }
    }

    #[test]
    fn a_pole_outside_is_drawn_in_and_the_others_stay() {
        // Poles 1.2 and 0.5.
        let drawn_in = held_within(&[-1.7, 0.6], 0.9).unwrap().unwrap();
        assert!((drawn_in[0] + 1.4).abs() < 1e-12 && (drawn_in[1] - 0.45).abs() < 1e-12);
        assert_eq!(held_within(&[-0.5], 0.9), Some(None));
        // A resonance may ring for longer than a real pole may remember.
        let resonance = [-2.0 * 0.9995 * 0.3_f64.cos(), 0.9995 * 0.9995];
        assert_eq!(held_within(&resonance, 0.999), Some(None));
        assert!(held_within(&resonance, 0.99).unwrap().is_some());
    }
}
