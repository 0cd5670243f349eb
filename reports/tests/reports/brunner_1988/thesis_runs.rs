//! Results of least squares and its recursive form on the thesis' kinds of runs: clean,
//! noisy, biased, detrended, begun in motion, closed in a loop, and on depth.
//!
//! Expected values were computed with 60-digit arithmetic and lie in
//! `least_squares_cases.json`; the data are made in `support`.

use super::support::*;
use planesman_identification::{
    Input, Model, RecursiveLeastSquares, Shape, least_squares, noise, rows, simulated, with_noise,
};
use planesman_reports::brunner_1988::identification::synthetic::{BIAS, NOISE, Plant, SAMPLE_TIME};

/// Enough for p0 to be without bound: the prior's share of any estimate is below rounding.
const UNBOUNDED: f64 = 1e30;

/// The record a case is fitted to.
struct Record {
    inputs: Vec<f64>,
    outputs: Vec<f64>,
    constant: bool,
}

impl Record {
    fn rows(&self, order: usize) -> Vec<(Vec<f64>, f64)> {
        let shape = Shape {
            order,
            moment: false,
            bias: self.constant,
        };
        rows(shape, &self.held_inputs(), &self.outputs)
    }

    fn held_inputs(&self) -> Vec<Input> {
        self.inputs.iter().map(|u| Input::held(*u)).collect()
    }
}

fn without_mean(values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.into_iter().map(|value| value - mean).collect()
}

fn plus(values: Vec<f64>, offset: f64) -> Vec<f64> {
    values.into_iter().map(|value| value + offset).collect()
}

/// A record that is taken to have been at zero before it began.
fn after_zeros(order: usize, values: &[f64]) -> Vec<f64> {
    let mut padded = vec![0.0; order];
    padded.extend(values);
    padded
}

/// z_k = 2 z_(k-1) - z_(k-2) + g (q_(k-1) + q_(k-2)) at 2.1 ft/s, V.
fn depth_from(pitch_rate: &[f64]) -> Vec<f64> {
    const GAIN: f64 = 0.01130325;
    let integrator = Plant {
        a: vec![-2.0, 1.0],
        b: vec![GAIN, GAIN],
    };
    integrator.respond(pitch_rate)
}

fn record(run: &str, case: &str, order: usize) -> Record {
    let u = planes(run);
    let y = clean(run);
    let noisy = || with_noise(&y, SEED, NOISE);
    let plain = |outputs| Record {
        inputs: u.clone(),
        outputs,
        constant: false,
    };
    let depth = |inputs, outputs| Record {
        inputs,
        outputs,
        constant: false,
    };
    let ramp = |z: Vec<f64>| -> Vec<f64> {
        z.into_iter()
            .enumerate()
            .map(|(k, z)| z + 1.627 + 0.02 * k as f64)
            .collect()
    };
    match case {
        "clean" => plain(y),
        "noise" => plain(noisy()),
        "bias" => plain(plus(y, BIAS)),
        "bias_const" => Record {
            constant: true,
            ..plain(plus(y, BIAS))
        },
        "bias+noise" => plain(plus(noisy(), BIAS)),
        "bias_detr_y" => plain(without_mean(plus(y, BIAS))),
        "bias+noise_detr_y" => plain(without_mean(plus(noisy(), BIAS))),
        "bias_detr_yu" => Record {
            inputs: without_mean(u.clone()),
            ..plain(without_mean(plus(y, BIAS)))
        },
        "quant12" => {
            let step = 20.0 / 4096.0;
            plain(y.iter().map(|y| (y / step + 0.5).floor() * step).collect())
        }
        "ic_cond" => Record {
            inputs: u[30..].to_vec(),
            ..plain(y[30..].to_vec())
        },
        "ic_prewin" => Record {
            inputs: after_zeros(order, &u[30..]),
            ..plain(after_zeros(order, &y[30..]))
        },
        "cl_noise" => {
            let (plant, noise) = (plant(run), noise(SEED, u.len()));
            let (mut fed, mut outputs, mut measured) = (Vec::new(), Vec::new(), Vec::new());
            for k in 0..u.len() {
                outputs.push(plant.next(&fed, &outputs));
                measured.push(outputs[k] + NOISE * noise[k]);
                fed.push(u[k] - measured[k]);
            }
            Record {
                inputs: fed,
                ..plain(measured)
            }
        }
        "depth_clean" => depth(y.clone(), depth_from(&y)),
        "depth_offset_ramp" => depth(y.clone(), ramp(depth_from(&y))),
        "depth_offset_ramp_prewin" => depth(
            after_zeros(order, &y),
            after_zeros(order, &ramp(depth_from(&y))),
        ),
        "depth_gyrobias" => depth(plus(y.clone(), BIAS), depth_from(&y)),
        "depth_gyrobias_const" => Record {
            constant: true,
            ..depth(plus(y.clone(), BIAS), depth_from(&y))
        },
        "depth_noise" => depth(y.clone(), with_noise(&depth_from(&y), DEPTH_SEED, NOISE)),
        other => panic!("no case {other}"),
    }
}

/// The largest difference, each relative to the expected number.
fn difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    found
        .iter()
        .zip(expected)
        .map(|(f, e)| (f - e).abs() / e.abs())
        .fold(0.0, f64::max)
}

fn recursive(rows: &[(Vec<f64>, f64)], lambda: f64, p0: f64) -> RecursiveLeastSquares {
    let mut rls = RecursiveLeastSquares::new(rows[0].0.len(), lambda, p0).unwrap();
    for (row, output) in rows {
        rls.update(row, *output);
    }
    rls
}

/// (name, record, expected case)
fn cases() -> Vec<(String, Record, serde_json::Value)> {
    expected()["cases"]
        .as_array()
        .unwrap()
        .iter()
        .map(|case| {
            let (run, kind) = (
                case["run"].as_str().unwrap(),
                case["case"].as_str().unwrap(),
            );
            let order = order(case);
            let name = format!("{run} {kind}, order {order}");
            (name, record(run, kind, order), case.clone())
        })
        .collect()
}

fn order(case: &serde_json::Value) -> usize {
    case["order"].as_u64().unwrap() as usize
}

#[test]
fn the_runs_are_the_ones_the_expected_values_were_computed_from() {
    for (name, run) in [("P3_1.2", "7/3"), ("P3_1.8", "9/1"), ("P3_2.1", "8/1")] {
        let expected = &expected()["plants"][name];
        assert_eq!(plant(run).a, numbers(&expected["a"]));
        assert_eq!(plant(run).b, numbers(&expected["b"]));
    }
    for (run, expected) in expected()["runs"].as_object().unwrap() {
        let y = clean(run);
        let sum: f64 = y.iter().map(|y| y * y).sum();
        assert!(difference(&[sum], &[expected["sum_y2"].as_f64().unwrap()]) < 1e-11);
        assert!(difference(&[y[25]], &[expected["y25"].as_f64().unwrap()]) < 1e-11);
        let e: f64 = noise(SEED, y.len()).iter().map(|e| e * e).sum();
        assert!(difference(&[e], &[expected["sum_e2"].as_f64().unwrap()]) < 1e-11);
    }
    let first = [-0.555054108612, 1.49447138701, -0.909095394425];
    assert!(difference(&noise(SEED, 3), &first) < 1e-11);
}

#[test]
fn batch_least_squares_finds_every_expected_estimate() {
    let mut checked = 0;
    for (name, record, case) in cases() {
        if !case["p0"].is_null() {
            continue;
        }
        let rows = record.rows(order(&case));
        assert_eq!(rows.len() as u64, case["rows"].as_u64().unwrap(), "{name}");
        let theta = least_squares(&rows).unwrap();
        let off = difference(theta.as_slice(), &numbers(&case["theta"]));
        assert!(off < 1e-8, "{name}: off by {off:e}");
        checked += 1;
    }
    assert_eq!(checked, 52);
}

#[test]
fn recursive_least_squares_with_an_unbounded_covariance_is_batch_least_squares() {
    for (name, record, case) in cases() {
        if case["p0"].is_null() {
            let rls = recursive(&record.rows(order(&case)), 1.0, UNBOUNDED);
            let off = difference(rls.parameters().as_slice(), &numbers(&case["theta"]));
            assert!(off < 1e-8, "{name}: off by {off:e}");
        }
    }
}

#[test]
fn recursive_least_squares_with_a_finite_covariance_is_the_ridge_estimate() {
    let mut checked = 0;
    for (name, record, case) in cases() {
        if let Some(p0) = case["p0"].as_f64() {
            let rls = recursive(&record.rows(order(&case)), 1.0, p0);
            let off = difference(rls.parameters().as_slice(), &numbers(&case["theta"]));
            assert!(off < 1e-8, "{name}, p0 {p0}: off by {off:e}");
            checked += 1;
        }
    }
    assert_eq!(checked, 4);
}

#[test]
fn the_recursive_estimate_passes_through_the_expected_points() {
    let rows = record("8/1", "noise", 2).rows(2);
    let trajectory = &expected()["trajectory"];
    for updates in [50, 100, 150, 198] {
        let theta = recursive(&rows[..updates], 1.0, 1e6).parameters();
        let off = difference(theta.as_slice(), &numbers(&trajectory[updates.to_string()]));
        assert!(off < 1e-10, "after {updates}: off by {off:e}");
    }
    let forgetting = recursive(&rows, 0.98, 1e6).parameters();
    assert!(difference(forgetting.as_slice(), &numbers(&trajectory["lambda0.98"])) < 1e-10);
}

#[test]
fn more_noise_moves_the_fast_pole_from_the_vehicle_to_a_smoother() {
    let expected = expected();
    for level in expected["sweep"].as_array().unwrap() {
        let sigma = level["sigma"].as_f64().unwrap();
        let record = Record {
            inputs: planes("8/1"),
            outputs: with_noise(&clean("8/1"), SEED, sigma),
            constant: false,
        };
        for (order, name) in [(2, "n2"), (3, "n3")] {
            let theta = least_squares(&record.rows(order)).unwrap();
            let off = difference(theta.as_slice(), &numbers(&level[name]));
            assert!(off < 1e-8, "sigma {sigma}, order {order}: off by {off:e}");
        }
    }
}

#[test]
fn a_fourth_order_fit_to_a_clean_third_order_run_is_known_to_be_undetermined() {
    for run in ["7/5", "8/1", "9/1"] {
        let rows = record(run, "clean", 4).rows(4);
        let all: Vec<usize> = (0..8).collect();
        assert_eq!(recursive(&rows, 1.0, 1e16).unlearnt(&all), 1, "{run}");
        let third: Vec<usize> = (0..6).collect();
        let rows = record(run, "clean", 3).rows(3);
        assert_eq!(recursive(&rows, 1.0, 1e16).unlearnt(&third), 0, "{run}");
    }
}

#[test]
fn feedback_alone_does_not_identify() {
    // u = -y without anything else: three of the six parameters are the controller's.
    let plant = plant("8/1");
    let mut outputs = vec![0.05, 0.04, 0.02];
    let mut inputs: Vec<f64> = outputs.iter().map(|y| -y).collect();
    while outputs.len() < 200 {
        outputs.push(plant.next(&inputs, &outputs));
        inputs.push(-outputs[outputs.len() - 1]);
    }
    let record = Record {
        inputs,
        outputs,
        constant: false,
    };
    let rls = recursive(&record.rows(3), 1.0, 1e16);
    assert!(rls.unlearnt(&[0, 1, 2, 3, 4, 5]) >= 3);
    assert!(least_squares(&record.rows(3)).is_err());
}

#[test]
fn poles_and_simulated_fit_are_the_expected_ones() {
    for (name, record, case) in cases() {
        let kind = case["case"].as_str().unwrap();
        let order = order(&case);
        let shape = Shape {
            order,
            moment: false,
            bias: record.constant,
        };
        let model = Model::from_parameters(shape, &numbers(&case["theta"]), SAMPLE_TIME);
        let poles = model.poles().unwrap();
        for root in case["roots"].as_array().unwrap() {
            let root = numbers(root);
            let nearest = poles
                .iter()
                .map(|pole| libm::hypot(pole.re - root[0], pole.im - root[1]))
                .fold(f64::MAX, f64::min);
            // Twelve digits of a double root at 1 are six of the root.
            assert!(nearest < 1e-5, "{name}: {nearest:e} from {root:?}");
        }
        if let (Some(expected), "clean" | "noise" | "bias" | "bias+noise") =
            (case["simulated_fit"].as_f64(), kind)
        {
            let fit = simulated(&model, &record.held_inputs(), &record.outputs).unwrap();
            assert!(
                (fit - expected).abs() < 1e-3,
                "{name}: {fit} %, {expected} % expected"
            );
        }
    }
}
