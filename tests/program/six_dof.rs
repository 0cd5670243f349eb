//! `planesman six-dof`: flights and steady turns, against values of an independent integration (crates/vehicle/vehicle/tests/vehicle/six_dof/values.json).

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
        "yaw rate    -12.8790 deg/s",
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
            "built-in vehicles with six degrees of freedom: ",
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
        (
            &["turn", "lauv", "--input", "rudder=5deg@3"],
            "Leave out @SECONDS",
        ),
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

/// A flight of `lauv` with rudder, planes and thrust in motion, in a current, with white noise on each signal and a bias of the yaw rate.
fn recorded(folder: &std::path::Path) -> String {
    let (clean, noisy) = (folder.join("clean.csv"), folder.join("noisy.csv"));
    let mut args: Vec<String> =
        "fly lauv --speed 1.4 --duration 40 --tick 0.2 --current 0.1,-0.05,0"
            .split(' ')
            .map(str::to_owned)
            .collect();
    for input in [
        "thrust=9",
        "thrust=5@13.8",
        "thrust=12@26",
        "rudder=8deg@3",
        "rudder=-9deg@8.2",
        "rudder=4deg@15",
        "rudder=-6deg@22",
        "rudder=0@31",
        "stern_planes=4deg@5",
        "stern_planes=-4deg@11.4",
        "stern_planes=3deg@19",
        "stern_planes=-3deg@28",
    ] {
        args.extend(["--input".to_owned(), input.to_owned()]);
    }
    args.extend(["--out".to_owned(), clean.to_str().unwrap().to_owned()]);
    printed(&args.iter().map(String::as_str).collect::<Vec<_>>());
    let noise = [
        0.05, 0.05, 0.02, 0.005, 0.005, 0.01, 0.02, 0.02, 0.02, 0.003, 0.003, 0.003,
    ];
    let mut random = rand_pcg::Pcg64::new(7, 11);
    let text = std::fs::read_to_string(&clean).unwrap();
    let mut lines = text.lines();
    let mut made = lines.next().unwrap().to_owned() + "\n";
    for line in lines {
        let mut row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        for (x, size) in row[1..].iter_mut().zip(noise) {
            *x += size * planesman_vehicle::standard_normal(&mut random);
        }
        row[12] += 0.002;
        let row: Vec<String> = row.iter().map(f64::to_string).collect();
        made += &(row.join(",") + "\n");
    }
    std::fs::write(&noisy, made).unwrap();
    noisy.to_str().unwrap().to_owned()
}

#[test]
fn a_vehicle_is_found_in_a_recording_with_intervals_that_hold_it_and_its_file_flies() {
    let folder = tempfile::tempdir().unwrap();
    let noisy = recorded(folder.path());
    // The vehicle to begin with is another.
    let other = folder.path().join("other.yaml");
    let text = include_str!("../../crates/vehicle/vehicle/vehicles/six_dof/lauv.yaml");
    let text = text.replace("N_uv: 10.98880392257711", "N_uv: 8");
    std::fs::write(&other, text.replace("N_uudr: -7.68", "N_uudr: -9")).unwrap();
    let mine = folder.path().join("mine.yaml");
    let args = |more: &[&'static str]| -> Vec<String> {
        let paths = [noisy.as_str(), "--like", other.to_str().unwrap()];
        let all = ["fit"].into_iter().chain(paths).chain(more.iter().copied());
        all.map(str::to_owned).collect()
    };
    let mut fit = args(&["--quiet", "--json", "--horizon", "20", "--free"]);
    fit.push("N_uv,N_ur,N_uudr,linear_damping_66,quadratic_damping_26".to_owned());
    fit.extend(["-o".to_owned(), mine.to_str().unwrap().to_owned()]);
    let fit = printed(&fit.iter().map(String::as_str).collect::<Vec<_>>());
    let fit: serde_json::Value = serde_json::from_str(&fit).unwrap();
    let number = |of: &serde_json::Value, key: &str| of[key].as_f64().unwrap();
    let found = |list: &str, name: &str| {
        let all = fit[list].as_array().unwrap();
        all.iter().find(|it| it["name"] == name).unwrap().clone()
    };
    for (list, name, truth) in [
        ("numbers", "N_uv", 10.98880392257711),
        ("numbers", "N_ur", -3.072),
        ("numbers", "N_uudr", -7.68),
        ("numbers", "linear_damping_66", 9.7),
        ("current", "north", 0.1),
        ("current", "east", -0.05),
        ("biases", "r", 0.002),
        ("biases", "u", 0.0),
    ] {
        let it = found(list, name);
        let (value, interval) = (number(&it, "value"), number(&it, "interval"));
        // Twice half the 95 % interval is 3.9 standard deviations.
        assert!((value - truth).abs() < 2.0 * interval, "{name} {it}");
        let size = if list == "numbers" { truth.abs() } else { 0.02 };
        assert!(interval < 0.5 * size, "{name} {it}");
    }
    let noise: Vec<(String, f64)> = serde_json::from_value(fit["noise"].clone()).unwrap();
    for (name, truth) in [("north", 0.05), ("pitch", 0.005), ("r", 0.003)] {
        let of = noise.iter().find(|it| it.0 == name).unwrap().1;
        assert!((of / truth - 1.0).abs() < 0.15, "{name} {of}");
    }
    let undetermined = fit["undetermined"].as_array().unwrap();
    assert_eq!(undetermined.len(), 1, "{undetermined:?}");
    assert_eq!(undetermined[0]["name"], "quadratic_damping_26");
    // Beforehand 98 % is known.
    assert!((0.9..1.05).contains(&number(&undetermined[0], "before")));
    let largest = fit["next"]["largest"].as_array().unwrap();
    assert!(
        largest[1][1].as_f64() < largest[0][1].as_f64(),
        "{largest:?}"
    );
    for signal in fit["held_out"]["signals"].as_array().unwrap() {
        let [fitted, like] = [1, 2].map(|it| signal[it].as_f64().unwrap());
        assert!(fitted < 1.2 * like, "{signal}");
        assert!(signal[0] != "r" || fitted < 0.7 * like, "{signal}");
    }
    // Units, sources and what was not sought stand as they did.
    let written = std::fs::read_to_string(&mine).unwrap();
    for line in [
        "name: mine",
        "mass: 18 kg",
        "    M_uw: -10.98880392257711",
        "# fitted, N_uv: 95 % +-",
        "quadratic_damping_26: not determined by the data",
    ] {
        assert!(written.contains(line), "{line}: {written}");
    }
    printed(&["fly", mine.to_str().unwrap(), "--input", "thrust=9"]);
    for (more, said) in [
        (
            &["--free", "N_uw"][..],
            "--free N_uw: no such name; known: buoyancy",
        ),
        (
            &[
                "--fixed",
                "added_mass,linear_damping,quadratic_damping,coefficients",
            ],
            "no number is estimated",
        ),
        (
            &["--bias", "heave"],
            "--bias heave: no such name; known: north",
        ),
        (
            &["--signal", "ruder=x"],
            "--signal ruder=x: no such name; known: rudder",
        ),
        (&["--signal", "u=x"], "x"),
        (&["--window", "0..1"], "samples for"),
    ] {
        let args = args(more);
        let output = six_dof(&args.iter().map(String::as_str).collect::<Vec<_>>());
        let all = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            !output.status.success() && all.contains(said),
            "{more:?}: {all}"
        );
    }
}

#[test]
fn an_exported_vehicle_is_checked_and_a_reversed_sign_ends_with_status_1() {
    let folder = tempfile::tempdir().unwrap();
    for (flag, file) in [
        ("--gz", "a.sdf"),
        ("--stonefish", "a.scn"),
        ("--dave", "a.urdf"),
    ] {
        let path = folder.path().join(file);
        let path = path.to_str().unwrap();
        let output = six_dof(&["export", "lauv", flag, "--out", path]);
        assert!(output.status.success(), "{output:?}");
        let omitted = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(omitted.contains("Y_uu rudder"), "{omitted}");
        let checked = printed(&["check", path]);
        assert!(checked.starts_with("Physical: nothing found"), "{checked}");
        assert!(
            checked.contains("mass                18.0000 kg"),
            "{checked}"
        );
    }
    let sdf = printed(&["export", "lauv", "--gz"]);
    assert!(
        sdf.contains("<yy>16</yy>") && sdf.contains("<yV>-23</yV>"),
        "{sdf}"
    );
    let wrong = folder.path().join("wrong.sdf");
    std::fs::write(&wrong, sdf.replace("<yV>-23</yV>", "<yV>23</yV>")).unwrap();
    let wrong = wrong.to_str().unwrap();
    let output = six_dof(&["check", wrong]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        said.starts_with(
            "Not physical: 1 finding\n- yV is 23: linear damping must be 0 or negative"
        ),
        "{said}"
    );
    let json = six_dof(&["check", wrong, "--json"]);
    assert_eq!(json.status.code(), Some(1));
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["physical"], false);
    assert_eq!(json["findings"][0]["code"], "damping_sign");
    assert_eq!(json["findings"][0]["entries"][0]["name"], "yV");
    for name in ["bluerov2_heavy", "lauv", "remus_100_6dof"] {
        assert!(printed(&["check", name]).starts_with("Physical: nothing found\n"));
    }
    // A vehicle file: its loader refuses more.
    let text = include_str!("../../crates/vehicle/vehicle/vehicles/six_dof/lauv.yaml");
    let mine = folder.path().join("mine.yaml");
    std::fs::write(
        &mine,
        text.replace("added_mass: [1, 16", "added_mass: [1, -16"),
    )
    .unwrap();
    let output = six_dof(&["check", mine.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        said.starts_with("Not physical: 1 finding\n- added_mass: -16"),
        "{said}"
    );
    let output = six_dof(&["export", "lauv"]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
}

/// Columns of a table by name, without units.
fn columns(path: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let head = lines.next().unwrap().split(',');
    let head = head.map(|it| it.split(" [").next().unwrap().to_owned());
    let row = |line: &str| line.split(',').map(|it| it.parse().unwrap()).collect();
    (head.collect(), lines.map(row).collect())
}

/// A real vehicle that is hardly like the built-in one, in what real logs have shown: six tenths of the thrust, thrusters that push through the
/// origin, twice the righting moment, commands that act 0.2 s late, a full roll.
#[test]
fn a_record_as_of_a_real_vehicle_gives_its_numbers_per_newton_and_its_delay() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let own = include_str!("../../crates/vehicle/vehicle/vehicles/six_dof/bluerov2_heavy.yaml");
    let truth = own
        .replace("0.085 m]", "0 m]")
        .replace(
            "centre_of_gravity: [0 m, 0 m, 0 m]",
            "centre_of_gravity: [0 m, 0 m, 0.01 m]",
        )
        .replace(
            "[8.9, 176.0, -404.1, 389.9, -140.3]",
            "[5.34, 105.6, -242.46, 233.94, -84.18]",
        )
        .replace(
            "[13.7, 0, 33.0, 0, 0.8, 0]",
            "[13.7, 6, 33.0, 0.4, 0.8, 0.5]",
        );
    std::fs::write(at("truth.yaml"), truth).unwrap();
    let (vehicle, run) = (at("truth.yaml"), at("run.csv"));
    let mut arguments = ["fly", &vehicle, "--duration", "150", "--out", &run]
        .map(str::to_owned)
        .to_vec();
    let noise = planesman_identification::noise(7, 12 * 1501 + 400);
    let mut normal = noise.into_iter();
    // Surge, sway, yaw, heave, roll, pitch, each to one side, none, or to the other.
    let names = [
        ("front_starboard", [1.0, -1.0, -0.5, 0.0, 0.0, 0.0]),
        ("front_port", [1.0, 1.0, 0.5, 0.0, 0.0, 0.0]),
        ("rear_starboard", [-1.0, -1.0, 0.5, 0.0, 0.0, 0.0]),
        ("rear_port", [-1.0, 1.0, -0.5, 0.0, 0.0, 0.0]),
        ("vertical_front_starboard", [0.0, 0.0, 0.0, -1.0, 0.5, 0.5]),
        ("vertical_front_port", [0.0, 0.0, 0.0, -1.0, -0.5, 0.5]),
        ("vertical_rear_starboard", [0.0, 0.0, 0.0, -1.0, 0.5, -0.5]),
        ("vertical_rear_port", [0.0, 0.0, 0.0, -1.0, -0.5, -0.5]),
    ];
    for step in 1..50 {
        let wanted: [f64; 6] =
            std::array::from_fn(|_| 0.3 * normal.next().unwrap().clamp(-1.4, 1.4).round());
        for (name, mix) in names {
            let command: f64 = mix.iter().zip(wanted).map(|(m, w)| m * w).sum();
            let command = command.clamp(-0.6, 0.6);
            arguments.push("--input".to_owned());
            arguments.push(format!("{name}={command:.3}@{}", 3 * step));
        }
    }
    printed(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    let (head, rows) = columns(&run);
    let mut text = head.join(",") + "\n";
    for (k, row) in rows.iter().enumerate() {
        let cell = |(column, value): (usize, &f64)| {
            let value = match column {
                0 => *value,
                1..=12 => value + normal.next().unwrap() * if column > 9 { 0.02 } else { 0.01 },
                // The commands, two rows early.
                _ => rows[(k + 2).min(rows.len() - 1)][column],
            };
            value.to_string()
        };
        let cells: Vec<String> = row.iter().enumerate().map(cell).collect();
        text += &(cells.join(",") + "\n");
    }
    std::fs::write(at("log.csv"), text).unwrap();
    let log = at("log.csv");
    let fit = ["fit", &log, "--real", "--like", "bluerov2_heavy", "--json"];
    let found: serde_json::Value = serde_json::from_str(&printed(&fit)).unwrap();
    let value = |list: &str, name: &str| {
        let all = found[list].as_array().unwrap().iter();
        let it = all.clone().find(|it| it["name"] == name).unwrap();
        it["value"].as_f64().unwrap()
    };
    let near = |list: &str, name: &str, expected: f64, within: f64| {
        let found = value(list, name);
        assert!(
            (found - expected).abs() < within,
            "{name}: {found}, not {expected}"
        );
    };
    near("delays", "all", 0.2, 0.01);
    near("numbers", "thrust_centre_z", -0.085, 0.003);
    // Per newton of a thrust of which six tenths are there: mass, damping and righting moment are larger by 1/0.6.
    near("numbers", "added_mass_11", (13.5 + 6.36) / 0.6 - 13.5, 0.6);
    near(
        "numbers",
        "added_mass_66",
        (0.37 + 0.222) / 0.6 - 0.37,
        0.03,
    );
    near("numbers", "linear_damping_44", 0.4 / 0.6, 0.1);
    let righting =
        132.57 * value("numbers", "centre_of_gravity_z") + 0.01 * value("numbers", "buoyancy");
    let expected = (132.57 * 0.01 + 131.588 * 0.01) / 0.6;
    assert!(
        (righting / expected - 1.0).abs() < 0.03,
        "{righting} {expected}"
    );
    assert_eq!(
        found["resets"].as_array().unwrap().len(),
        0,
        "{}",
        found["resets"]
    );
    // Ten seconds ahead it predicts far better than any of the simpler models.
    let predictions = found["predictions"].as_array().unwrap().iter();
    let judged = predictions
        .clone()
        .find(|it| it["is_judged"] == true)
        .unwrap();
    let position = |k: usize| judged["errors"][k][1]["position"].as_f64().unwrap();
    for other in 1..4 {
        assert!(position(0) < 0.3 * position(other), "{judged}");
    }
    // One thruster that is wired the other way round is found, and none is where all are right.
    assert_eq!(found["reversed_inputs"], serde_json::json!([]));
    let reversed = Command::new(env!("CARGO_BIN_EXE_planesman"))
        .args(["six-dof", "fit", &log, "--real", "--like", "bluerov2_heavy"])
        .args(["--signal", "rear_port=rear_port*-1", "--window", "0..60"])
        .output()
        .unwrap();
    assert_eq!(reversed.status.code(), Some(1));
    let text = String::from_utf8(reversed.stdout).unwrap();
    let lines = text.lines().filter(|it| it.contains("acts against"));
    let lines: Vec<&str> = lines.collect();
    assert!(
        lines.len() == 1 && lines[0].starts_with("- input rear_port "),
        "{text}"
    );
}
