//! A record whose truth is known: three pulses into a third-order plant with a zero at z = 1, at 20 Hz.

use planesman_identification::{filter, with_noise};

/// The interval between samples, s.
pub(crate) const SAMPLE_TIME: f64 = 0.05;
/// The plant's denominator and numerator, powers of `q^-1`.
pub(crate) const A: [f64; 4] = [1.0, -2.828096481, 2.662806429, -0.8346755128];
pub(crate) const B: [f64; 4] = [0.0, 0.1214921871, -0.2366258725, 0.1151336854];

/// The input.
pub(crate) fn pulses() -> Vec<f64> {
    let mut pulses = vec![0.0; 200];
    for (span, level) in [(20..40, 0.2), (60..80, -0.2), (100..120, 0.1)] {
        pulses[span].fill(level);
    }
    pulses
}

/// The plant's output from rest.
pub(crate) fn clean() -> Vec<f64> {
    filter(&B, &A, &pulses())
}

/// The same with noise of a size, and a bias.
pub(crate) fn measured(seed: u32, noise: f64, bias: f64) -> Vec<f64> {
    let noisy = with_noise(&clean(), seed, noise);
    noisy.into_iter().map(|y| y + bias).collect()
}

/// The plant's next output from the outputs and inputs before it, for a loop that is closed.
pub(crate) fn next(inputs: &[f64], outputs: &[f64]) -> f64 {
    let past = |coefficients: &[f64], values: &[f64]| -> f64 {
        let pairs = coefficients[1..].iter().zip(values.iter().rev());
        pairs.map(|(c, v)| c * v).sum()
    };
    past(&B, inputs) - past(&A, outputs)
}
