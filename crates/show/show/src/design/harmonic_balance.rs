//! Harmonic balance of the depth loop with a digital hydraulic actuator: the limit cycle caused by its quantum.
//!
//! ```text
//! H(s) = [Kpy (1 + K_i/s) (Kpz U/s + Kdz U + 1) + Kr s] K/(s^2 + B s + M) e^(-s T/2)
//! ```
//! with the depth controller's default gains, at its sampling time T.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

use planesman_control::gains::PitchModel;
use planesman_hydraulics::describing_function::{Search, balance};
use planesman_hydraulics::frequency_response::{self, Periods};
use planesman_hydraulics::{ActuatorSet, Demand};
use planesman_linear::{Complex, ComplexFunctions as _};

use crate::design::subject::{RATE, default_gains};

/// Measured values of an actuator's describing function; the key contains the bits of amplitude, rad, and frequency, rad/s.
pub type Describing = RefCell<BTreeMap<(u64, u64), Complex<f64>>>;

/// Largest `|1 + N H|` at which a harmonic balance counts as a limit cycle.
pub const MOST_RESIDUAL: f64 = 0.1;

/// Below this frequency the describing function is measured over one period, rad/s.
const SLOW: f64 = 0.05 * TAU;

/// The depth loop of a vehicle without heave, with the depth controller's default gains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthLoop {
    /// Pitch dynamics of the vehicle.
    pub model: PitchModel,
    /// Speed U, m/s.
    pub speed: f64,
    /// Integral gain K_i, 1/s.
    pub integral: f64,
}

/// A limit cycle predicted by harmonic balance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Frequency, Hz.
    pub frequency: f64,
    /// Depth amplitude, peak to peak, m.
    pub depth: f64,
    /// `|1 + N H|`: 0 where the balance is exact.
    pub residual: f64,
}

impl DepthLoop {
    /// The limit cycle with the smallest residual of harmonic balance, 1 + N(A, w) H(jw) = 0, over a range of amplitudes of the actuator's command,
    /// rad. The describing function N is measured on the full model under a sinusoid, with friction, leakage and delays. `demand`: the command for
    /// an amplitude; `known`: earlier measurements of the same actuator.
    #[must_use]
    pub fn predict(
        &self,
        set: &ActuatorSet,
        amplitudes: (f64, f64),
        known: &Describing,
        demand: impl Fn(f64) -> Demand,
    ) -> Prediction {
        let measured = |amplitude: f64, frequency: f64| {
            let periods = Periods {
                settling: 1,
                // Of a slow sinusoid one period has hundreds of samples.
                measured: if frequency < SLOW { 1 } else { 3 },
            };
            frequency_response::actuator(set, demand(amplitude), frequency, periods)
        };
        let describing_function = |amplitude: f64, frequency: f64| {
            let place = (amplitude.to_bits(), frequency.to_bits());
            *known
                .borrow_mut()
                .entry(place)
                .or_insert_with(|| measured(amplitude, frequency))
        };
        let search = Search {
            amplitudes,
            frequencies: (0.02 * TAU, 0.5 * TAU),
        };
        let found = balance(&search, describing_function, |w| self.around_the_planes(w));
        let planes =
            found.amplitude * describing_function(found.amplitude, found.frequency).modulus();
        let climb = self.pitch(found.frequency) * self.speed;
        Prediction {
            frequency: found.frequency / TAU,
            depth: 2.0 * planes * climb.modulus() / found.frequency,
            residual: found.residual,
        }
    }

    /// Transfer function theta/delta of the vehicle in small motion at a frequency, rad/s.
    fn pitch(&self, frequency: f64) -> Complex<f64> {
        let s = Complex::new(0.0, frequency);
        let model = &self.model;
        Complex::from(model.plane) / (s * s + s * model.damping + model.restoring)
    }

    /// H = -delta_c/delta of vehicle and controller at a frequency, rad/s: the loop without the actuator. The controller's sampling is modelled
    /// as a dead time of half a tick.
    fn around_the_planes(&self, frequency: f64) -> Complex<f64> {
        let s = Complex::new(0.0, frequency);
        let (gains, speed) = (default_gains(), self.speed);
        let integral = self.integral / s + 1.0;
        let pitch_error = gains.depth_p * speed / s + gains.depth_d * speed + 1.0;
        let feedback = gains.pitch_p * integral * pitch_error + gains.pitch_rate * s;
        feedback * self.pitch(frequency) * (-s * (0.5 / RATE)).exp()
    }
}
