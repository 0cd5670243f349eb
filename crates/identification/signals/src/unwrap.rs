//! Angles and counters that wrap, unwrapped.
//!
//! A wrap takes a signal from one end of its period to the other; after subtracting the period, the signal moves as before. Signals that jump in this
//! way without wrapping, for example commands, do not move steadily before the jump.

use std::f64::consts::PI;
use std::fmt;

use serde::Serialize;

use crate::quantile::median;

/// Periods that are detected automatically.
const PERIODS: [f64; 4] = [360.0, 2.0 * PI, 65_536.0, 4_294_967_296.0];

/// Number of steps from which the usual one is found.
const FIRST: usize = 8;

/// The weight of the latest step in the mean of all.
const FORGETTING: f64 = 0.05;

/// A step of up to this number of usual steps is not a jump.
const STEPS: f64 = 8.0;

/// A value may be rounded to lie this far beyond the end, in periods.
const EDGE: f64 = 1e-4;

/// The usual step must be below this part of the period.
const SMALL: f64 = 1.0 / 12.0;

/// Treatment of angles and counters that wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unwrap {
    /// Unwrap if the jump is unmistakable: periods 360, 2 pi, 2^16 and 2^32.
    #[default]
    Automatic,
    /// Unwrap with that period: each step is the shortest.
    Period(f64),
    /// Do not unwrap.
    No,
}

impl fmt::Display for Unwrap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Automatic => f.write_str("automatic"),
            Self::Period(period) if *period == 2.0 * PI => f.write_str("2pi"),
            Self::Period(period) => write!(f, "{period}"),
            Self::No => f.write_str("no"),
        }
    }
}

/// Unwraps the values of one signal, in the order of time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Unwrapper {
    choice: Unwrap,
    last: Option<f64>,
    /// The smallest and the largest value so far. A signal that wraps stays within its period.
    range: Option<(f64, f64)>,
    /// The usual size of a step other than 0, and the number of such steps.
    step: f64,
    steps: usize,
    /// Number of steps of 0 since the last nonzero one.
    still: usize,
    /// The number of periods added now.
    turns: f64,
    /// The period, once the signal has wrapped.
    pub(crate) period: Option<f64>,
    /// Number of wraps.
    pub(crate) wraps: u64,
}

impl Unwrapper {
    /// Before the first value. `values` are the first, from which the usual step is computed.
    pub(crate) fn new(choice: Unwrap, values: &[f64]) -> Self {
        let mut steps: Vec<f64> = values.windows(2).map(|it| (it[1] - it[0]).abs()).collect();
        steps.retain(|step| *step > 0.0);
        let step = median(&mut steps);
        let mut unwrapper = Self {
            choice,
            step,
            steps: steps.len(),
            ..Self::default()
        };
        values.iter().for_each(|value| unwrapper.stretch(*value));
        unwrapper
    }

    fn stretch(&mut self, value: f64) {
        let (low, high) = self.range.unwrap_or((value, value));
        self.range = Some((low.min(value), high.max(value)));
    }

    /// The next value, unwrapped.
    pub(crate) fn next(&mut self, value: f64) -> f64 {
        if self.last == Some(value) {
            self.still += 1;
            return value + self.turns * self.period.unwrap_or(0.0);
        }
        self.stretch(value);
        if let Some(last) = self.last.replace(value) {
            let step = value - last;
            match self.wrap(last, step) {
                Some(period) => {
                    self.period = Some(period);
                    self.wraps += 1;
                    self.turns -= (step / period).round();
                }
                None => {
                    self.steps += 1;
                    self.step += FORGETTING * (step.abs() - self.step);
                    self.still = 0;
                }
            }
        }
        value + self.turns * self.period.unwrap_or(0.0)
    }

    /// The period by which the signal wraps at this step, if it does.
    fn wrap(&self, last: f64, step: f64) -> Option<f64> {
        match (self.choice, self.period) {
            (Unwrap::No, _) => None,
            (Unwrap::Period(period), _) => (step.abs() > 0.5 * period).then_some(period),
            (Unwrap::Automatic, Some(period)) => self.is_wrap(period, last, step).then_some(period),
            (Unwrap::Automatic, None) => PERIODS
                .into_iter()
                .find(|period| self.is_wrap(*period, last, step)),
        }
    }

    fn is_wrap(&self, period: f64, last: f64, step: f64) -> bool {
        if self.steps < FIRST || self.step > SMALL * period || self.still > FIRST {
            return false;
        }
        let tolerance = (STEPS * self.step).min(0.25 * period);
        let value = last + step;
        let rest = step.abs() - period;
        // From one end to the other, of 0 to the period or of half of it on either side.
        let (low, high) = (value.min(last), value.max(last));
        let (least, greatest) = self.range.unwrap_or((low, high));
        let at_ends = |start: f64| {
            low - start <= tolerance
                && start + period - high <= tolerance
                && least >= start - EDGE * period
                && greatest <= start + period * (1.0 + EDGE)
        };
        rest.abs() <= tolerance && [0.0, -0.5 * period].into_iter().any(at_ends)
    }
}
