//! A subspace method: poles from states, everything else by least squares.
//!
//! States by canonical variates of a high-order equation, and their transition from sample to sample, give the poles ([`crate::states`];
//! Jansson 2003, in the family of N4SID, Van Overschee and De Moor 1994). With these poles, numerator, offset and initial motion enter the
//! simulated output linearly. The method needs no iterative search, so it has no local minimum, but its error is not the smallest possible. The
//! covariance is computed for an output-error model at this point, which is close to the method's estimate but not its exact minimum.

use super::estimate::Estimate;
use super::estimator::{Estimator, Recursive};
use super::normal_equations::NormalEquations;
use super::recursive::{self, Kind};
use super::rows::regression;
use super::simulator::Simulator;
use super::stability::{drawn_within, radius_of_memory};
use crate::batch::Triangle;
use crate::error::{IdentificationError, Result};
use crate::states::{HIGH, poles_of_states};
use crate::structure::{InitialState, Problem, Structure, variance};
use nalgebra::DVector;
use planesman_record::Run;

/// Minimum number of rows for each of its parameters.
const ROWS_PER_PARAMETER: usize = 4;
/// Relative ridge that limits the smallest singular values of its regressors.
const RIDGE: f64 = 1e-8;

/// Subspace identification by canonical variates.
#[derive(Clone, Copy, Debug)]
pub struct N4sid;

impl Estimator for N4sid {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        let none = IdentificationError::Undetermined(
            "the record is too short, or its input has too little variation, for a state-space model of this order",
        );
        let a = poles(problem).ok_or(none.clone())?;
        let equations = NormalEquations::new(problem, &[1.0]);
        let whole = equations.whole();
        let samples: usize = whole.iter().map(|part| part.samples.len()).sum();
        let a = drawn_within(&a, radius_of_memory(samples));
        let theta = equations.completed(&a, &whole).ok_or(none)?;
        let simulator = Simulator::new(problem);
        let at = simulator.linearised(&theta);
        simulator.estimate(theta, &at)
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        recursive::learner(Kind::OutputError, problem)
    }
}

/// `a1 ... an` from the states; for a long record from the part where its input varies most.
fn poles(problem: &Problem<'_>) -> Option<Vec<f64>> {
    let order = problem.structure.poles;
    let part = problem.part().unwrap_or_else(|| problem.clone());
    // Scales have no part in the poles.
    let scaled = |records: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        let largest = records.iter().map(|it| variance(it)).fold(0.0, f64::max);
        let scale = largest.sqrt().max(f64::MIN_POSITIVE);
        let of = |values: &Vec<f64>| values.iter().map(|v| v / scale).collect();
        records.iter().map(of).collect()
    };
    let known = |values: &[f64], run: &Run<'_>| -> Vec<f64> {
        let unknown = part.structure.unknown(run.past.len());
        values.get(unknown..).unwrap_or_default().to_vec()
    };
    let driving = part.driving();
    let driving = driving.iter().zip(&part.runs);
    let driving = scaled(driving.map(|(driving, run)| known(driving, run)).collect());
    let outputs = scaled(
        part.runs
            .iter()
            .map(|run| known(run.outputs, run))
            .collect(),
    );
    let runs: Vec<(&[f64], &[f64])> = driving
        .iter()
        .zip(&outputs)
        .map(|(u, y)| (&u[..], &y[..]))
        .collect();
    let rows: usize = outputs.iter().map(Vec::len).sum();
    let (high, theta, _) = HIGH
        .into_iter()
        .filter(|order| rows > ROWS_PER_PARAMETER * (2 * order + 1))
        .filter_map(|order| {
            let (theta, criterion) = high_order(&runs, order, part.structure.offset)?;
            Some((order, theta, criterion))
        })
        .min_by(|p, q| p.2.total_cmp(&q.2))?;
    let (a, rest) = theta.as_slice().split_at(high);
    // More samples of past and future than states; beyond its order the equation's coefficients are 0.
    let mut a = a.to_vec();
    a.resize(high.max(order + 1), 0.0);
    let found = poles_of_states((&a, &rest[..=high]), &runs, order);
    found.into_iter().nth(order.checked_sub(1)?)
}

/// `a1 ... aL, b0 ... bL` and constants of a high-order equation, and Akaike's criterion per row, because a higher order has fewer rows.
fn high_order(
    runs: &[(&[f64], &[f64])],
    order: usize,
    offset: bool,
) -> Option<(DVector<f64>, f64)> {
    let problem = Problem {
        structure: Structure {
            numerator: order + 1,
            delay: 0,
            offset,
            start: InitialState::Estimated,
            ..Structure::of_order(order)
        },
        sample_time: 1.0,
        runs: runs
            .iter()
            .map(|(inputs, outputs)| Run {
                inputs,
                outputs,
                ..Run::default()
            })
            .collect(),
    };
    let (phi, outputs) = regression(&problem);
    // Without noise the rows do not determine more than the system has.
    let triangle = Triangle::new(&phi, &outputs).ok()?;
    let damping = RIDGE * triangle.singular_values().max();
    let triangle = triangle.damped(damping);
    let theta = triangle.solution().ok()?;
    let rows = phi.nrows() as f64;
    let variance = (triangle.cost / rows).max(f64::MIN_POSITIVE);
    let criterion = libm::log(variance) + 2.0 * theta.len() as f64 / rows;
    Some((theta, criterion))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::Reading;
    use planesman_linear::ComplexFunctions as _;
    use planesman_record::filter;
    use planesman_record::noise;

    const COUNT: usize = 600;

    /// `(q^-1 + 0.5 q^-2) / (1 - 1.5 q^-1 + 0.7 q^-2) u + size v + 2`, v slow.
    fn record(seed: u32, size: f64) -> (Vec<f64>, Vec<f64>) {
        let u = noise(seed, COUNT);
        let clean = filter(&[0.0, 1.0, 0.5], &[1.0, -1.5, 0.7], &u);
        let v = filter(&[1.0], &[1.0, -0.8], &noise(seed + 5, COUNT));
        let y = clean.iter().zip(&v).map(|(x, v)| x + size * v + 2.0);
        (u, y.collect())
    }

    fn found(seed: u32, size: f64) -> Estimate {
        found_of_order(2, seed, size)
    }

    fn found_of_order(order: usize, seed: u32, size: f64) -> Estimate {
        let (inputs, outputs) = record(seed, size);
        let structure = Structure {
            start: InitialState::Estimated,
            ..Structure::of_order(order)
        };
        let (inputs, outputs) = (&inputs[..], &outputs[..]);
        let problem = Problem::new(
            structure,
            0.1,
            vec![Run {
                inputs,
                outputs,
                // It stood before the record begins.
                past: &inputs[..1],
            }],
        );
        N4sid.fit(&problem.unwrap()).unwrap()
    }

    #[test]
    fn more_states_than_the_equation_of_high_order_has_coefficients_are_found() {
        for order in [10, 20] {
            let found = found_of_order(order, 7, 0.05);
            let gain = Reading::new(&found, 0).steady_state_gain().unwrap();
            // (1 + 0.5) / (1 - 1.5 + 0.7)
            assert!(
                (gain.value.re / 7.5 - 1.0).abs() < 0.02,
                "{order}: {gain:?}"
            );
        }
    }

    /// The same regressions in numpy, by QR and SVD of the data in place of products: `a1, a2, b1, b2, offset`. SIPPY 1.0.1
    /// (oblique projections, horizon 20) finds -1.49504, 0.69390, 0.97898, 0.53200.
    #[test]
    fn the_model_is_that_of_the_same_regressions_in_numpy() {
        for (size, expected) in [
            (0.0, [-1.5, 0.7, 1.0, 0.5, 2.0]),
            (
                0.3,
                [
                    -1.490_438_45,
                    0.690_950_94,
                    0.981_851_8,
                    0.547_184_79,
                    1.925_773_98,
                ],
            ),
        ] {
            let found = found(4, size);
            for (it, expected) in found.theta.iter().zip(expected) {
                assert!((it - expected).abs() < 1e-7, "{}", found.theta);
            }
        }
    }

    /// The intervals are those of output error, which the method approaches.
    #[test]
    fn the_poles_spread_as_their_standard_deviations_say() {
        let seeds = 40;
        let squares = (0..seeds).map(|seed| {
            let found = found(100 + 37 * seed, 0.3);
            let pole = Reading::new(&found, 0).poles().unwrap()[0];
            let off = (pole.value.modulus() - 0.7_f64.sqrt()) / pole.magnitude_deviation();
            off * off
        });
        let ratio = (squares.sum::<f64>() / f64::from(seeds)).sqrt();
        assert!((0.7..1.4).contains(&ratio), "{ratio}");
    }

    #[test]
    fn the_poles_hold_in_a_closed_loop() {
        // A y = B u + e, u = r - 0.3 y, the disturbance as strong as the reference.
        let seeds = 20;
        let found: Vec<[f64; 2]> = (0..seeds)
            .map(|seed| {
                let (r, e) = (noise(3 + 31 * seed, 2000), noise(1000 + 17 * seed, 2000));
                let (mut u, mut y) = (vec![0.0; 2000], vec![0.0; 2000]);
                for k in 2..2000 {
                    y[k] = 1.5 * y[k - 1] - 0.7 * y[k - 2] + u[k - 1] + 0.5 * u[k - 2] + e[k];
                    u[k] = r[k] - 0.3 * y[k];
                }
                let structure = Structure {
                    start: InitialState::Estimated,
                    ..Structure::of_order(2)
                };
                let run = Run {
                    inputs: &u,
                    outputs: &y,
                    ..Run::default()
                };
                let found = N4sid.fit(&Problem::new(structure, 0.1, vec![run]).unwrap());
                let theta = found.unwrap().theta;
                [theta[0], theta[1]]
            })
            .collect();
        for (i, truth) in [-1.5, 0.7].into_iter().enumerate() {
            let mean = found.iter().map(|a| a[i]).sum::<f64>() / f64::from(seeds);
            let squares = found.iter().map(|a| (a[i] - mean).powi(2)).sum::<f64>();
            let deviation = (squares / f64::from(seeds - 1)).sqrt();
            let of_mean = deviation / f64::from(seeds).sqrt();
            assert!((mean - truth).abs() < 3.0 * of_mean, "{mean} {deviation}");
        }
    }

    #[test]
    fn runs_share_the_poles_and_a_short_record_is_refused() {
        let (inputs, outputs) = record(4, 0.0);
        let half = |range: std::ops::Range<usize>| Run {
            inputs: &inputs[range.clone()],
            outputs: &outputs[range],
            ..Run::default()
        };
        let fit = |runs| {
            let structure = Structure {
                start: InitialState::Estimated,
                ..Structure::of_order(2)
            };
            N4sid.fit(&Problem::new(structure, 0.1, runs).unwrap())
        };
        let found = fit(vec![half(0..300), half(300..600)]).unwrap();
        // The first sample of each run does not know the input before it.
        assert!((found.theta[0] + 1.5).abs() < 1e-3, "{}", found.theta);
        assert!(fit(vec![half(0..20)]).is_err());
    }
}
