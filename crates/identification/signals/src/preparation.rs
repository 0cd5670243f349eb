//! Prepares a record for identification. Each step reports what it found and did.
//!
//! - **Outliers** are single samples or pairs of samples that are far from the median of their neighbours (Hampel's test) and from the straight
//!   line between the neighbours on either side. The threshold is at least a fifth of the signal's own range, and a multiple of the signal's usual distance. For an output the
//!   usual distance is computed separately for samples just after a change of the input, so that a response to a pulse is not an outlier.
//! - **Prefiltering** applies a frequency band to every signal.
//! - A segment chosen by excitation is the longest part of each segment in which the input moves, including the response afterwards.
//! - **Detrending** subtracts from each signal of each segment its mean, or the least-squares straight line.
//! - **Prewindowing** inserts zeros before each segment: rows of the difference equation then begin with its first sample (Brunner 1988,
//!   ch. V.F).

use planesman_record::{Record, Segment, StraightLine};
use planesman_text::{option, setting};
use serde::Serialize;

use crate::decimation::decimate;
use crate::prefilter::{Band, prefilter};
use crate::quantile::quantile;

/// Number of neighbours on each side in the median.
const HAMPEL_SIDE: usize = 5;

/// An outlier is this many times farther from the median than usual samples of its kind.
const OUTLIER_FACTOR: f64 = 6.0;

/// The outlier factor for an input, which may consist of pulses.
const INPUT_OUTLIER_FACTOR: f64 = 20.0;

/// Number of samples after a change of the input, and at the beginning, that are treated separately: their medians include values from before and
/// after the change.
const RESPONSE_SAMPLES: usize = 2 * HAMPEL_SIDE;

/// Minimum number of samples of a kind from which the usual distance is computed.
const MIN_SAMPLES_OF_KIND: usize = 50;

/// Distances below this share of the signal's own range are harmless.
const HARMLESS_SHARE: f64 = 0.2;

/// The quantile of the distances that counts as usual: a change moves at least one of the [`RESPONSE_SAMPLES`] samples after the change.
const USUAL_SHARE: f64 = 0.95;

/// Maximum number of consecutive outliers; more are not a sensor fault.
const MAX_OUTLIERS_IN_ROW: usize = 2;

/// A change of the input is at least this share of its range.
const INPUT_CHANGE_SHARE: f64 = 0.02;

/// A pause separates two segments if it is longer than this many samples, and than this many times the distance within which nine in ten
/// changes of the input follow each other.
const MIN_PAUSE_SAMPLES: usize = 50;
const MIN_PAUSE_FACTOR: usize = 2;

/// Changes below this share of a signal's standard deviation may be rounding.
const ROUNDING_SHARE: f64 = 1e-9;

planesman_text::choices! {
    /// Treatment of outliers.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Outliers {
        #[default]
        Outputs = "outputs": "Replace outliers of outputs by the straight line between their neighbours",
        Report = "report": "Report outliers and use them",
        Drop = "drop": "Replace outliers of inputs too",
        Keep = "keep": "Do not look for outliers",
    }
}

planesman_text::choices! {
    /// The part of each segment to use.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum SegmentChoice {
        #[default]
        All = "all": "All data",
        Auto = "auto": "Use the longest part of the record in which the input moves",
    }
}

planesman_text::choices! {
    /// Mean or trend to subtract from each signal.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Trend {
        #[default]
        None = "none": "Nothing",
        Mean = "mean": "Subtract the mean of each segment",
        Line = "line": "Subtract the straight line nearest to each segment: for sensors that drift",
    }
}

/// The requested preparation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Preparation {
    /// Whether to decimate a record that is sampled much faster than it moves.
    pub decimate: bool,
    /// Treatment of outliers.
    pub outliers: Outliers,
    /// The band of frequencies to keep, Hz.
    pub band: Option<Band>,
    /// The part of each segment to use.
    pub segment: SegmentChoice,
    /// What to subtract.
    pub trend: Trend,
    /// Number of zeros inserted before each segment.
    pub prewindow: usize,
}

planesman_text::choices! {
    /// The kind of a step.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum StepName {
        /// Takes a coarser grid.
        Decimation = "decimation",
        /// Finds or replaces outliers.
        Outliers = "outliers",
        /// Filters to a band of frequencies.
        Prefilter = "prefilter",
        /// Chooses a part.
        Segment = "segment",
        /// Subtracts a trend.
        Detrend = "detrend",
        /// Inserts zeros before each segment.
        Prewindow = "prewindow",
    }
}

/// The findings and the action of a step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Step {
    /// What it does.
    pub name: StepName,
    /// A sentence with its numbers.
    pub text: String,
}

/// Prepares a record. A step without findings is omitted.
pub fn prepare(record: &mut Record, preparation: &Preparation) -> Vec<Step> {
    let mut steps = Vec::new();
    if preparation.outliers != Outliers::Keep {
        steps.extend(outliers(record, preparation.outliers));
    }
    if let Some(band) = preparation.band {
        steps.push(Step {
            name: StepName::Prefilter,
            text: prefilter(record, band),
        });
    }
    if preparation.decimate {
        steps.extend(decimate(record).map(|text| Step {
            name: StepName::Decimation,
            text,
        }));
    }
    if preparation.segment == SegmentChoice::Auto {
        steps.extend(excited_segment(record));
    }
    if preparation.trend != Trend::None {
        steps.extend(detrend(record, preparation.trend));
    }
    if preparation.prewindow > 0 {
        steps.push(prewindow(record, preparation.prewindow));
    }
    steps
}

/// The reason why a record determines no model: an input or an output never moves, or the output is the input times a number. If the record was at
/// rest before, a constant input is a step; an output that may be static may be the input times a number.
#[must_use]
pub fn without_dynamics(record: &Record, at_rest: bool, is_static: bool) -> Option<String> {
    let all = |signal: usize| {
        record
            .segments
            .iter()
            .flat_map(move |it| values(it, signal))
    };
    let names = || record.inputs.iter().chain(&record.outputs);
    for (signal, name) in names().enumerate() {
        let first = *all(signal).next()?;
        // A single sample neither moves nor rests.
        let samples = record.samples();
        let is_input = signal < record.inputs.len();
        let is_step = at_rest && is_input && first != 0.0;
        if samples > 1 && !is_step && all(signal).all(|it| *it == first) {
            let help = match (is_input, first == 0.0) {
                (false, _) => String::new(),
                (true, false) => format!(
                    "; if the output was at rest before the first sample, use {} to make the input a step there",
                    option("at_rest")
                ),
                (true, true) => {
                    ". A free motion alone determines no gain, so record the input that starts the motion, or an input that moves later"
                        .to_owned()
                }
            };
            return Some(format!(
                "{name} is constant ({first} in all {samples} samples), so it does not determine a model{help}"
            ));
        }
    }
    let (inputs, outputs) = (|| all(0), || all(record.inputs.len()));
    let mean = |sum: f64| sum / record.samples() as f64;
    let (u0, y0) = (mean(inputs().sum()), mean(outputs().sum()));
    let pairs = || inputs().zip(outputs()).map(|(u, y)| (u - u0, y - y0));
    let gain = pairs().map(|(u, y)| u * y).sum::<f64>() / pairs().map(|(u, _)| u * u).sum::<f64>();
    let deviation = mean(pairs().map(|(_, y)| y * y).sum()).sqrt();
    let is_proportional =
        !is_static && pairs().all(|(u, y)| (y - gain * u).abs() <= ROUNDING_SHARE * deviation);
    let (input, output) = (record.inputs.first()?, record.outputs.first()?);
    // A controller moves its output with each sample of a disturbed plant, and against it.
    let steps = || inputs().zip(inputs().skip(1));
    let is_held = 2 * steps().filter(|(u, next)| u != next).count() < record.samples();
    let may_be_feedback = gain < 0.0 && !is_held;
    let ends = || inputs().skip(2).zip(inputs().skip(1)).all(|(u, v)| u == v);
    let is_impulse = || ends() && outputs().next() == Some(&0.0);
    if is_proportional && record.samples() > 2 && is_impulse() {
        return Some(format!(
            "{input} moves only in its first sample, so it cannot be separated from the initial state: {output} may be {input} times {:.6}, or the response to an impulse; {} assumes an impulse from rest",
            Short(gain),
            option("at_rest")
        ));
    }
    is_proportional.then(|| {
        let feedback = match may_be_feedback {
            true => format!(
                " if {input} does not follow {output}; if {input} is feedback of the output alone, with a gain of {:.6}, the record does not show the plant",
                Short(1.0 / gain)
            ),
            false => String::new(),
        };
        format!(
            "{output} is {input} times {:.6} plus {:.6} in every sample, so there are no dynamics to identify. {} fits a static gain{feedback}",
            Short(gain),
            Short(y0 - gain * u0),
            setting("order", 0)
        )
    })
}

/// Finds outliers, and replaces them if requested.
fn outliers(record: &mut Record, asked: Outliers) -> Vec<Step> {
    let mut steps = Vec::new();
    let has_moved: Vec<Vec<bool>> = record.segments.iter().map(moved).collect();
    let names: Vec<String> = record
        .inputs
        .iter()
        .chain(&record.outputs)
        .cloned()
        .collect();
    for (signal, name) in names.iter().enumerate() {
        let lists: Vec<&[f64]> = record
            .segments
            .iter()
            .map(|it| values(it, signal))
            .collect();
        let is_input = signal < record.inputs.len();
        let drop = asked == Outliers::Drop || asked == Outliers::Outputs && !is_input;
        let found = if is_input {
            far(&lists, None, INPUT_OUTLIER_FACTOR)
        } else {
            far(&lists, Some(&has_moved), OUTLIER_FACTOR)
        };
        let count: usize = found.iter().map(Vec::len).sum();
        let Some(segment) = found.iter().position(|it| !it.is_empty()) else {
            continue;
        };
        let at = found[segment][0];
        let of_segment = match lists.len() {
            1 => String::new(),
            _ => format!(" of segment {}", segment + 1),
        };
        let done = match drop {
            true => "replaced by the straight line between their neighbours".to_owned(),
            false => format!(
                "used as recorded ({} replaces these samples)",
                setting("outliers", "drop")
            ),
        };
        steps.push(Step {
            name: StepName::Outliers,
            text: format!(
                "{name}: {count} sample{} far from the neighbours, the first at {:.3} s{of_segment}: {:.4}, while the neighbours are about {:.4}; {done}",
                if count == 1 { "" } else { "s" },
                at as f64 * record.sample_time,
                Short(lists[segment][at]),
                Short(local_median(lists[segment], at)),
            ),
        });
        if drop {
            for (segment, places) in record.segments.iter_mut().zip(&found) {
                let mut lists = segment.inputs.iter_mut().chain(&mut segment.outputs);
                lists
                    .nth(signal)
                    .into_iter()
                    .for_each(|it| bridge(it, places));
            }
        }
    }
    steps
}

/// The values of a signal; inputs are numbered first.
fn values(segment: &Segment, signal: usize) -> &[f64] {
    let mut lists = segment.inputs.iter().chain(&segment.outputs);
    lists.nth(signal).map_or(&[], Vec::as_slice)
}

/// A number with few digits, independent of its size.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = f.precision().unwrap_or(4);
        match self.0.abs() {
            size if size == 0.0 || (1e-3..1e5).contains(&size) => {
                write!(f, "{:.digits$}", self.0)
            }
            _ => write!(f, "{:.digits$e}", self.0),
        }
    }
}

/// Whether the first input has moved within the last samples, or whether these are the first samples.
fn moved(segment: &Segment) -> Vec<bool> {
    let Some(input) = segment.inputs.first() else {
        return vec![false; segment.len()];
    };
    let least = INPUT_CHANGE_SHARE * range(input);
    let has_moved =
        |k: usize| k < RESPONSE_SAMPLES || range(&input[k - RESPONSE_SAMPLES..=k]) > least;
    (0..input.len()).map(has_moved).collect()
}

/// The places in each list that lie `factor` times farther from the local median than is usual for their kind.
fn far(lists: &[&[f64]], kinds: Option<&[Vec<bool>]>, factor: f64) -> Vec<Vec<usize>> {
    let kind = |list: usize, k: usize| kinds.is_some_and(|it| it[list][k]);
    let distances: Vec<Vec<f64>> = lists
        .iter()
        .map(|list| {
            // At the ends the median is of one side: no measure there.
            let distance = |k: usize| match (HAMPEL_SIDE..list.len().saturating_sub(HAMPEL_SIDE))
                .contains(&k)
            {
                true => (list[k] - local_median(list, k))
                    .abs()
                    .min(from_line(list, k)),
                false => 0.0,
            };
            (0..list.len()).map(distance).collect()
        })
        .collect();
    let spread = middle_range(lists.iter().copied().flatten().copied().collect());
    let limits = [false, true].map(|wanted| {
        let mut sizes = Vec::new();
        for (list, distances) in distances.iter().enumerate() {
            let of_kind = distances.iter().enumerate();
            let of_kind = of_kind.filter(|(k, _)| kind(list, *k) == wanted);
            sizes.extend(of_kind.map(|it| *it.1));
        }
        if sizes.len() < MIN_SAMPLES_OF_KIND {
            return f64::INFINITY;
        }
        let usual = match quantile(&mut sizes, USUAL_SHARE) {
            0.0 => {
                // Most lie on the median, as of a coarse sensor: its steps are usual, up to the signal's own range.
                sizes.retain(|size| *size > 0.0);
                quantile(&mut sizes, 0.5).min(spread)
            }
            usual => usual,
        };
        match usual {
            0.0 => f64::INFINITY,
            usual => (factor * usual).max(HARMLESS_SHARE * spread),
        }
    });
    let is_far = |list: usize, k: usize| {
        let limit = limits[usize::from(kind(list, k))];
        distances[list][k] > limit
    };
    (0..lists.len())
        .map(|list| {
            let mut places: Vec<usize> = Vec::new();
            let mut row: Vec<usize> = Vec::new();
            for k in 0..=lists[list].len() {
                if k < lists[list].len() && is_far(list, k) {
                    row.push(k);
                } else if row.len() <= MAX_OUTLIERS_IN_ROW {
                    places.append(&mut row);
                } else {
                    row.clear();
                }
            }
            places
        })
        .collect()
}

/// The distance of a sample from the straight lines between its neighbours, including the next but one: on a smooth curve all these
/// distances are small.
fn from_line(list: &[f64], k: usize) -> f64 {
    let line = |before: usize, after: usize| {
        let share = before as f64 / (before + after) as f64;
        let (first, last) = (list[k - before], list[k + after]);
        (list[k] - first - share * (last - first)).abs()
    };
    line(1, 1).max(line(1, 2)).max(line(2, 1))
}

/// The median of a sample and its neighbours.
fn local_median(list: &[f64], k: usize) -> f64 {
    let around = &list[k.saturating_sub(HAMPEL_SIDE)..list.len().min(k + HAMPEL_SIDE + 1)];
    let mut copy = [0.0; 2 * HAMPEL_SIDE + 1];
    let copy = &mut copy[..around.len()];
    copy.copy_from_slice(around);
    quantile(copy, 0.5)
}

/// The range of the middle nine tenths.
fn middle_range(mut values: Vec<f64>) -> f64 {
    quantile(&mut values, 0.95) - quantile(&mut values, 0.05)
}

fn range(values: &[f64]) -> f64 {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (most - least).max(0.0)
}

/// Replaces the samples at `places` by the straight line between their neighbours.
fn bridge(list: &mut [f64], places: &[usize]) {
    let is_good = |k: &usize| places.binary_search(k).is_err();
    for place in places {
        let before = (0..*place).rev().find(is_good);
        let behind = (*place + 1..list.len()).find(is_good);
        list[*place] = match (before, behind) {
            (Some(before), Some(behind)) => {
                let share = (place - before) as f64 / (behind - before) as f64;
                list[before] + share * (list[behind] - list[before])
            }
            (Some(near), None) | (None, Some(near)) => list[near],
            (None, None) => return,
        };
    }
}

/// Keeps the longest part of each segment in which the first input moves; segments in which it never moves are left out.
fn excited_segment(record: &mut Record) -> Option<Step> {
    let all: Vec<f64> = record
        .segments
        .iter()
        .filter_map(|it| it.inputs.first())
        .flatten()
        .copied()
        .collect();
    let least = INPUT_CHANGE_SHARE * range(&all);
    let (before, samples) = (record.segments.len(), record.samples());
    let mut parts = Vec::new();
    let mut kept = Vec::new();
    for (number, segment) in record.segments.iter().enumerate() {
        let Some((first, end)) = moving_part(segment, least) else {
            continue;
        };
        let time = |k: usize| k as f64 * record.sample_time;
        let of_segment = match before {
            1 => String::new(),
            _ => format!(" of segment {}", number + 1),
        };
        parts.push(format!(
            "{:.3} to {:.3} s{of_segment}",
            time(first),
            time(end)
        ));
        kept.push(segment.part(first, end, record.sample_time));
    }
    // A record in which nothing moves stays as it is.
    if kept.is_empty() {
        return None;
    }
    record.segments = kept;
    let input = record.inputs.first().map_or("", String::as_str);
    Some(Step {
        name: StepName::Segment,
        text: format!(
            "the longest part in which {input} moves is {}: the fit uses {} of {samples} samples",
            parts.join(", "),
            record.samples()
        ),
    })
}

/// The longest part of a segment in which its input keeps changing by `least`, within the first `end` samples. Pauses between changes are at most as
/// long as the tail kept after the last change.
fn moving_part(segment: &Segment, least: f64) -> Option<(usize, usize)> {
    let input = segment.inputs.first()?;
    let mut level = *input.first()?;
    let mut changes = Vec::new();
    for (k, value) in input.iter().enumerate() {
        if (value - level).abs() > least {
            level = *value;
            changes.push(k);
        }
    }
    let mut apart: Vec<f64> = changes
        .windows(2)
        .map(|it| (it[1] - it[0]) as f64)
        .collect();
    let pause = match apart.len() {
        0 => input.len(),
        _ => MIN_PAUSE_SAMPLES.max(MIN_PAUSE_FACTOR * quantile(&mut apart, 0.9) as usize),
    };
    // The sample before the first change shows where it began.
    let part = |it: &[usize]| {
        (
            it[0].saturating_sub(1),
            input.len().min(it[it.len() - 1] + pause + 1),
        )
    };
    let parts = changes
        .chunk_by(|before, after| after - before <= pause)
        .map(part);
    parts.max_by_key(|(first, end)| end - first)
}

/// Subtracts a mean or a line from every signal of every segment; reports the values of the longest segment.
fn detrend(record: &mut Record, trend: Trend) -> Vec<Step> {
    let longest = (0..record.segments.len()).max_by_key(|it| record.segments[*it].len());
    let names: Vec<String> = record
        .inputs
        .iter()
        .chain(&record.outputs)
        .cloned()
        .collect();
    let mut steps = Vec::new();
    for (number, segment) in record.segments.iter_mut().enumerate() {
        let lists = segment.inputs.iter_mut().chain(&mut segment.outputs);
        let mut pasts = segment.past.iter_mut();
        for (list, name) in lists.zip(&names) {
            let StraightLine { mean, slope, .. } = StraightLine::nearest_to(list);
            let slope = if trend == Trend::Line { slope } else { 0.0 };
            let middle = 0.5 * (list.len() as f64 - 1.0);
            for (k, value) in list.iter_mut().enumerate() {
                *value -= mean + slope * (k as f64 - middle);
            }
            let past = pasts.next().into_iter().flatten().rev();
            for (k, value) in past.enumerate() {
                *value -= mean - slope * (k as f64 + 1.0 + middle);
            }
            if Some(number) != longest {
                continue;
            }
            let mean = Short(mean);
            let text = match trend {
                Trend::Line => {
                    let slope = Short(slope / record.sample_time);
                    format!(
                        "{name}: its mean {mean:.4} and its slope {slope:.4} per s are subtracted"
                    )
                }
                _ => format!("{name}: its mean {mean:.4} is subtracted"),
            };
            steps.push(Step {
                name: StepName::Detrend,
                text,
            });
        }
    }
    steps
}

/// Inserts zeros before every segment.
fn prewindow(record: &mut Record, count: usize) -> Step {
    for segment in &mut record.segments {
        segment.past.clear();
        for list in segment.inputs.iter_mut().chain(&mut segment.outputs) {
            list.splice(0..0, std::iter::repeat_n(0.0, count));
        }
        let time = (count as f64 * record.sample_time * 1e9).round() as i64;
        segment.start = segment.start.saturating_sub(time);
    }
    Step {
        name: StepName::Prewindow,
        text: format!("{count} zeros are inserted before each segment"),
    }
}

#[cfg(test)]
mod tests {
    use planesman_record::{filter, noise, with_noise};

    use super::*;

    fn record(inputs: Vec<f64>, outputs: Vec<f64>) -> Record {
        Record::of_run(0.1, vec![("u", inputs)], vec![("y", outputs)]).unwrap()
    }

    /// The response of a second-order system to an input.
    fn response(inputs: &[f64]) -> Vec<f64> {
        filter(&[0.0, 0.2, 0.1], &[1.0, -1.6, 0.63], inputs)
    }

    /// A square wave whose half period is so long.
    fn square(count: usize, half: usize) -> Vec<f64> {
        (0..count)
            .map(|k| f64::from(u8::from((k / half).is_multiple_of(2))))
            .collect()
    }

    fn found(record: &Record) -> Vec<Step> {
        prepare(&mut record.clone(), &Preparation::default())
    }

    #[test]
    fn a_spike_is_named_and_replaced_if_asked_for() {
        for (inputs, at) in [
            (noise(1, 1000), 400),
            (square(1000, 10), 405),
            (square(1000, 100), 570),
        ] {
            let clean = with_noise(&response(&inputs), 3, 0.05);
            let mut outputs = clean.clone();
            outputs[at] = 1e6;
            outputs[at + 200] = -1e6;
            let mut spoilt = record(inputs, outputs);
            let steps = found(&spoilt);
            assert_eq!(steps.len(), 1);
            assert!(steps[0].text.starts_with("y: 2 samples far"), "{steps:?}");
            assert!(
                steps[0].text.contains(&format!("{:.3} s", at as f64 * 0.1)),
                "{steps:?}"
            );
            let drop = Preparation {
                outliers: Outliers::Drop,
                ..Preparation::default()
            };
            prepare(&mut spoilt, &drop);
            let mended = &spoilt.segments[0].outputs[0];
            for (k, (mended, clean)) in mended.iter().zip(&clean).enumerate() {
                let is_line = k == at || k == at + 200;
                assert!(
                    mended == clean || is_line && (mended - clean).abs() < 5.0,
                    "{k}: {mended} {clean}"
                );
            }
        }
    }

    #[test]
    fn one_per_cent_of_outliers_are_all_found() {
        let inputs = square(2000, 10);
        let mut outputs = with_noise(&response(&inputs), 3, 0.05);
        let places: Vec<usize> = (0..20).map(|k| 37 + 97 * k).collect();
        for place in &places {
            outputs[*place] += 60.0;
        }
        let moved = moved(&record(inputs, outputs.clone()).segments[0]);
        assert_eq!(far(&[&outputs], Some(&[moved]), OUTLIER_FACTOR), [places]);
    }

    #[test]
    fn clean_data_has_no_outliers() {
        let pulse = |at: &[usize]| -> Vec<f64> {
            let is_on = |k: usize| f64::from(u8::from(at.contains(&k)));
            (0..1000).map(is_on).collect()
        };
        let quantised = |values: Vec<f64>, step: f64| -> Vec<f64> {
            values
                .into_iter()
                .map(|it| (it / step).round() * step)
                .collect()
        };
        let inputs = [
            noise(1, 1000),
            square(1000, 1),
            square(1000, 7),
            square(1000, 500),
            pulse(&[500]),
            pulse(&[200, 201, 500]),
            [square(200, 40), vec![0.0; 800]].concat(),
            (0..1000).map(|k| f64::from(k) * 0.01).collect(),
            (0..1000)
                .map(|k| libm::sin((f64::from(k) * 0.01).powi(2)))
                .collect(),
            vec![1.0; 1000],
        ];
        for (number, inputs) in inputs.into_iter().enumerate() {
            let first_order = filter(&[0.0, 1.0], &[1.0, -0.3], &inputs);
            let resonant = filter(&[0.0, 1.0], &[1.0, 1.6, 0.98], &inputs);
            for outputs in [response(&inputs), first_order, resonant] {
                for outputs in [
                    with_noise(&outputs, 2, 0.05),
                    with_noise(&outputs, 2, 1e-6),
                    quantised(outputs.clone(), 0.5),
                    quantised(with_noise(&outputs, 2, 0.1), 0.05),
                    outputs,
                ] {
                    let steps = found(&record(inputs.clone(), outputs));
                    assert!(steps.is_empty(), "{number}: {steps:?}");
                }
            }
        }
    }

    #[test]
    fn the_longest_part_in_which_the_input_moves_is_kept_with_its_tail() {
        let mut inputs = vec![0.0; 200];
        inputs.extend(square(100, 10));
        inputs.extend(vec![0.0; 300]);
        inputs.extend(square(300, 10));
        inputs.extend(vec![0.0; 500]);
        let outputs = response(&inputs);
        let mut kept = record(inputs.clone(), outputs.clone());
        let auto = Preparation {
            segment: SegmentChoice::Auto,
            ..Preparation::default()
        };
        let steps = prepare(&mut kept, &auto);
        // From the sample before 600; the last change is at 890, fifty more follow.
        assert!(steps[0].text.contains("59.900 to 94.100 s"), "{steps:?}");
        let segment = &kept.segments[0];
        assert_eq!((segment.start, segment.len()), (59_900_000_000, 342));
        assert_eq!(segment.inputs[0], inputs[599..941]);
        assert_eq!(segment.outputs[0], outputs[599..941]);
        // Steps far apart are one part.
        let inputs = [square(1000, 200), vec![1.0; 600]].concat();
        let mut kept = record(inputs.clone(), response(&inputs));
        prepare(&mut kept, &auto);
        assert_eq!(kept.samples(), 1201 - 199);
        // One in which it always moves is kept whole.
        let inputs = noise(1, 1000);
        let mut kept = record(inputs.clone(), response(&inputs));
        prepare(&mut kept, &auto);
        assert!(kept.samples() > 990);
    }

    #[test]
    fn a_mean_or_a_line_is_taken_away_and_told() {
        let wave = |k: usize| f64::from(u8::from(k.is_multiple_of(2)));
        let drifting: Vec<f64> = (0..1000).map(|k| wave(k) + 3.0 + 0.02 * k as f64).collect();
        let waves: Vec<f64> = (0..1000).map(wave).collect();
        for (trend, left, text) in [
            (Trend::Mean, 10.0, "y: its mean 13.4900 is subtracted"),
            (
                Trend::Line,
                0.51,
                "y: its mean 13.4900 and its slope 0.2000 per s are subtracted",
            ),
        ] {
            let mut prepared = record(waves.clone(), drifting.clone());
            let asked = Preparation {
                trend,
                ..Preparation::default()
            };
            let steps = prepare(&mut prepared, &asked);
            assert_eq!((steps.len(), steps[1].text.as_str()), (2, text));
            let segment = &prepared.segments[0];
            let mean: f64 = segment.outputs[0].iter().sum::<f64>() / 1000.0;
            assert!(mean.abs() < 1e-12, "{mean}");
            let most = segment.outputs[0]
                .iter()
                .map(|it| it.abs())
                .fold(0.0, f64::max);
            assert!((most / left - 1.0).abs() < 0.06, "{most}");
        }
    }

    #[test]
    fn a_record_without_dynamics_is_refused() {
        let says = |inputs: Vec<f64>, outputs: Vec<f64>| {
            without_dynamics(&record(inputs, outputs), false, false)
        };
        let moving = noise(1, 100);
        let still = says(vec![3.2; 100], moving.clone()).unwrap();
        assert!(
            still.starts_with("u is constant (3.2 in all 100"),
            "{still}"
        );
        let still = says(moving.clone(), vec![-1.0; 100]).unwrap();
        assert!(still.starts_with("y is constant (-1 in all 100"), "{still}");
        let scaled: Vec<f64> = moving.iter().map(|u| 7.0 - 2.5 * u).collect();
        let scaled = says(moving.clone(), scaled).unwrap();
        assert!(
            scaled.starts_with("y is u times -2.500000 plus 7.000000"),
            "{scaled}"
        );
        let nearly: Vec<f64> = moving
            .iter()
            .zip(noise(2, 100))
            .map(|(u, e)| u + 1e-6 * e)
            .collect();
        assert_eq!(says(moving, nearly), None);
    }

    #[test]
    fn zeros_go_in_front_of_each_segment() {
        let mut padded = record(vec![1.0, 2.0], vec![3.0, 4.0]);
        let asked = Preparation {
            prewindow: 2,
            ..Preparation::default()
        };
        prepare(&mut padded, &asked);
        assert_eq!(padded.segments[0].inputs[0], [0.0, 0.0, 1.0, 2.0]);
        assert_eq!(padded.segments[0].outputs[0], [0.0, 0.0, 3.0, 4.0]);
        assert_eq!(padded.segments[0].start, -200_000_000);
    }
}
