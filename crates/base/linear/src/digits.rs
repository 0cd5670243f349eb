//! Numbers printed with their significant digits.

/// Magnitudes printed without an exponent.
const PLAIN: std::ops::Range<f64> = 1e-3..1e6;

/// Largest number of decimals.
const DECIMALS: i32 = 9;

/// A number with this many significant digits, with an exponent if that is shorter.
#[must_use]
pub fn significant(value: f64, digits: usize) -> String {
    let digits = digits.max(1);
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    if !PLAIN.contains(&value.abs()) {
        return format!("{value:.*e}", digits - 1);
    }
    let decimals = digits as i32 - 1 - exponent(value, digits);
    format!("{value:.*}", decimals.max(0) as usize)
}

/// A number and half the width of its interval, in the same unit, rounded to two digits of the interval: `0.74984 ± 0.00041`,
/// `7.498e-9 ± 0.012e-9`. Without an interval (0 or unknown), the number has six digits.
#[must_use]
pub fn with_interval(value: f64, half_width: f64) -> String {
    let (value, half_width) = value_and_interval(value, half_width);
    match half_width.is_empty() {
        true => value,
        false => format!("{value} ± {half_width}"),
    }
}

/// The two numbers of [`with_interval`] separately; the second is empty without an interval.
#[must_use]
pub fn value_and_interval(value: f64, half_width: f64) -> (String, String) {
    if !value.is_finite() || !half_width.is_finite() || half_width <= 0.0 {
        return (significant(value, 6), String::new());
    }
    let last = exponent(half_width, 2) - 1;
    let largest = value.abs().max(half_width);
    let (scale, decimals) = match PLAIN.contains(&largest) {
        true => (0, -last),
        false => {
            let scale = exponent(largest, 2);
            (scale, scale - last)
        }
    };
    let power = 10_f64.powi(scale);
    let suffix = match scale {
        0 => String::new(),
        scale => format!("e{scale}"),
    };
    let written = |number: f64| {
        let number = number / power;
        if decimals < 0 {
            // Digits before the point that are not known.
            let unit = 10_f64.powi(-decimals);
            return format!("{:.0}{suffix}", (number / unit).round() * unit);
        }
        format!("{number:.*}{suffix}", decimals as usize)
    };
    if decimals > DECIMALS {
        let value = format!("{:.*}{suffix}", DECIMALS as usize, value / power);
        return (value, format!("{half_width:.1e}"));
    }
    (written(value), written(half_width))
}

/// Power of ten of the first digit of a number after rounding to so many digits.
fn exponent(value: f64, digits: usize) -> i32 {
    let written = format!("{:.*e}", digits - 1, value.abs());
    let exponent = written.rsplit_once('e').and_then(|it| it.1.parse().ok());
    exponent.unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_gives_a_number_its_digits() {
        for (value, half_width, text) in [
            (0.749_841, 0.000_413, "0.74984 ± 0.00041"),
            (-0.599_67, 0.000_631, "-0.59967 ± 0.00063"),
            (7.498e-9, 1.2e-11, "7.498e-9 ± 0.012e-9"),
            (-1.1111e-5, 2.2e-7, "-1.111e-5 ± 0.022e-5"),
            (-25.546_94, 17.704_33, "-26 ± 18"),
            (12_345.0, 1234.0, "12300 ± 1200"),
            (1.7e9, 3.0e6, "1.7000e9 ± 0.0030e9"),
            (0.0996, 0.099_6, "0.10 ± 0.10"),
            (0.75, 1.2e-12, "0.750000000 ± 1.2e-12"),
            (0.0, 0.0, "0"),
            (0.5, 0.0, "0.500000"),
            (f64::NAN, 1.0, "NaN"),
            (1.0, f64::INFINITY, "1.00000"),
        ] {
            assert_eq!(with_interval(value, half_width), text);
        }
    }

    #[test]
    fn significant_digits_are_those_that_are_asked_for() {
        for (value, digits, text) in [
            (0.003_648_758_88, 8, "0.0036487589"),
            (7.5e-9, 4, "7.500e-9"),
            (-123.456, 4, "-123.5"),
            (123_456.0, 3, "123456"),
            (0.0, 8, "0"),
            (9.999_96, 5, "10.000"),
        ] {
            assert_eq!(significant(value, digits), text);
        }
    }
}
