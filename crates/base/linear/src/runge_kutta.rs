//! The classical fourth-order Runge-Kutta method with a fixed step.
//!
//! ```text
//! k1 = f(t, y)   k2 = f(t + h/2, y + h/2 k1)   k3 = f(t + h/2, y + h/2 k2)   k4 = f(t + h, y + h k3)
//! y(t + h) = y + h/6 (k1 + 2 k2 + 2 k3 + k4)
//! ```
//!
//! The error per unit time is of order `h^4` if `f` is smooth. For a decaying mode `exp(s t)` the method is stable up to `|s| h = 2.78` on the
//! real axis and 2.83 on the imaginary axis.

use std::ops::{Add, Mul};

/// One step of length `h` of `y' = f(s, y)`, for numbers or for vectors of numbers. `s`: further inputs of `f` at the beginning, middle and end of
/// the step; `[&(); 3]` if there are none.
#[inline(always)]
pub fn runge_kutta_step<S, T, const N: usize>(
    y: &[T; N],
    h: f64,
    [start, middle, end]: [&S; 3],
    f: impl Fn(&S, &[T; N]) -> [T; N],
) -> [T; N]
where
    T: Copy + Add<Output = T> + Mul<f64, Output = T>,
{
    // Each stage: its inputs, the distance to the next stage, its weight. A loop with one call of `f`, so
    // that the compiler inlines it.
    let stages = [
        (start, h / 2.0, h / 6.0),
        (middle, h / 2.0, h / 3.0),
        (middle, h, h / 3.0),
        (end, 0.0, h / 6.0),
    ];
    let mut at = *y;
    let mut after = *y;
    for (s, ahead, weight) in stages {
        let k = f(s, &at);
        for i in 0..N {
            at[i] = y[i] + k[i] * ahead;
            after[i] = after[i] + k[i] * weight;
        }
    }
    after
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decayed(steps: u32) -> f64 {
        let h = 1.0 / f64::from(steps);
        let mut y = [1.0];
        for _ in 0..steps {
            y = runge_kutta_step(&y, h, [&(); 3], |(), y| [-y[0]]);
        }
        y[0]
    }

    #[test]
    fn halving_the_step_divides_the_error_by_sixteen() {
        let exact = libm::exp(-1.0);
        let ratio = (decayed(10) - exact) / (decayed(20) - exact);
        assert!((ratio - 16.0).abs() < 1.0, "{ratio}");
    }

    #[test]
    fn a_cubic_in_time_is_integrated_exactly() {
        let y = runge_kutta_step(&[0.0], 2.0, [&0.0, &1.0, &2.0], |t: &f64, _| [t * t * t]);
        assert!((y[0] - 4.0).abs() < 1e-14);
    }
}
