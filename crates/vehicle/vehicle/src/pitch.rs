//! The pitch equation of a vehicle, and the coefficients in it.

pub use planesman_linear::pitch::*;
use planesman_linear::{Error, StateSpace};

use crate::vehicle_file::{self, VehicleError};
use crate::{linearised::state_space_of, vehicle::Derivatives};

/// The coefficients of a vehicle about level flight, with heave.
///
/// # Errors
/// [`Error::NotFinite`] when the vehicle's numbers overflow.
pub fn coefficients(derivatives: &Derivatives) -> Result<[f64; PITCH_AND_HEAVE], Error> {
    let StateSpace { a, b, .. } = state_space_of(derivatives)?;
    Ok([
        b[(1, 0)],
        -a[(1, 1)],
        -a[(1, 2)],
        a[(1, 0)],
        -a[(0, 0)],
        a[(0, 1)],
        b[(0, 0)],
    ])
}

/// Why a vehicle has no coefficients of heave.
#[derive(Debug, thiserror::Error)]
pub enum HeaveError {
    /// A vehicle that is refused.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// A vehicle without linear equations.
    #[error("vehicle '{vehicle}' at {speed} m/s")]
    NotLinear {
        /// Its name.
        vehicle: String,
        /// Its speed, m/s.
        speed: f64,
        /// Why.
        source: Error,
    },
}

/// nu, zeta, eta and epsilon of a built-in vehicle or a vehicle file about level flight at a speed, m/s: pitch acceleration per heave,
/// 1/(m s); damping of heave, 1/s; heave acceleration per pitch rate, m/s, and per plane angle, m/s^2 per rad.
///
/// # Errors
/// A vehicle that is refused, or whose numbers overflow.
pub fn heave_of(vehicle: &str, speed: f64) -> Result<[f64; 4], HeaveError> {
    let vehicle = vehicle_file::load(vehicle)?;
    let coefficients = coefficients(&vehicle.derivatives(speed));
    let [_, _, _, heave @ ..] = coefficients.map_err(|source| HeaveError::NotLinear {
        vehicle: vehicle.name,
        speed,
        source,
    })?;
    Ok(heave)
}

/// `kappa`, `beta`, `mu` of a vehicle that does not heave.
#[must_use]
pub fn without_heave(d: &Derivatives) -> [f64; PITCH] {
    [d.m_delta, -d.m_q, d.restoring].map(|moment| moment / d.pitch_inertia)
}

#[cfg(test)]
mod tests {
    use planesman_units::{FOOT, INCH};

    use super::*;
    use crate::{
        linearised::{Output, response},
        vehicle_file::brunner,
    };

    #[test]
    fn the_coefficients_of_a_neutral_vehicle_give_its_linear_model_back() {
        let derivatives = brunner().derivatives(0.5);
        let of = |system: Result<StateSpace, Error>| {
            let system = system.and_then(|system| system.zero_order_hold(0.05));
            system.and_then(|system| system.transfer_function(0, 0))
        };
        let found = of(coefficients(&derivatives).and_then(|c| state_space(&c)));
        let expected = of(response(&derivatives, Output::PitchRate));
        let (found, expected) = (found.expect("a model"), expected.expect("a model"));
        for (f, e) in found.den.iter().zip(&expected.den) {
            assert!((f - e).abs() < 1e-12);
        }
        for (f, e) in found.num.iter().zip(&expected.num) {
            assert!((f - e).abs() < 1e-12);
        }
    }

    #[test]
    fn heave_of_the_thesis_vehicle_is_that_of_its_coefficients() {
        // Brunner 1988, Table 1 (p. 41): Z'w -1.295, Z'q + m' 0.196, Z'delta 0.095, M'w 0.088, m' - Z'w_dot 1.046,
        // I'y 0.072 with M'q_dot; 28 in long.
        let (speed, length) = (2.1 * FOOT, 28.0 * INCH);
        let rate = speed / length;
        let expected = [
            0.088 / 0.072 * rate / length,
            1.295 / 1.046 * rate,
            0.196 / 1.046 * rate * length,
            0.095 / 1.046 * rate * speed,
        ];
        let found = heave_of("brunner", speed).unwrap();
        for (found, expected) in found.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
        }
    }
}
