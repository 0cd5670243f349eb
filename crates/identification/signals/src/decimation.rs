//! Decimates a record that is sampled much faster than its outputs move.
//!
//! An output moves that slowly if its autocovariance stays above nine tenths for a hundred samples. The poles of a model then lie so close
//! to z = 1 that rounding and noise determine them. Every sample of the new record is a mean: an input is averaged over the interval in which it
//! acts, an output over the same number of samples about its instant, so that neither is delayed.

use planesman_record::{Record, Segment};
use planesman_text::setting;

/// The share of the autocovariance that defines how long an output stays the same.
const AUTOCOVARIANCE_SHARE: f64 = 0.9;
/// The number of samples in that time above which a record is decimated, and the number kept.
const SLOW_SAMPLES: usize = 100;
const SAMPLES_KEPT: usize = 20;

/// Decimates a record if all its outputs move slowly; returns a sentence on the result.
pub(crate) fn decimate(record: &mut Record) -> Option<String> {
    let longest = record.segments.iter().max_by_key(|it| it.len())?;
    let stays = longest.outputs.iter().filter_map(|it| stays(it)).min()?;
    if stays < SLOW_SAMPLES {
        return None;
    }
    // An odd number, whose middle is a sample.
    let factor = (stays / SAMPLES_KEPT - 1) | 1;
    let before = 1.0 / record.sample_time;
    record.segments = (record.segments.iter())
        .map(|it| means(it, factor, record.sample_time))
        .filter(|it| !it.is_empty())
        .collect();
    record.sample_time *= factor as f64;
    Some(format!(
        "{} changes little over {stays} samples (90 % of its autocovariance remains): means of {factor} samples are used, {:.6} samples per second ({} keeps all samples)",
        record.outputs.join(", "),
        1.0 / record.sample_time,
        setting("rate", format!("{before:.6}"))
    ))
}

/// The number of samples over which the autocovariance stays above [`AUTOCOVARIANCE_SHARE`] of its value at a lag of one sample (which white noise
/// does not affect); at most a tenth of the record. A straight line, the response of an integrator to the mean of its input, is removed first. `None`
/// if the values are constant.
fn stays(values: &[f64]) -> Option<usize> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let middle = (values.len().max(1) - 1) as f64 / 2.0;
    let line = values.iter().enumerate().map(|(k, value)| {
        let since = k as f64 - middle;
        (since * (value - mean), since * since)
    });
    let (along, size) = line.fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
    let slope = if size > 0.0 { along / size } else { 0.0 };
    let about: Vec<f64> = (values.iter().enumerate())
        .map(|(k, value)| value - mean - slope * (k as f64 - middle))
        .collect();
    let covariance = |lag: usize| -> f64 {
        let pairs = about.iter().zip(about.get(lag..).unwrap_or_default());
        pairs.map(|(now, later)| now * later).sum()
    };
    let first = covariance(1);
    let most = values.len() / 10;
    if !(first > 0.0 && first.is_finite()) {
        return None;
    }
    // It falls from lag to lag as long as it is this large.
    let (mut above, mut below) = (1, most.max(1));
    while above + 1 < below {
        let lag = usize::midpoint(above, below);
        match covariance(lag) > AUTOCOVARIANCE_SHARE * first {
            true => above = lag,
            false => below = lag,
        }
    }
    Some(above)
}

fn means(segment: &Segment, factor: usize, sample_time: f64) -> Segment {
    let half = factor / 2;
    let count = segment.len().saturating_sub(2 * half) / factor;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / factor as f64;
    let from = |list: &Vec<f64>, first: usize| -> Vec<f64> {
        (0..count)
            .map(|k| mean(&list[first + k * factor..first + (k + 1) * factor]))
            .collect()
    };
    let later = (half as f64 * sample_time * 1e9).round() as i64;
    // Windows of an input begin `half` behind the outputs'.
    let past = |number: usize, input: &Vec<f64>| -> Vec<f64> {
        let before = segment.past.get(number).map_or(&[][..], Vec::as_slice);
        let known = [before, &input[..half.min(input.len())]].concat();
        let windows = known.len() / factor;
        (known[known.len() - windows * factor..].chunks(factor))
            .map(mean)
            .collect()
    };
    let inputs = segment.inputs.iter().enumerate();
    Segment {
        source: segment.source,
        past: inputs.map(|(number, input)| past(number, input)).collect(),
        start: segment.start.saturating_add(later),
        inputs: segment.inputs.iter().map(|it| from(it, half)).collect(),
        outputs: segment.outputs.iter().map(|it| from(it, 0)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use planesman_record::{filter, with_noise};

    use super::*;

    fn record(sample_time: f64, samples: usize) -> Record {
        let inputs: Vec<f64> = (0..samples)
            .map(|k| f64::from(u8::from((k / 3000).is_multiple_of(2))))
            .collect();
        let decay = libm::exp(-sample_time);
        let outputs = with_noise(
            &filter(&[0.0, 1.0 - decay], &[1.0, -decay], &inputs),
            3,
            0.01,
        );
        Record::of_run(sample_time, vec![("u", inputs)], vec![("y", outputs)]).unwrap()
    }

    #[test]
    fn means_are_taken_of_a_record_sampled_a_thousand_times_in_a_time_constant() {
        let mut fast = record(0.001, 20_000);
        let before = fast.clone();
        let step = decimate(&mut fast).unwrap();
        assert!(step.contains("means of"), "{step}");
        let factor = (fast.sample_time / 0.001).round() as usize;
        assert!(factor >= 5 && factor % 2 == 1, "{factor}");
        let (old, new) = (&before.segments[0], &fast.segments[0]);
        assert_eq!(new.start, (factor / 2) as i64 * 1_000_000);
        // An output's window lies about its instant, an input's behind it.
        let about = |k: usize| &old.outputs[0][k * factor..(k + 1) * factor];
        let behind = |k: usize| &old.inputs[0][factor / 2 + k * factor..][..factor];
        let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
        for k in [0, 7, new.len() - 1] {
            assert_eq!(new.outputs[0][k], mean(about(k)));
            assert_eq!(new.inputs[0][k], mean(behind(k)));
        }
    }

    #[test]
    fn a_record_sampled_as_usual_is_left_alone() {
        let mut usual = record(0.05, 2000);
        let before = usual.clone();
        assert!(decimate(&mut usual).is_none());
        assert_eq!(usual, before);
        let mut still = Record::of_run(0.1, vec![], vec![("y", vec![1.0; 2000])]).unwrap();
        assert!(decimate(&mut still).is_none());
    }
}
