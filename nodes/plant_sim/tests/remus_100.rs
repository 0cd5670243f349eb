//! The REMUS 100 against the model its author published.
//!
//! The thesis' simulator (Prestero 2001, ch. 4 and 6, App. B) writes heave force and pitch moment as
//!
//! ```text
//! Z = (W - B) cos(theta) + Z_ww w|w| + Z_qq q|q| + Z_uw u w + (Z_uq + m) u q + m z_g q^2 + Z_uuds u^2 delta
//! M = -z_g W sin(theta) + M_ww w|w| + M_qq q|q| - m z_g w q + M_uq u q + M_uw u w + M_uuds u^2 delta
//! ```
//!
//! and inverts the mass matrix. Here that is written down once more, with the numbers of a transcription
//! of the thesis' simulator and not the vehicle file's, at a constant speed u = 1.54 m/s (3 knots), and flown by another
//! integrator: steps of the plane must lead both to the same place. Trim is where these two are 0.
//! The thesis' linear model of its ch. 4 is not compared: its coefficients (the fins' among them)
//! are others than those of the simulator.

use plant_sim::{
    Restoring, State, dynamics::Load, environment::Environment, linearised, motion::Motion,
    planes::PlanePath, vehicle_file::remus_100,
};

const SPEED: f64 = 1.54;

fn motion() -> Motion {
    Motion {
        derivatives: remus_100().derivatives(SPEED),
        restoring: Restoring::Sine,
        environment: Environment {
            density: 1025.0,
            gravity: 9.81,
            atmospheric_pressure: 101_325.0,
        },
        step: 0.001,
    }
}

/// `w'` and `q'` as the simulator has them.
fn published(w: f64, q: f64, theta: f64, delta: f64) -> (f64, f64) {
    let (weight, buoyancy, m, z_g, u) = (299.0, 308.0, 30.48, 0.0196, SPEED);
    let z = (weight - buoyancy) * f64::cos(theta)
        - 131.0 * w * w.abs()
        - 0.632 * q * q.abs()
        - 28.6 * u * w
        + (-5.22 + m) * u * q
        + m * z_g * q * q
        - 9.64 * u * u * delta;
    let moment = -z_g * weight * f64::sin(theta) + 3.18 * w * w.abs()
        - 188.0 * q * q.abs()
        - m * z_g * w * q
        - 2.0 * u * q
        + 24.0 * u * w
        - 6.15 * u * u * delta;
    // [m - Z_wdot, -Z_qdot; -M_wdot, I_yy - M_qdot], inverted by Cramer's rule.
    let (a, b, c, d) = (m + 35.5, 1.93, 1.93, 3.45 + 4.88);
    let determinant = a * d - b * c;
    (
        (d * z - b * moment) / determinant,
        (a * moment - c * z) / determinant,
    )
}

#[test]
fn the_accelerations_are_those_of_the_published_simulator() {
    let d = motion().derivatives;
    for (w, q, theta, delta) in [
        (0.0, 0.0, 0.0, 0.0),
        (0.1, 0.0, 0.2, 0.1),
        (-0.2, 0.3, -0.4, -0.2),
        (0.05, -0.6, 1.0, 0.3),
    ] {
        let state = State {
            heave: w,
            pitch_rate: q,
            pitch: theta,
            ..State::default()
        };
        let (heaving, pitching) = d.accelerations(&state, delta, Restoring::Sine, Load::NONE);
        let (w_dot, q_dot) = published(w, q, theta, delta);
        assert!((heaving - w_dot).abs() < 1e-12, "{heaving} {w_dot}");
        assert!((pitching - q_dot).abs() < 1e-12, "{pitching} {q_dot}");
    }
}

#[test]
fn a_step_of_the_stern_plane_leads_where_the_published_simulator_goes() {
    // Ten degrees for five seconds, then back; Heun's method at half a millisecond.
    let (ten_degrees, neutral) = (10_f64.to_radians(), 0.0);
    let mut ours = State {
        depth: 10.0,
        ..State::default()
    };
    for delta in [ten_degrees, neutral] {
        ours = motion()
            .advance(&ours, &PlanePath::held(&delta), 5000)
            .expect("it dives");
    }
    let h = 5e-4;
    let rates = |[w, q, theta, _]: [f64; 4], delta: f64| {
        let (w_dot, q_dot) = published(w, q, theta, delta);
        [w_dot, q_dot, q, w * theta.cos() - SPEED * theta.sin()]
    };
    let mut y = [0.0, 0.0, 0.0, 10.0];
    for k in 0..20_000 {
        let delta = if k < 10_000 { ten_degrees } else { neutral };
        let k1 = rates(y, delta);
        let k2 = rates(std::array::from_fn(|i| y[i] + h * k1[i]), delta);
        y = std::array::from_fn(|i| y[i] + 0.5 * h * (k1[i] + k2[i]));
    }
    let [w, q, theta, z] = y;
    assert!((ours.heave - w).abs() < 1e-6);
    assert!((ours.pitch_rate - q).abs() < 1e-6);
    assert!((ours.pitch - theta).abs() < 1e-6);
    assert!((ours.depth - z).abs() < 1e-6);
    assert!(ours.pitch < 0.0 && ours.depth > 10.5, "it dives: {ours:?}");
}

/// `(theta, delta)` of level flight, `w = u tan(theta)`, by Newton's method.
fn trim() -> (f64, f64) {
    let level = |theta: f64, delta: f64| published(SPEED * theta.tan(), 0.0, theta, delta);
    let (mut theta, mut delta) = (0.0, 0.0);
    for _ in 0..20 {
        let h = 1e-6;
        let (f, g) = level(theta, delta);
        let (f_t, g_t) = level(theta + h, delta);
        let (f_d, g_d) = level(theta, delta + h);
        let (a, b, c, d) = ((f_t - f) / h, (f_d - f) / h, (g_t - g) / h, (g_d - g) / h);
        let determinant = a * d - b * c;
        theta -= (d * f - b * g) / determinant;
        delta -= (a * g - c * f) / determinant;
    }
    (theta, delta)
}

#[test]
fn trimmed_bow_down_against_its_buoyancy_the_vehicle_flies_level() {
    let (theta, delta) = trim();
    assert!(theta < 0.0 && theta > -0.2, "bow down a little: {theta}");
    let start = State {
        depth: 10.0,
        pitch: theta,
        heave: SPEED * theta.tan(),
        ..State::default()
    };
    let d = motion().derivatives;
    let (heaving, pitching) = d.accelerations(&start, delta, Restoring::Sine, Load::NONE);
    assert!(heaving.abs() < 1e-9 && pitching.abs() < 1e-9);
    assert!(d.depth_rate(&start).abs() < 1e-12);
}

#[test]
fn the_linear_model_is_the_slope_of_the_simulator_and_dive_turns_the_bow_down() {
    let model = linearised::pitch_rate(&remus_100(), SPEED).expect("a model");
    // Slopes of the published accelerations at level flight.
    let h = 1e-6;
    let slope = |f: &dyn Fn(f64) -> (f64, f64)| {
        let ((a, b), (c, d)) = (f(h), f(-h));
        ((a - c) / (2.0 * h), (b - d) / (2.0 * h))
    };
    let columns = [
        slope(&|w| published(w, 0.0, 0.0, 0.0)),
        slope(&|q| published(0.0, q, 0.0, 0.0)),
        slope(&|theta| published(0.0, 0.0, theta, 0.0)),
    ];
    for (i, (w_dot, q_dot)) in columns.into_iter().enumerate() {
        assert!((model.a[(0, i)] - w_dot).abs() < 1e-4);
        assert!((model.a[(1, i)] - q_dot).abs() < 1e-4);
    }
    let (_, bow) = slope(&|delta| published(0.0, 0.0, 0.0, delta));
    assert!((model.b[(1, 0)] - bow).abs() < 1e-6 && bow < 0.0);
}
