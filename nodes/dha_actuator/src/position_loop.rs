//! The analog mode's error detector: commanded against measured position, a step ahead.
//!
//! In the analog mode "a commanded position is compared with the actual position" (Section
//! II.A). A volume commanded m cycles ago or later has not wholly arrived when the next
//! decision is due, so the detector takes off what is still on its way:
//!
//! ```text
//! eps_pred = delta_c - delta_measured - (the last m commanded quanta)
//! m = ceil((T_D + T_v + T_f)/T) - 1
//! ```
//!
//! The report's "the last command" is m = 1, right for its T_v + T_f of 15.5 ms against a T of
//! 12.1 ms. With m too large the loop chatters from cycle to cycle.

use crate::actuator_set::{ActuatorSet, MOST_CYCLES_IN_FLIGHT};

/// The predicting error detector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionLoop {
    quantum: f64,
    depth: usize,
    /// Strokes of the last cycles, latest first; `depth` of them count.
    latest: [i8; MOST_CYCLES_IN_FLIGHT],
}

impl PositionLoop {
    /// With nothing on its way.
    #[must_use]
    pub fn new(set: &ActuatorSet) -> Self {
        Self {
            quantum: set.plane_quantum(),
            depth: set.commands_in_flight(),
            latest: [0; MOST_CYCLES_IN_FLIGHT],
        }
    }

    /// eps_pred, rad, for a `command` and a `measured` plane angle, rad.
    #[must_use]
    pub fn error(&self, command: f64, measured: f64) -> f64 {
        let on_its_way: i32 = self.latest[..self.depth]
            .iter()
            .map(|q| i32::from(*q))
            .sum();
        (command - measured) - self.quantum * f64::from(on_its_way)
    }

    /// Remembers the quanta commanded in this cycle: +1, 0 or -1.
    pub fn remember(&mut self, quanta: i8) {
        self.latest.rotate_right(1);
        self.latest[0] = quanta;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::actuator_file::load;
    use crate::units::DEGREE;

    #[test]
    fn polaris_looks_one_command_ahead_and_the_auv_none() {
        for (name, m) in [("table_4_1", 1), ("table_3_1", 1), ("auv", 0)] {
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
        detector.remember(1);
        assert!((detector.error(2.0 * DEGREE, 0.0) / DEGREE - (2.0 - 1.0886)).abs() < 1e-4);
        detector.remember(0);
        assert_eq!(detector.error(2.0 * DEGREE, 0.0), 2.0 * DEGREE);
    }
}
