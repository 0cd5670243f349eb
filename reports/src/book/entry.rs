//! A quantity of a report.

use serde::Deserialize;

use crate::book::verdict::{Verdict, half_unit_of_last_digit};

/// A quantity: source, printed value, recomputed value.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Name, beginning with the family: `Tab1.Zw.dim`.
    pub id: String,
    /// Unit of all values of the entry, as in the report.
    pub unit: String,
    /// Source: page, table, figure or program.
    pub source: String,
    /// The printed number.
    pub printed: Option<f64>,
    /// Largest difference from the printed number that still counts as approximate agreement \[unit\].
    pub slack: Option<f64>,
    /// Rounding error of the printed number \[unit\], if its last digit does not show it.
    pub rounding: Option<f64>,
    /// The value recomputed when the book was made.
    #[serde(rename = "recomputed")]
    pub reference: Option<f64>,
    /// Tolerance of a recomputed number around that reference \[unit\].
    pub tolerance: Option<f64>,
    /// Note on its computation, or on peculiarities.
    pub note: Option<String>,
    /// Recorded verdict; a different new one is a change.
    pub verdict: Option<Verdict>,
    /// Whether the number is a constant used as a model input: reading it back checks only that it was copied correctly.
    #[serde(default)]
    pub input: bool,
    /// Whether a model constant was calibrated on this number: then its agreement does not validate the model.
    #[serde(default)]
    pub calibrated: bool,
    /// The entry for the same printed quantity with another model or unit; the two count once, as the other entry.
    pub counted_with: Option<String>,
    /// Number of the erratum that explains it.
    pub erratum: Option<String>,
}

impl Entry {
    /// Verdict on the recomputed `value`; `None` without a printed number.
    #[must_use]
    pub fn judge(&self, value: f64) -> Option<Verdict> {
        let printed = self.printed?;
        let slack = self.slack.unwrap_or(0.0);
        let rounding = self
            .rounding
            .unwrap_or_else(|| half_unit_of_last_digit(printed))
            .min(slack);
        Some(Verdict::of(printed, value, rounding, slack))
    }

    /// Whether `value` is within the tolerance of the reference; `None` without a reference.
    #[must_use]
    pub fn near_reference(&self, value: f64) -> Option<bool> {
        let tolerance = self.tolerance.unwrap_or(0.0);
        self.reference.map(|r| (value - r).abs() <= tolerance)
    }

    /// The family: the name up to the first dot.
    #[must_use]
    pub fn family(&self) -> &str {
        self.id.split('.').next().unwrap_or(&self.id)
    }
}
