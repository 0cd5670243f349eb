//! Invariants of the equations of motion: energy, momentum, symmetry.

use planesman_vehicle::{
    BRUNNER_SECANT_RATE, BRUNNER_VISCOUS_DAMPING, Derivatives, Environment, Motion, PitchDamping,
    PlanePath, Restoring, State, Variant, vehicle_file::brunner,
};

fn motion(derivatives: Derivatives, restoring: Restoring) -> Motion {
    Motion {
        derivatives,
        restoring,
        environment: Environment {
            density: 999.835,
            gravity: 9.81456,
            atmospheric_pressure: 101_325.0,
        },
        step: 0.001,
    }
}

/// Deep enough for the surface to play no part.
const DEEP: f64 = 500.0;

/// Every thousandth of a second for so many, the planes along `planes`.
fn fly(motion: &Motion, from: State, seconds: u32, planes: impl Fn(f64) -> f64) -> Vec<State> {
    let mut states = vec![from];
    let mut state = from;
    for k in 0..seconds * 1000 {
        let angle = planes(f64::from(k) * motion.step);
        state = motion
            .advance(&state, &PlanePath::held(&angle), 1)
            .expect("it moves");
        states.push(state);
    }
    states
}

/// `I q^2 / 2 + W BG (1 - cos theta)` \[J\].
fn pendulum_energy(d: &Derivatives, state: &State) -> f64 {
    0.5 * d.pitch_inertia * state.pitch_rate.powi(2) + d.restoring * (1.0 - libm::cos(state.pitch))
}

fn tilted(pitch: f64, pitch_rate: f64) -> State {
    State {
        depth: DEEP,
        pitch,
        pitch_rate,
        ..State::default()
    }
}

#[test]
fn at_rest_in_the_water_the_vehicle_is_a_pendulum_that_keeps_its_energy() {
    let d = brunner().derivatives(0.0);
    let motion = motion(d, Restoring::Sine);
    // Swinging, swinging wide, and going over the top.
    for start in [tilted(0.1, 0.0), tilted(2.5, 0.3), tilted(0.0, 2.0)] {
        let energy = pendulum_energy(&d, &start);
        for state in fly(&motion, start, 60, |_| 0.0) {
            let found = pendulum_energy(&d, &state);
            assert!((found / energy - 1.0).abs() < 1e-9, "{found} from {energy}");
        }
    }
}

#[test]
fn its_small_swings_have_the_pendulum_s_period() {
    let d = brunner().derivatives(0.0);
    let states = fly(&motion(d, Restoring::Sine), tilted(1e-4, 0.0), 60, |_| 0.0);
    let frequency = (d.restoring / d.pitch_inertia).sqrt();
    for (k, state) in states.iter().enumerate() {
        let expected = 1e-4 * libm::cos(frequency * k as f64 * 0.001);
        assert!((state.pitch - expected).abs() < 1e-11);
    }
}

#[test]
fn as_speed_goes_to_zero_so_does_all_but_the_pendulum() {
    let still = fly(
        &motion(brunner().derivatives(0.0), Restoring::Sine),
        tilted(0.5, 0.0),
        20,
        |_| 0.3,
    );
    let mut farthest = f64::INFINITY;
    for speed in [1e-2, 1e-3, 1e-4] {
        let slow = motion(brunner().derivatives(speed), Restoring::Sine);
        let apart = fly(&slow, tilted(0.5, 0.0), 20, |_| 0.3)
            .iter()
            .zip(&still)
            .map(|(a, b)| (a.pitch - b.pitch).abs())
            .fold(0.0, f64::max);
        assert!(apart < 0.2 * farthest, "{apart} at {speed} m/s");
        farthest = apart;
    }
    assert!(farthest < 5e-3);
}

#[test]
fn damped_by_any_law_the_pendulum_only_loses_energy() {
    let viscous = BRUNNER_VISCOUS_DAMPING;
    let rate = BRUNNER_SECANT_RATE;
    for damping in [
        PitchDamping::Secant { viscous, rate },
        PitchDamping::Tangent { viscous, rate },
        PitchDamping::Quadratic { viscous },
    ] {
        let variant = Variant {
            damping,
            ..Variant::default()
        };
        let d = variant.apply(brunner().derivatives(0.0));
        let start = tilted(2.0, 0.0);
        let mut energy = pendulum_energy(&d, &start);
        for state in fly(&motion(d, Restoring::Sine), start, 60, |_| 0.0) {
            let found = pendulum_energy(&d, &state);
            assert!(found <= energy * (1.0 + 1e-13), "{damping:?}");
            energy = found;
        }
        let left = energy / pendulum_energy(&d, &start);
        assert!(left < 0.05, "{damping:?}: {left} of it is left");
    }
}

#[test]
fn small_damped_swings_follow_the_exponential() {
    let variant = Variant {
        damping: PitchDamping::Secant {
            viscous: BRUNNER_VISCOUS_DAMPING,
            rate: BRUNNER_SECANT_RATE,
        },
        ..Variant::default()
    };
    let d = variant.apply(brunner().derivatives(0.0));
    let decay = -d.m_q / (2.0 * d.pitch_inertia);
    let frequency = (d.restoring / d.pitch_inertia - decay * decay).sqrt();
    let states = fly(&motion(d, Restoring::Sine), tilted(1e-4, 0.0), 60, |_| 0.0);
    for (k, state) in states.iter().enumerate() {
        let t = k as f64 * 0.001;
        let expected = 1e-4
            * libm::exp(-decay * t)
            * (libm::cos(frequency * t) + decay / frequency * libm::sin(frequency * t));
        assert!((state.pitch - expected).abs() < 1e-11);
    }
}

#[test]
fn without_forces_the_vehicle_keeps_turning_and_sinking_as_it_did() {
    let free = Variant {
        restoring_moment: false,
        ..Variant::default()
    };
    let d = free.apply(brunner().derivatives(0.0));
    let start = State {
        heave: 0.2,
        ..tilted(0.3, 0.7)
    };
    for state in fly(&motion(d, Restoring::Sine), start, 60, |_| 0.5) {
        assert_eq!(
            (state.heave, state.pitch_rate),
            (start.heave, start.pitch_rate)
        );
    }
}

#[test]
fn mirrored_planes_and_starts_give_the_mirrored_motion() {
    for speed in [0.0, 0.3, 0.6] {
        for damping in [
            PitchDamping::Coefficient,
            PitchDamping::Quadratic {
                viscous: BRUNNER_VISCOUS_DAMPING,
            },
        ] {
            let variant = Variant {
                damping,
                ..Variant::default()
            };
            let motion = motion(variant.apply(brunner().derivatives(speed)), Restoring::Sine);
            let start = State {
                heave: 0.05,
                ..tilted(0.2, -0.1)
            };
            let mirrored_start = State {
                heave: -0.05,
                ..tilted(-0.2, 0.1)
            };
            let wave = |t: f64| 0.5 * libm::sin(1.3 * t) + 0.1;
            let flown = fly(&motion, start, 20, wave);
            let mirrored = fly(&motion, mirrored_start, 20, |t| -wave(t));
            for (a, b) in flown.iter().zip(&mirrored) {
                assert_eq!(
                    (a.pitch, a.pitch_rate, a.heave),
                    (-b.pitch, -b.pitch_rate, -b.heave)
                );
                assert_eq!(a.distance, b.distance);
                // Depth alone has an origin, and rounds about it.
                assert!((a.depth - DEEP + (b.depth - DEEP)).abs() < 1e-9);
            }
        }
    }
}
