//! Results of the cases of a sweep by combination.
//!
//! The files are read row by row. Memory does not grow with the seeds: only the means of each combination are kept.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::case::{SETTLING, TRAVEL};
use super::results::file_of;
use super::space::Space;
use crate::error::{During, Result, refused};

/// A running mean.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mean {
    sum: f64,
    /// Values taken.
    pub count: u32,
}

impl Mean {
    /// Adds a value; `None` is ignored.
    pub fn take(&mut self, value: Option<f64>) {
        if let Some(value) = value {
            self.sum += value;
            self.count += 1;
        }
    }

    /// Mean of the values so far; `None` without values.
    #[must_use]
    pub fn value(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / f64::from(self.count))
    }
}

/// Results of a combination over its seeds.
#[derive(Clone, Copy, Debug, Default)]
pub struct Combination {
    /// Settling times, s.
    pub settling: Mean,
    /// Plane travel, rad.
    pub travel: Mean,
    /// Cases.
    pub cases: u32,
    /// Number of cases that never settled.
    pub unsettled: u32,
}

/// A combination that settles with every seed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settled {
    /// Mean settling time to 5 %, s.
    pub settling: f64,
    /// Mean plane travel, rad.
    pub travel: f64,
    /// Its number.
    pub combination: u64,
    /// Whether no other combination is better in both.
    pub is_on_front: bool,
}

/// Results of the cases in a folder.
#[derive(Clone, Debug, Default)]
pub struct Outcomes {
    /// Combinations with results, by number.
    pub combinations: BTreeMap<u64, Combination>,
    /// Cases.
    pub cases: u64,
    /// Number of failed cases.
    pub failed: u64,
}

impl Outcomes {
    /// Reads the folder's results, undivided or in `parts` parts.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn read(folder: &Path, parts: Option<u64>, space: &Space) -> Result<Self> {
        let mut outcomes = Self::default();
        for file in files(folder, parts)? {
            let mut rows = csv::Reader::from_path(&file)?;
            for row in rows.records() {
                let row = row.during(|| format!("'{}'", file.display()))?;
                let metric =
                    |place: usize| row.get(space.axes.len() + 2 + place)?.parse::<f64>().ok();
                let case = row.get(0).unwrap_or_default();
                let case: u64 = case
                    .parse()
                    .map_err(|_| refused!("'{}': unknown case number '{case}'", file.display()))?;
                let combination = outcomes
                    .combinations
                    .entry(case / u64::from(space.seeds))
                    .or_default();
                outcomes.cases += 1;
                combination.cases += 1;
                if row
                    .get(row.len() - 1)
                    .is_some_and(|error| !error.is_empty())
                {
                    outcomes.failed += 1;
                    continue;
                }
                let settling = metric(SETTLING);
                combination.unsettled += u32::from(settling.is_none());
                combination.settling.take(settling);
                combination.travel.take(metric(TRAVEL));
            }
        }
        Ok(outcomes)
    }

    /// Combinations that settle with every seed, the fastest first.
    #[must_use]
    pub fn settled(&self) -> Vec<Settled> {
        let all = self.combinations.iter();
        let all = all.filter(|(_, it)| it.unsettled == 0 && it.settling.count == it.cases);
        let mut settled: Vec<_> = all
            .filter_map(|(combination, it)| {
                Some(Settled {
                    settling: it.settling.value()?,
                    travel: it.travel.value()?,
                    combination: *combination,
                    is_on_front: false,
                })
            })
            .collect();
        settled.sort_by(|a, b| {
            let by_settling = a.settling.total_cmp(&b.settling);
            by_settling.then(a.travel.total_cmp(&b.travel))
        });
        let mut least = f64::INFINITY;
        for it in &mut settled {
            it.is_on_front = it.travel < least;
            least = least.min(it.travel);
        }
        settled
    }
}

/// Existing result files. A copy of a file, or a part of another division, would repeat cases: it is ignored.
fn files(folder: &Path, parts: Option<u64>) -> Result<Vec<PathBuf>> {
    let Some(parts) = parts else {
        return Ok(vec![folder.join("cases.csv")]);
    };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let part = || name.strip_prefix("cases-")?.split('-').next()?.parse().ok();
        if part().is_some_and(|part| name == file_of(part, parts)) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
