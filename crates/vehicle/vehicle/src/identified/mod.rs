//! A vehicle out of an identified model: the base vehicle, with what the model says of pitch.
//!
//! The base gives geometry, masses, buoyancy and heave. The pitch equation about level flight at the
//! model's speed is the model's,
//!
//! ```text
//! q' = kappa delta - beta q - mu theta + nu w       kappa = M_delta/J, beta = -M_q/J, mu = W BG/J
//! ```
//! and so gives `M'delta`, `M'q` and `BG`, with `J` the base's; at other speeds they go as every
//! coefficient goes. A model file that holds the vehicle's equations is used as it stands (`target`): its heave
//! equation too, and `nu = 0` if it left heave out. Of a transfer function alone, from planes to pitch
//! rate or pitch, those `kappa`, `beta`, `mu` are sought that with the base's heave come nearest to it
//! (`nearest`).

mod error;
mod nearest;
mod target;

use planesman_model_file::ModelFile;

pub use error::Error;

use crate::{Vehicle, linearised::Output};
use nearest::nearest;
use target::Target;

/// The base vehicle with the pitch dynamics of an identified model.
///
/// # Errors
/// [`enum@Error`]: signals that are not dive planes and pitch or pitch rate, a file without speed, a model that
/// no such vehicle follows (and by how much), or one that would turn over.
pub fn vehicle(base: &Vehicle, model: &ModelFile) -> Result<Vehicle, Error> {
    let output = signals(model)?;
    let speed = model.required_speed()?;
    let target = match &model.physical {
        Some(physical) => Target::of(physical, speed),
        None => nearest(base, model, output, speed)?,
    };
    let mut found = target.reached_from(base)?;
    for (coefficient, value, consequence) in [
        ("beta", -found.coefficients.m_q, "swing up by itself"),
        ("mu", found.restoring_arm, "turn over"),
        ("zeta", -found.coefficients.z_w, "heave up by itself"),
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

/// Whether a model file is one of the vehicle's pitch: its signals are dive planes and pitch or pitch rate, and it says at what speed.
#[must_use]
pub fn is_of_pitch(model: &ModelFile) -> bool {
    signals(model).is_ok() && model.speed.is_some()
}

/// The model's output, if its signals are the vehicle's in rad and s.
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
