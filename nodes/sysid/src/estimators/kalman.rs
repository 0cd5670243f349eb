//! State and parameters of the vehicle's equations together, by an extended Kalman filter: what the
//! thesis names as future work (Brunner 1988, p. 93: it "might be able to compensate" disturbances
//! and biases).
//!
//! ```text
//! x = (q, theta[, w], kappa, beta, mu, bias)
//! x_dot = f(x, u): the vehicle's equations, parameters and bias constant or drifting
//! y = q + bias + noise
//! ```
//! (Equations: [`super::vehicle`].) Mean and transition matrix are carried from sample to sample by one
//! Runge-Kutta step of both; the covariance is corrected in Joseph's form, which stays symmetric and
//! positive. A filter that begins far off linearises in the wrong place and is then too sure of
//! itself (Ljung, *IEEE Trans. Autom. Control* 24, 1979): over a record at hand, [`fit`] passes
//! again from where it ended, with the covariance it began with.

use nalgebra::{DMatrix, DVector};

use super::recursive::Recursive;
use super::vehicle::{UNKNOWNS, Vehicle, VehicleEstimate};
use crate::structure::Run;

/// Where the filter begins and what it takes for noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// `kappa`, `beta`, `mu` before the first sample.
    pub parameters: [f64; UNKNOWNS],
    /// Their standard deviations.
    pub deviations: [f64; UNKNOWNS],
    /// The bias' standard deviation about 0, output unit.
    pub bias_deviation: f64,
    /// The gyro noise's standard deviation, output unit.
    pub noise: f64,
    /// How far the bias drifts in one second, output unit.
    pub bias_drift: f64,
    /// How far each parameter drifts in one second.
    pub drift: [f64; UNKNOWNS],
    /// How far disturbances move the rate in one second, output unit.
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
    /// Follows the motion and learns nothing.
    frozen: bool,
    error: Option<f64>,
}

impl Settings {
    /// # Errors
    /// A sentence, when a deviation is negative or not finite, or the noise is 0.
    fn check(&self) -> Result<(), String> {
        let sizes = [
            self.bias_deviation,
            self.bias_drift,
            self.disturbance,
            self.motion,
        ];
        let sound = |v: &f64| *v >= 0.0 && v.is_finite();
        let mut all = sizes.iter().chain(&self.deviations).chain(&self.drift);
        if !all.all(sound) || self.parameters.iter().any(|v| !v.is_finite()) {
            return Err("the Kalman filter's deviations must not be negative".to_owned());
        }
        if !(self.noise > 0.0 && self.noise.is_finite()) {
            return Err("the Kalman filter needs noise above 0".to_owned());
        }
        Ok(())
    }
}

impl Filter {
    /// A filter before its first sample.
    ///
    /// # Errors
    /// A sentence, when a deviation is negative or not finite, or the noise is 0.
    pub fn new(vehicle: Vehicle, sample_time: f64, settings: Settings) -> Result<Self, String> {
        settings.check()?;
        if sample_time.is_nan() || sample_time <= 0.0 {
            return Err("the Kalman filter needs an interval above 0".to_owned());
        }
        let n = vehicle.states();
        let size = n + UNKNOWNS + 1;
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

    /// What has been found.
    #[must_use]
    pub fn estimate(&self) -> VehicleEstimate {
        let n = self.vehicle.states();
        VehicleEstimate {
            vehicle: self.vehicle,
            parameters: self.unknowns(),
            covariance: self.p.fixed_view::<3, 3>(n, n).into_owned(),
            biases: vec![self.x[n + UNKNOWNS]],
            noise_variance: self.settings.noise.powi(2),
        }
    }

    /// Takes other noises and drifts from the next sample on; what it began with stays.
    ///
    /// # Errors
    /// As [`Filter::new`]; nothing changes then.
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), String> {
        settings.check()?;
        self.settings = settings;
        Ok(())
    }

    /// From now on follows the motion and learns nothing, or learns again. Frozen, the unknowns' gains are 0:
    /// their covariance still counts in the motion's (Schmidt 1966), and does not change.
    pub fn set_frozen(&mut self, frozen: bool) {
        self.frozen = frozen;
    }

    /// By how much the last output missed its prediction, output unit; `None` when there was none.
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        self.error
    }

    /// What is known of the vehicle.
    #[must_use]
    pub fn vehicle(&self) -> Vehicle {
        self.vehicle
    }

    /// `kappa, beta, mu, bias` and their covariance.
    #[must_use]
    pub fn learnt(&self) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.vehicle.states();
        let count = UNKNOWNS + 1;
        (
            self.x.rows(n, count).into_owned(),
            self.p.view((n, n), (count, count)).into_owned(),
        )
    }

    fn unknowns(&self) -> [f64; UNKNOWNS] {
        let n = self.vehicle.states();
        [self.x[n], self.x[n + 1], self.x[n + 2]]
    }

    /// `f(x, u)` and its slope by x.
    fn equations(&self, x: &DVector<f64>, u: f64) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.vehicle.states();
        let (a, b) = self.vehicle.equations([x[n], x[n + 1], x[n + 2]]);
        let size = x.len();
        let mut f = DVector::zeros(size);
        f.rows_mut(0, n).copy_from(&(&a * x.rows(0, n) + b * u));
        let mut slope = DMatrix::zeros(size, size);
        slope.view_mut((0, 0), (n, n)).copy_from(&a);
        slope[(0, n)] = u;
        slope[(0, n + 1)] = -x[0];
        slope[(0, n + 2)] = -x[1];
        (f, slope)
    }

    /// Mean and covariance over one interval.
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

    /// The gain and correction of one measurement.
    fn correct(&mut self, y: f64) {
        let size = self.x.len();
        let mut h = DVector::zeros(size);
        (h[0], h[size - 1]) = (1.0, 1.0);
        let r = self.settings.noise.powi(2);
        let ph = &self.p * &h;
        let mut gain = &ph / (h.dot(&ph) + r);
        if self.frozen {
            gain.rows_mut(size - UNKNOWNS - 1, UNKNOWNS + 1).fill(0.0);
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
        let n = self.vehicle.states();
        let kept = self
            .p
            .view((n, n), (UNKNOWNS + 1, UNKNOWNS + 1))
            .into_owned();
        self.p.fill(0.0);
        self.p
            .view_mut((n, n), (UNKNOWNS + 1, UNKNOWNS + 1))
            .copy_from(&kept);
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
        DVector::from_row_slice(&self.unknowns())
    }

    fn covariance(&self) -> Option<DMatrix<f64>> {
        let n = self.vehicle.states();
        Some(self.p.view((n, n), (UNKNOWNS, UNKNOWNS)).into_owned())
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
        let bias = n + UNKNOWNS;
        self.p[(bias, bias)] = self.settings.bias_deviation.powi(2);
    }
}

/// The filter over a record, `passes` times, each beginning where the last one ended.
///
/// # Errors
/// As [`Filter::new`]; a filter that leaves the numbers that can be reckoned with.
pub fn fit(
    vehicle: Vehicle,
    sample_time: f64,
    settings: Settings,
    run: Run<'_>,
    passes: usize,
) -> Result<VehicleEstimate, String> {
    let mut settings = settings;
    let mut found = None;
    for _ in 0..passes.max(1) {
        let mut filter = Filter::new(vehicle, sample_time, settings)?;
        super::recursive::learn(&mut filter, run);
        let estimate = filter.estimate();
        if estimate.parameters.iter().any(|v| !v.is_finite()) {
            return Err("the Kalman filter diverged".to_owned());
        }
        settings.parameters = estimate.parameters;
        found = Some(estimate);
    }
    found.ok_or_else(|| "the Kalman filter saw nothing".to_owned())
}
