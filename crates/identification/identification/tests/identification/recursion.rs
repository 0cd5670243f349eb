//! Limits of the recursions: batch least squares, the plant under noise, and what the laws
//! of forgetting keep and discard.

#[allow(dead_code)]
use crate::common::{self, SAMPLE_TIME, clean, measured, pulses};
use nalgebra::{DMatrix, DVector};
use planesman_identification::estimators::recursive::{Forgetting, Kind, Options, Recursion};
use planesman_identification::estimators::{Estimator, LeastSquares, Recursive, learn};
use planesman_identification::{
    Input, Problem, RecursiveLeastSquares, Run, Structure, Triangle, filter, noise,
};

/// Poles 0.95 and 0.8, a zero at z = 1.
const A: [f64; 3] = [1.0, -1.75, 0.76];
const B: [f64; 3] = [0.0, 0.1, -0.1];

fn recursion(kind: Kind, structure: Structure, options: Options) -> Recursion {
    Recursion::new(kind, structure, SAMPLE_TIME, options).unwrap()
}

#[test]
fn recursive_least_squares_is_batch_least_squares_whatever_the_structure() {
    let (inputs, outputs) = (pulses(), measured(4, 0.005, 0.025));
    let record = Run {
        inputs: &inputs,
        outputs: &outputs,
        ..Run::default()
    };
    let delayed = Structure {
        delay: 3,
        numerator: 2,
        ..Structure::of_order(3)
    };
    for structure in [
        Structure::of_order(2),
        Structure::of_order(3).with_zero_at_one(),
        delayed,
    ] {
        let options = Options {
            initial_covariance: 1e16,
            ..Options::default()
        };
        let mut recursive = recursion(Kind::LeastSquares, structure.clone(), options);
        learn(&mut recursive, record);
        let problem = Problem::new(structure, SAMPLE_TIME, vec![record]).unwrap();
        let batch = LeastSquares.fit(&problem).unwrap();
        let found = recursive.estimate().unwrap();
        assert!((found.theta - &batch.theta).amax() < 1e-8);
        assert!((found.covariance - &batch.covariance).amax() < 1e-8 * batch.covariance.amax());
    }
}

/// The error of the poles' coefficients after 20 000 samples with this noise on the equation.
fn off_after_noise(kind: Kind, c: &[f64]) -> f64 {
    let inputs: Vec<f64> = noise(1, 20_000);
    let clean = filter(&B, &A, &inputs);
    let coloured = filter(c, &A, &noise(2, 20_000));
    let outputs: Vec<f64> = clean
        .iter()
        .zip(coloured)
        .map(|(y, v)| y + 0.1 * v)
        .collect();
    let structure = Structure::of_order(2).without_offset();
    let mut learner = recursion(kind, structure, Options::default());
    learn(
        &mut learner,
        Run {
            inputs: &inputs,
            outputs: &outputs,
            ..Run::default()
        },
    );
    let theta = learner.parameters();
    (theta[0] - A[1]).abs().max((theta[1] - A[2]).abs())
}

#[test]
fn noise_on_the_sensor_leads_least_squares_astray_and_output_error_not() {
    assert!(off_after_noise(Kind::LeastSquares, &A) > 0.3);
    let off = off_after_noise(Kind::OutputError, &A);
    assert!(off < 0.03, "{off}");
}

#[test]
fn the_prediction_error_method_follows_noise_that_least_squares_does_not() {
    for c in [[1.0, 0.5, 0.0], [1.0, -0.9, 0.2]] {
        let off = off_after_noise(Kind::PredictionError, &c);
        assert!(off < 0.01, "{c:?}: {off}");
        assert!(off_after_noise(Kind::LeastSquares, &c) > 3.0 * off, "{c:?}");
    }
}

#[test]
fn extended_least_squares_follows_a_moving_average_but_not_the_vehicles_own_poles() {
    // It converges where 1/C - 1/2 is positive real (Ljung 1977), which C = A is far from.
    let average = [1.0, 0.5, 0.0];
    let off = off_after_noise(Kind::ExtendedLeastSquares, &average);
    assert!(off < 0.01, "{off}");
    assert!(off_after_noise(Kind::LeastSquares, &average) > 2.0 * off);
    assert!(off_after_noise(Kind::ExtendedLeastSquares, &A) > 0.3);
}

/// The textbook recursion, g = P phi / (1 + phi'P phi), P -= g phi'P.
struct Textbook {
    theta: DVector<f64>,
    p: DMatrix<f64>,
}

impl Textbook {
    fn update(&mut self, row: &[f64], output: f64) {
        let phi = DVector::from_row_slice(row);
        let p_phi = &self.p * &phi;
        let gain = &p_phi / (1.0 + phi.dot(&p_phi));
        self.theta += &gain * (output - phi.dot(&self.theta));
        self.p -= &gain * p_phi.transpose();
    }
}

#[test]
fn after_a_million_nearly_dependent_rows_the_triangle_is_batch_and_the_textbook_is_lost() {
    const ROWS: usize = 1_000_000;
    const APART: f64 = 1e-6;
    let truth = [1.0, -2.0, 0.5];
    let p0 = 1e20;
    let mut rls = RecursiveLeastSquares::new(3, 1.0, p0).unwrap();
    let mut textbook = Textbook {
        theta: DVector::zeros(3),
        p: DMatrix::from_diagonal_element(3, 3, p0),
    };
    let mut phi = DMatrix::zeros(ROWS, 3);
    let mut outputs = DVector::zeros(ROWS);
    for k in 0..ROWS {
        let t = k as f64;
        let x = libm::sin(0.37 * t);
        // The second column is the first but for a millionth.
        let row = [x, x + APART * libm::cos(0.11 * t), libm::cos(0.05 * t)];
        let output =
            row.iter().zip(truth).map(|(f, c)| f * c).sum::<f64>() + 1e-9 * libm::sin(1.7 * t * t);
        rls.update(&row, output);
        textbook.update(&row, output);
        phi.row_mut(k).copy_from_slice(&row);
        outputs[k] = output;
    }
    let triangle = Triangle::new(&phi, &outputs).unwrap();
    let singular = triangle.singular_values();
    let condition = singular.max() / singular.min();
    let batch = triangle.solution().unwrap();
    let off = |theta: &DVector<f64>| {
        theta
            .iter()
            .zip(batch.iter())
            .map(|(f, e)| ((f - e) / e).abs())
            .fold(0.0, f64::max)
    };
    let (ours, theirs) = (off(&rls.parameters()), off(&textbook.theta));
    println!("square root {ours:.1e}, textbook {theirs:.1e} from batch");
    // The covariance has the condition of the rows squared, and rounding grows with it.
    let squared = f64::EPSILON * condition * condition;
    assert!(ours < 1e-9, "{ours:e}");
    assert!(
        theirs.is_nan() || theirs > squared,
        "{theirs:e} {squared:e}"
    );
}

/// The trace of P after ten thousand rows that say nothing, and the slope found after it has changed.
fn standing_still(forgetting: Forgetting) -> (f64, f64) {
    let structure = Structure {
        poles: 0,
        numerator: 2,
        ..Structure::of_order(1)
    }
    .without_offset();
    let options = Options {
        forgetting,
        initial_covariance: 1e4,
        ..Options::default()
    };
    let mut learner = recursion(Kind::LeastSquares, structure, options);
    let e = noise(3, 20_000);
    learner.begin(0.0);
    let mut u = [0.0, 0.0];
    let mut feed = |learner: &mut Recursion, input: f64, gain: f64, k: usize| {
        u = [input, u[0]];
        learner.push(input, gain * u[0] + 0.5 * u[1] + 0.01 * e[k]);
    };
    for k in 0..500 {
        feed(
            &mut learner,
            libm::sin(0.7 * k as f64) + libm::cos(0.31 * k as f64),
            1.0,
            k,
        );
    }
    for k in 500..10_500 {
        feed(&mut learner, 1.0, 1.0, k);
    }
    let trace = learner.covariance().unwrap().trace() / learner.estimate().unwrap().noise_variance;
    for k in 10_500..11_000 {
        feed(
            &mut learner,
            libm::sin(0.7 * k as f64) + libm::cos(0.31 * k as f64),
            2.0,
            k,
        );
    }
    (trace, learner.parameters()[0])
}

#[test]
fn forgetting_in_the_rows_direction_keeps_what_standing_still_says_nothing_about() {
    let (everywhere, gain) = standing_still(Forgetting::Constant(0.98));
    assert!(everywhere > 1e3, "{everywhere}");
    assert!((gain - 2.0).abs() < 0.05, "{gain}");
    let (along, gain) = standing_still(Forgetting::Directional(0.98));
    assert!(along < 10.0, "{along}");
    // It comes after the change, slower than where everything is forgotten.
    assert!(gain > 1.5 && gain < 2.0, "{gain}");
}

#[test]
fn forgetting_in_the_rows_direction_is_the_matrix_recursion() {
    // Cao and Schwartz 2000: N <- N - (1 - lambda) N phi phi' N / phi'N phi + phi phi', theta += N^-1 phi e.
    const LAMBDA: f64 = 0.95;
    let (u, y) = (noise(5, 400), noise(6, 400));
    let mut information = DMatrix::<f64>::identity(2, 2);
    let mut theta = DVector::<f64>::zeros(2);
    let mut rls = RecursiveLeastSquares::new(2, 1.0, 1.0).unwrap();
    for k in 1..400 {
        let phi = DVector::from_vec(vec![u[k], 0.9 * u[k] + 0.1 * u[k - 1]]);
        rls.forget_along(phi.as_slice(), LAMBDA);
        rls.update(phi.as_slice(), y[k]);
        let seen = &information * &phi;
        information -= &seen * seen.transpose() * ((1.0 - LAMBDA) / phi.dot(&seen));
        information += &phi * phi.transpose();
        let gain = information.clone().lu().solve(&phi).unwrap();
        theta += gain * (y[k] - phi.dot(&theta));
    }
    assert!((rls.parameters() - theta).amax() < 1e-9);
    let p = information.try_inverse().unwrap();
    assert!((rls.unit_covariance() - &p).amax() < 1e-9 * p.amax());
}

#[test]
fn variable_forgetting_forgets_when_it_is_surprised() {
    let forgetting = Forgetting::Variable {
        least: 0.9,
        information: 500.0 * 0.01_f64.powi(2),
    };
    let (_, gain) = standing_still(forgetting);
    assert!((gain - 2.0).abs() < 0.05, "{gain}");
    let (_, stubborn) = standing_still(Forgetting::Constant(1.0));
    assert!((stubborn - 2.0).abs() > 0.2, "{stubborn}");
}

/// A second-order plant whose gain is `after` times as large from sample 500 on, its input a telegraph signal and its equation error `noise` times
/// normal noise: by which sample each jump is detected, and the steady-state gain 40 samples after the change.
fn jumps(seed: u32, after: f64, noisy: impl Fn(usize) -> f64) -> (Vec<usize>, f64) {
    const N: usize = 1000;
    let (signs, e) = (noise(seed, N), noise(1000 + seed, N));
    let mut learner = recursion(
        Kind::LeastSquares,
        Structure::of_order(2).without_offset(),
        Options {
            forgetting: Forgetting::OnJump(1.0),
            initial_covariance: 1e18,
            ..Options::default()
        },
    );
    let (mut y, mut u) = ([0.0, 0.0], [0.0, 0.0]);
    let (mut found, mut gain) = (Vec::new(), 0.0);
    learner.begin(0.0);
    for k in 1..N {
        u = [if signs[k / 3] < 0.0 { -1.0 } else { 1.0 }, u[0]];
        let scale = if k >= 500 { after } else { 1.0 };
        let next = 1.5 * y[0] - 0.7 * y[1] + scale * (0.1 * u[0] + 0.05 * u[1]) + noisy(k) * e[k];
        y = [next, y[0]];
        learner.push(u[0], next);
        if learner.jump().is_some() {
            found.push(k);
        }
        if k == 540 {
            let theta = learner.parameters();
            gain = (theta[2] + theta[3]) / (1.0 + theta[0] + theta[1]);
        }
    }
    (found, gain)
}

#[test]
fn a_jump_is_found_within_forty_samples_and_the_estimate_is_that_of_the_plant_since() {
    let truth = 1.5 * 0.15 / 0.2;
    let mut near = 0;
    for seed in 1..=10 {
        let (found, gain) = jumps(seed, 1.5, |_| 0.0);
        assert!(matches!(found[..], [500..=520]), "{seed}: {found:?}");
        assert!((gain / truth - 1.0).abs() < 1e-6, "{seed}: {gain}");
        let (found, gain) = jumps(seed, 1.5, |_| 0.003);
        assert!((500..=540).contains(&found[0]), "{seed}: {found:?}");
        // Where errors had begun to grow by chance before the jump, a few rows of before are taken along.
        assert!((gain / truth - 1.0).abs() < 0.08, "{seed}: {gain}");
        near += u32::from((gain / truth - 1.0).abs() < 0.04);
    }
    assert!(near >= 9, "{near}");
}

#[test]
fn a_constant_plant_never_jumps_whatever_its_noise_and_the_estimate_is_that_without_forgetting() {
    for seed in 1..=20 {
        assert_eq!(jumps(seed, 1.0, |_| 0.0).0, []);
        assert_eq!(jumps(seed, 1.0, |_| 0.05).0, []);
        // Three times the noise is another noise, not another plant.
        let grown = |k| if k < 500 { 0.02 } else { 0.06 };
        assert_eq!(jumps(seed, 1.0, grown).0, []);
    }
}

#[test]
fn a_limit_keeps_the_covariance_and_a_dead_zone_the_parameters() {
    let (inputs, outputs) = (pulses(), measured(1, 0.005, 0.0));
    let record = Run {
        inputs: &inputs,
        outputs: &outputs,
        ..Run::default()
    };
    let limited = Options {
        forgetting: Forgetting::Constant(0.9),
        covariance_limit: Some(100.0),
        ..Options::default()
    };
    let mut learner = recursion(Kind::LeastSquares, Structure::of_order(2), limited);
    learn(&mut learner, record);
    let unit = learner.covariance().unwrap() / learner.estimate().unwrap().noise_variance;
    // Each direction below the limit, so the trace below as many limits.
    assert!(unit.trace() <= 5.0 * 100.0, "{}", unit.trace());

    let mut learner = recursion(
        Kind::LeastSquares,
        Structure::of_order(2),
        Options::default(),
    );
    learn(&mut learner, record);
    let learnt = learner.parameters();
    let deaf = Options {
        dead_zone: 10.0,
        ..Options::default()
    };
    let mut learner = recursion(Kind::LeastSquares, Structure::of_order(2), deaf);
    learn(&mut learner, record);
    assert_eq!(learner.parameters().amax(), 0.0);
    assert!(learnt.amax() > 0.1);
}

#[test]
fn resetting_the_covariance_keeps_the_parameters_and_a_gap_the_learning() {
    let (inputs, outputs) = (pulses(), clean());
    let record = Run {
        inputs: &inputs,
        outputs: &outputs,
        ..Run::default()
    };
    let structure = Structure::of_order(3).without_offset();
    let options = Options {
        // A clean third-order record determines its weakest direction by 1e-10: a prior of 1e-20 is nothing beside it.
        initial_covariance: 1e20,
        ..Options::default()
    };
    let mut learner = recursion(Kind::LeastSquares, structure, options);
    learn(
        &mut learner,
        Run {
            inputs: &inputs[..100],
            outputs: &outputs[..100],
            ..Run::default()
        },
    );
    // A gap of ten samples; both parts are of one plant.
    learn(
        &mut learner,
        Run {
            inputs: &inputs[110..],
            outputs: &outputs[110..],
            ..Run::default()
        },
    );
    let theta = learner.parameters();
    assert!((theta[0] - common::A[1]).abs() < 1e-8, "{}", theta[0]);
    learner.reset_covariance();
    assert!((learner.parameters() - &theta).amax() < 1e-9);
    assert!(learner.estimate().is_none());
    learn(&mut learner, record);
    assert!((learner.parameters()[0] - theta[0]).abs() < 1e-8);
    learner.reset();
    assert_eq!(learner.parameters().amax(), 0.0);
}

#[test]
fn options_without_meaning_are_refused() {
    let refused =
        |options| Recursion::new(Kind::LeastSquares, Structure::of_order(1), 0.1, options).is_err();
    for forgetting in [
        Forgetting::Constant(0.0),
        Forgetting::Directional(1.5),
        Forgetting::Variable {
            least: 0.9,
            information: 0.0,
        },
    ] {
        assert!(refused(Options {
            forgetting,
            ..Options::default()
        }));
    }
    assert!(refused(Options {
        covariance_limit: Some(f64::NAN),
        ..Options::default()
    }));
}

#[test]
fn a_frozen_recursion_goes_on_predicting_and_learns_nothing() {
    let inputs = noise(1, 400);
    let outputs = filter(&B, &A, &inputs);
    for kind in [
        Kind::LeastSquares,
        Kind::ExtendedLeastSquares,
        Kind::PredictionError,
        Kind::OutputError,
    ] {
        let structure = Structure::of_order(2).without_offset();
        let mut recursion = recursion(kind, structure, Options::default());
        recursion.begin(outputs[0]);
        for k in 1..200 {
            recursion.push(inputs[k - 1], outputs[k]);
        }
        let learnt = (recursion.parameters(), recursion.covariance());
        recursion.set_frozen(true);
        for k in 200..400 {
            // Another plant: there is an error to learn from.
            recursion.push(inputs[k - 1], 2.0 * outputs[k]);
            assert!(recursion.error().unwrap() != 0.0);
        }
        assert_eq!((recursion.parameters(), recursion.covariance()), learnt);
        recursion.set_frozen(false);
        recursion.push(inputs[0], outputs[1]);
        assert_ne!(recursion.parameters(), learnt.0);
    }
}

#[test]
fn first_moments_are_known_for_what_they_are_whatever_the_recursion() {
    let (inputs, moments) = (noise(1, 3000), noise(2, 3000));
    let held = filter(&B, &A, &inputs);
    let moved = filter(&[0.0, 0.3, -0.1], &A, &moments);
    for (kind, within) in [
        (Kind::LeastSquares, 1e-6),
        (Kind::PredictionError, 1e-3),
        // It is slow to converge.
        (Kind::OutputError, 0.1),
    ] {
        let structure = Structure::of_order(2);
        let mut recursion = recursion(kind, structure, Options::default())
            .with_moments()
            .unwrap();
        recursion.begin(held[0] + moved[0]);
        for k in 1..3000 {
            let input = Input {
                mean: inputs[k - 1],
                moment: moments[k - 1],
            };
            recursion.push_input(input, held[k] + moved[k]);
        }
        // a1, a2, b1, b2, offset, moments
        let truth = [A[1], A[2], B[1], B[2], 0.0, 0.3, -0.1];
        let found = recursion.parameters();
        for (value, truth) in found.iter().zip(truth) {
            assert!((value - truth).abs() < within, "{kind:?}: {found}");
        }
    }
}
