//! The vehicle's own coefficients, from whole records and a sample at a time.

#![allow(clippy::unwrap_used)]

use planesman_linear::polynomial;
use sysid::estimators::kalman::{self, Filter, Settings};
use sysid::estimators::recursive::{Recursive, learn};
use sysid::estimators::vehicle::{self, Vehicle};
use sysid::structure::{Run, filter};
use sysid::synthetic::{self, BIAS, NOISE, SAMPLE_TIME, with_noise};

/// A guess of the kind the thesis begins with: K/J, B/J, M_theta/J of its block estimates (Table 8), and
/// as much again for doubt.
fn settings() -> Settings {
    Settings {
        parameters: [0.3, 1.2, 0.27],
        deviations: [3.0, 3.0, 0.5],
        bias_deviation: 0.05,
        noise: NOISE,
        bias_drift: 0.0,
        drift: [0.0; 3],
        disturbance: 0.0,
        motion: 0.0,
    }
}

#[test]
fn the_equations_are_those_of_the_sampled_plants() {
    for run in synthetic::Run::ALL {
        let (vehicle, truth) = run.vehicle();
        let mut poles = polynomial::roots(&vehicle.characteristic(truth)).unwrap();
        poles.iter_mut().for_each(|s| *s = (*s * SAMPLE_TIME).exp());
        let mut sampled = polynomial::from_roots(&poles).unwrap();
        sampled.remove(0);
        for (found, decimal) in sampled.iter().zip(run.plant().a) {
            assert!(
                (found - decimal).abs() < 1e-8,
                "{}: {found} {decimal}",
                run.name()
            );
        }
    }
}

#[test]
fn a_clean_record_gives_the_vehicle_and_the_bias() {
    for run in synthetic::Run::ALL {
        let (known, truth) = run.vehicle();
        let (inputs, outputs) = (run.planes(), run.measured(1, 0.0, BIAS));
        let record = Run {
            inputs: &inputs,
            outputs: &outputs,
        };
        let found = vehicle::fit(known, SAMPLE_TIME, &[record]).unwrap();
        for (found, truth) in found.parameters.iter().zip(truth) {
            assert!(
                (found / truth - 1.0).abs() < 1e-4,
                "{}: {found} {truth}",
                run.name()
            );
        }
        assert!((found.biases[0] - BIAS).abs() < 1e-6);
    }
}

#[test]
fn a_noisy_record_gives_it_within_the_uncertainty_claimed_by_filter_and_search_alike() {
    for run in synthetic::Run::ALL {
        let (known, truth) = run.vehicle();
        let (inputs, outputs) = (run.planes(), run.measured(77, NOISE, BIAS));
        let record = Run {
            inputs: &inputs,
            outputs: &outputs,
        };
        let search = vehicle::fit(known, SAMPLE_TIME, &[record]).unwrap();
        let filter = kalman::fit(known, SAMPLE_TIME, settings(), record, 4).unwrap();
        for (i, true_value) in truth.iter().enumerate() {
            let deviation = search.covariance[(i, i)].sqrt();
            let off = (search.parameters[i] - true_value) / deviation;
            assert!(
                off.abs() < 4.0,
                "{}: parameter {i} is {off} deviations off",
                run.name()
            );
            let apart = (search.parameters[i] - filter.parameters[i]) / deviation;
            assert!(
                apart.abs() < 1.0,
                "{}: parameter {i}: {apart} deviations apart",
                run.name()
            );
            let ratio = filter.covariance[(i, i)].sqrt() / deviation;
            assert!((0.6..1.6).contains(&ratio), "{}: {ratio}", run.name());
        }
    }
}

#[test]
fn without_heave_the_pitch_equation_alone_is_found() {
    // Brunner 1988, p. 93: K/(J s^2 + B s + M), here kappa s/(s^2 + beta s + mu) to the rate.
    let truth = [0.6, 1.5, 0.3];
    let alone = Vehicle::default();
    let poles = polynomial::roots(&alone.characteristic(truth)).unwrap();
    let z: Vec<_> = poles.iter().map(|s| (*s * SAMPLE_TIME).exp()).collect();
    let den = polynomial::from_roots(&z).unwrap();
    // The step response kappa (e^(s1 t) - e^(s2 t))/(s1 - s2), sampled.
    let b = truth[0] * (z[0] - z[1]).re / (poles[0] - poles[1]).re;
    let inputs = synthetic::Run::SevenFive.planes();
    let outputs = filter(&[0.0, b, -b], &den, &inputs);
    let record = Run {
        inputs: &inputs,
        outputs: &outputs,
    };
    let found = vehicle::fit(alone, SAMPLE_TIME, &[record]).unwrap();
    for (found, truth) in found.parameters.iter().zip(truth) {
        assert!((found / truth - 1.0).abs() < 1e-6, "{found} {truth}");
    }
    let coefficients = found.with_inertia(0.6);
    assert!((coefficients[1].0 - 0.9).abs() < 1e-5);
}

#[test]
fn pole_uncertainty_is_the_parameters_carried_through() {
    let run = synthetic::Run::EightOne;
    let (known, _) = run.vehicle();
    let (inputs, outputs) = (run.planes(), run.measured(5, NOISE, BIAS));
    let record = Run {
        inputs: &inputs,
        outputs: &outputs,
    };
    let found = vehicle::fit(known, SAMPLE_TIME, &[record]).unwrap();
    let pole = |by: [f64; 2]| {
        let mut moved = found.clone();
        moved.parameters[1] += by[0];
        moved.parameters[2] += by[1];
        moved.poles().unwrap()[2].value.re
    };
    let slopes = [[1e-6, 0.0], [0.0, 1e-6]].map(|by| (pole(by) - pole(by.map(|v| -v))) / 2e-6);
    let p = &found.covariance;
    let variance = slopes[0] * slopes[0] * p[(1, 1)]
        + 2.0 * slopes[0] * slopes[1] * p[(1, 2)]
        + slopes[1] * slopes[1] * p[(2, 2)];
    let deviation = found.poles().unwrap()[2].real_deviation();
    assert!((deviation / variance.sqrt() - 1.0).abs() < 1e-5);
}

#[test]
fn a_drifting_bias_is_followed() {
    let run = synthetic::Run::SevenFive;
    let (known, _) = run.vehicle();
    let inputs = run.planes();
    // 25 mV over the run, as the thesis' gyros drifted.
    let outputs: Vec<f64> = with_noise(&run.clean(), 9, 0.001)
        .iter()
        .enumerate()
        .map(|(k, y)| y + BIAS * k as f64 / 300.0)
        .collect();
    let drifting = Settings {
        noise: 0.001,
        bias_drift: 0.003,
        ..settings()
    };
    let mut filter = Filter::new(known, SAMPLE_TIME, drifting).unwrap();
    learn(
        &mut filter,
        Run {
            inputs: &inputs,
            outputs: &outputs,
        },
    );
    assert!(
        (filter.estimate().biases[0] - BIAS).abs() < 0.003,
        "{:?}",
        filter.estimate().biases
    );
    assert_eq!(filter.parameters().len(), 3);
}

#[test]
fn settings_without_meaning_are_refused() {
    for settings in [
        Settings {
            noise: 0.0,
            ..settings()
        },
        Settings {
            motion: -1.0,
            ..settings()
        },
        Settings {
            parameters: [f64::NAN; 3],
            ..settings()
        },
    ] {
        assert!(Filter::new(Vehicle::default(), SAMPLE_TIME, settings).is_err());
    }
}
