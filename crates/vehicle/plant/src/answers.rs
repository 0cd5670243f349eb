//! The answers to a tick: the planes' motion over the tick, and the nodes that have finished it. Stamps are in ns.
//!
//! In lockstep a tick ends when the actuator and every member have answered with its stamp, in any order; answers may repeat. Without
//! lockstep no tick waits: it uses the newest unused answer that is at most `delay_budget` ticks old. Over a slow link the planes then
//! follow the correct motion with a delay. Without an answer the planes hold their angle.

use std::collections::{BTreeMap, BTreeSet};

use planesman_msgs::planesman_msgs::msg::{PlaneMotion, TickAnswer};

use crate::parameters::{PlantParameters, TimeSource};

/// Name of the actuator in [`Answers::missing`]; the actuator is not a member.
pub const THE_ACTUATOR: &str = "the actuator";

/// Received answers that are still usable, and a record of the answers used.
#[derive(Clone, Debug)]
pub struct Answers {
    /// Sampling time.
    tick: i64,
    /// Largest age of a usable motion, in ticks.
    budget: i64,
    lockstep: bool,
    /// Whether the vehicle has only thrusters, so no tick waits for an actuator.
    thrusters_alone: bool,
    /// Nodes that must answer in lockstep, besides the actuator.
    members: BTreeSet<String>,
    /// Topics whose messages must arrive in lockstep too.
    gates: BTreeSet<String>,
    /// Members and gates that have answered.
    answered: BTreeSet<String>,
    /// Answers of the actuator by stamp.
    motions: BTreeMap<i64, PlaneMotion>,
    /// Stamp of the last answer used.
    flown: Option<i64>,
    /// Age of the answer used in the last tick, in ticks.
    pub age: i64,
    /// Number of ticks without the actuator's answer.
    pub unanswered: u64,
    /// Number of consecutive ticks without the actuator's answer.
    pub silent: i64,
    /// Number of ticks that used an older answer.
    pub delayed: u64,
}

impl Answers {
    /// Returns an empty set, for ticks of `tick` ns.
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

    /// Sets `delay_budget`; lockstep does not use it.
    pub fn set_parameters(&mut self, parameters: &PlantParameters) {
        self.budget = if self.lockstep {
            0
        } else {
            parameters.delay_budget
        };
    }

    /// Adds topics that a tick waits for in lockstep.
    pub fn set_gates<'a>(&mut self, topics: impl Iterator<Item = &'a str>) {
        if self.lockstep {
            self.gates = topics.map(str::to_owned).collect();
        }
    }

    /// Removes the wait for an actuator, for a vehicle with only thrusters.
    pub fn need_no_actuator(&mut self) {
        self.thrusters_alone = true;
    }

    /// Begins a tick without answers; without lockstep, earlier motions stay usable.
    pub fn begin(&mut self) {
        self.answered.clear();
        if self.lockstep {
            self.motions.clear();
        }
    }

    /// Forgets the last answer used, since the stamps have gone back.
    pub fn restart(&mut self) {
        self.motions.clear();
        self.flown = None;
    }

    /// Adds the actuator's answer during the tick at `now`.
    pub fn on_motion(&mut self, motion: PlaneMotion, now: i64) {
        let stamp = motion.header.stamp.nanos();
        if self.is_due(stamp, now) {
            self.motions.insert(stamp, motion);
        }
    }

    /// Adds a member's answer during the tick at `now`.
    pub fn on_answer(&mut self, answer: &TickAnswer, now: i64) {
        if answer.header.stamp.nanos() == now && self.members.contains(&answer.member) {
            self.answered.insert(answer.member.clone());
        }
    }

    /// Adds a gate's message that answers the present tick.
    pub fn on_gate(&mut self, topic: &str) {
        if self.gates.contains(topic) {
            self.answered.insert(topic.to_owned());
        }
    }

    /// Names of the nodes and topics without an answer for the tick at `now`.
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

    /// Motion for the tick at `now`; its age is in [`Self::age`].
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
