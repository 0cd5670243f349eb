//! The pulse logic of Figure 2-6, single-speed: from an error to sign and volume pulses.
//!
//! Once in each valve cycle n:
//!
//! ```text
//! eps += Input_n - FB_(n-1)                      Input: the change of plane angle wanted
//! |eps| > e_b:  volume, FB = delta_b sgn eps     sign pulse = sgn eps
//! otherwise:    none,   FB = 0                   sign pulse = the last one (drift option 3)
//! volume, |X_1| > X_lim, outward:  inhibited; FB stays (limit option 1)
//!                                  or becomes delta_L sgn eps (limit option 2)
//! ```
//!
//! With e_b = (quantum + hysteresis)/2 this is a quantizer with hysteresis. The report's text
//! inhibits beyond X_lim without saying in which direction; only outward volumes are inhibited
//! here, since the literal reading locks the ram up.

use crate::actuator_set::{ActuatorSet, LimitOption};

/// What the logic sends to the valves in one cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    /// Whether a calibrated volume is asked for.
    pub volume: bool,
    /// The sign pulse: +1 or -1.
    pub sign: i8,
}

/// One cycle's decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// What goes to the valves.
    pub command: Command,
    /// FB, rad: what the logic books as moved.
    pub feedback: f64,
    /// Whether the travel limit refused a volume.
    pub inhibited: bool,
}

/// The quantizer with its memory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulseLogic {
    threshold: f64,
    quantum: f64,
    inhibit_beyond: f64,
    limit_option: LimitOption,
    error: f64,
    feedback: f64,
    sign: i8,
}

impl PulseLogic {
    /// At rest, the last sign pulse positive.
    #[must_use]
    pub fn new(set: &ActuatorSet) -> Self {
        Self {
            threshold: set.threshold,
            quantum: set.quantum,
            inhibit_beyond: set.inhibit_beyond,
            limit_option: set.limit_option,
            error: 0.0,
            feedback: 0.0,
            sign: 1,
        }
    }

    /// eps, rad, at the last decision.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Open loop, a cycle of the digital autopilot: adds `input` (rad, the change of plane
    /// angle wanted), takes off what the last cycle booked, and decides. `ram` is X_1, m.
    pub fn accumulate(&mut self, input: f64, ram: f64) -> Decision {
        self.decide(self.error + (input - self.feedback), ram)
    }

    /// Decides on the error `eps`, rad, as it is (the analog mode's, from the position loop),
    /// and remembers it. `ram` is X_1, m.
    pub fn decide(&mut self, eps: f64, ram: f64) -> Decision {
        self.error = eps;
        let outward_limit = ram.abs() > self.inhibit_beyond;
        let wanted = eps.abs() > self.threshold;
        if wanted {
            self.sign = if eps > 0.0 { 1 } else { -1 };
        }
        let inhibited = wanted && outward_limit && ram * f64::from(self.sign) > 0.0;
        let booked = match (wanted, inhibited, self.limit_option) {
            (false, _, _) => 0.0,
            (true, true, LimitOption::Aware(limit_feedback)) => limit_feedback,
            (true, _, _) => self.quantum,
        };
        self.feedback = booked * f64::from(self.sign);
        Decision {
            command: Command {
                volume: wanted && !inhibited,
                sign: self.sign,
            },
            feedback: self.feedback,
            inhibited,
        }
    }

    /// Sets eps, rad, and forgets what was booked: the loop is closed or opened around a ram
    /// that is already somewhere.
    pub fn restart_from(&mut self, eps: f64) {
        self.error = eps;
        self.feedback = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;
    use crate::units::{DEGREE, INCH};

    fn polaris() -> ActuatorSet {
        let mut set = load("table_4_1").expect("built in");
        // e_b from its definition; the table prints it as 0.681.
        set.threshold = (set.quantum + set.quantum / 4.0) / 2.0;
        set
    }

    /// Where, in degrees, the quantized output steps as the input rises by three quanta and falls.
    fn switching_levels() -> Vec<f64> {
        let mut logic = PulseLogic::new(&polaris());
        let step = 0.000_5 * DEGREE;
        let (mut wanted, mut levels) = (0.0, Vec::new());
        for i in 0..12_000 {
            let input = if i < 6_000 { step } else { -step };
            wanted += input;
            if logic.accumulate(input, 0.0).command.volume {
                levels.push(wanted / DEGREE);
            }
        }
        levels
    }

    #[test]
    fn a_slow_triangle_switches_the_quantizer_a_quarter_quantum_apart() {
        let expected = [0.681, 1.771, 2.861, 2.589, 1.499, 0.409];
        let levels = switching_levels();
        assert_eq!(levels.len(), expected.len());
        for (level, expected) in levels.iter().zip(expected) {
            assert!((level - expected).abs() < 2e-3, "{level} for {expected}");
        }
        let width = (levels[2] - levels[3]) * DEGREE;
        assert!((width - polaris().quantum / 4.0).abs() < 2e-3 * DEGREE);
    }

    #[test]
    fn what_is_booked_and_what_remains_add_up_to_what_was_asked_for() {
        let set = polaris();
        let mut logic = PulseLogic::new(&set);
        let (mut asked, mut booked) = (0.0, 0.0);
        for i in 0..1000 {
            let input = 3.0 * DEGREE * f64::from(i).sin();
            asked += input;
            let decision = logic.accumulate(input, 0.0);
            booked += decision.feedback;
            assert!((asked - booked - (logic.error() - decision.feedback)).abs() < 1e-12);
            assert_eq!(decision.command.volume, logic.error().abs() > set.threshold);
        }
    }

    #[test]
    fn without_a_volume_the_sign_pulse_is_the_last_one() {
        let mut logic = PulseLogic::new(&polaris());
        assert_eq!(logic.decide(-1.0, 0.0).command.sign, -1);
        let quiet = logic.decide(0.1 * DEGREE, 0.0).command;
        assert_eq!((quiet.volume, quiet.sign), (false, -1));
    }

    #[test]
    fn beyond_x_lim_only_outward_volumes_are_inhibited() {
        let mut set = polaris();
        set.inhibit_beyond = 2.0 * INCH;
        for (option, booked) in [
            (LimitOption::Unaware, set.quantum),
            (LimitOption::Aware(0.3 * DEGREE), 0.3 * DEGREE),
        ] {
            set.limit_option = option;
            let mut logic = PulseLogic::new(&set);
            for side in [1.0, -1.0] {
                let ram = side * 2.1 * INCH;
                let outward = logic.decide(side * 2.0 * DEGREE, ram);
                assert!(outward.inhibited && !outward.command.volume);
                assert_eq!(outward.feedback, side * booked);
                let inward = logic.decide(-side * 2.0 * DEGREE, ram);
                assert!(!inward.inhibited && inward.command.volume);
                let within = logic.decide(side * 2.0 * DEGREE, side * 1.9 * INCH);
                assert!(within.command.volume);
            }
        }
    }
}
