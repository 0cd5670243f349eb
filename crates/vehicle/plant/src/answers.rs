//! The answers to a tick: how the planes move over it, and who is done with it. Stamps are in ns.
//!
//! In lockstep a tick is over when the actuator and every member have answered for its stamp; they may come in any order, and more than
//! once. Elsewhere no tick waits: it is flown on the newest answer not yet flown that is at most `delay_budget` ticks old. Over a slow link
//! the planes then move as they would by the tick's own answer, so much later. Without an answer they are held.

use std::collections::{BTreeMap, BTreeSet};

use planesman_msgs::planesman_msgs::msg::{PlaneMotion, TickAnswer};

use crate::parameters::{PlantParameters, TimeSource};

/// What [`Answers::missing`] calls the actuator, which is no member.
pub const THE_ACTUATOR: &str = "the actuator";

/// Answers that have come and may still be flown, and what the ticks were flown on.
#[derive(Clone, Debug)]
pub struct Answers {
    /// Sampling time.
    tick: i64,
    /// The oldest motion that is flown, in ticks before the present one.
    budget: i64,
    lockstep: bool,
    /// Whether there is no actuator to wait for.
    thrusters_alone: bool,
    /// Who answers in lockstep besides the actuator.
    members: BTreeSet<String>,
    /// Topics whose messages answer in lockstep too.
    gates: BTreeSet<String>,
    /// The members and gates that have answered.
    answered: BTreeSet<String>,
    /// The actuator's answers by stamp.
    motions: BTreeMap<i64, PlaneMotion>,
    /// Stamp of the last one flown.
    flown: Option<i64>,
    /// The age of the answer used in the last tick, in ticks.
    pub age: i64,
    /// Ticks without the actuator's answer.
    pub unanswered: u64,
    /// Such ticks in a row.
    pub silent: i64,
    /// Ticks flown on an older answer.
    pub delayed: u64,
}

impl Answers {
    /// None yet, for ticks of `tick` ns.
    #[must_use]
    pub fn new(parameters: &PlantParameters, tick: i64) -> Self {
        let mut answers = Self {
            tick: tick.max(1),
            budget: 0,
            lockstep: parameters.time == TimeSource::Lockstep,
            thrusters_alone: false,
            members: parameters.lockstep.members.iter().cloned().collect(),
            gates: BTreeSet::new(),
            answered: BTreeSet::new(),
            motions: BTreeMap::new(),
            flown: None,
            age: 0,
            unanswered: 0,
            silent: 0,
            delayed: 0,
        };
        answers.set_parameters(parameters);
        answers
    }

    /// Takes another `delay_budget`; lockstep has none.
    pub fn set_parameters(&mut self, parameters: &PlantParameters) {
        self.budget = if self.lockstep {
            0
        } else {
            parameters.delay_budget
        };
    }

    /// Waits in lockstep for messages of these topics too.
    pub fn set_gates<'a>(&mut self, topics: impl Iterator<Item = &'a str>) {
        if self.lockstep {
            self.gates = topics.map(str::to_owned).collect();
        }
    }

    /// Waits for no actuator: thrusters alone move the vehicle.
    pub fn need_no_actuator(&mut self) {
        self.thrusters_alone = true;
    }

    /// A tick begins: nobody has answered; where no tick waits, earlier motions may still be flown.
    pub fn begin(&mut self) {
        self.answered.clear();
        if self.lockstep {
            self.motions.clear();
        }
    }

    /// The stamps go back: no answer has been flown.
    pub fn restart(&mut self) {
        self.motions.clear();
        self.flown = None;
    }

    /// Takes the actuator's answer, during the tick at `now`.
    pub fn on_motion(&mut self, motion: PlaneMotion, now: i64) {
        let stamp = motion.header.stamp.nanos();
        if self.is_due(stamp, now) {
            self.motions.insert(stamp, motion);
        }
    }

    /// Takes a member's answer, during the tick at `now`.
    pub fn on_answer(&mut self, answer: &TickAnswer, now: i64) {
        if answer.header.stamp.nanos() == now && self.members.contains(&answer.member) {
            self.answered.insert(answer.member.clone());
        }
    }

    /// Takes the message of a gate that answers the present tick.
    pub fn on_gate(&mut self, topic: &str) {
        if self.gates.contains(topic) {
            self.answered.insert(topic.to_owned());
        }
    }

    /// Who has not answered for the tick at `now`.
    #[must_use]
    pub fn missing(&self, now: i64) -> Vec<&str> {
        let has_answered = self.thrusters_alone || self.motions.contains_key(&now);
        let actuator = (!has_answered).then_some(THE_ACTUATOR);
        let others = self.members.iter().chain(&self.gates);
        let silent = others.filter(|it| !self.answered.contains(*it));
        actuator
            .into_iter()
            .chain(silent.map(String::as_str))
            .collect()
    }

    fn is_due(&self, stamp: i64, now: i64) -> bool {
        let oldest = now.saturating_sub(self.tick.saturating_mul(self.budget));
        (oldest..=now).contains(&stamp) && self.flown.is_none_or(|flown| stamp > flown)
    }

    /// The motion that the tick at `now` is flown on, its age in [`Self::age`].
    pub fn fly(&mut self, now: i64) -> Option<PlaneMotion> {
        let newest = std::mem::take(&mut self.motions).pop_last();
        let newest = newest.filter(|(stamp, _)| self.is_due(*stamp, now));
        self.flown = newest.as_ref().map(|(stamp, _)| *stamp).or(self.flown);
        self.age = newest
            .as_ref()
            .map_or(0, |(stamp, _)| (now - stamp) / self.tick);
        self.delayed += u64::from(self.age > 0);
        let is_missing = newest.is_none() && !self.thrusters_alone;
        self.unanswered += u64::from(is_missing);
        self.silent = if is_missing { self.silent + 1 } else { 0 };
        newest.map(|(_, motion)| motion)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_msgs::builtin_interfaces::msg::Time;

    const TICK: i64 = 50_000_000;

    fn motion(k: i64) -> PlaneMotion {
        let mut motion = PlaneMotion::default();
        motion.header.stamp = Time::from_nanos(k * TICK);
        motion
    }

    fn answer(k: i64, member: &str) -> TickAnswer {
        let mut answer = TickAnswer {
            member: member.to_owned(),
            ..TickAnswer::default()
        };
        answer.header.stamp = Time::from_nanos(k * TICK);
        answer
    }

    fn lockstep(members: &[&str]) -> Answers {
        let mut parameters = PlantParameters {
            time: TimeSource::Lockstep,
            delay_budget: 3,
            ..PlantParameters::default()
        };
        parameters.lockstep.members = members.iter().map(|it| (*it).to_owned()).collect();
        Answers::new(&parameters, TICK)
    }

    /// The tick and the age of what is flown at each tick, where `coming` come during it.
    fn flown(budget: i64, coming: &[&[i64]]) -> Vec<Option<(i64, i64)>> {
        let parameters = PlantParameters {
            delay_budget: budget,
            ..PlantParameters::default()
        };
        let mut answers = Answers::new(&parameters, TICK);
        let tick = |(now, coming): (i64, &&[i64])| {
            coming
                .iter()
                .for_each(|k| answers.on_motion(motion(*k), now * TICK));
            let motion = answers.fly(now * TICK)?;
            Some((motion.header.stamp.nanos() / TICK, answers.age))
        };
        (0..).zip(coming).map(tick).collect()
    }

    #[test]
    fn without_a_budget_only_the_ticks_own_answer_is_flown() {
        assert_eq!(
            flown(0, &[&[0], &[0], &[1], &[4], &[4]]),
            [Some((0, 0)), None, None, None, Some((4, 0))]
        );
    }

    #[test]
    fn answers_that_come_two_ticks_late_are_flown_in_their_order() {
        let late: &[&[i64]] = &[&[], &[], &[0], &[1], &[2], &[3]];
        let ages = [
            None,
            None,
            Some((0, 2)),
            Some((1, 2)),
            Some((2, 2)),
            Some((3, 2)),
        ];
        assert_eq!(flown(2, late), ages);
        assert_eq!(flown(1, late), [None; 6]);
    }

    #[test]
    fn of_several_the_newest_is_flown_none_twice_and_none_after_a_later_one() {
        assert_eq!(
            flown(3, &[&[], &[], &[1, 0], &[], &[1, 2], &[3, 5, 4], &[4]]),
            [
                None,
                None,
                Some((1, 1)),
                None,
                Some((2, 2)),
                Some((5, 0)),
                None
            ]
        );
    }

    #[test]
    fn a_tick_of_lockstep_is_over_when_actuator_and_members_have_answered_for_its_stamp() {
        let mut answers = lockstep(&["sysid"]);
        assert_eq!(answers.missing(TICK), ["the actuator", "sysid"]);
        answers.on_answer(&answer(0, "sysid"), TICK);
        answers.on_answer(&answer(1, "stranger"), TICK);
        answers.on_motion(motion(0), TICK);
        assert_eq!(answers.missing(TICK), ["the actuator", "sysid"]);
        answers.on_answer(&answer(1, "sysid"), TICK);
        answers.on_answer(&answer(1, "sysid"), TICK);
        assert_eq!(answers.missing(TICK), ["the actuator"]);
        answers.on_motion(motion(1), TICK);
        assert!(answers.missing(TICK).is_empty());
        assert_eq!(answers.fly(TICK), Some(motion(1)));
    }

    #[test]
    fn a_tick_waits_for_its_gates_too() {
        let mut answers = lockstep(&["sysid"]);
        answers.set_gates(["/auv/filtered"].into_iter());
        answers.on_motion(motion(0), 0);
        answers.on_answer(&answer(0, "/auv/filtered"), 0);
        answers.on_answer(&answer(0, "sysid"), 0);
        assert_eq!(answers.missing(0), ["/auv/filtered"], "a topic, no member");
        answers.on_gate("/auv/other");
        answers.on_gate("/auv/filtered");
        assert!(answers.missing(0).is_empty());
        answers.begin();
        answers.on_motion(motion(1), TICK);
        assert_eq!(answers.missing(TICK), ["sysid", "/auv/filtered"]);
    }

    #[test]
    fn the_next_tick_of_lockstep_begins_with_no_answers() {
        let mut answers = lockstep(&["sysid"]);
        answers.on_motion(motion(0), 0);
        answers.on_answer(&answer(0, "sysid"), 0);
        assert!(answers.missing(0).is_empty());
        assert_eq!(answers.fly(0), Some(motion(0)));
        answers.on_motion(motion(1), TICK);
        answers.begin();
        assert_eq!(answers.missing(TICK), ["the actuator", "sysid"]);
        assert_eq!((answers.unanswered, answers.delayed), (0, 0));
    }

    #[test]
    fn ticks_without_an_answer_are_counted_until_one_comes() {
        let mut answers = Answers::new(&PlantParameters::default(), TICK);
        assert_eq!((answers.fly(0), answers.fly(TICK)), (None, None));
        assert_eq!((answers.unanswered, answers.silent), (2, 2));
        answers.on_motion(motion(2), 2 * TICK);
        assert!(answers.fly(2 * TICK).is_some());
        assert_eq!((answers.unanswered, answers.silent), (2, 0));
    }
}
