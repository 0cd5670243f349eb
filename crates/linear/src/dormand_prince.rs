//! The Runge-Kutta method of Dormand and Prince (J. Comp. Appl. Math. 6 (1980), p. 23, RK5(4)7M): of order five, with
//! the difference to a result of order four as an estimate of the error.

/// Where within a step, as shares of it, the method asks for the inputs.
pub const DORMAND_PRINCE_NODES: [f64; 6] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0];

/// The stages' coefficients; the last row is the result.
const STAGES: [[f64; 6]; 7] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// The result less that of order four.
const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// One step of length `h` of `y' = f(s, y)`, and the estimate of its error. `s` holds the inputs of `f` besides `y` at
/// the [`DORMAND_PRINCE_NODES`].
#[inline(always)]
pub fn dormand_prince_step<S, const N: usize>(
    y: &[f64; N],
    h: f64,
    inputs: &[S; 6],
    f: impl Fn(&S, &[f64; N]) -> [f64; N],
) -> ([f64; N], [f64; N]) {
    let mut slopes = [[0.0; N]; 7];
    let mut after = *y;
    // A loop with one call of `f`, so that the compiler inlines it.
    for (stage, row) in STAGES.iter().enumerate() {
        after = *y;
        for (slope, weight) in slopes.iter().zip(row).take(stage) {
            for i in 0..N {
                after[i] += h * weight * slope[i];
            }
        }
        slopes[stage] = f(&inputs[stage.min(5)], &after);
    }
    let mut error = [0.0; N];
    for (slope, weight) in slopes.iter().zip(ERROR) {
        for i in 0..N {
            error[i] += h * weight * slope[i];
        }
    }
    (after, error)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `exp(-1)` in so many steps, and the sum of the errors estimated.
    fn decayed(steps: u32) -> (f64, f64) {
        let h = 1.0 / f64::from(steps);
        let (mut y, mut errors) = ([1.0], 0.0);
        for _ in 0..steps {
            let (after, [error]) = dormand_prince_step(&y, h, &[(); 6], |(), y| [-y[0]]);
            y = after;
            errors += error;
        }
        (y[0], errors)
    }

    #[test]
    fn halving_the_step_divides_the_error_by_thirty_two_and_its_estimate_by_sixteen() {
        let exact = f64::exp(-1.0);
        let ((coarse, coarse_estimate), (fine, fine_estimate)) = (decayed(40), decayed(80));
        let ratio = (coarse - exact) / (fine - exact);
        assert!((ratio - 32.0).abs() < 2.0, "{ratio}");
        let ratio = coarse_estimate / fine_estimate;
        assert!((ratio - 16.0).abs() < 1.0, "{ratio}");
    }

    #[test]
    fn a_polynomial_of_fourth_degree_in_time_is_integrated_exactly() {
        let times = DORMAND_PRINCE_NODES.map(|share| 2.0 * share);
        let ([y], _) = dormand_prince_step(&[0.0], 2.0, &times, |t: &f64, _| [5.0 * t.powi(4)]);
        assert!((y - 32.0).abs() < 1e-13);
    }
}
