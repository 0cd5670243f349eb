//! Timing statistics of stamps: rate, jitter, gaps, duplicates, in constant memory.
//!
//! Intervals are counted in bins one per cent wide, each with its mean. So the median and the range of 90 % are accurate to about 1 %, and exact if
//! all intervals in a bin are equal.

use std::collections::BTreeMap;

use crate::channel::Timing;

/// An interval of more than this many medians is a gap.
const GAP: f64 = 1.5;

/// Takes stamps in the order of arrival, and computes their timing.
#[derive(Clone, Debug, Default)]
pub struct Meter {
    timing: Timing,
    /// Intervals by the logarithm of their length: how many, and their sum, ns.
    bins: BTreeMap<u16, (u64, f64)>,
}

impl Meter {
    /// Takes a stamp, ns. A stamp that is not after the latest counts as a duplicate or as late.
    pub fn take(&mut self, stamp: i64) {
        self.timing.samples += 1;
        let Some((_, last)) = &mut self.timing.span else {
            self.timing.span = Some((stamp, stamp));
            return;
        };
        let interval = stamp.saturating_sub(*last);
        if interval <= 0 {
            let count = if interval == 0 {
                &mut self.timing.duplicates
            } else {
                &mut self.timing.late
            };
            *count += 1;
            return;
        }
        *last = stamp;
        let interval = interval as f64;
        self.timing.longest = self.timing.longest.max(interval * 1e-9);
        let (count, sum) = self
            .bins
            .entry((libm::log(interval) * 100.0) as u16)
            .or_default();
        *count += 1;
        *sum += interval;
    }

    /// Counts a sample whose value is not finite.
    pub fn not_finite(&mut self) {
        self.timing.not_finite += 1;
    }

    /// Counts a message without the element.
    pub fn absent(&mut self) {
        self.timing.absent += 1;
    }

    /// Counts a sample with the same stamp as an earlier one.
    pub fn duplicate(&mut self) {
        self.timing.duplicates += 1;
    }

    /// Counts a sample that came too late to be sorted.
    pub fn late(&mut self) {
        self.timing.late += 1;
    }

    /// The timing of the stamps so far.
    #[must_use]
    pub fn timing(&self) -> Timing {
        let total: u64 = self.bins.values().map(|(count, _)| count).sum();
        let median = self.quantile(total.div_ceil(2));
        let gaps = self
            .bins
            .values()
            .filter(|(count, sum)| sum / *count as f64 > GAP * median);
        Timing {
            interval: median * 1e-9,
            jitter: 0.5e-9
                * (self.quantile(total - total / 20) - self.quantile(total.div_ceil(20))),
            gaps: gaps.map(|(count, _)| count).sum(),
            ..self.timing.clone()
        }
    }

    /// The share of intervals below a tenth of the mean, 0 to 1.
    #[must_use]
    pub fn bursts(&self) -> f64 {
        let repeated = self.timing.duplicates;
        let total = repeated + self.bins.values().map(|(count, _)| count).sum::<u64>();
        let sum: f64 = self.bins.values().map(|(_, sum)| sum).sum();
        if total == 0 {
            return 0.0;
        }
        let short = |(count, of): &&(u64, f64)| of / *count as f64 <= 0.1 * sum / total as f64;
        let short: u64 = self.bins.values().filter(short).map(|it| it.0).sum();
        (short + repeated) as f64 / total as f64
    }

    /// The interval with this rank from below, counted from 1, ns; 0 if there is none.
    fn quantile(&self, rank: u64) -> f64 {
        let mut before = 0;
        for (count, sum) in self.bins.values() {
            before += count;
            if before >= rank {
                return sum / *count as f64;
            }
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timing(stamps: impl IntoIterator<Item = i64>) -> Timing {
        let mut meter = Meter::default();
        stamps.into_iter().for_each(|stamp| meter.take(stamp));
        meter.timing()
    }

    #[test]
    fn a_steady_clock_has_a_rate_and_nothing_to_report() {
        let steady = timing((0..1000).map(|k| 7 + k * 10_000_000));
        assert_eq!(steady.span, Some((7, 9_990_000_007)));
        assert!((steady.rate() - 100.0).abs() < 1e-9 && steady.jitter == 0.0);
        assert_eq!(
            (steady.samples, steady.gaps, steady.duplicates, steady.late),
            (1000, 0, 0, 0)
        );
    }

    #[test]
    fn gaps_jitter_duplicates_and_what_is_late_are_told_apart() {
        // Every interval 8 or 12 ms in turn; then half a second of nothing, twice.
        let mut at = 0;
        let mut stamps: Vec<i64> = (0..2000)
            .map(|k| {
                at += if k == 500 || k == 900 {
                    500
                } else {
                    8 + 4 * (k % 2)
                } * 1_000_000;
                at
            })
            .collect();
        stamps.push(at);
        stamps.push(at - 1);
        let found = timing(stamps);
        assert_eq!((found.gaps, found.duplicates, found.late), (2, 1, 1));
        assert_eq!(found.longest, 0.5);
        assert!((found.jitter - 0.002).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn no_stamp_one_stamp_and_the_ends_of_time_are_no_trouble() {
        assert_eq!(timing([]), Timing::default());
        assert_eq!(timing([5]).rate(), 0.0);
        let ends = timing([i64::MIN, 0, i64::MAX]);
        assert!(ends.interval > 9e9 && ends.interval.is_finite());
    }
}
