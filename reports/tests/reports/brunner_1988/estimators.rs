//! Results of the batch estimators: the plant itself from clean records, the same model
//! by different methods from noisy ones, with prior knowledge kept.

use nalgebra::{DMatrix, DVector};
use planesman_identification::estimators::{Armax, Estimate, Estimator, LeastSquares, OutputError};
use planesman_identification::{
    InitialState, Problem, Reading, Run, Structure, Uncertain, filter, with_noise,
};
use planesman_linear::{Complex, polynomial};
use planesman_reports::brunner_1988::identification::synthetic::{self, NOISE, SAMPLE_TIME};

/// The batch estimators of transfer functions.
const ALL: [&dyn Estimator; 3] = [&LeastSquares, &Armax, &OutputError];

fn fit(
    estimator: &dyn Estimator,
    structure: Structure,
    records: &[(Vec<f64>, Vec<f64>)],
) -> Estimate {
    let runs = records
        .iter()
        .map(|(inputs, outputs)| Run {
            inputs,
            outputs,
            ..Run::default()
        })
        .collect();
    estimator
        .fit(&Problem::new(structure, SAMPLE_TIME, runs).unwrap())
        .unwrap()
}

fn distance(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    found
        .iter()
        .zip(expected)
        .map(|(f, e)| (f - e).abs())
        .fold(0.0, f64::max)
}

#[test]
fn every_method_finds_the_plant_in_a_clean_record() {
    for run in synthetic::Run::ALL {
        let record = [(run.planes(), run.measured(1, 0.0, 0.025))];
        for method in ALL {
            for structure in [
                Structure::of_order(3),
                Structure::of_order(3).with_zero_at_one(),
            ] {
                let found = fit(method, structure, &record);
                let model = found.model(0);
                let off =
                    distance(&model.a, &run.plant().a).max(distance(&model.b, &run.plant().b));
                assert!(off < 1e-4, "{} {method:?}: off by {off:e}", run.name());
                assert!(
                    (found.offset(0) - 0.025).abs() < 1e-6,
                    "{} {method:?}: {}",
                    run.name(),
                    found.offset(0)
                );
                let fit = found.simulated_fit(
                    0,
                    Run {
                        inputs: &record[0].0,
                        outputs: &record[0].1,
                        ..Run::default()
                    },
                    0,
                );
                assert!(fit.unwrap() > 99.99, "{} {method:?}: {fit:?}", run.name());
            }
        }
    }
}

/// Second order with a zero at z = 1: poles 0.95 and 0.8.
fn second_order(inputs: &[f64]) -> Vec<f64> {
    filter(&[0.0, 0.1, -0.1], &[1.0, -1.75, 0.76], inputs)
}

#[test]
fn a_record_that_begins_in_motion_is_no_obstacle_when_said_so() {
    let run = synthetic::Run::EightOne;
    let record = [(run.planes()[30..].to_vec(), run.clean()[30..].to_vec())];
    let structure = Structure {
        start: InitialState::Estimated,
        ..Structure::of_order(3)
    };
    let found = fit(&OutputError, structure, &record);
    // What the planes did before the record began is part of the motion: two samples of input
    // enter rows that the motion's three numbers make up for.
    let off = distance(&found.model(0).a, &run.plant().a);
    assert!(off < 1e-4, "{off:e}");
}

#[test]
fn records_may_share_their_poles_and_keep_their_numerators() {
    let run = synthetic::Run::NineOne;
    let doubled: Vec<f64> = run.clean().iter().map(|y| 2.0 * y).collect();
    let records = [(run.planes(), run.clean()), (run.planes(), doubled)];
    let structure = Structure {
        own_numerators: true,
        ..Structure::of_order(3)
    };
    for method in ALL {
        let found = fit(method, structure.clone(), &records);
        let ratio = found.model(1).b[0] / found.model(0).b[0];
        assert!((ratio - 2.0).abs() < 1e-4, "{method:?}: {ratio}");
        assert!(
            distance(&found.model(0).a, &run.plant().a) < 1e-4,
            "{method:?}"
        );
        assert_eq!(found.residuals.len(), 2);
    }
}

#[test]
fn a_known_integrator_and_a_delay_are_kept() {
    let planes = synthetic::Run::EightOne.planes();
    // 0.02 q^-3 / ((1 - q^-1)(1 - 0.9 q^-1))
    let outputs = filter(&[0.0, 0.0, 0.0, 0.02], &[1.0, -1.9, 0.9], &planes);
    let structure = Structure {
        delay: 3,
        numerator: 1,
        ..Structure::of_order(2)
    }
    .with_integrator();
    for method in ALL {
        let found = fit(
            method,
            structure.clone(),
            &[(planes.clone(), outputs.clone())],
        );
        let model = found.model(0);
        assert!(
            distance(&model.a, &[-1.9, 0.9, 0.0]) < 1e-6,
            "{method:?}: {:?}",
            model.a
        );
        assert!(
            distance(&model.b, &[0.0, 0.0, 0.02]) < 1e-7,
            "{method:?}: {:?}",
            model.b
        );
        let poles = Reading::new(&found, 0).poles().unwrap();
        assert_eq!(poles[1].value, Complex::new(1.0, 0.0));
        assert_eq!(poles[1].real_deviation(), 0.0);
    }
}

/// Mean of the second pole over records with noises of their own, and the standard deviation of one.
fn second_pole(estimator: &dyn Estimator) -> (f64, f64) {
    const RECORDS: u32 = 20;
    let planes = synthetic::Run::SevenFive.planes();
    let poles: Vec<f64> = (0..RECORDS)
        .map(|seed| {
            let outputs = with_noise(&second_order(&planes), 7 + 1000 * seed, NOISE);
            let structure = Structure::of_order(2).without_offset();
            let found = fit(estimator, structure, &[(planes.clone(), outputs)]);
            Reading::new(&found, 0).poles().unwrap()[1].value.re
        })
        .collect();
    let mean = poles.iter().sum::<f64>() / f64::from(RECORDS);
    let squares = poles.iter().map(|pole| (pole - mean).powi(2));
    (mean, (squares.sum::<f64>() / f64::from(RECORDS)).sqrt())
}

#[test]
fn noise_draws_least_squares_where_its_own_regressors_say_and_not_the_others() {
    // White noise on the output adds its power to the regressors' own products:
    // theta -> (Phi'Phi + N sigma^2 on the outputs)^-1 Phi'y, Phi and y without noise.
    let planes = synthetic::Run::SevenFive.planes();
    let clean = second_order(&planes);
    let rows = clean.len() - 2;
    let phi = DMatrix::from_fn(rows, 4, |k, j| match j {
        0 | 1 => -clean[k + 1 - j],
        _ => planes[k + 3 - j],
    });
    let y = DVector::from_column_slice(&clean[2..]);
    let mut products = phi.tr_mul(&phi);
    for j in 0..2 {
        products[(j, j)] += rows as f64 * NOISE * NOISE;
    }
    let limit = products.lu().solve(&phi.tr_mul(&y)).unwrap();
    let smoother = polynomial::roots(&[1.0, limit[0], limit[1]]).unwrap();
    let smoother = smoother.iter().map(|z| z.re).fold(1.0, f64::min);
    assert!(smoother < 0.4, "{smoother}");
    let off = |(mean, deviation): (f64, f64), expected: f64| {
        (mean - expected).abs() / (deviation / 20_f64.sqrt())
    };
    let found = second_pole(&LeastSquares);
    assert!(off(found, smoother) < 4.0, "{found:?}, {smoother} expected");
    for estimator in [&Armax as &dyn Estimator, &OutputError] {
        let found = second_pole(estimator);
        assert!(off(found, 0.8) < 4.0, "{estimator:?}: {found:?}");
    }
}

#[test]
fn a_record_that_says_nothing_is_refused_with_the_reason() {
    let record = [(vec![0.0; 50], vec![0.0; 50])];
    for method in ALL {
        let runs = record
            .iter()
            .map(|(inputs, outputs)| Run {
                inputs,
                outputs,
                ..Run::default()
            })
            .collect();
        let problem = Problem::new(Structure::of_order(2), SAMPLE_TIME, runs).unwrap();
        assert!(
            method
                .fit(&problem)
                .unwrap_err()
                .to_string()
                .contains("determine"),
            "{method:?}"
        );
    }
}

#[test]
fn the_covariance_is_carried_as_small_changes_are() {
    let run = synthetic::Run::SevenFive;
    let record = [(run.planes(), run.measured(3, NOISE, 0.025))];
    let found = fit(&OutputError, Structure::of_order(2), &record);
    // Perturb each parameter and carry the covariance through the differences.
    let carried = |read: &dyn Fn(&Estimate) -> Complex<f64>| {
        let mut total = nalgebra::Matrix2::zeros();
        let slope = |i: usize| {
            let moved = |by: f64| {
                let mut estimate = found.clone();
                estimate.theta[i] += by;
                read(&estimate)
            };
            (moved(1e-7) - moved(-1e-7)) / 2e-7
        };
        let slopes: Vec<Complex<f64>> = (0..found.theta.len()).map(slope).collect();
        for (i, p) in slopes.iter().enumerate() {
            for (j, q) in slopes.iter().enumerate() {
                let share = found.covariance[(i, j)];
                total += nalgebra::Matrix2::new(p.re * q.re, p.re * q.im, p.im * q.re, p.im * q.im)
                    * share;
            }
        }
        total
    };
    type Read<'a> = (&'a str, &'a dyn Fn(&Estimate) -> Uncertain);
    let reads: [Read<'_>; 5] = [
        ("pole", &|e| Reading::new(e, 0).poles().unwrap()[0]),
        ("s pole", &|e| {
            Reading::new(e, 0).continuous_poles().unwrap()[1]
        }),
        ("zero", &|e| Reading::new(e, 0).zeros().unwrap()[0]),
        ("gain", &|e| Reading::new(e, 0).steady_state_gain().unwrap()),
        ("response", &|e| Reading::new(e, 0).response(3.0).unwrap()),
    ];
    for (name, read) in reads {
        let exact = read(&found).covariance;
        let differences = carried(&|e| read(e).value);
        let off = (exact - differences).amax() / exact.amax();
        assert!(off < 1e-4, "{name}: {off:e}");
    }
}
