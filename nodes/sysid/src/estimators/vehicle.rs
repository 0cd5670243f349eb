//! The vehicle's own equations, found from records: `K/J`, `B/J`, `M_theta/J` and the gyro's bias.
//!
//! ```text
//! q_dot     = kappa u - beta q - mu theta + nu w        kappa = K/J, beta = B/J, mu = M_theta/J
//! theta_dot = q
//! w_dot     = epsilon u + eta q - zeta w
//! y         = q + bias
//! ```
//! q, theta and w are measured in the output's unit (that of q, times s, and whatever nu is given in). The
//! heave equation is known or left out; without it these are the pitch equation of the thesis (Brunner
//! 1988, p. 93: `J q_dot = K u - B q - M_theta theta`). Between samples the input is held, and the equations
//! are solved exactly: state, and slopes by the parameters, step by the exponential of one matrix
//! (Van Loan, *IEEE Trans. Autom. Control* 23, 1978):
//! ```text
//! exp( T [ M   0 ] )  =  [ E   0 ]      M = [ A B ; 0 0 ],  E = [ F G ; 0 1 ]
//!        [ dM  M ]       [ dE  E ]
//! ```
//! The parameters of least simulated error are sought ([`super::levenberg_marquardt`]); three unknowns in
//! place of five or six coefficients are what makes short records suffice.

use nalgebra::{DMatrix, DVector, Matrix2, Matrix3};
use planesman_linear::{Complex, polynomial};

use super::least_squares::freedom;
use super::levenberg_marquardt::{Linearised, minimise, unit_covariance};
use crate::batch::Triangle;
use crate::structure::Run;
use crate::uncertainty::Uncertain;

/// The heave equation, when it is known.
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
}

/// What is known of the vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vehicle {
    /// Its heave equation; `None` to leave heave out.
    pub heave: Option<Heave>,
}

/// `kappa`, `beta`, `mu`: how many unknowns the vehicle has.
pub const UNKNOWNS: usize = 3;

impl Vehicle {
    /// `A` and `B` of `x_dot = A x + B u`, `x = (q, theta[, w])`.
    #[must_use]
    pub fn equations(&self, [kappa, beta, mu]: [f64; UNKNOWNS]) -> (DMatrix<f64>, DVector<f64>) {
        match self.heave {
            None => (
                DMatrix::from_row_slice(2, 2, &[-beta, -mu, 1.0, 0.0]),
                DVector::from_vec(vec![kappa, 0.0]),
            ),
            #[rustfmt::skip]
            Some(heave) => (
                DMatrix::from_row_slice(3, 3, &[
                    -beta,          -mu, heave.to_pitch,
                    1.0,            0.0, 0.0,
                    heave.from_rate, 0.0, -heave.damping,
                ]),
                DVector::from_vec(vec![kappa, 0.0, heave.from_input]),
            ),
        }
    }

    /// Numbers in the state.
    #[must_use]
    pub fn states(&self) -> usize {
        if self.heave.is_some() { 3 } else { 2 }
    }

    /// The characteristic polynomial, `(s^2 + beta s + mu)(s + zeta) - nu eta s`.
    #[must_use]
    pub fn characteristic(&self, [_, beta, mu]: [f64; UNKNOWNS]) -> Vec<f64> {
        match self.heave {
            None => vec![1.0, beta, mu],
            Some(h) => vec![
                1.0,
                beta + h.damping,
                mu + beta * h.damping - h.to_pitch * h.from_rate,
                mu * h.damping,
            ],
        }
    }

    /// `[F G]` over one interval and its slope by each unknown, `(states) x (states + 1)`.
    fn step(&self, parameters: [f64; UNKNOWNS], dt: f64) -> [DMatrix<f64>; UNKNOWNS + 1] {
        let n = self.states();
        let (a, b) = self.equations(parameters);
        let mut m = DMatrix::zeros(n + 1, n + 1);
        m.view_mut((0, 0), (n, n)).copy_from(&a);
        m.view_mut((0, n), (n, 1)).copy_from(&b);
        // Where kappa, beta and mu stand in M, and with which sign.
        let places = [(n, 1.0), (0, -1.0), (1, -1.0)];
        let exponential = |(column, sign): (usize, f64)| {
            let mut both = DMatrix::zeros(2 * (n + 1), 2 * (n + 1));
            both.view_mut((0, 0), (n + 1, n + 1)).copy_from(&m);
            both.view_mut((n + 1, n + 1), (n + 1, n + 1)).copy_from(&m);
            both[(n + 1, column)] = sign;
            (both * dt).exp()
        };
        let all = places.map(exponential);
        [
            all[0].view((0, 0), (n, n + 1)).into_owned(),
            all[0].view((n + 1, 0), (n, n + 1)).into_owned(),
            all[1].view((n + 1, 0), (n, n + 1)).into_owned(),
            all[2].view((n + 1, 0), (n, n + 1)).into_owned(),
        ]
    }

    /// The pitch rate from rest and its slopes by the unknowns, one column each.
    fn simulate(&self, parameters: [f64; UNKNOWNS], dt: f64, inputs: &[f64]) -> [Vec<f64>; 4] {
        let n = self.states();
        let [step, slopes @ ..] = self.step(parameters, dt);
        let mut x = DVector::zeros(n + 1);
        let mut sensitivities = [DVector::zeros(n), DVector::zeros(n), DVector::zeros(n)];
        let mut outputs = [vec![], vec![], vec![], vec![]];
        for u in inputs {
            outputs[0].push(x[0]);
            x[n] = *u;
            let transition = step.columns(0, n);
            for (i, sensitivity) in sensitivities.iter_mut().enumerate() {
                outputs[i + 1].push(sensitivity[0]);
                *sensitivity = transition * &*sensitivity + &slopes[i] * &x;
            }
            let next = &step * &x;
            x.rows_mut(0, n).copy_from(&next);
        }
        outputs
    }
}

/// The vehicle found.
#[derive(Clone, Debug)]
pub struct VehicleEstimate {
    /// What was known.
    pub vehicle: Vehicle,
    /// `kappa` (output unit per input unit per s), `beta` (1/s), `mu` (1/s^2).
    pub parameters: [f64; UNKNOWNS],
    /// Their covariance.
    pub covariance: Matrix3<f64>,
    /// The gyro's bias in each record, output unit.
    pub biases: Vec<f64>,
    /// The noise's variance, output unit squared.
    pub noise_variance: f64,
}

impl VehicleEstimate {
    /// The poles, 1/s, the one with the largest real part first, with their uncertainty.
    ///
    /// # Errors
    /// A sentence, when the roots cannot be found.
    pub fn poles(&self) -> Result<Vec<Uncertain>, String> {
        let polynomial = self.vehicle.characteristic(self.parameters);
        let roots = polynomial::roots(&polynomial).map_err(|reason| reason.to_string())?;
        let derivative = polynomial::derivative(&polynomial);
        let p = self.covariance.fixed_view::<2, 2>(1, 1).into_owned();
        Ok(roots
            .into_iter()
            .map(|s| {
                let slope = -polynomial::evaluate(&derivative, s).inv();
                let heave = self
                    .vehicle
                    .heave
                    .map_or(Complex::new(1.0, 0.0), |h| s + h.damping);
                let (by_beta, by_mu) = (slope * s * heave, slope * heave);
                let j = Matrix2::new(by_beta.re, by_mu.re, by_beta.im, by_mu.im);
                Uncertain {
                    value: s,
                    covariance: j * p * j.transpose(),
                }
            })
            .collect())
    }

    /// The sampled response from the input, held over `dt`, to the output at `omega` rad/s, with its
    /// uncertainty: `C (z - F)^-1 G`, and with `R = (z - F)^-1` its slopes `C R (dF R G + dG)`.
    #[must_use]
    pub fn sampled_response(&self, dt: f64, omega: f64) -> Option<Uncertain> {
        let n = self.vehicle.states();
        let complex = |m: &DMatrix<f64>| m.map(|v| Complex::new(v, 0.0));
        let [step, slopes @ ..] = self.vehicle.step(self.parameters, dt).map(|m| complex(&m));
        let z = Complex::new(0.0, omega * dt).exp();
        let resolvent = (DMatrix::identity(n, n) * z - step.columns(0, n)).try_inverse()?;
        let state = &resolvent * step.column(n);
        let value = state[0];
        let by = slopes.map(|slope| {
            let moved = slope.columns(0, n) * &state + slope.column(n);
            (resolvent.row(0) * moved)[0]
        });
        let j =
            nalgebra::Matrix2x3::new(by[0].re, by[1].re, by[2].re, by[0].im, by[1].im, by[2].im);
        Some(Uncertain {
            value,
            covariance: j * self.covariance * j.transpose(),
        })
    }

    /// `J`, `K`, `B`, `M_theta` when the moment of inertia is known from elsewhere: values and standard
    /// deviations (ratios are all that a record tells).
    #[must_use]
    pub fn with_inertia(&self, inertia: f64) -> [(f64, f64); UNKNOWNS] {
        [0, 1, 2].map(|i| {
            let deviation = self.covariance[(i, i)].max(0.0).sqrt();
            (self.parameters[i] * inertia, deviation * inertia)
        })
    }
}

/// Decay rates that first guesses are made of, from the record's length to one sample.
const GUESSES: usize = 6;

/// The vehicle of least simulated error, each record from rest with a bias of its own.
///
/// # Errors
/// A sentence, when the records do not determine the unknowns.
pub fn fit(vehicle: Vehicle, dt: f64, runs: &[Run<'_>]) -> Result<VehicleEstimate, String> {
    let linearise = |theta: &DVector<f64>| linearised(vehicle, dt, runs, theta);
    let longest = runs
        .iter()
        .map(|run| run.outputs.len())
        .max()
        .unwrap_or(0)
        .max(2);
    let rate = |i: usize| (longest as f64).powf(i as f64 / (GUESSES - 1) as f64 - 1.0) / dt;
    let mut starts: Vec<(f64, DVector<f64>)> = (0..GUESSES)
        .flat_map(|i| (0..=i).map(move |j| (rate(i), rate(j))))
        .filter_map(|(fast, slow)| {
            let mut theta = DVector::zeros(UNKNOWNS + runs.len());
            (theta[1], theta[2]) = (fast + slow, fast * slow);
            // kappa and the biases enter linearly.
            let at = linearise(&theta);
            let linear = at.slopes.clone().remove_columns(1, 2);
            let rest = Triangle::of(linear, at.errors).ok()?.solution().ok()?;
            theta[0] = rest[0];
            theta
                .rows_mut(UNKNOWNS, runs.len())
                .copy_from(&rest.rows(1, runs.len()));
            let cost = linearise(&theta).errors.norm_squared();
            cost.is_finite().then_some((cost, theta))
        })
        .collect();
    starts.sort_by(|p, q| p.0.total_cmp(&q.0));
    let (theta, at) = starts
        .into_iter()
        .take(2)
        .filter_map(|(_, start)| minimise(start, linearise).ok())
        .min_by(|p, q| {
            p.1.errors
                .norm_squared()
                .total_cmp(&q.1.errors.norm_squared())
        })
        .ok_or("the records do not determine the vehicle")?;
    let noise_variance = at.errors.norm_squared() / freedom(at.errors.len(), theta.len())?;
    let covariance = unit_covariance(&at)? * noise_variance;
    Ok(VehicleEstimate {
        vehicle,
        parameters: [theta[0], theta[1], theta[2]],
        covariance: covariance.fixed_view::<3, 3>(0, 0).into_owned(),
        biases: theta.rows(UNKNOWNS, runs.len()).iter().copied().collect(),
        noise_variance,
    })
}

fn linearised(vehicle: Vehicle, dt: f64, runs: &[Run<'_>], theta: &DVector<f64>) -> Linearised {
    let rows = runs.iter().map(|run| run.outputs.len()).sum();
    let mut errors = DVector::zeros(rows);
    let mut slopes = DMatrix::zeros(rows, UNKNOWNS + runs.len());
    let mut row = 0;
    for (r, run) in runs.iter().enumerate() {
        let [rate, by @ ..] = vehicle.simulate([theta[0], theta[1], theta[2]], dt, run.inputs);
        for k in 0..run.outputs.len() {
            errors[row] = run.outputs[k] - rate[k] - theta[UNKNOWNS + r];
            for (i, slope) in by.iter().enumerate() {
                slopes[(row, i)] = slope[k];
            }
            slopes[(row, UNKNOWNS + r)] = 1.0;
            row += 1;
        }
    }
    Linearised { errors, slopes }
}
