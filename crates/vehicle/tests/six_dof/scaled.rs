//! Vehicles with some numbers times factors.

use planesman_vehicle::six_dof::{State, Water};

use crate::vehicle;

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
        ("N_uu_dr", 1.1, "none of mass, inertia"),
        ("thrust", 1.1, "lauv has none"),
        ("X_vv", 1.1, "lauv has none"),
        ("linear_damping", -1.0, "feeds energy"),
        ("mass", f64::NAN, "mass"),
    ] {
        let refusal = lauv.scaled([(name, factor)]).unwrap_err().to_string();
        assert!(refusal.contains(reason), "{refusal}");
    }
}
