//! Error detector of the analog mode: commanded angle minus predicted position.
//!
//! In the analog mode "a commanded position is compared with the actual position" (Section II.A). A volume commanded at most m cycles ago
//! has not completely arrived at the next decision, so the detector subtracts the volumes that are still on their way:
//!
//! ```text
//! eps_pred = delta_c - delta_measured - (what the last m commands will move)
//! m = ceil((T_D + T_v + T_f)/T) - 1
//! ```
//!
//! The report's "the last command" corresponds to m = 1, correct for its T_v + T_f of 15.5 ms and a T of 12.1 ms. Too large an m makes the
//! loop chatter from cycle to cycle.

use crate::actuator_set::{ActuatorSet, MOST_CYCLES_IN_FLIGHT};
use crate::pulse_logic::{Command, Volume};

/// The predicting error detector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PositionLoop {
    /// Angles of a large and a small volume, rad.
    large: f64,
    small: f64,
    depth: usize,
    /// Angles of the last cycles' commands, rad, latest first; the first `depth` are used.
    latest: [f64; MOST_CYCLES_IN_FLIGHT],
}

impl PositionLoop {
    /// Returns a detector with no volume on its way.
    #[must_use]
    pub(crate) fn new(set: &ActuatorSet) -> Self {
        Self {
            large: set.plane_quantum(),
            small: set
                .small
                .map_or(0.0, |small| small.volume / set.area / set.load.moment_arm),
            depth: set.commands_in_flight(),
            latest: [0.0; MOST_CYCLES_IN_FLIGHT],
        }
    }

    /// eps_pred, rad, for a commanded and a measured plane angle, rad.
    #[must_use]
    pub(crate) fn error(&self, command: f64, measured: f64) -> f64 {
        let on_its_way: f64 = self.latest[..self.depth].iter().sum();
        (command - measured) - on_its_way
    }

    /// Stores the command of this cycle.
    pub(crate) fn remember(&mut self, command: Command) {
        let moves = match command.volume {
            Volume::None => 0.0,
            Volume::Small => self.small,
            Volume::Large => self.large,
        };
        self.latest.rotate_right(1);
        self.latest[0] = moves * f64::from(command.sign);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;
    use planesman_units::DEGREE;

    #[test]
    fn polaris_looks_one_command_ahead_and_the_auv_none() {
        for (name, m) in [
            ("table_4_1", 1),
            ("table_3_1", 1),
            ("auv", 0),
            ("auv_two_speed", 0),
        ] {
            assert_eq!(
                load(name).expect("built in").commands_in_flight(),
                m,
                "{name}"
            );
        }
    }

    #[test]
    fn the_last_command_is_taken_off_until_it_has_arrived() {
        let mut detector = PositionLoop::new(&load("table_4_1").expect("built in"));
        assert_eq!(detector.error(2.0 * DEGREE, 0.0), 2.0 * DEGREE);
        let sign = 1;
        detector.remember(Command {
            volume: Volume::Large,
            sign,
        });
        assert!((detector.error(2.0 * DEGREE, 0.0) / DEGREE - (2.0 - 1.0886)).abs() < 1e-4);
        detector.remember(Command {
            volume: Volume::None,
            sign,
        });
        assert_eq!(detector.error(2.0 * DEGREE, 0.0), 2.0 * DEGREE);
    }
}
