//! What can move the planes: the digital hydraulic actuator, or an ideal one to compare with.

use crate::actuator_set::ActuatorSet;
use crate::dha::{Demand, Dha};
use crate::hydraulics::Reading;
use crate::parameters::Model;

/// An actuator behind the messages. Copying it copies its whole future.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // one lives in a node, and it is copied, not boxed
pub enum ActuatorModel {
    /// The digital hydraulic actuator.
    Dha(Dha),
    /// Planes at the angle asked for, rad, at once.
    Ideal(f64),
}

/// Where the planes are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planes {
    /// Plane angle, rad.
    pub angle: f64,
    /// Plane rate, rad/s.
    pub rate: f64,
    /// What the hydraulics show; none behind an ideal actuator.
    pub reading: Option<Reading>,
}

impl ActuatorModel {
    /// Planes neutral and at rest.
    #[must_use]
    pub fn new(model: Model, set: &ActuatorSet) -> Self {
        match model {
            Model::Dha => Self::Dha(Dha::new(set)),
            Model::Ideal => Self::Ideal(0.0),
        }
    }

    /// What is asked for takes effect: at once on an ideal actuator, at its next valve cycle on
    /// the digital one.
    pub fn ask(&mut self, demand: Demand) {
        if let Self::Ideal(angle) = self {
            *angle = demand.angle;
        }
    }

    /// Runs to the instant `nanos` after the start under `demand`.
    pub fn advance_to(&mut self, nanos: i64, demand: Demand) {
        match self {
            Self::Dha(dha) => dha.advance_to(nanos, demand),
            Self::Ideal(angle) => *angle = demand.angle,
        }
    }

    /// The planes at the instant `nanos`, to which it has been advanced.
    #[must_use]
    pub fn planes(&self, nanos: i64) -> Planes {
        match self {
            Self::Dha(dha) => {
                let reading = dha.reading(nanos);
                Planes {
                    angle: dha.plane_angle(&reading),
                    rate: dha.plane_rate(&reading),
                    reading: Some(reading),
                }
            }
            Self::Ideal(angle) => Planes {
                angle: *angle,
                rate: 0.0,
                reading: None,
            },
        }
    }
}
