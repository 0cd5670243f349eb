//! Estimates state and parameters of the vehicle's equations together by an extended Kalman filter, which the thesis proposes as future
//! work (Brunner 1988, p. 93: it "might be able to compensate" disturbances and biases).
//!
//! ```text
//! x = (q, theta[, w], kappa, beta, mu, bias)
//! x_dot = f(x, u): the vehicle's equations, parameters and bias constant or drifting
//! y = q + bias + noise
//! ```
//! (Equations: [`super::vehicle`].) One Runge-Kutta step propagates mean and transition matrix from sample to sample; the covariance is
//! corrected in Joseph's form, which stays symmetric and positive. A filter with a poor start linearises at the wrong place and then
//! underestimates its uncertainty (Ljung, *IEEE Trans. Autom. Control* 24, 1979). So for complete records [`VehicleFilter`](super::VehicleFilter)
//! makes further passes, which start from the final pitch coefficients and the initial covariance. Each pass begins with the prior knowledge of
//! heave.

use nalgebra::{DMatrix, DVector};

use super::estimator::Recursive;
use super::physical::{NAMES, Physical, UNKNOWNS};
use super::vehicle::Vehicle;
use crate::error::{IdentificationError, Result};

/// Initial values and noise levels of the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Initial `kappa`, `beta`, `mu`.
    pub parameters: [f64; UNKNOWNS],
    /// Their standard deviations.
    pub deviations: [f64; UNKNOWNS],
    /// The bias' standard deviation about 0, output unit.
    pub bias_deviation: f64,
    /// The gyro noise's standard deviation, output unit.
    pub noise: f64,
    /// Standard deviation of the bias drift in one second, output unit.
    pub bias_drift: f64,
    /// Standard deviation of the drift of each parameter in one second.
    pub drift: [f64; UNKNOWNS],
    /// Standard deviation of the rate's change by disturbances in one second, output unit.
    pub disturbance: f64,
    /// The standard deviation of each state when a record begins, output unit; 0 for rest.
    pub motion: f64,
}

/// The filter.
#[derive(Clone, Debug)]
pub struct Filter {
    vehicle: Vehicle,
    settings: Settings,
    sample_time: f64,
    x: DVector<f64>,
    p: DMatrix<f64>,
    /// Whether the filter only follows the motion, without learning.
    frozen: bool,
    error: Option<f64>,
}

impl Settings {
    /// # Errors
    /// [`IdentificationError`], if a deviation is negative or not finite, or the noise is 0.
    fn check(&self) -> Result<()> {
        let sizes = [
            self.bias_deviation,
            self.bias_drift,
            self.disturbance,
            self.motion,
        ];
        let sound = |v: &f64| *v >= 0.0 && v.is_finite();
        let mut all = sizes.iter().chain(&self.deviations).chain(&self.drift);
        if !all.all(sound) || self.parameters.iter().any(|v| !v.is_finite()) {
            return Err(IdentificationError::Option(
                "the Kalman filter's deviations must not be negative".to_owned(),
            ));
        }
        if !(self.noise > 0.0 && self.noise.is_finite()) {
            return Err(IdentificationError::Option(
                "the Kalman filter needs a noise variance above 0".to_owned(),
            ));
        }
        Ok(())
    }
}

impl Filter {
    /// A filter before its first sample.
    ///
    /// # Errors
    /// [`IdentificationError`], if a deviation is negative or not finite, or the noise is 0.
    pub fn new(vehicle: Vehicle, sample_time: f64, settings: Settings) -> Result<Self> {
        settings.check()?;
        if sample_time.is_nan() || sample_time <= 0.0 {
            return Err(IdentificationError::Option(
                "the Kalman filter needs an interval above 0".to_owned(),
            ));
        }
        let size = vehicle.states() + vehicle.unknowns() + 1;
        let mut filter = Self {
            vehicle,
            settings,
            sample_time,
            x: DVector::zeros(size),
            p: DMatrix::zeros(size, size),
            frozen: false,
            error: None,
        };
        filter.reset();
        Ok(filter)
    }

    /// The current estimate of the coefficients.
    #[must_use]
    pub fn physical(&self) -> Physical {
        let (n, unknowns) = (self.vehicle.states(), self.vehicle.unknowns());
        Physical {
            values: self.x.rows(n, unknowns).into_owned(),
            covariance: self.p.view((n, n), (unknowns, unknowns)).into_owned(),
        }
    }

    /// Changes noise levels and drifts from the next sample on; the initial values are kept.
    ///
    /// # Errors
    /// Like [`Filter::new`]; on an error nothing changes.
    pub fn set_settings(&mut self, settings: Settings) -> Result<()> {
        settings.check()?;
        self.settings = settings;
        Ok(())
    }

    /// The vehicle's sampled equations, and their slopes by the unknowns ([`Vehicle::sampled`]).
    #[must_use]
    pub fn sampled(&self) -> (DVector<f64>, DMatrix<f64>) {
        let coefficients = self.coefficients();
        self.vehicle.sampled(&coefficients, self.sample_time)
    }

    /// The unknown coefficients and the bias, and their covariance.
    #[must_use]
    pub fn learnt(&self) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.vehicle.states();
        let count = self.vehicle.unknowns() + 1;
        (
            self.x.rows(n, count).into_owned(),
            self.p.view((n, n), (count, count)).into_owned(),
        )
    }

    /// The current estimate of the bias, output unit.
    #[must_use]
    pub fn bias(&self) -> f64 {
        self.x[self.x.len() - 1]
    }

    /// The current estimate of all coefficients, including heave.
    pub(super) fn coefficients(&self) -> DVector<f64> {
        self.coefficients_at(&self.x)
    }

    /// All coefficients at a state.
    fn coefficients_at(&self, x: &DVector<f64>) -> DVector<f64> {
        let (n, unknowns) = (self.vehicle.states(), self.vehicle.unknowns());
        let mut coefficients = self.vehicle.coefficients([0.0; UNKNOWNS]);
        coefficients
            .rows_mut(0, unknowns)
            .copy_from(&x.rows(n, unknowns));
        coefficients
    }

    /// `f(x, u)` and its slope by x.
    fn equations(&self, x: &DVector<f64>, u: f64) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.vehicle.states();
        let equations = self.vehicle.equations(&self.coefficients_at(x));
        let driven = x.rows(0, n).into_owned().push(u);
        let size = x.len();
        let mut f = DVector::zeros(size);
        f.rows_mut(0, n).copy_from(&(&equations * &driven));
        let mut slope = DMatrix::zeros(size, size);
        slope
            .view_mut((0, 0), (n, n))
            .copy_from(&equations.columns(0, n));
        for i in 0..self.vehicle.unknowns() {
            slope
                .view_mut((0, n + i), (n, 1))
                .copy_from(&(self.vehicle.slope(i) * &driven));
        }
        (f, slope)
    }

    /// Propagates mean and covariance over one interval.
    fn predict(&mut self, u: f64) {
        let dt = self.sample_time;
        let size = self.x.len();
        let one = DMatrix::identity(size, size);
        let rate = |x: &DVector<f64>, phi: &DMatrix<f64>| {
            let (f, slope) = self.equations(x, u);
            (f, slope * phi)
        };
        let (f1, p1) = rate(&self.x, &one);
        let (f2, p2) = rate(&(&self.x + &f1 * (dt / 2.0)), &(&one + &p1 * (dt / 2.0)));
        let (f3, p3) = rate(&(&self.x + &f2 * (dt / 2.0)), &(&one + &p2 * (dt / 2.0)));
        let (f4, p4) = rate(&(&self.x + &f3 * dt), &(&one + &p3 * dt));
        self.x += (f1 + f2 * 2.0 + f3 * 2.0 + f4) * (dt / 6.0);
        let phi = one + (p1 + p2 * 2.0 + p3 * 2.0 + p4) * (dt / 6.0);
        self.p = &phi * &self.p * phi.transpose();
        let n = self.vehicle.states();
        self.p[(0, 0)] += self.settings.disturbance.powi(2) * dt;
        if self.frozen {
            return;
        }
        for (i, drift) in self.settings.drift.iter().enumerate() {
            self.p[(n + i, n + i)] += drift.powi(2) * dt;
        }
        self.p[(size - 1, size - 1)] += self.settings.bias_drift.powi(2) * dt;
    }

    /// Computes gain and correction for one measurement.
    fn correct(&mut self, y: f64) {
        let size = self.x.len();
        let mut h = DVector::zeros(size);
        (h[0], h[size - 1]) = (1.0, 1.0);
        let r = self.settings.noise.powi(2);
        let ph = &self.p * &h;
        let mut gain = &ph / (h.dot(&ph) + r);
        if self.frozen {
            let n = self.vehicle.states();
            gain.rows_mut(n, size - n).fill(0.0);
        }
        let error = y - h.dot(&self.x);
        self.error = Some(error);
        let x = &self.x + &gain * error;
        if x.iter().any(|v| !v.is_finite()) {
            return;
        }
        self.x = x;
        let keep = DMatrix::identity(size, size) - &gain * h.transpose();
        self.p = &keep * &self.p * keep.transpose() + &gain * gain.transpose() * r;
    }
}

impl Recursive for Filter {
    fn begin(&mut self, output: f64) {
        // The motion is forgotten, parameters and bias are kept.
        let (n, kept) = (self.vehicle.states(), self.vehicle.unknowns() + 1);
        let (_, known) = self.learnt();
        self.p.fill(0.0);
        self.p.view_mut((n, n), (kept, kept)).copy_from(&known);
        for i in 0..n {
            self.x[i] = 0.0;
            self.p[(i, i)] = self.settings.motion.powi(2);
        }
        self.correct(output);
        // Nothing had predicted it.
        self.error = None;
    }

    fn push(&mut self, input: f64, output: f64) {
        self.predict(input);
        self.correct(output);
    }

    fn parameters(&self) -> DVector<f64> {
        self.physical().values
    }

    fn names(&self) -> Vec<String> {
        let names = NAMES.iter().take(self.vehicle.unknowns());
        names.map(|name| (*name).to_owned()).collect()
    }

    fn covariance(&self) -> Option<DMatrix<f64>> {
        Some(self.physical().covariance)
    }

    fn error(&self) -> Option<f64> {
        self.error
    }

    /// If frozen, the unknowns' gains are 0: their covariance still affects the motion's (Schmidt 1966), and does not change.
    fn set_frozen(&mut self, frozen: bool) {
        self.frozen = frozen;
    }

    fn reset(&mut self) {
        let n = self.vehicle.states();
        self.x.fill(0.0);
        self.p.fill(0.0);
        for i in 0..n {
            self.p[(i, i)] = self.settings.motion.powi(2);
        }
        for i in 0..UNKNOWNS {
            self.x[n + i] = self.settings.parameters[i];
            self.p[(n + i, n + i)] = self.settings.deviations[i].powi(2);
        }
        for (i, (known, deviation)) in self.vehicle.prior().into_iter().enumerate() {
            let at = n + UNKNOWNS + i;
            self.x[at] = known;
            self.p[(at, at)] = deviation.powi(2);
        }
        let bias = self.x.len() - 1;
        self.p[(bias, bias)] = self.settings.bias_deviation.powi(2);
    }
}
