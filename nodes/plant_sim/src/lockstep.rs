//! Lockstep: the answers that the present tick waits for.
//!
//! A tick is complete when the actuator has said how the planes move over it and every
//! member named has said that it is done with its stamp. Answers may come in any order, and
//! more than once; answers for another stamp change nothing.

use std::collections::BTreeSet;

use planesman_msgs::builtin_interfaces::msg::Time;
use planesman_msgs::planesman_msgs::msg::{PlaneMotion, TickAnswer};

/// The answers to one tick.
#[derive(Clone, Debug)]
pub(crate) struct Lockstep {
    members: BTreeSet<String>,
    stamp: Time,
    answered: BTreeSet<String>,
    motion: Option<PlaneMotion>,
}

impl Lockstep {
    /// Waits for `members` beside the actuator, from the tick at `stamp` on.
    pub(crate) fn new(members: impl IntoIterator<Item = String>, stamp: Time) -> Self {
        Self {
            members: members.into_iter().collect(),
            stamp,
            answered: BTreeSet::new(),
            motion: None,
        }
    }

    /// Goes on to the tick at `stamp`: nobody has answered yet.
    pub(crate) fn begin(&mut self, stamp: Time) {
        self.stamp = stamp;
        self.answered.clear();
        self.motion = None;
    }

    /// The actuator's answer.
    pub(crate) fn on_motion(&mut self, motion: PlaneMotion) {
        if motion.header.stamp == self.stamp {
            self.motion = Some(motion);
        }
    }

    /// A member's answer.
    pub(crate) fn on_answer(&mut self, answer: &TickAnswer) {
        if answer.header.stamp == self.stamp && self.members.contains(&answer.member) {
            self.answered.insert(answer.member.clone());
        }
    }

    /// The plane motion of the tick once everybody has answered.
    pub(crate) fn complete(&self) -> Option<&PlaneMotion> {
        self.motion
            .as_ref()
            .filter(|_| self.answered.len() == self.members.len())
    }

    /// The members whose answers are missing.
    pub(crate) fn waiting_for(&self) -> Vec<&str> {
        let actuator = self.motion.is_none().then_some("the actuator");
        actuator
            .into_iter()
            .chain(
                self.members
                    .iter()
                    .filter(|m| !self.answered.contains(*m))
                    .map(String::as_str),
            )
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(nanos: i64) -> PlaneMotion {
        let mut motion = PlaneMotion::default();
        motion.header.stamp = Time::from_nanos(nanos);
        motion
    }

    fn answer(nanos: i64, member: &str) -> TickAnswer {
        let mut answer = TickAnswer {
            member: member.to_owned(),
            ..TickAnswer::default()
        };
        answer.header.stamp = Time::from_nanos(nanos);
        answer
    }

    #[test]
    fn a_tick_is_complete_when_actuator_and_members_have_answered_for_its_stamp() {
        let mut lockstep = Lockstep::new(["sysid".to_owned()], Time::from_nanos(50));
        assert_eq!(lockstep.waiting_for(), ["the actuator", "sysid"]);
        lockstep.on_answer(&answer(0, "sysid"));
        lockstep.on_answer(&answer(50, "stranger"));
        lockstep.on_motion(motion(0));
        assert!(lockstep.complete().is_none());
        lockstep.on_answer(&answer(50, "sysid"));
        lockstep.on_answer(&answer(50, "sysid"));
        assert!(lockstep.complete().is_none());
        lockstep.on_motion(motion(50));
        assert_eq!(lockstep.complete(), Some(&motion(50)));
    }

    #[test]
    fn the_next_tick_begins_with_no_answers() {
        let mut lockstep = Lockstep::new([], Time::from_nanos(0));
        lockstep.on_motion(motion(0));
        lockstep.begin(Time::from_nanos(50));
        assert!(lockstep.complete().is_none());
    }
}
