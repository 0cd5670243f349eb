//! Numbers of a vehicle file, changed where they stand.

use planesman_vehicle::six_dof::{EditableFile, State, Water, built_in, load, parse, rotation};

#[test]
fn a_file_with_its_own_numbers_is_the_same_vehicle_and_each_number_that_changes_changes_it() {
    for name in built_in() {
        let file = EditableFile::load(name).unwrap();
        let as_it_is = load(name).unwrap();
        let own: Vec<(usize, f64)> = file
            .numbers()
            .iter()
            .map(|it| it.value)
            .enumerate()
            .collect();
        assert!(own.len() > 10, "{name}");
        assert_eq!(file.vehicle(&own).unwrap(), as_it_is, "{name}");
        for (place, value) in own {
            let by = 0.001 * file.numbers()[place].size;
            let of = file.vehicle(&[(place, value + by)]).unwrap();
            assert_ne!(of, as_it_is, "{name} {}", file.numbers()[place].name);
        }
    }
}

#[test]
fn a_changed_number_is_the_entry_of_its_name_and_all_else_stays() {
    let file = EditableFile::load("lauv").unwrap();
    let place = |name: &str| file.named(name).unwrap()[0];
    let changes = [
        ((place("linear_damping_26"), -12.5), "+-0.5".to_owned()),
        ((place("N_uv"), 11.25), "+-1".to_owned()),
        ((place("buoyancy"), 178.0), "+-2".to_owned()),
    ];
    let text = file.text("mine", "two\nlines", &changes);
    assert!(text.starts_with("# two\n# lines\n#\n# The Light AUV"));
    for line in [
        "name: mine",
        "  - [0, 23, 0, 0, 0, -12.5]  # fitted, linear_damping_26: +-0.5",
        "    N_uv: 11.25  # fitted, N_uv: +-1",
        // The remark on the old number is gone.
        "buoyancy: 178 N  # fitted, buoyancy: +-2",
        "centre_of_gravity: [0 m, 0 m, 0.01 m]",
    ] {
        assert!(text.lines().any(|it| it == line), "{line}");
    }
    let vehicle = parse("mine", &text).unwrap();
    assert_eq!(vehicle.parts().damping.linear[1][5], -12.5);
    assert_eq!(vehicle.parts().buoyancy, 178.0);
    assert_eq!(vehicle.parts().body, load("lauv").unwrap().parts().body);
}

#[test]
fn thrust_is_one_factor_of_all_propulsors_and_groups_have_their_numbers() {
    let file = EditableFile::load("bluerov2_heavy").unwrap();
    let thrust = file.named("thrust").unwrap();
    assert_eq!(thrust.len(), 1);
    let scaled = file.vehicle(&[(thrust[0], 0.5)]).unwrap();
    let before = load("bluerov2_heavy").unwrap();
    use planesman_vehicle::six_dof::propulsion::Propulsor::Thruster;
    let pairs = scaled
        .parts()
        .propulsors
        .iter()
        .zip(&before.parts().propulsors);
    for pair in pairs {
        let (
            Thruster { thruster: one, .. },
            Thruster {
                thruster: other, ..
            },
        ) = pair
        else {
            panic!("thrusters alone");
        };
        assert!((one.thrust(0.7) / other.thrust(0.7) - 0.5).abs() < 1e-12);
    }
    assert_eq!(file.named("added_mass").unwrap().len(), 6);
    assert_eq!(file.named("coefficients"), Some(Vec::new()));
    assert_eq!(file.named("Y_uv"), None);
    // A coefficient of added mass off the diagonal would have to change with its twin.
    let printed = EditableFile::load("remus_100_printed").unwrap();
    assert!(printed.named("Y_vdot").is_some() && printed.named("Y_rdot").is_none());
}

#[test]
fn a_number_that_is_zero_has_a_size_and_positions_of_propulsion_move_together() {
    let file = EditableFile::load("bluerov2_heavy").unwrap();
    let place = |name: &str| file.named(name).unwrap()[0];
    let of = |name: &str| &file.numbers()[place(name)];
    assert_eq!(of("linear_damping_22").value, 0.0);
    // A fifth of 13.5 kg + 7.12 kg per second.
    assert!((of("linear_damping_22").size - 4.124).abs() < 1e-12);
    let moved = file.vehicle(&[(place("thrust_centre_z"), -0.085)]).unwrap();
    let heights: Vec<f64> = (moved.parts().thrusters())
        .map(|it| it.1.position[2])
        .collect();
    let expected = [0.0, 0.0, 0.0, 0.0, -0.085, -0.085, -0.085, -0.085];
    for (height, expected) in heights.iter().zip(expected) {
        assert!((height - expected).abs() < 1e-12, "{heights:?}");
    }
    assert_eq!(file.named("all").unwrap().len(), file.numbers().len());
}

#[test]
fn an_input_may_be_a_force_or_moment_along_any_axis() {
    let rov = include_str!("../../../vehicles/six_dof/bluerov2_heavy.yaml");
    let (head, rest) = rov.split_once("inputs:").unwrap();
    let body = &rest[rest.find("\nmass:").unwrap()..rest.find("# Thrust in N").unwrap()];
    let with = |propulsion: &str| {
        let inputs = "inputs:\n  - { name: Y }\n  - { name: N }\n";
        parse(
            "mine",
            &format!("{head}{inputs}{body}propulsion:\n{propulsion}"),
        )
    };
    let both = "  - { kind: force, input: Y, axis: Y, limits: [-50 N, 50 N], position: [0 m, 0 m, 0.1 m] }\n  - { kind: force, input: N, axis: N, limits: [-9 N m, 9 N m] }\n";
    let vehicle = with(both).unwrap();
    let still = State {
        position: [0.0; 3],
        attitude: rotation::from_euler([0.0; 3]),
        velocity: [0.0; 6],
    };
    let water = Water::steady([0.0; 3]);
    let force = vehicle.forces(&still, &[10.0, 20.0], &water).propulsion;
    // A force of 10 N at 0.1 m below the origin rolls by -1 N m; the moment is limited to 9 N m.
    assert_eq!(force, [0.0, 10.0, 0.0, -1.0, 0.0, 9.0]);
    let refusal = with(&both.replace("9 N m]", "9 N m], position: [0 m, 0 m, 0 m]")).unwrap_err();
    assert!(
        refusal.to_string().contains("propulsion[1].position"),
        "{refusal}"
    );
}

#[test]
fn an_alias_is_refused_since_its_number_would_change_with_its_anchor() {
    let text = include_str!("../../../vehicles/six_dof/bluerov2_heavy.yaml");
    let curve = "curve: [8.9, 176.0, -404.1, 389.9, -140.3]";
    let (first, others) = text.split_once(curve).unwrap();
    let anchor = curve.replace("curve:", "curve: &t200");
    let aliased = first.to_owned() + &anchor + &others.replace(curve, "curve: *t200");
    assert_eq!(
        parse("mine", &aliased).unwrap(),
        load("bluerov2_heavy").unwrap()
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.yaml");
    std::fs::write(&path, aliased).unwrap();
    let refusal = EditableFile::load(path.to_str().unwrap()).unwrap_err();
    let said = "propulsion[1].curve: the alias *t200 refused";
    assert!(refusal.to_string().contains(said), "{refusal}");
}
