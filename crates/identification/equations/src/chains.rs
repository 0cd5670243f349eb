//! Chains of integrators with one denominator. Between two stamps the inputs are constant or linear and the equations are linear: each step
//! is the exponential of their matrix, by its series to rounding error.

use crate::simulation::{Between, Run, Track};

/// Terms of the series of a matrix exponential, and the largest norm of the matrix for which they are exact to rounding.
const TERMS: usize = 14;
const NORM: f64 = 0.5;
/// Maximum number of parts of an interval; samples contain no information on faster poles.
const PARTS: f64 = 2000.0;

/// The values of a signal over an interval: at its beginning, and its slope per s.
type Piece = (f64, f64);

/// A signal on each interval between two stamps of a run.
pub(crate) struct Signal<'a> {
    pub(crate) track: &'a Track,
    pub(crate) between: Between,
    pub(crate) reference: f64,
    /// The value before the first sample.
    pub(crate) before: f64,
    pub(crate) delay: f64,
}

impl Signal<'_> {
    pub(crate) fn at(&self, time: f64) -> Piece {
        let time = time - self.delay;
        let Track { times, values } = self.track;
        // A stamp that is a sample's own, but for rounding, has that sample.
        let count = times.partition_point(|it| *it <= time + 1e-12 * time.abs().max(1.0));
        let Some(k) = count.checked_sub(1) else {
            return (self.before - self.reference, 0.0);
        };
        match (self.between, times.get(k + 1)) {
            (Between::Lines, Some(next)) => {
                let slope = (values[k + 1] - values[k]) / (next - times[k]);
                (
                    values[k] + slope * (time - times[k]) - self.reference,
                    slope,
                )
            }
            _ => (values[k] - self.reference, 0.0),
        }
    }

    fn stamps(&self) -> impl Iterator<Item = f64> + '_ {
        self.track.times.iter().map(|it| it + self.delay)
    }
}

/// Chains of integrators with one denominator: driven by the signal, by an impulse, and by the output of both.
pub(crate) struct Chains<'a> {
    pub(crate) d: &'a [f64],
    pub(crate) b: &'a [f64],
    pub(crate) m: &'a [f64],
    /// Whether the third chain is computed.
    pub(crate) with_slopes: bool,
}

impl Chains<'_> {
    fn chains(&self) -> usize {
        if self.with_slopes { 3 } else { 2 }
    }

    /// `A z` of the chains, then of the signal and its slope.
    fn derivative(&self, z: &[f64], to: &mut [f64]) {
        let n = self.d.len();
        let chains = self.chains();
        let (signal, slope) = (z[chains * n], z[chains * n + 1]);
        let dot = |of: &[f64], z: &[f64]| of.iter().zip(z).map(|(a, b)| a * b).sum::<f64>();
        let output = dot(self.b, &z[..n]) + dot(self.m, &z[n..2 * n]);
        for (chain, driven) in [signal, 0.0, output].into_iter().take(chains).enumerate() {
            let of = &z[chain * n..(chain + 1) * n];
            let last = driven - dot(self.d, of);
            to[chain * n..(chain + 1) * n - 1].copy_from_slice(&of[1..]);
            to[(chain + 1) * n - 1] = last;
        }
        to[chains * n] = slope;
        to[chains * n + 1] = 0.0;
    }

    /// The largest rate of motion, 1/s.
    fn rate(&self) -> f64 {
        let n = self.d.len();
        let powers = self.d.iter().enumerate();
        let bounds = powers.map(|(k, d)| libm::pow(n as f64 * d.abs(), 1.0 / (n - k) as f64));
        bounds.fold(0.0, f64::max)
    }

    /// The states `xi, psi, eta` at each output's stamp of a run; `None` if they overflow.
    pub(crate) fn through(
        &self,
        run: &Run,
        signal: &Signal<'_>,
        each: &mut dyn FnMut(usize, &[f64]),
    ) -> Option<()> {
        let n = self.d.len();
        let size = self.chains() * n + 2;
        let times = &run.outputs[0].times;
        let end = run.end();
        let mut stamps: Vec<f64> = times.iter().copied().chain(signal.stamps()).collect();
        stamps.retain(|it| (0.0..=end).contains(it));
        stamps.push(0.0);
        stamps.sort_by(f64::total_cmp);
        stamps.dedup();
        let mut z = vec![0.0; size];
        z[2 * n - 1] = 1.0;
        let rate = self.rate();
        let (mut term, mut next) = (z.clone(), z.clone());
        let mut number = 0;
        for (k, now) in stamps.iter().enumerate() {
            (z[size - 2], z[size - 1]) = signal.at(*now);
            if times.get(number) == Some(now) {
                each(number, &z);
                number += 1;
            }
            let Some(after) = stamps.get(k + 1) else {
                break;
            };
            let h = after - now;
            let parts = (rate * h / NORM).ceil().max(1.0);
            if parts.is_nan() || parts > PARTS {
                return None;
            }
            let part = h / parts;
            for _ in 0..parts as usize {
                term.copy_from_slice(&z);
                for order in 1..=TERMS {
                    self.derivative(&term, &mut next);
                    let factor = part / order as f64;
                    for ((term, next), z) in term.iter_mut().zip(&next).zip(&mut z) {
                        *term = factor * next;
                        *z += *term;
                    }
                }
            }
            if !z[0].is_finite() {
                return None;
            }
        }
        Some(())
    }
}
