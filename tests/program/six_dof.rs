//! `planesman six-dof`: flights and steady turns, against values of an independent integration (crates/vehicle/tests/six_dof/values.json).

use std::process::{Command, Output};

fn six_dof(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_planesman"))
        .arg("six-dof")
        .args(args)
        .output()
        .unwrap()
}

fn printed(args: &[&str]) -> String {
    let output = six_dof(args);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_steady_turn_is_found_and_a_flight_with_its_inputs_goes_over_into_it() {
    // lauv.steady.+10: the source counts the rudder to port.
    let turn = printed(&[
        "turn",
        "lauv",
        "--input",
        "thrust=9",
        "--input",
        "rudder=-10deg",
    ]);
    for line in [
        "speed       1.41824 m/s",
        "heading     -12.8790 deg/s",
        "radius      6.309 m",
        "stern_planes -0.01064",
    ] {
        assert!(turn.contains(line), "{turn}");
    }
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("turn.csv");
    let inputs = [
        "thrust=9N",
        "stern_planes=-0.01064255114",
        "rudder=-10deg@1",
    ];
    let mut args = vec![
        "fly",
        "lauv",
        "--speed",
        "1.5",
        "--forces",
        "--out",
        file.to_str().unwrap(),
    ];
    inputs
        .iter()
        .for_each(|input| args.extend(["--input", input]));
    let flight = printed(&args);
    let error: f64 = flight
        .split("integration error ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    assert!(error > 0.0 && error < 1e-6, "{flight}");
    let table = std::fs::read_to_string(&file).unwrap();
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|row| row.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    assert_eq!((rows.len(), rows[0].len()), (601, 13 + 3 + 48));
    let last = &rows[600];
    assert!((last[12] + 0.2246574525).abs() < 1e-5, "{last:?}");
    assert_eq!(last[13..16], [-10_f64.to_radians(), -0.01064255114, 9.0]);
    // The whole right-hand side, by its parts: a steady turn accelerates nowhere, and M nu' of each row is nearly 0.
    for row in 0..6 {
        let sum: f64 = (0..8).map(|part| last[16 + 6 * part + row]).sum();
        assert!(sum.abs() < 1e-3, "{row} {sum}");
    }
}

#[test]
fn what_cannot_be_flown_is_refused_in_one_line() {
    for (args, expected) in [
        (
            &["fly", "nowhere.yaml"][..],
            "built in with six degrees of freedom are",
        ),
        (
            &["fly", "lauv", "--input", "ruder=1"],
            "the inputs of 'lauv' are rudder, stern_planes, thrust",
        ),
        (&["fly", "lauv", "--input", "rudder"], "NAME=VALUE"),
        (&["fly", "lauv", "--input", "rudder=5furlong"], "NAME=VALUE"),
        (&["fly", "lauv", "--current", "1,2"], "three numbers"),
        (
            &["fly", "lauv", "--wave", "1,0,0"],
            "the period must be above zero",
        ),
        (
            &["turn", "lauv", "--hold", "bow_planes"],
            "--hold bow_planes",
        ),
        (&["turn", "lauv", "--input", "rudder=5deg@3"], "no @SECONDS"),
        (&["turn", "lauv"], "no steady turn"),
    ] {
        let output = six_dof(args);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            !output.status.success() && said.contains(expected),
            "{args:?}: {said}"
        );
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
}

#[test]
fn a_torpedo_of_a_shape_is_flown_in_the_loop_and_a_shape_that_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.yaml");
    let out = folder.path().join("mine.csv");
    let (file, out) = (file.to_str().unwrap(), out.to_str().unwrap());
    let made = six_dof(&[
        "torpedo",
        "--length",
        "1.6m",
        "--diameter",
        "0.2m",
        "--out",
        file,
    ]);
    assert!(made.status.success(), "{made:?}");
    let vehicle = format!("plant_sim.vehicle={file}");
    let flown = Command::new(env!("CARGO_BIN_EXE_planesman"))
        .args(["sim", "lauv", "--set", &vehicle, "--out", out])
        .output()
        .unwrap();
    assert!(flown.status.success(), "{flown:?}");
    let refused = six_dof(&["torpedo", "--length", "1m", "--diameter", "0.5m"]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(said.contains("length over diameter: 2 refused"), "{said}");
}
