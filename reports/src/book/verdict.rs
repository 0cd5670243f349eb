//! Agreement of a recomputed number with the printed one.

use std::fmt;

use serde::Deserialize;

/// Verdict on a recomputed number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Equal within the printed rounding.
    Agrees,
    /// Different by more than the printed rounding, but within the entry's slack.
    Approximate,
    /// Different by more than the slack.
    Contradicts,
}

/// Relative tolerance for rounding errors at a bound.
const ROUND_OFF: f64 = 1e-9;

impl Verdict {
    /// Verdict on `value` with the given `rounding` and `slack` of `printed`, in the same unit. A number that is not finite contradicts.
    #[must_use]
    pub fn of(printed: f64, value: f64, rounding: f64, slack: f64) -> Self {
        let off = (value - printed).abs();
        let within = |bound: f64| off <= bound + ROUND_OFF * printed.abs();
        if within(rounding) {
            Self::Agrees
        } else if within(slack) {
            Self::Approximate
        } else {
            Self::Contradicts
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Agrees => "agrees",
            Self::Approximate => "approximate",
            Self::Contradicts => "contradicts",
        })
    }
}

/// Half a unit of the last digit of `printed` in its shortest form: 0.005 for 2.61.
#[must_use]
pub fn half_unit_of_last_digit(printed: f64) -> f64 {
    let text = printed.to_string();
    let decimals = text.split_once('.').map_or(0, |(_, d)| d.len());
    0.5 * 10_f64.powi(-i32::try_from(decimals).unwrap_or(i32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digit_tells_how_far_a_printed_number_is_rounded() {
        for (printed, half) in [(2.61, 0.005), (-27.5, 0.05), (543.0, 0.5), (0.002, 0.0005)] {
            assert!((half_unit_of_last_digit(printed) - half).abs() < 1e-15);
        }
    }

    #[test]
    fn a_number_agrees_to_its_rounding_and_approximately_to_its_slack() {
        let of = |value| Verdict::of(2.61, value, 0.005, 0.015);
        assert_eq!(of(2.615), Verdict::Agrees);
        assert_eq!(of(2.6004), Verdict::Approximate);
        assert_eq!(of(2.59), Verdict::Contradicts);
        assert_eq!(of(f64::NAN), Verdict::Contradicts);
    }
}
