//! What happens to the samples of one signal before they go onto a grid.

use crate::channel::Change;
use crate::quantile::median;
use crate::repeats::{Repeats, rows_per_sample};
use crate::spread::{Bursts, Spreader, mean_interval};
use crate::unwrap::{Unwrap, Unwrapper};

/// A mean interval of so many medians says that the median is not what samples stand for.
const UNEVEN: f64 = 1.5;

/// The changes of one signal.
#[derive(Clone, Debug)]
pub(crate) struct Sieve {
    /// From sample to sample, ns; 0 where fewer than two are known.
    pub(crate) interval: f64,
    bursts: Option<Bursts>,
    pub(crate) spreader: Option<Spreader>,
    pub(crate) repeats: Option<Repeats>,
    pub(crate) unwrapper: Unwrapper,
}

impl Sieve {
    /// Finds what the first samples need; they are put in the order of their stamps. Repeats of an output are left out.
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
        if let Some(repeats) = &repeats {
            interval *= repeats.rows;
        }
        Self {
            interval,
            bursts,
            spreader: bursts.map(Spreader::new),
            repeats,
            unwrapper: Unwrapper::new(unwrap, &values),
        }
    }

    /// Samples in the order of their stamps, changed. Of those of one stamp the last counts.
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

    /// What was done to the samples.
    pub(crate) fn changes(&self) -> Vec<Change> {
        let spread = self.bursts.map(|it| it.change());
        let repeats = self.repeats.map(|it| it.change());
        let unwrapped = Change::of(&self.unwrapper);
        [spread, repeats, unwrapped].into_iter().flatten().collect()
    }
}

/// How sorted stamps are to be spread, if they are.
pub(crate) fn bursts(stamps: &[i64]) -> Option<Bursts> {
    Bursts::find(stamps).or_else(|| Bursts::in_steps(stamps))
}

/// The median interval of sorted stamps, or the mean without gaps where that is far longer, ns; repeated stamps count for nothing.
fn interval(stamps: &[i64]) -> f64 {
    let mut stamps = stamps.to_vec();
    stamps.dedup();
    let intervals = stamps.windows(2).map(|it| (it[1] - it[0]) as f64);
    let median = median(&mut intervals.collect::<Vec<f64>>());
    let mean = mean_interval(&stamps);
    if mean > UNEVEN * median { mean } else { median }
}
