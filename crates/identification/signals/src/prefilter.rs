//! A frequency band: the same Butterworth filters for every signal, so that the model between them does not change.
//!
//! Each edge is a causal filter of second order (bilinear transform with the edge preserved): -3 dB at the edge, 40 dB per decade beyond.
//! The filters begin in the steady state of the first sample, and their settling time is left out.

use planesman_record::{Record, filter};

/// The time, in parts of 1/f, until the transient of a filter with the edge f has fallen to a twentieth.
const SETTLING_PERIODS: f64 = 0.7;

/// Edges of a band, Hz: 0 and infinity if open.
pub type Band = (f64, f64);

/// The reason why a record cannot be filtered to a band: its sampling rate does not reach an edge, or segments end before the filters have settled.
#[must_use]
pub fn unreachable(record: &Record, band: Band) -> Option<String> {
    let edges = edges(band);
    let highest = 0.5 / record.sample_time;
    if let Some(edge) = edges.iter().find(|edge| **edge >= highest) {
        return Some(format!(
            "the prefilter's edge {edge} Hz is not below half the sampling rate, {highest:.6} Hz"
        ));
    }
    let lead = lead(record, band);
    let longest = record.segments.iter().map(|it| it.len()).max();
    (longest.unwrap_or_default() <= 2 * lead).then(|| {
        format!(
            "the prefilter needs {:.6} s to settle, which is more than half of the longest segment",
            lead as f64 * record.sample_time
        )
    })
}

/// Filters every signal to the band; returns a sentence on the result.
pub(crate) fn prefilter(record: &mut Record, band: Band) -> String {
    let lead = lead(record, band);
    let low_pass = band
        .1
        .is_finite()
        .then(|| low_pass(band.1 * record.sample_time));
    let high_pass = (band.0 > 0.0).then(|| high_pass(band.0 * record.sample_time));
    for segment in &mut record.segments {
        segment.past.clear();
        for list in segment.inputs.iter_mut().chain(&mut segment.outputs) {
            let first = list.first().copied().unwrap_or_default();
            let mut values: Vec<f64> = list.iter().map(|value| value - first).collect();
            for (num, den) in low_pass.iter().chain(&high_pass) {
                values = filter(num, den, &values);
            }
            // The mean passes a low-pass filter only.
            let level = if high_pass.is_none() { first } else { 0.0 };
            *list = values.iter().map(|value| value + level).collect();
        }
        let lead = lead.min(segment.len());
        *segment = segment.part(lead, segment.len(), record.sample_time);
    }
    record.segments.retain(|it| !it.is_empty());
    let passed = match (high_pass, low_pass) {
        (Some(_), Some(_)) => format!("frequencies from {} to {} Hz pass", band.0, band.1),
        (Some(_), None) => format!(
            "frequencies above {} Hz pass: the steady-state gain is extrapolated",
            band.0
        ),
        _ => format!("frequencies below {} Hz pass", band.1),
    };
    format!(
        "{passed}; the first {:.6} s of each segment are left out, because the filters settle in this time",
        lead as f64 * record.sample_time
    )
}

fn edges((low, high): Band) -> Vec<f64> {
    let is_edge = |edge: &f64| *edge > 0.0 && edge.is_finite();
    [low, high].into_iter().filter(is_edge).collect()
}

/// Samples until the slower of the filters has settled.
fn lead(record: &Record, band: Band) -> usize {
    let lowest = edges(band).into_iter().fold(f64::INFINITY, f64::min);
    (SETTLING_PERIODS / (lowest * record.sample_time)).ceil() as usize
}

type Section = ([f64; 3], [f64; 3]);

/// Numerator and denominator in z^-1 for an edge in cycles per sample.
fn low_pass(edge: f64) -> Section {
    let (w, scale, den) = section(edge);
    ([1.0, 2.0, 1.0].map(|c| c * w * w * scale), den)
}

/// The same.
fn high_pass(edge: f64) -> Section {
    let (_, scale, den) = section(edge);
    ([1.0, -2.0, 1.0].map(|c| c * scale), den)
}

fn section(edge: f64) -> (f64, f64, [f64; 3]) {
    let w = libm::tan(std::f64::consts::PI * edge);
    let damped = std::f64::consts::SQRT_2 * w;
    let scale = 1.0 / (1.0 + damped + w * w);
    let den = [
        1.0,
        2.0 * (w * w - 1.0) * scale,
        (1.0 - damped + w * w) * scale,
    ];
    (w, scale, den)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The amplitude of a sine behind the band, of its amplitude before.
    fn passed(frequency: f64, band: Band) -> f64 {
        let sine: Vec<f64> = (0..4000)
            .map(|k| libm::sin(std::f64::consts::TAU * frequency * f64::from(k) * 0.01))
            .collect();
        let mut record =
            Record::of_run(0.01, vec![("u", sine.clone())], vec![("y", sine)]).unwrap();
        assert_eq!(unreachable(&record, band), None);
        prefilter(&mut record, band);
        let values = &record.segments[0].outputs[0];
        let squares: f64 = values.iter().map(|v| v * v).sum();
        (2.0 * squares / values.len() as f64).sqrt()
    }

    #[test]
    fn at_its_edges_a_band_passes_3_db_less_and_a_decade_away_40() {
        let (low, high) = (0.5, 10.0);
        for (frequency, expected) in [(low, 0.5_f64.sqrt()), (2.0, 1.0), (high, 0.5_f64.sqrt())] {
            let found = passed(frequency, (low, high));
            assert!((found - expected).abs() < 0.02, "{frequency} Hz: {found}");
        }
        assert!((passed(0.5, (5.0, f64::INFINITY)) - 0.01).abs() < 0.002);
        assert!((passed(10.0, (0.0, 1.0)) - 0.01).abs() < 0.002);
    }

    #[test]
    fn an_edge_that_the_data_does_not_reach_is_refused() {
        let values = vec![0.0; 100];
        let record =
            Record::of_run(0.01, vec![("u", values.clone())], vec![("y", values)]).unwrap();
        assert!(
            unreachable(&record, (0.0, 50.0))
                .unwrap()
                .contains("half the sampling rate")
        );
        assert!(
            unreachable(&record, (1.0, 10.0))
                .unwrap()
                .contains("to settle")
        );
        assert_eq!(unreachable(&record, (2.0, 10.0)), None);
    }
}
