//! Surface, bottom, and the ticks of the loop.

use planesman_vehicle::six_dof::{
    Accurate, Commands, Conditions, Damping, Sea, Simulation, State, Three, Tick, Vehicle, rotation,
};
use planesman_vehicle::{Body, Boundary, Inputs, PlanePath};

use super::{changed, vehicle};

const ACCURATE: Accurate = Accurate {
    relative: 1e-11,
    absolute: 1e-11,
};

fn ideal(of: &Vehicle) -> Vehicle {
    changed(of, |parts| {
        parts.damping = Damping::default();
        parts.terms.clear();
        parts.fins.clear();
        parts.propulsors.clear();
    })
}

fn at(depth: f64, angles: Three<f64>, velocity: [f64; 6]) -> State {
    State {
        position: [0.0, 0.0, depth],
        attitude: rotation::from_euler(angles),
        velocity,
    }
}

fn with_surface() -> Sea {
    Sea {
        has_surface: true,
        ..Sea::default()
    }
}

/// Kinetic energy, and those of weight and of nine strips of buoyancy that leave the water.
fn energy(of: &Vehicle, state: &State) -> f64 {
    let parts = of.parts();
    let r = rotation::matrix(state.attitude);
    let deep = |p: Three<f64>| state.position[2] + r[2][0] * p[0] + r[2][1] * p[1] + r[2][2] * p[2];
    let moving: f64 = (0..6)
        .flat_map(|i| (0..6).map(move |j| (i, j)))
        .map(|(i, j)| 0.5 * state.velocity[i] * of.inertia()[i][j] * state.velocity[j])
        .sum();
    let (height, b) = (parts.hull.height, parts.centre_of_buoyancy);
    let lifted: f64 = (0..9)
        .map(|i| {
            let x = parts.hull.length * ((f64::from(i) + 0.5) / 9.0 - 0.5);
            let z = deep([b[0] + x, b[1], b[2]]);
            let under = (z + 0.5 * height).clamp(0.0, height);
            under * under / (2.0 * height) + (z - 0.5 * height).max(0.0)
        })
        .sum();
    moving - parts.weight * deep(parts.body.centre_of_gravity) + parts.buoyancy / 9.0 * lifted
}

#[test]
fn a_leap_through_the_surface_keeps_the_energy_of_an_ideal_fluid() {
    for name in ["general_body", "remus_100", "bluerov2_heavy", "lauv"] {
        let of = ideal(&vehicle(name));
        let inputs = vec![0.0; of.parts().inputs.len()];
        let sea = with_surface();
        let start = at(0.8, [0.1, 0.6, 0.3], [1.5, 0.1, -0.2, 0.1, 0.2, -0.1]);
        let mut simulation = Simulation::new(&of, &sea, start, ACCURATE);
        let before = energy(&of, &start);
        let mut highest = start.position[2];
        for k in 1..=60 {
            simulation.advance(0.1 * f64::from(k), &inputs).unwrap();
            highest = highest.min(simulation.state.position[2]);
            let now = energy(&of, &simulation.state);
            assert!(
                (now - before).abs() < 1e-5 * before.abs().max(10.0),
                "{name} {k}: {now} {before}"
            );
        }
        assert!(highest < 0.1, "{name}: {highest} m");
    }
}

/// `omega^2 = B / (H m)`, where the hull floats with its top out.
#[test]
fn a_floating_hull_bobs_at_the_frequency_of_its_waterplane() {
    let of = ideal(&vehicle("lauv"));
    let parts = of.parts();
    let height = parts.hull.height;
    let level = height * (0.5 - (1.0 - parts.weight / parts.buoyancy));
    let mass = of.inertia()[2][2];
    let omega = (parts.buoyancy / (height * mass)).sqrt();
    let sea = with_surface();
    let start = at(level + 2e-4, [0.0; 3], [0.0; 6]);
    let mut simulation = Simulation::new(&of, &sea, start, ACCURATE);
    for k in 1..=20 {
        let t = 0.05 * f64::from(k);
        simulation.advance(t, &[0.0; 3]).unwrap();
        let expected = level + 2e-4 * libm::cos(omega * t);
        let found = simulation.state.position[2];
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }
}

#[test]
fn a_heavy_vehicle_comes_to_rest_on_the_bottom() {
    let heavy = changed(&vehicle("remus_100"), |parts| parts.weight = 330.0);
    let half = 0.5 * heavy.parts().hull.height;
    let sea = Sea {
        bottom: Some(5.0),
        ..with_surface()
    };
    let mut start = at(4.0, [0.0, -0.1, 0.0], [0.0; 6]);
    start.velocity[2] = 0.5;
    let still = changed(&heavy, |parts| parts.propulsors.clear());
    let mut simulation = Simulation::new(&still, &sea, start, ACCURATE);
    simulation.advance(60.0, &[0.0; 2]).unwrap();
    let state = simulation.state;
    // The spring gives 330 N a centimetre; buoyancy bears 308 of them.
    let expected = 5.0 - half + 0.01 * (330.0 - 308.0) / 330.0;
    assert!(
        (state.position[2] - expected).abs() < 1e-4,
        "{:?}",
        state.position
    );
    assert!(state.velocity.iter().all(|v| v.abs() < 1e-3), "{state:?}");
}

fn over(
    planes: &f64,
    rudder: &f64,
    thrust: &f64,
    tick: &Tick,
    sea: &Sea,
    holds: bool,
    ticks: u32,
) -> State {
    let inputs = Inputs {
        dive_planes: PlanePath::held(planes),
        rudder: PlanePath::held(rudder),
        thrust: PlanePath::held(thrust),
        ..Inputs::all(PlanePath::NEUTRAL)
    };
    let mut state = at(20.0, [0.0; 3], [1.5, 0.0, 0.0, 0.0, 0.0, 0.0]);
    for k in 0..ticks {
        let conditions = Conditions {
            sea,
            time: 0.05 * f64::from(k),
            holds_speed: holds,
            load: [0.0; 6],
            step: 0.05,
        };
        (state, _) = tick
            .advance(&conditions, &state, &inputs, Commands::NONE, 1)
            .unwrap();
    }
    state
}

#[test]
fn ticks_of_the_loop_fly_as_the_simulation_does() {
    let of = vehicle("lauv");
    let tick = Tick::new(of.clone()).unwrap();
    let sea = Sea {
        current: [0.2, -0.1, 0.0],
        ..Sea::default()
    };
    // Half of the thrust's 14 N.
    let found = over(&0.1, &-0.05, &0.5, &tick, &sea, false, 400);
    let start = at(20.0, [0.0; 3], [1.5, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut simulation = Simulation::new(&of, &sea, start, ACCURATE);
    simulation.advance(20.0, &[-0.05, 0.1, 7.0]).unwrap();
    for (x, y) in found.row().iter().zip(simulation.state.row()) {
        assert!((x - y).abs() < 1e-6, "{x} {y}");
    }
}

#[test]
fn a_held_speed_stays_and_the_rest_moves_as_under_the_force_that_holds_it() {
    let sea = Sea {
        current: [0.3, 0.2, 0.0],
        ..Sea::default()
    };
    let tick = Tick::new(vehicle("lauv")).unwrap();
    let state = over(&0.1, &-0.1, &0.0, &tick, &sea, true, 400);
    let through = state.body(sea.current).speed;
    // At the start the stream took 0.3 m/s of the 1.5 over ground.
    assert!((through - 1.2).abs() < 1e-9, "{through}");
    assert!(state.position[2] > 21.0 && state.velocity[5].abs() > 0.05);
}

#[test]
fn a_state_is_the_bodys_and_back() {
    let current = [0.3, -0.2, 0.1];
    let state = at(3.0, [0.3, -0.5, 2.0], [1.0, 0.2, -0.1, 0.05, 0.1, -0.2]);
    let body = state.body(current);
    let back = State::of_body(&body, current);
    for (x, y) in state.row().iter().zip(back.row()) {
        assert!((x - y).abs() < 1e-12, "{x} {y}");
    }
    let Body {
        roll, plane, yaw, ..
    } = body;
    let angles = [roll.angle, plane.pitch, yaw.angle];
    for (x, y) in angles.iter().zip([0.3, -0.5, 2.0]) {
        assert!((x - y).abs() < 1e-14);
    }
}

#[test]
fn the_first_contact_is_told_with_its_time() {
    let tick = Tick::new(vehicle("lauv")).unwrap();
    let sea = Sea {
        bottom: Some(8.0),
        ..with_surface()
    };
    let touched = |from: f64, rate: f64| {
        let mut state = at(from, [0.0; 3], [0.0; 6]);
        state.velocity[2] = rate;
        let neutral = Inputs::all(PlanePath::NEUTRAL);
        let conditions = Conditions {
            sea: &sea,
            time: 0.0,
            holds_speed: false,
            load: [0.0; 6],
            step: 0.05,
        };
        tick.advance(&conditions, &state, &neutral, Commands::NONE, 1)
            .unwrap()
            .1
    };
    let down = touched(8.0 - 0.075 - 0.01, 0.5).unwrap();
    assert_eq!(down.boundary, Boundary::Bottom);
    assert!((down.time - 0.02).abs() < 1e-3, "{}", down.time);
    let up = touched(0.075 + 0.01, -0.5).unwrap();
    assert_eq!(up.boundary, Boundary::Surface);
    assert_eq!(touched(4.0, 0.5), None);
}

/// So stiff that every step is the shortest: a step that rounding made longer by its last bit was refused for ever.
#[test]
fn a_tick_deep_in_the_ground_ends() {
    let tick = Tick::new(vehicle("bluerov2_heavy")).unwrap();
    let sea = Sea {
        bottom: Some(0.1),
        ..with_surface()
    };
    let conditions = Conditions {
        sea: &sea,
        time: 0.0,
        holds_speed: false,
        load: [0.0; 6],
        step: 0.01,
    };
    let neutral = Inputs::all(PlanePath::NEUTRAL);
    let mut state = at(500.0, [0.0; 3], [0.0; 6]);
    for _ in 0..20 {
        (state, _) = tick
            .advance(&conditions, &state, &neutral, Commands::NONE, 1)
            .unwrap();
    }
    assert!(state.position[2] < 500.0, "{:?}", state.position);
}

#[test]
fn an_input_that_nothing_moves_is_named() {
    let odd = changed(&vehicle("lauv"), |parts| {
        parts.inputs[0] = "tail".to_owned()
    });
    let refusal = Tick::new(odd).unwrap_err().to_string();
    assert!(refusal.contains("'tail'"), "{refusal}");
}

/// The 1988 report's kind of equations for the plane are those of `remus_100`, which has Prestero's numbers as printed.
#[test]
fn the_derivatives_of_the_plane_are_those_of_the_vehicle_of_the_plane() {
    let found = Tick::new(vehicle("remus_100")).unwrap().derivatives(1.54);
    let plane = planesman_vehicle::vehicle_file::remus_100().derivatives(1.54);
    for (name, x, y) in [
        ("heave_inertia", found.heave_inertia, plane.heave_inertia),
        ("z_w", found.z_w, plane.z_w),
        ("z_q", found.z_q_plus_m_u, plane.z_q_plus_m_u),
        ("z_delta", found.z_delta, plane.z_delta),
        ("pitch_inertia", found.pitch_inertia, plane.pitch_inertia),
        ("m_w", found.m_w, plane.m_w),
        ("m_q", found.m_q, plane.m_q),
        ("m_delta", found.m_delta, plane.m_delta),
        ("restoring", found.restoring, plane.restoring),
        ("z_q_dot", found.z_q_dot, plane.z_q_dot),
        ("m_w_dot", found.m_w_dot, plane.m_w_dot),
        ("first_moment", found.first_moment, plane.first_moment),
        ("excess_weight", found.excess_weight, plane.excess_weight),
    ] {
        assert!((x - y).abs() < 2e-3 * y.abs().max(0.1), "{name}: {x} {y}");
    }
}

fn torpedo() -> planesman_vehicle::six_dof::Torpedo {
    planesman_vehicle::six_dof::Torpedo {
        name: "mine".to_owned(),
        length: 1.33,
        diameter: 0.191,
        prismatic: 0.82,
        density: 1030.0,
        reserve: 0.01,
        gravity_below: 0.0196,
        fin_span: 0.0857,
        fin_chord: 0.0757,
        fin_aft: 0.638,
        top_speed: 2.5,
    }
}

/// The shape of REMUS gives what Prestero 2001 derives for it, within what ellipsoid and strips differ by.
#[test]
fn a_torpedo_of_the_shape_of_remus_has_its_derivatives() {
    let text = torpedo().file().unwrap();
    let of = planesman_vehicle::six_dof::parse("mine", &text).unwrap();
    let parts = of.parts();
    let printed = vehicle("remus_100");
    // Table 2.3: 31.8 kg of water; B.1: X_udot -0.93, Y_vdot -35.5 with fins, I_y 3.45.
    assert!(
        (parts.buoyancy / 306.0 - 1.0).abs() < 0.05,
        "{}",
        parts.buoyancy
    );
    assert!(
        (parts.added_mass[0][0] / 0.93 - 1.0).abs() < 0.25,
        "{:?}",
        parts.added_mass
    );
    assert!((parts.added_mass[1][1] / 35.5 - 1.0).abs() < 0.25);
    assert!((parts.body.inertia[1][1] / printed.parts().body.inertia[1][1] - 1.0).abs() < 0.35);
    // Hoerner's c_L of the fins: 3.12 (p. 32).
    assert!(
        (parts.fins[0].section.slope - 3.12).abs() < 0.15,
        "{}",
        parts.fins[0].section.slope
    );
}

/// It runs straight, reaches its speed, and turns to the side of its rudder.
#[test]
fn a_torpedo_flies() {
    let text = torpedo().file().unwrap();
    let of = planesman_vehicle::six_dof::parse("mine", &text).unwrap();
    let full = text
        .split_once("limits: [")
        .and_then(|(_, rest)| {
            rest.split(", ")
                .nth(1)?
                .split(' ')
                .next()?
                .parse::<f64>()
                .ok()
        })
        .unwrap();
    let fly = |rudder: f64, seconds: f64| {
        let mut start = at(30.0, [0.0; 3], [2.0, 0.02, 0.0, 0.0, 0.0, 0.02]);
        start.velocity[3] = 0.01;
        let sea = Sea::default();
        let mut simulation = Simulation::new(&of, &sea, start, ACCURATE);
        simulation.advance(seconds, &[rudder, 0.0, full]).unwrap();
        simulation.state
    };
    let straight = fly(0.0, 60.0);
    assert!((straight.velocity[0] - 2.5).abs() < 0.15, "{straight:?}");
    assert!(straight.velocity[5].abs() < 1e-3, "{straight:?}");
    assert!(fly(0.1, 20.0).velocity[5] > 0.02);
}

#[test]
fn a_shape_outside_the_formulas_is_refused_with_its_number() {
    for (change, what) in [
        (
            (|it: &mut planesman_vehicle::six_dof::Torpedo| it.length = f64::NAN) as fn(&mut _),
            "length",
        ),
        (
            |it: &mut planesman_vehicle::six_dof::Torpedo| it.diameter = 1.0,
            "length over diameter",
        ),
        (
            |it: &mut planesman_vehicle::six_dof::Torpedo| it.fin_span = 5.0,
            "fin span",
        ),
        (
            |it: &mut planesman_vehicle::six_dof::Torpedo| it.name = "a: b".to_owned(),
            "name: 'a: b' refused",
        ),
    ] {
        let mut shape = torpedo();
        change(&mut shape);
        let refusal = shape.file().unwrap_err().to_string();
        assert!(refusal.contains(what), "{refusal}");
    }
}
