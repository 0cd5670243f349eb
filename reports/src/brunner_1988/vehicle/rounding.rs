//! Rounding between steps, as in the report: Table 6 continues with its own rounded columns.

/// `value` rounded to so many decimals.
#[must_use]
pub(super) fn to_decimals(value: f64, decimals: i32) -> f64 {
    let scale = 10_f64.powi(decimals);
    (value * scale).round() / scale
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_friction_coefficient_rounds_to_three_decimals() {
        assert_eq!(super::to_decimals(0.005_97, 3), 0.006);
    }
}
