//! One actuator's constants, in SI, and what follows from them.
//!
//! Symbols as in IBM 66-L03-005 (1966), Tables 3-1 and 4-1 and the list of symbols. Positive
//! is ram to the right, which is pressure, volume and pulses positive, and planes to dive.

use std::sync::Arc;

use planesman_circuit::Circuit;
use planesman_units::readers;
use serde::Deserialize;

/// What an actuator file describes.
#[derive(Clone, Debug, PartialEq)]
pub enum ActuatorFile {
    /// A ram moved in metered volumes, of the 1966 study's kind.
    Metering(Box<ActuatorSet>),
    /// A ram behind on/off valves in parallel.
    Circuit(Arc<Circuit>),
}

impl ActuatorFile {
    /// R, m: ram travel per radian of plane.
    #[must_use]
    pub fn moment_arm(&self) -> f64 {
        match self {
            Self::Metering(set) => set.load.moment_arm,
            Self::Circuit(circuit) => circuit.load.moment_arm,
        }
    }
}

/// The constants of one actuator. Made by [`crate::actuator_file`], which validates them.
#[derive(Clone, Debug, PartialEq)]
pub struct ActuatorSet {
    /// Its name.
    pub name: String,
    /// Where the numbers come from.
    pub source: String,
    /// The load at the ram.
    pub load: RamLoad,
    /// A_L, m^2: the ram's larger area.
    pub area: f64,
    /// A_L/A_R, at the ram's two faces.
    pub area_ratio: f64,
    /// V_lim, m^3: |V_T| never exceeds it; infinite when there is none.
    pub volume_limit: f64,
    /// x_stop, m: |X_1| never exceeds it; infinite when there is none.
    pub stop: f64,
    /// The oil.
    pub oil: Oil,
    /// V_c, m^3: the calibrated volume.
    pub volume: f64,
    /// f_c in millihertz, whole, so that cycle times are exact.
    pub frequency_millihertz: u32,
    /// T_v, s: from the command to the flow.
    pub valve_time: f64,
    /// T_f, s: how long a calibrated volume flows.
    pub flow_time: f64,
    /// T_D, s: what the interface adds to T_v.
    pub extra_delay: f64,
    /// Electrical energy of a valve's solenoid for one switching, J.
    pub switching_energy: f64,
    /// q_L, m^3/s: drift, with the sign valve's polarity.
    pub rate_gain: f64,
    /// q_LC, m^3/s: constant leakage.
    pub error_rate: f64,
    /// delta_b, rad: what the pulse logic books for one volume.
    pub quantum: f64,
    /// e_b, rad: the error beyond which a volume is commanded.
    pub threshold: f64,
    /// The second calibrating cylinder; none on an actuator that can only be single-speed.
    pub small: Option<SmallVolume>,
    /// X_lim, m: no volume is commanded outwards beyond it; infinite when there is none.
    pub inhibit_beyond: f64,
    /// The amount that the pulse logic books for a volume that was inhibited.
    pub limit_option: LimitOption,
}

readers! {
    mass: Mass, [1e-3, 1e7];
    viscous: Damping, [1e-3, 1e8];
    coulomb: Force, [0.0, 1e8];
    moment_arm: Length, [1e-4, 1e2];
    stiffness: OilStiffness, [1e5, 1e21];
    supply: Pressure, [1e3, 1e9];
    return_pressure: Pressure, [0.0, 1e9];
    clamp: Pressure, [1.0, 1e9];
}

/// The load at the ram, the `load:` section of its file.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RamLoad {
    /// M, kg: ram and load, lumped at the ram.
    #[serde(with = "mass")]
    pub mass: f64,
    /// C, N s/m.
    #[serde(with = "viscous")]
    pub viscous: f64,
    /// Delta F, N: Coulomb friction, static and kinetic alike.
    #[serde(with = "coulomb")]
    pub coulomb: f64,
    /// R, m: ram travel per radian of plane.
    #[serde(with = "moment_arm")]
    pub moment_arm: f64,
}

/// The oil, the `oil:` section of the file.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Oil {
    /// beta/V, Pa/m^3: pressure for a volume squeezed in.
    #[serde(with = "stiffness")]
    pub stiffness: f64,
    /// P_h, Pa.
    #[serde(with = "supply")]
    pub supply: f64,
    /// P_R, Pa.
    #[serde(rename = "return", with = "return_pressure")]
    pub return_pressure: f64,
    /// P_m+, Pa: the auxiliary piston's clamp on positive differential pressure.
    #[serde(with = "clamp")]
    pub clamp_positive: f64,
    /// |P_m-|, Pa.
    #[serde(with = "clamp")]
    pub clamp_negative: f64,
}

/// The small volume of a two-speed actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallVolume {
    /// V_cs, m^3.
    pub volume: f64,
    /// T_fs, s; at most T_f.
    pub flow_time: f64,
    /// delta_s, rad: what the pulse logic books for it.
    pub quantum: f64,
    /// e_s, rad: the error beyond which it is commanded.
    pub threshold: f64,
}

/// The travel limit in the control computer (Section II.B.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LimitOption {
    /// Option 1: no feedback from the actuator; the inhibited volume is booked as if moved.
    Unaware,
    /// Option 2: the limit is detected; this feedback delta_L (rad) is booked instead.
    Aware(f64),
}

/// The largest number of cycles over which one command's flow may reach.
pub(crate) const MOST_CYCLES_IN_FLIGHT: usize = 8;

impl ActuatorSet {
    /// T = 1/f_c, s.
    #[must_use]
    pub fn cycle(&self) -> f64 {
        1000.0 / f64::from(self.frequency_millihertz)
    }

    /// T_D + T_v, s: from a command to its flow, and to its drift polarity.
    #[must_use]
    pub fn delay(&self) -> f64 {
        self.extra_delay + self.valve_time
    }

    /// m = ceil((T_D + T_v + T_f)/T) - 1: earlier commands whose volume has not wholly arrived
    /// when the next decision is due. The report's "last command" is m = 1.
    #[must_use]
    pub fn commands_in_flight(&self) -> usize {
        let cycles = ((self.delay() + self.flow_time) / self.cycle() - 1e-9).ceil();
        (cycles as usize).saturating_sub(1)
    }

    /// k = 2 q_L/P_h, m^3/(s Pa): oil lost past the calibrating piston for differential pressure.
    #[must_use]
    pub fn pressure_leakage(&self) -> f64 {
        2.0 * self.rate_gain / self.oil.supply
    }

    /// V_c/A_L, m: the ram's quantum.
    #[must_use]
    pub fn ram_quantum(&self) -> f64 {
        self.volume / self.area
    }

    /// V_c/(A_L R), rad: the planes' quantum.
    #[must_use]
    pub fn plane_quantum(&self) -> f64 {
        self.ram_quantum() / self.load.moment_arm
    }

    /// V_c f_c/A_L, m/s: the ram's speed with a volume in every cycle.
    #[must_use]
    pub fn slew_rate(&self) -> f64 {
        self.ram_quantum() / self.cycle()
    }

    /// What an ideal proportional valve would take in this actuator's own circuit, J: one that joins the larger chamber to supply or
    /// return, while the smaller one stays at the supply. `four_way` is what a 4-way valve takes for the same motion
    /// ([`Energy::proportional_valve`](crate::Energy::proportional_valve)), `moved` how far the ram is from where it began, m.
    ///
    /// ```text
    /// int P_h (A_L - A_R) max(v, 0) + (P_h A_R - P_R A_L) max(-v, 0) dt
    /// ```
    #[must_use]
    pub fn proportional_in_own_circuit(&self, four_way: f64, moved: f64) -> f64 {
        let (high, low) = (self.oil.supply, self.oil.return_pressure);
        let (large, small) = (self.area, self.area / self.area_ratio);
        let (right, left) = (high * large - low * small, high * small - low * large);
        // four_way = right r + left l for the ways r and l to the right and to the left, and moved = r - l.
        let to_right = (four_way + left * moved) / (right + left);
        high * (large - small) * to_right + left * (to_right - moved)
    }

    /// (P_m A_L - Delta F)/C, m/s: the speeds `(positive, negative)` that the clamped pressure
    /// can sustain.
    #[must_use]
    pub fn force_limits(&self) -> (f64, f64) {
        let speed = |pressure: f64| (pressure * self.area - self.load.coulomb) / self.load.viscous;
        (
            speed(self.oil.clamp_positive),
            -speed(self.oil.clamp_negative),
        )
    }

    /// A_L^2 beta/V, N/m: the oil column's stiffness at the ram.
    #[must_use]
    pub fn column_stiffness(&self) -> f64 {
        self.area * self.area * self.oil.stiffness
    }

    /// omega_n = A_L sqrt((beta/V)/M), rad/s.
    #[must_use]
    pub fn natural_frequency(&self) -> f64 {
        self.area * (self.oil.stiffness / self.load.mass).sqrt()
    }

    /// zeta = C/(2 M omega_n), by the viscous load alone.
    #[must_use]
    pub fn damping_ratio(&self) -> f64 {
        self.load.viscous / (2.0 * self.load.mass * self.natural_frequency())
    }

    /// The share of the leakage k P_d in the damping ratio.
    #[must_use]
    pub fn leakage_damping(&self) -> f64 {
        self.pressure_leakage() * self.oil.stiffness / (2.0 * self.natural_frequency())
    }

    /// Delta F/(A_L^2 beta/V), m: how far from V_T/A_L the ram may rest.
    #[must_use]
    pub fn stiction_band(&self) -> f64 {
        self.load.coulomb / self.column_stiffness()
    }

    /// P_L0 = P_h A_R/A_L, Pa: the larger chamber's pressure at rest.
    #[must_use]
    pub fn resting_pressure(&self) -> f64 {
        self.oil.supply / self.area_ratio
    }

    /// K_L = q_L/(A_L R), rad/s: the planes' drift.
    #[must_use]
    pub fn drift_rate(&self) -> f64 {
        self.rate_gain / (self.area * self.load.moment_arm)
    }

    /// The ram's steady creep against friction, m/s, under drift of polarity `sign`:
    /// (s q_L + q_LC - k s Delta F/A_L)/(A_L + k C/A_L). Zero where the leakage past the piston
    /// balances the drift before the load breaks away.
    #[must_use]
    pub fn creep(&self, sign: f64) -> f64 {
        let k = self.pressure_leakage();
        let speed = (sign * self.rate_gain + self.error_rate
            - k * sign * self.load.coulomb / self.area)
            / (self.area + k * self.load.viscous / self.area);
        if speed * sign > 0.0 { speed } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use crate::{Demand, Dha, actuator_file};

    /// The work of a valve for the way of each millisecond to the right and to the left, summed up.
    #[test]
    fn a_proportional_valve_in_the_same_circuit_pays_for_the_smaller_chamber_s_oil_once() {
        for name in ["auv", "table_4_1"] {
            let set = actuator_file::load(name).expect("built in");
            let mut dha = Dha::new(&set).keeping_energy();
            let (large, small) = (set.area, set.area / set.area_ratio);
            let (mut own, mut four_way, mut position) = (0.0, 0.0, 0.0);
            for k in 1..=6000 {
                let angle = [0.2, -0.1, 0.05][k / 500 % 3];
                dha.advance_to(k as i64 * 1_000_000, Demand::angle(angle));
                let ram = dha.reading(k as i64 * 1_000_000).ram.position;
                let (right, left) = ((ram - position).max(0.0), (position - ram).max(0.0));
                own += set.oil.supply * (large - small) * right;
                four_way += (set.oil.supply * large - set.oil.return_pressure * small) * right;
                let back = (set.oil.supply * small - set.oil.return_pressure * large) * left;
                (own, four_way, position) = (own + back, four_way + back, ram);
            }
            let energy = dha.energy().expect("kept").proportional_valve;
            assert!(
                (energy / four_way - 1.0).abs() < 2e-3,
                "{name} {energy} {four_way}"
            );
            let found = set.proportional_in_own_circuit(energy, position);
            assert!((found / own - 1.0).abs() < 2e-3, "{name} {found} {own}");
            assert!(own < 0.9 * four_way, "{name} {own} {four_way}");
        }
    }
}
