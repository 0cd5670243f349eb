//! Metrics of a step response.
//!
//! The step goes from one value to another at the first sample. The response is scaled so that `from` is 0 and `to` is 1, for steps in either
//! direction:
//!
//! - **rise time**: from first reaching 10 % to first reaching 90 %;
//! - **overshoot**: the highest value minus 1, in percent, not below 0;
//! - **settling time**: from the step to the last entry into the band of 2 % (5 %) about 1;
//! - **steady error**: `to` minus the mean over the last tenth of the record, unscaled;
//! - **ITAE**: the integral of the time since the step times the scaled response's absolute error from 1.
//!
//! Between samples the response is assumed linear. These are the usual definitions (Franklin, Powell and Emami-Naeini, *Feedback Control of
//! Dynamic Systems*, ch. 3); all refer to the commanded level, not to the response's final value.

use crate::{Error, error::finite};

/// Final fraction of the record whose mean is the steady value.
const STEADY_SHARE: f64 = 0.1;

/// Metrics of one step response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepMetrics {
    /// Time from 10 % to 90 %, in the unit of the times; `None` if 90 % is not reached.
    pub rise_time: Option<f64>,
    /// Overshoot in percent of the step; 0 if the response does not pass the new value.
    pub overshoot: f64,
    /// Settling time to 2 % of the step; `None` if the record ends outside the band.
    pub settling_time: Option<f64>,
    /// Settling time to 5 % of the step; `None` if the record ends outside the band.
    pub settling_time_5: Option<f64>,
    /// `to` minus the final value, in the unit of the values.
    pub steady_error: f64,
    /// `int t |1 - y| dt`, in the square of the unit of the times.
    pub itae: f64,
}

impl StepMetrics {
    /// Metrics of `values` at `times`, for a step from one value to another at `times[0]`.
    ///
    /// ```
    /// # use planesman_linear::StepMetrics;
    /// // A lag of 1 s: from 10 % to 90 % in ln 9 seconds.
    /// let times: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
    /// let values: Vec<f64> = times.iter().map(|t| 1.0 - libm::exp(-t)).collect();
    /// let step = StepMetrics::of(&times, &values, 0.0, 1.0)?;
    /// assert!((step.rise_time.expect("it rises") - 9.0_f64.ln()).abs() < 0.02);
    /// assert_eq!(step.overshoot, 0.0);
    /// # Ok::<(), planesman_linear::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Empty`], [`Error::Shape`] if the lists differ in length, [`Error::NotFinite`], [`Error::NotPositive`] if the times do not increase or the
    /// step is zero.
    pub fn of(times: &[f64], values: &[f64], from: f64, to: f64) -> Result<Self, Error> {
        if values.len() != times.len() {
            return Err(Error::Shape {
                what: "the response",
                found: format!("{} values", values.len()),
                expected: format!("one value for each of {} times", times.len()),
            });
        }
        let mut meter = StepMeter::new(from, to, times.last().copied().unwrap_or(0.0))?;
        for (time, value) in times.iter().zip(values) {
            meter.take(*time, *value)?;
        }
        meter.metrics()
    }
}

/// Measures a response sample by sample, with constant memory.
#[derive(Clone, Debug)]
pub struct StepMeter {
    from: f64,
    to: f64,
    end: f64,
    /// Time of the first sample.
    begin: Option<f64>,
    last: Option<Sample>,
    /// Times at which 10 % and 90 % were first reached.
    reached: [Option<f64>; 2],
    highest: f64,
    /// The bands of 2 % and 5 %.
    bands: [Band; 2],
    /// Sum and number of the values in the last tenth.
    steady: (f64, usize),
    itae: f64,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    time: f64,
    scaled: f64,
}

/// A band about the new value.
#[derive(Clone, Copy, Debug)]
struct Band {
    half_width: f64,
    /// Time at which the response last entered the band.
    entered: Option<f64>,
}

impl StepMeter {
    /// A meter for a step from one value to another at the first sample of a record whose last sample is at `end`; the end must be known in advance,
    /// because the last tenth of the record is evaluated.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`] if the step is zero.
    pub fn new(from: f64, to: f64, end: f64) -> Result<Self, Error> {
        finite("the step", &[from, to])?;
        finite("the times", &[end])?;
        if from == to {
            return Err(Error::NotPositive {
                what: "the step's height",
                value: 0.0,
            });
        }
        let band = |half_width| Band {
            half_width,
            entered: None,
        };
        Ok(Self {
            from,
            to,
            end,
            begin: None,
            last: None,
            reached: [None; 2],
            highest: f64::MIN,
            bands: [band(0.02), band(0.05)],
            steady: (0.0, 0),
            itae: 0.0,
        })
    }

    /// Adds the next sample.
    ///
    /// # Errors
    /// [`Error::NotFinite`], [`Error::NotPositive`] if the time is not after the last one. The sample is then ignored.
    pub fn take(&mut self, time: f64, value: f64) -> Result<(), Error> {
        let scaled = (value - self.from) / (self.to - self.from);
        finite("the times", &[time])?;
        finite("the response", &[value])?;
        finite("the scaled response", &[scaled])?;
        if let Some(last) = self.last.filter(|last| time <= last.time) {
            return Err(Error::NotPositive {
                what: "the time between samples",
                value: time - last.time,
            });
        }
        let begin = *self.begin.get_or_insert(time);
        let sample = Sample { time, scaled };
        for (reached, level) in self.reached.iter_mut().zip([0.1, 0.9]) {
            if reached.is_none() && scaled >= level {
                let crossed = self.last.map(|last| crossing(last, sample, level));
                *reached = Some(crossed.unwrap_or(time));
            }
        }
        for band in &mut self.bands {
            band.take(self.last, sample);
        }
        self.highest = self.highest.max(scaled);
        if time >= self.end - STEADY_SHARE * (self.end - begin) {
            self.steady = (self.steady.0 + value, self.steady.1 + 1);
        }
        if let Some(last) = self.last {
            let weighted = |s: Sample| (s.time - begin) * (1.0 - s.scaled).abs();
            self.itae += 0.5 * (weighted(last) + weighted(sample)) * (time - last.time);
        }
        self.last = Some(sample);
        Ok(())
    }

    /// Metrics of the samples so far.
    ///
    /// # Errors
    /// [`Error::Empty`] without a sample in the last tenth; [`Error::NotFinite`] if a metric overflows.
    pub fn metrics(&self) -> Result<StepMetrics, Error> {
        let (Some(begin), Some(last)) = (self.begin, self.last) else {
            return Err(Error::Empty {
                what: "the response",
            });
        };
        let (sum, count) = self.steady;
        if count == 0 {
            return Err(Error::Empty {
                what: "the last tenth of the response",
            });
        }
        let settled = |band: Band| Some(band.settled(last)? - begin);
        let [low, high] = self.reached;
        let metrics = StepMetrics {
            rise_time: high.zip(low).map(|(high, low)| high - low),
            overshoot: 100.0 * (self.highest - 1.0).max(0.0),
            settling_time: settled(self.bands[0]),
            settling_time_5: settled(self.bands[1]),
            steady_error: self.to - sum / count as f64,
            itae: self.itae,
        };
        // Sums of numbers near the ends of their range.
        finite(
            "a metric of the step",
            &[metrics.overshoot, metrics.steady_error, metrics.itae],
        )?;
        Ok(metrics)
    }
}

impl Band {
    fn holds(self, sample: Sample) -> bool {
        (sample.scaled - 1.0).abs() <= self.half_width
    }

    fn take(&mut self, last: Option<Sample>, sample: Sample) {
        if !self.holds(sample) {
            return;
        }
        match last {
            None => self.entered = Some(sample.time),
            Some(last) if !self.holds(last) => {
                let above = last.scaled > 1.0;
                let edge = 1.0
                    + if above {
                        self.half_width
                    } else {
                        -self.half_width
                    };
                self.entered = Some(crossing(last, sample, edge));
            }
            Some(_) => {}
        }
    }

    /// Time at which the response entered the band for good; `None` if the response ends outside the band.
    fn settled(self, last: Sample) -> Option<f64> {
        self.entered.filter(|_| self.holds(last))
    }
}

/// Time at which the line between two samples passes `level`, which is between them.
fn crossing(from: Sample, to: Sample, level: f64) -> f64 {
    let share = (level - from.scaled) / (to.scaled - from.scaled);
    from.time + share * (to.time - from.time)
}

#[cfg(test)]
mod tests {
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
        let (times, values) = sampled(20.0, |t| 1.0 - libm::exp(-t));
        let metrics = StepMetrics::of(&times, &values, 0.0, 1.0).unwrap();
        assert!((metrics.rise_time.unwrap() - libm::log(9f64)).abs() < 1e-5);
        assert!((metrics.settling_time.unwrap() - libm::log(50f64)).abs() < 1e-5);
        assert!((metrics.settling_time_5.unwrap() - libm::log(20f64)).abs() < 1e-5);
        assert_eq!(metrics.overshoot, 0.0);
        assert!(metrics.steady_error.abs() < 1e-7);
    }

    #[test]
    fn a_second_order_system_overshoots_by_the_textbook_formula() {
        let damping = 0.394; // Brunner 1988: the depth loop at Kdz = 0.5
        let damped = f64::sqrt(1.0 - damping * damping);
        let (times, values) = sampled(40.0, |t| {
            1.0 - libm::exp(-damping * t)
                * (libm::cos(damped * t) + damping / damped * libm::sin(damped * t))
        });
        let metrics = StepMetrics::of(&times, &values, 0.0, 1.0).unwrap();
        let expected = 100.0 * libm::exp(-std::f64::consts::PI * damping / damped);
        assert!((metrics.overshoot - expected).abs() < 1e-4);
    }

    #[test]
    fn a_step_down_has_the_metrics_of_the_step_up() {
        let (times, up) = sampled(10.0, |t| 1.0 - libm::exp(-t) * libm::cos(2.0 * t));
        let down: Vec<f64> = up.iter().map(|y| 5.0 - 3.0 * y).collect();
        let a = StepMetrics::of(&times, &up, 0.0, 1.0).unwrap();
        let b = StepMetrics::of(&times, &down, 5.0, 2.0).unwrap();
        assert!((a.overshoot - b.overshoot).abs() < 1e-9);
        assert!((a.rise_time.unwrap() - b.rise_time.unwrap()).abs() < 1e-9);
        assert!((a.settling_time.unwrap() - b.settling_time.unwrap()).abs() < 1e-9);
        assert!((b.steady_error + 3.0 * a.steady_error).abs() < 1e-9);
    }

    #[test]
    fn a_first_order_lag_of_one_second_has_an_itae_of_one() {
        // int t e^(-t) dt = 1
        let (times, values) = sampled(20.0, |t| 1.0 - libm::exp(-t));
        let metrics = StepMetrics::of(&times, &values, 0.0, 1.0).unwrap();
        assert!((metrics.itae - 1.0).abs() < 1e-3, "{}", metrics.itae);
    }

    #[test]
    fn a_response_that_never_arrives_has_no_rise_and_no_settling_time() {
        let (times, values) = sampled(1.0, |t| 0.5 * t);
        let metrics = StepMetrics::of(&times, &values, 0.0, 1.0).unwrap();
        assert_eq!(metrics.rise_time, None);
        assert_eq!(metrics.settling_time, None);
        assert!((metrics.steady_error - (1.0 - 0.475)).abs() < 1e-9);
    }

    #[test]
    fn a_response_at_its_level_from_the_start_has_settled() {
        let metrics = StepMetrics::of(&[0.0, 1.0], &[1.0, 1.0], 0.0, 1.0).unwrap();
        assert_eq!(metrics.rise_time, Some(0.0));
        assert_eq!(metrics.settling_time, Some(0.0));
    }

    #[test]
    fn what_is_no_step_response_is_refused() {
        assert!(StepMetrics::of(&[], &[], 0.0, 1.0).is_err());
        assert!(StepMetrics::of(&[0.0], &[], 0.0, 1.0).is_err());
        assert!(StepMetrics::of(&[0.0, 0.0], &[0.0, 1.0], 0.0, 1.0).is_err());
        assert!(StepMetrics::of(&[0.0, 1.0], &[0.0, f64::NAN], 0.0, 1.0).is_err());
        assert!(StepMetrics::of(&[0.0, 1.0], &[0.0, 1.0], 1.0, 1.0).is_err());
    }

    #[test]
    fn figures_beyond_all_numbers_are_refused() {
        assert!(StepMetrics::of(&[0.0, 1.0], &[0.0, 1e308], 0.0, 1.0).is_err());
    }

    #[test]
    fn a_sample_that_is_refused_leaves_the_response_as_it_was() {
        let mut meter = StepMeter::new(0.0, 1.0, 2.0).unwrap();
        assert!(meter.metrics().is_err());
        meter.take(0.0, 0.0).unwrap();
        meter.take(1.0, 1.0).unwrap();
        assert!(meter.take(1.0, 5.0).is_err());
        assert!(meter.take(1.5, f64::NAN).is_err());
        assert!(meter.metrics().is_err(), "the last tenth has not come");
        meter.take(2.0, 1.0).unwrap();
        assert_eq!(
            meter.metrics().unwrap(),
            StepMetrics::of(&[0.0, 1.0, 2.0], &[0.0, 1.0, 1.0], 0.0, 1.0).unwrap()
        );
    }
}
