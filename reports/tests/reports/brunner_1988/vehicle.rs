//! The vehicle's own coefficients, from whole records and a sample at a time.

use planesman_identification::estimators::kalman::{Filter, Settings};
use planesman_identification::estimators::vehicle::{Heave, Vehicle};
use planesman_identification::estimators::{
    Estimate, Estimator, Guess, Recursive, VehicleFilter, VehicleSearch, learn,
};
use planesman_identification::{
    InitialState, Problem, Reading, Run, Structure, filter as filter_by, with_noise,
};
use planesman_linear::{ComplexFunctions as _, polynomial};
use planesman_reports::brunner_1988::identification::synthetic::{self, BIAS, NOISE, SAMPLE_TIME};

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

/// The filter, told the same.
fn filter(vehicle: Vehicle) -> VehicleFilter {
    let Settings {
        parameters,
        deviations,
        bias_deviation,
        noise,
        ..
    } = settings();
    VehicleFilter {
        guess: Some(Guess {
            parameters,
            deviations,
            bias_deviation,
        }),
        noise: Some(noise),
        ..VehicleFilter::new(vehicle)
    }
}

/// One record from rest.
fn fit(estimator: &dyn Estimator, inputs: &[f64], outputs: &[f64]) -> Estimate {
    let runs = vec![Run {
        inputs,
        outputs,
        ..Run::default()
    }];
    let problem = Problem::new(Structure::of_order(1), SAMPLE_TIME, runs).unwrap();
    estimator.fit(&problem).unwrap()
}

#[test]
fn the_equations_are_those_of_the_sampled_plants() {
    for run in synthetic::Run::ALL {
        let (vehicle, truth) = run.vehicle();
        let (sampled, _) = vehicle.sampled(&vehicle.coefficients(truth), SAMPLE_TIME);
        let plant = run.plant();
        for (found, decimal) in sampled.iter().zip(plant.a.iter().chain(&plant.b)) {
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
        let found = fit(&VehicleSearch { vehicle: known }, &inputs, &outputs);
        let values = found.physical.as_ref().unwrap().values.clone();
        for (found, truth) in values.iter().zip(truth) {
            assert!(
                (found / truth - 1.0).abs() < 1e-4,
                "{}: {found} {truth}",
                run.name()
            );
        }
        assert!((found.offset(0) - BIAS).abs() < 1e-6);
    }
}

#[test]
fn a_noisy_record_gives_it_within_the_uncertainty_claimed_by_filter_and_search_alike() {
    for run in synthetic::Run::ALL {
        let (known, truth) = run.vehicle();
        let (inputs, outputs) = (run.planes(), run.measured(77, NOISE, BIAS));
        let of = |estimator: &dyn Estimator| fit(estimator, &inputs, &outputs).physical.unwrap();
        let search = of(&VehicleSearch { vehicle: known });
        let filter = of(&filter(known));
        for (i, true_value) in truth.iter().enumerate() {
            let deviation = search.covariance[(i, i)].sqrt();
            let off = (search.values[i] - true_value) / deviation;
            assert!(
                off.abs() < 4.0,
                "{}: parameter {i} is {off} deviations off",
                run.name()
            );
            let apart = (search.values[i] - filter.values[i]) / deviation;
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
    let poles = polynomial::roots(&[1.0, truth[1], truth[2]]).unwrap();
    let z: Vec<_> = poles.iter().map(|s| (*s * SAMPLE_TIME).exp()).collect();
    let den = polynomial::from_roots(&z).unwrap();
    // The step response kappa (e^(s1 t) - e^(s2 t))/(s1 - s2), sampled.
    let b = truth[0] * (z[0] - z[1]).re / (poles[0] - poles[1]).re;
    let inputs = synthetic::Run::SevenFive.planes();
    let outputs = filter_by(&[0.0, b, -b], &den, &inputs);
    let found = fit(&VehicleSearch::default(), &inputs, &outputs);
    let found = found.physical.unwrap();
    for (found, truth) in found.values.iter().zip(truth) {
        assert!((found / truth - 1.0).abs() < 1e-6, "{found} {truth}");
    }
    let (name, value, _) = found.with_inertia(0.6)[1];
    assert!(name == "B" && (value - 0.9).abs() < 1e-5);
}

#[test]
fn pole_uncertainty_is_the_parameters_carried_through() {
    let run = synthetic::Run::EightOne;
    let (known, _) = run.vehicle();
    let (inputs, outputs) = (run.planes(), run.measured(5, NOISE, BIAS));
    let found = fit(&VehicleSearch { vehicle: known }, &inputs, &outputs);
    let physical = found.physical.as_ref().unwrap();
    let pole = |by: [f64; 2]| {
        let unknowns = [0.0, by[0], by[1]];
        let moved = [0, 1, 2].map(|i| physical.values[i] + unknowns[i]);
        let (sampled, _) = known.sampled(&known.coefficients(moved), SAMPLE_TIME);
        let den = [&[1.0], &sampled.as_slice()[..3]].concat();
        let poles = polynomial::roots(&den).unwrap();
        let slowest_last = poles.iter().map(|z| libm::log(z.re) / SAMPLE_TIME);
        slowest_last.fold(0.0, f64::min)
    };
    let slopes = [[1e-4, 0.0], [0.0, 1e-4]].map(|by| (pole(by) - pole(by.map(|v| -v))) / 2e-4);
    let p = &physical.covariance;
    let variance = slopes[0] * slopes[0] * p[(1, 1)]
        + 2.0 * slopes[0] * slopes[1] * p[(1, 2)]
        + slopes[1] * slopes[1] * p[(2, 2)];
    let poles = Reading::new(&found, 0).continuous_poles().unwrap();
    let fastest = poles
        .iter()
        .min_by(|p, q| p.value.re.total_cmp(&q.value.re));
    let deviation = fastest.unwrap().real_deviation();
    assert!((deviation / variance.sqrt() - 1.0).abs() < 1e-4);
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
            ..Run::default()
        },
    );
    assert!((filter.bias() - BIAS).abs() < 0.003, "{}", filter.bias());
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

#[test]
fn a_record_that_begins_in_motion_gives_the_same_vehicle() {
    for run in synthetic::Run::ALL {
        let (known, truth) = run.vehicle();
        let (inputs, outputs) = (run.planes(), run.measured(1, 0.0, BIAS));
        let structure = Structure {
            start: InitialState::Estimated,
            ..Structure::of_order(1)
        };
        let record = Run {
            inputs: &inputs[45..],
            outputs: &outputs[45..],
            ..Run::default()
        };
        let problem = Problem::new(structure, SAMPLE_TIME, vec![record]).unwrap();
        let found = VehicleSearch { vehicle: known }.fit(&problem).unwrap();
        let simulated = found.simulate(0, record);
        for (found, truth) in found.physical.unwrap().values.iter().zip(truth) {
            let off = (found / truth - 1.0).abs();
            assert!(off < 1e-4, "{}: {found} {truth}", run.name());
        }
        for (simulated, measured) in simulated.iter().zip(&outputs[45..]) {
            assert!((simulated - measured).abs() < 1e-6, "{}", run.name());
        }
    }
}

#[test]
fn heave_known_to_a_fifth_gives_the_vehicle_within_a_wider_uncertainty_that_is_true() {
    let run = synthetic::Run::SevenFive;
    let (known, truth) = run.vehicle();
    let heave = known.heave.unwrap().changed([0.2, -0.2, 0.2, -0.2]);
    let doubtful = |doubt| Vehicle {
        heave: Some(Heave { doubt, ..heave }),
    };
    let (inputs, outputs) = (run.planes(), run.measured(77, NOISE, BIAS));
    let of = |estimator: &dyn Estimator| fit(estimator, &inputs, &outputs).physical.unwrap();
    let sure = of(&VehicleSearch {
        vehicle: doubtful(0.0),
    });
    for unsure in [
        of(&VehicleSearch {
            vehicle: doubtful(0.2),
        }),
        of(&filter(doubtful(0.2))),
    ] {
        assert_eq!((sure.values.len(), unsure.values.len()), (3, 7));
        for (i, truth) in truth.iter().enumerate() {
            let deviation = unsure.covariance[(i, i)].sqrt();
            let off = (unsure.values[i] - truth) / deviation;
            assert!(off.abs() < 3.0, "parameter {i} is {off} deviations off");
            assert!(deviation > sure.covariance[(i, i)].sqrt(), "parameter {i}");
        }
    }
}
