//! The vehicle in pitch: `theta'' = -k delta - b theta' - m theta`, bow up and dive positive (Brunner, NPS
//! thesis, 1988, ch. II, with `K`, `B` and `Me` over `J`): the pitch equation of `planesman_vehicle::pitch`
//! without heave, with `k = -kappa`, `b = beta`, `m = mu`.
//!
//! **From an identified model** of pitch rate over plane angle: its response to a unit step of planes from rest satisfies, integrated once,
//!
//! ```text
//! q(t) = -k t - b theta(t) - m int theta dt
//! ```
//! whose three coefficients are fitted by least squares over the first seconds. An order above two, caused by heave or noise, is thereby reduced to
//! the order that the loops can use. The uncertainty of the fit follows from the model's covariance by the derivatives of `k` and `b` with respect to
//! each identified coefficient.

use nalgebra::{DMatrix, Matrix3, Vector3};
use planesman_linear::TransferFunction;
use planesman_msgs::planesman_msgs::msg::ModelEstimate;

use super::distrust::Distrust;

/// The step response is fitted over this time, s: the pitch loop's own time scale.
const FITTED: f64 = 4.0;

/// Models with a longer sampling interval have too few samples for the fit; models with a shorter interval have too many.
const SAMPLES: std::ops::RangeInclusive<usize> = 8..=4000;

/// The relative step of a coefficient in difference quotients.
const NUDGE: f64 = 1e-6;

/// The vehicle in pitch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PitchModel {
    /// `k = K/J`, 1/s^2: dive moment per plane angle over inertia.
    pub plane: f64,
    /// `b = B/J`, 1/s.
    pub damping: f64,
    /// `m = Me/J`, 1/s^2.
    pub restoring: f64,
}

/// The vehicle in pitch over speed: `k ~ U^i`, `b ~ U^j`, `m` from weight alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLaw {
    /// The pitch model at the reference speed.
    pub model: PitchModel,
    /// `U_0`, m/s.
    pub reference_speed: f64,
    /// `i`: 2 in water, 0 in the report's Table 3.
    pub plane_exponent: f64,
    /// `j`: 1 in water, 0 in the report's Table 3.
    pub damping_exponent: f64,
}

impl SpeedLaw {
    /// The vehicle at a speed (m/s).
    #[must_use]
    pub fn at(&self, speed: f64) -> PitchModel {
        let ratio = speed / self.reference_speed;
        PitchModel {
            plane: self.model.plane * libm::pow(ratio, self.plane_exponent),
            damping: self.model.damping * libm::pow(ratio, self.damping_exponent),
            restoring: self.model.restoring,
        }
    }
}

/// A pitch model with standard deviations from its source's covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Identified {
    /// The model.
    pub model: PitchModel,
    /// Of `k`, 1/s^2.
    pub plane_deviation: f64,
    /// Of `b`, 1/s.
    pub damping_deviation: f64,
}

impl Identified {
    /// The vehicle in pitch from an estimate; its input must be the dive-plane angle (rad, dive) and its output the pitch rate (rad/s, bow
    /// up).
    ///
    /// # Errors
    /// If the estimate has other signals, is malformed, or its step response does not determine the model.
    pub fn from_estimate(estimate: &ModelEstimate) -> Result<Self, Distrust> {
        if !is_of_pitch(estimate) {
            return Err(Distrust::Signals {
                input: estimate.input.clone(),
                output: estimate.output.clone(),
            });
        }
        let count = estimate.a.len() + estimate.b.len() + estimate.c.len();
        let width = estimate.covariance.len().isqrt();
        if width < count || width * width != estimate.covariance.len() {
            return Err(Distrust::Covariance);
        }
        let coefficients: Vec<f64> = estimate.a.iter().chain(&estimate.b).copied().collect();
        let order = estimate.a.len();
        let fit = |c: &[f64]| reduced(&c[..order], &c[order..], estimate.sample_time);
        let model = fit(&coefficients)?;

        // Rows k and b of the Jacobian; a and b stand first in the covariance.
        let mut jacobian = DMatrix::zeros(2, coefficients.len());
        for i in 0..coefficients.len() {
            let mut nudged = coefficients.clone();
            let by = NUDGE * nudged[i].abs().max(1e-3);
            nudged[i] += by;
            let moved = fit(&nudged)?;
            jacobian[(0, i)] = (moved.plane - model.plane) / by;
            jacobian[(1, i)] = (moved.damping - model.damping) / by;
        }
        let n = coefficients.len();
        let covariance = DMatrix::from_fn(n, n, |i, j| estimate.covariance[width * i + j]);
        let spread = &jacobian * covariance * jacobian.transpose();
        let identified = Self {
            model,
            plane_deviation: spread[(0, 0)].max(0.0).sqrt(),
            damping_deviation: spread[(1, 1)].max(0.0).sqrt(),
        };
        let finite =
            identified.plane_deviation.is_finite() && identified.damping_deviation.is_finite();
        finite
            .then_some(identified)
            .ok_or(Distrust::InfiniteUncertainty)
    }
}

/// The name of the pair of signals that `sysid` identifies before any other (`ModelEstimate.msg`).
pub const FIRST_PAIR: &str = "model";

/// Whether an estimate is of pitch rate over plane angle, by its signals' names.
#[must_use]
pub fn is_of_pitch(estimate: &ModelEstimate) -> bool {
    let named = |name: &str, field: &str| name.rsplit([':', '.']).next() == Some(field);
    named(&estimate.input, "dive_planes") && named(&estimate.output, "pitch_rate")
}

/// `k`, `b` and `m` of the difference equation with these coefficients, `dt` seconds a sample.
fn reduced(a: &[f64], b: &[f64], dt: f64) -> Result<PitchModel, Distrust> {
    let samples = (FITTED / dt) as usize;
    if !(dt > 0.0 && SAMPLES.contains(&samples)) {
        return Err(Distrust::SampleTime(dt));
    }
    let mut den = vec![1.0];
    den.extend(a);
    let mut num = vec![0.0];
    num.extend(b);
    let rates = TransferFunction::new(num, den)
        .and_then(|g| g.simulate(&vec![1.0; samples + 1]))
        .map_err(|error| Distrust::Undetermined(error.to_string()))?;

    // Normal equations of q = -k t - b theta - m int theta.
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let (mut pitch, mut pitch_integral) = (0.0, 0.0);
    for (i, pair) in rates.windows(2).enumerate() {
        let next_pitch = pitch + 0.5 * (pair[0] + pair[1]) * dt;
        pitch_integral += 0.5 * (pitch + next_pitch) * dt;
        pitch = next_pitch;
        let row = -Vector3::new((i + 1) as f64 * dt, pitch, pitch_integral);
        normal += row * row.transpose();
        right += row * pair[1];
    }
    let solution = normal
        .svd(true, true)
        .solve(&right, f64::EPSILON)
        .map_err(|reason| Distrust::Undetermined(reason.to_owned()))?;
    if !solution.iter().all(|x| x.is_finite()) {
        return Err(Distrust::Overflow);
    }
    Ok(PitchModel {
        plane: solution[0],
        damping: solution[1],
        restoring: solution[2],
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use planesman_vehicle::pitch;

    /// The estimate that exact identification of `model` gives, with a standard deviation for each
    /// coefficient.
    pub(in crate::gains) fn estimate_of(
        model: &PitchModel,
        dt: f64,
        deviation: f64,
    ) -> ModelEstimate {
        let sampled = pitch::state_space(&[-model.plane, model.damping, model.restoring])
            .unwrap()
            .zero_order_hold(dt)
            .unwrap()
            .transfer_function(0, 0)
            .unwrap();
        let mut covariance = vec![0.0; 25];
        for i in 0..5 {
            covariance[6 * i] = deviation * deviation;
        }
        let offset = sampled.num.len() - 2;
        ModelEstimate {
            input: "plane_motion:dive_planes".to_owned(),
            output: "state:pitch_rate".to_owned(),
            sample_time: dt,
            order: 2,
            samples: 1000,
            a: sampled.den[1..].to_vec(),
            b: sampled.num[offset..].to_vec(),
            covariance,
            fit: 95.0,
            valid: true,
            ..ModelEstimate::default()
        }
    }

    const VEHICLE: PitchModel = PitchModel {
        plane: 0.47,
        damping: 1.2,
        restoring: 0.27,
    };

    #[test]
    fn an_exact_model_gives_the_vehicle_back() {
        let identified = Identified::from_estimate(&estimate_of(&VEHICLE, 0.05, 0.0)).unwrap();
        assert!(
            (identified.model.plane / VEHICLE.plane - 1.0).abs() < 1e-3,
            "{identified:?}"
        );
        assert!(
            (identified.model.damping / VEHICLE.damping - 1.0).abs() < 3e-3,
            "{identified:?}"
        );
        assert!(
            (identified.model.restoring / VEHICLE.restoring - 1.0).abs() < 1e-2,
            "{identified:?}"
        );
        assert_eq!(identified.plane_deviation, 0.0);
    }

    #[test]
    fn an_unsure_model_gives_an_unsure_vehicle() {
        let of =
            |deviation| Identified::from_estimate(&estimate_of(&VEHICLE, 0.05, deviation)).unwrap();
        let (sure, unsure) = (of(1e-6), of(1e-3));
        assert!((unsure.plane_deviation / sure.plane_deviation / 1e3 - 1.0).abs() < 1e-6);
        assert!(unsure.plane_deviation > 0.0 && unsure.damping_deviation > 0.0);
    }

    #[test]
    fn a_model_of_any_size_is_taken_or_refused_and_ends_nothing() {
        for wild in [1e308, -1e308, 1e200, 1e150, -1e80, 1e-308, 0.0] {
            for place in 0..5 {
                let mut estimate = estimate_of(&VEHICLE, 0.05, 1e-4);
                match place {
                    0 => estimate.a[0] = wild,
                    1 => estimate.a[1] = wild,
                    2 => estimate.b[0] = wild,
                    3 => estimate.b = vec![wild; 2],
                    _ => estimate.covariance = vec![wild; 25],
                }
                if let Ok(identified) = Identified::from_estimate(&estimate) {
                    assert!(
                        identified.model.plane.is_finite()
                            && identified.plane_deviation.is_finite()
                    );
                }
            }
        }
    }

    #[test]
    fn what_is_no_model_of_pitch_is_refused_with_the_reason() {
        let good = estimate_of(&VEHICLE, 0.05, 1e-4);
        let refused = |change: fn(&mut ModelEstimate)| {
            let mut changed = good.clone();
            change(&mut changed);
            Identified::from_estimate(&changed).unwrap_err().to_string()
        };
        assert!(refused(|m| m.output = "state:depth".to_owned()).contains("pitch_rate"));
        assert!(refused(|m| m.covariance.truncate(3)).contains("covariance"));
        assert!(refused(|m| m.sample_time = 0.0).contains("sample time"));
        assert!(refused(|m| m.sample_time = 1e-9).contains("sample time"));
        assert!(refused(|m| m.a = vec![-3.0e3, 2.0]).contains("refused"));
        assert!(refused(|m| m.covariance[0] = f64::INFINITY).contains("finite"));
    }
}
