//! A circuit with its controller, on the controller's own clock.

use std::sync::Arc;

use crate::circuit::Circuit;
use crate::control::{Controller, Reference};
use crate::ledger::Ledger;
use crate::simulation::{Force, Simulation};

/// A circuit and its controller. A clone has exactly the same future.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    simulation: Simulation,
    controller: Controller,
    period: i64,
    /// The number of the sampling period, and whether it has begun.
    cycle: i64,
    begun: bool,
}

/// The inputs of a sampling period: the reference, and the force on the load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// The position that the ram should reach.
    pub reference: Reference,
    /// The force against positive motion.
    pub force: Force,
}

impl Actuator {
    /// An actuator at rest at `position`, m, with the load force `force`, N. `accuracy` is the largest error of a step relative to each quantity's
    /// scale, `seed` is the seed of the scatter of the valves' delays.
    #[must_use]
    pub fn new(
        circuit: &Arc<Circuit>,
        accuracy: f64,
        position: f64,
        force: f64,
        seed: u64,
    ) -> Self {
        Self {
            controller: Controller::new(circuit),
            simulation: Simulation::new(Arc::clone(circuit), accuracy, position, force, seed),
            period: circuit.control.period,
            cycle: 0,
            begun: false,
        }
    }

    /// The simulation of the circuit.
    #[must_use]
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Changes the force on the load, N, stepwise at the instant `nanos`, to which the actuator has been advanced; the force then stays
    /// constant. Later demands must have the same force.
    pub fn push(&mut self, nanos: i64, force: f64) {
        self.simulation.push(self.in_cycle(nanos), force);
    }

    /// Runs to the instant `nanos` after the start. Sampling periods that begin before this instant use `demand`; a period that begins exactly there
    /// waits for the next call. An earlier instant has no effect.
    pub fn advance_to(&mut self, nanos: i64, demand: Demand) {
        if nanos <= 0 {
            return;
        }
        let period = self.period as f64 * 1e-9;
        if !self.begun {
            self.begin(demand);
        }
        while (self.cycle + 1) * self.period < nanos {
            self.simulation.next_cycle(period);
            self.cycle += 1;
            self.begin(demand);
        }
        self.simulation.advance(self.in_cycle(nanos), period);
    }

    fn begin(&mut self, demand: Demand) {
        self.begun = true;
        self.simulation.set_force(demand.force);
        self.controller
            .decide(&mut self.simulation, demand.reference);
    }

    fn in_cycle(&self, nanos: i64) -> f64 {
        (nanos - self.cycle * self.period).max(0) as f64 * 1e-9
    }

    /// Position m, speed m/s, p_A and p_B gauge Pa at the instant `nanos`, to which the actuator has been advanced.
    #[must_use]
    pub fn at(&self, nanos: i64) -> [f64; 4] {
        self.simulation.at(self.in_cycle(nanos))
    }

    /// At the instant `nanos`, to which the actuator has been advanced: the net volume taken from the supply levels, m^3, and the energy that an
    /// ideal proportional valve would have used, J ([`Simulation::proportional`]).
    #[must_use]
    pub fn volume_and_proportional(&self, nanos: i64) -> [f64; 2] {
        let time = self.in_cycle(nanos);
        [
            self.simulation.volume(time),
            self.simulation.proportional(time),
        ]
    }

    /// The ledger at the instant `nanos`, to which the actuator has been advanced.
    #[must_use]
    pub fn ledger(&self, nanos: i64) -> Ledger {
        self.simulation.ledger(self.in_cycle(nanos))
    }
}
