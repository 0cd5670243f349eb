//! One quantity of a report.

use serde::Deserialize;

use crate::book::verdict::{Verdict, half_unit_of_last_digit};

/// One quantity: where it stands, what is printed, what it comes to.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Its name, family first: `Tab1.Zw.dim`.
    pub id: String,
    /// The unit of all its values, as the report has it.
    pub unit: String,
    /// Page, table, figure or program.
    pub source: String,
    /// The printed number.
    pub printed: Option<f64>,
    /// The tolerance of a recomputed number around the printed one \[unit\].
    pub slack: Option<f64>,
    /// The rounding error of the printed number \[unit\], where its last digit does not show it.
    pub rounding: Option<f64>,
    /// The value when the report was worked through.
    #[serde(rename = "recomputed")]
    pub reference: Option<f64>,
    /// The tolerance of another computation around the reference \[unit\].
    pub tolerance: Option<f64>,
    /// How it is computed, or what is odd about it.
    pub note: Option<String>,
    /// The verdict that stands; a new one that differs is a change.
    pub verdict: Option<Verdict>,
    /// A constant that the models are given: read back it says that it was copied right, and nothing of the models.
    #[serde(default)]
    pub input: bool,
    /// A number that a constant of the model was calibrated on: that it agrees says nothing of the model.
    #[serde(default)]
    pub calibrated: bool,
    /// The entry of the same printed quantity, with another model or in another unit: the two count once, as that entry.
    pub counted_with: Option<String>,
    /// The erratum that explains it, by its number in the book's errata.
    pub erratum: Option<String>,
}

impl Entry {
    /// The verdict on the recomputed `value`: `None` when nothing is printed to compare it with.
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

    /// Whether `value` lies within the tolerance of the reference; `None` without a reference.
    #[must_use]
    pub fn near_reference(&self, value: f64) -> Option<bool> {
        let tolerance = self.tolerance.unwrap_or(0.0);
        self.reference.map(|r| (value - r).abs() <= tolerance)
    }

    /// The family: its name up to the first dot.
    #[must_use]
    pub fn family(&self) -> &str {
        self.id.split('.').next().unwrap_or(&self.id)
    }
}
