//! The hydraulics alone under a train of pulses: one command per valve cycle while the train lasts.

use crate::actuator_set::ActuatorSet;
use crate::condition::Condition;
use crate::energy::Energy;
use crate::hydraulics::{Hydraulics, Reading};
use crate::pulse_logic::{Command, Volume};

/// A run of the hydraulics from rest.
#[derive(Clone, Debug, PartialEq)]
pub struct PulseTrain {
    period: f64,
    hydraulics: Hydraulics,
    quanta: Vec<i8>,
    sign: i8,
    cycle: usize,
    condition: Condition,
}

impl PulseTrain {
    /// Sends large volumes, +1, 0 or -1 in each cycle from t = 0 on; the sign valve is at `sign` before the start.
    #[must_use]
    pub fn settled(set: &ActuatorSet, sign: i8, quanta: &[i8]) -> Self {
        Self::worn(set, Condition::SOUND, sign, quanta)
    }

    /// Like [`PulseTrain::settled`], with the actuator in `condition`.
    #[must_use]
    pub fn worn(set: &ActuatorSet, condition: Condition, sign: i8, quanta: &[i8]) -> Self {
        let mut train = Self {
            period: set.cycle(),
            hydraulics: Hydraulics::settled(set, sign),
            quanta: quanta.to_vec(),
            sign,
            cycle: 0,
            condition,
        };
        train.hydraulics.keep_energy();
        train.begin_cycle();
        train
    }

    /// Reading at `time`, s; times must not decrease.
    pub fn at(&mut self, time: f64) -> Reading {
        let time = self.advance(time);
        self.hydraulics.reading(time)
    }

    /// Total distance that the load has slid against friction up to `time`, m; times must not decrease.
    pub fn slid(&mut self, time: f64) -> f64 {
        let time = self.advance(time);
        self.hydraulics.slid(time)
    }

    /// Energies from the start to `time`, s; times must not decrease.
    pub fn energy(&mut self, time: f64) -> Energy {
        let time = self.advance(time);
        self.hydraulics.energy(time).unwrap_or_default()
    }

    fn begin_cycle(&mut self) {
        let quanta = self.quanta.get(self.cycle).copied().unwrap_or(0);
        if quanta != 0 {
            self.sign = quanta;
        }
        self.hydraulics.set_condition(self.condition);
        self.hydraulics.begin_cycle(Command {
            volume: if quanta == 0 {
                Volume::None
            } else {
                Volume::Large
            },
            sign: self.sign,
        });
    }

    /// Runs to `time`, s, and returns the time within the cycle.
    fn advance(&mut self, time: f64) -> f64 {
        while time - self.cycle as f64 * self.period > self.period {
            self.hydraulics.finish_cycle();
            self.cycle += 1;
            self.begin_cycle();
        }
        let time = (time - self.cycle as f64 * self.period).clamp(0.0, self.period);
        self.hydraulics.advance(time);
        time
    }
}
