//! Identification in a closed loop by two stages (Van den Hof and Schrama, *Automatica* 29, 1993).
//!
//! Feedback brings the output's noise into the input, and methods that take the two for unrelated are
//! led astray. The reference has no such noise. First the part of the input that the reference causes is
//! found, `u_r = S r`, by a long difference equation; then the plant from `u_r` to the output.
//! The other way is direct: a method with a noise model, on input and output as they are.

use crate::estimators::{Estimate, Method};
use crate::structure::{Problem, Run, Start, Structure};

/// The order of the first stage: long enough for a loop of a vehicle and its controller.
const FIRST_ORDER: usize = 8;

/// The plant between a record's input and output, from the reference that was fed to the loop: the model,
/// and the input that it is from.
///
/// # Errors
/// A sentence: a reference of another length, records that do not determine the loop or the plant.
pub fn fit(
    method: Method,
    structure: &Structure,
    sample_time: f64,
    reference: &[f64],
    run: Run<'_>,
) -> Result<(Estimate, Vec<f64>), String> {
    // The input answers the reference at once: S begins with the sample it is given at. Shifted by
    // one, that is a model with a delay of one.
    let mut ahead = reference.get(1..).unwrap_or_default().to_vec();
    ahead.push(reference.last().copied().unwrap_or(0.0));
    let loop_record = Run {
        inputs: &ahead,
        outputs: run.inputs,
    };
    let of_loop = Structure {
        start: Start::Rest,
        poles: 0,
        numerator: FIRST_ORDER * 4,
        ..Structure::of_order(1)
    };
    let first = Method::LeastSquares
        .fit(&Problem::new(of_loop, sample_time, vec![loop_record])?)
        .map_err(|reason| format!("from the reference to the input: {reason}"))?;
    let caused = first.simulate(0, &ahead);
    let second = Run {
        inputs: &caused,
        outputs: run.outputs,
    };
    let found = method.fit(&Problem::new(structure.clone(), sample_time, vec![second])?)?;
    Ok((found, caused))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::synthetic::noise;

    /// y = 0.2 q^-1 / (1 - 0.9 q^-1) u + v, u = r - 2 y, v strong and slow.
    fn closed_loop(seed: u32) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let (r, e) = (noise(seed, 4000), noise(seed + 77, 4000));
        let (mut u, mut y) = (Vec::<f64>::new(), Vec::<f64>::new());
        let (mut x, mut v) = (0.0, 0.0);
        for k in 0..r.len() {
            x = 0.9 * x + u.last().map_or(0.0, |u| 0.2 * u);
            v = 0.8 * v + e[k];
            y.push(x + v);
            u.push(r[k] - 2.0 * y[k]);
        }
        (r, u, y)
    }

    #[test]
    fn noise_that_went_round_the_loop_misleads_the_direct_way_and_not_the_two_stages() {
        let (r, u, y) = closed_loop(5);
        let run = Run {
            inputs: &u,
            outputs: &y,
        };
        let structure = Structure::of_order(1);
        let off = |found: &Estimate| (found.theta[0] + 0.9).abs() + (found.theta[1] - 0.2).abs();
        let problem = Problem::new(structure.clone(), 0.1, vec![run]).unwrap();
        let direct = off(&Method::OutputError.fit(&problem).unwrap());
        let (found, _) = fit(Method::OutputError, &structure, 0.1, &r, run).unwrap();
        let staged = off(&found);
        assert!(
            staged < 0.25 && direct > 3.0 * staged,
            "direct {direct}, staged {staged}"
        );
    }

    #[test]
    fn a_reference_of_another_length_is_refused() {
        let (r, u, y) = closed_loop(5);
        let run = Run {
            inputs: &u,
            outputs: &y,
        };
        assert!(
            fit(
                Method::OutputError,
                &Structure::of_order(1),
                0.1,
                &r[..99],
                run
            )
            .is_err()
        );
    }
}
