//! Sorts one topic's messages by stamp, with one message of look-ahead.
//!
//! A loop that was held up repeats a tick, a foreign message may have any stamp, and a vehicle that was reset begins at zero again. One
//! message of look-ahead distinguishes these cases without storing the flight.

/// Messages of one topic, to be sorted by stamp.
#[derive(Clone, Debug)]
pub struct InOrder<M> {
    /// Stamps of the first and the last message returned since time last went back, ns.
    first: Option<i64>,
    last: Option<i64>,
    /// The message that waits for the next one.
    waiting: Option<(i64, M)>,
    /// Messages out of plain order.
    pub statistics: ReorderStatistics,
}

/// Messages out of plain order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReorderStatistics {
    /// Number of messages that repeat a stamp; they count once.
    pub repeated: u64,
    /// Number of single messages whose stamps do not fit their neighbours; they are skipped.
    pub out_of_line: u64,
    /// Number of restarts of the time.
    pub restarts: u64,
}

/// A message whose order is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next<M> {
    /// The message follows the last one.
    On(i64, M),
    /// Time has gone back: a new flight begins with this message.
    Restarted(i64, M),
}

impl<M> Default for InOrder<M> {
    fn default() -> Self {
        Self {
            first: None,
            last: None,
            waiting: None,
            statistics: ReorderStatistics::default(),
        }
    }
}

impl<M> InOrder<M> {
    /// Adds the message with the stamp `stamp` (ns), in the order of the bag; returns the previous message if its order is now known.
    pub fn take(&mut self, stamp: i64, message: M) -> Option<Next<M>> {
        let Some((waiting, _)) = self.waiting else {
            self.waiting = Some((stamp, message));
            return None;
        };
        if stamp == waiting || Some(stamp) == self.last {
            self.statistics.repeated += 1;
            return None;
        }
        let follows_waiting = stamp > waiting;
        let follows_last = self.last.is_none_or(|last| stamp > last);
        let waiting_follows_last = self.last.is_none_or(|last| waiting > last);
        let (waiting, before) = self.waiting.replace((stamp, message))?;
        match (waiting_follows_last, follows_waiting) {
            (true, true) => self.hand_on(waiting, before),
            // Back behind one that came too early; or behind both, which the next shows.
            (true, false) if follows_last => self.leave_out(),
            (true, false) => self.hand_on(waiting, before),
            // The one before went back: alone, or for good.
            (false, true) if follows_last => self.leave_out(),
            (false, true) if self.is_nearer_to_the_first(waiting) => {
                self.statistics.restarts += 1;
                (self.first, self.last) = (Some(waiting), Some(waiting));
                Some(Next::Restarted(waiting, before))
            }
            // A sender that has been behind catches up.
            (false, true) => self.leave_out(),
            (false, false) => self.leave_out(),
        }
    }

    /// Whether any message was added.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.last.is_some() || self.waiting.is_some()
    }

    /// Returns the message that still waits.
    pub fn finish(&mut self) -> Option<Next<M>> {
        let (waiting, message) = self.waiting.take()?;
        if self.last.is_none_or(|last| waiting > last) {
            self.hand_on(waiting, message)
        } else {
            self.leave_out()
        }
    }

    /// Whether an earlier stamp looks like a restart.
    fn is_nearer_to_the_first(&self, stamp: i64) -> bool {
        self.first
            .zip(self.last)
            .is_some_and(|(first, last)| stamp.saturating_sub(first) < last.saturating_sub(stamp))
    }

    fn hand_on(&mut self, stamp: i64, message: M) -> Option<Next<M>> {
        self.first.get_or_insert(stamp);
        self.last = Some(stamp);
        Some(Next::On(stamp, message))
    }

    fn leave_out(&mut self) -> Option<Next<M>> {
        self.statistics.out_of_line += 1;
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stamps handed on, a restart as a list of its own; and what was met.
    fn ordered(stamps: &[i64]) -> (Vec<Vec<i64>>, ReorderStatistics) {
        let mut order = InOrder::default();
        let mut runs = vec![Vec::new()];
        let mut next: Vec<_> = stamps.iter().map(|s| order.take(*s, ())).collect();
        next.push(order.finish());
        for next in next.into_iter().flatten() {
            match next {
                Next::On(stamp, ()) => runs.last_mut().expect("a run").push(stamp),
                Next::Restarted(stamp, ()) => runs.push(vec![stamp]),
            }
        }
        (runs, order.statistics)
    }

    fn statistics(repeated: u64, out_of_line: u64, restarts: u64) -> ReorderStatistics {
        ReorderStatistics {
            repeated,
            out_of_line,
            restarts,
        }
    }

    #[test]
    fn a_tick_said_again_counts_once() {
        let (runs, counted) = ordered(&[0, 1, 1, 2, 2, 2, 3, 3]);
        assert_eq!(
            (runs, counted),
            (vec![vec![0, 1, 2, 3]], statistics(4, 0, 0))
        );
    }

    #[test]
    fn a_single_message_from_another_time_is_left_out() {
        let stamps = [0, 1, 900, 2, 3, -900, 4, 5, 900];
        let (runs, counted) = ordered(&stamps);
        assert_eq!(runs, [vec![0, 1, 2, 3, 4, 5, 900]]);
        assert_eq!(counted, statistics(0, 2, 0));
        // The first and the last one have a neighbour on one side only.
        assert_eq!(ordered(&[900, 0, 1, 2]).0, [vec![0, 1, 2]]);
        assert_eq!(ordered(&[0, 1, 2, -900]).0, [vec![0, 1, 2]]);
    }

    #[test]
    fn a_stranger_who_speaks_in_turn_with_the_vehicle_is_not_heard() {
        let (runs, counted) = ordered(&[0, 1, 900, 2, 901, 3, 902, 4, 903, 5]);
        assert_eq!(
            (runs, counted),
            (vec![vec![0, 1, 2, 3, 4, 5]], statistics(0, 4, 0))
        );
    }

    #[test]
    fn a_sender_that_catches_up_begins_no_new_flight() {
        let (runs, counted) = ordered(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 6, 7, 8, 9, 10, 11]);
        assert_eq!(runs, [(0..=11).collect::<Vec<_>>()]);
        assert_eq!(counted, statistics(1, 3, 0));
    }

    #[test]
    fn a_vehicle_that_begins_again_begins_a_new_flight() {
        let (runs, counted) = ordered(&[0, 1, 2, 3, 0, 1, 2, 0, 1]);
        let expected = vec![vec![0, 1, 2, 3], vec![0, 1, 2], vec![0, 1]];
        assert_eq!((runs, counted), (expected, statistics(0, 0, 2)));
    }
}
