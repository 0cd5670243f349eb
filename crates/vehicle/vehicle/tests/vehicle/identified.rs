//! An identified model is loaded as the vehicle it was identified from, or refused.

use planesman_linear::{Complex, ComplexFunctions as _, polynomial};
use planesman_model_file::{Heave, ModelFile, Physical};
use planesman_units::FOOT;
use planesman_vehicle::Vehicle;
use planesman_vehicle::identified;
use planesman_vehicle::linearised::{self, Output};
use planesman_vehicle::vehicle_file::{brunner, geometry_on, load_on, remus_100};

const SAMPLE_TIME: f64 = 0.05;

/// The file that exact identification of the vehicle at a speed would write.
fn exact(vehicle: &Vehicle, speed: f64, output: Output) -> ModelFile {
    let model = linearised::response(&vehicle.derivatives(speed), output)
        .and_then(|it| it.zero_order_hold(SAMPLE_TIME)?.transfer_function(0, 0))
        .unwrap();
    let order = model.den.len() - 1;
    let num = model.num[model.num.len() - order..].to_vec();
    of_coefficients(num, model.den, speed, output)
}

fn of_coefficients(num: Vec<f64>, den: Vec<f64>, speed: f64, output: Output) -> ModelFile {
    let output = format!("/auv/state:{}", output.name());
    let input = "plane_motion:dive_planes";
    ModelFile {
        speed: Some(speed),
        ..ModelFile::exact(input, &output, SAMPLE_TIME, num, den)
    }
}

/// The vehicle with planes half as strong, twice the damping and a quarter of the righting moment.
fn changed(mut vehicle: Vehicle) -> Vehicle {
    vehicle.coefficients.m_delta *= 0.5;
    vehicle.coefficients.m_q *= 2.0;
    vehicle.restoring_arm *= 0.25;
    vehicle
}

fn same(found: &Vehicle, expected: &Vehicle, tolerance: f64) {
    for (found, expected) in [
        (found.coefficients.m_delta, expected.coefficients.m_delta),
        (found.coefficients.m_q, expected.coefficients.m_q),
        (found.coefficients.m_w, expected.coefficients.m_w),
        (found.coefficients.z_w, expected.coefficients.z_w),
        (found.coefficients.z_q, expected.coefficients.z_q),
        (found.coefficients.z_delta, expected.coefficients.z_delta),
        (found.restoring_arm, expected.restoring_arm),
    ] {
        assert!(
            (found / expected - 1.0).abs() < tolerance,
            "{found} is not {expected}"
        );
    }
}

#[test]
fn a_transfer_function_of_another_vehicle_makes_the_base_that_vehicle() {
    for output in [Output::PitchRate, Output::Pitch] {
        for (base, speed) in [(brunner(), 1.8 * FOOT), (remus_100(), 1.54)] {
            let truth = changed(base.clone());
            let found = identified::vehicle(&base, &exact(&truth, speed, output)).unwrap();
            same(&found, &truth, 1e-6);
        }
    }
}

#[test]
fn what_turns_in_pitch_with_the_righting_moment_rolls_with_it() {
    let base = brunner();
    let file = exact(&changed(base.clone()), FOOT, Output::PitchRate);
    let found = identified::vehicle(&base, &file).unwrap();
    let share = found.roll.unwrap().restoring / base.roll.unwrap().restoring;
    assert!((share - 0.25).abs() < 1e-6, "{share}");
}

#[test]
fn the_vehicle_s_own_equations_are_taken_at_their_word() {
    for (base, speed) in [(brunner(), 1.2 * FOOT), (remus_100(), 1.54)] {
        for heaves in [true, false] {
            let own = linearised::state_space(&base, speed).unwrap();
            let [kappa, beta, mu] = [1.2 * own.b[1], -0.9 * own.a[(1, 1)], -1.1 * own.a[(1, 2)]];
            let heave = heaves.then(|| Heave {
                to_pitch: 1.1 * own.a[(1, 0)],
                damping: -1.05 * own.a[(0, 0)],
                from_rate: 0.95 * own.a[(0, 1)],
                from_input: 0.8 * own.b[0],
            });
            let mut file = exact(&base, speed, Output::PitchRate);
            file.physical = Some(Physical {
                kappa,
                beta,
                mu,
                covariance: [[0.0; 3]; 3],
                heave,
            });
            let found = identified::vehicle(&base, &file).unwrap();
            let equations = linearised::state_space(&found, speed).unwrap();
            let (a, b) = (&equations.a, &equations.b);
            let is = |found: f64, expected: f64| {
                assert!(
                    (found - expected).abs() < 1e-10,
                    "{found} is not {expected}"
                );
            };
            is(b[1], kappa);
            is(a[(1, 1)], -beta);
            is(a[(1, 2)], -mu);
            match heave {
                Some(heave) => {
                    is(a[(1, 0)], heave.to_pitch);
                    is(a[(0, 0)], -heave.damping);
                    is(a[(0, 1)], heave.from_rate);
                    is(b[0], heave.from_input);
                }
                None => {
                    // Pitch was identified alone, so heave does not turn it.
                    is(a[(1, 0)], 0.0);
                    assert_eq!(found.coefficients.z_w, base.coefficients.z_w);
                }
            }
        }
    }
}

#[test]
fn a_second_order_model_makes_the_nearest_vehicle() {
    // Pitch alone: q' = -0.7 delta - 1.2 q - 0.1 theta, of a vehicle that also heaves.
    let s = polynomial::roots(&[1.0, 1.2, 0.1]).unwrap();
    let poles: Vec<Complex<f64>> = s.iter().map(|s| (s * SAMPLE_TIME).exp()).collect();
    let den = polynomial::from_roots(&poles).unwrap();
    let gain = -0.7 * ((poles[0] - poles[1]) / (s[0] - s[1])).re;
    let speed = 1.2 * FOOT;
    let file = of_coefficients(vec![gain, -gain], den, speed, Output::PitchRate);
    let base = brunner();
    let found = identified::vehicle(&base, &file).unwrap();
    let d = found.derivatives(speed);
    let kappa = d.m_delta / d.pitch_inertia;
    assert!((kappa + 0.7).abs() < 0.07, "{kappa}");
    assert_eq!(found.coefficients.z_w, base.coefficients.z_w);
}

#[test]
fn what_no_vehicle_follows_is_refused_with_how_far_it_is_off() {
    let base = brunner();
    let good = exact(&base, FOOT, Output::PitchRate);
    type Change = fn(&mut ModelFile);
    let refused: [(Change, &str); 9] = [
        (|m| m.speed = None, "the speed of the vehicle"),
        (|m| m.output = "state:depth".to_owned(), "state:depth"),
        (|m| m.input = "daq:dive_planes".to_owned(), "daq"),
        (|m| m.output = "imu:pitch_rate".to_owned(), "imu"),
        // Planes that do nothing for half a second.
        (
            |m| {
                m.num.splice(0..0, vec![0.0; 10]);
                m.den.extend([0.0; 10]);
                m.covariance = vec![vec![0.0; 26]; 26];
            },
            "differs by",
        ),
        // Two lags behind one another: planes move a vehicle's pitch rate sooner.
        (
            |m| {
                (m.num, m.den) = (vec![0.0, -0.01], vec![1.0, -1.9, 0.9025]);
                m.covariance = vec![vec![0.0; 4]; 4];
            },
            "differs by",
        ),
        (|m| m.covariance[0][0] = 1.0, "frequencies"),
        (|m| m.physical = Some(physical(0.5, -0.2)), "mu is negative"),
        (
            |m| m.physical = Some(physical(-0.5, 0.2)),
            "beta is negative",
        ),
    ];
    for (change, reason_part) in refused {
        let mut file = good.clone();
        change(&mut file);
        let refusal = identified::vehicle(&base, &file).unwrap_err().to_string();
        assert!(refusal.contains(reason_part), "{refusal}");
        assert!(!refusal.contains('\n'));
    }
}

#[test]
fn numbers_beyond_any_vehicle_are_refused_and_bring_nothing_down() {
    let base = brunner();
    let good = exact(&base, FOOT, Output::PitchRate);
    let own = Physical {
        heave: Some(Heave {
            to_pitch: 0.3,
            damping: 0.6,
            from_rate: 0.1,
            from_input: 0.02,
        }),
        ..physical(1.0, 0.2)
    };
    for wild in [1e308, -1e308, 1e150, 1e-308, 0.0] {
        for place in 0..8 {
            let mut file = good.clone();
            match place {
                0 => file.num[0] = wild,
                1 => file.den[1] = wild,
                2 => file.den[3] = wild,
                3 => file.covariance[0][0] = wild,
                4 => file.sample_time = wild.abs().max(1e-308),
                5 => file.speed = Some(wild.abs().max(1e-308)),
                6 => {
                    file.physical = Some(Physical {
                        kappa: wild,
                        ..own.clone()
                    });
                }
                _ => {
                    let mut equations = own.clone();
                    equations.heave.as_mut().unwrap().damping = wild;
                    file.physical = Some(equations);
                }
            }
            match identified::vehicle(&base, &file) {
                Ok(vehicle) => assert!(vehicle.coefficients.m_delta.is_finite()),
                Err(refusal) => assert!(!refusal.to_string().is_empty()),
            }
        }
    }
}

fn physical(beta: f64, mu: f64) -> Physical {
    Physical {
        kappa: -0.5,
        beta,
        mu,
        covariance: [[0.0; 3]; 3],
        heave: None,
    }
}

#[test]
fn a_model_file_is_distinguished_from_a_vehicle_file_by_what_it_says() {
    let folder = tempfile::tempdir().unwrap();
    let truth = changed(brunner());
    for name in ["model.yaml", "model.json"] {
        let path = folder.path().join(name);
        exact(&truth, FOOT, Output::PitchRate).write(&path).unwrap();
        let path = path.to_str().unwrap();
        same(&load_on(path, "brunner").unwrap(), &truth, 1e-6);
        assert!(geometry_on(path, "brunner").unwrap().is_some());
        assert!(geometry_on(path, "remus_100").unwrap().is_none());
        assert!(load_on(path, "no/such.yaml").is_err());
        let text = std::fs::read_to_string(path).unwrap();
        std::fs::write(path, text.replace("sample_time", "sampled")).unwrap();
        let refusal = load_on(path, "brunner").unwrap_err().to_string();
        assert!(
            refusal.contains("sampled") && refusal.contains(name),
            "{refusal}"
        );
    }
}
