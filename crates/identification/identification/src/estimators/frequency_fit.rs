//! A frequency response, and the transfer function with dead time that was fitted to it.

use nalgebra::{DMatrix, DVector};
use planesman_linear::{Complex, DelayedLoop};

use super::delayed_transfer::{HeldInputTransfer, Orders};
use crate::frequency::{Point, Row, rows};

/// Orders that were tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// The orders.
    pub orders: Orders,
    /// The dead time, s.
    pub delay: f64,
    /// J.
    pub cost: f64,
    /// The criterion.
    pub bic: f64,
}

/// A frequency response and its fitted transfer function.
#[derive(Clone, Debug)]
pub struct FrequencyFit {
    /// The response, at increasing frequencies.
    pub points: Vec<Point>,
    /// Lengths of the windows, samples.
    pub windows: Vec<usize>,
    /// The lowest coherence used.
    pub coherence: f64,
    /// The lowest and the highest frequency used, rad/s.
    pub band: (f64, f64),
    /// Whether each point was used.
    pub used: Vec<bool>,
    /// Whether the response is `S_ry / S_ru`.
    pub by_reference: bool,
    /// What was sought.
    pub orders: Orders,
    /// The transfer function and its dead time.
    pub transfer: DelayedLoop,
    /// The unknowns, by [`Orders::names`].
    pub values: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// J.
    pub cost: f64,
    /// The orders tried, best first.
    pub candidates: Vec<Candidate>,
}

impl FrequencyFit {
    /// Name, value and standard deviation of each unknown.
    pub fn named(&self) -> impl Iterator<Item = (String, f64, f64)> {
        let each = self.orders.names().into_iter().zip(&self.values);
        each.enumerate().map(|(i, (name, value))| {
            let deviation = self.covariance[(i, i)].max(0.0).sqrt();
            (name, *value, deviation)
        })
    }

    /// The transfer function in letters.
    #[must_use]
    pub fn equation(&self) -> String {
        let orders = &self.orders;
        let power = |power: usize| match power {
            0 => String::new(),
            1 => " s".to_owned(),
            power => format!(" s^{power}"),
        };
        let known = |power: usize| match power {
            0 => String::new(),
            1 => "s ".to_owned(),
            power => format!("s^{power} "),
        };
        let terms = |letter: char, highest: usize| -> Vec<String> {
            let powers = (0..=highest).rev();
            powers
                .map(|it| format!("{letter}{it}{}", power(it)))
                .collect()
        };
        let num = match orders.zeros {
            0 => "b0".to_owned(),
            zeros => format!("({})", terms('b', zeros).join(" + ")),
        };
        let num = known(orders.differentiators) + &num;
        let mut den = vec![power(orders.poles).trim_start().to_owned()];
        if let Some(highest) = orders.poles.checked_sub(1) {
            den.extend(terms('a', highest));
        }
        let den = known(orders.integrators) + &format!("({})", den.join(" + "));
        let delay = match orders.delay {
            Some(0.0) => "",
            _ => " e^(-theta s)",
        };
        format!("{num}{delay} / ({den})")
            .replace("/ ((", "/ (")
            .replace("))", ")")
    }

    /// The measured and the model's response at each frequency, for a table or a plot.
    #[must_use]
    pub fn rows(&self, sample_time: f64) -> Vec<Row> {
        let held = HeldInputTransfer::new(&self.transfer, sample_time).ok();
        rows(&self.points, &self.used, |omega| held.as_ref()?.at(omega))
    }

    /// The model's response under zero-order hold at a frequency, rad/s.
    #[must_use]
    pub fn model_at(&self, omega: f64, sample_time: f64) -> Option<Complex<f64>> {
        HeldInputTransfer::new(&self.transfer, sample_time)
            .ok()?
            .at(omega)
    }
}
