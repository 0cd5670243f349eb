//! The kept samples of one channel.

use std::collections::VecDeque;

/// Number of samples kept per channel: almost three hours at 20 Hz.
pub(crate) const SAMPLES_PER_CHANNEL: usize = 200_000;

/// A reader that falls behind by more samples continues with the newest samples: otherwise a slow connection would show an ever older past.
const MAX_LAG: u64 = 20_000;

/// If time goes back by less than this, s, a message is out of order. If it goes back by more, the vehicle has restarted.
const RESTART: f64 = 1.0;

/// Values over time, s.
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    samples: VecDeque<(f64, f64)>,
    /// Time of the vehicle's last reset; samples stamped before it belong to the previous run.
    reset: Option<f64>,
    /// Number of times that time went back.
    restarts: u64,
    /// Number of samples of this run dropped because of the limit.
    dropped: u64,
}

/// Position of a reader.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Cursor {
    restarts: u64,
    next: u64,
    /// Whether the reader has caught up with the last sample.
    level: bool,
}

/// Samples that a reader has not read yet.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct News {
    /// Whether time has gone back, so that earlier samples belong to a previous run.
    pub(crate) restarted: bool,
    pub(crate) times: Vec<f64>,
    pub(crate) values: Vec<f64>,
}

impl Series {
    /// Adds a sample and keeps the latest `kept`; ignores a late sample, or a second sample at the same time.
    pub(crate) fn push(&mut self, time: f64, value: f64, kept: usize) {
        if !(time.is_finite() && value.is_finite()) {
            return;
        }
        let last = self.samples.back().map(|it| it.0);
        if last.is_some_and(|last| time <= last) || self.reset.is_some_and(|at| time < at) {
            let newest = last.or(self.reset).unwrap_or(time);
            if newest - time < RESTART {
                return;
            }
            self.begin_anew(None);
        }
        self.keep(kept.saturating_sub(1));
        self.samples.push_back((time, value));
    }

    /// Drops the oldest samples beyond the latest `kept`; frees memory once more than half of it is unused.
    pub(crate) fn keep(&mut self, kept: usize) {
        let excess = self.samples.len().saturating_sub(kept);
        self.samples.drain(..excess);
        self.dropped += excess as u64;
        if self.samples.capacity() / 2 > kept {
            self.samples.shrink_to(kept + 1);
        }
    }

    /// Drops all samples because the vehicle restarts. `reset`: the time of the reset, s, if time continues.
    pub(crate) fn begin_anew(&mut self, reset: Option<f64>) {
        self.samples.clear();
        self.reset = reset;
        self.restarts += 1;
        self.dropped = 0;
    }

    /// Whether there is no sample.
    pub(crate) fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    /// At most `most` samples after the cursor, which moves forward.
    pub(crate) fn since(&self, cursor: &mut Cursor, most: usize) -> News {
        let restarted = cursor.restarts != self.restarts;
        if restarted {
            *cursor = Cursor {
                restarts: self.restarts,
                ..Cursor::default()
            };
        }
        let end = self.dropped + self.samples.len() as u64;
        if cursor.level && end.saturating_sub(cursor.next) > MAX_LAG {
            cursor.next = end.saturating_sub(most as u64);
        }
        let skipped = usize::try_from(cursor.next.saturating_sub(self.dropped)).unwrap_or(0);
        let taken = self.samples.iter().skip(skipped).take(most);
        let (times, values): (Vec<f64>, Vec<f64>) = taken.copied().unzip();
        cursor.next = cursor.next.max(self.dropped) + times.len() as u64;
        cursor.level |= cursor.next >= end;
        News {
            restarted,
            times,
            values,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_gets_each_sample_once_and_is_told_of_a_restart() {
        let mut series = Series::default();
        let mut cursor = Cursor::default();
        for k in 0..5 {
            series.push(f64::from(k), 10.0, SAMPLES_PER_CHANNEL);
        }
        series.push(4.0, 11.0, SAMPLES_PER_CHANNEL); // sent again
        series.push(3.5, 11.0, SAMPLES_PER_CHANNEL); // late
        series.push(f64::NAN, 1.0, SAMPLES_PER_CHANNEL);
        series.push(5.0, f64::INFINITY, SAMPLES_PER_CHANNEL);
        assert_eq!(series.since(&mut cursor, 3).times, [0.0, 1.0, 2.0]);
        assert_eq!(series.since(&mut cursor, 3).times, [3.0, 4.0]);
        assert_eq!(series.since(&mut cursor, 3), News::default());
        series.push(0.5, 1.0, SAMPLES_PER_CHANNEL);
        let new = series.since(&mut cursor, 3);
        assert!(new.restarted);
        assert_eq!(new.times, [0.5]);
        assert!(!series.since(&mut cursor, 3).restarted);
    }

    #[test]
    fn a_reset_at_a_time_that_goes_on_leaves_nothing_of_the_run_before() {
        let mut series = Series::default();
        let mut cursor = Cursor::default();
        series.push(10.0, 1.0, SAMPLES_PER_CHANNEL);
        series.since(&mut cursor, 9);
        series.begin_anew(Some(10.1));
        series.push(10.05, 1.0, SAMPLES_PER_CHANNEL); // late, of the run before
        assert_eq!(series.since(&mut cursor, 9).times, [0.0; 0]);
        series.push(10.1, 0.0, SAMPLES_PER_CHANNEL);
        series.push(10.2, 0.0, SAMPLES_PER_CHANNEL);
        assert_eq!(series.since(&mut cursor, 9).times, [10.1, 10.2]);
        series.push(0.0, 0.0, SAMPLES_PER_CHANNEL); // a simulation started again
        assert_eq!(series.since(&mut cursor, 9).times, [0.0]);
        series.push(0.1, 0.0, SAMPLES_PER_CHANNEL);
        assert_eq!(series.since(&mut cursor, 9).times, [0.1]);
    }

    #[test]
    fn of_too_many_samples_the_latest_are_kept() {
        let mut series = Series::default();
        let mut cursor = Cursor::default();
        for k in 0..SAMPLES_PER_CHANNEL + 10 {
            series.push(k as f64, 0.0, SAMPLES_PER_CHANNEL);
        }
        let new = series.since(&mut cursor, SAMPLES_PER_CHANNEL + 10);
        assert_eq!((new.times.len(), new.times[0]), (SAMPLES_PER_CHANNEL, 10.0));
        series.push(1e9, 0.0, SAMPLES_PER_CHANNEL);
        assert_eq!(series.since(&mut cursor, 10).times, [1e9]);
    }

    #[test]
    fn a_reader_gets_what_was_before_it_came_and_the_newest_once_it_is_too_slow() {
        let mut series = Series::default();
        let mut cursor = Cursor::default();
        let lag = usize::try_from(MAX_LAG).expect("a length");
        for k in 0..2 * lag {
            series.push(k as f64, 0.0, SAMPLES_PER_CHANNEL);
        }
        let mut next = 0.0;
        while let [first, .., last] = series.since(&mut cursor, 1000).times[..] {
            assert_eq!(first, next);
            next = last + 1.0;
        }
        assert_eq!(next, 2.0 * MAX_LAG as f64);
        for k in 2 * lag..3 * lag + 1 {
            series.push(k as f64, 0.0, SAMPLES_PER_CHANNEL);
        }
        let new = series.since(&mut cursor, 10).times;
        assert_eq!((new.len(), new[9]), (10, 3.0 * MAX_LAG as f64));
    }
}
