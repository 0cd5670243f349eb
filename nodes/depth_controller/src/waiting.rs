//! A vehicle state that waits until its sensor readings have arrived.
//!
//! The readings arrive on separate topics, in any order. A repeated state means that the vehicle misses an answer; the readings are repeated too,
//! perhaps after the state. A state received [`MAX_REPEATS`] times is answered without the missing readings.

use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::VehicleState;

/// Number of receptions of a state after which it is answered without the missing sensor readings.
pub(crate) const MAX_REPEATS: u32 = 3;

/// The waiting state, and the number of times that it was received.
#[derive(Clone, Debug, Default)]
pub(crate) struct Waiting {
    state: Option<VehicleState>,
    received: u32,
}

impl Waiting {
    /// Stores a state, or returns it if it can be answered now. A state that waited before is dropped, since the vehicle has moved on.
    pub(crate) fn on_state(&mut self, state: VehicleState, ready: bool) -> Option<VehicleState> {
        let stamp = |state: &VehicleState| state.header.stamp.nanos();
        let again = self
            .state
            .as_ref()
            .is_some_and(|s| stamp(s) == stamp(&state));
        self.received = if again { self.received + 1 } else { 1 };
        if ready || self.received >= MAX_REPEATS {
            self.state = None;
            return Some(state);
        }
        self.state = Some(state);
        None
    }

    /// Called when a sensor reading arrives: returns the waiting state if it can be answered now.
    pub(crate) fn on_instrument(
        &mut self,
        ready: impl FnOnce(&Time) -> bool,
    ) -> Option<VehicleState> {
        self.state.take_if(|state| ready(&state.header.stamp))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(k: i64) -> VehicleState {
        let mut state = VehicleState::default();
        state.header.stamp = Time::from_nanos(k);
        state
    }

    #[test]
    fn a_state_is_answered_with_its_instruments_last_word() {
        let mut waiting = Waiting::default();
        assert_eq!(waiting.on_state(state(1), true), Some(state(1)));
        assert_eq!(waiting.on_state(state(2), false), None);
        assert_eq!(waiting.on_instrument(|_| false), None);
        assert_eq!(
            waiting.on_instrument(|stamp| stamp.nanos() == 2),
            Some(state(2))
        );
        assert_eq!(waiting.on_instrument(|_| true), None);
    }

    #[test]
    fn a_lost_word_is_waited_for_until_the_state_has_been_said_three_times() {
        let mut waiting = Waiting::default();
        assert_eq!(waiting.on_state(state(1), false), None);
        assert_eq!(waiting.on_state(state(1), false), None);
        let mut served = waiting.clone();
        assert_eq!(
            served.on_instrument(|_| true),
            Some(state(1)),
            "the repeated state"
        );
        assert_eq!(waiting.on_state(state(1), false), Some(state(1)));
        // Another state begins anew.
        assert_eq!(waiting.on_state(state(2), false), None);
        assert_eq!(waiting.on_state(state(3), false), None);
        assert_eq!(waiting.on_state(state(3), false), None);
        assert_eq!(waiting.on_state(state(3), false), Some(state(3)));
    }
}
