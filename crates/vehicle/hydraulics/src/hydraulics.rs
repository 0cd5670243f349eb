//! The hydraulic part of the actuator: valves, metering and ram, advanced by valve cycles.
//!
//! The module receives one pulse command at the beginning of each cycle; errors and demanded angles are not known here. Times are in s from the begin
//! of the present cycle.

use crate::actuator_set::ActuatorSet;
use crate::condition::{Condition, Sound};
use crate::energy::Energy;
use crate::metering::Metering;
use crate::modes::{Mode, State};
use crate::pulse_logic::Command;
use crate::ram::Ram;
use crate::valves::{Stroke, Valves};

/// Valves, metering and ram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hydraulics {
    cycle: f64,
    sound: Sound,
    condition: Condition,
    valves: Valves,
    metering: Metering,
    ram: Ram,
    /// Index of the present piece of flow.
    piece: usize,
    /// Energy per switching of each solenoid, J: large volume's valve, small volume's valve, direction valve.
    switching_energy: [f64; 3],
}

/// A reading of the hydraulics, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// State of the ram and its oil.
    pub ram: State,
    /// P_d, Pa.
    pub pressure: f64,
    /// Mode of the ram.
    pub mode: Mode,
    /// d, the present drift polarity.
    pub polarity: i8,
    /// Oil gained other than by calibrated volumes, m^3: initial position, drift and constant leakage, less pressure-dependent leakage and
    /// oil rejected at the volume limit.
    pub leaked: f64,
}

impl Hydraulics {
    /// Returns the hydraulics at rest in mid-position, with the sign valve positive, before the first cycle.
    #[must_use]
    pub fn new(set: &ActuatorSet) -> Self {
        Self::settled(set, 1)
    }

    /// Like [`Hydraulics::new`], with the sign valve at `polarity`, +1 or -1.
    #[must_use]
    pub fn settled(set: &ActuatorSet, polarity: i8) -> Self {
        Self::resting_at(set, polarity, 0.0)
    }

    /// Like [`Hydraulics::settled`], with the ram at rest at `position`, m.
    #[must_use]
    pub fn resting_at(set: &ActuatorSet, polarity: i8, position: f64) -> Self {
        Self {
            cycle: set.cycle(),
            sound: Sound::new(set),
            condition: Condition::SOUND,
            valves: Valves::settled(polarity),
            metering: Metering::new(set, polarity),
            ram: Ram::resting_at(set, position),
            piece: 0,
            switching_energy: [1.0, f64::from(u8::from(set.small.is_some())), 1.0]
                .map(|valves| valves * set.switching_energy),
        }
    }

    /// Keeps the energies; call it before the first cycle ([`Hydraulics::energy`]).
    pub fn keep_energy(&mut self) {
        self.ram.keep_energy();
    }

    /// Energies up to `time`, up to which it has been advanced; `None` if they are not kept.
    #[must_use]
    pub fn energy(&self, time: f64) -> Option<Energy> {
        self.ram.energy(time)
    }

    /// Like [`Hydraulics::energy`], but up to the last change of law or flow: this needs no computation.
    #[must_use]
    pub fn booked_energy(&self) -> Option<Energy> {
        self.ram.booked_energy()
    }

    /// Finishes the present cycle; the next one begins in `condition`.
    pub fn set_condition(&mut self, condition: Condition) {
        if condition == self.condition {
            return;
        }
        self.finish_cycle();
        let (constants, leakages) = self.sound.in_condition(&condition);
        self.ram
            .set_constants(constants, self.sound.pressures(&condition));
        self.metering.set_condition(&condition, leakages);
        self.valves.set_stuck(condition.stuck);
        self.condition = condition;
    }

    /// Finishes the present cycle, moves the ram by `position`, m, and squeezes in `squeezed`, m^3, of oil. Derivatives of the end state by
    /// the initial state are computed from such neighbouring states.
    pub fn displace(&mut self, position: f64, squeezed: f64) {
        self.finish_cycle();
        self.ram.displace(position, squeezed);
    }

    /// Finishes the present cycle and begins the next one with a command.
    pub fn begin_cycle(&mut self, command: Command) -> Stroke {
        self.finish_cycle();
        let stroke = self.valves.obey(command);
        self.metering.begin_cycle(stroke);
        self.begin_piece(0);
        if let Some(ledger) = self.ram.ledger() {
            let driven = stroke.driven.iter().zip(self.switching_energy);
            ledger.switch(
                driven
                    .map(|(driven, it)| f64::from(u8::from(*driven)) * it)
                    .sum(),
            );
        }
        stroke
    }

    /// Runs up to `time` within the present cycle. An earlier time has no effect.
    pub fn advance(&mut self, time: f64) {
        while self.piece + 1 < self.metering.pieces().len()
            && self.metering.pieces()[self.piece].until <= time
        {
            self.begin_piece(self.piece + 1);
        }
        self.ram.advance(time);
    }

    /// Field of the file with the fastest time constant if the ram's motion could not be solved; otherwise `None`.
    #[must_use]
    pub fn unsolved(&self) -> Option<&'static str> {
        self.ram.unsolved()
    }

    /// Runs to the end of the present cycle.
    pub fn finish_cycle(&mut self) {
        self.advance(self.cycle);
    }

    /// Reading at `time`, up to which it has been advanced.
    #[must_use]
    pub fn reading(&self, time: f64) -> Reading {
        let ram = self.ram.at(time);
        Reading {
            ram,
            pressure: self.ram.pressure(&ram),
            mode: self.ram.mode(),
            polarity: self
                .metering
                .pieces()
                .get(self.piece)
                .map_or(1, |piece| piece.polarity),
            leaked: ram.volume - self.metering.delivered(time),
        }
    }

    /// X_1, m, at `time`, up to which it has been advanced: the value of the reading, computed faster.
    #[must_use]
    pub fn position(&self, time: f64) -> f64 {
        self.ram.position(time)
    }

    /// Appends positions, m, from `time` on, as far as [`Ram::sample`] goes; the ram must have been advanced to `time`.
    pub(crate) fn sample(&self, time: f64, interval: f64, count: usize, positions: &mut Vec<f64>) {
        self.ram.sample(time, interval, count, positions);
    }

    /// Total distance that the load has slid against friction up to `time`, m, in both directions. Delta F times this distance is the work
    /// lost to friction.
    #[must_use]
    pub fn slid(&self, time: f64) -> f64 {
        self.ram.slid(time)
    }

    fn begin_piece(&mut self, piece: usize) {
        let pieces = self.metering.pieces();
        let from = match piece {
            0 => 0.0,
            later => pieces[later - 1].until,
        };
        let (flow, until) = (pieces[piece].flow, pieces[piece].until);
        let keeps = self.ram.ledger().is_some();
        let flows = keeps.then(|| self.metering.flows(from, &self.metering.pieces()[piece]));
        self.ram.begin(flow, from, until, flows);
        self.piece = piece;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;
    use crate::pulse_logic::Volume;

    #[test]
    fn a_cycles_end_is_the_next_ones_begin() {
        for name in ["auv", "auv_two_speed", "table_3_1", "table_4_1"] {
            let set = load(name).expect("built in");
            let mut hydraulics = Hydraulics::new(&set);
            for n in 0..40 {
                let before = hydraulics.reading(if n == 0 { 0.0 } else { set.cycle() });
                hydraulics.begin_cycle(Command {
                    volume: [Volume::None, Volume::Small, Volume::Large][n % 3],
                    sign: if n % 20 < 10 { 1 } else { -1 },
                });
                assert_eq!(hydraulics.reading(0.0).ram, before.ram, "{name} {n}");
                hydraulics.finish_cycle();
                let almost = hydraulics.reading(set.cycle() - 1e-9).ram.position;
                let end = hydraulics.reading(set.cycle()).ram.position;
                assert!((end - almost).abs() < 1e-8, "{name} {n}");
            }
        }
    }
}
