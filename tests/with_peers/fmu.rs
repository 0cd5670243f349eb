//! `planesman export`: FMUs run by FMPy, from PyPI, as the loop runs in one process, and as scipy computes a model file.
//!
//! Where `.venv` has no FMPy the tests pass, saying what they skipped (tests/README.md).

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;
use std::process::Stdio;

use crate::foreign;
use crate::foreign::peers;
use crate::stage::Stage;
use planesman_flight::compose::{Loop, Tick};
use planesman_flight::scenario::Scenario;
use planesman_model_file::{ModelFile, Parameter, Side, StaticCurve};
use serde_json::{Value, json};

/// What FMPy makes of runs and wrong calls; `None`, having said so, where it is not there.
fn fmpy(asked: &Value) -> Option<Value> {
    let mut peer = peers::program("fmu.py")?;
    peer.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut peer = peer.stderr(Stdio::piped()).spawn().unwrap();
    let mut input = peer.stdin.take().unwrap();
    let _ = input.write_all(asked.to_string().as_bytes());
    drop(input);
    let output = peer.wait_with_output().unwrap();
    let complaints = String::from_utf8_lossy(&output.stderr);
    if complaints.contains("No module named 'fmpy'") {
        foreign::skip("there is no FMPy: .venv/bin/pip install -r python/tests/requirements.txt");
        return None;
    }
    assert!(output.status.success(), "{complaints}");
    Some(serde_json::from_slice(&output.stdout).unwrap())
}

/// The FMU of a subject in the stage's folder.
fn exported(stage: &Stage, subject: &str, options: &[&str]) -> String {
    let stem = Path::new(subject).file_stem().unwrap().to_str().unwrap();
    let out = format!("{stem}.fmu");
    let arguments = [&["export", "--fmi", subject, "-o", &out][..], options].concat();
    stage.run(&arguments).success();
    stage.path(&out)
}

/// The first ticks of a built-in scenario's flight in this process.
fn flown(scenario: &str, changes: &[&str], ticks: usize) -> Vec<Tick> {
    let changes: Vec<String> = changes.iter().map(|it| (*it).to_owned()).collect();
    let scenario = Scenario::load_with(scenario, &changes).unwrap();
    let flight = Loop::new(&scenario).unwrap();
    flight.take(ticks).map(|tick| tick.unwrap()).collect()
}

/// The parameters that a scenario gives `plant_sim`, as an FMU's start values.
fn start(scenario: &str, names: &[&str]) -> Value {
    let scenario = Scenario::load(scenario).unwrap();
    let values = scenario.values("plant_sim").unwrap();
    let of = |name: &&str| {
        let text = values.get(name).unwrap().to_string();
        (
            (*name).to_owned(),
            serde_json::from_str::<Value>(&text).unwrap(),
        )
    };
    names
        .iter()
        .map(of)
        .collect::<serde_json::Map<_, _>>()
        .into()
}

/// The held value of a path over a tick; nothing is neutral.
fn held(samples: &[f64]) -> f64 {
    samples.last().copied().unwrap_or_default()
}

const STATE: [&str; 11] = [
    "distance",
    "cross_track",
    "depth",
    "depth_rate",
    "roll",
    "pitch",
    "pitch_rate",
    "yaw",
    "yaw_rate",
    "surge",
    "heave",
];

fn state(tick: &Tick) -> Vec<Value> {
    let it = &tick.observation.state;
    let row = [
        it.distance,
        it.cross_track,
        it.depth,
        it.depth_rate,
        it.roll,
        it.pitch,
        it.pitch_rate,
        it.yaw,
        it.yaw_rate,
        it.surge,
        it.heave,
    ];
    row.map(Value::from).to_vec()
}

/// A run of an FMU, and the outputs at each tick that it must have to the last bit.
struct Case {
    run: Value,
    expected: Vec<Vec<Value>>,
}

/// The actuator of the built-in dive; the counts are those of the tick before, which `dha_state` tells at its start.
fn actuator(stage: &Stage) -> Case {
    let ticks = flown("dive", &[], 240);
    let commands: Vec<f64> = ticks.iter().map(|it| it.command.dive_planes).collect();
    let row = |(k, tick): (usize, &Tick)| {
        let at = &tick.states[0];
        let before = k.checked_sub(1).map_or(0, |k| ticks[k].states[0].pulses);
        vec![
            at.ram.into(),
            at.ram_velocity.into(),
            at.pressure.into(),
            at.volume.into(),
            at.leakage.into(),
            at.sign.into(),
            at.at_stop.into(),
            before.into(),
        ]
    };
    let outputs = [
        "ram",
        "ram_velocity",
        "pressure",
        "volume",
        "leakage",
        "sign",
        "at_stop",
        "pulses",
    ];
    Case {
        expected: ticks.iter().enumerate().map(row).collect(),
        run: json!({
            "fmu": exported(stage, "auv", &[]),
            "tick": 0.05,
            "inputs": {"plane_command": commands},
            "outputs": outputs,
        }),
    }
}

/// The vehicle of the built-in dive, behind planes that follow at once, with four steps in a tick.
fn of_the_plane(stage: &Stage) -> Case {
    let ticks = flown("dive", &["dha_actuator.model=ideal"], 160);
    let planes: Vec<f64> = ticks
        .iter()
        .map(|it| held(&it.actuator.motion().dive_planes))
        .collect();
    Case {
        expected: ticks.iter().map(state).collect(),
        run: json!({
            "fmu": exported(stage, "brunner", &[]),
            "tick": 0.05,
            "parts": 4,
            "inputs": {"dive_planes": planes},
            "outputs": STATE,
        }),
    }
}

/// The LAUV on its way-points: planes, rudder and thrust.
fn of_six_degrees(stage: &Stage) -> Case {
    let ticks = flown("lauv", &[], 120);
    let motion = |of: fn(&Tick) -> f64| ticks.iter().map(of).collect::<Vec<f64>>();
    Case {
        expected: ticks.iter().map(state).collect(),
        run: json!({
            "fmu": exported(stage, "lauv", &["--set", "propulsion=thrust", "--set", "speed=1.5"]),
            "tick": 0.05,
            "start": start("lauv", &["initial_depth"]),
            "inputs": {
                "dive_planes": motion(|it| held(&it.actuator.motion().dive_planes)),
                "rudder": motion(|it| held(&it.actuator.motion().rudder)),
                "thrust": motion(|it| held(&it.actuator.motion().thrust)),
            },
            "outputs": STATE,
        }),
    }
}

/// The BlueROV2 across a current: eight thrusters.
fn of_thrusters(stage: &Stage) -> Case {
    let ticks = flown("bluerov2", &[], 80);
    let mut inputs: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for command in ticks.iter().filter_map(|it| it.thrusters.as_ref()) {
        for (name, value) in command.name.iter().zip(&command.command) {
            inputs
                .entry(format!("thrusters.{name}"))
                .or_default()
                .push(*value);
        }
    }
    assert_eq!(inputs.len(), 8);
    let names = [
        "propulsion",
        "speed",
        "initial_depth",
        "environment.current.y",
    ];
    Case {
        expected: ticks.iter().map(state).collect(),
        run: json!({
            "fmu": exported(stage, "bluerov2_heavy", &[]),
            "tick": 0.05,
            "start": start("bluerov2", &names),
            "inputs": inputs,
            "outputs": STATE,
        }),
    }
}

/// An input with corners.
fn signal(count: usize, period: usize, size: f64) -> Vec<f64> {
    (0..count)
        .map(|k| size * ((k * 7 / period) % 5) as f64 - size)
        .collect()
}

/// Model files: a delay with an offset, a dead zone and an input level; one that passes its input on at once; and what `sysid fit` finds of
/// two inputs and two outputs.
fn models(stage: &Stage) -> Vec<Value> {
    let file = |name: &str, num: &[f64], den: &[f64], change: &dyn Fn(&mut ModelFile)| {
        let mut model =
            ModelFile::exact("cmd:data[0]", "imu:rate", 0.02, num.to_vec(), den.to_vec());
        change(&mut model);
        model.write(Path::new(&stage.path(name))).unwrap();
        name.to_owned()
    };
    let parameter = |name: &str, value| Parameter {
        name: name.to_owned(),
        unit: String::new(),
        value,
        deviation: 0.0,
    };
    let delayed = file(
        "delayed.json",
        &[0.0, 0.4, 0.3, -0.2],
        &[1.0, -1.2, 0.5, 0.0, 0.0],
        &|it| {
            (it.offset, it.input_level) = (3.5, 0.25);
            it.static_curve = Some(StaticCurve {
                side: Side::Input,
                kind: "dead zone".to_owned(),
                parameters: vec![parameter("lower", -0.5), parameter("upper", 0.4)],
            });
        },
    );
    let at_once = file("at_once.json", &[0.7, -0.1], &[1.0, -0.9], &|_| {});

    let mut table = "t,u1,u2,y1,y2\n".to_owned();
    let (mut y1, mut y2) = (0.0, 0.0);
    for (k, (u1, u2)) in signal(600, 23, 1.0)
        .into_iter()
        .zip(signal(600, 61, 0.5))
        .enumerate()
    {
        // Noise, without which the record determines nothing more.
        let noise = ((k * k * 7919) % 101) as f64 * 4e-4;
        let (first, second) = (y1 + 2.0 + noise, y2 - 1.0 - noise);
        table += &format!("{},{u1},{u2},{first},{second}\n", k as f64 * 0.1);
        (y1, y2) = (
            0.8 * y1 + 0.3 * u1 - 0.1 * u2,
            0.6 * y2 + 0.2 * u1 + 0.5 * u2,
        );
    }
    stage.file("two.csv", table);
    let fit = "sysid fit two.csv -i u1 -i u2 -o y1 -o y2 --order 1 --delay 1 --model two.json";
    stage.run(&fit.split(' ').collect::<Vec<_>>()).success();

    let run = |name: String, tick: f64, inputs: Value, outputs: &[&str]| {
        json!({
            "fmu": exported(stage, &name, &[]),
            "model": stage.path(&name),
            "tick": tick,
            "inputs": inputs,
            "outputs": outputs,
        })
    };
    let one = || json!({"cmd:data[0]": signal(160, 17, 0.6)});
    let two = json!({"u1": signal(160, 13, 1.0), "u2": signal(160, 29, 2.0)});
    vec![
        run(delayed, 0.02, one(), &["imu:rate"]),
        run(at_once, 0.02, one(), &["imu:rate"]),
        run("two.json".to_owned(), 0.1, two, &["y1", "y2"]),
    ]
}

#[test]
fn an_fmu_in_fmpy_moves_as_the_loop_does_and_as_scipy_computes_its_model() {
    let stage = Stage::new();
    let cases = [
        actuator(&stage),
        of_the_plane(&stage),
        of_six_degrees(&stage),
        of_thrusters(&stage),
    ];
    let models = models(&stage);
    let runs: Vec<&Value> = cases.iter().map(|it| &it.run).chain(&models).collect();
    let Some(answer) = fmpy(&json!({ "runs": runs })) else {
        return;
    };
    let answers = answer["runs"].as_array().unwrap();
    assert_eq!(answers.len(), runs.len());
    for (run, answer) in runs.iter().zip(answers) {
        // The schema, names, start values and structure; a state taken and set again.
        assert_eq!(answer["problems"], json!([]), "{}", run["fmu"]);
        assert_eq!(answer["repeats"], true, "{}", run["fmu"]);
    }
    for (case, answer) in cases.iter().zip(answers) {
        let rows = answer["outputs"].as_array().unwrap();
        assert_eq!(rows.len(), case.expected.len());
        for (k, (found, expected)) in rows.iter().zip(&case.expected).enumerate() {
            // To the last bit; the sign of a zero, and 1 for 1.0, do not count.
            let same = |(a, b): (&Value, &Value)| a == b || a.as_f64() == b.as_f64();
            let found = found.as_array().unwrap();
            assert!(
                found.iter().zip(expected).all(same),
                "{} {k}: {found:?} {expected:?}",
                case.run["fmu"]
            );
        }
    }
    for (run, answer) in models.iter().zip(&answers[cases.len()..]) {
        let numbers = |of: &str| -> Vec<f64> {
            let rows = answer[of].as_array().unwrap().iter();
            rows.flat_map(|row| {
                row.as_array()
                    .unwrap()
                    .iter()
                    .map(|it| it.as_f64().unwrap())
            })
            .collect()
        };
        let (found, expected) = (numbers("outputs"), numbers("computed"));
        assert_eq!(found.len(), expected.len());
        let largest = expected.iter().fold(0.0_f64, |most, it| most.max(it.abs()));
        assert!(largest > 1.0);
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                (found - expected).abs() < 1e-12 * largest,
                "{}: {found} {expected}",
                run["fmu"]
            );
        }
    }
    // kg, m, s, rad
    for (answer, variable, unit) in [
        (0, "plane_angle", [0, 0, 0, 1]),
        (0, "pressure", [1, -1, -2, 0]),
        (0, "volume", [0, 3, 0, 0]),
        (0, "hydraulic_power", [1, 2, -3, 0]),
        (1, "pitch_rate", [0, 0, -1, 1]),
        (1, "pitch_damping_viscous", [1, 2, 0, 0]),
        (1, "environment.density", [1, -3, 0, 0]),
    ] {
        assert_eq!(
            answers[answer]["units"][variable],
            json!(unit),
            "{variable}"
        );
    }
}

/// A built-in file with some words of it changed, and its FMU; the words stand there once.
fn edited(stage: &Stage, name: &str, text: &str, words: &[(&str, &str)]) -> String {
    let mut text = text.to_owned();
    for (from, to) in words {
        assert_eq!(text.matches(from).count(), 1, "{from}");
        text = text.replace(from, to);
    }
    let file = format!("edited_{name}.yaml");
    stage.file(&file, text);
    exported(stage, &file, &[])
}

/// A run of a built-in subject with parameters set, beside one of its file edited by hand.
fn both_ways(
    stage: &Stage,
    (name, text): (&str, &str),
    words: &[(&str, &str)],
    start: Value,
    (inputs, outputs): (Value, &[&str]),
) -> [Value; 2] {
    let by_hand = edited(stage, name, text, words);
    let run = |fmu: String, start: Value| json!({"fmu": fmu, "tick": 0.05, "start": start, "inputs": inputs, "outputs": outputs});
    [
        run(exported(stage, name, &[]), start),
        run(by_hand, json!({})),
    ]
}

#[test]
fn a_number_of_the_file_set_as_a_parameter_is_the_file_edited() {
    let stage = Stage::new();
    let actuator = |name| {
        let mut all = planesman_hydraulics::actuator_file::built_in();
        all.find(|it| it.0 == name).unwrap()
    };
    let vehicle = |name| planesman_vehicle::vehicle_file::text(name).unwrap();
    let angles = signal(60, 11, 0.2);
    let pairs = [
        both_ways(
            &stage,
            actuator("dfcu"),
            &[
                ("mass: 120 kg", "mass: 150 kg"),
                ("A: {area: 8.04 cm^2", "A: {area: 8.1 cm^2"),
                (
                    "P-A: {coding: pcm, count: 5, flow: 12 L/min}",
                    "P-A: {coding: pcm, count: 4, flow: 16 L/min}",
                ),
                ("gain: 6", "gain: 4.5"),
            ],
            json!({
                "load.mass": 150.0,
                "chambers.A.area": 8.1 / 1e4,
                "edges.P-A.count": 4,
                "edges.P-A.flow": 16.0 / 6e4,
                "control.gain": 4.5,
            }),
            (
                json!({"plane_command": angles, "load_force": signal(60, 7, 800.0)}),
                &["ram", "p_A", "p_B", "pulses", "energy_supply"],
            ),
        ),
        both_ways(
            &stage,
            actuator("auv"),
            &[
                ("supply: 150 psi", "supply: 160 psi"),
                ("mass: 0.002 lb s^2/in ", "mass: 0.5 kg "),
            ],
            json!({"oil.supply": 160.0 * planesman_units::PSI, "load.mass": 0.5}),
            (
                json!({"plane_command": angles}),
                &["ram", "pressure", "pulses"],
            ),
        ),
        both_ways(
            &stage,
            ("brunner", &vehicle("brunner")),
            &[
                ("restoring_arm: 0.1 in", "restoring_arm: 5 mm"),
                ("z_w: -1.295", "z_w: -1.5"),
            ],
            json!({"particulars.restoring_arm": 0.005, "coefficients.z_w": -1.5}),
            (json!({"dive_planes": angles}), &STATE),
        ),
        both_ways(
            &stage,
            ("lauv", &vehicle("lauv")),
            &[
                ("xx: 0.0405 kg m^2", "xx: 0.06 kg m^2"),
                ("added_mass: [1, 16,", "added_mass: [1.5, 16,"),
                ("Z_uuds: -19.2", "Z_uuds: -25"),
                ("[0 m, 0 m, 0.01 m]", "[0 m, 0 m, 20 mm]"),
            ],
            json!({
                "inertia.xx": 0.06,
                "added_mass[0]": 1.5,
                "coefficients.values.Z_uuds": -25.0,
                "centre_of_gravity[2]": 0.02,
            }),
            (
                json!({"dive_planes": angles, "rudder": signal(60, 13, 0.3)}),
                &STATE,
            ),
        ),
    ];
    // A ram between closed valves, under a force that jumps within the controller's periods of 20 ms.
    let options = ["--step", "13ms", "--set", "control.dead_zone=1m"];
    let ram = [&["export", "--fmi", "dfcu", "-o", "ram.fmu"], &options[..]].concat();
    stage.run(&ram).success();
    let ram = json!({
        "fmu": stage.path("ram.fmu"),
        "tick": 0.013,
        "start": {"load.coulomb": 0.0, "chambers.B.volume": 0.25e-3},
        "inputs": {"plane_command": vec![0.0; 60], "load_force": signal(60, 9, 600.0)},
        "outputs": ["ram", "ram_velocity", "p_A", "p_B"],
        "ram": {
            "mass": 120.0, "viscous": 900.0, "A": [8.04e-4, 0.3e-3], "B": [4.9e-4, 0.25e-3],
            "P": 10e6, "T": 0.3e6, "bulk_modulus": 1.4e9, "air": 0.005, "polytropic": 1.4,
        },
    });
    let fmu = |of: usize| pairs[of][0]["fmu"].clone();
    let refused = json!([
        {"fmu": fmu(0), "name": "load.mass", "value": -3.0, "then": 100.0},
        {"fmu": fmu(0), "name": "edges.P-A.count", "value": 9, "then": 8},
        {"fmu": fmu(1), "name": "oil.return", "value": 2e6, "then": 1e5},
        {"fmu": fmu(2), "name": "coefficients.z_w", "value": 1.0, "then": -1.0},
        {"fmu": fmu(3), "name": "inertia.xx", "value": -1.0, "then": 0.05},
    ]);
    let runs: Vec<&Value> = pairs.iter().flatten().chain([&ram]).collect();
    let Some(answer) = fmpy(&json!({"runs": runs, "refused": refused})) else {
        return;
    };
    let answers = answer["runs"].as_array().unwrap();
    for (run, answer) in runs.iter().zip(answers) {
        assert_eq!(answer["problems"], json!([]), "{}", run["fmu"]);
        assert_eq!(answer["repeats"], true, "{}", run["fmu"]);
    }
    for pair in answers[..8].chunks(2) {
        // To the last bit, and the number does something.
        assert_eq!(pair[0]["outputs"], pair[1]["outputs"]);
        assert_ne!(pair[0]["constants"], pair[1]["constants"]);
    }
    let (found, expected) = (&answers[8]["outputs"], &answers[8]["computed"]);
    let row = |of: &Value, k: usize| -> [f64; 4] { serde_json::from_value(of[k].clone()).unwrap() };
    for k in 0..60 {
        let scales = [1e-3, 0.1, 1e6, 1e6];
        for ((found, expected), scale) in row(found, k).iter().zip(row(expected, k)).zip(scales) {
            let error = (found - expected).abs() / scale;
            assert!(error < 1e-6, "{k}: {found} for {expected}");
        }
    }
    // In SI, as a hand computes them.
    for (of, name, kind, unit, value) in [
        (0, "load.mass", "Float64", Some("kg"), 120.0),
        (0, "chambers.A.area", "Float64", Some("m^2"), 8.04e-4),
        (0, "edges.P-A.flow", "Float64", Some("m^3/s"), 2e-4),
        (0, "edges.P-A.count", "Int64", None, 5.0),
        (0, "control.gain", "Float64", None, 6.0),
        (0, "valves.rated_life", "Float64", None, 1e8),
        (2, "oil.supply", "Float64", Some("Pa"), 1_034_213.593_975),
        (2, "logic.limit_option", "Int64", None, 1.0),
        (4, "depth_port.forward", "Float64", Some("m"), 0.0127),
        (6, "quadratic_damping[5][5]", "Float64", None, 9.1),
        (6, "propulsion[0].limits[1]", "Float64", Some("N"), 14.0),
    ] {
        let found = &answers[of]["constants"][name];
        assert_eq!(
            (&found[0], &found[1]),
            (&kind.into(), &unit.into()),
            "{name}"
        );
        let start = found[2].as_f64().unwrap();
        assert!((start / value - 1.0).abs() < 1e-12, "{name}: {start}");
    }
    let none = &answers[4]["constants"]["geometry.hull.length"];
    assert_eq!(*none, Value::Null, "nothing reads it");
    let said = [
        "load.mass: -3.0 kg refused",
        "edges.P-A.count: 9 refused: it must be from 1 to 8",
        "oil.return: 2000000.0 Pa refused: it must be below oil.supply",
        "coefficients.z_w: 1 refused",
        "inertia.xx: -1.0 kg m^2 refused",
    ];
    for (answer, said) in answer["refused"].as_array().unwrap().iter().zip(said) {
        // fmi3Discard, and its message.
        assert_eq!(answer[0], 2, "{said}");
        let messages = answer[1].as_array().unwrap();
        assert_eq!(messages.len(), 1, "{messages:?}");
        assert!(messages[0].as_str().unwrap().contains(said), "{messages:?}");
    }
}

#[test]
fn an_fmu_refuses_what_no_importer_should_do_and_goes_on() {
    let stage = Stage::new();
    let fmus = ["auv", "brunner"].map(|name| exported(&stage, name, &[]));
    let Some(answer) = fmpy(&json!({ "garbage": fmus })) else {
        return;
    };
    for answer in answer["garbage"].as_array().unwrap() {
        let statuses = answer["statuses"].as_object().unwrap();
        assert!(statuses.len() >= 23);
        for (call, status) in statuses {
            let expected = match call.as_str() {
                // fmi3Discard: another value would be taken. Else fmi3Error.
                "NaN as an input" | "infinity as an input" => 2,
                _ => 3,
            };
            assert_eq!(*status, expected, "{call}");
        }
        // Every refusal but that of no instance has its message; one more is among the right calls.
        assert_eq!(answer["messages"], statuses.len());
        assert_eq!(answer["right"], json!([0, 0, 0]));
        assert_eq!(answer["instantiated"], json!([]));
    }
}
