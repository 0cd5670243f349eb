//! The accelerometers measure the body's true motion: the second difference of its track
//! less gravity, under every load that the plant knows.

use planesman_plant::specific_force;
use planesman_vehicle::{
    AxisState, Body, BodyMotion, DepthLimits, Drive, Environment, GeneralisedForce, Inputs, Motion,
    PlanePath, Restoring, State, Tether, Variant, Vehicle,
    vehicle_file::{brunner, remus_100},
};

/// Short enough for second differences, long enough for their rounding.
const STEP: f64 = 1e-3;

/// A vehicle with all that it has, in a current and with a tether.
fn everything(vehicle: Vehicle, speed: f64) -> BodyMotion {
    BodyMotion {
        vertical: Motion {
            derivatives: vehicle.derivatives(speed),
            restoring: Restoring::Sine,
            environment: Environment {
                density: 999.835,
                gravity: 9.81456,
                atmospheric_pressure: 101_325.0,
            },
            step: STEP,
        },
        roll: vehicle.roll,
        yaw: vehicle.yaw,
        current: [0.1, -0.2, 0.05],
        depth_limits: DepthLimits::default(),
        tether: Tether {
            diameter: 0.003,
            drag_coefficient: 1.2,
            above: 0.05,
        },
        drive: vehicle.propulsion.map(|propulsion| Drive {
            propulsion,
            vehicle,
            variant: Variant::default(),
        }),
    }
}

fn position(body: &Body) -> [f64; 3] {
    [body.plane.distance, body.across, body.plane.depth]
}

/// The specific force forward, left, up by differences of the track, about the middle of three
/// bodies a step apart.
fn by_differences([before, now, after]: [&Body; 3], gravity: f64) -> [f64; 3] {
    let [a, b, c] = [before, now, after].map(position);
    let mut felt: [f64; 3] = std::array::from_fn(|i| (a[i] - 2.0 * b[i] + c[i]) / (STEP * STEP));
    felt[2] -= gravity;
    let [forward, right, down] = now.attitude().to_body(felt);
    [forward, -right, -down]
}

#[test]
fn the_specific_force_is_the_track_s_second_difference_less_gravity_under_any_load() {
    let waves = [
        GeneralisedForce::NONE,
        GeneralisedForce {
            heave: 1.5,
            pitch: -0.2,
        },
    ];
    let starts = [
        (0.0, 0.0, 0.0, 0.0),
        (-0.4, 0.05, 0.2, 0.3),
        (1.2, -0.1, -0.3, -0.8),
    ];
    for (vehicle, speed) in [(brunner(), 0.5), (remus_100(), 1.5)] {
        let motion = everything(vehicle, speed);
        let gravity = motion.vertical.environment.gravity;
        for load in waves {
            for (pitch, heave, rate, heel) in starts {
                for thrust in [0.0, 1.0] {
                    let inputs = Inputs {
                        dive_planes: PlanePath::held(&0.2),
                        bow_stern_differential: PlanePath::held(&0.1),
                        roll_differential: PlanePath::held(&0.1),
                        rudder: PlanePath::held(&-0.3),
                        thrust: PlanePath::held(&thrust),
                    };
                    // A vehicle without a plant for it stays as it is.
                    let turn = |turns: bool| AxisState {
                        angle: heel,
                        rate: if turns { 0.1 } else { 0.0 },
                    };
                    let plane = State {
                        distance: 0.0,
                        depth: 3.0,
                        pitch,
                        heave,
                        pitch_rate: rate,
                    };
                    let before = Body {
                        roll: turn(motion.roll.is_some()),
                        yaw: turn(motion.yaw.is_some()),
                        ..Body::upright(plane, speed)
                    };
                    let one_on = |body: &Body| motion.advance(body, &inputs, load, 1).unwrap().0;
                    let now = one_on(&before);
                    let after = one_on(&now);
                    let acceleration = motion.acceleration(&now, &inputs, load);
                    let felt = specific_force(&now, &acceleration, gravity);
                    let expected = by_differences([&before, &now, &after], gravity);
                    for (felt, expected) in felt.into_iter().zip(expected) {
                        assert!((felt - expected).abs() < 2e-5, "{felt} is not {expected}");
                    }
                }
            }
        }
    }
}

#[test]
fn surface_and_bottom_are_felt_while_they_hold_the_vehicle_at_its_depth() {
    let inputs = Inputs {
        dive_planes: PlanePath::held(&0.1),
        thrust: PlanePath::held(&1.0),
        ..Inputs::all(PlanePath::NEUTRAL)
    };
    let mut motion = everything(brunner(), 0.5);
    motion.current = [0.0; 3];
    motion.depth_limits.bottom = Some(2.0);
    let gravity = motion.vertical.environment.gravity;
    for (depth, pitch, heel) in [(0.0, 0.3, 0.2), (2.0, -0.4, -0.1)] {
        let plane = State {
            depth,
            pitch,
            pitch_rate: 0.2,
            ..State::default()
        };
        let before = Body {
            roll: AxisState {
                angle: heel,
                rate: 0.0,
            },
            ..Body::upright(plane, 0.5)
        };
        let one_on = |body: &Body| {
            motion
                .advance(body, &inputs, GeneralisedForce::NONE, 1)
                .unwrap()
                .0
        };
        let now = one_on(&before);
        let after = one_on(&now);
        assert_eq!(after.plane.depth, depth, "it is held");
        let acceleration = motion.acceleration(&now, &inputs, GeneralisedForce::NONE);
        let felt = specific_force(&now, &acceleration, gravity);
        let expected = by_differences([&before, &now, &after], gravity);
        for (felt, expected) in felt.into_iter().zip(expected) {
            assert!((felt - expected).abs() < 2e-5, "{felt} is not {expected}");
        }
        assert!(acceleration.boundary.abs() > 1e-2, "something is felt");
        // On the way off it is left to itself.
        let leaving = Body {
            plane: State {
                pitch: -pitch,
                ..now.plane
            },
            ..now
        };
        let free = motion.acceleration(&leaving, &inputs, GeneralisedForce::NONE);
        assert_eq!(free.boundary, 0.0);
    }
}

#[test]
fn thrust_is_felt_forwards_as_force_over_mass() {
    let vehicle = brunner();
    let propulsion = vehicle.propulsion.unwrap();
    let mass = vehicle.mass + propulsion.added_mass;
    let motion = BodyMotion {
        tether: Tether::default(),
        ..everything(vehicle, 0.0)
    };
    let inputs = Inputs {
        thrust: PlanePath::held(&1.0),
        ..Inputs::all(PlanePath::NEUTRAL)
    };
    let body = Body::default();
    let acceleration = motion.acceleration(&body, &inputs, GeneralisedForce::NONE);
    let [forward, left, up] = specific_force(&body, &acceleration, 9.81456);
    assert!((forward - propulsion.full_thrust() / mass).abs() < 1e-12);
    assert_eq!((left, up), (0.0, 9.81456));
}
