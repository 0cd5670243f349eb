//! Six degrees of freedom against values of an independent integration (DOP853 at 3e-14, in Python), and against what the equations must keep.

mod editable;
mod exchange;
mod invariants;
mod surface;
mod values;

use planesman_vehicle::six_dof::{self, Parts, State, Vehicle, Water};

/// A vehicle of the values by its name there.
fn vehicle(name: &str) -> Vehicle {
    match name {
        "general_body" => six_dof::parse(name, include_str!("general_body.yaml")),
        "remus_100" => six_dof::load("remus_100_printed"),
        name => six_dof::load(name),
    }
    .unwrap()
}

/// The vehicle with something else in it.
fn changed(vehicle: &Vehicle, change: impl FnOnce(&mut Parts)) -> Vehicle {
    let mut parts = vehicle.parts().clone();
    change(&mut parts);
    Vehicle::new(parts).unwrap()
}

/// A file that is not physical is refused with the entry.
#[test]
fn a_file_that_is_not_physical_is_refused_with_the_entry() {
    let text = include_str!("general_body.yaml");
    for (from, to, entry) in [
        ("mass: 40 kg", "mass: -40 kg", "mass: -40 kg refused"),
        ("mass: 40 kg", "mass: 40 m", "mass: 40 m refused"),
        ("buoyancy: 398 N", "buoyancy: .nan N", "buoyancy"),
        (
            "[0.01 m, 0.015 m, -0.02 m]",
            "[0.01 m, 0.015 m, -2000 m]",
            "centre_of_buoyancy",
        ),
        (
            "xx: 0.9 kg m^2",
            "xx: 20 kg m^2",
            "inertia: the principal moments",
        ),
        ("xy: 0.11 kg m^2", "xy: 5.1 kg m^2", "inertia"),
        ("[3.1, 0.4,", "[-90, 0.4,", "added_mass"),
        ("[3.1, 0.4,", "[3.1, 0.5,", "added_mass: not symmetric"),
        (
            "- [4, 0, 0.2, 0, 0.1, 0]",
            "- [-4, 0, 0.2, 0, 0.1, 0]",
            "linear_damping: it adds energy",
        ),
        (
            "- [5, 0.1, 0.2, 0, 0, 0]",
            "- [-5, 0.1, 0.2, 0, 0, 0]",
            "quadratic_damping: row 1",
        ),
        (
            "input: propeller",
            "input: screw",
            "propulsion[0].input: 'screw'",
        ),
        ("chord: [1, 0, 0]", "chord: [0, 0, 0]", "fins[0].chord"),
        ("chord: [1, 0, 0]", "chord: [1, 1, 0]", "fins[0].normal"),
        ("hand: right", "hand: up", "unknown variant `up`"),
        ("weight: 392.4 N", "weight: 392.4 N\nmassage: 3", "massage"),
    ] {
        assert!(text.contains(from), "{from}");
        let parsed = six_dof::parse("own.yaml", &text.replacen(from, to, 1));
        let refusal = parsed.unwrap_err().to_string();
        assert!(
            refusal.starts_with("vehicle file 'own.yaml': ") && refusal.contains(entry),
            "{refusal}"
        );
    }
    let unknown = six_dof::load("nowhere.yaml").unwrap_err().to_string();
    assert!(unknown.contains("bluerov2_heavy"), "{unknown}");
    let remus = include_str!("../../../vehicles/six_dof/remus_100_printed.yaml");
    for name in ["Q_uv", "Y_ux", "Y_uudq", "X_", "Y_u|v"] {
        let of = remus.replacen("Y_uv:", &format!("{name}:"), 1);
        let refusal = six_dof::parse("own.yaml", &of).unwrap_err().to_string();
        assert!(
            refusal.contains(&format!("coefficients.{name}")),
            "{refusal}"
        );
    }
}

const MOVING: [f64; 13] = [
    0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.4, 0.1, -0.2, 0.05, -0.1, 0.2,
];

/// Each name beside the entry that the vehicle's parts have for it.
#[test]
fn a_factor_scales_the_numbers_of_its_name_and_no_other() {
    let lauv = vehicle("lauv");
    let of = |factors: &[(&str, f64)]| lauv.scaled(factors.iter().copied()).unwrap();
    let state = State::of_row(MOVING);
    let inputs = [0.1, 0.0, 9.0];
    let force = |factors: &[(&str, f64)]| of(factors).forces(&state, &inputs, &Water::at_rest());
    let [plain, rudder, hull] = [&[][..], &[("N_uu_rudder", 1.5)], &[("Y_uv", 0.5)]].map(force);
    // N_uudr is 7.68 to starboard, the rudder 0.1 rad, u 1.4 m/s; Y_uv as its file has it.
    let yaw = rudder.total()[5] - plain.total()[5];
    assert!((yaw - 0.5 * 7.68 * 0.1 * 1.4 * 1.4).abs() < 1e-12, "{yaw}");
    let sway = hull.total()[1] - plain.total()[1];
    assert!(
        (sway - 0.5 * 30.156304379394403 * 1.4 * 0.1).abs() < 1e-12,
        "{sway}"
    );
    assert_eq!(hull.damping, plain.damping);

    let heavier = of(&[
        ("mass", 1.1),
        ("Y_r", 2.0),
        ("Z_w|w|", 3.0),
        ("M_qdot", 1.25),
    ]);
    let (parts, was) = (heavier.parts(), lauv.parts());
    assert_eq!(parts.body.mass, 18.0 * 1.1);
    assert_eq!(parts.body.inertia[1][1], was.body.inertia[1][1] * 1.1);
    assert_eq!(parts.weight, 176.58);
    assert_eq!(parts.damping.linear[1][5], -23.0);
    assert_eq!(parts.damping.quadratic[2][2], 240.0);
    assert_eq!(parts.added_mass[4][4], 1.3 * 1.25);
    assert_eq!(of(&[]), lauv);
}

#[test]
fn a_factor_of_nothing_or_one_that_no_vehicle_has_is_refused() {
    let lauv = vehicle("lauv");
    for (name, factor, reason) in [
        ("N_uu_dr", 1.1, "use one of mass, inertia"),
        ("thrust", 1.1, "vehicle 'lauv' has no such number"),
        ("X_vv", 1.1, "vehicle 'lauv' has no such number"),
        ("linear_damping", -1.0, "adds energy"),
        ("mass", f64::NAN, "mass"),
    ] {
        let refusal = lauv.scaled([(name, factor)]).unwrap_err().to_string();
        assert!(refusal.contains(reason), "{refusal}");
    }
}
