//! The condition of an actuator: wear and faults.
//!
//! | fault | model | effect |
//! |---|---|---|
//! | increased leakage | q_L and q_LC times a factor | open loop, an angle error; in the position loop, more pulses |
//! | short volume | V_c less a share | smaller steps; open loop, too small an angle |
//! | low supply pressure | P_h less a share | a weaker and slower ram, which finally stops |
//! | air in the oil | beta/V less a share | a soft column: the load oscillates longer and rests further from its target |
//! | one slow latch | every second volume delayed by a time | in precision mode, parasitic volumes |
//! | stuck valve | one valve no longer switches | no volumes, or all in one direction |
//! | encoder lost | no measured position | the position loop opens: drift |
//! | encoder frozen | the measured position stays constant | the ram runs to its limit |
//!
//! **Supply.** The auxiliary pistons hold the cavity's pressure between two fixed shares of P_h about P_h A_R/A_L (Appendix A). The clamps
//! on P_d are therefore proportional to P_h; the lower clamp ends at P_R. Leakage flows past the calibrating piston from P_h and to P_R. So
//! q_L and q_LC are proportional to P_h - P_R, and k = 2 q_L/P_h.
//!
//! **Stepping.** "Of interest is the 'stepping' characteristic produced with the mathematical model during drift ... due to the method of
//! implementing coulomb friction" (Section III): the report's latch releases the load only above Delta F. With exact friction the ram
//! creeps smoothly; with the latch's excess, about 5 % of Delta F, it steps as in the report.

use crate::actuator_set::ActuatorSet;
use crate::modes::{Constants, Pressures};

/// A valve that no longer switches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StuckValve {
    /// The large volume's actuating valve.
    Actuating,
    /// The direction valve.
    Direction,
}

/// The sensor of the ram's position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum Encoder {
    /// The sensor measures the position.
    Sound,
    /// The sensor gives no measurement, and the actuator detects this: it counts its volumes from the last position.
    Lost,
    /// The sensor holds its last value, and the actuator does not detect this.
    Frozen,
}

/// An actuator's condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// Factor on q_L and q_LC.
    pub leakage_scale: f64,
    /// Excess of static friction over Delta F, as a share: the report's "stepping".
    pub stepping: f64,
    /// Missing share of V_c, in \[0, 1).
    pub short_volume: f64,
    /// Missing share of P_h, in \[0, 1).
    pub lost_supply: f64,
    /// Missing share of beta/V, in \[0, 1).
    pub air: f64,
    /// Additional time of one latch of the large volume's actuating valve, beyond T_v, s.
    pub slow_latch: f64,
    /// Stuck valve; `None` if no valve is stuck.
    pub stuck: Option<StuckValve>,
    /// State of the position measurement.
    pub encoder: Encoder,
}

impl Condition {
    /// Condition without wear and faults.
    pub const SOUND: Self = Self {
        leakage_scale: 1.0,
        stepping: 0.0,
        short_volume: 0.0,
        lost_supply: 0.0,
        air: 0.0,
        slow_latch: 0.0,
        stuck: None,
        encoder: Encoder::Sound,
    };

    /// Lists the faults beyond the wear in `worn`, each as text.
    #[must_use]
    pub fn faults_beside(&self, worn: &Self) -> Vec<String> {
        let mut faults = Vec::new();
        let mut percent = |share: f64, what: &str| {
            if share > 0.0 {
                faults.push(format!("{what} by {:.1} %", 100.0 * share));
            }
        };
        percent(self.short_volume, "volume short");
        percent(self.lost_supply, "supply pressure low");
        percent(self.air, "oil softened by air");
        if self.leakage_scale > worn.leakage_scale {
            let grown = self.leakage_scale / worn.leakage_scale;
            faults.push(format!("leakage grown {grown:.1} times"));
        }
        if self.slow_latch > 0.0 {
            let late = 1e3 * self.slow_latch;
            faults.push(format!("one latch is slow by {late:.1} ms"));
        }
        match self.stuck {
            Some(StuckValve::Actuating) => faults.push("actuating valve stuck".to_owned()),
            Some(StuckValve::Direction) => faults.push("direction valve stuck".to_owned()),
            None => {}
        }
        match self.encoder {
            Encoder::Lost => faults.push("encoder lost".to_owned()),
            Encoder::Frozen => faults.push("encoder frozen".to_owned()),
            Encoder::Sound => {}
        }
        faults
    }
}

/// Leakage flows past the calibrating piston, m^3/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leakages {
    /// q_L: drift; its sign is the sign valve's polarity.
    pub rate_gain: f64,
    /// q_LC: constant.
    pub error_rate: f64,
}

/// Constants of a sound actuator that its condition changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sound {
    constants: Constants,
    leakages: Leakages,
    pressures: Pressures,
}

impl Sound {
    /// Reads these constants from an actuator's constants.
    #[must_use]
    pub fn new(set: &ActuatorSet) -> Self {
        Self {
            constants: Constants::new(set),
            leakages: Leakages {
                rate_gain: set.rate_gain,
                error_rate: set.error_rate,
            },
            pressures: Pressures::new(set),
        }
    }

    /// Pressures at the ram in a condition.
    #[must_use]
    pub(crate) fn pressures(&self, condition: &Condition) -> Pressures {
        let left = 1.0 - condition.lost_supply;
        Pressures {
            supply: self.pressures.supply * left,
            back: self.pressures.back,
            resting: self.pressures.resting * left,
        }
    }

    /// Constants of the ram and leakages in a condition.
    #[must_use]
    pub fn in_condition(&self, condition: &Condition) -> (Constants, Leakages) {
        let left = 1.0 - condition.lost_supply;
        let sound = &self.pressures;
        let supply = sound.supply * left;
        let drive = (supply - sound.back) / (sound.supply - sound.back);
        let scale = condition.leakage_scale * drive.max(0.0);
        let leakages = Leakages {
            rate_gain: self.leakages.rate_gain * scale,
            error_rate: self.leakages.error_rate * scale,
        };
        let sound = self.constants;
        // Oil does not flow from the return into the ram: the clamp ends at P_R.
        let negative = sound.clamp_negative * left;
        let above_return = self.pressures.resting * left - self.pressures.back;
        let constants = Constants {
            stiffness: sound.stiffness * (1.0 - condition.air),
            leakage: 2.0 * leakages.rate_gain / supply,
            clamp_positive: sound.clamp_positive * left,
            clamp_negative: negative.min(above_return.max(1e-3 * negative)),
            stepping: condition.stepping,
            ..sound
        };
        (constants, leakages)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;

    #[test]
    fn a_sound_actuator_is_as_its_file_says_to_the_last_bit() {
        for name in ["auv", "table_3_1", "table_4_1"] {
            let set = load(name).expect("built in");
            let (constants, leakages) = Sound::new(&set).in_condition(&Condition::SOUND);
            assert_eq!(constants, Constants::new(&set));
            assert_eq!(leakages.rate_gain, set.rate_gain);
            assert_eq!(leakages.error_rate, set.error_rate);
        }
    }

    #[test]
    fn every_fault_has_its_words_and_wear_has_none() {
        let worn = Condition {
            leakage_scale: 3.0,
            stepping: 0.05,
            ..Condition::SOUND
        };
        assert!(worn.faults_beside(&worn).is_empty());
        let ill = Condition {
            leakage_scale: 6.0,
            short_volume: 0.1,
            lost_supply: 0.25,
            air: 0.5,
            slow_latch: 0.004,
            stuck: Some(StuckValve::Direction),
            encoder: Encoder::Lost,
            ..worn
        };
        assert_eq!(
            ill.faults_beside(&worn),
            [
                "volume short by 10.0 %",
                "supply pressure low by 25.0 %",
                "oil softened by air by 50.0 %",
                "leakage grown 2.0 times",
                "one latch is slow by 4.0 ms",
                "direction valve stuck",
                "encoder lost",
            ]
        );
    }

    #[test]
    fn half_the_supply_halves_the_clamps_and_more_than_halves_the_drift() {
        let set = load("table_4_1").expect("built in");
        let condition = Condition {
            lost_supply: 0.5,
            ..Condition::SOUND
        };
        let (constants, leakages) = Sound::new(&set).in_condition(&condition);
        assert_eq!(constants.clamp_positive, 0.5 * set.oil.clamp_positive);
        // (1065 - 130)/(2130 - 130)
        assert!((leakages.rate_gain / set.rate_gain - 0.4675).abs() < 1e-12);
        let almost_none = Condition {
            lost_supply: 0.99,
            ..Condition::SOUND
        };
        let (_, leakages) = Sound::new(&set).in_condition(&almost_none);
        assert_eq!(
            leakages.rate_gain, 0.0,
            "below the return pressure nothing drives it"
        );
    }
}
