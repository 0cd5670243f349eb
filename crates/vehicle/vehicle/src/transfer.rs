//! Transfer functions of a vehicle about level flight, in s and behind a zero-order hold.

use std::ops::RangeInclusive;

use planesman_linear::{Error, TransferFunction};
use planesman_text::number;

use crate::linearised::{self, Output};
use crate::{LevelFlight, Vehicle};

/// Speeds at which a vehicle is linearised for its users \[m/s\].
pub const SPEEDS: RangeInclusive<f64> = 0.001..=100.0;

/// Rates of the zero-order hold for its users \[Hz\].
pub const RATES: RangeInclusive<f64> = 0.01..=10_000.0;

planesman_text::choices! {
    /// An input of the linear models.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Input {
        DivePlanes = "dive_planes": "The dive planes' angle (rad), positive to dive",
        PitchRate = "pitch_rate": "The pitch rate (rad/s), for output depth only; without the direct effect of the planes",
    }
}

/// Why there is no transfer function.
#[derive(Debug, thiserror::Error)]
pub enum TransferError {
    /// Numbers that overflow, or a sampling rate that is not above zero.
    #[error("vehicle '{vehicle}' at {speed} m/s")]
    Linear {
        /// The vehicle's name.
        vehicle: String,
        /// Its speed \[m/s\].
        speed: f64,
        /// Why.
        source: Error,
    },
    /// There is no pitch rate to divide by.
    #[error("the planes have no effect on the pitch of this vehicle")]
    NoEffect,
    /// The pitch rate moves nothing but the depth by itself.
    #[error("pitch_rate is an input for the output depth only")]
    NotAnInput,
}

/// A model before and after the zero-order hold, with its heading and remarks.
#[derive(Clone, Debug)]
pub struct Models {
    /// Vehicle, signals, unit and speed.
    pub heading: String,
    /// The model in s.
    pub continuous: TransferFunction,
    /// The unit of `s`.
    pub frequency: &'static str,
    /// The model in z.
    pub sampled: TransferFunction,
    /// The rate of the zero-order hold.
    pub sampling: String,
    /// The operating point, and what else is to be known.
    pub remarks: Vec<String>,
}

/// The transfer function between two signals at a speed \[m/s\], its input held over each sample at a rate \[Hz\].
///
/// # Errors
/// A pair of input and output that has no model, numbers that overflow.
pub fn models(
    vehicle: &Vehicle,
    (input, output): (Input, Output),
    speed: f64,
    rate: f64,
) -> Result<Models, TransferError> {
    let refused = |source| TransferError::Linear {
        vehicle: vehicle.name.clone(),
        speed,
        source,
    };
    let dt = 1.0 / rate;
    let derivatives = vehicle.derivatives(speed);
    let of = |output| {
        linearised::response(&derivatives, output)
            .and_then(|s| s.transfer_function(0, 0))
            .map(TransferFunction::without_rounding)
            .map_err(refused)
    };
    let (continuous, sampled, unit) = match (input, output) {
        (Input::DivePlanes, _) => {
            let sampled = linearised::response(&derivatives, output)
                .and_then(|s| s.zero_order_hold(dt))
                .and_then(|s| s.transfer_function(0, 0))
                .map_err(refused)?;
            (of(output)?, sampled.without_rounding(), output.unit())
        }
        (Input::PitchRate, Output::Depth) => {
            // z / q = (z / delta) / (q / delta): both have the same denominator but for an s.
            let mut den = of(Output::PitchRate)?.num;
            den.push(0.0);
            let g = TransferFunction::new(of(Output::Depth)?.num, den)
                .map_err(|_| TransferError::NoEffect)?;
            let g = g.monic();
            let sampled = g.zero_order_hold(dt).map_err(refused)?;
            (g, sampled.without_rounding(), "m s/rad")
        }
        (Input::PitchRate, _) => return Err(TransferError::NotAnInput),
    };
    Ok(Models {
        heading: format!(
            "{}: {} over {} [{unit}] at {} m/s",
            vehicle.name,
            output.name(),
            input.name(),
            number(speed)
        ),
        continuous,
        frequency: "rad/s",
        sampled,
        sampling: format!("{rate} Hz, T = {dt} s"),
        remarks: vec![operating_point(derivatives.level_flight())],
    })
}

/// The operating point of the linearised model.
fn operating_point(level: Option<LevelFlight>) -> String {
    match level {
        Some(level) if level == LevelFlight::default() => {
            "about level flight on an even keel with neutral planes".to_owned()
        }
        Some(level) => format!(
            "about level flight: pitch {:.2} degrees, planes {:.2} degrees",
            level.pitch.to_degrees(),
            level.planes.to_degrees()
        ),
        None => "about zero pitch: at this speed the vehicle has no trim".to_owned(),
    }
}
