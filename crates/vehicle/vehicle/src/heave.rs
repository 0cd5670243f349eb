//! Heave coefficients of a vehicle by its name or file, which an identification may use as known values.

use planesman_linear::Error;

use crate::pitch::coefficients;
use crate::vehicle_file::{self, VehicleError};

/// Reason why a vehicle has no heave coefficients.
#[derive(Debug, thiserror::Error)]
pub enum HeaveError {
    /// The vehicle is refused.
    #[error(transparent)]
    Vehicle(#[from] VehicleError),
    /// The vehicle has no linear equations.
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

/// nu, zeta, eta and epsilon of a built-in vehicle or a vehicle file in level flight at a speed, m/s: pitch acceleration per heave, 1/(m s); damping
/// of heave, 1/s; heave acceleration per pitch rate, m/s, and per plane angle, m/s^2 per rad.
///
/// # Errors
/// If the vehicle is refused, or its numbers overflow.
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

#[cfg(test)]
mod tests {
    use planesman_units::{FOOT, INCH};

    use super::*;

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
