//! Changes to the samples of one signal before resampling.

use crate::channel::Change;
use crate::quantile::median;
use crate::repeats::{Repeats, rows_per_sample};
use crate::spread::{Bursts, LostDigits, Spreader, mean_interval};
use crate::unwrap::{Unwrap, Unwrapper};

/// Minimum number of unique stamps before shared ones, used to find the interval; and the required share of repeated stamps after these.
const LONG: usize = 50;
const SHARED: f64 = 0.3;

/// If the mean interval exceeds this many medians, the median is not representative.
const UNEVEN: f64 = 1.5;

/// The changes of one signal.
#[derive(Clone, Debug)]
pub(crate) struct DuplicateFilter {
    /// The time from sample to sample, ns; 0 if fewer than two samples are known.
    pub(crate) interval: f64,
    /// The grid step for the samples, ns.
    pub(crate) step: f64,
    bursts: Option<Bursts>,
    pub(crate) spreader: Option<Spreader>,
    lost: LostDigits,
    pub(crate) repeats: Option<Repeats>,
    pub(crate) unwrapper: Unwrapper,
}

impl DuplicateFilter {
    /// Determines the needed changes from the first samples, sorted by their stamps. Repeats of an output are left out.
    pub(crate) fn find(samples: &mut [(i64, f64)], is_output: bool, unwrap: Unwrap) -> Self {
        samples.sort_by_key(|it| it.0);
        let stamps: Vec<i64> = samples.iter().map(|it| it.0).collect();
        let bursts = bursts(&stamps);
        let mut interval = match bursts {
            Some(bursts) => bursts.interval,
            None => interval(&stamps),
        };
        let values: Vec<f64> = samples.iter().map(|it| it.1).collect();
        let repeats = rows_per_sample(&values)
            .filter(|_| is_output)
            .map(Repeats::new);
        let lost = LostDigits::new(interval);
        let mut step = grid_step(interval, &stamps);
        if let Some(repeats) = &repeats {
            interval *= repeats.rows;
            step = rounded(interval);
        }
        Self {
            interval,
            step,
            bursts,
            lost,
            spreader: bursts.map(Spreader::new),
            repeats,
            unwrapper: Unwrapper::new(unwrap, &values),
        }
    }

    /// Takes a sample; when stamps begin to lose digits, returns the samples that are spread from there on.
    pub(crate) fn find_lost_digits(&mut self, stamp: i64, value: f64) -> Option<Vec<(i64, f64)>> {
        if self.spreader.is_some() {
            return None;
        }
        let (spreader, samples) = self.lost.take(stamp, value)?;
        self.bursts = Some(spreader.bursts);
        self.spreader = Some(spreader);
        Some(samples)
    }

    /// Changes samples, which are in the order of their stamps. If several samples have the same stamp, the last one counts.
    pub(crate) fn through(&mut self, samples: &[(i64, f64)]) -> Vec<(i64, f64)> {
        let mut changed: Vec<(i64, f64)> = Vec::with_capacity(samples.len());
        for (stamp, value) in samples {
            let stamp = match &mut self.spreader {
                Some(spreader) => spreader.next(*stamp),
                None => *stamp,
            };
            if self.repeats.as_mut().is_some_and(|it| it.is_one(*value)) {
                continue;
            }
            let value = self.unwrapper.next(*value);
            match changed.last_mut() {
                Some(last) if stamp <= last.0 => last.1 = value,
                _ => changed.push((stamp, value)),
            }
        }
        changed
    }

    /// The changes made to the samples.
    pub(crate) fn changes(&self) -> Vec<Change> {
        let spread = self.bursts.map(|it| it.change());
        let repeats = self.repeats.map(|it| it.change());
        let unwrapped = Change::of(&self.unwrapper);
        [spread, repeats, unwrapped].into_iter().flatten().collect()
    }
}

/// The sorted stamps before many begin to be shared, if that is far from the first.
fn with_all_digits(stamps: &[i64]) -> &[i64] {
    let is_shared = |it: &[i64]| it[0] == it[1];
    let end = stamps.windows(2).position(is_shared).unwrap_or(0) + 1;
    let (first, rest) = stamps.split_at(end.min(stamps.len()));
    let shared = rest.windows(2).filter(|it| is_shared(it)).count();
    match first.len() >= LONG && shared as f64 > SHARED * rest.len() as f64 {
        true => first,
        false => stamps,
    }
}

/// The spread of sorted stamps, if it is needed.
pub(crate) fn bursts(stamps: &[i64]) -> Option<Bursts> {
    let stamps = with_all_digits(stamps);
    Bursts::find(stamps).or_else(|| Bursts::in_steps(stamps))
}

/// The median interval of sorted stamps, or the mean without gaps if that is much longer, ns; repeated stamps are ignored.
pub(crate) fn interval(stamps: &[i64]) -> f64 {
    let mut stamps = with_all_digits(stamps).to_vec();
    stamps.dedup();
    let intervals = stamps.windows(2).map(|it| (it[1] - it[0]) as f64);
    let median = median(&mut intervals.collect::<Vec<f64>>());
    let mean = mean_interval(&stamps);
    if mean > UNEVEN * median { mean } else { median }
}

/// The share of stamps on a grid, and their maximum distance from an instant, in steps.
const ON_GRID: f64 = 0.95;
const NEAR: f64 = 0.1;

/// The grid step for samples with this interval: rounded, unless the stamps fit an unrounded grid better, for example those of a camera with 29.97
/// frames per second.
fn grid_step(interval: f64, stamps: &[i64]) -> f64 {
    let round = rounded(interval);
    let [first, .., last] = stamps else {
        return round;
    };
    let time = (last - first) as f64;
    let measured = time / (time / interval).round();
    let fits = |step: f64| {
        let off = |stamp: &&i64| {
            let steps = (**stamp - first) as f64 / step;
            (steps - steps.round()).abs() <= NEAR
        };
        stamps.iter().filter(off).count() as f64 >= ON_GRID * stamps.len() as f64
    };
    match measured.is_finite() && !fits(round) && fits(measured) {
        true => measured,
        false => round,
    }
}

/// The nearest whole number of hertz or milliseconds within half a per cent; otherwise the interval itself.
fn rounded(interval: f64) -> f64 {
    if interval <= 0.0 {
        return interval;
    }
    let off = |candidate: &f64| (candidate / interval - 1.0).abs();
    [
        1e9 / (1e9 / interval).round(),
        (interval / 1e6).round() * 1e6,
    ]
    .into_iter()
    .filter(|candidate| off(candidate) < 0.005)
    .min_by(|a, b| off(a).total_cmp(&off(b)))
    .unwrap_or(interval)
}
