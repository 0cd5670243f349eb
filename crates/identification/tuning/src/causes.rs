//! Finds the property of the model that makes the phase margin uncertain, and an experiment that would determine it better.
//!
//! To first order the phase margin and a property q of the model are jointly normal, with slopes `g` and `h` by the parameters and
//! covariance `P`. If q were known, the variance of the margin would fall by the share
//!
//! ```text
//! (g' P h)^2 / ((g' P g) (h' P h))
//! ```
//! the square of their correlation. Shares of correlated properties overlap: they need not sum to one.

use crate::closed_loop::{Margins, PlantResponse};
use crate::controller::Controller;
use crate::error::{Result, TuneError};
use crate::model::{NUDGE, PropertyKind, Sampling, UncertainModel};

/// A property of the model and the effect of its uncertainty.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// Its name.
    pub name: String,
    /// Unit of the property; empty for the signals' own unit.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// The share by which the variance of the phase margin would fall if the property were known.
    pub share: f64,
    /// The standard deviation of the phase margin from all properties, rad.
    pub margin_deviation: f64,
    /// An experiment that would determine the property better.
    pub experiment: String,
}

/// The properties, sorted by the share of the phase margin's variance that they explain; empty for an exact model, or without a phase
/// margin.
///
/// # Errors
/// If plants or roots cannot be computed.
pub fn causes(
    model: &UncertainModel,
    sampling: &Sampling,
    controller: &Controller,
    own: &Margins,
) -> Result<Vec<Cause>> {
    let Some(frequency) = own.crossover.filter(|_| own.phase.is_finite()) else {
        return Ok(Vec::new());
    };
    let look = |direction: usize, by: f64| {
        let parameters = model.along(direction, by);
        let plant = model.plant(&parameters, sampling)?;
        let properties = model.properties(&parameters, &plant, frequency)?;
        Ok::<_, TuneError>((
            PlantResponse::new(plant).margins(controller).phase,
            properties,
        ))
    };
    let plant = model.plant(model.centre(), sampling)?;
    let properties = model.properties(model.centre(), &plant, frequency)?;
    let (mut of_margin, mut slopes) = (0.0, vec![(0.0, 0.0); properties.len()]);
    for direction in 0..model.directions() {
        let ((phase_up, up), (phase_down, down)): ((f64, _), (f64, _)) =
            (look(direction, NUDGE)?, look(direction, -NUDGE)?);
        let slope = |up: f64, down: f64| (up - down) / (2.0 * NUDGE);
        let margin = slope(phase_up, phase_down);
        if !margin.is_finite() {
            return Ok(Vec::new());
        }
        of_margin += margin * margin;
        for ((variance, common), (up, down)) in slopes.iter_mut().zip(up.iter().zip(&down)) {
            let property = slope(up.value, down.value);
            *variance += property * property;
            *common += property * margin;
        }
    }
    let mut found: Vec<Cause> = (properties.into_iter().zip(slopes))
        .filter(|(_, (variance, _))| *variance > 0.0 && of_margin > 0.0)
        .map(|(property, (variance, common))| Cause {
            share: (common * common / (variance * of_margin)).min(1.0),
            deviation: variance.sqrt(),
            margin_deviation: of_margin.sqrt(),
            experiment: experiment(property.kind, property.value, property.unit, frequency),
            name: property.name,
            unit: property.unit,
            value: property.value,
        })
        .collect();
    found.sort_by(|a, b| b.share.total_cmp(&a.share));
    Ok(found)
}

/// An experiment that would determine a property better.
fn experiment(kind: PropertyKind, value: f64, unit: &str, crossover: f64) -> String {
    let period = std::f64::consts::TAU / crossover;
    match kind {
        PropertyKind::Gain => format!(
            "use larger steps of the input, or more steps, each held for about {:.3} s, and keep the output's noise low",
            3.0 * period
        ),
        PropertyKind::Pole if unit == "s" => format!(
            "use an input that switches about every {:.3} s (a PRBS or square wave), for several times as long as this record",
            value.abs()
        ),
        PropertyKind::Pole | PropertyKind::Damping => format!(
            "use a chirp that passes the mode, from {:.3} to {:.3} rad/s",
            0.3 * crossover.min(value.abs().max(1e-9)),
            3.0 * crossover.max(value.abs())
        ),
        PropertyKind::Delay => {
            "use an input with more sharp edges (a square wave rather than a ramp), recorded at a higher rate with the stamps of the samples themselves".to_owned()
        }
    }
}
