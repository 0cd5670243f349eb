//! Transfer functions of a vehicle in level flight, in s and with a zero-order hold.

use std::ops::RangeInclusive;

use planesman_linear::{Error, TransferFunction};
use planesman_text::number;

use crate::linearised::{self, Output};
use crate::{LevelFlight, Vehicle};

/// Allowed speeds of the linear models \[m/s\].
pub const SPEEDS: RangeInclusive<f64> = 0.001..=100.0;

/// Allowed rates of the zero-order hold \[Hz\].
pub const RATES: RangeInclusive<f64> = 0.01..=10_000.0;

planesman_text::choices! {
    /// An input of the linear models.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Input {
        DivePlanes = "dive_planes": "The dive planes' angle (rad), positive to dive",
        PitchRate = "pitch_rate": "The pitch rate (rad/s), only for the output depth; without the direct effect of the planes",
    }
}

/// Reason why there is no transfer function.
#[derive(Debug, thiserror::Error)]
pub enum TransferError {
    /// The numbers overflow, or the sampling rate is not positive.
    #[error("vehicle '{vehicle}' at {speed} m/s")]
    Linear {
        /// Name of the vehicle.
        vehicle: String,
        /// Its speed \[m/s\].
        speed: f64,
        /// Why.
        source: Error,
    },
    /// The planes do not affect the pitch rate.
    #[error("the planes have no effect on the pitch of this vehicle")]
    NoEffect,
    /// Pitch rate is an input of the depth only.
    #[error("pitch_rate is an input for the output depth only")]
    NotAnInput,
}

/// A model before and after the zero-order hold, with heading and remarks.
#[derive(Clone, Debug)]
pub struct Models {
    /// Vehicle, signals, unit and speed.
    pub heading: String,
    /// The model in s.
    pub continuous: TransferFunction,
    /// Unit of `s`.
    pub frequency: &'static str,
    /// The model in z.
    pub sampled: TransferFunction,
    /// Rate of the zero-order hold.
    pub sampling: String,
    /// Operating point, and other remarks.
    pub remarks: Vec<String>,
}

/// Returns the transfer function between two signals at a speed \[m/s\]; the input is held over each sample at a rate \[Hz\].
///
/// # Errors
/// If the pair of input and output has no model, or numbers overflow.
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

/// Operating point of the linearised model.
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
        None => "about zero pitch: the vehicle cannot be trimmed at this speed".to_owned(),
    }
}
