//! Windows of a spectral estimate: half-overlapping Hann tapers in several lengths.
//!
//! ```text
//! t_n = w_n e^(-jwTn) - mean,   w_n = (1 - cos(2 pi n / L)) / 2,   n = 0 ... L-1
//! ```
//! The mean of a taper is subtracted from the taper; this has the same effect as subtracting the mean of each segment. Long windows resolve low
//! frequencies, short windows average more often (Tischler and Remple, *Aircraft and Rotorcraft System Identification*, 2nd ed., 2012, ch. 10).
//! Source of the averages: Welch, *IEEE Trans. Audio Electroacoust.* 15, 1967.

use std::f64::consts::{PI, TAU};

use planesman_linear::Complex;

use crate::error::{IdentificationError, Result};

/// Minimum number of segments of the longest window for one input, and the number of additional segments for each further input.
const SEGMENTS: usize = 5;
const SEGMENTS_PER_INPUT: usize = 2;
/// The shortest window, samples; the longest window is at least as long, and halving ends here.
const LEAST: usize = 16;
const SHORTEST: usize = 64;
/// Maximum number of window lengths; each is half of the previous one.
const LENGTHS: usize = 5;
/// Minimum number of cycles of a frequency in the longest window, and in a shorter one: a response that falls like 1/w has a relative error
/// of `(0.58 / cycles)^2`.
const CYCLES: f64 = 2.0;
const CYCLES_OF_SHORTER: f64 = 10.0;
/// Frequencies per decade, their maximum number, and the highest as a share of half the sampling rate.
const PER_DECADE: f64 = 40.0;
const FREQUENCIES: usize = 160;
const HIGHEST: f64 = 0.9;

/// Lengths of windows, samples, longest first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Windows(pub Vec<usize>);

impl Windows {
    /// Chooses window lengths for records of these lengths and this many inputs: the longest window has at least five segments.
    ///
    /// # Errors
    /// [`IdentificationError::Record`]: too few samples.
    pub fn of(records: &[usize], inputs: usize) -> Result<Self> {
        let segments = SEGMENTS + SEGMENTS_PER_INPUT * inputs.saturating_sub(1);
        let fits = |length: usize| {
            let count = records.iter().map(|it| starts(*it, length).count());
            count.sum::<usize>() >= segments
        };
        let longest = records.iter().copied().max().unwrap_or_default();
        let (mut fitting, mut too_long) = (LEAST, longest + 1);
        if !fits(fitting) {
            let samples: usize = records.iter().sum();
            return Err(IdentificationError::Record(format!(
                "{samples} samples are too few for a frequency response, which needs {segments} windows of {LEAST} samples. Record for longer"
            )));
        }
        while too_long - fitting > 1 {
            let middle = usize::midpoint(fitting, too_long);
            match fits(middle) {
                true => fitting = middle,
                false => too_long = middle,
            }
        }
        let halved = std::iter::successors(Some(fitting - fitting % 2), |it| {
            let half = it / 4 * 2;
            (half >= SHORTEST).then_some(half)
        });
        Ok(Self(halved.take(LENGTHS).collect()))
    }

    /// Frequencies, rad/s, evenly spaced on a logarithmic scale, from two cycles in the longest window to nine tenths of half the sampling
    /// rate.
    #[must_use]
    pub fn frequencies(&self, sample_time: f64) -> Vec<f64> {
        let longest = self.0.first().copied().unwrap_or(LEAST);
        let lowest = CYCLES * TAU / (longest as f64 * sample_time);
        let ratio = (HIGHEST * PI / sample_time / lowest).max(1.0);
        let count = (PER_DECADE * libm::log10(ratio)).ceil().max(1.0) as usize;
        let count = count.min(FREQUENCIES);
        (0..=count)
            .map(|i| lowest * libm::pow(ratio, i as f64 / count as f64))
            .collect()
    }

    /// The windows suitable for a frequency, `angle` rad per sample.
    pub(super) fn holding(&self, angle: f64) -> impl Iterator<Item = usize> {
        let cycles = |place: usize| {
            if place == 0 {
                CYCLES
            } else {
                CYCLES_OF_SHORTER
            }
        };
        let each = self.0.iter().enumerate();
        let holds = move |(place, length): &(usize, &usize)| {
            angle * **length as f64 >= cycles(*place) * TAU * (1.0 - 1e-9)
        };
        each.filter(holds).map(|(_, length)| *length)
    }
}

/// The first samples of a window's segments in a record of this many samples.
pub(super) fn starts(samples: usize, length: usize) -> impl Iterator<Item = usize> {
    let last = (samples + 1).saturating_sub(length);
    (0..last).step_by((length / 2).max(1))
}

/// A taper at one frequency.
pub(super) struct Taper {
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Taper {
    /// A taper of this length, at `angle` rad per sample.
    pub(super) fn new(length: usize, angle: f64) -> Self {
        let count = length as f64;
        let at = |n: usize| {
            let window = 0.5 - 0.5 * libm::cos(TAU * n as f64 / count);
            let (sin, cos) = libm::sincos(angle * n as f64);
            (window * cos, -window * sin)
        };
        let (mut re, mut im): (Vec<f64>, Vec<f64>) = (0..length).map(at).unzip();
        for part in [&mut re, &mut im] {
            let mean = part.iter().sum::<f64>() / count;
            part.iter_mut().for_each(|it| *it -= mean);
        }
        Self { re, im }
    }

    pub(super) fn len(&self) -> usize {
        self.re.len()
    }

    /// The sum of the taper's squares.
    pub(super) fn energy(&self) -> f64 {
        let squares = self.re.iter().chain(&self.im).map(|it| it * it);
        squares.sum()
    }

    /// The tapered transform of a signal that begins at a given sample.
    pub(super) fn transform(&self, signal: &[f64], start: usize) -> Complex<f64> {
        let segment = &signal[start..start + self.len()];
        let sum = |part: &[f64]| -> f64 { part.iter().zip(segment).map(|(t, x)| t * x).sum() };
        Complex::new(sum(&self.re), sum(&self.im))
    }

    /// Adds the taper times a factor to a sequence from a sample on.
    pub(super) fn add_to(&self, sequence: &mut [Complex<f64>], start: usize, factor: Complex<f64>) {
        let segment = &mut sequence[start..start + self.len()];
        for ((it, re), im) in segment.iter_mut().zip(&self.re).zip(&self.im) {
            *it += factor * Complex::new(*re, *im);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use planesman_linear::ComplexFunctions as _;

    #[test]
    fn the_longest_window_has_five_segments_and_each_next_is_half_as_long() {
        let windows = Windows::of(&[3000], 1).unwrap();
        assert_eq!(windows.0, vec![1000, 500, 250, 124]);
        assert_eq!(
            starts(3000, 1000).collect::<Vec<_>>(),
            [0, 500, 1000, 1500, 2000]
        );
        // Two records of which neither has five.
        assert_eq!(Windows::of(&[1500, 1500], 1).unwrap().0[0], 750);
        assert!(Windows::of(&[40], 1).is_err());
        let frequencies = windows.frequencies(0.01);
        assert!((frequencies[0] - 2.0 * TAU / 10.0).abs() < 1e-12);
        assert!((frequencies[frequencies.len() - 1] - 90.0 * PI).abs() < 1e-9);
    }

    #[test]
    fn a_constant_has_no_transform() {
        let taper = Taper::new(50, 0.3);
        assert!(taper.transform(&[7.0; 60], 4).modulus() < 1e-12);
    }
}
