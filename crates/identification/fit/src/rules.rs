//! The allowed values of options, each rule stated once for the command line's parsers and the library's checks.

use std::f64::consts::PI;
use std::num::ParseIntError;
use std::ops::RangeInclusive;

use planesman_signals::Unwrap;

use crate::error::FitError;
pub use crate::error::RuleError;

/// Allowed numbers of an option.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// The minimum; not NaN.
    pub least: f64,
    /// The maximum; finite.
    pub most: f64,
    /// The rule in words.
    pub text: &'static str,
}

impl Rule {
    /// A rule.
    #[must_use]
    pub const fn new(least: f64, most: f64, text: &'static str) -> Self {
        Self { least, most, text }
    }

    /// Returns the number if the rule allows it; `written` is its text.
    ///
    /// # Errors
    /// [`RuleError`].
    pub fn check(&self, written: &str, value: f64) -> Result<f64, RuleError> {
        if (self.least..=self.most).contains(&value) {
            Ok(value)
        } else if self.most == f64::MAX && !value.is_finite() {
            Err(RuleError::NotFinite(written.to_owned()))
        } else {
            Err(RuleError::Range(self.text))
        }
    }

    /// Parses a number and returns it if the rule allows it.
    ///
    /// # Errors
    /// [`RuleError`].
    pub fn parse(&self, text: &str) -> Result<f64, RuleError> {
        self.check(text, parsed(text.trim())?)
    }
}

fn parsed(text: &str) -> Result<f64, RuleError> {
    text.parse()
        .map_err(|_| RuleError::NotANumber(text.to_owned()))
}

/// The smallest number above 0.
const LEAST: f64 = f64::from_bits(1);

/// Sampling rates, Hz.
pub const RATE: Rule = Rule::new(1e-6, 1e6, "expected a rate between 1e-6 and 1e6 Hz");
/// The longest interval that is not a gap, s.
pub const MAX_GAP: Rule = Rule::new(LEAST, 1e9, "expected a time between 0 and 1e9 s");
/// Forgetting factors per sample.
pub const FORGETTING: Rule = Rule::new(1e-3, 1.0, "a number from 0.001 to 1 is expected");
/// Coherences.
pub const COHERENCE: Rule = Rule::new(0.05, 0.999, "a coherence from 0.05 to 0.999 is expected");
/// Periods of an angle or a counter.
pub const PERIOD: Rule = Rule::new(
    1e-6,
    1e15,
    "expected automatic, no, 2pi or a period above 0, such as 360 or 65536",
);
/// Numbers above 0.
pub const ABOVE_ZERO: Rule = Rule::new(LEAST, f64::MAX, "expected a number above 0");
/// Numbers of 0 or more.
pub const NOT_NEGATIVE: Rule = Rule::new(0.0, f64::MAX, "expected a number of 0 or more");
/// Finite numbers.
pub const FINITE: Rule = Rule::new(f64::MIN, f64::MAX, "expected a finite number");

/// Treatment of angles and counters that wrap: `automatic`, `no`, or the period.
///
/// # Errors
/// [`RuleError`].
pub fn unwrap(text: &str) -> Result<Unwrap, RuleError> {
    Ok(match text.trim() {
        "automatic" => Unwrap::Automatic,
        "no" => Unwrap::No,
        "2pi" => Unwrap::Period(2.0 * PI),
        period => Unwrap::Period(PERIOD.parse(period)?),
    })
}

/// Parses the four coefficients of heave, `NU,ZETA,ETA,EPSILON`.
///
/// # Errors
/// [`RuleError`].
pub fn heave(text: &str) -> Result<[f64; 4], RuleError> {
    let numbers = text.split(',').map(|it| FINITE.parse(it));
    four(&numbers.collect::<Result<Vec<_>, _>>()?)
}

/// The four coefficients of heave.
///
/// # Errors
/// [`RuleError::NotFour`].
pub fn four(numbers: &[f64]) -> Result<[f64; 4], RuleError> {
    numbers.try_into().map_err(|_| RuleError::NotFour)
}

/// Pairs of bounds that an option accepts, the lower one first.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// The values for open bounds; no bound is below the first.
    pub open: (f64, f64),
    /// Whether both bounds may be open.
    pub may_be_open: bool,
    /// The rule in words.
    pub text: &'static str,
}

impl Span {
    /// Parses `FROM..TO` and returns the bounds if the rule allows them; a missing bound is open.
    ///
    /// # Errors
    /// [`RuleError`].
    pub fn parse(&self, text: &str) -> Result<(f64, f64), RuleError> {
        let refusal = || self.refusal(text);
        let (from, to) = text.split_once("..").ok_or_else(refusal)?;
        let edge = |text: &str, open: f64| match text {
            "" => Ok(open),
            text => parsed(text).map_err(|_| refusal()),
        };
        self.check(text, (edge(from, self.open.0)?, edge(to, self.open.1)?))
    }

    fn refusal(&self, written: &str) -> RuleError {
        RuleError::NotASpan(written.to_owned(), self.text)
    }

    /// Returns the bounds if the rule allows them; `written` is their text.
    ///
    /// # Errors
    /// [`RuleError`].
    pub fn check(&self, written: &str, (from, to): (f64, f64)) -> Result<(f64, f64), RuleError> {
        let is_open = !self.may_be_open && (from, to) == self.open;
        if from > to {
            Err(RuleError::Reversed(written.to_owned(), from, to))
        } else if from < to && from >= self.open.0 && !is_open {
            Ok((from, to))
        } else {
            Err(self.refusal(written))
        }
    }
}

/// Windows, s.
pub const WINDOW: Span = Span {
    open: (f64::NEG_INFINITY, f64::INFINITY),
    may_be_open: true,
    text: "is not a window; write FROM..TO, for example 10..60, 10.. or ..60",
};
/// Bands of frequency, Hz.
pub const BAND: Span = Span {
    open: (0.0, f64::INFINITY),
    may_be_open: false,
    text: "is not a band; write LOW..HIGH in Hz, for example 0.01..2, 0.01.. or ..2",
};

/// Prediction horizons in samples.
pub const AHEAD: RangeInclusive<i64> = 1..=1000;

/// Parses a whole number in the range.
pub(crate) fn whole(text: &str, range: &RangeInclusive<i64>) -> Result<usize, RuleError> {
    let number: i64 =
        (text.parse()).map_err(|refusal: ParseIntError| RuleError::Own(refusal.to_string()))?;
    let within = usize::try_from(number).ok();
    let within = within.filter(|_| range.contains(&number));
    within.ok_or_else(|| RuleError::Count(number.into(), range.clone()))
}

/// Checks the prediction horizons in samples.
pub(crate) fn check_ahead(ahead: &[usize]) -> Result<(), FitError> {
    for samples in ahead {
        let refused = |rule| FitError::value("ahead", samples, rule);
        whole(&samples.to_string(), &AHEAD).map_err(refused)?;
    }
    Ok(())
}
