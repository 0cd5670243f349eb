//! A digital flight control under test: missile, actuator, autopilot, pulse logic.

use crate::ibm_1966::autopilot::Gains;
use crate::ibm_1966::missile::{Surrogate, YawPlant};
use planesman_hydraulics::{ActuatorSet, Condition, Options};

/// Source of the autopilot's psi', which the report does not specify.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RateSignal {
    /// A rate gyro.
    Gyro,
    /// The first difference of psi.
    Difference,
}

/// A digital flight control to be tested.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The missile.
    pub surrogate: Surrogate,
    /// Yaw dynamics: the surrogate's, unless other calibrated values are tried.
    pub plant: YawPlant,
    /// Source of psi'.
    pub rate: RateSignal,
    /// The actuator.
    pub set: ActuatorSet,
    /// The autopilot.
    pub gains: Gains,
    /// The pulse logic's options.
    pub options: Options,
    /// Wear and faults of the actuator.
    pub condition: Condition,
}

impl Case {
    /// A case with the surrogate's own gains.
    #[must_use]
    pub fn new(surrogate: Surrogate, set: ActuatorSet) -> Self {
        Self {
            surrogate,
            plant: surrogate.plant(),
            rate: RateSignal::Gyro,
            set,
            gains: Gains::new(surrogate),
            options: Options::SINGLE_SPEED,
            condition: Condition::SOUND,
        }
    }

    /// The same case with all gains multiplied by K_g.
    #[must_use]
    pub fn with_gain(&self, overall: f64) -> Self {
        Self {
            gains: Gains {
                overall,
                ..self.gains
            },
            ..self.clone()
        }
    }
}
