//! Spreads samples that share a stamp, or come in bursts, over the time that they represent.
//!
//! A clock of whole seconds gives all samples of a second the same stamp: their true times are after this stamp. A recorder that wakes up only now and
//! then receives several samples at once: their true times are before their stamp. In both cases the number per burst and the time between bursts give
//! the interval, which differences between neighbouring stamps do not.

use std::collections::BTreeMap;

use crate::channel::Change;
use crate::quantile::median;

/// Stamps nearer than this, in mean intervals, belong to one burst.
const TOGETHER: f64 = 0.2;

/// The share of samples that come together with others, in data with bursts.
const MOST: f64 = 0.6;

/// Number of bursts from which the interval is found.
const FEWEST: usize = 4;

/// A time between two bursts that exceeds this number of usual times is a gap.
const GAP: f64 = 3.0;

/// Number of stamps from which steps are found, and the longest interval for which they matter, in steps.
const FEWEST_IN_STEPS: usize = 50;
const SLOWEST: f64 = 8.0;

/// Stamps rounded to steps lie within this many steps of an even time from the first to the last, and fewer than this share of their
/// intervals are equal.
const EVEN: f64 = 2.1;
const MOSTLY_EVEN: f64 = 0.9;

/// Long intervals are not gaps if they are more than this share of all intervals, or differ by less than this factor.
const MANY: f64 = 0.05;
const ALIKE: f64 = 2.0;

/// The timing of bursts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bursts {
    /// The time from sample to sample, ns.
    pub(crate) interval: f64,
    /// The time from burst to burst, ns.
    pub(crate) period: f64,
    /// Whether the samples of a burst share one stamp, the time of the burst's beginning.
    pub(crate) share_a_stamp: bool,
    /// The time from the first burst's stamp to the first sample, ns.
    first: f64,
    /// Stamps nearer than this belong to one burst, ns.
    together: f64,
    /// Whether stamps have begun to lose digits: they are rounded, and may lose more.
    is_late: bool,
}

/// The mean interval of sorted stamps without gaps, ns; 0 if there is no interval.
pub(crate) fn mean_interval(stamps: &[i64]) -> f64 {
    let mut intervals: Vec<f64> = (stamps.windows(2))
        .map(|pair| (pair[1] - pair[0]) as f64)
        .collect();
    intervals.sort_unstable_by(f64::total_cmp);
    // What is longer than the mean is the pauses of bursts, if there are many or all are alike; else gaps.
    loop {
        let mean = intervals.iter().sum::<f64>() / intervals.len().max(1) as f64;
        let long = &intervals[intervals.partition_point(|it| *it < mean)..];
        let (Some(least), Some(most)) = (
            long.get(long.len() / 10),
            long.get((long.len() * 9 / 10).min(long.len().saturating_sub(1))),
        ) else {
            return mean;
        };
        let are_many = long.len() as f64 > MANY * intervals.len() as f64;
        if are_many || (long.len() >= FEWEST && *most < ALIKE * least) {
            let longest = GAP * long[long.len() / 2];
            intervals.retain(|it| *it <= longest);
            return intervals.iter().sum::<f64>() / intervals.len() as f64;
        }
        intervals.truncate(intervals.len() - long.len());
    }
}

impl Bursts {
    /// The bursts of sorted stamps; `None` if samples come one by one.
    pub(crate) fn find(stamps: &[i64]) -> Option<Self> {
        let together = TOGETHER * mean_interval(stamps);
        let mut bursts: Vec<(i64, usize)> = Vec::new();
        let mut shared = 0;
        for (place, stamp) in stamps.iter().enumerate() {
            let before = place.checked_sub(1).map(|it| stamps[it]);
            match (before, bursts.last_mut()) {
                (Some(before), Some((_, count))) if ((stamp - before) as f64) < together => {
                    *count += 1;
                    shared += usize::from(*stamp == before);
                }
                _ => bursts.push((*stamp, 1)),
            }
        }
        let in_company: usize = bursts.iter().map(|it| it.1).filter(|it| *it > 1).sum();
        if bursts.len() < FEWEST || (in_company as f64) < MOST * stamps.len() as f64 {
            return None;
        }
        let mut times: Vec<f64> = (bursts.windows(2))
            .map(|it| (it[1].0 - it[0].0) as f64)
            .collect();
        let period = median(&mut times);
        let share_a_stamp = 2 * shared > stamps.len() - bursts.len();
        let (mut time, mut samples) = (0.0, 0);
        // The first second may have begun before the recording, and the last burst may not be all there.
        let pairs = bursts.len() - 1;
        for (place, pair) in bursts.windows(2).enumerate() {
            if (share_a_stamp && place == 0) || (!share_a_stamp && place + 1 == pairs) {
                continue;
            }
            let between = (pair[1].0 - pair[0].0) as f64;
            if between <= GAP * period {
                time += between;
                samples += pair[usize::from(!share_a_stamp)].1;
            }
        }
        if samples == 0 {
            return None;
        }
        let interval = time / samples as f64;
        // The recording may have begun within the first second, or burst.
        let count = bursts[0].1 as f64;
        let first = match share_a_stamp {
            true => (bursts[1].0 - bursts[0].0) as f64 - count * interval,
            false => (1.0 - count) * interval,
        };
        Some(Self {
            interval,
            period,
            share_a_stamp,
            first,
            together,
            is_late: false,
        })
    }

    /// Samples that come one by one, with stamps rounded to a clock step of about their interval: stamps in whole milliseconds 400 times a
    /// second. The stamps follow uniform times within these steps, in contrast to rows of which some are missing.
    pub(crate) fn in_steps(stamps: &[i64]) -> Option<Self> {
        let steps = || stamps.windows(2).map(|it| it[1] - it[0]);
        let step = steps().fold(0, greatest_common_divisor);
        let [first, .., last] = stamps else {
            return None;
        };
        let interval = (last - first) as f64 / (stamps.len() - 1) as f64;
        let mut counts: BTreeMap<i64, usize> = BTreeMap::new();
        steps().for_each(|it| *counts.entry(it).or_default() += 1);
        let usual = counts.values().copied().max().unwrap_or(0) as f64;
        let is_even = usual > MOSTLY_EVEN * stamps.len() as f64;
        let is_slow = interval > SLOWEST * step as f64;
        if stamps.len() < FEWEST_IN_STEPS || step == 0 || is_slow || is_even {
            return None;
        }
        let off = stamps.iter().enumerate();
        let off = off.map(|(k, stamp)| (stamp - first) as f64 - k as f64 * interval);
        let (least, most) = off.fold((0.0_f64, 0.0_f64), |(a, b), it| (a.min(it), b.max(it)));
        let fits = most - least <= EVEN * step as f64;
        fits.then_some(Self {
            interval,
            period: step as f64,
            share_a_stamp: true,
            first: (-least).min(step as f64),
            together: 0.0,
            is_late: false,
        })
    }

    /// The change that a record makes to the samples.
    pub(crate) fn change(&self) -> Change {
        let samples = self.period / self.interval;
        match samples > 1.0 {
            true => Change::Spread {
                samples,
                period: self.period * 1e-9,
                share_a_stamp: self.share_a_stamp,
            },
            false => Change::Rounded {
                step: self.period * 1e-9,
            },
        }
    }
}

fn greatest_common_divisor(a: i64, b: i64) -> i64 {
    match b {
        0 => a,
        b => greatest_common_divisor(b, a % b),
    }
}

/// For stamps that have lost digits: range of the interval between samples that share a stamp, relative to the usual interval, and the number of
/// samples of one stamp that are stored.
const LOST_DIGITS: std::ops::Range<f64> = 0.7..1.4;
const MOST_KEPT: usize = 10_000;

/// Watches stamps that come one by one. Digits are lost if so many samples share each stamp that the time between two stamps is the duration of these
/// samples. For example, all numbers have five digits, and the seconds begin to need four of them.
#[derive(Clone, Debug)]
pub(crate) struct LostDigits {
    /// The usual interval, ns.
    interval: f64,
    /// The stamps before those of `kept`, of the previous group, and of the current one.
    stamps: [Option<i64>; 3],
    /// The samples of both groups, and how many belong to the previous one.
    kept: Vec<(i64, f64)>,
    before: usize,
}

impl LostDigits {
    pub(crate) fn new(interval: f64) -> Self {
        Self {
            interval,
            stamps: [None; 3],
            kept: Vec::new(),
            before: 0,
        }
    }

    /// Takes a sample; if digits are lost, returns a spreader for the samples from the previous two groups on, and those samples.
    pub(crate) fn take(&mut self, stamp: i64, value: f64) -> Option<(Spreader, Vec<(i64, f64)>)> {
        let [last, first, current] = self.stamps;
        if current.is_none_or(|it| stamp > it) {
            if let (Some(first), Some(current)) = (first, current)
                && self.before > 1
                && self.kept.len() > self.before + 1
            {
                let interval = (stamp - first) as f64 / self.kept.len() as f64;
                if LOST_DIGITS.contains(&(interval / self.interval)) {
                    let bursts = Bursts {
                        interval: self.interval,
                        period: (stamp - current) as f64,
                        share_a_stamp: true,
                        first: 0.0,
                        together: 1.0,
                        is_late: true,
                    };
                    let mut spreader = Spreader::new(bursts);
                    spreader.last = last.map(|it| (it, 0.0));
                    spreader.burst = last;
                    return Some((spreader, std::mem::take(&mut self.kept)));
                }
            }
            self.kept.drain(..self.before);
            self.before = self.kept.len();
            self.stamps = [first, current, Some(stamp)];
        }
        if self.stamps[2] == Some(stamp) && self.kept.len() < MOST_KEPT {
            self.kept.push((stamp, value));
        }
        None
    }
}

/// Spreads the samples of one signal as they arrive: each is an interval after the previous sample, within the range that its stamp allows.
#[derive(Clone, Debug)]
pub(crate) struct Spreader {
    pub(crate) bursts: Bursts,
    /// The last sample's stamp, and the time added to this stamp, ns.
    last: Option<(i64, f64)>,
    /// The stamps of the previous and the current burst, ns.
    before: Option<i64>,
    burst: Option<i64>,
}

impl Spreader {
    pub(crate) fn new(bursts: Bursts) -> Self {
        Self {
            bursts,
            last: None,
            before: None,
            burst: None,
        }
    }

    /// The time of the next sample.
    pub(crate) fn next(&mut self, stamp: i64) -> i64 {
        let Bursts {
            interval, period, ..
        } = self.bursts;
        // Relative to the stamp: those of our time are not exact as 64-bit floating point.
        let relative = |it: i64| it.saturating_sub(stamp) as f64;
        let is_new = self
            .last
            .is_none_or(|it| -relative(it.0) >= self.bursts.together);
        if is_new {
            self.before = self.burst.replace(stamp);
        }
        let expected = match self.last {
            Some((last, more)) => relative(last) + more + interval,
            None => self.bursts.first,
        };
        let since = match self.bursts.share_a_stamp {
            true if self.bursts.is_late && !is_new => expected,
            true if self.bursts.is_late => expected.clamp(-0.5 * period, period - 1.0),
            true => expected.min(period - 1.0).max(0.0),
            // Received at once, they were sent since the burst before.
            false => {
                let least = self.before.map_or(-period, relative) + 0.5 * interval;
                expected.max(least).min(0.0)
            }
        };
        self.last = Some((stamp, since));
        stamp.saturating_add(since.round() as i64)
    }

    /// The signal is unknown between the last sample and the next.
    pub(crate) fn begin_anew(&mut self) {
        (self.last, self.before, self.burst) = (None, None, None);
    }
}
