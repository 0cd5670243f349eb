//! Recomputed numbers of the controllers.

/// Recomputed numbers: name and value, in the entry's unit.
pub(crate) type Values = Vec<(&'static str, f64)>;

/// The value, or NaN, which agrees with no number.
pub(crate) fn or_nan(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}
