//! Verdicts on records whose true model is known.

#[allow(dead_code)]
use crate::common::{SAMPLE_TIME, measured, pulses};
use planesman_identification::analysis::{Analysis, Options, analyse};
use planesman_identification::estimators::Method;
use planesman_identification::{Record, Segment, filter, noise, with_noise};

fn record(segments: Vec<(Vec<f64>, Vec<f64>)>) -> Record {
    Record {
        sample_time: SAMPLE_TIME,
        inputs: vec!["planes".to_owned()],
        outputs: vec!["gyro".to_owned()],
        segments: segments
            .into_iter()
            .map(|(inputs, outputs)| Segment {
                start: 0,
                inputs: vec![inputs],
                outputs: vec![outputs],
                ..Segment::default()
            })
            .collect(),
    }
}

fn found(inputs: Vec<f64>, outputs: Vec<f64>, options: &Options) -> Analysis {
    analyse(&record(vec![(inputs, outputs)]), options).unwrap()
}

fn says(analysis: &Analysis, phrase: &str) -> bool {
    analysis
        .sentences()
        .iter()
        .any(|sentence| sentence.contains(phrase))
}

/// Second order, poles 0.9 and 0.7, first effect after two samples.
fn second_order(inputs: &[f64]) -> Vec<f64> {
    filter(&[0.0, 0.0, 0.2, 0.1], &[1.0, -1.6, 0.63], inputs)
}

#[test]
fn order_and_delay_are_found_and_the_next_order_is_said_to_add_nothing() {
    let inputs = noise(1, 800);
    let outputs = with_noise(&second_order(&inputs), 2, 0.1);
    let analysis = found(inputs, outputs, &Options::default());
    let structure = &analysis.estimate.layout.structure;
    assert_eq!(
        (structure.poles, structure.delay),
        (2, 2),
        "{}",
        analysis.text()
    );
    assert!(
        says(
            &analysis,
            "by cross-validation: output_error, order 2, delay 2"
        ),
        "{}",
        analysis.text()
    );
    assert!(
        says(&analysis, "white and uncorrelated"),
        "{}",
        analysis.text()
    );
    assert!(analysis.held_out.fit.unwrap() > 85.0);
}

#[test]
fn least_squares_on_a_noisy_gyro_is_told_that_its_second_pole_is_noise() {
    let options = Options {
        method: Method::LeastSquares,
        order: Some(2),
        delay: Some(1),
        offset: false,
        ..Options::default()
    };
    let analysis = found(pulses(), measured(12345, 0.005, 0.0), &options);
    assert!(says(&analysis, "artefact of noise"), "{}", analysis.text());
}

#[test]
fn an_order_too_low_is_told_that_dynamics_are_missing() {
    let inputs = noise(3, 800);
    let outputs = with_noise(&second_order(&inputs), 4, 0.02);
    let options = Options {
        order: Some(1),
        delay: Some(1),
        ..Options::default()
    };
    let analysis = found(inputs, outputs, &options);
    assert!(
        says(&analysis, "dynamics are missing"),
        "{}",
        analysis.text()
    );
}

#[test]
fn segments_with_gaps_between_are_one_model() {
    let inputs = noise(5, 600);
    let outputs = second_order(&inputs);
    let cut = |from: usize, to: usize| (inputs[from..to].to_vec(), outputs[from..to].to_vec());
    let options = Options {
        order: Some(2),
        delay: Some(2),
        ..Options::default()
    };
    let analysis = analyse(&record(vec![cut(0, 250), cut(300, 600)]), &options).unwrap();
    let model = analysis.model();
    // The second begins in motion, with an input that is not in the record still to take effect.
    assert!((model.a[0] + 1.6).abs() < 0.02, "{:?}", model.a);
    assert_eq!(analysis.longest, 1);
}

#[test]
fn a_record_without_an_input_is_refused() {
    assert!(analyse(&record(vec![]), &Options::default()).is_err());
    let still = record(vec![(vec![0.0; 100], vec![0.0; 100])]);
    assert!(analyse(&still, &Options::default()).is_err());
}

#[test]
fn the_coefficients_covariance_knows_what_was_known_beforehand() {
    let inputs = noise(1, 400);
    let outputs = with_noise(
        &filter(&[0.0, 0.2, -0.2], &[1.0, -1.6, 0.63], &inputs),
        2,
        0.05,
    );
    let options = Options {
        order: Some(2),
        delay: Some(1),
        zeros_at_one: 1,
        ..Options::default()
    };
    let analysis = found(inputs, outputs, &options);
    let p = analysis.estimate.coefficient_covariance(analysis.longest);
    let estimated = &analysis.estimate.covariance;
    for i in 0..2 {
        for j in 0..2 {
            assert!((p[(i, j)] - estimated[(i, j)]).abs() <= 1e-12 * estimated[(i, j)].abs());
        }
    }
    // b2 = -b1: as uncertain, and their sum not at all.
    assert!(p[(2, 2)] > 0.0);
    assert!((p[(2, 2)] + p[(2, 3)]).abs() < 1e-12 * p[(2, 2)]);
    assert!((p[(3, 3)] - p[(2, 2)]).abs() < 1e-12 * p[(2, 2)]);
}

/// 3/(s^2 + 1.2 s + 4), held in steps of 0.1 s (scipy: `cont2discrete(([3], [1, 1.2, 4]), 0.1)`): gain 0.75.
fn oscillating(inputs: &[f64]) -> Vec<f64> {
    let b = [0.0, 0.014_369_969_403, 0.013_805_836_567_7];
    filter(
        &b,
        &[1.0, -1.849_352_695_422_9, 0.886_920_436_717_16],
        inputs,
    )
}

#[test]
fn an_impulse_in_the_first_row_is_one_from_rest() {
    let mut inputs = vec![0.0; 200];
    inputs[0] = 10.0;
    let outputs = oscillating(&inputs);
    let analysis = found(inputs, outputs, &Options::default());
    let gain = analysis.reading().steady_state_gain().unwrap().value.re;
    assert!((gain - 0.75).abs() < 1e-6, "{}", analysis.text());
    assert!(says(&analysis, "verdict: good"), "{}", analysis.text());
}

#[test]
fn a_step_in_the_second_row_is_no_impulse_though_the_output_comes_back() {
    // 2 s/(s^2 + 1.2 s + 4), held in steps of 0.1 s (scipy as above): gain 0.
    let b = [0.0, 0.187_212_310_281_86, -0.187_212_310_281_86];
    let mut inputs = vec![1.0; 200];
    inputs[0] = 0.0;
    let outputs = filter(
        &b,
        &[1.0, -1.849_352_695_422_9, 0.886_920_436_717_16],
        &inputs,
    );
    let analysis = found(inputs, outputs, &Options::default());
    let gain = analysis.reading().steady_state_gain().map(|it| it.value.re);
    assert!(gain.is_none_or(|it| it.abs() < 1e-6), "{}", analysis.text());
}

#[test]
fn a_triangle_in_open_loop_is_not_called_closed_loop() {
    let triangle = |k: i32| f64::from((k % 80 - 40).abs()) / 20.0 - 1.0;
    let inputs: Vec<f64> = (0..2000).map(triangle).collect();
    let outputs = with_noise(&oscillating(&inputs), 5, 0.05);
    let analysis = found(inputs, outputs, &Options::default());
    assert!(!says(&analysis, "closed-loop"), "{}", analysis.text());
}

#[test]
fn a_smooth_input_without_noise_gives_a_model_that_is_good_and_no_cause() {
    let smooth = |k: i32| {
        let x = (f64::from(k) / 80.0 - 0.5).clamp(0.0, 1.0);
        (3.0 - 2.0 * x) * x * x
    };
    let inputs: Vec<f64> = (0..400).map(smooth).collect();
    let outputs = oscillating(&inputs);
    let analysis = found(inputs, outputs, &Options::default());
    let gain = analysis.reading().steady_state_gain().unwrap().value.re;
    assert!((gain - 0.75).abs() < 1e-6, "{}", analysis.text());
    assert!(says(&analysis, "verdict: good"), "{}", analysis.text());
}

/// A PI controller, 2 + 1.2/s, around 2/(3 s + 1) in steps of 0.05 s, for a setpoint and a disturbance of the output: input and output.
/// The plant is held (scipy: `cont2discrete(([2], [3, 1]), 0.05)`): gain 2.
fn in_loop(setpoint: &[f64], disturbance: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut inputs, mut outputs, mut state, mut integral) = (vec![], vec![], 0.0, 0.0);
    for (r, d) in setpoint.iter().zip(disturbance) {
        let y = state + d;
        integral += 1.2 * 0.05 * (r - y);
        let u: f64 = integral + 2.0 * (r - y);
        outputs.push(y);
        inputs.push(u);
        state = 0.983_471_453_82 * state + 0.033_057_092_36 * u;
    }
    (inputs, outputs)
}

#[test]
fn in_a_loop_the_plant_is_found_whatever_the_noise_and_no_curve_is_made_up() {
    let white = noise(3, 2400);
    let coloured = filter(&[0.02], &[1.0, -0.97], &noise(5, 2400));
    let telegraph: Vec<f64> = (0..2400)
        .map(|k| noise(8, 24)[k / 100].signum() + 0.2)
        .collect();
    for disturbance in [white.iter().map(|e| 0.02 * e).collect(), coloured] {
        let (inputs, outputs) = in_loop(&telegraph, &disturbance);
        let analysis = found(inputs, outputs, &Options::default());
        let gain = analysis.reading().steady_state_gain().unwrap();
        let told = analysis.text();
        assert!((gain.value.re - 2.0).abs() < 0.15, "{told}");
        let delay = analysis.lag.unwrap();
        assert!(delay.interval.0 >= 1, "{told}");
        assert!(
            analysis.curved.is_none() && analysis.finding.is_none(),
            "{told}"
        );
        assert!(analysis.drift < 0.01, "{told}");
    }
}

#[test]
fn a_sine_that_the_input_does_not_cause_is_named_and_the_model_is_not_called_good() {
    let inputs: Vec<f64> = (0..1500).map(|k| noise(4, 60)[k / 25].signum()).collect();
    let sine = (0..1500).map(|k| 0.1 * libm::sin(0.07 * f64::from(k)));
    let outputs: Vec<f64> = oscillating(&inputs)
        .iter()
        .zip(sine)
        .map(|(y, d)| y + d)
        .collect();
    let analysis = found(inputs, with_noise(&outputs, 6, 0.005), &Options::default());
    let told = analysis.text();
    let rate = 0.07 / SAMPLE_TIME;
    assert!(
        says(&analysis, &format!("oscillates at {rate:.2}")),
        "{told}"
    );
    assert!(
        says(&analysis, "something that is not recorded moves the output"),
        "{told}"
    );
}

#[test]
fn the_delays_interval_holds_the_true_one_where_lags_look_like_a_delay() {
    // 7.5/((s + 0.5)(s + 1.5)(s + 5)), held in steps of 0.1 s (scipy), answers by one sample: a model of lower order has a longer delay.
    let b = [
        0.0,
        0.001_053_250_394_1,
        0.003_550_376_957_9,
        0.000_742_324_227_3,
    ];
    let a = [
        1.0,
        -2.418_468_060_638,
        1.917_726_340_219,
        -0.496_585_303_791,
    ];
    let levels = [0.0, 1.0, -1.0, 0.5, -0.4];
    let inputs: Vec<f64> = (0..500).map(|k| levels[k / 100]).collect();
    for seed in [1, 2, 3] {
        let outputs = with_noise(&filter(&b, &a, &inputs), seed, 0.2);
        let analysis = found(inputs.clone(), outputs, &Options::default());
        let (least, most) = analysis.lag.unwrap().interval;
        assert!((least..=most).contains(&1), "{}", analysis.text());
    }
}

#[test]
fn a_limit_between_the_inputs_levels_is_not_determined() {
    // Levels 0, 200 ... 1000, limited at 1: every limit between 0 and 200 with the gain that belongs to it gives the same output.
    let draws = noise(5, 15);
    let levels: Vec<f64> = (0..900)
        .map(|k| 200.0 * f64::from((40.0 * draws[k / 60]).abs() as u32 % 6))
        .collect();
    let limited: Vec<f64> = levels.iter().map(|u| u.min(1.0)).collect();
    let outputs = with_noise(&filter(&[0.0, 0.08], &[1.0, -0.92], &limited), 3, 0.005);
    let analysis = found(levels, outputs, &Options::default());
    assert!(analysis.curved.is_none(), "{}", analysis.text());
    assert!(!says(&analysis, "verdict: good"), "{}", analysis.text());
}
