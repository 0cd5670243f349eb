//! The controller's reaction when the vehicle leaves its envelope: a fault that is latched until it is reset. The reaction does not use the
//! loops' gains, since these may be the cause.
//!
//! | fault | when | reaction |
//! |---|---|---|
//! | floor | deeper than the hard floor | planes climb, until `margin` above the floor or `climb_time` is over; then neutral |
//! | bow down | pitched further down than the limit | planes climb, until the bow is level or `climb_time` is over; then neutral |
//! | bow up | pitched further up than the limit | neutral |
//! | ceiling | shallower than the hard ceiling | neutral |
//! | silence | no state within `state_timeout`, if that is latched | neutral |
//!
//! Rudder, roll planes and thrust are neutral in every reaction. The first fault is reported, with one exception: the floor replaces any
//! other, because it still needs the climb. A reset is accepted once the cause of the fault is over.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::error::Error;
use crate::fault::Fault;
use crate::feedback::Feedback;

/// The envelope and the way back into it: the parameters `safety.*`.
#[derive(Clone, Copy, Debug, PartialEq, planesman_parameters::Parameters)]
pub struct Envelope {
    /// Least depth, positive down; above it is a fault: everything neutral until reset. At most depth.min.
    #[parameter(default = -1e4, unit = "m", positive = "down", range = -1e4..=1e4)]
    pub ceiling: f64,
    /// Largest depth, positive down; below it is a fault: planes to climb, then neutral, until reset. At least
    /// depth.max.
    #[parameter(default = 1e4, unit = "m", positive = "down", range = -1e4..=1e4)]
    pub floor: f64,
    /// Height above the floor at which the climb ends.
    #[parameter(default = 0.3, unit = "m", range = 0.0..=1e4)]
    pub margin: f64,
    /// Largest pitch to either side; beyond it is a fault until reset. Bow down: planes to climb until the vehicle is level, then neutral; bow up:
    /// planes neutral. At least depth.pitch_limit.
    #[parameter(default = PI, unit = "rad", range = 0.0..=PI)]
    pub pitch: f64,
    /// Plane angle of the climb, open loop; within planes.limit.
    #[parameter(default = 10.0_f64.to_radians(), unit = "rad", range = 0.0..=FRAC_PI_2)]
    pub climb_planes: f64,
    /// Longest duration of the climb; then neutral.
    #[parameter(default = 20.0, unit = "s", range = 0.0..=3600.0)]
    pub climb_time: f64,
    /// Whether a state missing for longer than state_timeout is a fault, latched until reset; otherwise control
    /// resumes with the next state.
    #[parameter(default = false)]
    pub latch_silence: bool,
}

impl Envelope {
    /// The bound of the envelope that the vehicle has exceeded.
    #[must_use]
    pub(crate) fn violated(&self, feedback: &Feedback) -> Option<Fault> {
        if feedback.depth > self.floor {
            Some(Fault::Floor)
        } else if feedback.pitch < -self.pitch {
            Some(Fault::BowDown)
        } else if feedback.pitch > self.pitch {
            Some(Fault::BowUp)
        } else if feedback.depth < self.ceiling {
            Some(Fault::Ceiling)
        } else {
            None
        }
    }
}

/// The fault, if there is one, and the duration of the climb so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Safety {
    fault: Option<Fault>,
    /// s
    climbed: f64,
    /// Whether the climb is over.
    climb_over: bool,
}

/// The reaction of the planes to a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reaction {
    /// Rise.
    Climb,
    /// Nothing.
    Neutral,
}

impl Safety {
    /// The latched fault.
    #[must_use]
    pub(crate) fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Latches a fault; returns whether it becomes the reported one.
    pub(crate) fn latch(&mut self, fault: Fault) -> bool {
        let stands = match self.fault {
            None => true,
            Some(standing) => fault == Fault::Floor && standing != Fault::Floor,
        };
        if stands {
            *self = Self {
                fault: Some(fault),
                ..Self::default()
            };
        }
        stands
    }

    /// Checks the vehicle's position `dt` seconds after the last check, and returns the reaction to the latched fault; `None` without a
    /// fault.
    pub(crate) fn react(
        &mut self,
        envelope: &Envelope,
        feedback: &Feedback,
        dt: f64,
    ) -> Option<Reaction> {
        let fault = self.fault?;
        let done = match fault {
            Fault::Floor => feedback.depth <= envelope.floor - envelope.margin,
            Fault::BowDown => feedback.pitch >= 0.0,
            Fault::BowUp | Fault::Ceiling | Fault::Silence => true,
        };
        self.climb_over |= done || self.climbed >= envelope.climb_time;
        self.climbed += dt;
        Some(match self.climb_over {
            true => Reaction::Neutral,
            false => Reaction::Climb,
        })
    }

    /// Resets the fault, unless the vehicle is still outside its envelope.
    ///
    /// # Errors
    /// [`Error::NoFault`], [`Error::StillFaulty`].
    pub(crate) fn reset(
        &mut self,
        envelope: &Envelope,
        now: Option<&Feedback>,
    ) -> Result<Fault, Error> {
        let fault = self.fault.ok_or(Error::NoFault)?;
        if let Some(still) = now.and_then(|feedback| envelope.violated(feedback)) {
            return Err(Error::StillFaulty(still));
        }
        *self = Self::default();
        Ok(fault)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENVELOPE: Envelope = Envelope {
        ceiling: 0.2,
        floor: 3.0,
        margin: 0.5,
        pitch: 1.0,
        climb_planes: 0.2,
        climb_time: 10.0,
        latch_silence: false,
    };

    fn at(depth: f64, pitch: f64) -> Feedback {
        Feedback {
            depth,
            pitch,
            ..Feedback::default()
        }
    }

    #[test]
    fn each_side_of_the_envelope_has_its_fault() {
        for (feedback, fault) in [
            (at(1.0, 0.0), None),
            (at(3.0, 1.0), None),
            (at(3.01, 0.0), Some(Fault::Floor)),
            (at(0.19, 0.0), Some(Fault::Ceiling)),
            (at(1.0, -1.01), Some(Fault::BowDown)),
            (at(1.0, 1.01), Some(Fault::BowUp)),
            (at(3.01, 1.01), Some(Fault::Floor)),
        ] {
            assert_eq!(ENVELOPE.violated(&feedback), fault);
        }
    }

    #[test]
    fn a_vehicle_too_deep_climbs_until_it_is_clear_of_the_floor_and_not_again() {
        let mut safety = Safety::default();
        assert_eq!(safety.react(&ENVELOPE, &at(3.1, 0.0), 0.1), None);
        assert!(safety.latch(Fault::Floor));
        for (depth, reaction) in [
            (3.1, Reaction::Climb),
            (2.6, Reaction::Climb),
            (2.5, Reaction::Neutral),
            (2.9, Reaction::Neutral),
        ] {
            assert_eq!(
                safety.react(&ENVELOPE, &at(depth, 0.0), 0.1),
                Some(reaction)
            );
        }
    }

    #[test]
    fn a_climb_that_leads_nowhere_ends() {
        let mut safety = Safety::default();
        safety.latch(Fault::BowDown);
        let climbing = (0..)
            .take_while(|_| safety.react(&ENVELOPE, &at(2.0, -1.2), 0.5) == Some(Reaction::Climb));
        assert_eq!(climbing.count(), 20);
    }

    #[test]
    fn the_first_fault_stands_unless_the_vehicle_sinks_below_the_floor() {
        let mut safety = Safety::default();
        assert!(safety.latch(Fault::BowUp));
        assert!(!safety.latch(Fault::Ceiling));
        assert_eq!(safety.fault(), Some(Fault::BowUp));
        assert!(safety.latch(Fault::Floor));
        assert!(!safety.latch(Fault::Floor));
        assert!(!safety.latch(Fault::BowUp));
        assert_eq!(safety.fault(), Some(Fault::Floor));
    }

    #[test]
    fn only_a_reset_from_within_the_envelope_takes_the_fault_back() {
        let mut safety = Safety::default();
        assert_eq!(safety.reset(&ENVELOPE, None), Err(Error::NoFault));
        safety.latch(Fault::Floor);
        safety.react(&ENVELOPE, &at(1.0, 0.0), 0.1);
        assert_eq!(safety.fault(), Some(Fault::Floor));
        let refusal = safety.reset(&ENVELOPE, Some(&at(3.2, 0.0))).unwrap_err();
        assert_eq!(refusal, Error::StillFaulty(Fault::Floor));
        assert_eq!(
            safety.reset(&ENVELOPE, Some(&at(1.0, 0.0))),
            Ok(Fault::Floor)
        );
        assert_eq!(safety.fault(), None);
    }
}
