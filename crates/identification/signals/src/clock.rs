//! Makes a continuous time from the stamps of clocks that wrap, are set back or restart.
//!
//! If a stamp is earlier than the newest stamp of its signal, either the sample is late, or the clock went back. Late samples fill holes that they left;
//! samples of a clock that went back are consecutive where samples already are. So a few samples are stored until this is decided.
//!
//! - A wrap is recognised by its period ([`COUNTERS`], [`CALENDAR`]): the stamps before it reach the period, the stamps after it begin at 0. The time
//!   continues.
//! - **Otherwise** the length of the interruption is unknown: the stamps continue a little later, and a new segment begins.
//!
//! All signals of a record share one clock. When the first signal has gone back, the others are expected to follow.

use std::collections::VecDeque;

use crate::quantile::median;
use crate::resample::ORDER;

/// Stamps stored for each signal, to know where samples have been.
const RECENT: usize = 256;

/// Number of consecutive samples older than the newest that show that the clock has gone back.
const BEHIND: usize = 8;

/// The number of such samples if the clock is set back by less than that many samples and then catches up.
const BEHIND_BRIEFLY: usize = 3;

/// An interval of this many medians is a hole.
const HOLE: f64 = 1.6;

/// Gaps up to this many median intervals before and after a wrap belong to the wrap.
const AT_WRAP: f64 = 4.0;

/// The assumed time between two segments with unknown distance: at least this many ns, and this many intervals.
const PAUSE: f64 = 1e9;
const SHORTEST_PAUSE: f64 = 10.0;

const SECOND: i64 = 1_000_000_000;

/// A stamp this far ahead, ns, is accepted after this many samples in order.
const FAR: i64 = 10 * SECOND;
const AHEAD: usize = 4;

/// Periods of counters that wrap, ns, with their names. A counter may be signed.
const COUNTERS: [(i64, &str); 5] = [
    ((1 << 32) * 1000, "2^32 us"),
    ((1 << 31) * 1000, "2^31 us"),
    ((1 << 32) * 1_000_000, "2^32 ms"),
    ((1 << 16) * 1_000_000, "2^16 ms"),
    (1 << 32, "2^32 ns"),
];

/// Periods of the calendar, ns, with their names. A run may last as long as this, so it is a wrap only if the record did not begin at 0.
const CALENDAR: [(i64, &str); 5] = [
    (604_800 * SECOND, "a week"),
    (86_400 * SECOND, "a day"),
    (43_200 * SECOND, "12 hours"),
    (3600 * SECOND, "an hour"),
    (60 * SECOND, "a minute"),
];

/// Number of returns that are reported individually.
const TOLD: usize = 3;

/// The corrected stamp of a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Followed {
    /// A sample of a signal on the continuous time.
    Sample(usize, i64, Option<f64>),
    /// The signal is unknown between its last sample and its next.
    Break(usize),
}

/// A return of the clock to an earlier time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Return {
    /// The newest stamp before the clock went back, and the first stamp after, ns.
    from: i64,
    to: i64,
    /// The offset added to the stamps from there on, ns.
    offset: i64,
    /// The name of the clock's period, if the clock wrapped.
    wrap: Option<&'static str>,
    /// The newest stamp since the return, over all signals.
    newest: i64,
}

/// Corrects the clock of a record's signals.
#[derive(Clone, Debug)]
pub(crate) struct ClockFollower {
    signals: Vec<SignalClock>,
    returns: Vec<Return>,
    /// The newest stamp of any signal on the continuous time.
    newest: Option<i64>,
    /// Samples whose stamps were far ahead of their neighbours'.
    left_out: u64,
}

/// The stamps of one signal.
#[derive(Clone, Debug, Default)]
struct SignalClock {
    /// Number of times that the signal's clock has gone back.
    returns: usize,
    /// The first stamp since then.
    first: Option<i64>,
    /// The latest stamps on the signal's own clock, in order, with their values.
    recent: VecDeque<(i64, f64)>,
    /// Samples older than the newest, in the order of arrival.
    behind: Vec<(i64, f64)>,
    /// Samples so far ahead of the newest that they may be damaged, in the order of arrival.
    ahead: Vec<(i64, f64)>,
}

impl SignalClock {
    fn newest(&self) -> Option<i64> {
        self.recent.back().map(|it| it.0)
    }

    /// The median of the latest intervals, ns.
    fn interval(&self) -> f64 {
        let stamps = self.recent.iter().map(|it| it.0);
        let later = stamps.clone().skip(1);
        let intervals = later.zip(stamps).map(|(b, a)| b.saturating_sub(a) as f64);
        let mut intervals: Vec<f64> = intervals.filter(|it| *it > 0.0).collect();
        median(&mut intervals)
    }

    fn keep(&mut self, stamp: i64, value: f64) {
        self.first.get_or_insert(stamp);
        if self.recent.len() == RECENT {
            self.recent.pop_front();
        }
        self.recent.push_back((stamp, value));
    }

    /// Whether there are already samples near that stamp, so that it fills no hole.
    fn is_covered(&self, stamp: i64, interval: f64) -> bool {
        let place = self.recent.partition_point(|it| it.0 <= stamp);
        match (place.checked_sub(1), self.recent.get(place)) {
            (Some(before), Some((after, _))) => {
                let hole = after.saturating_sub(self.recent[before].0);
                hole as f64 <= HOLE * interval
            }
            // Before all that are known, it may still be a straggler.
            (None, Some((after, _))) => {
                self.recent.len() == RECENT
                    || after.saturating_sub(stamp) as f64 > ORDER as f64 * interval
            }
            _ => true,
        }
    }

    /// Whether the older samples show that the clock has gone back; `next` is the next newer sample, if one has arrived.
    fn has_gone_back(&self, next: Option<i64>) -> bool {
        let interval = self.interval();
        let rises = self.behind.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let is_covered = |it: &&(i64, f64)| self.is_covered(it.0, interval);
        let covered = self.behind.iter().filter(is_covered).count();
        // A value that does not change says nothing.
        let changes = self.behind.windows(2).any(|pair| pair[0].1 != pair[1].1);
        let is_repeated = changes && (self.behind.iter()).all(|it| self.recent.contains(it));
        if !rises || is_repeated {
            return false;
        }
        match (next, self.behind.last()) {
            _ if self.behind.len() >= BEHIND => covered + 1 >= self.behind.len(),
            (Some(next), Some((last, _))) => {
                self.behind.len() >= BEHIND_BRIEFLY
                    && covered == self.behind.len()
                    && next.saturating_sub(*last) as f64 <= HOLE * interval
            }
            _ => self.behind.len() >= BEHIND_BRIEFLY && covered == self.behind.len(),
        }
    }
}

impl ClockFollower {
    pub(crate) fn new(signals: usize) -> Self {
        Self {
            signals: vec![SignalClock::default(); signals],
            returns: Vec::new(),
            newest: None,
            left_out: 0,
        }
    }

    /// Takes a sample, and passes on the samples whose order is decided.
    pub(crate) fn take(
        &mut self,
        signal: usize,
        stamp: i64,
        value: Option<f64>,
        give: &mut dyn FnMut(Followed),
    ) {
        let number = value.filter(|it| it.is_finite() && signal < self.signals.len());
        let Some(value) = number else {
            return give(Followed::Sample(signal, stamp, value));
        };
        if self.is_of_next(signal, stamp) {
            self.go_back(signal, stamp, give);
            return self.pass(signal, stamp, value, give);
        }
        let stamps = &mut self.signals[signal];
        match stamps.newest() {
            Some(newest) if stamp < newest => {
                stamps.behind.push((stamp, value));
                if stamps.behind.len() >= BEHIND {
                    self.settle(signal, None, give);
                }
            }
            _ => {
                if !stamps.behind.is_empty() {
                    self.settle(signal, Some(stamp), give);
                }
                self.go_on(signal, stamp, value, give);
            }
        }
    }

    /// Takes a sample that is not older than the newest. A sample that is far ahead waits for the next ones, which show whether time has jumped
    /// there.
    fn go_on(&mut self, signal: usize, stamp: i64, value: f64, give: &mut dyn FnMut(Followed)) {
        let stamps = &mut self.signals[signal];
        let newest = stamps.newest();
        let is_far = newest.is_some_and(|it| stamp.saturating_sub(it) > FAR);
        match stamps.ahead.last() {
            None if !is_far => return self.pass(signal, stamp, value, give),
            Some((last, _)) if stamp < *last => {
                // The time is where it was, or others came far ahead too.
                self.left_out += stamps.ahead.len() as u64;
                stamps.ahead.clear();
                if !is_far {
                    return self.pass(signal, stamp, value, give);
                }
            }
            _ => {}
        }
        self.signals[signal].ahead.push((stamp, value));
        if self.signals[signal].ahead.len() >= AHEAD {
            self.give_out_ahead(signal, give);
        }
    }

    fn give_out_ahead(&mut self, signal: usize, give: &mut dyn FnMut(Followed)) {
        for (stamp, value) in std::mem::take(&mut self.signals[signal].ahead) {
            self.pass(signal, stamp, value, give);
        }
    }

    /// Passes on the remaining samples.
    pub(crate) fn finish(&mut self, give: &mut dyn FnMut(Followed)) {
        for signal in 0..self.signals.len() {
            self.give_out_ahead(signal, give);
            self.settle(signal, None, give);
        }
    }

    /// Whether the clock has gone back.
    pub(crate) fn has_returned(&self) -> bool {
        !self.returns.is_empty()
    }

    /// The findings about the clock, for people.
    pub(crate) fn notes(&self) -> Vec<String> {
        let seconds = |stamp: i64| stamp as f64 * 1e-9;
        let told = self.returns.iter().take(TOLD).map(|it| match it.wrap {
            Some(period) => format!(
                "the clock wraps at {:.3} s ({period}): the later times continue without a jump",
                seconds(it.from)
            ),
            None => format!(
                "the clock goes back from {:.3} to {:.3} s: a new segment begins there",
                seconds(it.from),
                seconds(it.to)
            ),
        });
        let mut notes: Vec<String> = told.collect();
        let more = self.returns.len().saturating_sub(TOLD);
        if more > 0 {
            notes.push(format!("the clock goes back {more} more times"));
        }
        if self.left_out > 0 {
            notes.push(format!(
                "{} samples have stamps far ahead of their neighbours and are left out",
                self.left_out
            ));
        }
        notes
    }

    /// Whether a sample has the new time of a clock that has already gone back for another signal.
    fn is_of_next(&self, signal: usize, stamp: i64) -> bool {
        let stamps = &self.signals[signal];
        let Some(next) = self.returns.get(stamps.returns) else {
            return false;
        };
        let distance = |other: i64| stamp.saturating_sub(other).saturating_abs();
        stamps.newest().is_some_and(|newest| stamp < newest)
            || distance(next.newest) < distance(next.from)
    }

    /// Decides whether the older samples are late or the clock went back.
    fn settle(&mut self, signal: usize, next: Option<i64>, give: &mut dyn FnMut(Followed)) {
        let stamps = &mut self.signals[signal];
        if let Some((first, _)) = stamps.behind.first().copied()
            && stamps.has_gone_back(next)
        {
            return self.go_back(signal, first, give);
        }
        let offset = self.offset(signal);
        for (stamp, value) in std::mem::take(&mut self.signals[signal].behind) {
            let stamp = stamp.saturating_add(offset);
            give(Followed::Sample(signal, stamp, Some(value)));
        }
    }

    /// Handles the return of the signal's clock; the older samples have its new time.
    fn go_back(&mut self, signal: usize, first: i64, give: &mut dyn FnMut(Followed)) {
        let stamps = &self.signals[signal];
        let newest = stamps.newest().unwrap_or(first);
        let first = stamps.behind.first().map_or(first, |it| it.0);
        if stamps.returns == self.returns.len() {
            let told = self.returned(signal, newest, first);
            self.returns.push(told);
        }
        let behind = {
            let stamps = &mut self.signals[signal];
            stamps.returns += 1;
            stamps.recent.clear();
            stamps.first = None;
            std::mem::take(&mut stamps.behind)
        };
        let goes_on = self.returns[self.signals[signal].returns - 1]
            .wrap
            .is_some();
        if !goes_on {
            give(Followed::Break(signal));
        }
        for (stamp, value) in behind {
            self.pass(signal, stamp, value, give);
        }
    }

    fn returned(&self, signal: usize, from: i64, to: i64) -> Return {
        let interval = self.signals[signal].interval();
        let before = self.offset(signal);
        let near = |stamp: i64, edge: i64| {
            (stamp.saturating_sub(edge)).unsigned_abs() as f64 <= AT_WRAP * interval
        };
        let wraps = |period: i64| {
            [0, -period / 2]
                .into_iter()
                .any(|start| near(to, start) && near(from, start + period))
        };
        let began_at_zero = self.signals[signal]
            .first
            .is_some_and(|first| near(first, 0));
        let calendar = CALENDAR.into_iter().filter(|_| !began_at_zero);
        let mut periods = COUNTERS.into_iter().chain(calendar);
        let wrap = periods.find(|(period, _)| wraps(*period));
        let offset = match wrap {
            Some((period, _)) => before.saturating_add(period),
            None => {
                // Whole intervals, so that a grid through the samples before goes through those behind.
                let ours = from.saturating_add(before);
                let ahead = self.newest.unwrap_or(ours).saturating_sub(ours) as f64;
                let interval = interval.max(1.0);
                let intervals = ((ahead.max(0.0) + PAUSE) / interval)
                    .ceil()
                    .max(SHORTEST_PAUSE);
                let goes_on = ours.saturating_add((intervals * interval) as i64);
                goes_on.saturating_sub(to)
            }
        };
        Return {
            from,
            to,
            offset,
            wrap: wrap.map(|it| it.1),
            newest: to,
        }
    }

    fn offset(&self, signal: usize) -> i64 {
        let returns = self.signals[signal].returns;
        returns
            .checked_sub(1)
            .map_or(0, |it| self.returns[it].offset)
    }

    /// Takes a sample that is in front.
    fn pass(&mut self, signal: usize, stamp: i64, value: f64, give: &mut dyn FnMut(Followed)) {
        let returns = self.signals[signal].returns;
        if let Some(last) = returns
            .checked_sub(1)
            .and_then(|it| self.returns.get_mut(it))
        {
            last.newest = last.newest.max(stamp);
        }
        let on = stamp.saturating_add(self.offset(signal));
        self.newest = self.newest.max(Some(on));
        self.signals[signal].keep(stamp, value);
        give(Followed::Sample(signal, on, Some(value)));
    }
}
