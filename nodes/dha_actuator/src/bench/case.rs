//! A digital flight control as it is put to the test: missile, actuator, autopilot, pulse logic.

use super::autopilot::Gains;
use super::digital_loop::{DigitalLoop, Start};
use super::missile::Surrogate;
use crate::actuator_set::ActuatorSet;
use crate::condition::Condition;
use crate::pulse_logic::Options;

/// A digital flight control to be tested.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The missile.
    pub surrogate: Surrogate,
    /// The actuator.
    pub set: ActuatorSet,
    /// The autopilot.
    pub gains: Gains,
    /// The pulse logic's options.
    pub options: Options,
    /// What is the matter with the actuator.
    pub condition: Condition,
}

impl Case {
    /// The case with a surrogate's own gains.
    #[must_use]
    pub fn new(surrogate: Surrogate, set: ActuatorSet) -> Self {
        Self {
            surrogate,
            set,
            gains: Gains::of(surrogate),
            options: Options::SINGLE_SPEED,
            condition: Condition::SOUND,
        }
    }

    /// The same with all gains times K_g.
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

    /// The loop, ready to fly.
    #[must_use]
    pub fn fly(&self, start: Start) -> DigitalLoop {
        DigitalLoop::new(self, start)
    }
}
