//! Uncertainty of derived quantities: the covariance of the parameters propagated to poles, zeros, gains and frequency responses.
//!
//! To first order (the delta method) a quantity `f(theta)` has the covariance `J P J'`, with J its
//! slope. All slopes are exact:
//! ```text
//! p a root of A:  dp/da_i = -p^(n-i) / A'(p)          s = ln(p)/T:  ds = dp / (p T)
//! G = B/A:        dG/da_i = -G z^(-i) / A,  dG/db_j = z^(-j) / A
//! ```
//! A complex quantity has a covariance of its real and imaginary parts: an ellipse. Known values have zero covariance. Where two roots nearly
//! coincide, the derivative grows without bound and the first-order approximation is poor; the ellipse is then large, which is the correct warning.

use std::ops::Range;

use nalgebra::{Complex, Matrix2};
use planesman_linear::digits::with_interval;
use planesman_linear::{
    ComplexFunctions as _, discrete_to_continuous, is_sampling_artefact, polynomial,
};

use crate::error::Result;
use crate::estimators::Estimate;
use planesman_record::filter;

pub use crate::structure::SIGMAS_95;
/// The same for 99 %.
pub const SIGMAS_99: f64 = 2.575_829;

/// The largest distance in z from a zero to a pole that it cancels.
const CANCELS: f64 = 0.2;

/// A complex quantity and the covariance of its parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertain {
    /// The quantity.
    pub value: Complex<f64>,
    /// The covariance of real and imaginary part; zero for known values.
    pub covariance: Matrix2<f64>,
}

impl Uncertain {
    /// A known quantity, with zero covariance.
    #[must_use]
    pub fn known(value: Complex<f64>) -> Self {
        Self {
            value,
            covariance: Matrix2::zeros(),
        }
    }

    /// The real part's standard deviation.
    #[must_use]
    pub fn real_deviation(&self) -> f64 {
        self.covariance[(0, 0)].max(0.0).sqrt()
    }

    /// The imaginary part's standard deviation.
    #[must_use]
    pub fn imaginary_deviation(&self) -> f64 {
        self.covariance[(1, 1)].max(0.0).sqrt()
    }

    /// The standard deviation of the magnitude.
    #[must_use]
    pub fn magnitude_deviation(&self) -> f64 {
        let size = self.value.modulus();
        if size == 0.0 {
            return libm::hypot(self.real_deviation(), self.imaginary_deviation());
        }
        let along = nalgebra::Vector2::new(self.value.re, self.value.im) / size;
        (along.dot(&(self.covariance * along))).max(0.0).sqrt()
    }

    /// For a pole in s, the damping ratio `-re/|s|` and its standard deviation.
    #[must_use]
    pub fn damping_ratio(&self) -> (f64, f64) {
        let size = self.value.modulus();
        // The ratio depends on the angle alone: d(cos phi) = -sin phi d(phi).
        let slope = self.value.im / size;
        (-self.value.re / size, slope.abs() * self.phase_deviation())
    }

    /// The mode of a pole in s as text, with 95 % intervals: natural frequency and damping ratio of a pair, time constant of a real pole.
    #[must_use]
    pub fn mode_text(&self) -> String {
        let Complex { re, im } = self.value;
        let unstable = if re > 0.0 { "unstable, " } else { "" };
        if im != 0.0 {
            let (damping, deviation) = self.damping_ratio();
            format!(
                "{unstable}natural frequency {} rad/s, damping ratio {}",
                with_interval(self.value.modulus(), SIGMAS_95 * self.magnitude_deviation()),
                with_interval(damping, SIGMAS_95 * deviation)
            )
        } else if re == 0.0 {
            "integrator".to_owned()
        } else {
            let interval = SIGMAS_95 * self.real_deviation() / (re * re);
            format!(
                "{unstable}time constant {} s",
                with_interval(1.0 / re.abs(), interval)
            )
        }
    }

    /// The standard deviation of the phase, rad.
    #[must_use]
    pub fn phase_deviation(&self) -> f64 {
        let size = self.value.modulus();
        let across = nalgebra::Vector2::new(-self.value.im, self.value.re) / size;
        (across.dot(&(self.covariance * across))).max(0.0).sqrt() / size
    }

    /// The ellipse that contains the true value with 95 % probability, as `points` points; 2.448 standard deviations for a normal
    /// distribution in two dimensions, 1.960 along a line.
    #[must_use]
    pub fn ellipse_95(&self, points: usize) -> Vec<Complex<f64>> {
        let on_a_line = self.covariance[(1, 1)] <= 1e-24 * self.covariance[(0, 0)];
        let radius = if on_a_line { SIGMAS_95 } else { 2.447_747 };
        let eigen = self.covariance.symmetric_eigen();
        let root = eigen.eigenvectors
            * Matrix2::from_diagonal(&eigen.eigenvalues.map(|v| radius * v.max(0.0).sqrt()));
        (0..=points)
            .map(|i| {
                let angle = std::f64::consts::TAU * i as f64 / points as f64;
                let at = root * nalgebra::Vector2::new(libm::cos(angle), libm::sin(angle));
                self.value + Complex::new(at[0], at[1])
            })
            .collect()
    }
}

/// A root this near to z = 1 counts as being there.
const AT_ONE: f64 = 1e-6;

/// Poles, zeros, gain and response of an estimate, with their covariance.
#[derive(Clone, Copy, Debug)]
pub struct Reading<'a> {
    estimate: &'a Estimate,
    run: usize,
}

impl<'a> Reading<'a> {
    /// The quantities for record `run`.
    #[must_use]
    pub fn new(estimate: &'a Estimate, run: usize) -> Self {
        Self { estimate, run }
    }

    /// The poles in z by decreasing real part; known poles last.
    ///
    /// # Errors
    /// [`IdentificationError`](crate::IdentificationError), if the roots cannot be found.
    pub fn poles(&self) -> Result<Vec<Uncertain>> {
        let layout = &self.estimate.layout;
        let mut monic = vec![1.0];
        monic.extend(&self.estimate.theta.as_slice()[layout.a()]);
        let mut poles = self.roots(&monic, layout.a())?;
        poles.extend(known_roots(&layout.structure.known_denominator)?);
        Ok(poles)
    }

    /// The zeros in z, in the same order as poles.
    ///
    /// # Errors
    /// [`IdentificationError`](crate::IdentificationError), if the roots cannot be found.
    pub fn zeros(&self) -> Result<Vec<Uncertain>> {
        let layout = &self.estimate.layout;
        let b = &self.estimate.theta.as_slice()[layout.b(self.run)];
        // Coefficients that are 0 in front are a longer delay.
        let leading = b.iter().take_while(|b| **b == 0.0).count().min(b.len() - 1);
        let places = layout.b(self.run).start + leading..layout.b(self.run).end;
        let mut zeros = self.roots(&b[leading..], places)?;
        zeros.extend(known_roots(&layout.structure.known_numerator)?);
        Ok(zeros)
    }

    /// The poles that a zero may cancel, one of each complex pair: the zero is so near that the 95 % intervals do not separate them.
    pub(crate) fn cancelled_poles(&self) -> Vec<Uncertain> {
        let (Ok(poles), Ok(zeros)) = (self.poles(), self.zeros()) else {
            return Vec::new();
        };
        let cancels = |pole: &Uncertain| {
            zeros.iter().any(|zero| {
                let apart = (zero.value - pole.value).modulus();
                let joint = libm::hypot(zero.magnitude_deviation(), pole.magnitude_deviation());
                joint > 0.0 && apart < SIGMAS_95 * joint && apart < CANCELS
            })
        };
        let poles = poles.into_iter().filter(|pole| pole.value.im >= 0.0);
        poles.filter(cancels).collect()
    }

    /// The poles in s, `ln(z)/T`, 1/s, in the order of [`Reading::poles`]; without poles at z = 0.
    ///
    /// # Errors
    /// Like [`Reading::poles`].
    pub fn continuous_poles(&self) -> Result<Vec<Uncertain>> {
        let poles = self.poles()?;
        Ok(poles.iter().filter_map(|it| self.in_s(it)).collect())
    }

    /// Converts a pole in z to s; `None` at z = 0.
    #[must_use]
    pub fn in_s(&self, pole: &Uncertain) -> Option<Uncertain> {
        let dt = self.estimate.sample_time;
        let value = discrete_to_continuous(pole.value, dt)?;
        let turn = rotation((pole.value * dt).inv());
        Some(Uncertain {
            value,
            covariance: turn * pole.covariance * turn.transpose(),
        })
    }

    /// The poles in z, slowest first; one pole of each complex pair.
    ///
    /// # Errors
    /// Like [`Reading::poles`].
    pub fn slowest_first(&self) -> Result<Vec<Uncertain>> {
        let mut poles = self.poles()?;
        poles.retain(|it| it.value.im >= 0.0);
        // z = 0 is infinitely fast.
        poles.sort_by(|p, q| p.value.ln().modulus().total_cmp(&q.value.ln().modulus()));
        Ok(poles)
    }

    /// The modes of the poles as text with 95 % intervals, slowest first; without artefacts of sampling, which are not modes of the system.
    #[must_use]
    pub fn modes(&self) -> Vec<String> {
        self.system_poles().map(|it| it.mode_text()).collect()
    }

    /// The modes whose pole differs from 0 by more than its 95 % interval, see [`Reading::modes`], and the number of the other modes.
    #[must_use]
    pub fn determined_modes(&self) -> (Vec<String>, usize) {
        let is_determined = |it: &Uncertain| {
            it.value.re == 0.0 || SIGMAS_95 * it.magnitude_deviation() < it.value.modulus()
        };
        let (known, others): (Vec<_>, Vec<_>) = self.system_poles().partition(is_determined);
        (
            known.iter().map(Uncertain::mode_text).collect(),
            others.len(),
        )
    }

    /// The poles in s, slowest first; one pole of each complex pair, without artefacts of sampling.
    fn system_poles(&self) -> impl Iterator<Item = Uncertain> {
        let mut poles = self.slowest_first().unwrap_or_default();
        poles.retain(|it| !is_sampling_artefact(it.value));
        poles.into_iter().filter_map(|it| self.in_s(&it))
    }

    /// The steady-state gain, output unit per input unit; `None` with a pole at z = 1.
    #[must_use]
    pub fn steady_state_gain(&self) -> Option<Uncertain> {
        self.estimate.model(self.run).steady_state_gain()?;
        self.response(0.0)
    }

    /// The gain of a model that integrates `n` times, K of `K/(s^n (T s + 1))`, output unit per input unit and s^n, and n; `None` without a
    /// pole known to be at z = 1.
    #[must_use]
    pub fn integrator_gain(&self) -> Option<(Uncertain, usize)> {
        let known = &self.estimate.layout.structure.known_denominator;
        let integrators = known.len() - 1;
        let roots = polynomial::roots(known).ok()?;
        let are_at_one = roots.iter().all(|root| (root - 1.0).modulus() < AT_ONE);
        if integrators == 0 || !are_at_one {
            return None;
        }
        let per_sample = self.response_behind(0.0, &[1.0])?;
        let scale = self.estimate.sample_time.powi(-(integrators as i32));
        let gain = Uncertain {
            value: per_sample.value * scale,
            covariance: per_sample.covariance * (scale * scale),
        };
        Some((gain, integrators))
    }

    /// The gain of an integrating model as text, with its 95 % interval.
    #[must_use]
    pub fn integrator_gain_text(&self) -> Option<String> {
        let (gain, integrators) = self.integrator_gain()?;
        let gain = with_interval(gain.value.re, SIGMAS_95 * gain.real_deviation());
        let power = match integrators {
            1 => String::new(),
            n => format!("^{n}"),
        };
        Some(format!("{gain} per s{power}, K of K/s{power}"))
    }

    /// The frequency response at `omega` rad/s; `None` where it is infinite.
    #[must_use]
    pub fn response(&self, omega: f64) -> Option<Uncertain> {
        self.response_behind(omega, &self.estimate.layout.structure.known_denominator)
    }

    /// The frequency response, including these known poles.
    fn response_behind(&self, omega: f64, known_denominator: &[f64]) -> Option<Uncertain> {
        let layout = &self.estimate.layout;
        let structure = &layout.structure;
        let theta = self.estimate.theta.as_slice();
        let back = (Complex::new(0.0, -omega * self.estimate.sample_time)).exp();
        let sum = |coefficients: &[f64]| -> Complex<f64> {
            coefficients
                .iter()
                .rev()
                .fold(Complex::new(0.0, 0.0), |sum, c| sum * back + c)
        };
        let known = back.powi(structure.delay as i32) * sum(&structure.known_numerator)
            / sum(known_denominator);
        let a = 1.0 + back * sum(&theta[layout.a()]);
        let value = known * sum(&theta[layout.b(self.run)]) / a;
        let columns: Vec<usize> = layout.a().chain(layout.b(self.run)).collect();
        let slopes: Vec<Complex<f64>> = (1..=structure.poles)
            .map(|i| -value * back.powi(i as i32) / a)
            .chain((0..structure.numerator).map(|j| known * back.powi(j as i32) / a))
            .collect();
        let found = Uncertain {
            value,
            covariance: self.carried(&columns, &slopes),
        };
        (value.re.is_finite() && value.im.is_finite()).then_some(found)
    }

    /// The output's change after a unit step of the input at sample 0, for the first `count` samples, output unit per input unit.
    #[must_use]
    pub fn step_response(&self, count: usize) -> Vec<f64> {
        self.step_through_numerator(&self.step_through_poles(count))
    }

    /// The step response with its standard deviation.
    #[must_use]
    pub fn uncertain_step_response(&self, count: usize) -> Vec<(f64, f64)> {
        let layout = &self.estimate.layout;
        let structure = &layout.structure;
        let by_numerator = self.step_through_poles(count);
        let response = self.step_through_numerator(&by_numerator);
        let a = layout.denominator(self.estimate.theta.as_slice());
        let by_denominator = filter(&[-1.0], &a, &response);
        let slopes: Vec<Vec<f64>> = (1..=structure.poles)
            .map(|i| late(&by_denominator, i))
            .chain((0..structure.numerator).map(|j| late(&by_numerator, j)))
            .collect();
        let columns: Vec<usize> = layout.a().chain(layout.b(self.run)).collect();
        let deviation = |k: usize| {
            let at: Vec<_> = (slopes.iter().map(|it| Complex::new(it[k], 0.0))).collect();
            self.carried(&columns, &at)[(0, 0)].max(0.0).sqrt()
        };
        let each = response.iter().enumerate();
        each.map(|(k, value)| (*value, deviation(k))).collect()
    }

    /// A unit step filtered by delay, known zeros and all poles: the slope of the step response by the first numerator coefficient.
    fn step_through_poles(&self, count: usize) -> Vec<f64> {
        let layout = &self.estimate.layout;
        let structure = &layout.structure;
        let step = late(&vec![1.0; count], structure.delay);
        let known = &structure.known_denominator;
        let driving = filter(&structure.known_numerator, known, &step);
        let a = layout.denominator(self.estimate.theta.as_slice());
        filter(&[1.0], &a, &driving)
    }

    fn step_through_numerator(&self, through_poles: &[f64]) -> Vec<f64> {
        let b = self.estimate.layout.b(self.run);
        filter(&self.estimate.theta.as_slice()[b], &[1.0], through_poles)
    }

    /// Roots of a polynomial, highest power first, whose last coefficients are the parameters at `places`, with the propagated covariance.
    fn roots(&self, polynomial: &[f64], places: Range<usize>) -> Result<Vec<Uncertain>> {
        let roots = polynomial::roots(polynomial)?;
        let derivative = polynomial::derivative(polynomial);
        let columns: Vec<usize> = places.collect();
        Ok(roots
            .into_iter()
            .map(|value| {
                let slope = -polynomial::evaluate(&derivative, value).inv();
                let slopes: Vec<Complex<f64>> = (0..columns.len())
                    .rev()
                    .map(|power| slope * value.powi(power as i32))
                    .collect();
                Uncertain {
                    value,
                    covariance: self.carried(&columns, &slopes),
                }
            })
            .collect())
    }

    /// The covariance `J P J'` of a complex quantity with these slopes.
    fn carried(&self, columns: &[usize], slopes: &[Complex<f64>]) -> Matrix2<f64> {
        if let Some(factor) = &self.estimate.factor {
            // Sums of squares: nothing cancels but in the sums themselves.
            return (factor.column_iter())
                .map(|column| {
                    let shares = columns.iter().zip(slopes);
                    let sum: Complex<f64> = shares.map(|(i, slope)| slope * column[*i]).sum();
                    let at = nalgebra::Vector2::new(sum.re, sum.im);
                    at * at.transpose()
                })
                .sum();
        }
        let p = &self.estimate.covariance;
        let mut covariance = Matrix2::zeros();
        for (i, left) in columns.iter().zip(slopes) {
            for (j, right) in columns.iter().zip(slopes) {
                let share = p[(*i, *j)];
                covariance[(0, 0)] += left.re * share * right.re;
                covariance[(0, 1)] += left.re * share * right.im;
                covariance[(1, 0)] += left.im * share * right.re;
                covariance[(1, 1)] += left.im * share * right.im;
            }
        }
        covariance
    }
}

/// The signal delayed by this many samples, cut off at its length.
fn late(signal: &[f64], samples: usize) -> Vec<f64> {
    let later = std::iter::repeat_n(0.0, samples).chain(signal.iter().copied());
    later.take(signal.len()).collect()
}

/// The matrix that multiplies (re, im) as `factor` multiplies the complex number.
fn rotation(factor: Complex<f64>) -> Matrix2<f64> {
    Matrix2::new(factor.re, -factor.im, factor.im, factor.re)
}

/// Roots of a known polynomial in `q^-1`.
fn known_roots(coefficients: &[f64]) -> Result<Vec<Uncertain>> {
    let roots = polynomial::roots(coefficients)?;
    Ok(roots.into_iter().map(Uncertain::known).collect())
}
