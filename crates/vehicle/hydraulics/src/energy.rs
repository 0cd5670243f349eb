//! The energy balance in closed form: the supply's energy and where it goes.
//!
//! The ram is a differential cylinder: the smaller chamber is always at the supply P_h, the larger one at P_L = P_L0 + P_d with P_L0 = P_h
//! A_R/A_L (Appendix A). Let Q_h be the flow from the supply into the larger chamber, Q_R the flow from this chamber to the return, and q =
//! Q_h - Q_R. Then, over any time interval,
//!
//! ```text
//! supply      int P_h Q_h - P_R Q_R - P_h A_R v dt
//! throttling  int (P_h - P_L) Q_h + (P_L - P_R) Q_R dt        of the metered volumes, by valve
//! leakage     the same of drift and leakage, from P_h or to P_R
//! compression int P_L dV_e         while the column is compressed, and while the clamp holds P_d: auxiliary pistons
//! friction    int Delta F |v| dt        viscous load  int C v^2 dt        kinetic  M v^2/2        stops  M v^2/2 at each
//!
//! supply = throttling + leakage + compression + auxiliary pistons + friction + viscous + kinetic + stops
//! ```
//!
//! since V_e' = q - A_L v and M v' = A_L P_d - C v - Delta F sgn v ([`crate::modes`]). Each term is a separate integral over each stretch of
//! closed-form motion, so [`Energy::residual`] reveals an error in any term. The solenoids' energy is electrical and is not part of the balance. The
//! energy of one valve cycle is the difference between two readings.
//!
//! Drift and the pressure-dependent leakage, d q_L - k P_d, flow past the calibrating piston: from P_h at d = +1, from P_R at d = -1. q_LC
//! flows from P_h if it fills the ram, and to P_R if it empties it. A volume rejected by the volume limit is not drawn from the supply.

use std::ops::{Add, Sub};

use planesman_circuit as circuit;
use planesman_linear::first_below_zero;
use planesman_msgs::planesman_msgs::msg::DhaState;

use crate::closed_form::{ClosedForm, Integrals, Quantity};
use crate::metering::Flows;
use crate::modes::{Constants, FrictionState, Mode, Pressures, Side, State};

/// Declares [`Energy`] from its terms, each with its message field, and the operations on every term.
macro_rules! energies {
    ($($(#[$doc:meta])+ $term:ident: $field:ident,)+) => {
        /// Energies since the start, J.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct Energy {
            $($(#[$doc])+ pub $term: f64,)+
        }

        impl Add for Energy {
            type Output = Self;

            fn add(self, other: Self) -> Self {
                Self { $($term: self.$term + other.$term,)+ }
            }
        }

        impl Sub for Energy {
            type Output = Self;

            fn sub(self, other: Self) -> Self {
                Self { $($term: self.$term - other.$term,)+ }
            }
        }

        impl Energy {
            /// Writes the energies into a message.
            pub(crate) fn fill(&self, state: &mut DhaState) {
                $(state.$field = self.$term;)+
            }
        }

        impl From<&DhaState> for Energy {
            fn from(state: &DhaState) -> Self {
                Self { $($term: state.$field,)+ }
            }
        }
    };
}

energies! {
    /// Work of supply and return: P_h for each drawn volume, minus P_R for each returned volume and P_h for the volume that the smaller
    /// chamber returns.
    supply: energy_supply,
    /// Electrical energy of the solenoids.
    switching: energy_switching,
    /// Work on the load against the viscous friction C.
    viscous: energy_viscous,
    /// Present kinetic energy of ram and load.
    kinetic: energy_kinetic,
    /// Lost at the stops.
    stops: energy_stops,
    /// Lost to Coulomb friction.
    friction: energy_friction,
    /// Throttling loss in the large volume's valve.
    throttling: energy_throttling,
    /// Throttling loss in the small volume's valve.
    throttling_small: energy_throttling_small,
    /// Throttling loss past the calibrating piston.
    leakage: energy_leakage,
    /// Stored in the compressed column.
    compressed: energy_compressed,
    /// Recovered from the compressed column.
    recovered: energy_recovered,
    /// Stored in the auxiliary pistons.
    stored: energy_stored,
    /// Recovered from the auxiliary pistons.
    returned: energy_returned,
    /// Energy of an ideal 4-way proportional valve, without lag and leakage, for the same motion: P_h for each volume to the driven side,
    /// less P_R for the volume from the other side.
    proportional_valve: energy_proportional_valve,
}

impl Energy {
    /// Work on the load: viscous friction C, and its kinetic energy.
    #[must_use]
    pub fn load(&self) -> f64 {
        self.viscous + self.kinetic
    }

    /// Energy still stored in the column.
    #[must_use]
    pub fn compression(&self) -> f64 {
        self.compressed - self.recovered
    }

    /// Energy still stored in the auxiliary pistons.
    #[must_use]
    pub fn auxiliary(&self) -> f64 {
        self.stored - self.returned
    }

    /// The hydraulic terms with their names; their sum is [`Energy::supply`].
    #[must_use]
    pub fn terms(&self) -> [(&'static str, f64); 8] {
        [
            ("load", self.load()),
            ("friction", self.friction),
            ("stops", self.stops),
            ("throttling", self.throttling),
            ("throttling, small volume", self.throttling_small),
            ("leakage", self.leakage),
            ("compression", self.compression()),
            ("auxiliary pistons", self.auxiliary()),
        ]
    }

    /// The supply's work minus the sum of the terms, J: 0 except for rounding.
    #[must_use]
    pub fn residual(&self) -> f64 {
        self.supply - self.terms().iter().map(|(_, energy)| energy).sum::<f64>()
    }

    /// The residual relative to the supply's work; `None` if that work is 0.
    #[must_use]
    pub fn closure(&self) -> Option<f64> {
        (self.supply != 0.0).then(|| (self.residual() / self.supply).abs())
    }

    /// Work on the load relative to the supply's work; `None` if the supply's work is not positive.
    #[must_use]
    pub fn efficiency(&self) -> Option<f64> {
        (self.supply > 0.0).then(|| self.load() / self.supply)
    }

    /// Converts the ledger of a circuit of on/off valves. `kinetic` includes springs and weight, `throttling` all its valves and the line
    /// friction, `leakage` is the piston's seal, and `compressed` minus `recovered` is the energy in the lines.
    pub(crate) fn of_circuit(ledger: &circuit::Ledger, proportional_valve: f64) -> Self {
        Self {
            supply: ledger.supply,
            switching: ledger.switching,
            viscous: ledger.viscous,
            kinetic: ledger.mechanical + ledger.load,
            stops: ledger.stops,
            friction: ledger.friction,
            throttling: ledger.throttled() + ledger.line_friction,
            leakage: ledger.seal,
            compressed: ledger.compressed,
            recovered: ledger.compressed - ledger.compression - ledger.lines,
            proportional_valve,
            ..Self::default()
        }
    }
}

/// The ledger of one ram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ledger {
    energy: Energy,
    constants: Constants,
    pressures: Pressures,
    flows: Flows,
}

impl Ledger {
    /// Returns an empty ledger for a ram with these constants between these pressures.
    pub(crate) fn new(constants: Constants, pressures: Pressures) -> Self {
        Self {
            energy: Energy::default(),
            constants,
            pressures,
            flows: Flows::NONE,
        }
    }

    /// Begins a piece with these constants, pressures and flows.
    pub(crate) fn begin(&mut self, constants: Constants, pressures: Pressures, flows: Flows) {
        (self.constants, self.pressures, self.flows) = (constants, pressures, flows);
    }

    /// Adds the solenoids' energy.
    pub(crate) fn switch(&mut self, energy: f64) {
        self.energy.switching += energy;
    }

    /// Adds the kinetic energy lost when the load hits a stop at `speed`, m/s.
    pub(crate) fn hit_stop(&mut self, speed: f64) {
        self.energy.stops += 0.5 * self.constants.mass * speed * speed;
    }

    /// Energies with the load at `velocity`, m/s.
    #[must_use]
    pub(crate) fn energy(&self, velocity: f64) -> Energy {
        Energy {
            kinetic: 0.5 * self.constants.mass * velocity * velocity,
            ..self.energy
        }
    }

    /// Adds the first `t` seconds of a motion in `mode` from `start` to `end`.
    pub(crate) fn book(
        &mut self,
        mode: Mode,
        motion: &ClosedForm,
        start: &State,
        end: &State,
        t: f64,
    ) {
        if t <= 0.0 {
            return;
        }
        let (constants, resting) = (&self.constants, self.pressures.resting);
        let held = mode.clamped.map(|side| side.sign() * constants.clamp(side));
        let integrals = motion.integrals(t, end);
        let energy = &mut self.energy;

        // Column and auxiliary pistons: int P_L dV_e, up and down by themselves.
        let (mut put_in, mut given_back) = (0.0, 0.0);
        let mut from = start.squeezed;
        let turns = motion.turns_within(Quantity::Oil, t, end);
        let stretches = turns.map(|time| motion.at(time).squeezed);
        for to in stretches.chain([end.squeezed]) {
            let pressure = held.unwrap_or(0.5 * constants.stiffness * (from + to));
            let work = (resting + pressure) * (to - from);
            if work > 0.0 {
                put_in += work;
            } else {
                given_back -= work;
            }
            from = to;
        }
        if held.is_some() {
            energy.stored += put_in;
            energy.returned += given_back;
        } else {
            energy.compressed += put_in;
            energy.recovered += given_back;
        }

        // The flows into the larger chamber, unless the volume limit refuses them.
        if mode.limited.is_none() {
            self.add_flows(held, &integrals, t);
        }
        if !matches!(mode.friction, FrictionState::Sliding(_)) {
            return;
        }
        // The load.
        let (constants, energy) = (&self.constants, &mut self.energy);
        let moved = end.position - start.position;
        energy.viscous += constants.viscous * integrals.velocity_squared;
        energy.friction += constants.coulomb * moved.abs();
        // The smaller chamber: P_h A_R = P_L0 A_L.
        energy.supply -= resting * constants.area * moved;
        energy.proportional_valve +=
            proportional_valve(constants, &self.pressures, motion, start, end, t);
    }

    fn add_flows(&mut self, held: Option<f64>, integrals: &Integrals, t: f64) {
        let Constants {
            stiffness, leakage, ..
        } = self.constants;
        let Pressures {
            supply,
            back,
            resting,
        } = self.pressures;
        // int P_d dt and int P_d^2 dt.
        let (pressure, squared) = match held {
            Some(held) => (held * t, held * held * t),
            None => (
                stiffness * integrals.squeezed,
                stiffness * stiffness * integrals.squeezed_squared,
            ),
        };
        // int P_h - P_L dt and int P_L - P_R dt.
        let drops = [
            (supply - resting) * t - pressure,
            (resting - back) * t + pressure,
        ];
        let (flows, energy) = (&self.flows, &mut self.energy);
        let throttled = flows
            .metered
            .map(|[from, to]| from * drops[0] + to * drops[1]);
        energy.throttling += throttled[0];
        energy.throttling_small += throttled[1];
        for [from, to] in flows.metered {
            energy.supply += (supply * from - back * to) * t;
        }
        let source = if flows.from_supply { supply } else { back };
        let drifted = flows.drift * t - leakage * pressure;
        energy.supply += source * drifted;
        energy.leakage += (source - resting) * drifted - flows.drift * pressure + leakage * squared;
        let constant = flows.constant_leakage;
        let source = if constant > 0.0 { supply } else { back };
        energy.supply += source * constant * t;
        energy.leakage += constant * ((source - resting) * t - pressure);
    }
}

/// Energy of an ideal proportional valve for a motion, J.
fn proportional_valve(
    constants: &Constants,
    pressures: &Pressures,
    motion: &ClosedForm,
    start: &State,
    end: &State,
    t: f64,
) -> f64 {
    let Constants { area, coulomb, .. } = *constants;
    let Pressures {
        supply,
        back,
        resting,
    } = *pressures;
    // A_R = A_L P_L0/P_h.
    let ratio = resting / supply;
    let taken = |moved: f64| match Side::from_sign(moved) {
        Side::Positive => (supply - back * ratio) * area * moved,
        Side::Negative => (back - supply * ratio) * area * moved,
    };
    // With friction it halts before it turns.
    if coulomb > 0.0 {
        return taken(end.position - start.position);
    }
    let speed = |time: f64| motion.value_and_rate(Quantity::Speed, time);
    let turns = motion.turns_within(Quantity::Speed, t, end);
    let (mut sum, mut since, mut position) = (0.0, 0.0, start.position);
    for until in turns.chain([t]) {
        let (before, after) = (speed(since).0, speed(until).0);
        if before * after < 0.0 {
            let sign = before.signum();
            let halt = first_below_zero(since, until, |time| {
                let (value, rate) = speed(time);
                (sign * value, sign * rate)
            });
            let at_halt = motion.position(halt);
            sum += taken(at_halt - position);
            position = at_halt;
        }
        since = until;
    }
    sum + taken(end.position - position)
}
