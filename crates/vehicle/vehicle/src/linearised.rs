//! Linear models of the vehicle for small deviations from level flight at a constant speed.
//!
//! The states are `(w, q, theta, z)`, the input is the plane angle `delta`, the outputs are `(q, theta, z, w)`. The equations come from `dynamics`,
//! with the derivatives of the forces ([`Derivatives::slopes`]) in level flight (`trim`). A neutral vehicle flies level on an even keel. Without
//! coupling of the inertias the model is then
//!
//! ```text
//! w'     = (Z_w w + (Z_q + m U) q + Z_delta delta) / (m - Z_wdot)
//! q'     = (M_w w + M_q q - W BG theta + M_delta delta) / (I_y - M_qdot)
//! theta' = q
//! z'     = w - U theta
//! ```
//!
//! A vehicle lighter than its displaced water flies level at a small angle to its path. All variables are then deviations from level
//! flight. If no level flight exists, the derivatives on an even keel are used.
//!
//! Brunner 1988 gives such models in eq. (7) and Table 8, but prints `z' = w + U theta`, and samples every 0.05 of the time unit `L / U`
//! instead of every 0.05 s. Both are corrected here.

use planesman_linear::{
    Complex, DMatrix, Domain, Error, StateSpace, TransferFunction, discrete_to_continuous,
};

use crate::{
    Vehicle,
    dynamics::{GeneralisedForce, Slopes},
    vehicle::Derivatives,
};

planesman_text::choices! {
    /// An output of the linear model.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Output {
        PitchRate = "pitch_rate": "q (rad/s), positive bow up",
        Pitch = "pitch": "theta (rad), positive bow up",
        Depth = "depth": "z (m), positive down",
        Heave = "heave": "w (m/s), positive towards the keel",
    }
}

impl Output {
    /// Unit of the gain: the unit of the output per radian of plane angle.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::PitchRate => "1/s",
            Self::Pitch => "rad/rad",
            Self::Depth => "m/rad",
            Self::Heave => "m/(s rad)",
        }
    }
}

/// Linear system with the outputs [`Output::ALL`].
///
/// # Errors
/// [`Error::NotFinite`], if the vehicle's numbers overflow.
pub fn state_space(vehicle: &Vehicle, speed: f64) -> Result<StateSpace, Error> {
    state_space_of(&vehicle.derivatives(speed))
}

/// The state space from derivatives, for example of a [`Variant`](crate::Variant), with the hydrostatic restoring moment.
///
/// # Errors
/// Same as [`state_space`].
pub fn state_space_of(derivatives: &Derivatives) -> Result<StateSpace, Error> {
    let d = derivatives;
    let level = d.level_flight().unwrap_or_default().state();
    let (w, pitch) = (level.heave, level.pitch);
    let Slopes { heave: z, pitch: m } = d.slopes(&level);
    let inverse = d.inverse_inertia();
    let accelerations =
        |heave: f64, pitch: f64| inverse.accelerations(GeneralisedForce { heave, pitch });
    let heave = |z: f64, m: f64| accelerations(z, m).0;
    let pitching = |z: f64, m: f64| accelerations(z, m).1;
    let sinking = -w * libm::sin(pitch) - d.speed * libm::cos(pitch);
    #[rustfmt::skip]
    let a = [
        heave(z.w, m.w),    heave(z.q, m.q),    heave(z.theta, m.theta),    0.0,
        pitching(z.w, m.w), pitching(z.q, m.q), pitching(z.theta, m.theta), 0.0,
        0.0,                1.0,                0.0,                        0.0,
        libm::cos(pitch),        0.0,                sinking,                    0.0,
    ];
    let b = [
        heave(z.delta, m.delta),
        pitching(z.delta, m.delta),
        0.0,
        0.0,
    ];
    #[rustfmt::skip]
    let c = [
        0.0, 1.0, 0.0, 0.0,
        0.0, 0.0, 1.0, 0.0,
        0.0, 0.0, 0.0, 1.0,
        1.0, 0.0, 0.0, 0.0,
    ];
    StateSpace::new(
        DMatrix::from_row_slice(4, 4, &a),
        DMatrix::from_row_slice(4, 1, &b),
        DMatrix::from_row_slice(4, 4, &c),
        DMatrix::zeros(4, 1),
    )
}

/// System from the plane angle to one output. Depth is a state only for the output depth, since no other output depends on it.
///
/// # Errors
/// Same as [`state_space`].
pub fn response(derivatives: &Derivatives, output: Output) -> Result<StateSpace, Error> {
    let full = state_space_of(derivatives)?;
    let states = if output == Output::Depth { 4 } else { 3 };
    let row = Output::ALL.iter().position(|o| *o == output).unwrap_or(0);
    StateSpace::new(
        full.a.view((0, 0), (states, states)).into_owned(),
        full.b.view((0, 0), (states, 1)).into_owned(),
        full.c.view((row, 0), (1, states)).into_owned(),
        full.d.view((row, 0), (1, 1)).into_owned(),
    )
}

/// System from `delta` to the pitch rate `q` alone.
///
/// # Errors
/// Same as [`state_space`].
pub fn pitch_rate(vehicle: &Vehicle, speed: f64) -> Result<StateSpace, Error> {
    response(&vehicle.derivatives(speed), Output::PitchRate)
}

/// True model from plane angle to pitch rate, the reference for identification.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueModel {
    /// `q / delta` sampled every `dt` with a zero-order hold \[1/s\]: the numerator `[0, b1, b2, b3]` over `[1, a1, a2, a3]`.
    pub transfer_function: TransferFunction,
    /// Poles in the `z` plane, slowest first.
    pub poles: Vec<Complex<f64>>,
    /// Poles in the `s` plane \[rad/s\], slowest first.
    pub continuous_poles: Vec<Complex<f64>>,
    /// Steady pitch rate per plane angle \[1/s\]: 0, since the restoring moment stops any rotation. `None` without a restoring moment or at
    /// zero speed.
    pub steady_state_gain: Option<f64>,
}

/// The vehicle's true `q / delta` at a speed \[m/s\], sampled every `dt` \[s\].
///
/// # Errors
/// [`Error`], if the vehicle's numbers overflow or `dt` is not positive.
pub fn true_model(vehicle: &Vehicle, speed: f64, dt: f64) -> Result<TrueModel, Error> {
    true_model_of(&vehicle.derivatives(speed), dt)
}

/// The true model from derivatives, for example of a [`Variant`](crate::Variant).
///
/// # Errors
/// Same as [`true_model`].
pub fn true_model_of(derivatives: &Derivatives, dt: f64) -> Result<TrueModel, Error> {
    let continuous = response(derivatives, Output::PitchRate)?;
    let sampled = continuous.zero_order_hold(dt)?;
    let poles = sampled.poles()?;
    Ok(TrueModel {
        transfer_function: sampled.transfer_function(0, 0)?,
        continuous_poles: poles
            .iter()
            .filter_map(|&z| discrete_to_continuous(z, dt))
            .collect(),
        poles,
        steady_state_gain: continuous
            .steady_state_gain(Domain::Continuous)
            .ok()
            .map(|gain| gain[(0, 0)]),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        Restoring, State, environment::Environment, motion::Motion, planes::PlanePath,
        vehicle_file::brunner,
    };
    use planesman_linear::ComplexFunctions as _;
    use planesman_units::{FOOT, POUND_FORCE};

    /// Gyro volts per degree per second over plane volts per degree (Brunner 1988, Table 8).
    const CF1: f64 = 0.0125 / 0.010;

    /// The vehicle with `M'theta` rounded to -0.106 at 1 ft/s, as Table 1 prints it.
    fn with_the_rounded_restoring_moment() -> Vehicle {
        let mut vehicle = brunner();
        let moment = 0.106 * vehicle.reference_mass * FOOT * FOOT;
        vehicle.restoring_arm = moment / vehicle.weight;
        vehicle
    }

    fn model(feet_per_second: f64) -> TrueModel {
        let vehicle = with_the_rounded_restoring_moment();
        true_model(&vehicle, feet_per_second * FOOT, 0.05).expect("a model")
    }

    #[test]
    fn the_poles_move_from_an_oscillation_to_three_lags_as_speed_rises() {
        let expected: [(f64, [(f64, f64); 3]); 4] = [
            (1.0, [(-0.3553, 0.1256), (-0.3553, -0.1256), (-1.0105, 0.0)]),
            (1.2, [(-0.2737, 0.0), (-0.4794, 0.0), (-1.3122, 0.0)]),
            (1.8, [(-0.1481, 0.0), (-0.8180, 0.0), (-2.1318, 0.0)]),
            (2.1, [(-0.1235, 0.0), (-0.9663, 0.0), (-2.5244, 0.0)]),
        ];
        for (speed, poles) in expected {
            for (found, (re, im)) in model(speed).continuous_poles.iter().zip(poles) {
                assert!(
                    (found - Complex::new(re, im)).modulus() < 1e-4,
                    "{speed}: {found}"
                );
            }
        }
    }

    #[test]
    fn the_sampled_models_have_the_coefficients_known_to_ten_digits() {
        // In volts per volt, dive planes down positive and bow up positive.
        let expected: [(f64, [f64; 3], [f64; 3]); 3] = [
            (
                1.2,
                [-2.899220036, 2.801129200, -0.9018887212],
                [-0.04074507348, 0.08025755659, -0.03951248310],
            ),
            (
                1.8,
                [-2.851440556, 2.707974524, -0.8565040752],
                [-0.09005535940, 0.1760553911, -0.08600003167],
            ),
            (
                2.1,
                [-2.828096481, 2.662806429, -0.8346755128],
                [-0.1214921871, 0.2366258725, -0.1151336854],
            ),
        ];
        for (speed, a, b) in expected {
            let TransferFunction { num, den } = model(speed).transfer_function;
            for i in 0..3 {
                assert!((den[i + 1] - a[i]).abs() < 1e-9, "{speed}: {den:?}");
                assert!((CF1 * num[i + 1] - b[i]).abs() < 1e-9, "{speed}: {num:?}");
            }
        }
    }

    #[test]
    fn depth_per_plane_angle_has_the_known_fourth_order_model() {
        // At 1.2 ft/s; depth cell 3.084 V/ft, planes 0.01 V per degree.
        let vehicle = with_the_rounded_restoring_moment();
        let g = state_space(&vehicle, 1.2 * FOOT)
            .and_then(|s| s.zero_order_hold(0.05))
            .and_then(|s| s.transfer_function(2, 0))
            .expect("a model");
        let volts = 3.084 / FOOT / 0.01_f64.to_degrees();
        for (found, expected) in g.num[1..].iter().zip([
            0.0004458707686589847,
            -0.00013498097100494988,
            -0.0005704800042583003,
            0.0002759983464845073,
        ]) {
            assert!((found * volts - expected).abs() < 1e-11, "{found}");
        }
        for (found, expected) in g.den[1..].iter().zip([
            -3.89922003585517,
            5.700349235721747,
            -3.703017921071854,
            0.9018887212052775,
        ]) {
            assert!((found - expected).abs() < 1e-9, "{found}");
        }
    }

    #[test]
    fn a_held_plane_turns_the_vehicle_no_further_than_the_restoring_moment_lets_it() {
        let gain = model(1.2).steady_state_gain.expect("a gain");
        assert!(gain.abs() < 1e-12, "{gain}");
        let mut free = brunner();
        free.restoring_arm = 0.0;
        let free = true_model(&free, FOOT, 0.05).expect("a model");
        assert_eq!(free.steady_state_gain, None);
    }

    #[test]
    fn small_motions_of_the_vehicle_follow_the_linear_model() {
        let vehicle = brunner();
        let motion = Motion {
            derivatives: vehicle.derivatives(1.8 * FOOT),
            restoring: Restoring::Sine,
            environment: Environment {
                density: 1000.0,
                gravity: 9.81,
                atmospheric_pressure: 101_325.0,
            },
            step: 0.001,
        };
        let planes: Vec<f64> = (0..200)
            .map(|k| 1e-4 * libm::sin(0.1 * f64::from(k)))
            .collect();
        let linear = true_model(&vehicle, 1.8 * FOOT, 0.05)
            .and_then(|m| m.transfer_function.simulate(&planes))
            .expect("a response");
        let mut state = State {
            depth: 10.0,
            ..State::default()
        };
        for (delta, q) in planes.iter().zip(linear) {
            assert!(
                (state.pitch_rate - q).abs() < 1e-11,
                "{} is not {q}",
                state.pitch_rate
            );
            state = motion
                .advance(&state, &PlanePath::held(delta), 50)
                .expect("it moves");
        }
    }

    #[test]
    fn a_restoring_moment_in_newton_metres_is_weight_times_arm() {
        let d = brunner().derivatives(FOOT);
        assert!((d.restoring - 19.6 * POUND_FORCE * 0.00254).abs() < 1e-12);
    }
}
