//! Poles and gains for the comparison of an identified model with the true one.

use planesman_linear::{Complex, ComplexFunctions as _, by_decay, is_sampling_artefact, mode_text};
use planesman_msgs::planesman_msgs::msg::ModelEstimate;

/// Characteristics of a transfer function for a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelSummary {
    /// Continuous poles, 1/s, slowest first ([`by_decay`]).
    pub poles: Vec<Complex<f64>>,
    /// Steady-state gain, output unit per input unit; `None` with a pole at s = 0.
    pub steady_state_gain: Option<f64>,
    /// First Markov parameter: the response to a unit pulse after one sample, output unit per input unit.
    pub first_markov_parameter: f64,
}

impl ModelSummary {
    /// The dominant pole, which is the slowest; of a complex pair, the pole with the positive imaginary part.
    #[must_use]
    pub fn dominant(&self) -> Option<Complex<f64>> {
        let slowest = *self.poles.first()?;
        Some(Complex::new(slowest.re, slowest.im.abs()))
    }

    /// Descriptions of the modes, slowest first; a complex pair is one mode.
    #[must_use]
    pub fn modes(&self) -> Vec<String> {
        let once = self.poles.iter().filter(|pole| pole.im >= 0.0);
        once.map(|pole| mode_text(*pole)).collect()
    }
}

/// Characteristics of an estimate.
#[must_use]
pub fn identified(model: &ModelEstimate) -> ModelSummary {
    let poles = model
        .s_poles_re
        .iter()
        .zip(&model.s_poles_im)
        .map(|(re, im)| Complex::new(*re, *im))
        .collect();
    ModelSummary {
        poles: slowest_first(poles, model.sample_time),
        steady_state_gain: model
            .has_steady_state_gain
            .then_some(model.steady_state_gain),
        first_markov_parameter: model.b.first().copied().unwrap_or(0.0),
    }
}

/// Poles in s in the order of [`by_decay`]; artefacts of the sampling time (s; 0 if there is none) come last.
#[must_use]
pub fn slowest_first(mut poles: Vec<Complex<f64>>, sample_time: f64) -> Vec<Complex<f64>> {
    let is_artefact =
        |s: &Complex<f64>| sample_time > 0.0 && is_sampling_artefact((s * sample_time).exp());
    poles.sort_by(|a, b| is_artefact(a).cmp(&is_artefact(b)).then(by_decay(a, b)));
    poles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dominant_pole_decays_slowest_and_is_no_artefact() {
        let pole = Complex::new;
        // Slower than -1, though it is further from the origin; ln(-0.9)/0.05 turns at the Nyquist frequency.
        let artefact = (Complex::new(-0.9, 0.0)).ln() / 0.05;
        let poles = vec![pole(-1.0, 0.0), artefact, pole(-0.1, -3.0), pole(-0.1, 3.0)];
        let summary = ModelSummary {
            poles: slowest_first(poles, 0.05),
            steady_state_gain: None,
            first_markov_parameter: 0.0,
        };
        assert_eq!(summary.dominant(), Some(pole(-0.1, 3.0)));
        assert_eq!(summary.poles.last(), Some(&artefact));
    }
}
