//! The verdict on a model: conclusions from fit, residuals and uncertainty, as sentences.

use std::f64::consts::PI;

use nalgebra::Matrix2;

use super::Analysis;
use super::account::interval;
use crate::record::Record;
use crate::uncertainty::{Reading, SIGMAS_95};
use crate::validation::order_search;
use crate::validation::residuals::Correlation;

/// Standard deviations between two responses, at the worst of [`FREQUENCIES`], above which the estimates are of
/// different systems.
const APART: f64 = 4.0;
const FREQUENCIES: usize = 20;

impl Analysis {
    pub(super) fn judged(&self, doubts: Vec<String>, record: &Record) -> Vec<String> {
        let mut said = doubts;
        said.extend(self.left_out(record));
        said.extend(order_search::verdict(&self.candidates));
        said.extend(self.of_two_stages());
        match (self.held_out_fit, self.fit) {
            (Some(held), _) if held >= 90.0 => said.push(format!("simulated fit on held-out data {held:.1} %: very good")),
            (Some(held), Some(fit)) if held < fit - 20.0 => said.push(format!(
                "simulated fit on held-out data {held:.1} %, on the whole record {fit:.1} %: the model is overfitted, or the system changed"
            )),
            (Some(held), _) => said.push(format!("simulated fit on held-out data {held:.1} %")),
            (None, _) => said.push("not validated: in the held-out data the output stays within the noise".to_owned()),
        }
        said.extend(self.of_residuals());
        said.extend(self.suspicious_poles());
        said
    }

    /// Poles that are probably artefacts of noise, are unstable, or cancel.
    fn suspicious_poles(&self) -> Vec<String> {
        let reading = self.reading();
        let (Ok(poles), Ok(mut zeros)) = (reading.poles(), reading.zeros()) else {
            return Vec::new();
        };
        if self.estimate.physical.is_some() {
            // Its order is the equations', which cannot be lower.
            zeros.clear();
        }
        let mut said = Vec::new();
        for pole in poles.iter().filter(|pole| pole.value.im >= 0.0) {
            let at = interval(pole);
            if pole.value.re < 0.0 && pole.covariance != Matrix2::zeros() {
                let kind = match pole.value.im {
                    0.0 => "a negative real pole",
                    _ => "a pole pair with negative real part",
                };
                said.push(format!("{kind}, z = {at}: probably an artefact of noise"));
            } else if pole.value.norm() - SIGMAS_95 * pole.magnitude_deviation() > 1.0 {
                said.push(format!(
                    "the pole at z = {at} is unstable, beyond its 95 % interval"
                ));
            }
            let cancels = zeros.iter().any(|zero| {
                let apart = (zero.value - pole.value).norm();
                let joint = zero.magnitude_deviation().hypot(pole.magnitude_deviation());
                joint > 0.0 && apart < SIGMAS_95 * joint && apart < 0.2
            });
            if cancels {
                said.push(format!(
                    "a zero may cancel the pole at z = {at}: try a lower order"
                ));
            }
        }
        said
    }

    /// The parts of the record that were not used, or only for the fit.
    fn left_out(&self, record: &Record) -> Vec<String> {
        let mut said = Vec::new();
        let all = record.stretches.len();
        if self.stretches.len() < all {
            let kept = self.stretches.iter().map(|it| record.stretches[*it].len());
            said.push(format!(
                "of {all} segments the {} longest were used, {:.1} % of the samples",
                self.stretches.len(),
                100.0 * kept.sum::<usize>() as f64 / record.samples().max(1) as f64
            ));
        }
        if !self.candidates.is_empty() && self.searched < record.samples() {
            said.push(format!(
                "order and delay were searched on the {} of {} samples where the input varies most; the model was fitted to all",
                self.searched,
                record.samples()
            ));
        }
        said
    }

    /// The effect of the two stages: both magnitudes of the response, where they differ most.
    fn of_two_stages(&self) -> Option<String> {
        let (direct, reference) = (self.direct.as_ref()?, self.reference.as_ref()?);
        let (staged, direct) = (self.reading(), Reading::of(direct, self.longest));
        let nyquist = PI / self.estimate.sample_time;
        let share = |i: usize| 10_f64.powf(-3.0 * i as f64 / FREQUENCIES as f64);
        let moved = (0..=FREQUENCIES).filter_map(|i| {
            let omega = nyquist * share(i);
            let pair = [staged.response(omega)?, direct.response(omega)?];
            let [found, other] = pair.map(|it| (it.value.norm(), it.magnitude_deviation()));
            let joint = found.1.hypot(other.1);
            let apart = (found.0 - other.0).abs() / joint;
            (joint > 0.0).then_some((apart, omega, found, other))
        });
        let (apart, omega, found, other) = moved.max_by(|p, q| p.0.total_cmp(&q.0))?;
        let size =
            |(size, deviation): (f64, f64)| format!("{size:.4} ± {:.4}", SIGMAS_95 * deviation);
        let verdict = if apart > APART {
            format!("{apart:.1} standard deviations away: feedback of noise biases the direct fit")
        } else {
            "no significant difference: feedback of noise does not bias the direct fit".to_owned()
        };
        Some(format!(
            "magnitude of the response at {omega:.3} rad/s: {} in two stages from {reference}, {} by a direct fit; {verdict}",
            size(found),
            size(other)
        ))
    }

    /// The results of the residual tests.
    fn of_residuals(&self) -> Vec<String> {
        let Some(tests) = &self.residuals else {
            return Vec::new();
        };
        let against = match self.reference {
            Some(_) => "the reference",
            None => "the input",
        };
        let (earlier, later) = (tests.of_earlier_inputs(), tests.of_later_inputs());
        let mut said = vec![match (earlier.passes(), tests.whiteness.passes()) {
            (true, true) => format!(
                "residuals are white and uncorrelated with {against}: the model explains the data"
            ),
            (true, false) => format!(
                "residuals are uncorrelated with {against} but not white ({}): the model is valid, its standard deviations are not reliable",
                evidence(&tests.whiteness)
            ),
            (false, _) => format!(
                "residuals correlate with {against} ({}): dynamics are missing; try a higher order or another delay",
                evidence(&earlier)
            ),
        }];
        if !later.passes() && self.reference.is_none() {
            said.push(format!(
                "residuals correlate with later inputs ({}): the data is closed-loop, and the model may be biased; give the loop's reference (--reference) or use --method armax",
                evidence(&later)
            ));
        }
        said
    }
}

/// The result of a correlation test in numbers.
fn evidence(found: &Correlation) -> String {
    let largest = found
        .values
        .iter()
        .fold(0.0_f64, |m, (_, r)| m.max(r.abs()));
    format!(
        "max {largest:.2}, 99 % bound {:.2}, exceeded at {} of {} lags",
        found.bound,
        found.outside(),
        found.values.len()
    )
}
