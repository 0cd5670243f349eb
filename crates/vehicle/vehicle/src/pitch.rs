//! The pitch equation of a vehicle, and its coefficients.

pub use planesman_linear::pitch::*;
use planesman_linear::{Error, StateSpace};

use crate::{linearised::state_space_of, vehicle::Derivatives};

/// Coefficients of a vehicle about level flight, with heave.
///
/// # Errors
/// [`Error::NotFinite`], if the vehicle's numbers overflow.
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

/// `kappa`, `beta`, `mu` of a vehicle without heave.
#[must_use]
pub fn without_heave(d: &Derivatives) -> [f64; PITCH] {
    [d.m_delta, -d.m_q, d.restoring].map(|moment| moment / d.pitch_inertia)
}

#[cfg(test)]
mod tests {
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
}
