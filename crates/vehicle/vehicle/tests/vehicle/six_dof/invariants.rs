//! What the equations must keep, whatever the vehicle: energy, impulse, mirror images, a current that carries all, the choice of the origin.

use std::f64::consts::PI;

use nalgebra::{SMatrix, SVector};
use planesman_vehicle::six_dof::{
    Accurate, Batch, Damping, Matrix6, RigidBody, Sea, Simulation, Six, State, Three, Vehicle,
    Water, Wave, about_origin, ellipsoid, rotation, runge_kutta,
};
use planesman_vehicle::{GeneralisedForce, Restoring, standard_normal, vehicle_file};
use rand_pcg::{Pcg64, rand_core::SeedableRng};

use super::{changed, vehicle};

const ALL: [&str; 4] = ["general_body", "remus_100", "bluerov2_heavy", "lauv"];
const ACCURATE: Accurate = Accurate {
    relative: 1e-12,
    absolute: 1e-12,
};

fn draw<const N: usize>(random: &mut Pcg64, size: f64) -> [f64; N] {
    std::array::from_fn(|_| size * standard_normal(random))
}

/// A state and inputs drawn at random.
fn drawn(of: &Vehicle, random: &mut Pcg64) -> (State, Vec<f64>) {
    let state = State {
        position: draw(random, 3.0),
        attitude: rotation::from_euler(draw(random, 1.0)),
        velocity: draw(random, 0.5),
    };
    let rotating = of.parts().name == "general_body";
    let count = of.parts().inputs.len();
    let inputs = (0..count).map(|k| match rotating && k == 4 {
        true => 80.0 * standard_normal(random),
        false => 0.3 * standard_normal(random),
    });
    (state, inputs.collect())
}

fn times(a: &Matrix6, x: &Six<f64>) -> Six<f64> {
    std::array::from_fn(|i| (0..6).map(|j| a[i][j] * x[j]).sum())
}

fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

fn cross(a: Three<f64>, b: Three<f64>) -> Three<f64> {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

fn turned(attitude: [f64; 4], v: Three<f64>) -> Three<f64> {
    rotation::matrix(attitude).map(|row| dot(&row, &v))
}

fn close<const N: usize>(a: &[f64; N], b: &[f64; N], allowed: f64) {
    for (x, y) in a.iter().zip(b) {
        assert!((x - y).abs() <= allowed * y.abs().max(1.0), "{a:?} {b:?}");
    }
}

/// The vehicle without damping, fins and propulsion.
fn ideal(of: &Vehicle) -> Vehicle {
    changed(of, |parts| {
        parts.damping = Damping::default();
        parts.terms.clear();
        parts.fins.clear();
        parts.propulsors.clear();
    })
}

fn kinetic(of: &Vehicle, state: &State) -> f64 {
    0.5 * dot(&state.velocity, &times(&of.inertia(), &state.velocity))
}

fn flown(of: &Vehicle, sea: &Sea, state: State, seconds: f64, inputs: &[f64]) -> State {
    let mut simulation = Simulation::new(of, sea, state, ACCURATE);
    simulation.advance(seconds, inputs).unwrap();
    simulation.state
}

/// Sec. 126 of Lamb's Hydrodynamics: no force but its own pressure acts on a body in an ideal fluid.
#[test]
fn without_damping_energy_and_impulse_are_kept() {
    let mut random = Pcg64::seed_from_u64(1);
    for name in ALL {
        let of = ideal(&vehicle(name));
        let count = of.parts().inputs.len();
        // Weight and buoyancy balance.
        let free = changed(&of, |parts| {
            parts.buoyancy = parts.weight;
            parts.centre_of_buoyancy = parts.body.centre_of_gravity;
        });
        for _ in 0..3 {
            let (state, _) = drawn(&of, &mut random);
            let impulse = |state: &State| {
                let [a, b, c, d, e, f] = times(&free.inertia(), &state.velocity);
                let (p, h) = (
                    turned(state.attitude, [a, b, c]),
                    turned(state.attitude, [d, e, f]),
                );
                let about = cross(state.position, p);
                [
                    p[0],
                    p[1],
                    p[2],
                    h[0] + about[0],
                    h[1] + about[1],
                    h[2] + about[2],
                ]
            };
            let after = flown(&free, &Sea::default(), state, 10.0, &vec![0.0; count]);
            close(&impulse(&after), &impulse(&state), 1e-8);
            close(&[kinetic(&free, &after)], &[kinetic(&free, &state)], 1e-9);

            let energy = |state: &State| {
                let parts = of.parts();
                let below = |r: Three<f64>| state.position[2] + turned(state.attitude, r)[2];
                kinetic(&of, state) - parts.weight * below(parts.body.centre_of_gravity)
                    + parts.buoyancy * below(parts.centre_of_buoyancy)
            };
            let after = flown(&of, &Sea::default(), state, 10.0, &vec![0.0; count]);
            close(&[energy(&after)], &[energy(&state)], 1e-8);
        }
    }
}

#[test]
fn coriolis_forces_do_no_work_and_all_others_change_the_energy_by_their_power() {
    let mut random = Pcg64::seed_from_u64(2);
    for name in ALL {
        let of = vehicle(name);
        for _ in 0..20 {
            let (state, inputs) = drawn(&of, &mut random);
            let forces = of.forces(&state, &inputs, &Water::at_rest());
            let nu = state.velocity;
            for idle in [forces.rigid_body_coriolis, forces.added_mass_coriolis] {
                let scale = idle.iter().map(|x| x.abs()).fold(0.0, f64::max);
                assert!(dot(&nu, &idle).abs() <= 1e-12 * (1.0 + scale));
            }
            let rate = dot(
                &nu,
                &times(
                    &of.inertia(),
                    &of.acceleration(&state, &inputs, &Water::at_rest()),
                ),
            );
            close(&[rate], &[dot(&nu, &forces.total())], 1e-10);
            let drained = dot(&nu, &forces.damping);
            assert!(drained <= 0.0 || name == "general_body", "{name} {drained}");
        }
    }
}

/// Lamb, art. 127: broadside, a body of revolution swings like a pendulum about its course. Period `4 K(sin(s/2)) / Omega`, by the
/// arithmetic-geometric mean.
#[test]
fn an_ellipsoid_in_its_own_stream_is_kirchhoffs_pendulum() {
    let (a, b, rho) = (0.8, 0.1, 1000.0);
    let mass = rho * 4.0 / 3.0 * PI * a * b * b;
    let added = ellipsoid(rho, [a, b, b]);
    let turning = mass * (a * a + b * b) / 5.0;
    let of = changed(&ideal(&vehicle("lauv")), |parts| {
        parts.body = RigidBody {
            mass,
            centre_of_gravity: [0.0; 3],
            inertia: [
                [mass * 2.0 * b * b / 5.0, 0.0, 0.0],
                [0.0, turning, 0.0],
                [0.0, 0.0, turning],
            ],
        };
        parts.added_mass =
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { added[i] } else { 0.0 }));
        parts.buoyancy = parts.weight;
    });
    let (m1, m3, inertia) = (mass + added[0], mass + added[2], turning + added[4]);
    // Impulse P straight down, the nose off broadside by `off`: 2 theta - pi swings with amplitude 2 off.
    let (impulse, off) = (40.0, 0.4);
    let omega = impulse * ((1.0 / m1 - 1.0 / m3) / inertia).sqrt();
    let pitch: f64 = off;
    let start = State {
        position: [0.0; 3],
        attitude: rotation::from_euler([0.0, pitch, 0.0]),
        velocity: [
            -impulse * libm::sin(pitch) / m1,
            0.0,
            impulse * libm::cos(pitch) / m3,
            0.0,
            0.0,
            0.0,
        ],
    };
    let (mut x, mut y) = (1.0, libm::cos(off));
    for _ in 0..10 {
        (x, y) = (0.5 * (x + y), (x * y).sqrt());
    }
    let period = 4.0 * (PI / (2.0 * x)) / omega;
    let after = |share: f64| flown(&of, &Sea::default(), start, share * period, &[0.0; 3]);
    let pitch_at = |share| rotation::euler(after(share).attitude)[1];
    close(
        &[pitch_at(0.25), pitch_at(0.5), pitch_at(1.0)],
        &[0.0, -off, off],
        1e-8,
    );
    // The Munk moment alone, and no force: K of a body that moves askew.
    let askew = State {
        velocity: [1.0, 0.3, 0.0, 0.0, 0.0, 0.0],
        ..start
    };
    let forces = of
        .forces(&askew, &[0.0; 3], &Water::at_rest())
        .added_mass_coriolis;
    close(
        &forces,
        &[0.0, 0.0, 0.0, 0.0, 0.0, (added[0] - added[1]) * 0.3],
        1e-12,
    );
}

/// What is to starboard becomes what is to port.
#[test]
fn the_mirror_image_of_a_motion_is_a_motion() {
    let mut random = Pcg64::seed_from_u64(3);
    let sign: Six<f64> = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
    for (name, image) in [
        (
            "remus_100",
            (|x: &[f64]| vec![-x[0], x[1]]) as fn(&[f64]) -> Vec<f64>,
        ),
        ("lauv", |x| vec![-x[0], x[1], x[2]]),
        ("bluerov2_heavy", |x| {
            vec![x[1], x[0], x[3], x[2], x[5], x[4], x[7], x[6]]
        }),
    ] {
        // The propeller's torque has a hand.
        let of = changed(&vehicle(name), |parts| {
            if name == "remus_100" {
                parts.propulsors.clear();
            }
        });
        for _ in 0..10 {
            let (state, inputs) = drawn(&of, &mut random);
            let [roll, pitch, yaw] = rotation::euler(state.attitude);
            let mirrored = State {
                position: state.position,
                attitude: rotation::from_euler([-roll, pitch, -yaw]),
                velocity: std::array::from_fn(|i| sign[i] * state.velocity[i]),
            };
            let [n, e, d] = draw(&mut random, 0.3);
            let found = of.acceleration(&mirrored, &image(&inputs), &Water::steady([n, -e, d]));
            let expected = of.acceleration(&state, &inputs, &Water::steady([n, e, d]));
            close(
                &found,
                &std::array::from_fn(|i| sign[i] * expected[i]),
                1e-9,
            );
        }
    }
}

/// A steady current carries the motion of still water along.
#[test]
fn in_a_current_the_motion_is_that_of_still_water_carried_along() {
    let mut random = Pcg64::seed_from_u64(4);
    for name in ALL {
        let of = vehicle(name);
        let (state, mut inputs) = drawn(&of, &mut random);
        inputs.iter_mut().for_each(|x| *x *= 0.3);
        let current: Three<f64> = draw(&mut random, 0.4);
        let sea = Sea {
            current,
            ..Sea::default()
        };
        let in_body = |attitude| {
            let r = rotation::matrix(attitude);
            std::array::from_fn::<f64, 3, _>(|i| (0..3).map(|j| r[j][i] * current[j]).sum())
        };
        let over_ground = |state: &State| {
            let c = in_body(state.attitude);
            let mut velocity = state.velocity;
            (0..3).for_each(|i| velocity[i] += c[i]);
            velocity
        };
        let started = State {
            velocity: over_ground(&state),
            ..state
        };
        let seconds = 2.0;
        let still = flown(&of, &Sea::default(), state, seconds, &inputs);
        let carried = flown(&of, &sea, started, seconds, &inputs);
        close(&carried.velocity, &over_ground(&still), 1e-7);
        let place = std::array::from_fn(|i| still.position[i] + current[i] * seconds);
        close(&carried.position, &place, 1e-7);
    }
}

/// The origin of the body's axes is a choice.
#[test]
fn another_origin_gives_the_same_motion() {
    let mut random = Pcg64::seed_from_u64(5);
    let of = changed(&vehicle("general_body"), |parts| {
        parts.damping.quadratic = Matrix6::default();
        parts.fins.clear();
        parts.propulsors.clear();
    });
    let d: Three<f64> = [0.2, -0.1, 0.15];
    // nu_old = H nu_new, v_old = v_new - w x d.
    let h = SMatrix::<f64, 6, 6>::from_fn(|i, j| {
        let shift = [[0.0, -d[2], d[1]], [d[2], 0.0, -d[0]], [-d[1], d[0], 0.0]];
        match (i, j) {
            (i, j) if i == j => 1.0,
            (0..3, 3..6) => shift[i][j - 3],
            _ => 0.0,
        }
    });
    let moved = |a: &Matrix6| -> Matrix6 {
        let a = SMatrix::<f64, 6, 6>::from_fn(|i, j| a[i][j]);
        let b = h.transpose() * a * h;
        std::array::from_fn(|i| std::array::from_fn(|j| b[(i, j)]))
    };
    let there = changed(&of, |parts| {
        let body = &parts.body;
        let r: Three<f64> = std::array::from_fn(|i| body.centre_of_gravity[i] - d[i]);
        // About the centre of gravity and out again.
        let about_gravity = about_origin(body.inertia, -body.mass, body.centre_of_gravity);
        parts.body = RigidBody {
            mass: body.mass,
            centre_of_gravity: r,
            inertia: about_origin(about_gravity, body.mass, r),
        };
        (0..3).for_each(|i| parts.centre_of_buoyancy[i] -= d[i]);
        parts.added_mass = moved(&parts.added_mass);
        parts.damping.linear = moved(&parts.damping.linear);
    });
    let (state, inputs) = drawn(&of, &mut random);
    let of_new = |state: &State| {
        let [u, v, w, p, q, r] = state.velocity;
        let turn = cross([p, q, r], d);
        let far = turned(state.attitude, d);
        State {
            position: std::array::from_fn(|i| state.position[i] + far[i]),
            attitude: state.attitude,
            velocity: [u + turn[0], v + turn[1], w + turn[2], p, q, r],
        }
    };
    let sea = Sea {
        current: [0.3, -0.2, 0.1],
        ..Sea::default()
    };
    let here = of_new(&flown(&of, &sea, state, 3.0, &inputs));
    let there = flown(&there, &sea, of_new(&state), 3.0, &inputs);
    close(&there.row(), &here.row(), 1e-8);
}

/// Water that accelerates, by a current that turns or by waves, takes a neutral homogeneous body with it.
#[test]
fn a_stream_that_turns_carries_a_neutral_homogeneous_body() {
    let of = changed(&ideal(&vehicle("general_body")), |parts| {
        parts.body.centre_of_gravity = [0.0; 3];
        parts.body.inertia = [[0.9, 0.0, 0.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.4]];
        parts.centre_of_buoyancy = [0.0; 3];
        (parts.weight, parts.buoyancy) = (9.81 * parts.body.mass, 9.81 * parts.body.mass);
    });
    let sea = Sea {
        current: [0.4, -0.3, 0.0],
        turning: 0.5,
        ..Sea::default()
    };
    let attitude = rotation::from_euler([0.3, -0.2, 0.8]);
    let in_body = |v: Three<f64>| {
        let r = rotation::matrix(attitude);
        std::array::from_fn::<f64, 3, _>(|i| (0..3).map(|j| r[j][i] * v[j]).sum())
    };
    let [u, v, w] = in_body(sea.current);
    let start = State {
        position: [0.0, 0.0, 5.0],
        attitude,
        velocity: [u, v, w, 0.0, 0.0, 0.0],
    };
    let after = flown(&of, &sea, start, 4.0, &[0.0; 5]);
    let [u, v, w] = in_body(sea.at([0.0; 3], [0.0; 3], 4.0).velocity);
    close(&after.velocity, &[u, v, w, 0.0, 0.0, 0.0], 1e-9);
}

/// Along the way of a vehicle the water's velocity changes as its derivative says.
#[test]
fn the_water_along_the_way_changes_by_its_own_derivative() {
    let sea = Sea {
        current: [0.3, 0.1, 0.0],
        turning: 0.05,
        shear: [-0.02, 0.01],
        waves: vec![
            Wave {
                amplitude: 0.4,
                period: 6.0,
                direction: 0.7,
                phase: 0.3,
            },
            Wave {
                amplitude: 0.2,
                period: 3.0,
                direction: -2.0,
                phase: 1.0,
            },
        ],
        ..Sea::default()
    };
    let (place, speed) = ([2.0, -1.0, 4.0], [1.2, 0.4, -0.3]);
    let at = |t: f64| {
        sea.at(
            std::array::from_fn(|i| place[i] + speed[i] * t),
            speed,
            10.0 + t,
        )
    };
    let h = 1e-4;
    let (before, now, after) = (at(-h), at(0.0), at(h));
    let slope = std::array::from_fn(|i| (after.velocity[i] - before.velocity[i]) / (2.0 * h));
    close(&now.acceleration, &slope, 1e-7);
    let standing = |t: f64| sea.at(place, [0.0; 3], 10.0 + t).velocity;
    let slope = std::array::from_fn(|i| (standing(h)[i] - standing(-h)[i]) / (2.0 * h));
    close(&now.of_water, &slope, 1e-7);
}

#[test]
fn upright_neutral_and_at_rest_it_stays_and_a_small_roll_swings_at_its_frequency() {
    let of = changed(&vehicle("bluerov2_heavy"), |parts| {
        parts.buoyancy = parts.weight;
        parts.damping = Damping::default();
    });
    let rest = State {
        position: [0.0, 0.0, 3.0],
        attitude: [1.0, 0.0, 0.0, 0.0],
        velocity: [0.0; 6],
    };
    assert_eq!(
        of.derivative(&rest, &[0.0; 8], &Water::at_rest()),
        [0.0; 13]
    );
    let arm = 0.01 * of.parts().buoyancy;
    let omega = (arm / (0.26 + 0.189)).sqrt();
    let heeled = State {
        attitude: rotation::from_euler([1e-4, 0.0, 0.0]),
        ..rest
    };
    let after = flown(&of, &Sea::default(), heeled, PI / omega, &[0.0; 8]);
    close(&[1e4 * rotation::euler(after.attitude)[0]], &[-1.0], 1e-6);
}

/// The equations of the vertical plane are these without sway, roll and yaw, surge held by a force along x.
#[test]
fn without_sway_roll_and_yaw_the_equations_are_those_of_the_plane() {
    let mut random = Pcg64::seed_from_u64(6);
    let planar = vehicle_file::remus_100();
    let of = changed(&vehicle("remus_100"), |parts| parts.propulsors.clear());
    for _ in 0..50 {
        let [w, q, pitch, planes] = draw(&mut random, 0.3);
        let u = 1.0 + standard_normal(&mut random).abs();
        let state = State {
            position: [0.0, 0.0, 5.0],
            attitude: rotation::from_euler([0.0, pitch, 0.0]),
            velocity: [u, 0.0, w, 0.0, q, 0.0],
        };
        let forces = of.forces(&state, &[0.0, planes], &Water::at_rest()).total();
        close(&[forces[1], forces[3], forces[5]], &[0.0; 3], 1e-12);
        let m = of.inertia();
        let determinant = m[2][2] * m[4][4] - m[2][4] * m[4][2];
        let found = [
            (m[4][4] * forces[2] - m[2][4] * forces[4]) / determinant,
            (m[2][2] * forces[4] - m[4][2] * forces[2]) / determinant,
        ];
        let in_plane = planesman_vehicle::State {
            pitch,
            heave: w,
            pitch_rate: q,
            ..planesman_vehicle::State::default()
        };
        let (heave, turning) = planar.derivatives(u).accelerations(
            &in_plane,
            planes,
            Restoring::Sine,
            GeneralisedForce::NONE,
        );
        close(&found, &[heave, turning], 1e-12);
    }
}

/// A loop through straight up comes back, and the quaternion keeps its length.
#[test]
fn a_loop_through_straight_up_comes_back() {
    let of = changed(&ideal(&vehicle("bluerov2_heavy")), |parts| {
        parts.buoyancy = parts.weight;
        parts.centre_of_buoyancy = [0.0; 3];
    });
    let start = State {
        position: [0.0; 3],
        attitude: rotation::from_euler([0.0, 0.2, 0.5]),
        velocity: [0.0, 0.0, 0.0, 0.0, 0.7, 0.0],
    };
    let after = flown(&of, &Sea::default(), start, 2.0 * PI / 0.7, &[0.0; 8]);
    let along: f64 = dot(&after.attitude, &start.attitude);
    close(
        &[along.abs(), dot(&after.attitude, &after.attitude)],
        &[1.0, 1.0],
        1e-9,
    );
    let up = flown(
        &of,
        &Sea::default(),
        start,
        (PI / 2.0 - 0.2) / 0.7,
        &[0.0; 8],
    );
    assert!(rotation::matrix(up.attitude)[2][0] < -1.0 + 1e-9);
}

/// Prestero 2001, (4.43): at small angles a fin gives `1/2 rho S a (u^2 delta - u v - x u r)`.
#[test]
fn at_small_angles_a_fin_is_its_coefficient_form() {
    let general = vehicle("general_body");
    let of = changed(&general, |parts| parts.fins.retain(|fin| fin.input == 1));
    let fin = of.parts().fins[0];
    let scale = 0.5 * fin.density * fin.area * fin.section.slope;
    let (u, v, r, delta) = (1.3, 2e-5, 1e-5, 3e-5);
    let state = State {
        position: [0.0; 3],
        attitude: [1.0, 0.0, 0.0, 0.0],
        velocity: [u, v, 0.0, 0.0, 0.0, r],
    };
    let force = of
        .forces(&state, &[0.0, delta, 0.0, 0.0, 0.0], &Water::at_rest())
        .fins;
    let wanted = scale * (u * u * delta - u * v - fin.position[0] * u * r);
    // Drag without lift acts along the flow: C_D0 u (v + x r) across.
    let drag = 0.5 * fin.density * fin.area * fin.section.drag * u * (v + fin.position[0] * r);
    close(&[1e4 * force[1]], &[1e4 * (wanted - drag)], 1e-5);
    close(
        &[1e4 * force[5]],
        &[1e4 * (fin.position[0] * force[1] - fin.position[1] * force[0])],
        1e-9,
    );
}

/// Sum of squares of the thrusts is least among all that give the force, and the direction is kept when they saturate.
#[test]
fn allocation_gives_the_wanted_force() {
    use planesman_vehicle::six_dof::propulsion::{Allocation, Propulsor};
    let of = vehicle("bluerov2_heavy");
    let thrusters: Vec<_> = of
        .parts()
        .propulsors
        .iter()
        .filter_map(|propulsor| match propulsor {
            Propulsor::Thruster { thruster, .. } => Some(thruster),
            _ => None,
        })
        .collect();
    let allocation = Allocation::new(&thrusters).unwrap();
    let mut random = Pcg64::seed_from_u64(7);
    for _ in 0..10 {
        let wanted: Six<f64> = draw(&mut random, 10.0);
        let given = |thrusts: &[f64]| -> Six<f64> {
            let mut sum = SVector::<f64, 6>::zeros();
            for (thruster, thrust) in thrusters.iter().zip(thrusts) {
                sum += SVector::from(thruster.wrench()) * *thrust;
            }
            sum.into()
        };
        close(&given(&allocation.thrusts(&wanted)), &wanted, 1e-12);
        let (limited, _) = allocation.within(&wanted, 2.0);
        assert!(limited.iter().all(|t| t.abs() <= 2.0 + 1e-12));
        let share = given(&limited)[0] / wanted[0];
        close(&given(&limited), &wanted.map(|x| x * share), 1e-9);
    }
    assert_eq!(Allocation::new(&thrusters[..4]).unwrap_err().rank, 3);
}

/// Of any number, and in parts of any size for threads: to the last bit.
#[test]
fn a_vehicle_in_a_batch_moves_as_it_does_alone() {
    let bits = |state: &State| state.row().map(f64::to_bits);
    for name in ALL {
        let of = vehicle(name);
        let mut random = Pcg64::seed_from_u64(11);
        for count in [1, 7, 8, 9, 20] {
            let drawn: Vec<_> = (0..count)
                .map(|_| {
                    let (state, inputs) = drawn(&of, &mut random);
                    let water = Water {
                        velocity: draw(&mut random, 0.3),
                        acceleration: draw(&mut random, 0.1),
                        of_water: draw(&mut random, 0.1),
                        ..Water::at_rest()
                    };
                    (state, inputs, water)
                })
                .collect();
            let alone = drawn.iter().map(|(state, inputs, water)| {
                let step = |state, _| runge_kutta(&of, &state, inputs, water, 0.02);
                bits(&(0..10).fold(*state, step))
            });
            let alone: Vec<_> = alone.collect();
            let starts: Vec<State> = drawn.iter().map(|(state, ..)| *state).collect();
            let mut batch = Batch::new(&of, &starts);
            for (k, (_, inputs, water)) in drawn.iter().enumerate() {
                batch.set_inputs(k, inputs);
                batch.set_water(k, water);
            }
            for size in [1, 8, 9, 100] {
                let mut together = Vec::new();
                for mut part in batch.clone().split(size) {
                    part.advance(4, 0.02);
                    part.advance(6, 0.02);
                    together.extend((0..part.len()).map(|k| bits(&part.state(k))));
                }
                assert_eq!(together, alone, "{name}: {count} in parts of {size}");
            }
        }
    }
}
