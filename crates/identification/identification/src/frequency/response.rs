//! Spectra, frequency response, coherence and random errors at chosen frequencies.
//!
//! With transforms Z, X, Y of instruments, inputs and output over segments s, each weighted by c_s,
//! ```text
//! S_zx = sum c_s conj(Z) X',   S_zy = sum c_s conj(Z) Y,   H = S_zx^-1 S_zy
//! ```
//! In open loop the instruments are the inputs; several inputs are conditioned on each other (Bendat and Piersol, *Random Data*, 4th ed.,
//! 2010, ch. 7). In a closed loop they are the references: `H = S_ry / S_ru`, which noise circulating in the loop does not bias.
//!
//! **Transforms** are evaluated at the frequencies themselves, not at the bins of a fast transform.
//!
//! **Composite windows** (Tischler and Remple 2012, ch. 10): the spectra of each window length are averaged with the squares of the weights
//! `(e / e_least)^-4`, where e is the random error of that length alone.
//!
//! **Errors.** H is a weighted sum of the output's samples, `H = sum g_n y_n`. With noise v on the output, of spectrum S_v near the
//! frequency, `var H = S_v sum |g|^2`. This accounts for overlap, composite windows, and a chirp that passes a frequency only once. S_v is the
//! spectrum of the output unexplained by H, `S_ee / (1 - q)`, with q the share of the noise that H absorbs. For one input this is
//! ```text
//! e = sqrt(1 - g2) / (|g| sqrt(2 n_d)),   n_d = 1/q - 1
//! ```
//! (Bendat and Piersol, eq. 9.90) for magnitude (relative) and phase (rad).

use nalgebra::{DMatrix, DVector};
use planesman_linear::{Complex, ComplexFunctions as _};

use super::windows::{Taper, Windows, starts};
use crate::error::{IdentificationError, Result};
use planesman_parallel::on_all_cores;

/// A window length is left out if its share of the averages is below this value.
const NEXT_TO_NOTHING: f64 = 1e-3;
/// The smallest random error assigned to a window length, so that noise-free data has weights.
const LEAST_ERROR: f64 = 1e-9;
/// dB of a relative change, `20 / ln 10`.
pub(crate) const DECIBEL: f64 = 8.685_889_638_065_037;

/// The columns of one record, all of the same length.
#[derive(Clone, Debug)]
pub struct Columns<'a> {
    /// The inputs.
    pub inputs: Vec<&'a [f64]>,
    /// The output.
    pub output: &'a [f64],
    /// References of the loop around the inputs, as many as there are inputs; empty in open loop.
    pub references: Vec<&'a [f64]>,
}

/// Settings that override the defaults from the data.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Frequencies, rad/s; `None` for [`Windows::frequencies`].
    pub frequencies: Option<Vec<f64>>,
    /// Lengths of the windows, samples; `None` for [`Windows::of`].
    pub windows: Option<Windows>,
}

/// The response at one frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// The frequency, rad/s.
    pub omega: f64,
    /// The response to each input, output unit per input unit.
    pub values: Vec<Complex<f64>>,
    /// Standard deviations of each real part, and of each imaginary part.
    pub deviations: Vec<f64>,
    /// The coherence of each input, 0 to 1. With several inputs it is the partial coherence, without the others' share. In a closed loop it
    /// is the smaller of the coherences from the references to the input and to the output.
    pub coherences: Vec<f64>,
    /// The multiple coherence of all inputs together; in a closed loop the smallest of [`Point::coherences`].
    pub coherence: f64,
    /// The equivalent number of independent averages.
    pub averages: f64,
    /// The spectrum of each input, expressed as the variance of white noise with the same density, input unit squared.
    pub inputs: Vec<f64>,
    /// The spectrum of the noise on the output, expressed as the variance of white noise with the same density, output unit squared.
    pub noise: f64,
    /// The mean length of the windows, samples.
    pub window: f64,
}

impl Point {
    /// The magnitude of the response to an input, dB, and its standard deviation.
    #[must_use]
    pub fn decibels(&self, input: usize) -> (f64, f64) {
        let size = self.values[input].modulus();
        (
            DECIBEL * libm::log(size),
            DECIBEL * self.deviations[input] / size,
        )
    }

    /// The standard deviation of the phase of the response to an input, rad.
    #[must_use]
    pub fn phase_deviation(&self, input: usize) -> f64 {
        self.deviations[input] / self.values[input].modulus()
    }

    /// Number of standard deviations in half a 95 % interval: from Student's distribution, with twice as many degrees of freedom as there
    /// are averages beyond the inputs, from which the noise is estimated (Abramowitz and Stegun, eq. 26.7.5).
    #[must_use]
    pub fn sigmas_95(&self) -> f64 {
        let x = crate::structure::SIGMAS_95;
        let freedom = 2.0 * self.freedom();
        let odd = |coefficients: [f64; 4]| {
            let powers = [x, x.powi(3), x.powi(5), x.powi(7)];
            powers
                .iter()
                .zip(coefficients)
                .map(|(p, c)| p * c)
                .sum::<f64>()
        };
        x + odd([1.0, 1.0, 0.0, 0.0]) / (4.0 * freedom)
            + odd([3.0, 16.0, 5.0, 0.0]) / (96.0 * freedom.powi(2))
            + odd([-15.0, 17.0, 19.0, 3.0]) / (384.0 * freedom.powi(3))
    }

    /// The coherence that noise alone exceeds in one of twenty estimates: `1 - 0.05^(1/(n - 1))` for n averages of one input (Carter, Knapp
    /// and Nuttall, *IEEE Trans. Audio Electroacoust.* 21, 1973).
    #[must_use]
    pub fn coherence_by_chance(&self) -> f64 {
        1.0 - libm::pow(0.05_f64, 1.0 / self.freedom())
    }

    /// Number of averages beyond the inputs.
    fn freedom(&self) -> f64 {
        (self.averages - self.values.len() as f64).max(1.0)
    }
}

/// A window length in the composite at one frequency.
struct Part {
    length: usize,
    /// The weight of each segment.
    weight: f64,
    /// Record and first sample of each segment, with the transforms of its instruments.
    segments: Vec<(usize, usize, Vec<Complex<f64>>)>,
}

/// The composite of all windows at one frequency.
struct Composite {
    parts: Vec<Part>,
    /// `S_zx^-1`.
    inverse: DMatrix<Complex<f64>>,
}

/// The spectra of some records.
pub struct Spectra<'a> {
    records: Vec<Columns<'a>>,
    sample_time: f64,
    /// Lengths of the windows.
    pub windows: Windows,
    /// The response at each frequency.
    pub points: Vec<Point>,
    composites: Vec<Composite>,
}

/// The transforms of one segment.
struct Segment {
    record: usize,
    start: usize,
    z: DVector<Complex<f64>>,
    x: DVector<Complex<f64>>,
    y: Complex<f64>,
}

/// Spectra of some segments.
struct Matrices {
    zz: DMatrix<Complex<f64>>,
    zx: DMatrix<Complex<f64>>,
    zy: DVector<Complex<f64>>,
    xx: DVector<f64>,
    yy: f64,
}

impl Matrices {
    fn of<'s>(inputs: usize, segments: impl Iterator<Item = (f64, &'s Segment)>) -> Self {
        let none = Complex::new(0.0, 0.0);
        let mut sums = Self {
            zz: DMatrix::from_element(inputs, inputs, none),
            zx: DMatrix::from_element(inputs, inputs, none),
            zy: DVector::from_element(inputs, none),
            xx: DVector::zeros(inputs),
            yy: 0.0,
        };
        for (weight, of) in segments {
            let z = of.z.map(|it| it.conj() * weight);
            sums.zz += &z * of.z.transpose();
            sums.zx += &z * of.x.transpose();
            sums.zy += &z * of.y;
            sums.xx += of.x.map(|it| weight * it.norm_sqr());
            sums.yy += weight * of.y.norm_sqr();
        }
        sums
    }

    /// The share of the output explained by the instruments, by all or by all except one: 0 to 1.
    fn told(&self, without: Option<usize>) -> f64 {
        let (zz, zy) = match without {
            None => (self.zz.clone(), self.zy.clone()),
            Some(at) => (
                self.zz.clone().remove_row(at).remove_column(at),
                self.zy.clone().remove_row(at),
            ),
        };
        share(zz, &zy, self.yy)
    }
}

/// The explained share, `S_zy* S_zz^-1 S_zy / S_yy`.
fn share(zz: DMatrix<Complex<f64>>, zy: &DVector<Complex<f64>>, yy: f64) -> f64 {
    if zy.is_empty() || yy <= 0.0 {
        return 0.0;
    }
    let told = zz.lu().solve(zy).map_or(0.0, |it| zy.dotc(&it).re);
    (told / yy).clamp(0.0, 1.0)
}

impl<'a> Spectra<'a> {
    /// The response of records, sampled every `sample_time` s.
    ///
    /// # Errors
    /// [`IdentificationError`]: columns of several lengths, as many references as there are no inputs, too few samples, inputs that
    /// have different lengths or do not move.
    pub fn new(records: Vec<Columns<'a>>, sample_time: f64, settings: &Settings) -> Result<Self> {
        let refused = |reason: &str| Err(IdentificationError::Record(reason.to_owned()));
        let inputs = records.first().map_or(0, |it| it.inputs.len());
        if inputs == 0 {
            return refused("there is no input");
        }
        for it in &records {
            let mut columns = it.inputs.iter().chain(&it.references);
            let is_one_length = columns.all(|column| column.len() == it.output.len());
            let is_paired = it.references.is_empty() || it.references.len() == inputs;
            if !is_one_length || !is_paired || it.inputs.len() != inputs {
                return refused(
                    "inputs, references and output of the records have different \
                    lengths",
                );
            }
        }
        let lengths: Vec<usize> = records.iter().map(|it| it.output.len()).collect();
        let windows = match &settings.windows {
            Some(given) => given.clone(),
            None => Windows::of(&lengths, inputs)?,
        };
        let frequencies = settings.frequencies.clone();
        let frequencies = frequencies.unwrap_or_else(|| windows.frequencies(sample_time));
        let mut spectra = Self {
            records,
            sample_time,
            windows,
            points: Vec::new(),
            composites: Vec::new(),
        };
        let found = on_all_cores(&frequencies, |omega| spectra.at(*omega));
        (spectra.points, spectra.composites) = found.into_iter().flatten().unzip();
        match spectra.points.is_empty() {
            true => refused("the inputs are constant, or identical"),
            false => Ok(spectra),
        }
    }

    /// The transforms of all records with a taper.
    fn segments(&self, taper: &Taper) -> Vec<Segment> {
        let mut segments = Vec::new();
        for (record, of) in self.records.iter().enumerate() {
            for start in starts(of.output.len(), taper.len()) {
                let all = |columns: &[&[f64]]| {
                    let each = columns.iter().map(|it| taper.transform(it, start));
                    DVector::from_vec(each.collect())
                };
                let x = all(&of.inputs);
                segments.push(Segment {
                    record,
                    start,
                    z: match of.references.is_empty() {
                        true => x.clone(),
                        false => all(&of.references),
                    },
                    x,
                    y: taper.transform(of.output, start),
                });
            }
        }
        segments
    }

    /// The windows suitable for a frequency in rad per sample: their segments, each with its weight in the mean, and the random error.
    fn weighed(&self, angle: f64) -> Vec<(Taper, Vec<Segment>, f64, f64)> {
        let inputs = self.records[0].inputs.len();
        let mut tried: Vec<(Taper, Vec<Segment>, f64, f64)> = Vec::new();
        for length in self.windows.holding(angle) {
            let taper = Taper::new(length, angle);
            let segments = self.segments(&taper);
            if segments.len() <= inputs {
                continue;
            }
            let weight = 1.0 / (segments.len() as f64 * taper.energy());
            let sums = Matrices::of(inputs, segments.iter().map(|it| (weight, it)));
            let told = sums.told(None).max(f64::MIN_POSITIVE);
            let averages = (segments.len() - inputs) as f64;
            let error = ((1.0 - told) / (2.0 * told * averages)).sqrt();
            tried.push((taper, segments, weight, error.max(LEAST_ERROR)));
        }
        let least = tried.iter().map(|it| it.3).fold(f64::INFINITY, f64::min);
        let of_length = |error: f64| (error / least).powi(-8);
        let all: f64 = tried.iter().map(|it| of_length(it.3)).sum();
        tried.retain(|it| of_length(it.3) > NEXT_TO_NOTHING * all);
        let all: f64 = tried.iter().map(|it| of_length(it.3)).sum();
        for it in &mut tried {
            it.2 *= of_length(it.3) / all;
        }
        tried
    }

    /// The response at a frequency; `None` if no window is suitable, or the inputs cannot be separated.
    fn at(&self, omega: f64) -> Option<(Point, Composite)> {
        let inputs = self.records[0].inputs.len();
        let tried = self.weighed(omega * self.sample_time);
        let weighted = || {
            let each = tried.iter();
            each.flat_map(|(_, segments, weight, _)| segments.iter().map(|it| (*weight, it)))
        };
        let sums = Matrices::of(inputs, weighted());
        let inverse = sums.zx.clone().try_inverse()?;
        let values = &inverse * &sums.zy;
        if values
            .iter()
            .any(|it| !(it.re.is_finite() && it.im.is_finite()))
        {
            return None;
        }
        let left = weighted().map(|(weight, of)| {
            let caused: Complex<f64> = of.x.iter().zip(&values).map(|(x, h)| x * h).sum();
            weight * (of.y - caused).norm_sqr()
        });
        let left: f64 = left.sum();
        let composite = Composite {
            parts: tried
                .iter()
                .map(|(taper, segments, weight, _)| Part {
                    length: taper.len(),
                    weight: *weight,
                    segments: segments
                        .iter()
                        .map(|it| (it.record, it.start, it.z.iter().copied().collect()))
                        .collect(),
                })
                .collect(),
            inverse,
        };
        // The sums of |g|^2, and the share of noise that the response takes up.
        let kernels = self.kernels(&composite, omega);
        let gram = |i: usize, j: usize| -> Complex<f64> {
            let pairs = kernels[i].iter().flatten().zip(kernels[j].iter().flatten());
            pairs.map(|(p, q)| p * q.conj()).sum()
        };
        let gram = DMatrix::from_fn(inputs, inputs, gram);
        // tr(S_zz^-1 S_zx G S_zx*), which in open loop is tr(G S_xx).
        let taken = sums
            .zz
            .clone()
            .lu()
            .solve(&(&sums.zx * &gram * sums.zx.adjoint()))?;
        let taken = taken.trace().re.clamp(f64::MIN_POSITIVE, 0.99);
        let noise = left / (1.0 - taken);
        let in_loop = !self.records[0].references.is_empty();
        let (coherences, coherence) = match in_loop {
            false => {
                let (all, rest) = (1.0 - left / sums.yy, |i| 1.0 - sums.told(Some(i)));
                let partial = |i| (1.0 - (1.0 - all) / rest(i)).clamp(0.0, 1.0);
                ((0..inputs).map(partial).collect(), all.clamp(0.0, 1.0))
            }
            true => {
                let to_output = sums.told(None);
                let to_input =
                    |i: usize| share(sums.zz.clone(), &sums.zx.column(i).into_owned(), sums.xx[i]);
                let each: Vec<f64> = (0..inputs).map(|i| to_output.min(to_input(i))).collect();
                let least = each.iter().copied().fold(1.0, f64::min);
                (each, least)
            }
        };
        let window = tried.iter().map(|(taper, segments, weight, _)| {
            taper.len() as f64 * weight * segments.len() as f64 * taper.energy()
        });
        let point = Point {
            omega,
            deviations: (0..inputs)
                .map(|i| (noise * gram[(i, i)].re / 2.0).max(0.0).sqrt())
                .collect(),
            values: values.iter().copied().collect(),
            coherences,
            coherence,
            averages: inputs as f64 / taken,
            inputs: sums.xx.iter().copied().collect(),
            noise,
            window: window.sum(),
        };
        Some((point, composite))
    }

    /// The weights g of the output's samples in the response, for each input and record.
    fn kernels(&self, of: &Composite, omega: f64) -> Vec<Vec<Vec<Complex<f64>>>> {
        let inputs = of.inverse.nrows();
        let none = |record: &Columns<'_>| vec![Complex::new(0.0, 0.0); record.output.len()];
        let mut kernels: Vec<Vec<Vec<_>>> = (0..inputs)
            .map(|_| self.records.iter().map(none).collect())
            .collect();
        for part in &of.parts {
            let taper = Taper::new(part.length, omega * self.sample_time);
            for (record, start, z) in &part.segments {
                let z = DVector::from_iterator(inputs, z.iter().map(|it| it.conj() * part.weight));
                let factors = &of.inverse * z;
                for (kernel, factor) in kernels.iter_mut().zip(factors.iter()) {
                    taper.add_to(&mut kernel[*record], *start, *factor);
                }
            }
        }
        kernels
    }

    /// The weight of each output sample in the response to the first input at point `at`, by record.
    #[must_use]
    pub fn kernel(&self, at: usize) -> Vec<Vec<Complex<f64>>> {
        self.kernels(&self.composites[at], self.points[at].omega)
            .swap_remove(0)
    }

    /// The response of other outputs to the first input at point `at`, with the same windows.
    #[must_use]
    pub fn of_other(&self, at: usize, outputs: &[Vec<f64>]) -> Complex<f64> {
        let (of, omega) = (&self.composites[at], self.points[at].omega);
        let inputs = of.inverse.nrows();
        let mut zy = DVector::from_element(inputs, Complex::new(0.0, 0.0));
        for part in &of.parts {
            let taper = Taper::new(part.length, omega * self.sample_time);
            for (record, start, z) in &part.segments {
                let y = taper.transform(&outputs[*record], *start);
                for (sum, z) in zy.iter_mut().zip(z) {
                    *sum += z.conj() * y * part.weight;
                }
            }
        }
        (&of.inverse * zy)[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const WINDOW: usize = 128;

    /// A chirp, a second input, and the output of 0.2/(q - 0.9) with a constant and something like noise.
    fn signals() -> [Vec<f64>; 3] {
        let of = |f: fn(f64) -> f64| (0..600).map(|k| f(f64::from(k))).collect::<Vec<f64>>();
        let u = of(|k| libm::sin(0.002 * k * k));
        let second = of(|k| libm::sin(0.7 * k) * libm::cos(0.0011 * k * k));
        let mut y = vec![0.0; u.len()];
        for k in 1..u.len() {
            y[k] = 0.9 * y[k - 1] + 0.2 * u[k - 1];
        }
        let noise = of(|k| 0.1 * libm::sin(1.3 * k * k) + 3.0);
        let y = y.iter().zip(noise).map(|(y, v)| y + v).collect();
        [u, second, y]
    }

    fn at_bins(record: Columns<'_>) -> Vec<Point> {
        let bins = [4.0, 10.0, 20.0, 40.0];
        let settings = Settings {
            frequencies: Some(bins.map(|bin| bin * TAU / WINDOW as f64).into()),
            windows: Some(Windows(vec![WINDOW])),
        };
        Spectra::new(vec![record], 1.0, &settings).unwrap().points
    }

    #[track_caller]
    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }

    #[test]
    fn spectrum_response_and_coherence_are_scipys() {
        // scipy 1.17.1, signal.csd over signal.welch, and signal.coherence: hann, nperseg 128, noverlap 64, detrend constant.
        let expected = [
            (0.36799258898267817, -0.9064955360662572, 0.9891767689462285),
            (-0.0275914265804191, -0.4170044330066791, 0.9821173956896054),
            (
                -0.08731074246170355,
                -0.20390484946391865,
                0.9969636114320237,
            ),
            (
                -0.12495158968292899,
                -0.06597875661584614,
                0.527992854019801,
            ),
        ];
        // signal.welch of u, one-sided and per Hz: half of it is the variance of white noise.
        let spectrum = [
            0.759_223_321_533_792,
            0.980_955_973_276_935_6,
            0.904_006_479_877_993_5,
            0.647_567_647_201_313_1,
        ];
        let [u, _, y] = &signals();
        let points = at_bins(Columns {
            inputs: vec![u],
            output: y,
            references: Vec::new(),
        });
        for (point, of_input) in points.iter().zip(spectrum) {
            near(point.inputs[0], of_input);
        }
        for (point, (re, im, coherence)) in points.iter().zip(expected) {
            near(point.values[0].re, re);
            near(point.values[0].im, im);
            near(point.coherence, coherence);
            near(point.coherences[0], coherence);
            // Bendat and Piersol, eq. 9.90, of eight segments that overlap.
            assert!((6.0..9.0).contains(&point.averages), "{}", point.averages);
            let g = coherence.sqrt();
            let error = (1.0 - coherence).sqrt() / (g * (2.0 * (point.averages - 1.0)).sqrt());
            near(point.phase_deviation(0), error);
        }
    }

    #[test]
    fn two_inputs_are_conditioned_on_each_other() {
        // The same spectra of scipy; H by numpy.linalg.solve, partial coherences by conditioned spectra (Bendat and Piersol, ch. 7).
        let expected = [
            (
                [0.36824539048598487, 0.49182753353677217],
                0.9905872165696962,
                [0.9888719005466328, 0.9430609014841512],
            ),
            (
                [-0.030899318630861428, 0.46774300407560465],
                0.9869205911922464,
                [0.9753742749263956, 0.962169043067762],
            ),
            (
                [-0.0867252954731603, 0.27725266839415724],
                0.9987547368245009,
                [0.9956755498956935, 0.9982941216554612],
            ),
            (
                [-0.15542747248762445, -1.2252603104054927],
                0.6343247180932035,
                [0.18614790368617573, 0.26539823950421637],
            ),
        ];
        let [u, second, y] = &signals();
        let late = std::iter::once(0.0).chain(second.iter().map(|u| 0.5 * u));
        let y: Vec<f64> = y.iter().zip(late).map(|(y, it)| y + it).collect();
        let points = at_bins(Columns {
            inputs: vec![u, second],
            output: &y,
            references: Vec::new(),
        });
        for (point, (re, multiple, partial)) in points.iter().zip(expected) {
            near(point.coherence, multiple);
            for i in 0..2 {
                near(point.values[i].re, re[i]);
                near(point.coherences[i], partial[i]);
            }
        }
    }

    #[test]
    fn inputs_that_are_one_or_do_not_pair_are_refused() {
        let [u, _, y] = &signals();
        let of = |inputs: Vec<&[f64]>| {
            let record = Columns {
                inputs: inputs.iter().map(|it| &it[..]).collect(),
                output: &y[..],
                references: Vec::new(),
            };
            Spectra::new(vec![record], 1.0, &Settings::default()).is_err()
        };
        assert!(of(vec![&u[1..]]));
        assert!(of(vec![&vec![0.0; y.len()]]));
        assert!(of(Vec::new()));
    }
}
