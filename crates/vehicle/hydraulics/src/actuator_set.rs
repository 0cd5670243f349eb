//! Constants of one actuator in SI, and derived quantities.
//!
//! Symbols as in IBM 66-L03-005 (1966), Tables 3-1 and 4-1 and the list of symbols. Positive directions: ram to the right, pressure, volume
//! and pulses positive, planes to dive.

use std::sync::Arc;

use planesman_circuit::Circuit;
use planesman_units::readers;
use serde::Deserialize;

/// Content of an actuator file.
#[derive(Clone, Debug, PartialEq)]
pub enum ActuatorFile {
    /// A ram moved by metered volumes, as in the 1966 study.
    Metering(Box<ActuatorSet>),
    /// A ram driven by parallel on/off valves.
    Circuit(Arc<Circuit>),
}

impl ActuatorFile {
    /// R, m: ram travel per radian of plane angle.
    #[must_use]
    pub fn moment_arm(&self) -> f64 {
        match self {
            Self::Metering(set) => set.load.moment_arm,
            Self::Circuit(circuit) => circuit.load.moment_arm,
        }
    }
}

/// The constants of one actuator. [`crate::actuator_file`] creates and validates it.
#[derive(Clone, Debug, PartialEq)]
pub struct ActuatorSet {
    /// Its name.
    pub name: String,
    /// Source of the numbers.
    pub source: String,
    /// The load at the ram.
    pub load: RamLoad,
    /// A_L, m^2: the ram's larger area.
    pub area: f64,
    /// A_L/A_R, at the ram's two faces.
    pub area_ratio: f64,
    /// V_lim, m^3: limit of |V_T|; infinite if there is no limit.
    pub volume_limit: f64,
    /// x_stop, m: limit of |X_1|; infinite if there is no stop.
    pub stop: f64,
    /// The oil.
    pub oil: Oil,
    /// V_c, m^3: the calibrated volume.
    pub volume: f64,
    /// f_c in millihertz; a whole number keeps cycle times exact.
    pub frequency_millihertz: u32,
    /// T_v, s: from the command to the flow.
    pub valve_time: f64,
    /// T_f, s: flow time of a calibrated volume.
    pub flow_time: f64,
    /// T_D, s: delay of the interface in addition to T_v.
    pub extra_delay: f64,
    /// Electrical energy of a valve's solenoid for one switching, J.
    pub switching_energy: f64,
    /// q_L, m^3/s: drift; its sign is the sign valve's polarity.
    pub rate_gain: f64,
    /// q_LC, m^3/s: constant leakage.
    pub error_rate: f64,
    /// delta_b, rad: angle that the pulse logic counts for one volume.
    pub quantum: f64,
    /// e_b, rad: error above which a volume is commanded.
    pub threshold: f64,
    /// Second calibrating cylinder; `None` for a single-speed actuator.
    pub small: Option<SmallVolume>,
    /// X_lim, m: no outward volume is commanded beyond it; infinite if there is no limit.
    pub inhibit_beyond: f64,
    /// The angle that the pulse logic counts for an inhibited volume.
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
    /// R, m: ram travel per radian of plane angle.
    #[serde(with = "moment_arm")]
    pub moment_arm: f64,
}

/// The oil, the `oil:` section of the file.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Oil {
    /// beta/V, Pa/m^3: pressure rise per squeezed volume.
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
    /// delta_s, rad: angle that the pulse logic counts for a small volume.
    pub quantum: f64,
    /// e_s, rad: error above which the small volume is commanded.
    pub threshold: f64,
}

/// The travel limit in the control computer (Section II.B.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LimitOption {
    /// Option 1: the actuator gives no feedback; the logic counts the inhibited volume as moved.
    Unaware,
    /// Option 2: the limit is detected, and the logic counts delta_L (rad) instead.
    Aware(f64),
}

/// Largest number of cycles over which the flow of one command may extend.
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

    /// m = ceil((T_D + T_v + T_f)/T) - 1: number of earlier commands whose volume is still arriving at the next decision. The report's
    /// "last command" is m = 1.
    #[must_use]
    pub fn commands_in_flight(&self) -> usize {
        let cycles = ((self.delay() + self.flow_time) / self.cycle() - 1e-9).ceil();
        (cycles as usize).saturating_sub(1)
    }

    /// k = 2 q_L/P_h, m^3/(s Pa): leakage past the calibrating piston per differential pressure.
    #[must_use]
    pub fn pressure_leakage(&self) -> f64 {
        2.0 * self.rate_gain / self.oil.supply
    }

    /// V_c/A_L, m: position quantum of the ram.
    #[must_use]
    pub fn ram_quantum(&self) -> f64 {
        self.volume / self.area
    }

    /// V_c/(A_L R), rad: angle quantum of the planes.
    #[must_use]
    pub fn plane_quantum(&self) -> f64 {
        self.ram_quantum() / self.load.moment_arm
    }

    /// V_c f_c/A_L, m/s: ram speed with one volume in every cycle.
    #[must_use]
    pub fn slew_rate(&self) -> f64 {
        self.ram_quantum() / self.cycle()
    }

    /// Energy of an ideal proportional valve in this actuator's own circuit, J. The valve joins the larger chamber to supply or return; the
    /// smaller chamber stays at the supply. `four_way` is the energy of a 4-way valve for the same motion
    /// ([`Energy::proportional_valve`](crate::Energy::proportional_valve)); `moved` is the ram's distance from its start, m.
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

    /// (P_m A_L - Delta F)/C, m/s: sustainable speeds `(positive, negative)` at the clamped pressure.
    #[must_use]
    pub fn force_limits(&self) -> (f64, f64) {
        let speed = |pressure: f64| (pressure * self.area - self.load.coulomb) / self.load.viscous;
        (
            speed(self.oil.clamp_positive),
            -speed(self.oil.clamp_negative),
        )
    }

    /// A_L^2 beta/V, N/m: stiffness of the oil column at the ram.
    #[must_use]
    pub fn column_stiffness(&self) -> f64 {
        self.area * self.area * self.oil.stiffness
    }

    /// omega_n = A_L sqrt((beta/V)/M), rad/s.
    #[must_use]
    pub fn natural_frequency(&self) -> f64 {
        self.area * (self.oil.stiffness / self.load.mass).sqrt()
    }

    /// zeta = C/(2 M omega_n): damping by the viscous load only.
    #[must_use]
    pub fn damping_ratio(&self) -> f64 {
        self.load.viscous / (2.0 * self.load.mass * self.natural_frequency())
    }

    /// Damping ratio due to the leakage k P_d.
    #[must_use]
    pub fn leakage_damping(&self) -> f64 {
        self.pressure_leakage() * self.oil.stiffness / (2.0 * self.natural_frequency())
    }

    /// Delta F/(A_L^2 beta/V), m: largest distance from V_T/A_L at which the ram may rest.
    #[must_use]
    pub fn stiction_band(&self) -> f64 {
        self.load.coulomb / self.column_stiffness()
    }

    /// P_L0 = P_h A_R/A_L, Pa: pressure of the larger chamber at rest.
    #[must_use]
    pub fn resting_pressure(&self) -> f64 {
        self.oil.supply / self.area_ratio
    }

    /// K_L = q_L/(A_L R), rad/s: drift rate of the planes.
    #[must_use]
    pub fn drift_rate(&self) -> f64 {
        self.rate_gain / (self.area * self.load.moment_arm)
    }

    /// Steady creep of the ram against friction, m/s, under drift of polarity `sign`: (s q_L + q_LC - k s Delta F/A_L)/(A_L + k C/A_L).
    /// Zero if the leakage past the piston balances the drift before the load breaks away.
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
