//! What a step response is judged by.
//!
//! The step goes `from` one level `to` another at the first sample. With the response scaled so
//! that `from` is 0 and `to` is 1, whichever way the step goes:
//!
//! - **rise time**: from first reaching 10 % to first reaching 90 %;
//! - **overshoot**: the highest value less 1, in percent, not below 0;
//! - **settling time**: from the step to the last entry into the band of 2 % (5 %) about 1;
//! - **steady error**: `to` less the mean over the last tenth of the record, unscaled;
//! - **ITAE**: the integral of time since the step times the scaled response's distance from 1.
//!
//! Between samples the response is taken as linear. These are the usual definitions (Franklin,
//! Powell and Emami-Naeini, *Feedback Control of Dynamic Systems*, ch. 3); all refer to the level
//! asked for, not to where the response happens to end.

use crate::{Error, error::finite};

/// The part of the record, at its end, whose mean stands for the steady value.
const STEADY_SHARE: f64 = 0.1;

/// The figures of one step response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepMetrics {
    /// 10 % to 90 %, in the unit of the times; `None` when 90 % is not reached.
    pub rise_time: Option<f64>,
    /// Beyond the new level, in percent of the step; 0 when it is not passed.
    pub overshoot: f64,
    /// To stay within 2 % of the step; `None` when the record ends outside.
    pub settling_time: Option<f64>,
    /// To stay within 5 % of the step; `None` when the record ends outside.
    pub settling_time_5: Option<f64>,
    /// `to` less the final value, in the unit of the values.
    pub steady_error: f64,
    /// `int t |1 - y| dt`, in the square of the unit of the times.
    pub itae: f64,
}

impl StepMetrics {
    /// The metrics of `values` at `times`, for a step `from` one level `to` another at
    /// `times[0]`.
    ///
    /// # Errors
    /// [`Error::Empty`], [`Error::Shape`] when the lists differ in length, [`Error::NotFinite`],
    /// [`Error::NotPositive`] when the times do not increase or the step is none.
    pub fn of(times: &[f64], values: &[f64], from: f64, to: f64) -> Result<Self, Error> {
        check(times, values, from, to)?;
        let scaled: Vec<f64> = values.iter().map(|y| (y - from) / (to - from)).collect();
        finite("the scaled response", &scaled)?;
        let rise_time = match (
            first_reached(times, &scaled, 0.1),
            first_reached(times, &scaled, 0.9),
        ) {
            (Some(start), Some(end)) => Some(end - start),
            _ => None,
        };
        let highest = scaled.iter().copied().fold(f64::MIN, f64::max);
        Ok(Self {
            rise_time,
            overshoot: 100.0 * (highest - 1.0).max(0.0),
            settling_time: settled(times, &scaled, 0.02),
            settling_time_5: settled(times, &scaled, 0.05),
            steady_error: to - final_value(times, values),
            itae: itae(times, &scaled),
        })
    }
}

/// As [`StepMetrics::of`].
///
/// # Errors
/// Those of [`StepMetrics::of`].
pub fn of(times: &[f64], values: &[f64], from: f64, to: f64) -> Result<StepMetrics, Error> {
    StepMetrics::of(times, values, from, to)
}

fn check(times: &[f64], values: &[f64], from: f64, to: f64) -> Result<(), Error> {
    if times.is_empty() {
        return Err(Error::Empty {
            what: "the response",
        });
    }
    if values.len() != times.len() {
        return Err(Error::Shape {
            what: "the response",
            found: format!("{} values", values.len()),
            expected: format!("one for each of {} times", times.len()),
        });
    }
    finite("the times", times)?;
    finite("the response", values)?;
    finite("the step", &[from, to])?;
    if from == to {
        return Err(Error::NotPositive {
            what: "the step's height",
            value: 0.0,
        });
    }
    if let Some(pair) = times.windows(2).find(|pair| pair[1] <= pair[0]) {
        return Err(Error::NotPositive {
            what: "the time between samples",
            value: pair[1] - pair[0],
        });
    }
    Ok(())
}

/// When the response first reaches `level`.
fn first_reached(times: &[f64], scaled: &[f64], level: f64) -> Option<f64> {
    let i = scaled.iter().position(|&y| y >= level)?;
    Some(match i.checked_sub(1) {
        None => times[0],
        Some(before) => crossing(times, scaled, before, level),
    })
}

/// How long after the first sample the response last enters the band about 1.
fn settled(times: &[f64], scaled: &[f64], band: f64) -> Option<f64> {
    let Some(outside) = scaled.iter().rposition(|y| (y - 1.0).abs() > band) else {
        return Some(0.0);
    };
    if outside + 1 == scaled.len() {
        return None;
    }
    let edge = if scaled[outside] > 1.0 {
        1.0 + band
    } else {
        1.0 - band
    };
    Some(crossing(times, scaled, outside, edge) - times[0])
}

/// When the line from sample `i` to the next passes `level`, which lies between them.
fn crossing(times: &[f64], scaled: &[f64], i: usize, level: f64) -> f64 {
    let share = (level - scaled[i]) / (scaled[i + 1] - scaled[i]);
    times[i] + share * (times[i + 1] - times[i])
}

/// `int t |1 - y| dt` by the trapezoidal rule.
fn itae(times: &[f64], scaled: &[f64]) -> f64 {
    let weighted = |i: usize| (times[i] - times[0]) * (1.0 - scaled[i]).abs();
    (1..times.len())
        .map(|i| 0.5 * (weighted(i - 1) + weighted(i)) * (times[i] - times[i - 1]))
        .sum()
}

fn final_value(times: &[f64], values: &[f64]) -> f64 {
    let last = times[times.len() - 1];
    let since = last - STEADY_SHARE * (last - times[0]);
    let start = times.partition_point(|&t| t < since);
    let steady = &values[start..];
    steady.iter().sum::<f64>() / steady.len() as f64
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn sampled(duration: f64, response: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let times: Vec<f64> = (0..=20_000)
            .map(|k| duration * f64::from(k) / 20_000.0)
            .collect();
        let values = times.iter().map(|&t| response(t)).collect();
        (times, values)
    }

    #[test]
    fn a_first_order_lag_rises_in_2_2_and_settles_in_3_9_time_constants() {
        let (times, values) = sampled(20.0, |t| 1.0 - (-t).exp());
        let metrics = of(&times, &values, 0.0, 1.0).unwrap();
        assert!((metrics.rise_time.unwrap() - 9f64.ln()).abs() < 1e-5);
        assert!((metrics.settling_time.unwrap() - 50f64.ln()).abs() < 1e-5);
        assert!((metrics.settling_time_5.unwrap() - 20f64.ln()).abs() < 1e-5);
        assert_eq!(metrics.overshoot, 0.0);
        assert!(metrics.steady_error.abs() < 1e-7);
    }

    #[test]
    fn a_second_order_system_overshoots_by_the_textbook_formula() {
        let damping = 0.394; // Brunner 1988: the depth loop at Kdz = 0.5
        let damped = f64::sqrt(1.0 - damping * damping);
        let (times, values) = sampled(40.0, |t| {
            1.0 - (-damping * t).exp()
                * ((damped * t).cos() + damping / damped * (damped * t).sin())
        });
        let metrics = of(&times, &values, 0.0, 1.0).unwrap();
        let expected = 100.0 * (-std::f64::consts::PI * damping / damped).exp();
        assert!((metrics.overshoot - expected).abs() < 1e-4);
    }

    #[test]
    fn a_step_down_has_the_metrics_of_the_step_up() {
        let (times, up) = sampled(10.0, |t| 1.0 - (-t).exp() * (2.0 * t).cos());
        let down: Vec<f64> = up.iter().map(|y| 5.0 - 3.0 * y).collect();
        let a = of(&times, &up, 0.0, 1.0).unwrap();
        let b = of(&times, &down, 5.0, 2.0).unwrap();
        assert!((a.overshoot - b.overshoot).abs() < 1e-9);
        assert!((a.rise_time.unwrap() - b.rise_time.unwrap()).abs() < 1e-9);
        assert!((a.settling_time.unwrap() - b.settling_time.unwrap()).abs() < 1e-9);
        assert!((b.steady_error + 3.0 * a.steady_error).abs() < 1e-9);
    }

    #[test]
    fn a_first_order_lag_of_one_second_has_an_itae_of_one() {
        // int t e^(-t) dt = 1
        let (times, values) = sampled(20.0, |t| 1.0 - (-t).exp());
        let metrics = of(&times, &values, 0.0, 1.0).unwrap();
        assert!((metrics.itae - 1.0).abs() < 1e-3, "{}", metrics.itae);
    }

    #[test]
    fn a_response_that_never_arrives_has_no_rise_and_no_settling_time() {
        let (times, values) = sampled(1.0, |t| 0.5 * t);
        let metrics = of(&times, &values, 0.0, 1.0).unwrap();
        assert_eq!(metrics.rise_time, None);
        assert_eq!(metrics.settling_time, None);
        assert!((metrics.steady_error - (1.0 - 0.475)).abs() < 1e-9);
    }

    #[test]
    fn a_response_at_its_level_from_the_start_has_settled() {
        let metrics = of(&[0.0, 1.0], &[1.0, 1.0], 0.0, 1.0).unwrap();
        assert_eq!(metrics.rise_time, Some(0.0));
        assert_eq!(metrics.settling_time, Some(0.0));
    }

    #[test]
    fn what_is_no_step_response_is_refused() {
        assert!(of(&[], &[], 0.0, 1.0).is_err());
        assert!(of(&[0.0], &[], 0.0, 1.0).is_err());
        assert!(of(&[0.0, 0.0], &[0.0, 1.0], 0.0, 1.0).is_err());
        assert!(of(&[0.0, 1.0], &[0.0, f64::NAN], 0.0, 1.0).is_err());
        assert!(of(&[0.0, 1.0], &[0.0, 1.0], 1.0, 1.0).is_err());
    }
}
