//! The response of a closed loop to a unit step, and its metrics.

use planesman_linear::{Error, StateSpace, StepMetrics, TransferFunction};

/// Rise, overshoot and settling of `closed_loop` (in `s`) after a unit step, over `duration` seconds in
/// steps of `dt`.
///
/// A zero-order hold represents a constant input exactly, so the samples are exact for any `dt`:
///
/// ```text
/// x_(k+1) = Ad x_k + Bd,   y_k = C x_k + D
/// ```
///
/// # Errors
/// Errors of [`TransferFunction::companion`] and [`planesman_linear::StateSpace::zero_order_hold`], and [`Error::NotFinite`] if an unstable
/// response overflows.
pub fn response(
    closed_loop: &TransferFunction,
    dt: f64,
    duration: f64,
) -> Result<StepMetrics, Error> {
    let (times, values): (Vec<f64>, Vec<f64>) =
        samples(closed_loop, dt, duration)?.into_iter().unzip();
    StepMetrics::of(&times, &values, 0.0, 1.0)
}

/// The response itself: time in s and value, from the step on.
///
/// # Errors
/// Errors of [`TransferFunction::companion`] and [`planesman_linear::StateSpace::zero_order_hold`].
pub fn samples(
    closed_loop: &TransferFunction,
    dt: f64,
    duration: f64,
) -> Result<Vec<(f64, f64)>, Error> {
    Ok(held(
        &closed_loop.companion()?.zero_order_hold(dt)?,
        dt,
        duration,
    ))
}

/// The response of a discrete system with samples `dt` seconds apart to a unit step: time in s and value.
#[must_use]
pub fn held(system: &StateSpace, dt: f64, duration: f64) -> Vec<(f64, f64)> {
    let steps = (duration / dt).round() as usize;
    let mut state = system.b.clone() * 0.0;
    let mut samples = Vec::with_capacity(steps + 1);
    for k in 0..=steps {
        samples.push((k as f64 * dt, (&system.c * &state + &system.d)[(0, 0)]));
        state = &system.a * state + &system.b;
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_order_loop_overshoots_as_in_closed_form() {
        let (wn, zeta) = (2.0_f64, 0.5_f64);
        let g = TransferFunction::new(vec![wn * wn], vec![1.0, 2.0 * zeta * wn, wn * wn]);
        let metrics = response(&g.expect("proper"), 1e-3, 20.0).expect("a response");
        let overshoot =
            100.0 * libm::exp(-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt());
        assert!((metrics.overshoot - overshoot).abs() < 1e-3);
    }
}
