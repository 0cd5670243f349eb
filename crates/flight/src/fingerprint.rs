//! What is compared of an identified model and the true one: poles and gains.

use planesman_linear::{Complex, mode_text};
use planesman_msgs::planesman_msgs::msg::ModelEstimate;

/// The characteristics of a transfer function that are compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Fingerprint {
    /// Continuous poles, 1/s, slowest first.
    pub poles: Vec<Complex<f64>>,
    /// Gain at rest, output unit per input unit; `None` with a pole at rest.
    pub dc_gain: Option<f64>,
    /// Response to a held unit input after one, two, … samples (the impulse response of
    /// the sampled system): the gain at short times.
    pub first_response: f64,
}

impl Fingerprint {
    /// The slowest pole; of a pair the one with the positive imaginary part.
    #[must_use]
    pub fn dominant(&self) -> Option<Complex<f64>> {
        let slowest = *self.poles.first()?;
        Some(Complex::new(slowest.re, slowest.im.abs()))
    }

    /// What the poles do, slowest first, a pair once.
    #[must_use]
    pub fn modes(&self) -> Vec<String> {
        let once = self.poles.iter().filter(|pole| pole.im >= 0.0);
        once.map(|pole| mode_text(*pole)).collect()
    }
}

/// The characteristics of an estimate.
#[must_use]
pub fn identified(model: &ModelEstimate) -> Fingerprint {
    let poles = model
        .s_poles_re
        .iter()
        .zip(&model.s_poles_im)
        .map(|(re, im)| Complex::new(*re, *im))
        .collect();
    Fingerprint {
        poles: slowest_first(poles),
        dc_gain: model.has_dc_gain.then_some(model.dc_gain),
        first_response: model.b.first().copied().unwrap_or(0.0),
    }
}

/// Poles by their magnitude, of a pair the one above the real axis first.
pub fn slowest_first(mut poles: Vec<Complex<f64>>) -> Vec<Complex<f64>> {
    poles.sort_by(|a, b| {
        a.norm()
            .total_cmp(&b.norm())
            .then_with(|| b.im.total_cmp(&a.im))
    });
    poles
}
