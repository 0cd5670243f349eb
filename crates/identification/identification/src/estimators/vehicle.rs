//! The vehicle's equations and their parameters: `K/J`, `B/J`, `M_theta/J` and the gyro's bias.
//!
//! ```text
//! q_dot     = kappa u - beta q - mu theta + nu w        kappa = K/J, beta = B/J, mu = M_theta/J
//! theta_dot = q
//! w_dot     = epsilon u + eta q - zeta w
//! y         = q + bias
//! ```
//! q, theta and w have the output's unit (the unit of q, times s, and the unit implied by nu). The heave equation is left out, known, or known with a
//! relative uncertainty. Then the coefficients of heave are unknowns too, with a prior of that strength:
//! ```text
//! minimise |y - yhat|^2 / sigma^2 + sum ((p_i - known_i) / deviation_i)^2
//! ```
//! Without heave these are the pitch equation of the thesis (Brunner 1988, p. 93: `J q_dot = K u - B q - M_theta theta`). Under zero-order
//! hold the equations are solved exactly: the exponential of one matrix advances the state and its derivatives by the unknowns (Van Loan,
//! *IEEE Trans. Autom. Control* 23, 1978):
//! ```text
//! exp( T [ M   0 ] )  =  [ E   0 ]      M = [ A B ; 0 0 ],  E = [ F G ; 0 1 ]
//!        [ dM  M ]       [ dE  E ]
//! ```
//! The result is also converted to the transfer function of the sampled equations, with the propagated covariance, so that it can be used
//! like other estimates. Three unknowns instead of five or six coefficients make short records sufficient.

use nalgebra::{DMatrix, DVector};
use planesman_linear::{exponential, pitch};

use super::estimate::{Error, Estimate};
use super::physical::{Physical, UNKNOWNS};
use crate::structure::{InitialState, Layout, Problem, Structure};

/// The heave equation, with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heave {
    /// `nu`: pitch acceleration per heave.
    pub to_pitch: f64,
    /// `zeta`, 1/s.
    pub damping: f64,
    /// `eta`: heave acceleration per pitch rate.
    pub from_rate: f64,
    /// `epsilon`: heave acceleration per input.
    pub from_input: f64,
    /// The relative standard deviation of each of these; 0 for exactly known values.
    pub doubt: f64,
}

/// The known part of the vehicle's equations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vehicle {
    /// The heave equation; `None` to leave heave out.
    pub heave: Option<Heave>,
}

impl Vehicle {
    /// The number of states.
    #[must_use]
    pub fn states(&self) -> usize {
        if self.heave.is_some() { 3 } else { 2 }
    }

    /// The number of estimated coefficients: `kappa`, `beta`, `mu`, and the coefficients of heave if they are uncertain.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        UNKNOWNS + self.prior().len()
    }

    /// All coefficients, in the order of [`NAMES`](super::NAMES).
    #[must_use]
    pub fn coefficients(&self, pitch: [f64; UNKNOWNS]) -> DVector<f64> {
        let heave = self.heave.iter().flat_map(Heave::coefficients);
        DVector::from_iterator(
            UNKNOWNS + 4 * usize::from(self.heave.is_some()),
            pitch.into_iter().chain(heave),
        )
    }

    /// Value and standard deviation of each unknown with prior knowledge.
    #[must_use]
    pub fn prior(&self) -> Vec<(f64, f64)> {
        let doubted = self.heave.iter().filter(|heave| heave.doubt > 0.0);
        doubted
            .flat_map(|heave| {
                heave
                    .coefficients()
                    .map(|known| (known, (heave.doubt * known).abs().max(f64::MIN_POSITIVE)))
            })
            .collect()
    }

    /// The slope of `[A B]` by a coefficient.
    #[must_use]
    pub fn slope(&self, coefficient: usize) -> DMatrix<f64> {
        pitch::slope(coefficient, self.coefficients([0.0; UNKNOWNS]).len())
    }

    /// `[A B]` of `x_dot = A x + B u`, `x = (q, theta[, w])`.
    #[must_use]
    pub fn equations(&self, coefficients: &DVector<f64>) -> DMatrix<f64> {
        pitch::equations(coefficients.as_slice())
    }

    /// `[F G]` over one interval, and its slope by each unknown.
    fn step(&self, coefficients: &DVector<f64>, dt: f64) -> (DMatrix<f64>, Vec<DMatrix<f64>>) {
        let n = self.states();
        let m = self.equations(coefficients).resize_vertically(n + 1, 0.0);
        let slopes = (0..self.unknowns())
            .map(|i| {
                let mut both = DMatrix::zeros(2 * (n + 1), 2 * (n + 1));
                both.view_mut((0, 0), (n + 1, n + 1)).copy_from(&m);
                both.view_mut((n + 1, n + 1), (n + 1, n + 1)).copy_from(&m);
                both.view_mut((n + 1, 0), (n, n + 1))
                    .copy_from(&self.slope(i));
                let slope = exponential(&(both * dt));
                slope.view((n + 1, 0), (n, n + 1)).into_owned()
            })
            .collect();
        let step = exponential(&(m * dt)).rows(0, n).into_owned();
        (step, slopes)
    }

    /// `a1 ... an, b1 ... bn` of the sampled equations, and their slopes by the unknowns, one column each.
    #[must_use]
    pub fn sampled(&self, coefficients: &DVector<f64>, dt: f64) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.states();
        let (step, by) = self.step(coefficients, dt);
        let (f, g) = (step.columns(0, n).into_owned(), step.column(n).into_owned());
        let (value, _) = fraction((&f, &g), (&DMatrix::zeros(n, n), &DVector::zeros(n)));
        let mut slopes = DMatrix::zeros(2 * n, by.len());
        for (mut column, by) in slopes.column_iter_mut().zip(&by) {
            let change = (by.columns(0, n).into_owned(), by.column(n).into_owned());
            let (_, slope) = fraction((&f, &g), (&change.0, &change.1));
            column.copy_from(&slope.coefficients());
        }
        (value.coefficients(), slopes)
    }

    /// The pitch rate from state `x` under the inputs; its slopes by the unknowns and then by `x`, one column each.
    pub(crate) fn simulate(
        &self,
        coefficients: &DVector<f64>,
        mut x: DVector<f64>,
        dt: f64,
        inputs: &[f64],
    ) -> (Vec<f64>, DMatrix<f64>) {
        let (n, unknowns) = (self.states(), self.unknowns());
        let (step, by) = self.step(coefficients, dt);
        let transition = step.columns(0, n).into_owned();
        let mut rate = Vec::with_capacity(inputs.len());
        let mut slopes = DMatrix::zeros(inputs.len(), unknowns + n);
        let mut sensitivity = DMatrix::zeros(n, unknowns + n);
        sensitivity.columns_mut(unknowns, n).fill_with_identity();
        let mut next = sensitivity.clone();
        let mut driven = x.clone().push(0.0);
        for (k, u) in inputs.iter().enumerate() {
            rate.push(x[0]);
            slopes.row_mut(k).copy_from(&sensitivity.row(0));
            driven.rows_mut(0, n).copy_from(&x);
            driven[n] = *u;
            next.gemm(1.0, &transition, &sensitivity, 0.0);
            for (mut column, by) in next.column_iter_mut().zip(&by) {
                column.gemv(1.0, by, &driven, 1.0);
            }
            std::mem::swap(&mut sensitivity, &mut next);
            x.gemv(1.0, &step, &driven, 0.0);
        }
        (rate, slopes)
    }
}

impl Heave {
    fn coefficients(&self) -> [f64; 4] {
        [self.to_pitch, self.damping, self.from_rate, self.from_input]
    }

    /// The vehicle with other coefficients.
    #[must_use]
    pub fn with(self, [to_pitch, damping, from_rate, from_input]: [f64; 4]) -> Self {
        Self {
            to_pitch,
            damping,
            from_rate,
            from_input,
            ..self
        }
    }

    /// The vehicle with each coefficient changed by its own share.
    #[must_use]
    pub fn changed(self, shares: [f64; 4]) -> Self {
        let mut coefficients = self.coefficients();
        for (coefficient, share) in coefficients.iter_mut().zip(shares) {
            *coefficient *= 1.0 + share;
        }
        self.with(coefficients)
    }
}

/// A `det(q - F)` in powers of `q^-1` and a `C adj(q - F) g`, `C = (1, 0, ...)`.
struct Fraction {
    /// `1, a1 ... an`.
    den: Vec<f64>,
    /// `b1 ... bn`.
    num: Vec<f64>,
}

impl Fraction {
    /// `a1 ... an, b1 ... bn`.
    fn coefficients(&self) -> DVector<f64> {
        DVector::from_vec([&self.den[1..], &self.num[..]].concat())
    }
}

/// `C (q - F)^-1 g` and its change with `F` and `g`, by the recursion of Faddeev and Le Verrier:
/// ```text
/// N_1 = 1,   a_k = -tr(F N_k) / k,   N_(k+1) = F N_k + a_k,   b_k = C N_k g
/// ```
fn fraction(
    (f, g): (&DMatrix<f64>, &DVector<f64>),
    (df, dg): (&DMatrix<f64>, &DVector<f64>),
) -> (Fraction, Fraction) {
    let n = f.nrows();
    let one = DMatrix::<f64>::identity(n, n);
    let (mut adjoint, mut change) = (one.clone(), DMatrix::zeros(n, n));
    let mut value = Fraction {
        den: vec![1.0],
        num: Vec::new(),
    };
    let mut slope = Fraction {
        den: vec![0.0],
        num: Vec::new(),
    };
    for k in 1..=n {
        value.num.push((&adjoint * g)[0]);
        slope.num.push((&change * g + &adjoint * dg)[0]);
        let product = f * &adjoint;
        let moved = df * &adjoint + f * &change;
        let a = -product.trace() / k as f64;
        let da = -moved.trace() / k as f64;
        value.den.push(a);
        slope.den.push(da);
        adjoint = product + &one * a;
        change = moved + &one * da;
    }
    (value, slope)
}

/// The estimates of a vehicle, with their covariance.
pub(crate) struct Solution {
    /// All coefficients.
    pub(crate) coefficients: DVector<f64>,
    /// The bias in each record.
    pub(crate) biases: Vec<f64>,
    /// The state at the beginning of each record.
    pub(crate) motions: Vec<DVector<f64>>,
    /// Covariance of the unknowns, then of bias and initial state of each record ([`Vehicle::columns`]).
    pub(crate) covariance: DMatrix<f64>,
    pub(crate) noise_variance: f64,
    pub(crate) residuals: Vec<Vec<f64>>,
}

impl Vehicle {
    /// The places of a record's bias and initial state among all estimated values.
    pub(crate) fn columns(
        &self,
        structure: &Structure,
        run: usize,
    ) -> (Option<usize>, std::ops::Range<usize>) {
        let motion = match structure.start {
            InitialState::Rest => 0,
            InitialState::Estimated => self.states(),
        };
        let offset = usize::from(structure.offset);
        let first = self.unknowns() + run * (offset + motion);
        let bias = structure.offset.then_some(first);
        (bias, first + offset..first + offset + motion)
    }

    /// The number of estimated values for this many records.
    pub(crate) fn count(&self, structure: &Structure, runs: usize) -> usize {
        self.columns(structure, runs - 1).1.end
    }

    /// The estimate as a transfer function.
    pub(crate) fn estimate(&self, problem: &Problem<'_>, solution: Solution) -> Estimate {
        let n = self.states();
        let unknowns = self.unknowns();
        let structure = Structure {
            offset: problem.structure.offset,
            start: problem.structure.start,
            ..Structure::of_order(n)
        };
        let layout = Layout {
            structure,
            runs: problem.runs.len(),
        };
        let dt = problem.sample_time;
        let (coefficients, by) = self.sampled(&solution.coefficients, dt);
        let mut theta = DVector::zeros(layout.count());
        let mut slopes = DMatrix::zeros(theta.len(), solution.covariance.nrows());
        theta.rows_mut(0, 2 * n).copy_from(&coefficients);
        slopes.view_mut((0, 0), (2 * n, unknowns)).copy_from(&by);
        let (step, by) = self.step(&solution.coefficients, dt);
        let f = step.columns(0, n).into_owned();
        let still = (DMatrix::zeros(n, n), DVector::zeros(n));
        for run in 0..layout.runs {
            let (bias, beginning) = self.columns(&layout.structure, run);
            if let (Some(at), Some(bias)) = (layout.offset(run), bias) {
                theta[at] = solution.biases[run];
                slopes[(at, bias)] = 1.0;
            }
            let motion = layout.motion(run);
            if motion.is_empty() {
                continue;
            }
            // A state x at the beginning does what the input x would do in one impulse.
            let x = &solution.motions[run];
            let (value, _) = fraction((&f, x), (&still.0, &still.1));
            theta.rows_mut(motion.start, n).copy_from_slice(&value.num);
            for (i, by) in by.iter().enumerate() {
                let df = by.columns(0, n).into_owned();
                let (_, slope) = fraction((&f, x), (&df, &still.1));
                slopes
                    .view_mut((motion.start, i), (n, 1))
                    .copy_from_slice(&slope.num);
            }
            for (i, column) in beginning.enumerate() {
                let unit = DVector::from_fn(n, |row, _| f64::from(u8::from(row == i)));
                let (value, _) = fraction((&f, &unit), (&still.0, &still.1));
                slopes
                    .view_mut((motion.start, column), (n, 1))
                    .copy_from_slice(&value.num);
            }
        }
        Estimate {
            error: Error::Output,
            layout,
            sample_time: problem.sample_time,
            covariance: &slopes * &solution.covariance * slopes.transpose(),
            theta,
            noise_variance: solution.noise_variance,
            noise_model: Vec::new(),
            factor: None,
            noise_denominator: Vec::new(),
            input_level: 0.0,
            residuals: solution.residuals,
            output_curve: None,
            process: None,
            frequency: None,
            physical: Some(Physical {
                values: solution.coefficients.rows(0, unknowns).into_owned(),
                covariance: solution
                    .covariance
                    .view((0, 0), (unknowns, unknowns))
                    .into_owned(),
            }),
        }
    }
}
