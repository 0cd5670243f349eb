//! Detects two sources in one signal: two publishers whose samples alternate, if nothing in the messages distinguishes them.
//!
//! A sample of the second source is far from the samples before and after it, while these are close to each other. With one publisher such a sample
//! is an outlier: it replaces a good one in time, and does not resemble the next outlier. With two publishers it is an additional sample between two
//! at the usual distance, and the next of its kind lies near it.

use std::fmt;

use serde::Serialize;

use crate::quantile::median;

/// Fewer samples than this cannot reveal a mixture.
const FEWEST: usize = 40;

/// Number of samples examined together.
const BLOCK: usize = 1000;

/// A sample is off the course if the difference of its neighbours is below this share of their distance from the sample.
const NEAR: f64 = 0.3;

/// The share of samples that are off if two publishers alternate one by one.
const IN_TURN: f64 = 0.8;

/// The minimum share of samples from a slower publisher, and their minimum number.
const SLOWER: f64 = 0.02;
const FEWEST_OF_SLOWER: usize = 10;

/// An additional sample lies between two that are at most this many usual intervals apart.
const ONE_MORE: f64 = 1.25;

/// The share of a publisher's intervals that must be near its usual one, and the tolerance.
const MOST: f64 = 0.8;
const EVEN: f64 = 0.25;

/// Alternating samples of two sources.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mixture {
    /// Number of samples examined.
    pub samples: usize,
    /// Number of samples off the course of their neighbours.
    pub off: usize,
    /// Two consecutive values, one from each source.
    pub values: [f64; 2],
}

impl fmt::Display for Mixture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [one, other] = self.values.map(planesman_text::number);
        write!(
            f,
            "{} of {} consecutive samples alternate between two courses, {one} and {other} in turn: two sources seem to share this signal, such as two publishers on one topic, and the data does not name the source. Record each source under a separate name (a remap, or 'ros2 run topic_tools relay')",
            self.off, self.samples
        )
    }
}

impl Mixture {
    /// Searches samples sorted by their stamps.
    pub(crate) fn find(samples: &[(i64, f64)]) -> Option<Self> {
        let off: Vec<usize> = (1..samples.len().saturating_sub(1))
            .filter(|at| is_off(samples, *at))
            .collect();
        let is_found = samples.len() >= FEWEST
            && off.len() >= FEWEST_OF_SLOWER
            && has_levels(samples)
            && (takes_turns(samples, &off) || has_a_slower_one(samples, &off));
        is_found.then(|| Self {
            samples: samples.len(),
            off: off.len(),
            values: [samples[off[0] - 1].1, samples[off[0]].1],
        })
    }
}

/// Searches the samples of one signal block by block for a mixture, until one is found.
#[derive(Clone, Debug, Default)]
pub(crate) struct Mixtures {
    block: Vec<(i64, f64)>,
    pub(crate) found: Option<Mixture>,
}

impl Mixtures {
    /// Takes a sample, roughly in the order of stamps.
    pub(crate) fn take(&mut self, stamp: i64, value: f64) {
        if self.found.is_some() {
            return;
        }
        self.block.push((stamp, value));
        if self.block.len() == BLOCK {
            self.finish();
        }
    }

    /// Examines the last block.
    pub(crate) fn finish(&mut self) {
        self.block.sort_by_key(|it| it.0);
        self.found = self.found.or_else(|| Mixture::find(&self.block));
        self.block.clear();
    }
}

fn distance(samples: &[(i64, f64)], one: usize, other: usize) -> f64 {
    (samples[one].1 - samples[other].1).abs()
}

fn is_off(samples: &[(i64, f64)], at: usize) -> bool {
    let nearest = distance(samples, at - 1, at).min(distance(samples, at, at + 1));
    nearest > 0.0 && distance(samples, at - 1, at + 1) <= NEAR * nearest
}

/// Whether there are more than two values: a switch that is sent when it changes has two, alternating.
fn has_levels(samples: &[(i64, f64)]) -> bool {
    let mut others = samples.iter().filter(|it| it.1 != samples[0].1);
    let other = others.next();
    other.is_some_and(|other| others.any(|it| it.1 != other.1))
}

/// Whether nearly every sample is off, and every other comes at an even rate.
fn takes_turns(samples: &[(i64, f64)], off: &[usize]) -> bool {
    let intervals = samples.windows(3).map(|it| (it[2].0 - it[0].0) as f64);
    off.len() as f64 >= IN_TURN * samples.len() as f64 && are_even(&intervals.collect::<Vec<f64>>())
}

/// Whether most intervals are near the usual one.
fn are_even(intervals: &[f64]) -> bool {
    let usual = median(&mut intervals.to_vec());
    let near = intervals
        .iter()
        .filter(|it| (**it - usual).abs() <= EVEN * usual);
    near.count() as f64 >= MOST * intervals.len() as f64
}

/// Whether samples that are off are additional, at an even rate, and on a separate course.
fn has_a_slower_one(samples: &[(i64, f64)], off: &[usize]) -> bool {
    let between = |one: usize, other: usize| (samples[other].0 - samples[one].0) as f64;
    let mut is_near_off = vec![false; samples.len()];
    off.iter().for_each(|at| is_near_off[*at] = true);
    let usual = (1..samples.len()).filter(|at| !is_near_off[at - 1] && !is_near_off[*at]);
    let usual = median(&mut usual.map(|at| between(at - 1, at)).collect::<Vec<f64>>());
    let is_one_more = |at: &&usize| between(*at - 1, *at + 1) <= ONE_MORE * usual;
    let more: Vec<usize> = off.iter().filter(is_one_more).copied().collect();
    if more.len() < FEWEST_OF_SLOWER || (more.len() as f64) < SLOWER * samples.len() as f64 {
        return false;
    }
    let pairs = || more.windows(2);
    let intervals: Vec<f64> = pairs().map(|it| between(it[0], it[1])).collect();
    let steps = pairs().map(|it| distance(samples, it[0], it[1]));
    let leaps = more.iter().map(|at| distance(samples, at - 1, *at));
    let [step, leap] = [steps.collect(), leaps.collect()].map(|mut it: Vec<f64>| median(&mut it));
    are_even(&intervals) && step <= NEAR * leap
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A publisher's interval, its first time and its course.
    type Publisher<'a> = (i64, i64, &'a dyn Fn(i64) -> f64);

    fn merged(of: &[Publisher<'_>]) -> Vec<(i64, f64)> {
        let mut samples = Vec::new();
        for (step, phase, value) in of {
            samples.extend((0..400).map(|k| (k * step + phase, value(k * step))));
        }
        samples.sort_by_key(|it| it.0);
        samples.truncate(400);
        samples
    }

    /// A number that looks random.
    fn noise(k: i64) -> f64 {
        let mixed = (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ((mixed ^ (mixed >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40) as f64 / 1e7
    }

    #[test]
    fn two_publishers_in_turn_are_told_from_one() {
        let slow = |t: i64| libm::sin(t as f64 * 1e-3);
        let steps = |t: i64| if noise(t / 500) > 0.8 { 1.0 } else { -1.0 };
        let still = |_: i64| 0.3;
        let zero = |_: i64| 0.0;
        for (name, samples) in [
            ("as fast", merged(&[(50, 0, &steps), (50, 20, &still)])),
            (
                "in the middle",
                merged(&[(50, 0, &slow), (50, 25, &|t| 2.0 + slow(t))]),
            ),
            (
                "five times as slow",
                merged(&[(20, 0, &steps), (100, 7, &zero)]),
            ),
            ("half as slow", merged(&[(50, 0, &steps), (100, 20, &zero)])),
            (
                "nearly as fast",
                merged(&[(50, 0, &steps), (66, 20, &still)]),
            ),
        ] {
            assert!(Mixture::find(&samples).is_some(), "{name}");
        }
    }

    #[test]
    fn one_publisher_of_whatever_course_is_one() {
        let pulses = |t: i64| if t % 1000 == 0 { 1.0 } else { 0.0 };
        let dropouts = |t: i64| if noise(t) > 1.5 { 0.0 } else { 5.0 };
        let bits = |t: i64| if noise(t) > 0.8 { 1.0 } else { -1.0 };
        let oscillation = |t: i64| libm::sin(t as f64 * 0.05);
        let one: [&dyn Fn(i64) -> f64; 5] = [&noise, &pulses, &dropouts, &bits, &oscillation];
        for (number, course) in one.into_iter().enumerate() {
            let evenly = merged(&[(50, 0, course)]);
            assert_eq!(Mixture::find(&evenly), None, "{number}");
            // In bursts of two, and with jitter.
            let in_twos = |it: &(i64, f64)| (it.0 / 100 * 100 + it.0 % 100 / 50, it.1);
            let bursts: Vec<(i64, f64)> = evenly.iter().map(in_twos).collect();
            assert_eq!(Mixture::find(&bursts), None, "{number} in bursts");
            let late = |it: &(i64, f64)| (it.0 + (noise(it.0 + 7) * 25.0) as i64, it.1);
            let jitter: Vec<(i64, f64)> = evenly.iter().map(late).collect();
            assert_eq!(Mixture::find(&jitter), None, "{number} with jitter");
        }
        // Commands that are sent when they change: a switch at random, at an even rate, and of a fixed duty; steps at random.
        let switch = |times: &dyn Fn(i64) -> i64| -> Vec<(i64, f64)> {
            (0..400).map(|k| (times(k), (k % 2) as f64)).collect()
        };
        let mut random: Vec<(i64, f64)> = merged(&[(50, 0, &bits)]);
        random.dedup_by_key(|it| it.1);
        let steps = (0..400).map(|k| (k * 300 + (noise(k) * 100.0) as i64, noise(k + 1000)));
        for (name, samples) in [
            ("at random", random),
            ("at an even rate", switch(&|k| k * 500)),
            ("of a fixed duty", switch(&|k| k / 2 * 1000 + k % 2 * 300)),
            ("steps", steps.collect()),
        ] {
            assert_eq!(Mixture::find(&samples), None, "{name}");
        }
        // Every message twice.
        let slow = |t: i64| libm::sin(t as f64 * 1e-3);
        assert_eq!(
            Mixture::find(&merged(&[(50, 0, &slow), (50, 1, &slow)])),
            None
        );
    }
}
