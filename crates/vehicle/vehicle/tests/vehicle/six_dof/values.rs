//! Each value within the tolerance it states: `|a - b| <= tolerance max(1, |b|)`.

use nalgebra::Matrix3;
use planesman_vehicle::six_dof::propulsion::{Allocation, Propulsor, Thruster};
use planesman_vehicle::six_dof::{
    self, Accurate, CrossFlow, Damping, Sea, Simulation, Six, State, Turn, Vehicle, Water,
    ellipsoid, growth, rotation, steady_turn, steady_turns,
};
use serde_json::Value;

use super::{changed, vehicle};

fn items(kind: &str) -> Vec<Value> {
    let all: Vec<Value> = serde_json::from_str(include_str!("values.json")).unwrap();
    let of: Vec<Value> = all
        .into_iter()
        .filter(|item| item["kind"] == kind)
        .collect();
    assert!(!of.is_empty());
    of
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

fn array<const N: usize>(value: &Value) -> [f64; N] {
    numbers(value).try_into().unwrap()
}

/// Checks numbers against an item's.
fn check(item: &Value, what: &str, found: &[f64], expected: &Value) {
    let tolerance = item["tolerance"].as_f64().unwrap();
    let expected = numbers(expected);
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(&expected) {
        let allowed = tolerance * b.abs().max(1.0);
        assert!(
            (a - b).abs() <= allowed,
            "{} {what}: {found:?}, expected {expected:?}",
            item["id"]
        );
    }
}

/// The vehicle's inputs for an item's controls. The values count the rudder to port.
fn inputs(vehicle: &Vehicle, controls: &Value) -> Vec<f64> {
    let number = |name: &str| controls[name].as_f64().unwrap_or(0.0);
    let list = |name: &str| controls[name].as_array().map(|_| numbers(&controls[name]));
    let count = vehicle.parts().inputs.len();
    if let Some(volts) = list("volts") {
        return volts;
    }
    if vehicle.parts().name == "general_body" {
        let mut of = list("fins").unwrap_or_else(|| vec![0.0; 4]);
        of.push(number("n"));
        return of;
    }
    let mut of = vec![-number("dr"), number("ds")];
    if count == 3 {
        of.push(number("thrust"));
    }
    of
}

fn current(item: &Value) -> [f64; 3] {
    array(&item["inputs"]["current_ned"])
}

#[test]
fn inertias() {
    for item in items("matrix") {
        let of = vehicle(item["vehicle"].as_str().unwrap());
        let rows = |name: &str| item["outputs"][name].as_array().unwrap().clone();
        for (i, row) in rows("M_RB").iter().enumerate() {
            check(&item, "M_RB", &of.parts().body.matrix()[i], row);
        }
        for (i, row) in rows("M_A").iter().enumerate() {
            check(&item, "M_A", &of.parts().added_mass[i], row);
        }
        let inertia = nalgebra::SMatrix::<f64, 6, 6>::from_fn(|i, j| of.inertia()[i][j]);
        for (i, row) in rows("M_inverse").iter().enumerate() {
            let found: Vec<f64> = inertia
                .try_inverse()
                .unwrap()
                .row(i)
                .iter()
                .copied()
                .collect();
            check(&item, "inverse", &found, row);
        }
    }
}

#[test]
fn accelerations_and_their_parts() {
    for item in items("nu_dot") {
        let of = vehicle(item["vehicle"].as_str().unwrap());
        let state = State {
            position: [0.0, 0.0, 5.0],
            attitude: rotation::from_euler(array(&item["inputs"]["euler"])),
            velocity: array(&item["inputs"]["nu"]),
        };
        let inputs = inputs(&of, &item["inputs"]["controls"]);
        let water = Water::steady(current(&item));
        let forces = of.forces(&state, &inputs, &water);
        let parts = &item["outputs"]["parts"];
        check(
            &item,
            "rigid body",
            &forces.rigid_body_coriolis,
            &parts["rigid_body_coriolis"],
        );
        check(
            &item,
            "added mass",
            &forces.added_mass_coriolis,
            &parts["added_mass_coriolis"],
        );
        check(
            &item,
            "current",
            &forces.current_acceleration,
            &parts["current_acceleration"],
        );
        check(&item, "restoring", &forces.restoring, &parts["restoring"]);
        check(&item, "damping", &forces.damping, &parts["damping"]);
        check(
            &item,
            "coefficients",
            &forces.coefficients,
            &parts["coefficients"],
        );
        check(
            &item,
            "propulsion",
            &forces.propulsion,
            &parts["propulsion"],
        );
        if parts["fins"].is_array() {
            check(&item, "fins", &forces.fins, &parts["fins"]);
        }
        check(
            &item,
            "nu'",
            &of.acceleration(&state, &inputs, &water),
            &item["outputs"]["nu_dot"],
        );
    }
}

/// The vehicle with what a run changes of it.
fn overridden(of: &Vehicle, change: &Value) -> Vehicle {
    changed(of, |parts| {
        if let Some(buoyancy) = change["buoyancy"].as_f64() {
            parts.buoyancy = buoyancy;
        }
        if change["linear_damping"].is_array() {
            parts.damping = Damping::default();
        }
        if change.get("fins").is_some_and(Value::is_null) {
            parts.fins.clear();
        }
        if change.get("propeller").is_some_and(Value::is_null) {
            parts.propulsors.clear();
        }
    })
}

/// Flies a run and checks each of its states.
fn fly(item: &Value) {
    let id = item["id"].as_str().unwrap();
    let with = overridden(
        &vehicle(item["vehicle"].as_str().unwrap()),
        &item["inputs"]["override"],
    );
    let without = changed(&with, |parts| parts.propulsors.clear());
    let sea = Sea {
        current: current(item),
        ..Sea::default()
    };
    let accuracy = Accurate {
        relative: 1e-13,
        absolute: 1e-13,
    };
    let mut state = State::of_row(array(&item["inputs"]["x0"]));
    let mut now = 0.0;
    let times = numbers(&item["outputs"]["t"]);
    let segments = item["inputs"]["segments"].as_array().unwrap();
    let mut ends: Vec<f64> = segments
        .iter()
        .skip(1)
        .map(|s| s[0].as_f64().unwrap())
        .collect();
    ends.push(f64::INFINITY);
    let mut expected = times
        .iter()
        .zip(item["outputs"]["x"].as_array().unwrap())
        .peekable();
    for (segment, end) in segments.iter().zip(ends) {
        let controls = &segment[1];
        let of = match controls["propeller"].as_f64() {
            Some(0.0) => &without,
            _ => &with,
        };
        let held = inputs(of, controls);
        let law = |time: f64, state: &State| match id {
            "lauv.run.depth_hold" => {
                let [_, theta, _] = rotation::euler(state.attitude);
                let wanted = -0.15 * (controls["depth"].as_f64().unwrap() - state.position[2]);
                let planes = 1.0 * (theta - wanted) + 0.5 * state.velocity[4];
                vec![held[0], planes, held[2]]
            }
            "general_body.run.sine_fins" => {
                let (rudder, planes) = (0.2 * libm::sin(time), 0.15 * libm::cos(0.7 * time));
                vec![rudder, rudder, planes, planes, held[4]]
            }
            _ => held.clone(),
        };
        let mut simulation = Simulation::new(of, &sea, state, accuracy);
        simulation.time = now;
        while let Some((time, row)) = expected.next_if(|(time, _)| **time <= end) {
            simulation.advance_under(*time, law).unwrap();
            let mut found = simulation.state.row();
            // Q and -Q are one attitude.
            let sign = (3..7)
                .map(|i| found[i] * row[i].as_f64().unwrap())
                .sum::<f64>()
                .signum();
            found[3..7].iter_mut().for_each(|q| *q *= sign);
            check(item, &format!("at {time} s"), &found, row);
        }
        if end.is_finite() {
            simulation.advance_under(end, law).unwrap();
        }
        (state, now) = (simulation.state, simulation.time);
    }
    assert!(expected.next().is_none());
}

#[test]
fn runs() {
    let flown = items("run")
        .iter()
        .filter(|item| item["inputs"]["segments"].is_array())
        .map(fly)
        .count();
    assert_eq!(flown, 25);
}

/// Rudder to one side, and to the other each time the heading passes the limit.
#[test]
fn zig_zags() {
    let mut flown = 0;
    for item in items("run")
        .iter()
        .filter(|item| item["inputs"]["rule"].is_string())
    {
        let of = vehicle(item["vehicle"].as_str().unwrap());
        let sea = Sea::default();
        let accuracy = Accurate {
            relative: 1e-13,
            absolute: 1e-13,
        };
        let inputs = &item["inputs"];
        let [rudder, limit] = ["rudder", "heading"].map(|name| inputs[name].as_f64().unwrap());
        let base = &inputs["base"];
        let mut simulation =
            Simulation::new(&of, &sea, State::of_row(array(&inputs["x0"])), accuracy);
        let switches = numbers(&item["outputs"]["switch_times"]);
        let times = numbers(&item["outputs"]["t"]);
        let mut side = 1.0;
        let mut found = Vec::new();
        let mut expected = times
            .iter()
            .zip(item["outputs"]["x"].as_array().unwrap())
            .peekable();
        let last = *times.last().unwrap();
        while simulation.time < last {
            let controls = [
                -side * rudder,
                base["ds"].as_f64().unwrap(),
                base["thrust"].as_f64().unwrap(),
            ];
            let next = expected.peek().map_or(last, |(time, _)| **time);
            let before = simulation.clone();
            simulation
                .advance((before.time + 0.05).min(next), &controls)
                .unwrap();
            let passed = |simulation: &Simulation<'_>| {
                rotation::euler(simulation.state.attitude)[2] * side <= -limit
            };
            if passed(&simulation) && !passed(&before) {
                let (mut low, mut high) = (before.time, simulation.time);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    let mut there = before.clone();
                    there.advance(middle, &controls).unwrap();
                    (low, high) = if passed(&there) {
                        (low, middle)
                    } else {
                        (middle, high)
                    };
                }
                simulation = before;
                simulation.advance(high, &controls).unwrap();
                found.push(high);
                side = -side;
            }
            while let Some((time, row)) = expected.next_if(|(time, _)| **time <= simulation.time) {
                assert!((simulation.time - time).abs() < 1e-9);
                check(item, &format!("at {time} s"), &simulation.state.row(), row);
            }
        }
        assert!(found.len() >= switches.len());
        check(
            item,
            "switches",
            &found[..switches.len()],
            &item["outputs"]["switch_times"],
        );
        flown += 1;
    }
    assert_eq!(flown, 2);
}

#[test]
fn steady_turns_and_helices() {
    for item in items("steady") {
        let of = vehicle(item["vehicle"].as_str().unwrap());
        let out = |name: &str| item["outputs"][name].as_f64().unwrap();
        let controls = inputs(&of, &item["inputs"]);
        // A start that is a little off: the turn must be found.
        let near = |name: &str| out(name) * 1.01 + 1e-3;
        let turn = Turn {
            velocity: ["u", "v", "w"].map(near),
            roll: near("phi"),
            pitch: near("theta"),
            yaw_rate: near("psi_dot"),
            held: 0.0,
        };
        let names = ["u", "v", "w", "phi", "theta", "psi_dot"];
        if item["outputs"]["ds"].is_number() {
            let start = Turn {
                held: near("ds"),
                ..turn
            };
            let found = steady_turn(&of, &controls, 1, start).unwrap();
            let [u, v, w] = found.velocity;
            let found = [u, v, w, found.roll, found.pitch, found.yaw_rate, found.held];
            for (name, x) in names.iter().chain(&["ds"]).zip(found) {
                check(&item, name, &[x], &Value::from(vec![out(name)]));
            }
        } else {
            // A helix sinks or rises: its accelerations are zero.
            let exact = Turn {
                velocity: ["u", "v", "w"].map(out),
                roll: out("phi"),
                pitch: out("theta"),
                yaw_rate: out("psi_dot"),
                held: 0.0,
            };
            for x in of.acceleration(&exact.state(), &controls, &Water::at_rest()) {
                assert!(x.abs() < 1e-7, "{}", item["id"]);
            }
        }
    }
}

/// Growth by the linear motion, and by a flight from a hair beside the turn.
#[test]
fn every_turn_of_an_unstable_vehicle_is_found_and_the_unstable_ones_are_left_by_themselves() {
    let of = six_dof::load("remus_100_printed").unwrap();
    let names = &of.parts().inputs;
    let holding = names.iter().position(|it| it == "stern_planes").unwrap();
    let rudder = names.iter().position(|it| it == "rudder").unwrap();
    let mut controls = vec![0.0; names.len()];
    controls[rudder] = 1_f64.to_radians();
    let start = Turn {
        velocity: [1.4, 0.0, 0.0],
        roll: 0.0,
        pitch: 0.0,
        yaw_rate: 0.0,
        held: 0.0,
    };
    let turns = steady_turns(&of, &controls, holding, start);
    // From single starts: 0, 0.1 and -0.1 rad/s.
    let rates: Vec<f64> = turns.iter().map(|it| it.yaw_rate.to_degrees()).collect();
    for rate in [0.3205, 6.2682, -5.7997] {
        assert!(rates.iter().any(|it| (it - rate).abs() < 1e-4), "{rates:?}");
    }
    for turn in &turns {
        let found = growth(&of, &controls, holding, turn).unwrap();
        controls[holding] = turn.held;
        let mut beside = turn.state();
        beside.velocity.iter_mut().for_each(|it| *it += 1e-7);
        let accurate = Accurate {
            relative: 1e-13,
            absolute: 1e-13,
        };
        let sea = Sea::default();
        let mut flight = Simulation::new(&of, &sea, beside, accurate);
        flight.advance(300.0, &controls).unwrap();
        let away = flight.state.velocity.iter().zip(turn.state().velocity);
        let away = away.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert_eq!(away < 1e-7, found < 0.0, "{turn:?} {found} {away}");
        assert!(found.abs() > 0.01, "{found}");
    }
}

/// The derivative of roll, pitch, yaw and velocities by themselves, by differences of order four.
#[test]
fn jacobians() {
    for item in items("jacobian") {
        let of = vehicle(item["vehicle"].as_str().unwrap());
        let controls = inputs(&of, &item["inputs"]["controls"]);
        let water = Water::steady(current(&item));
        let rates = |x: &[f64; 9]| -> [f64; 9] {
            let [phi, theta, _, u, v, w, p, q, r] = *x;
            let state = State {
                position: [0.0; 3],
                attitude: rotation::from_euler([x[0], x[1], x[2]]),
                velocity: [u, v, w, p, q, r],
            };
            let [a, b, c, d, e, f] = of.acceleration(&state, &controls, &water);
            let ((sr, cr), (sp, cp)) = (libm::sincos(phi), libm::sincos(theta));
            let turn = q * sr + r * cr;
            [
                p + turn * sp / cp,
                q * cr - r * sr,
                turn / cp,
                a,
                b,
                c,
                d,
                e,
                f,
            ]
        };
        let at: [f64; 9] = array(&item["inputs"]["state"]);
        let h = 1e-3;
        let columns: Vec<[f64; 9]> = (0..9)
            .map(|j| {
                let off = |k: f64| {
                    let mut x = at;
                    x[j] += k * h;
                    rates(&x)
                };
                let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(off);
                std::array::from_fn(|i| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * h))
            })
            .collect();
        for (i, row) in item["outputs"]["A"].as_array().unwrap().iter().enumerate() {
            let found: Vec<f64> = columns.iter().map(|column| column[i]).collect();
            for (x, y) in found.iter().zip(numbers(row)) {
                assert!(
                    (x - y).abs() < 1e-8 * y.abs().max(1.0),
                    "{} {i}: {found:?} {row}",
                    item["id"]
                );
            }
        }
    }
}

fn thrusters(of: &Vehicle) -> Vec<&Thruster> {
    of.parts()
        .propulsors
        .iter()
        .map(|propulsor| match propulsor {
            Propulsor::Thruster { thruster, .. } => thruster,
            _ => panic!("a thruster"),
        })
        .collect()
}

#[test]
fn fins_propellers_thrusters_strips_and_attitudes() {
    let general = vehicle("general_body");
    let rov = vehicle("bluerov2_heavy");
    let mut seen = 0;
    for item in items("unit") {
        let id = item["id"].as_str().unwrap();
        let (given, expected) = (&item["inputs"], &item["outputs"]);
        let number = |name: &str| given[name].as_f64().unwrap();
        seen += 1;
        if id.starts_with("spheroid.k") {
            // k1, k2 of the mass of the water displaced, k' of its inertia about a cross axis.
            let a = number("a_over_b");
            let [x, y, _, _, m, _] = ellipsoid(1.0, [a, 1.0, 1.0]);
            let mass = 4.0 / 3.0 * std::f64::consts::PI * a;
            let k = [x / mass, y / mass, m / (mass * (a * a + 1.0) / 5.0)];
            check(&item, "k", &k, &expected["k"]);
        } else if id.starts_with("ellipsoid") {
            let found = ellipsoid(number("rho"), array(&given["semi_axes"]));
            check(&item, "added mass", &found, &expected["added_mass"]);
        } else if id.starts_with("fin.coefficients") {
            let (lift, drag) = general.parts().fins[0]
                .section
                .lift_and_drag(number("alpha"));
            check(
                &item,
                "C_L",
                &[lift],
                &Value::from(vec![expected["C_L"].clone()]),
            );
            check(
                &item,
                "C_D",
                &[drag],
                &Value::from(vec![expected["C_D"].clone()]),
            );
        } else if id.starts_with("fin.force") {
            let names = &general.parts().inputs;
            let which = names.iter().position(|name| *name == given["fin"]).unwrap();
            let alone = changed(&general, |parts| {
                parts.fins.retain(|fin| fin.input == which)
            });
            let mut angles = vec![0.0; 5];
            angles[which] = number("delta");
            let state = moving(array(&given["nu_r"]));
            let found = alone.forces(&state, &angles, &Water::at_rest()).fins;
            check(&item, "force", &found, &expected["tau"]);
        } else if id.starts_with("propeller") {
            let inputs = [0.0, 0.0, 0.0, 0.0, number("n")];
            let state = moving([number("u_r"), 0.0, 0.0, 0.0, 0.0, 0.0]);
            let [x, _, _, k, _, _] = general
                .forces(&state, &inputs, &Water::at_rest())
                .propulsion;
            check(&item, "X, K", &[x, k], &expected["X_K"]);
        } else if id.contains("allocate") {
            let allocation = Allocation::new(&thrusters(&rov)).unwrap();
            check(
                &item,
                "thrusts",
                &allocation.thrusts(&array(&given["tau"])),
                &expected["thrusts"],
            );
        } else if id.starts_with("t200.lag") {
            check(
                &item,
                "y",
                &[lag_step(number("t"))],
                &Value::from(vec![expected["y"].clone()]),
            );
        } else if id.starts_with("t200") {
            let found = thrusters(&rov)[0].thrust(number("command"));
            check(
                &item,
                "thrust",
                &[found],
                &Value::from(vec![expected["thrust"].clone()]),
            );
        } else if id.starts_with("strips") {
            let hull = CrossFlow {
                density: 1025.0,
                drag: 1.1,
                width: 0.19,
                ends: [-0.8, 0.8],
            };
            let bare = changed(&general, |parts| {
                parts.damping = Damping::default();
                parts.cross_flow = vec![hull];
            });
            let found = bare.forces(&moving(array(&given["nu_r"])), &[0.0; 5], &Water::at_rest());
            check(&item, "force", &found.damping, &expected["tau"]);
        } else if id.starts_with("attitude") {
            let q = rotation::from_euler(array(&given["euler"]));
            check(&item, "q", &q, &expected["q"]);
            for (row, expected) in rotation::matrix(q)
                .iter()
                .zip(expected["R"].as_array().unwrap())
            {
                check(&item, "R", row, expected);
            }
        } else {
            panic!("{id}");
        }
    }
    assert_eq!(seen, 43);
}

fn moving(velocity: Six<f64>) -> State {
    State {
        position: [0.0; 3],
        attitude: [1.0, 0.0, 0.0, 0.0],
        velocity,
    }
}

/// The unit step of the thruster's lag, (6136 s + 108700)/(s^3 + 89 s^2 + 9258 s + 108700), by the matrix exponential.
fn lag_step(time: f64) -> f64 {
    use planesman_linear::{DMatrix, exponential};
    let den = [89.0, 9258.0, 108_700.0];
    let mut a = Matrix3::zeros();
    for i in 0..3 {
        a[(0, i)] = -den[i];
    }
    a[(1, 0)] = 1.0;
    a[(2, 1)] = 1.0;
    let mut whole = DMatrix::zeros(4, 4);
    whole.view_mut((0, 0), (3, 3)).copy_from(&(a * time));
    whole[(0, 3)] = time;
    let of = exponential(&whole);
    6136.0 * of[(1, 3)] + 108_700.0 * of[(2, 3)]
}
