//! Recomputed numbers of the controllers.

/// Some of the book's numbers, computed again: name and value, in the entry's unit.
pub(crate) type Values = Vec<(&'static str, f64)>;

/// A number that could not be found agrees with nothing.
pub(crate) fn or_nan(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}
