//! The classical fourth-order Runge-Kutta method with a fixed step.
//!
//! ```text
//! k1 = f(t, y)   k2 = f(t + h/2, y + h/2 k1)   k3 = f(t + h/2, y + h/2 k2)   k4 = f(t + h, y + h k3)
//! y(t + h) = y + h/6 (k1 + 2 k2 + 2 k3 + k4)
//! ```
//!
//! Error per unit time of order `h^4` where `f` is smooth. For a decaying mode `exp(s t)` it is
//! stable up to `|s| h = 2.78` on the real axis and 2.83 on the imaginary one.

/// The largest `|s| h` at which a mode is well clear of instability, and still resolved.
pub const LARGEST_POLE_STEP: f64 = 1.0;

/// One step of `y' = f(t, y)` from `t` to `t + h`.
pub fn step<const N: usize>(
    y: &[f64; N],
    t: f64,
    h: f64,
    f: impl Fn(f64, &[f64; N]) -> [f64; N],
) -> [f64; N] {
    let along = |k: &[f64; N], h: f64| -> [f64; N] { std::array::from_fn(|i| y[i] + h * k[i]) };
    let k1 = f(t, y);
    let k2 = f(t + h / 2.0, &along(&k1, h / 2.0));
    let k3 = f(t + h / 2.0, &along(&k2, h / 2.0));
    let k4 = f(t + h, &along(&k3, h));
    std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decayed(steps: u32) -> f64 {
        let h = 1.0 / f64::from(steps);
        let mut y = [1.0];
        for k in 0..steps {
            y = step(&y, f64::from(k) * h, h, |_, y| [-y[0]]);
        }
        y[0]
    }

    #[test]
    fn halving_the_step_divides_the_error_by_sixteen() {
        let exact = f64::exp(-1.0);
        let ratio = (decayed(10) - exact) / (decayed(20) - exact);
        assert!((ratio - 16.0).abs() < 1.0, "{ratio}");
    }

    #[test]
    fn a_cubic_in_time_is_integrated_exactly() {
        let y = step(&[0.0], 0.0, 2.0, |t, _| [t * t * t]);
        assert!((y[0] - 4.0).abs() < 1e-14);
    }
}
