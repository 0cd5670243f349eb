//! Numbers and text as JSON in a page.

use serde_json::{Number, Value, json};

/// Number of significant digits of a value at the cursor, and of a position along an axis: enough for a millisecond in an hour.
const DIGITS: usize = 5;
const PLACE_DIGITS: usize = 7;

/// Values; `null` for values that are not finite.
pub(crate) fn list(values: impl Iterator<Item = f64>) -> Value {
    values.map(|it| rounded(it, DIGITS)).collect()
}

/// Positions along an axis; if equally spaced, only the first, the last and their number.
pub(crate) fn places(values: impl Iterator<Item = f64>) -> Value {
    let values: Vec<f64> = values.collect();
    if let ([first, .., last], count) = (&values[..], values.len()) {
        let distance = (last - first) / (count - 1) as f64;
        let is_equal = values
            .iter()
            .enumerate()
            .all(|(k, it)| (it - first - k as f64 * distance).abs() <= 1e-6 * distance.abs());
        if is_equal && distance != 0.0 {
            return json!({ "first": rounded(*first, 15), "last": rounded(*last, 15), "count": count });
        }
    }
    values
        .into_iter()
        .map(|it| rounded(it, PLACE_DIGITS))
        .collect()
}

/// A number rounded to so many significant digits.
fn rounded(value: f64, digits: usize) -> Value {
    let text = format!("{value:.*e}", digits - 1);
    let near: f64 = text.parse().unwrap_or(value);
    // Whole numbers without a decimal point; beyond this a double is no longer exact.
    if near.fract() == 0.0 && near.abs() < 1e15 {
        return (near as i64).into();
    }
    Number::from_f64(near).map_or(Value::Null, Value::Number)
}

/// JSON for a `<script>`, escaped so that no text can end the element.
pub(crate) fn script(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_as_many_digits_as_can_be_seen() {
        let values = [0.123_456_789, -2.0, 1e-9, f64::NAN, 123_456.7];
        let found = list(values.into_iter());
        assert_eq!(found.to_string(), "[0.12346,-2,1e-9,null,123460]");
    }

    #[test]
    fn equal_distances_are_told_by_their_ends() {
        let even = places((0..5).map(|k| f64::from(k) * 0.1));
        assert_eq!(even.to_string(), r#"{"count":5,"first":0,"last":0.4}"#);
        assert_eq!(places([0.0, 1.0, 3.0].into_iter()), json!([0, 1, 3]));
        assert_eq!(places([2.0, 2.0].into_iter()), json!([2, 2]));
        assert_eq!(places([2.0].into_iter()), json!([2]));
    }
}
