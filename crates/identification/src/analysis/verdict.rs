//! The verdict on a model, in plain words.

use std::f64::consts::PI;

use nalgebra::Matrix2;

use super::Analysis;
use super::account::interval;
use crate::record::Record;
use crate::uncertainty::{Reading, SIGMAS_95};
use crate::validation::order_search;
use crate::validation::residuals::Correlation;

/// Standard deviations beyond which two estimates are not of one system, the furthest apart of so many
/// frequencies.
const APART: f64 = 4.0;
const FREQUENCIES: usize = 20;

impl Analysis {
    pub(super) fn judged(&self, doubts: Vec<String>, record: &Record) -> Vec<String> {
        let mut said = doubts;
        said.extend(self.left_out(record));
        said.extend(order_search::verdict(&self.candidates));
        said.extend(self.of_two_stages());
        match (self.held_out_fit, self.fit) {
            (Some(held), _) if held >= 90.0 => said.push(format!("it simulates {held:.1} % of what it was not fitted to: very good")),
            (Some(held), Some(fit)) if held < fit - 20.0 => said.push(format!(
                "it simulates {held:.1} % of what it was not fitted to, and {fit:.1} % of everything: it has learnt this record rather than the system, or the system changed"
            )),
            (Some(held), _) => said.push(format!("it simulates {held:.1} % of what it was not fitted to")),
            (None, _) => said.push("the output does not move beyond the noise in what was held out: nothing was checked".to_owned()),
        }
        said.extend(self.of_residuals());
        said.extend(self.suspicious_poles());
        said
    }

    /// Poles that are noise's rather than the system's.
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
                said.push(format!("the pole at z = {at} alternates from sample to sample: it is what noise makes of a fit, not the system's"));
            } else if pole.value.norm() - SIGMAS_95 * pole.magnitude_deviation() > 1.0 {
                said.push(format!(
                    "the pole at z = {at} is unstable beyond its uncertainty"
                ));
            }
            let cancels = zeros.iter().any(|zero| {
                let apart = (zero.value - pole.value).norm();
                let joint = zero.magnitude_deviation().hypot(pole.magnitude_deviation());
                joint > 0.0 && apart < SIGMAS_95 * joint && apart < 0.2
            });
            if cancels {
                said.push(format!(
                    "a zero may cancel the pole at z = {at}: a lower order would do as well"
                ));
            }
        }
        said
    }

    /// The parts of the record that were not used, or not everywhere.
    fn left_out(&self, record: &Record) -> Vec<String> {
        let mut said = Vec::new();
        let all = record.stretches.len();
        if self.stretches.len() < all {
            let kept = self.stretches.iter().map(|it| record.stretches[*it].len());
            said.push(format!(
                "of {all} stretches the {} longest were used, {:.1} % of the samples",
                self.stretches.len(),
                100.0 * kept.sum::<usize>() as f64 / record.samples().max(1) as f64
            ));
        }
        if !self.candidates.is_empty() && self.searched < record.samples() {
            said.push(format!(
                "the order was sought on {} of {} samples, where the input varies most, and the model fitted to all",
                self.searched,
                record.samples()
            ));
        }
        said
    }

    /// The effect of the two stages: the size of the response where it has moved most.
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
            format!(
                "{apart:.1} standard deviations away: noise that goes round the loop misleads the direct fit"
            )
        } else {
            "which is no further than chance: the loop hardly misleads the direct fit".to_owned()
        };
        Some(format!(
            "in two stages from {reference} the response at {omega:.3} rad/s comes out at {}; directly it would be {}, {verdict}",
            size(found),
            size(other)
        ))
    }

    /// Whether what is left over is noise.
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
                "what it leaves over is white and unrelated to {against}: nothing is left to explain"
            ),
            (true, false) => format!(
                "what it leaves over is unrelated to {against} but coloured ({}): the model stands, its standard errors are too small or too large",
                evidence(&tests.whiteness)
            ),
            (false, _) => format!(
                "what it leaves over still follows {against} before it ({}): dynamics are missing, a higher order or another delay may find them",
                evidence(&earlier)
            ),
        }];
        if !later.passes() && self.reference.is_none() {
            said.push(format!(
                "later inputs follow what it leaves over ({}): there is feedback, and the model may be the controller's as much as the plant's; give the loop's reference (--reference) or take --method armax",
                evidence(&later)
            ));
        }
        said
    }
}

/// The result of a test in numbers.
fn evidence(found: &Correlation) -> String {
    let largest = found
        .values
        .iter()
        .fold(0.0_f64, |m, (_, r)| m.max(r.abs()));
    format!(
        "{} of {} lags beyond 99 %, the largest {largest:.2} where chance makes {:.2}",
        found.outside(),
        found.values.len(),
        found.bound
    )
}
