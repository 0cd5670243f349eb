//! A discrete transfer function and its properties: poles in z and in s,
//! steady-state gain, response.

use planesman_linear::polynomial::{self, evaluate};
use planesman_linear::{Complex, ComplexFunctions as _, TransferFunction, discrete_to_continuous};

use crate::error::Result;
use crate::regression::Shape;
use planesman_record::Input;

/// If `1 + a1 + ... + an` is closer to zero than this share of `1 + |a1| + ... + |an|`, there is a pole at z = 1: a steady-state gain would
/// be rounding error.
const INTEGRATOR_TOLERANCE: f64 = 1e-12;

/// The model of [`rows`](crate::rows), its parameters by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// The sampling interval, s.
    pub sample_time: f64,
    /// `a1 ... an`.
    pub a: Vec<f64>,
    /// `b0` for direct feedthrough, output unit per input unit; 0 if every input acts later.
    pub feedthrough: f64,
    /// `b1 ... bn`, output unit per input unit.
    pub b: Vec<f64>,
    /// `c1 ... cn`, output unit per input unit; empty without moments as regressors.
    pub c: Vec<f64>,
    /// The bias, output unit; 0 without a bias as regressor.
    pub bias: f64,
}

impl Model {
    /// The model with the parameters `theta`, in the order of the regression's row.
    #[must_use]
    pub fn from_parameters(shape: Shape, theta: &[f64], sample_time: f64) -> Self {
        let n = shape.order;
        let block = |i: usize| theta.iter().skip(i * n).take(n).copied().collect();
        Self {
            sample_time,
            a: block(0),
            feedthrough: 0.0,
            b: block(1),
            c: if shape.moment { block(2) } else { Vec::new() },
            bias: if shape.bias {
                theta.last().copied().unwrap_or(0.0)
            } else {
                0.0
            },
        }
    }

    /// `b1 ... bn`, preceded by `b0` with direct feedthrough.
    #[must_use]
    pub fn numerator(&self, feedthrough: bool) -> Vec<f64> {
        let lead = feedthrough.then_some(self.feedthrough);
        lead.into_iter().chain(self.b.iter().copied()).collect()
    }

    /// `z^n + a1 z^(n-1) + ... + an`.
    fn denominator(&self) -> Vec<f64> {
        std::iter::once(1.0).chain(self.a.iter().copied()).collect()
    }

    /// The poles in the z plane, largest magnitude first; of a conjugate pair the one with positive imaginary part comes first.
    ///
    /// # Errors
    /// [`IdentificationError`](crate::IdentificationError), if the roots cannot be found.
    pub fn poles(&self) -> Result<Vec<Complex<f64>>> {
        let mut poles = polynomial::roots(&self.denominator())?;
        sort_largest_first(&mut poles);
        Ok(poles)
    }

    /// The zeros of the numerator in the z plane, in the same order as poles.
    ///
    /// # Errors
    /// [`IdentificationError`](crate::IdentificationError), if the roots cannot be found.
    pub fn zeros(&self) -> Result<Vec<Complex<f64>>> {
        let numerator = self.numerator(self.feedthrough != 0.0);
        let mut zeros =
            TransferFunction::new(numerator, self.denominator()).and_then(|g| g.zeros())?;
        sort_largest_first(&mut zeros);
        Ok(zeros)
    }

    /// A pole's place in the s plane, `ln(z) / T`, 1/s. For a pole at z = 0, whose logarithm is infinite, the logarithm of the smallest
    /// positive number is used.
    #[must_use]
    pub fn continuous(&self, z: Complex<f64>) -> Complex<f64> {
        discrete_to_continuous(z, self.sample_time)
            .unwrap_or_else(|| Complex::new(libm::log(f64::MIN_POSITIVE) / self.sample_time, 0.0))
    }

    /// The slowest pole in the s plane, 1/s: the pole with the largest real part; of a complex pair the one with positive imaginary part. Poles on
    /// the negative real axis of z are left out: no continuous system has one; least squares puts them there to smooth noise. `None` if no other pole
    /// exists.
    #[must_use]
    pub fn dominant_pole(&self) -> Option<Complex<f64>> {
        self.poles()
            .ok()?
            .into_iter()
            .filter(|z| !(z.im == 0.0 && z.re <= 0.0))
            .map(|z| self.continuous(z))
            .max_by(|s, r| s.re.total_cmp(&r.re).then(s.im.total_cmp(&r.im)))
    }

    /// The steady output per steady input, `sum b / (1 + sum a)`, without the bias; `None`
    /// with a pole at z = 1.
    #[must_use]
    pub fn steady_state_gain(&self) -> Option<f64> {
        let one = Complex::new(1.0, 0.0);
        let denominator = evaluate(&self.denominator(), one).re;
        let size = 1.0 + self.a.iter().map(|a| a.abs()).sum::<f64>();
        (denominator.abs() > INTEGRATOR_TOLERANCE * size)
            .then(|| (self.feedthrough + self.b.iter().sum::<f64>()) / denominator)
            .filter(|gain| gain.is_finite())
    }

    /// The output at `count` samples from rest: `inputs[k]` acts over the interval that begins with sample k, and there is neither input
    /// nor bias before the first.
    #[must_use]
    pub fn simulate(&self, inputs: &[Input], count: usize) -> Vec<f64> {
        let mut outputs: Vec<f64> = Vec::with_capacity(count);
        for k in 0..count {
            let past = |coefficients: &[f64], value: &dyn Fn(usize) -> f64| -> f64 {
                coefficients
                    .iter()
                    .enumerate()
                    .take(k)
                    .map(|(i, coefficient)| coefficient * value(k - 1 - i))
                    .sum()
            };
            let input = |j: usize| inputs.get(j).copied().unwrap_or_default();
            let bias = if k == 0 { 0.0 } else { self.bias };
            let output = past(&self.b, &|j| input(j).mean) + past(&self.c, &|j| input(j).moment)
                - past(&self.a, &|j| outputs[j])
                + self.feedthrough * input(k).mean
                + bias;
            outputs.push(output);
        }
        outputs
    }
}

/// Sorts by magnitude, largest first; of a conjugate pair the root with positive imaginary part comes first.
fn sort_largest_first(roots: &mut [Complex<f64>]) {
    // Conjugates found apart may differ in the last bit: order them by a rounded
    // magnitude, so that the pair stays together.
    let rounded = |z: &Complex<f64>| (z.modulus() * 1e9).round();
    roots.sort_by(|p, q| {
        (rounded(q).total_cmp(&rounded(p)))
            .then(q.re.total_cmp(&p.re))
            .then(q.im.total_cmp(&p.im))
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(a: &[f64], b: &[f64]) -> Model {
        Model {
            sample_time: 0.05,
            a: a.to_vec(),
            feedthrough: 0.0,
            b: b.to_vec(),
            c: Vec::new(),
            bias: 0.0,
        }
    }

    #[test]
    fn the_identified_model_of_run_9_2_has_its_poles_and_gain() {
        // Brunner 1988, Table 9, run 9/2, q/delta second order.
        let run = model(&[-0.7812, -0.099], &[0.033, 0.0758]);
        let poles = run.poles().unwrap();
        assert!((poles[0].re - 0.89217).abs() < 1e-5);
        assert!((poles[1].re + 0.11097).abs() < 1e-5);
        assert!((run.dominant_pole().unwrap().re + 2.282).abs() < 1e-3);
        assert!((run.steady_state_gain().unwrap() - 0.908).abs() < 5e-4);
        assert!((run.zeros().unwrap()[0].re + 2.297).abs() < 1e-3);
    }

    #[test]
    fn a_pole_at_one_leaves_no_steady_state_gain() {
        assert_eq!(model(&[-2.0, 1.0], &[0.01, 0.01]).steady_state_gain(), None);
    }

    #[test]
    fn an_oscillation_is_given_by_the_upper_of_its_pair() {
        let s = Complex::new(-0.35, 0.12);
        let z = (s * 0.05_f64).exp();
        let run = model(&[-2.0 * z.re, z.norm_sqr()], &[0.0, 1.0]);
        assert!((run.dominant_pole().unwrap() - s).modulus() < 1e-9);
        let poles = run.poles().unwrap();
        assert!(poles[0].im > 0.0 && poles[1].im < 0.0);
    }

    #[test]
    fn a_model_of_nothing_has_finite_poles() {
        let nothing = model(&[0.0, 0.0, 0.0], &[0.0; 3]);
        for pole in nothing.poles().unwrap() {
            assert!(nothing.continuous(pole).re.is_finite());
        }
        assert_eq!(nothing.dominant_pole(), None);
    }

    #[test]
    fn the_response_is_the_difference_equations() {
        let run = Model {
            c: vec![2.0],
            bias: 0.5,
            ..model(&[-0.5], &[1.0])
        };
        let inputs = [
            Input {
                mean: 1.0,
                moment: 0.25,
            },
            Input {
                mean: 0.0,
                moment: 0.0,
            },
        ];
        assert_eq!(run.simulate(&inputs, 3), vec![0.0, 2.0, 1.5]);
    }
}
