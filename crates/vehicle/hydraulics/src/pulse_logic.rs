//! The pulse logic of Figure 2-6: one state machine from an error to sign and volume pulses.
//!
//! Once in each valve cycle n, with e_s <= e_b, where sgn 0 means "unchanged":
//!
//! ```text
//! eps += Input_n - FB_(n-1)                 Input: the change of plane angle wanted
//!
//! state     when            sign pulse                        FB
//! large     |eps| > e_b     sgn eps                           delta_b sgn eps
//! small     |eps| > e_s     sgn eps                           delta_s sgn eps
//! none      otherwise       drift option 1: sgn Input         delta_n sgn eps
//!                                        2: sgn eps           + delta_p sgn(sign pulse)
//!                                        3: the last one
//!
//! a volume, |X_1| > X_lim, outward:  inhibited, the state is none; FB stays (limit option 1)
//!                                    or becomes delta_L sgn eps (limit option 2)
//! ```
//!
//! The report's options (Section II.B.1) are settings of this one machine:
//!
//! - **single-speed**: e_s = e_b, so "small" never occurs. With e_b = (quantum + hysteresis)/2 it is a quantizer with hysteresis. Phase I
//!   and III: drift option 3, limit option 1, delta_n = delta_p = 0.
//! - **two-speed**: a large volume for slewing, a small one for fine quantization.
//! - **precision mode** ("accurate positioning"): drift option 1 or 2. A sign pulse without a volume switches the direction valve, and with it the
//!   direction of the drift, but displaces no calibrated volume ([`crate::valves`]): the drift then positions the ram between two quanta. With
//!   delta_p = K_L T the logic counts the drift.
//! - **feedback flexibility**: without a volume, FB may have the polarity of eps (delta_n), of the sign pulse (delta_p), or both.
//!
//! The analog mode has no sum: eps comes from the error detector ([`crate::position_loop`]) and is the Input, so drift options 1 and 2 are
//! identical.
//!
//! The report is ambiguous in two places. The report's text inhibits volumes beyond X_lim without naming a direction. Only outward volumes are
//! inhibited here; otherwise the ram would lock up. "When changing the direction of motion ... the volume command in parallel with the sign command
//! is inhibited" does not lose a volume, because the sign valve's own switching moves it. The reading in which the volume is lost is
//! [`SignChange::DropsVolume`].

use crate::actuator_set::{ActuatorSet, LimitOption};

/// The volume of one cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Volume {
    /// No calibrated volume.
    None,
    /// The small volume of a two-speed actuator, V_cs.
    Small,
    /// The large volume, V_cb; a single-speed actuator has only this one.
    Large,
}

/// The command to the valves in one cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    /// Commanded calibrated volume.
    pub volume: Volume,
    /// The sign pulse: +1 or -1.
    pub sign: i8,
}

/// Signal for the drift's polarity while no volume is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriftOption {
    /// Option 1: the sign of Input.
    Input,
    /// Option 2: the sign of eps.
    Error,
    /// Option 3: the last command.
    LastCommand,
}

/// Treatment of a volume commanded together with a change of sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, planesman_parameters::Choice)]
pub enum SignChange {
    /// The sign valve's switching moves it (Appendix A): nothing is lost.
    MovesVolume,
    /// Literal reading of Section II.A.1: the direction changes, the volume is dropped, and FB still counts it.
    DropsVolume,
}

/// The options of Section II.B.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Whether the small volume is used. An actuator without a small volume stays single-speed.
    pub two_speed: bool,
    /// Drift polarity while no volume is due.
    pub drift: DriftOption,
    /// delta_n, rad: counted without a volume, with the polarity of eps.
    pub error_feedback: f64,
    /// delta_p, rad: counted without a volume, with the polarity of the sign pulse.
    pub sign_feedback: f64,
    /// Treatment of a volume in parallel with a change of sign.
    pub sign_change: SignChange,
}

impl Options {
    /// Single-speed operation, the same as in Phases I and III.
    pub const SINGLE_SPEED: Self = Self {
        two_speed: false,
        drift: DriftOption::LastCommand,
        error_feedback: 0.0,
        sign_feedback: 0.0,
        sign_change: SignChange::MovesVolume,
    };
    /// Two-speed operation.
    pub const TWO_SPEED: Self = Self {
        two_speed: true,
        ..Self::SINGLE_SPEED
    };
    /// Accurate positioning with one volume; the drift follows the error.
    pub const PRECISION: Self = Self {
        drift: DriftOption::Error,
        ..Self::SINGLE_SPEED
    };
    /// Accurate positioning with two volumes.
    pub const TWO_SPEED_PRECISION: Self = Self {
        two_speed: true,
        ..Self::PRECISION
    };
}

/// Decision of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// The command to the valves.
    pub command: Command,
    /// FB, rad: angle that the logic counts as moved.
    pub feedback: f64,
    /// Whether the travel limit refused a volume.
    pub inhibited: bool,
}

/// A threshold of the error for a volume, and the angle counted for it; both rad.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Level {
    threshold: f64,
    quantum: f64,
}

/// The state machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulseLogic {
    large: Level,
    small: Option<Level>,
    inhibit_beyond: f64,
    limit_option: LimitOption,
    options: Options,
    error: f64,
    feedback: f64,
    sign: i8,
}

/// Sign of `value`; `None` for 0.
fn sgn(value: f64) -> Option<i8> {
    match value {
        v if v > 0.0 => Some(1),
        v if v < 0.0 => Some(-1),
        _ => None,
    }
}

impl PulseLogic {
    /// Returns a single-speed logic at rest, the last sign pulse positive.
    #[must_use]
    pub fn new(set: &ActuatorSet) -> Self {
        Self::with_options(set, Options::SINGLE_SPEED)
    }

    /// Returns a logic with `options` at rest, the last sign pulse positive.
    #[must_use]
    pub fn with_options(set: &ActuatorSet, options: Options) -> Self {
        Self {
            large: Level {
                threshold: set.threshold,
                quantum: set.quantum,
            },
            small: set.small.map(|small| Level {
                threshold: small.threshold,
                quantum: small.quantum,
            }),
            inhibit_beyond: set.inhibit_beyond,
            limit_option: set.limit_option,
            options,
            error: 0.0,
            feedback: 0.0,
            sign: 1,
        }
    }

    /// Sets the last sign pulse to `sign`, +1 or -1.
    #[must_use]
    pub fn settled(self, sign: i8) -> Self {
        Self { sign, ..self }
    }

    /// Changes the options from the next decision on.
    pub fn set_options(&mut self, options: Options) {
        self.options = options;
    }

    /// eps, rad, at the last decision.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Simulation mode, one cycle of the digital autopilot: adds `input` (rad, the wanted change of plane angle), subtracts the angle
    /// counted in the last cycle, and decides. `ram` is X_1, m.
    pub fn accumulate(&mut self, input: f64, ram: f64) -> Decision {
        self.cycle(input, self.error + (input - self.feedback), ram)
    }

    /// Analog mode: decides on the error `eps`, rad, and stores it. `ram` is X_1, m.
    pub fn decide(&mut self, eps: f64, ram: f64) -> Decision {
        self.cycle(eps, eps, ram)
    }

    /// Sets eps, rad, and clears the feedback: used when the loop is closed or opened around a displaced ram.
    pub fn restart_from(&mut self, eps: f64) {
        self.error = eps;
        self.feedback = 0.0;
    }

    /// Volume required for the error `eps`, and the angle counted for it.
    fn volume_due(&self, eps: f64) -> Option<(Volume, f64)> {
        if eps.abs() > self.large.threshold {
            return Some((Volume::Large, self.large.quantum));
        }
        let small = self.small.filter(|_| self.options.two_speed)?;
        (eps.abs() > small.threshold).then_some((Volume::Small, small.quantum))
    }

    /// Runs one cycle of the machine.
    fn cycle(&mut self, input: f64, eps: f64, ram: f64) -> Decision {
        let due = self.volume_due(eps);
        let last_sign = self.sign;
        self.sign = match (due, self.options.drift) {
            (Some(_), _) | (None, DriftOption::Error) => sgn(eps),
            (None, DriftOption::Input) => sgn(input),
            (None, DriftOption::LastCommand) => None,
        }
        .unwrap_or(last_sign);
        let sign = f64::from(self.sign);

        let inhibited = due.is_some() && ram.abs() > self.inhibit_beyond && ram * sign > 0.0;
        let dropped = self.options.sign_change == SignChange::DropsVolume && self.sign != last_sign;
        self.feedback = match (due, self.limit_option) {
            (Some(_), LimitOption::Aware(limit_feedback)) if inhibited => limit_feedback * sign,
            (Some((_, quantum)), _) => quantum * sign,
            (None, _) => {
                let polarity = f64::from(sgn(eps).unwrap_or(0));
                self.options.error_feedback * polarity + self.options.sign_feedback * sign
            }
        };
        self.error = eps;
        Decision {
            command: Command {
                volume: match due {
                    Some((volume, _)) if !inhibited && !dropped => volume,
                    _ => Volume::None,
                },
                sign: self.sign,
            },
            feedback: self.feedback,
            inhibited,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;
    use planesman_units::{DEGREE, INCH};

    fn polaris() -> ActuatorSet {
        let mut set = load("table_4_1").expect("built in");
        // e_b from its definition; the table prints it as 0.681.
        set.threshold = (set.quantum + set.quantum / 4.0) / 2.0;
        set
    }

    fn two_speed() -> ActuatorSet {
        load("auv_two_speed").expect("built in")
    }

    /// Where, in degrees, a volume is commanded as the input rises to `top` degrees and falls.
    fn switching_levels(mut logic: PulseLogic, top: f64) -> Vec<(f64, Command)> {
        let step = 0.000_5;
        let half = (top / step).round() as i32;
        let mut levels = Vec::new();
        for i in 1..=2 * half {
            let input = if i <= half { step } else { -step };
            let command = logic.accumulate(input * DEGREE, 0.0).command;
            if command.volume != Volume::None {
                levels.push((step * f64::from(i.min(2 * half - i)), command));
            }
        }
        levels
    }

    #[test]
    fn a_slow_triangle_switches_the_quantizer_a_quarter_quantum_apart() {
        let expected = [0.681, 1.771, 2.861, 2.589, 1.499, 0.409];
        let levels = switching_levels(PulseLogic::new(&polaris()), 3.0);
        assert_eq!(levels.len(), expected.len());
        for ((level, command), expected) in levels.iter().zip(expected) {
            assert!((level - expected).abs() < 2e-3, "{level} for {expected}");
            assert_eq!(command.volume, Volume::Large);
        }
        let width = (levels[2].0 - levels[3].0) * DEGREE;
        assert!((width - polaris().quantum / 4.0).abs() < 2e-3 * DEGREE);
    }

    #[test]
    fn what_is_booked_and_what_remains_add_up_to_what_was_asked_for() {
        let options = [
            Options::SINGLE_SPEED,
            Options::TWO_SPEED,
            Options::PRECISION,
            Options {
                drift: DriftOption::Input,
                error_feedback: 0.02 * DEGREE,
                sign_feedback: 0.01 * DEGREE,
                ..Options::TWO_SPEED_PRECISION
            },
        ];
        for (set, options) in [polaris(), two_speed()]
            .iter()
            .flat_map(|set| options.map(|options| (set, options)))
        {
            let mut logic = PulseLogic::with_options(set, options);
            let (mut asked, mut booked) = (0.0, 0.0);
            for i in 0..1000 {
                let input = 3.0 * DEGREE * libm::sin(f64::from(i));
                asked += input;
                let decision = logic.accumulate(input, 0.0);
                booked += decision.feedback;
                assert!((asked - booked - (logic.error() - decision.feedback)).abs() < 1e-12);
                let e_s = match set.small {
                    Some(small) if options.two_speed => small.threshold,
                    _ => set.threshold,
                };
                assert_eq!(
                    decision.command.volume == Volume::None,
                    logic.error().abs() <= e_s
                );
            }
        }
    }

    #[test]
    fn large_volumes_slew_and_small_ones_quantize_finely() {
        let set = two_speed();
        let logic = PulseLogic::with_options(&set, Options::TWO_SPEED);
        // A slow triangle never leaves the small volumes: e_s, then a quarter of a degree each.
        for (i, (level, command)) in switching_levels(logic, 2.0).iter().take(8).enumerate() {
            assert_eq!((command.volume, command.sign), (Volume::Small, 1));
            let expected = 0.15625 + 0.25 * i as f64;
            assert!((level - expected).abs() < 1e-3, "{level} for {expected}");
        }
        // A step is slewed in large volumes and finished with small ones.
        let mut logic = PulseLogic::with_options(&set, Options::TWO_SPEED);
        let mut volumes = vec![logic.accumulate(3.45 * DEGREE, 0.0).command.volume];
        volumes.extend((0..6).map(|_| logic.accumulate(0.0, 0.0).command.volume));
        use Volume::{Large, None, Small};
        assert_eq!(volumes, [Large, Large, Large, Small, Small, None, None]);
    }

    #[test]
    fn single_speed_is_two_speed_with_e_s_equal_to_e_b() {
        let mut set = two_speed();
        let single = PulseLogic::new(&set);
        if let Some(small) = &mut set.small {
            small.threshold = set.threshold;
        }
        let two = PulseLogic::with_options(&set, Options::TWO_SPEED);
        assert_eq!(switching_levels(two, 5.0), switching_levels(single, 5.0));
    }

    #[test]
    fn drift_option_3_repeats_the_last_command() {
        let mut logic = PulseLogic::new(&polaris());
        assert_eq!(logic.decide(-1.0, 0.0).command.sign, -1);
        let quiet = logic.decide(0.1 * DEGREE, 0.0).command;
        assert_eq!((quiet.volume, quiet.sign), (Volume::None, -1));
    }

    #[test]
    fn drift_option_1_follows_the_input_and_option_2_the_error() {
        let set = polaris();
        let after = |drift| {
            let mut logic = PulseLogic::with_options(
                &set,
                Options {
                    drift,
                    ..Options::PRECISION
                },
            );
            logic.accumulate(0.5 * DEGREE, 0.0);
            // The error stays positive while the input turns.
            let command = logic.accumulate(-0.1 * DEGREE, 0.0).command;
            assert_eq!(command.volume, Volume::None);
            let still = logic.accumulate(0.0, 0.0).command;
            assert_eq!(still.sign, command.sign, "an input of 0 keeps the sign");
            command.sign
        };
        assert_eq!(after(DriftOption::Input), -1);
        assert_eq!(after(DriftOption::Error), 1);
        assert_eq!(after(DriftOption::LastCommand), 1);
    }

    #[test]
    fn without_a_volume_the_feedback_has_the_polarity_of_the_error_the_sign_pulse_or_both() {
        let set = polaris();
        let (delta_n, delta_p) = (0.03 * DEGREE, 0.01 * DEGREE);
        for (n, p, expected) in [
            (0.0, 0.0, 0.0),
            (delta_n, 0.0, delta_n),
            (0.0, delta_p, -delta_p),
            (delta_n, delta_p, delta_n - delta_p),
        ] {
            let options = Options {
                error_feedback: n,
                sign_feedback: p,
                ..Options::SINGLE_SPEED
            };
            let mut logic = PulseLogic::with_options(&set, options);
            logic.decide(-2.0 * DEGREE, 0.0);
            // The error is positive, the last sign pulse negative.
            assert_eq!(logic.decide(0.2 * DEGREE, 0.0).feedback, expected);
        }
    }

    #[test]
    fn read_literally_a_change_of_sign_drops_its_volume_and_books_it() {
        let literal = Options {
            sign_change: SignChange::DropsVolume,
            ..Options::SINGLE_SPEED
        };
        let set = polaris();
        let mut logic = PulseLogic::with_options(&set, literal);
        let first = logic.decide(-2.0 * DEGREE, 0.0);
        assert_eq!(
            (first.command.volume, first.command.sign),
            (Volume::None, -1)
        );
        assert_eq!(first.feedback, -set.quantum);
        let second = logic.decide(-2.0 * DEGREE, 0.0);
        assert_eq!(second.command.volume, Volume::Large);
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
                assert!(outward.inhibited && outward.command.volume == Volume::None);
                assert_eq!(outward.feedback, side * booked);
                let inward = logic.decide(-side * 2.0 * DEGREE, ram);
                assert!(!inward.inhibited && inward.command.volume == Volume::Large);
                let within = logic.decide(side * 2.0 * DEGREE, side * 1.9 * INCH);
                assert!(within.command.volume == Volume::Large);
            }
        }
    }

    #[test]
    fn the_mirrored_input_gives_the_mirrored_commands() {
        for options in [
            Options::SINGLE_SPEED,
            Options::TWO_SPEED,
            Options::PRECISION,
            Options::TWO_SPEED_PRECISION,
        ] {
            let set = two_speed();
            let mut logic = PulseLogic::with_options(&set, options);
            let mut mirror = logic.settled(-1);
            for i in 0..2000 {
                let (input, ram) = (0.4 * DEGREE * libm::sin(f64::from(i)), 0.3 * INCH);
                let one = logic.accumulate(input, ram);
                let other = mirror.accumulate(-input, -ram);
                assert_eq!(other.command.volume, one.command.volume);
                assert_eq!(other.command.sign, -one.command.sign);
                assert_eq!(other.feedback, -one.feedback);
            }
        }
    }
}
