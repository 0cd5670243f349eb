//! Circuits of on/off valves: designs over a load cycle, planes that they move, files that are refused.

use planesman_circuit::{LoadCycle, Point, file, run};
use planesman_testing::content;
use serde_json::Value;

use crate::stage::Stage;

const CYCLE: &str =
    "time,position,force\n0,-0.1,500\n1,0.1,500\n1.5,0.1,2000\n2.5,-0.1,500\n3,-0.1,500\n";

#[test]
fn designs_are_compared_over_a_load_cycle_and_none_on_the_front_is_beaten() {
    let stage = Stage::new();
    let (cycle, page) = (stage.file("cycle.csv", CYCLE), stage.path("designs.html"));
    let outcome = stage
        .run(&[
            "dha",
            "design",
            "dfcu",
            "--load-cycle",
            &cycle,
            "--valves",
            "4,5",
            "--all",
            "--format",
            "json",
            "--html",
            &page,
        ])
        .success();
    let rows: Vec<Value> = serde_json::from_str(&outcome.stdout).unwrap();
    // The file's own are five binary valves by the model: they stand there once.
    assert_eq!(rows.len(), 18);
    let number = |row: &Value, name: &str| {
        row[name]
            .as_str()
            .unwrap_or_default()
            .parse::<f64>()
            .or(row[name].as_f64().ok_or(()))
            .unwrap()
    };
    let names = [
        "energy, J",
        "tracking, mm",
        "peak, MPa",
        "switchings/h",
        "life, h",
    ];
    let figures: Vec<[f64; 5]> = rows
        .iter()
        .map(|row| names.map(|name| number(row, name)))
        .collect();
    let beaten = |one: &[f64; 5]| {
        figures.iter().any(|other| {
            let better = |place: usize| {
                if place == 4 {
                    other[4] >= one[4]
                } else {
                    other[place] <= one[place]
                }
            };
            (0..5).all(better) && other != one
        })
    };
    for (row, figures) in rows.iter().zip(&figures) {
        // Printed figures are rounded, and two may be the same so.
        assert!(row["not beaten"] != "yes" || !beaten(figures), "{row}");
    }
    let own = rows
        .iter()
        .find(|row| row["design"] == "valves as in the file, model")
        .unwrap();
    let point = |time, position, force| Point {
        time,
        position,
        force,
    };
    let points = vec![
        point(0.0, -0.1, 500.0),
        point(1.0, 0.1, 500.0),
        point(1.5, 0.1, 2000.0),
        point(2.5, -0.1, 500.0),
        point(3.0, -0.1, 500.0),
    ];
    let circuit = file::parse(file::BUILT_IN[0].1).unwrap();
    // Its energy by the volumes that left the levels, over the chambers' own volumes: the supply's pressure times what the ram swept, at least.
    let expected = run(
        &circuit.into(),
        &LoadCycle::new(points).unwrap(),
        1e-9,
        1,
        |_, _| (),
    );
    assert!((number(own, "energy, J") / expected.energy - 1.0).abs() < 1e-3);
    let page = std::fs::read_to_string(page).unwrap();
    for part in [
        "Energy and tracking",
        "Where its energy goes",
        "throttling P-A",
        "error of the energy balance",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!content(&page).contains("NaN"));
}

#[test]
fn designs_behind_lines_tell_the_pressures_at_the_valves_and_what_the_lines_hold() {
    let stage = Stage::new();
    let lines = "lines: {P: {length: 3 m, diameter: 12 mm}, T: {length: 2 m, diameter: 12 mm}}\noil:\n  viscosity: 46 mm^2/s\n";
    let circuit = stage.file("lines.yaml", file::BUILT_IN[0].1.replace("oil:\n", lines));
    let cycle = stage.file("cycle.csv", CYCLE);
    let mut arguments = vec!["dha", "design", &circuit, "--load-cycle", &cycle];
    arguments.extend([
        "--codings",
        "pcm",
        "--valves",
        "5",
        "--controllers",
        "model",
    ]);
    arguments.extend(["--seeds", "1", "--format", "md", "--verbose"]);
    let designs = stage.run(&arguments).success().stdout;
    for part in [
        "At the valves' end of the lines the oil pressure ranges from -",
        "| stored in the lines |",
        "| friction in the lines |",
    ] {
        assert!(designs.contains(part), "{part}: {designs}");
    }
}

#[test]
fn a_scenario_is_a_load_cycle_and_a_circuit_moves_its_planes() {
    let stage = Stage::new();
    let designs = stage
        .run(&[
            "dha",
            "design",
            "dfcu",
            "--load-cycle",
            "open_loop",
            "--codings",
            "pcm",
            "--valves",
            "5",
            "--controllers",
            "nearest",
            "--format",
            "csv",
        ])
        .success();
    assert_eq!(designs.stdout.lines().count(), 3, "{}", designs.stdout);
    let table = stage.path("dive.csv");
    stage
        .run(&[
            "sim",
            "dive",
            "--set",
            "dha_actuator.actuator=dfcu",
            "--set",
            "plant_sim.duration=40",
            "--out",
            &table,
        ])
        .success();
    let text = std::fs::read_to_string(table).unwrap();
    let last: Vec<&str> = text.lines().last().unwrap().split(',').collect();
    let column = text
        .lines()
        .next()
        .unwrap()
        .split(',')
        .position(|it| it == "depth [m]")
        .unwrap();
    let depth: f64 = last[column].parse().unwrap();
    assert!((depth - 0.9144).abs() < 0.05, "{depth}");
}

#[test]
fn what_is_no_circuit_and_no_load_cycle_is_refused() {
    let stage = Stage::new();
    let text = file::BUILT_IN[0].1;
    let bad = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        stage.file("bad.yaml", text.replacen(from, to, 1))
    };
    for (from, to, said) in [
        (
            "count: 5",
            "count: 1000000",
            "edges.P-A.count: 1000000 refused: it must be from 1 to 8",
        ),
        (
            "bulk_modulus: 1.4 GPa",
            "bulk_modulus: 0 GPa",
            "oil.bulk_modulus: 0 GPa refused",
        ),
        ("air: 0.005", "air: .nan", "oil.air: NaN refused"),
        (
            "volume: 0.30 L",
            "volume: 0.01 L",
            "chambers.A.volume: 0.01 L refused: the volume at mid-stroke must be more than 1.01 times the product of area and travel",
        ),
    ] {
        let file = bad(from, to);
        let outcome = stage.run(&[
            "sim",
            "dive",
            "--set",
            &format!("dha_actuator.actuator={file}"),
            "--out",
            &stage.path("x.csv"),
        ]);
        assert!(
            outcome.status.code() == Some(1) && outcome.stderr.contains(said),
            "{}",
            outcome.stderr
        );
    }
    let fault = [
        "sim",
        "dive",
        "--set",
        "dha_actuator.actuator=dfcu",
        "--set",
        "dha_actuator.fault.air=0.5",
        "--out",
        &stage.path("y.csv"),
    ];
    assert!(stage.run(&fault).stderr.contains(
        "is a circuit of on/off valves, which has leakage, friction and supply in its own file"
    ));
    assert!(
        stage
            .run(&["dha", "size", "dfcu"])
            .stderr
            .contains("planesman dha design dfcu")
    );
    assert!(
        stage
            .run(&["dha", "design", "auv", "--load-cycle", "dive"])
            .stderr
            .contains("planesman dha size auv")
    );
    for (cycle, said) in [
        (
            "time,position\n0,0\n1,0.3\n",
            "point 2 of the load cycle, 0.3 m, is beyond the ram's travel of +-0.25 m",
        ),
        (
            "time,position\n0,0\n1,nan\n2,0\n",
            "point 2 of the load cycle has a number that is not finite",
        ),
        (
            "time,speed\n0,0\n1,0.3\n",
            "unknown column 'speed'; known: time, position, force",
        ),
        (
            "time,position,load\n0,0,1\n1,0.1,1\n",
            "unknown column 'load'; known: time, position, force",
        ),
        (
            "time,position,position [mm]\n0,0,0\n1,0.1,100\n",
            "columns 'position' and 'position [mm]' both contain the position",
        ),
        (
            "time,position,force_stone\n0,0,1\n1,0.1,1\n",
            "column 'force_stone'",
        ),
        (
            "time,position\n0,0\n",
            "a load cycle needs at least two points",
        ),
    ] {
        let file = stage.file("cycle.csv", cycle);
        let outcome = stage.run(&["dha", "design", "dfcu", "--load-cycle", &file]);
        assert!(
            outcome.status.code() == Some(1) && outcome.stderr.contains(said),
            "{cycle}: {}",
            outcome.stderr
        );
    }
}

#[test]
fn a_load_cycle_says_its_units_and_a_design_that_does_not_follow_is_not_on_the_front() {
    let stage = Stage::new();
    let design = |file: &str, cycle: &str| {
        let cycle = stage.file("cycle.csv", cycle);
        let of = "--valves 5 --codings pnm --controllers nearest --seeds 1 --all --format csv";
        let mut words = vec!["dha", "design", file, "--load-cycle", &cycle];
        words.extend(of.split(' '));
        stage.run(&words).success().stdout
    };
    let in_other_units = "time [ms],Position_mm,force [kN]\n0,-100,.5\n1000,100,.5\n1500,100,2\n2500,-100,.5\n3000,-100,.5\n";
    assert_eq!(design("dfcu", CYCLE), design("dfcu", in_other_units));
    // For whom each switching is too dear.
    let lazy = file::BUILT_IN[0]
        .1
        .replace("switching_cost: 0.002", "switching_cost: 1");
    let lazy = stage.file("lazy.yaml", lazy);
    let table = design(&lazy, CYCLE);
    assert!(table.contains("does not follow"), "{table}");
    let rests = design("dfcu", "time,position\n0,0\n3,0\n");
    assert!(!rests.contains("NaN") && !rests.contains("inf"), "{rests}");
    assert!(rests.contains(",-,"), "{rests}");
}
