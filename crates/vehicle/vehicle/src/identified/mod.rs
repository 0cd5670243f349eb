//! A vehicle from an identified model: the base vehicle with the model's pitch dynamics.
//!
//! The base vehicle gives geometry, masses, buoyancy and heave. The pitch equation for level flight at the model's speed comes from the model,
//!
//! ```text
//! q' = kappa delta - beta q - mu theta + nu w       kappa = M_delta/J, beta = -M_q/J, mu = W BG/J
//! ```
//! and gives `M'delta`, `M'q` and `BG`, with the base's `J`. At other speeds they scale like all coefficients. A model file with the vehicle's
//! equations is used directly (`target`), including its heave equation, with `nu = 0` if it omits heave. For a transfer function alone, from planes
//! to pitch rate or pitch, the `kappa`, `beta`, `mu` are estimated that fit it best together with the base's heave (`nearest`).

mod error;
mod nearest;
mod target;

use planesman_model_file::ModelFile;

pub use error::Error;

use crate::{Vehicle, linearised::Output};
use nearest::nearest;
use target::Target;

/// Returns the base vehicle with the pitch dynamics of an identified model.
///
/// # Errors
/// [`enum@Error`]: signals that are not dive planes and pitch or pitch rate, a file without speed, a model that
/// If no vehicle fits (with the error), or the vehicle would turn over.
pub fn vehicle(base: &Vehicle, model: &ModelFile) -> Result<Vehicle, Error> {
    let output = signals(model)?;
    let speed = model.required_speed()?;
    let target = match &model.physical {
        Some(physical) => Target::of(physical, speed),
        None => nearest(base, model, output, speed)?,
    };
    let mut found = target.reached_from(base)?;
    for (coefficient, value, consequence) in [
        (
            "beta",
            -found.coefficients.m_q,
            "pitch more and more by itself",
        ),
        ("mu", found.restoring_arm, "turn over"),
        (
            "zeta",
            -found.coefficients.z_w,
            "heave more and more by itself",
        ),
    ] {
        if value < 0.0 {
            return Err(Error::Unstable {
                coefficient,
                consequence,
            });
        }
    }
    found.name += ", pitch as identified";
    Ok(found)
}

/// Whether a model file describes the vehicle's pitch: its signals are dive planes and pitch or pitch rate, and it gives the speed.
#[must_use]
pub fn is_of_pitch(model: &ModelFile) -> bool {
    signals(model).is_ok() && model.speed.is_some()
}

/// Output of the model; its signals must be the vehicle's in rad and s.
fn signals(model: &ModelFile) -> Result<Output, Error> {
    // Where these fields are in rad; on `daq` they are volts.
    let on = |signal: &str, topics: &[&str], field: &str| {
        let (topic, name) = signal.rsplit_once(':').unwrap_or(("", signal));
        let topic = topic.rsplit('/').next().unwrap_or_default();
        name == field && (topic.is_empty() || topics.contains(&topic))
    };
    let planes = on(&model.input, &["plane_motion", "state"], "dive_planes");
    let outputs = [Output::PitchRate, Output::Pitch];
    let output = outputs
        .into_iter()
        .find(|output| on(&model.output, &["state"], output.name()));
    match output {
        Some(output) if planes => Ok(output),
        _ => Err(Error::Signals {
            input: model.input.clone(),
            output: model.output.clone(),
        }),
    }
}
