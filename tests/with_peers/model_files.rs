//! An identified model in a file dives as the vehicle it was identified from, gives the controller its gains, and
//! is the same model in python-control.
//!
//! Where `.venv` is absent the last passes, saying what it skipped (tests/README.md).

use crate::foreign;
use crate::stage;
use std::path::Path;

use foreign::Python;
use planesman_flight::compose::Loop;
use planesman_flight::scenario::Scenario;
use planesman_linear::{Complex, ComplexFunctions as _};
use planesman_model_file::{ModelFile, Place};
use planesman_vehicle::Vehicle;
use planesman_vehicle::linearised;
use planesman_vehicle::vehicle_file::{brunner, load_on};
use stage::{Stage, text};

/// The speed of the scenario `dive`, m/s.
const SPEED: f64 = 0.3048;

/// The scenario's dive, and the third-order model that is identified from it, in the stage's folder under this name.
fn identified(stage: &Stage, model: &str) -> ModelFile {
    identified_as(stage, model, &["--order", "3", "--delay", "1"])
}

/// The same with other wishes for the fit.
fn identified_as(stage: &Stage, model: &str, wishes: &[&str]) -> ModelFile {
    stage.run(&["sim", "dive", "--out", "dive.mcap"]).success();
    let signals = [
        "--input",
        "plane_motion:dive_planes",
        "--output",
        "state:pitch_rate",
    ];
    let rest = ["--window", "20..90", "--speed", "0.3048", "--model", model];
    let arguments = [&["sysid", "fit", "dive.mcap"][..], &signals, &rest, wishes].concat();
    stage.run(&arguments).success();
    ModelFile::read(Path::new(&stage.path(model))).unwrap()
}

/// The continuous poles of a vehicle from planes to pitch rate, 1/s.
fn poles(vehicle: &Vehicle) -> Vec<Complex<f64>> {
    linearised::true_model(vehicle, SPEED, 0.05)
        .unwrap()
        .continuous_poles
}

/// How far the nearest of a file's poles is from this one, 1/s.
fn off(file: &ModelFile, pole: Complex<f64>) -> f64 {
    let off = |place: &Place| (Complex::new(place.re, place.im) - pole).modulus();
    let all = file.continuous_poles.iter().map(off);
    all.fold(f64::MAX, f64::min)
}

/// The depths of a scenario's flight in one process.
fn depths(text: &str) -> Vec<f64> {
    let flight = Loop::new(&Scenario::parse(text).unwrap()).unwrap();
    flight
        .map(|tick| tick.unwrap().observation.state.depth)
        .collect()
}

#[test]
fn an_identified_model_dives_as_the_vehicle_it_was_identified_from() {
    let stage = Stage::new();
    let file = identified(&stage, "model.yaml");
    let model = stage.path("model.yaml");

    let loaded = poles(&load_on(&model, "brunner").unwrap());
    for (found, truth) in loaded.into_iter().zip(poles(&brunner())) {
        let from_the_file = off(&file, found);
        assert!(from_the_file < 0.01 * found.modulus(), "{from_the_file}");
        // Heave is known to the vehicle and was not to the fit, so it comes nearer to the truth.
        let off = (found - truth).modulus();
        assert!(off < 0.001 * truth.modulus(), "{found} is not {truth}");
    }

    let text = include_str!("../../launch-scripts/scenarios/identified.yaml");
    let again = depths(&text.replace("model.yaml", &model));
    let first = depths(include_str!("../../launch-scripts/scenarios/dive.yaml"));
    for (again, first) in again.iter().zip(&first) {
        assert!((again - first).abs() < 5e-3, "{again} m for {first} m");
    }
}

#[test]
fn the_vehicle_s_equations_come_round_to_their_own_poles() {
    for (wishes, name) in [
        (
            &["--method", "vehicle", "--vehicle", "brunner"][..],
            "heaving.json",
        ),
        (&["--method", "vehicle"], "pitching.json"),
    ] {
        let stage = Stage::new();
        let file = identified_as(&stage, name, wishes);
        let loaded = load_on(&stage.path(name), "brunner").unwrap();
        let loaded = poles(&loaded);
        for place in &file.continuous_poles {
            let pole = Complex::new(place.re, place.im);
            let off = loaded
                .iter()
                .map(|it| (it - pole).modulus())
                .fold(f64::MAX, f64::min);
            assert!(off < 1e-6, "{name}: {pole}, {loaded:?}");
        }
        assert_eq!(
            file.physical.unwrap().heave.is_some(),
            name == "heaving.json"
        );
    }
}

#[test]
fn what_takes_a_vehicle_takes_a_model_file() {
    let stage = Stage::new();
    let _ = identified(&stage, "model.json");
    let printed = |command: &[&str], vehicle: &str, rest: &[&str]| {
        let arguments = [command, &[vehicle], rest].concat();
        stage.run(&arguments).success().stdout
    };
    let at_speed = &["--speed", "0.3048"][..];
    for (command, rest) in [
        (&["tf"][..], at_speed),
        (&["coefficients"], at_speed),
        (&["design", "analyse"], at_speed),
        (
            &["design", "place"],
            &["--real", "0.2", "--frequency", "0.7"],
        ),
    ] {
        let of_the_model = printed(command, "model.json", rest);
        let of_the_truth = printed(command, "brunner", rest);
        assert_eq!(of_the_model.lines().count(), of_the_truth.lines().count());
        assert_ne!(of_the_model, of_the_truth, "they are near, not the same");
    }
    let refused = stage.run(&["tf", "model.json", "--base", "no/such.yaml", "--speed", "1"]);
    assert!(!refused.status.success());
    assert!(refused.stderr.contains("no/such.yaml"), "{refused:?}");
}

#[test]
fn a_file_that_is_not_to_be_trusted_is_refused_at_the_start_and_while_it_flies() {
    let stage = Stage::new();
    let mut file = identified(&stage, "model.yaml");
    let good = stage.path("model.yaml");
    file.covariance
        .iter_mut()
        .enumerate()
        .for_each(|(i, row)| row[i] = 1.0);
    let unsure = stage.path("unsure.yaml");
    file.write(Path::new(&unsure)).unwrap();

    let refused = stage.node(
        "depth_controller",
        &["gains.source:=file", &format!("gains.file:={unsure}")],
    );
    let refused = refused.finish();
    assert!(!refused.status.success());
    let complaint = refused.stderr;
    assert!(
        complaint.contains("gains.file") && complaint.contains("known only to"),
        "{complaint}"
    );

    let _controller = stage.node(
        "depth_controller",
        &["gains.source:=file", &format!("gains.file:={good}")],
    );
    let operator = stage.operator();
    let answer = operator.set("depth_controller", &[text("gains.file", &unsure)]);
    assert!(!answer.successful);
    assert!(answer.reason.contains("known only to"), "{}", answer.reason);
    let answer = operator.set("depth_controller", &[text("gains.file", &good)]);
    assert!(answer.successful, "{}", answer.reason);
}

#[test]
fn python_control_loads_the_same_model() {
    let Some(python) = Python::find() else { return };
    let stage = Stage::new();
    let file = identified(&stage, "model.json");
    let loaded = python.load_model(Path::new(&stage.path("model.json")));
    let list = |name: &str| -> Vec<Complex<f64>> {
        serde_json::from_value::<Vec<[f64; 2]>>(loaded[name].clone())
            .unwrap()
            .into_iter()
            .map(|[re, im]| Complex::new(re, im))
            .collect()
    };
    let all_are = |name: &str, places: &[Place], tolerance: f64| {
        let found = list(name);
        assert_eq!(found.len(), places.len(), "{name}");
        for place in places {
            let place = Complex::new(place.re, place.im);
            let nearest = found
                .iter()
                .map(|it| (it - place).modulus())
                .fold(f64::MAX, f64::min);
            assert!(nearest < tolerance, "{name}: {nearest}");
        }
    };
    all_are("poles", &file.poles, 1e-9);
    all_are("zeros", &file.zeros, 1e-9);
    all_are("continuous_poles", &file.continuous_poles, 1e-7);
    let [gain, _] = file.steady_state_gain.unwrap();
    for name in ["steady_state_gain", "continuous_steady_state_gain"] {
        let found = loaded[name].as_f64().unwrap();
        assert!((found - gain).abs() < 1e-6, "{name}: {found} for {gain}");
    }
    // Its own zero-order hold leads from the continuous model to the sampled one.
    for (held, sampled) in list("held_response").iter().zip(list("response")) {
        assert!(
            (held - sampled).modulus() < 1e-7 * sampled.modulus(),
            "{held} for {sampled}"
        );
    }
}
