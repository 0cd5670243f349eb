//! The plant behind the logs, integrated here by Runge and Kutta's method, and inputs that excite it.

use std::fmt::Write as _;

use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

/// Seconds from sample to sample.
pub(crate) const STEP: f64 = 0.05;

/// The samples of a usual log.
pub(crate) const SAMPLES: usize = 2000;

/// The poles of `3/(s^2 + 1.2 s + 4)`: real part and magnitude of the imaginary part.
pub(crate) const POLE: (f64, f64) = (-0.6, 1.907_878_402_833_891);

/// Its steady-state gain.
pub(crate) const GAIN: f64 = 0.75;

/// Steps of the integration within a sample.
const SUBSTEPS: usize = 20;

/// Numbers of a normal distribution, nearly: mean 0, variance 1.
pub(crate) fn noise(seed: u64, count: usize) -> Vec<f64> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut one = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    (0..count).map(|_| one()).collect()
}

/// An input of plus and minus one, that may change every ten samples.
pub(crate) fn prbs(seed: u64, samples: usize) -> Vec<f64> {
    let levels = noise(seed, samples / 10 + 1);
    (0..samples).map(|k| levels[k / 10].signum()).collect()
}

/// The response from rest of `num / (s^2 + damping s + stiffness)` to an input held between samples.
pub(crate) fn second_order(
    [num, damping, stiffness]: [f64; 3],
    step: f64,
    input: &[f64],
) -> Vec<f64> {
    let h = step / SUBSTEPS as f64;
    let (mut y, mut v) = (0.0, 0.0);
    let mut response = Vec::with_capacity(input.len());
    for u in input {
        response.push(y);
        let f = |y: f64, v: f64| (v, num * u - damping * v - stiffness * y);
        for _ in 0..SUBSTEPS {
            let k1 = f(y, v);
            let k2 = f(y + h / 2.0 * k1.0, v + h / 2.0 * k1.1);
            let k3 = f(y + h / 2.0 * k2.0, v + h / 2.0 * k2.1);
            let k4 = f(y + h * k3.0, v + h * k3.1);
            y += h / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
            v += h / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
        }
    }
    response
}

/// Input and measured output of `3/(s^2 + 1.2 s + 4)`, white noise of 0.005 on the output.
pub(crate) fn log(seed: u64, samples: usize) -> (Vec<f64>, Vec<f64>) {
    let u = prbs(seed, samples);
    let y = second_order([3.0, 1.2, 4.0], STEP, &u);
    let y = y.iter().zip(noise(seed + 1000, samples));
    (u, y.map(|(y, e)| y + 0.005 * e).collect())
}

/// A table with a header and rows of cells that are written already.
pub(crate) fn table(header: &str, rows: impl Iterator<Item = (String, f64, f64)>) -> String {
    let mut text = format!("{header}\n");
    for (time, u, y) in rows {
        writeln!(text, "{time},{u},{y:.6}").unwrap();
    }
    text
}
