//! The actuator's answers where no tick waits for them.
//!
//! A tick flies on the newest answer not yet flown that is at most `delay_budget` ticks old: over a slow link
//! the planes then move as they would by the tick's own answer, so much later. Where there is none they are held.

use std::collections::BTreeMap;

use planesman_msgs::planesman_msgs::msg::PlaneMotion;

/// Answers that have come and may still be flown.
#[derive(Clone, Debug)]
pub(crate) struct Answers {
    /// Sampling time, ns.
    tick: i64,
    /// The oldest answer that is flown, in ticks before the present one.
    budget: i64,
    /// By stamp, ns.
    waiting: BTreeMap<i64, PlaneMotion>,
    /// Stamp of the last one flown.
    flown: Option<i64>,
}

impl Answers {
    /// None yet, for ticks of `tick` ns.
    #[must_use]
    pub(crate) fn new(tick: i64, budget: i64) -> Self {
        Self {
            tick: tick.max(1),
            budget,
            waiting: BTreeMap::new(),
            flown: None,
        }
    }

    /// Takes another budget.
    pub(crate) fn set_budget(&mut self, budget: i64) {
        self.budget = budget;
    }

    /// The stamps go back: no answer has been flown.
    pub(crate) fn restart(&mut self) {
        self.waiting.clear();
        self.flown = None;
    }

    /// Takes an answer, while the tick at `now` (ns) is flown.
    pub(crate) fn take(&mut self, motion: PlaneMotion, now: i64) {
        let stamp = motion.header.stamp.nanos();
        if self.is_due(stamp, now) {
            self.waiting.insert(stamp, motion);
        }
    }

    fn is_due(&self, stamp: i64, now: i64) -> bool {
        let oldest = now.saturating_sub(self.tick.saturating_mul(self.budget));
        (oldest..=now).contains(&stamp) && self.flown.is_none_or(|flown| stamp > flown)
    }

    /// The answer that the tick at `now` (ns) is flown on, and its age in ticks.
    pub(crate) fn fly(&mut self, now: i64) -> Option<(PlaneMotion, i64)> {
        let waiting = std::mem::take(&mut self.waiting);
        let (stamp, motion) = waiting.into_iter().next_back()?;
        if !self.is_due(stamp, now) {
            return None;
        }
        self.flown = Some(stamp);
        Some((motion, (now - stamp) / self.tick))
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

    /// The tick and the age of what is flown at each tick, where `coming` come during it.
    fn flown(budget: i64, coming: &[&[i64]]) -> Vec<Option<(i64, i64)>> {
        let mut answers = Answers::new(TICK, budget);
        let tick = |(now, coming): (i64, &&[i64])| {
            coming
                .iter()
                .for_each(|k| answers.take(motion(*k), now * TICK));
            let (motion, age) = answers.fly(now * TICK)?;
            Some((motion.header.stamp.nanos() / TICK, age))
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
}
