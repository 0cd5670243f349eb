//! The setpoints of depth, pitch, heading and speed: source, limits, rate.

use crate::limits::{bounded, slewed};

/// The bounds of a setpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// The minimum.
    pub min: f64,
    /// The maximum.
    pub max: f64,
    /// The largest rate of change, per second; 0 for no limit.
    pub rate: f64,
}

impl Bounds {
    /// No bounds.
    pub(crate) const NONE: Self = Self {
        min: f64::MIN,
        max: f64::MAX,
        rate: 0.0,
    };

    /// The value limited to the bounds.
    #[must_use]
    pub(crate) fn hold(&self, value: f64) -> f64 {
        value.clamp(self.min, self.max)
    }
}

/// The operator's last command.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Commanded {
    value: f64,
    /// The time of its reception on the topic, ns of the run; `None` for a live change of the parameter, which does not expire.
    received: Option<i64>,
}

/// One quantity's setpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Setpoint {
    commanded: Option<Commanded>,
    /// The present value of the moving setpoint; `None` while no loop follows it.
    position: Option<f64>,
}

impl Setpoint {
    /// Takes a command from the topic, at `elapsed` nanoseconds of the run.
    pub(crate) fn command(&mut self, value: f64, elapsed: i64) {
        let received = Some(elapsed);
        self.commanded = Some(Commanded { value, received });
    }

    /// Takes a live change of the parameter as the last command.
    pub(crate) fn change(&mut self, value: f64) {
        let received = None;
        self.commanded = Some(Commanded { value, received });
    }

    /// Forgets the operator's command.
    pub(crate) fn forget(&mut self) {
        self.commanded = None;
    }

    /// Forgets a command from the topic that is older than `timeout` seconds (0: never); returns whether it did.
    pub(crate) fn expire(&mut self, timeout: f64, elapsed: i64) -> bool {
        let received = self.commanded.and_then(|commanded| commanded.received);
        let old = received.is_some_and(|at| (elapsed - at) as f64 * 1e-9 > timeout);
        let expired = timeout > 0.0 && old;
        if expired {
            self.forget();
        }
        expired
    }

    /// The operator's last command.
    #[must_use]
    pub(crate) fn commanded(&self) -> Option<f64> {
        self.commanded.map(|commanded| commanded.value)
    }

    /// Whether the setpoint came on the topic.
    #[must_use]
    pub(crate) fn is_from_the_topic(&self) -> bool {
        self.commanded
            .is_some_and(|commanded| commanded.received.is_some())
    }

    /// Marks the setpoint as not followed; when followed again, it begins at the vehicle's present value.
    pub(crate) fn release(&mut self) {
        self.position = None;
    }

    /// The setpoint at the last tick; `None` if no loop followed it.
    #[must_use]
    pub(crate) fn current_target(&self) -> Option<f64> {
        self.position
    }

    /// The setpoint `dt` seconds later, on its way from its last value, or from `present`, to `target`.
    pub(crate) fn follow(&mut self, target: f64, present: f64, bounds: Bounds, dt: f64) -> f64 {
        let from = bounds.hold(self.position.unwrap_or(present));
        let position = bounded(slewed(from, bounds.hold(target), bounds.rate, dt));
        self.position = Some(position);
        position
    }
}

/// A quantity for which an operator gives a setpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// m, down.
    Depth,
    /// rad, bow up; in mode pitch.
    Pitch,
    /// rad, from the initial heading, to starboard.
    Heading,
    /// m/s, through the water.
    Speed,
}

impl Quantity {
    /// Every quantity.
    pub const ALL: [Self; 4] = [Self::Depth, Self::Pitch, Self::Heading, Self::Speed];

    /// Name of the setpoint, as in the topic `NAME_setpoint`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Pitch => "pitch",
            Self::Heading => "heading",
            Self::Speed => "speed",
        }
    }

    /// The unit of its setpoint.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Depth => "m",
            Self::Pitch | Self::Heading => "rad",
            Self::Speed => "m/s",
        }
    }
}

/// The setpoints of the four quantities.
#[derive(Clone, Debug, Default)]
pub(crate) struct Setpoints {
    /// Of depth, m.
    pub depth: Setpoint,
    /// Of pitch, rad.
    pub pitch: Setpoint,
    /// Of course, rad.
    pub heading: Setpoint,
    /// Of speed, m/s.
    pub speed: Setpoint,
}

impl Setpoints {
    /// The setpoint of a quantity.
    pub(crate) fn get_mut(&mut self, quantity: Quantity) -> &mut Setpoint {
        match quantity {
            Quantity::Depth => &mut self.depth,
            Quantity::Pitch => &mut self.pitch,
            Quantity::Heading => &mut self.heading,
            Quantity::Speed => &mut self.speed,
        }
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
        setpoint.command(1.0, 0);
        assert!(!setpoint.expire(2.0, 2_000_000_000));
        assert!(!setpoint.expire(0.0, i64::MAX), "0: never");
        assert!(setpoint.expire(2.0, 2_000_000_001));
        assert_eq!(setpoint.commanded(), None);
        setpoint.change(1.0);
        assert!(!setpoint.expire(2.0, i64::MAX));
        assert_eq!(setpoint.commanded(), Some(1.0));
    }
}
