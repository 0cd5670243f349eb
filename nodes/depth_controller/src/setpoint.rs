//! A setpoint between the operator and a loop: whose word counts, its limits, and how fast it may move.

use crate::limits::{bounded, slewed};

/// The bounds of a setpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least it may be.
    pub min: f64,
    /// The most it may be.
    pub max: f64,
    /// How fast it may move, per second; 0 for as fast as it is said.
    pub rate: f64,
}

impl Bounds {
    /// No bounds.
    pub const NONE: Self = Self {
        min: f64::MIN,
        max: f64::MAX,
        rate: 0.0,
    };
}

/// The operator's word.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Word {
    value: f64,
    /// When it came on the topic, ns of the run; `None` for a live change of the parameter, which
    /// does not grow old.
    heard: Option<i64>,
}

/// One quantity's setpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setpoint {
    word: Option<Word>,
    /// Where the moving setpoint stands; `None` while no loop follows it.
    held: Option<f64>,
}

impl Setpoint {
    /// Takes the operator's word from the topic, at `elapsed` nanoseconds of the run.
    pub fn say(&mut self, value: f64, elapsed: i64) {
        let heard = Some(elapsed);
        self.word = Some(Word { value, heard });
    }

    /// Takes a live change of the parameter as the last word.
    pub fn change(&mut self, value: f64) {
        self.word = Some(Word { value, heard: None });
    }

    /// Forgets the operator's word.
    pub fn forget(&mut self) {
        self.word = None;
    }

    /// Forgets a word from the topic that is older than `timeout` seconds (0: none is), and says
    /// whether it did.
    pub fn expire(&mut self, timeout: f64, elapsed: i64) -> bool {
        let heard = self.word.and_then(|word| word.heard);
        let old = heard.is_some_and(|at| (elapsed - at) as f64 * 1e-9 > timeout);
        let expired = timeout > 0.0 && old;
        if expired {
            self.forget();
        }
        expired
    }

    /// The operator's word.
    #[must_use]
    pub fn word(&self) -> Option<f64> {
        self.word.map(|word| word.value)
    }

    /// Whether the word came on the topic.
    #[must_use]
    pub fn is_from_the_topic(&self) -> bool {
        self.word.is_some_and(|word| word.heard.is_some())
    }

    /// Nobody follows the setpoint now; followed again, it begins where the vehicle then is.
    pub fn release(&mut self) {
        self.held = None;
    }

    /// Where the setpoint stood at the last tick; `None` when nobody followed it.
    #[must_use]
    pub fn stands(&self) -> Option<f64> {
        self.held
    }

    /// The setpoint `dt` seconds on, on its way from where it stood, or from `present`, to `target`.
    pub fn follow(&mut self, target: f64, present: f64, bounds: Bounds, dt: f64) -> f64 {
        let within = |value: f64| value.clamp(bounds.min, bounds.max);
        let from = within(self.held.unwrap_or(present));
        let held = bounded(slewed(from, within(target), bounds.rate, dt));
        self.held = Some(held);
        held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds {
        min: 0.0,
        max: 3.0,
        rate: 0.5,
    };

    #[test]
    fn a_setpoint_moves_from_where_the_vehicle_is_to_its_limit() {
        let mut setpoint = Setpoint::default();
        assert_eq!(setpoint.follow(9.0, 1.0, BOUNDS, 0.0), 1.0);
        assert_eq!(setpoint.follow(9.0, 1.1, BOUNDS, 1.0), 1.5);
        for _ in 0..10 {
            setpoint.follow(9.0, 1.1, BOUNDS, 1.0);
        }
        assert_eq!(setpoint.follow(9.0, 1.1, BOUNDS, 1.0), 3.0);
        setpoint.release();
        assert_eq!(setpoint.follow(0.0, 2.0, BOUNDS, 0.0), 2.0);
    }

    #[test]
    fn without_a_rate_the_setpoint_is_where_it_is_said_to_be_at_once() {
        let bounds = Bounds {
            rate: 0.0,
            ..BOUNDS
        };
        assert_eq!(Setpoint::default().follow(2.5, 0.0, bounds, 0.0), 2.5);
    }

    #[test]
    fn a_word_from_the_topic_grows_old_and_a_parameter_does_not() {
        let mut setpoint = Setpoint::default();
        setpoint.say(1.0, 0);
        assert!(!setpoint.expire(2.0, 2_000_000_000));
        assert!(!setpoint.expire(0.0, i64::MAX), "0: never");
        assert!(setpoint.expire(2.0, 2_000_000_001));
        assert_eq!(setpoint.word(), None);
        setpoint.change(1.0);
        assert!(!setpoint.expire(2.0, i64::MAX));
        assert_eq!(setpoint.word(), Some(1.0));
    }
}
