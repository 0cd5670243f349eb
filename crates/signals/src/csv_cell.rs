//! A cell of a table: a number, or a time.

use jiff::Timestamp;
use jiff::civil::{DateTime, Time};
use jiff::tz::TimeZone;

use crate::time_unit::TimeUnit;

/// The number a cell holds. One comma in it is a decimal comma: cells parted by commas have none.
pub(crate) fn number(cell: &str) -> Option<f64> {
    match cell.split_once(',') {
        None => cell.parse().ok(),
        Some((whole, part)) => {
            let is_plain = !whole.contains('.') && !part.contains(['.', ',', '+', '-']);
            let point = || format!("{whole}.{part}").parse().ok();
            is_plain.then(point).flatten().or_else(|| {
                // An exponent may have a sign: 1,5e-3.
                let (part, exponent) = part.split_once(['e', 'E'])?;
                let is_plain = !whole.contains('.') && part.bytes().all(|it| it.is_ascii_digit());
                let point = || format!("{whole}.{part}e{exponent}").parse().ok();
                is_plain.then(point).flatten()
            })
        }
    }
}

/// The time a cell holds, ns: a decimal number of units, or a date and time as ISO 8601 writes them (UTC where no zone
/// is written), or a time of day.
pub(crate) fn nanoseconds(cell: &str, unit: TimeUnit) -> Option<i64> {
    decimal(cell, unit).or_else(|| date(cell))
}

/// A decimal number of time units in nanoseconds, exactly where it is written with digits and a point; 64-bit
/// floating point cannot hold the nanoseconds of a date.
fn decimal(text: &str, unit: TimeUnit) -> Option<i64> {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(digits) => (true, digits),
        None => (false, text),
    };
    let (whole, part) = digits.split_once(['.', ',']).unwrap_or((digits, ""));
    let is_plain = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let is_decimal = unit.nanoseconds() == 10_i64.pow(unit.places());
    if whole.is_empty() || !is_plain(whole) || !is_plain(part) || !is_decimal {
        // An exponent, or a unit of 60 or 24.
        return unit.in_nanoseconds(number(text)?);
    }
    let places = unit.places() as usize;
    let padded = format!("{part:0<places$}");
    let rounded = padded
        .as_bytes()
        .get(places)
        .is_some_and(|digit| *digit >= b'5');
    let nanoseconds: i64 = format!("{whole}{}", &padded[..places]).parse().ok()?;
    let nanoseconds = nanoseconds.checked_add(i64::from(rounded))?;
    Some(if negative { -nanoseconds } else { nanoseconds })
}

/// A date with a time, or a time of day, in nanoseconds.
pub(crate) fn date(text: &str) -> Option<i64> {
    // Times of day have colons; `2024` alone is a number and no time of day.
    if !text.contains(':') {
        return None;
    }
    let since = |stamp: Timestamp| i64::try_from(stamp.as_nanosecond()).ok();
    if let Ok(stamp) = text.parse::<Timestamp>() {
        return since(stamp);
    }
    if let Ok(local) = text.parse::<DateTime>() {
        return since(TimeZone::UTC.to_timestamp(local).ok()?);
    }
    let time: Time = text.parse().ok()?;
    let seconds =
        (i64::from(time.hour()) * 60 + i64::from(time.minute())) * 60 + i64::from(time.second());
    Some(seconds * 1_000_000_000 + i64::from(time.subsec_nanosecond()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_has_a_decimal_point_or_a_decimal_comma() {
        for (text, expected) in [
            ("1.5", Some(1.5)),
            ("1,5", Some(1.5)),
            ("-0,05", Some(-0.05)),
            ("1,5e-3", Some(1.5e-3)),
            (",5", Some(0.5)),
            ("1.234,5", None),
            ("1,234,5", None),
            ("1,-5", None),
            ("1,e", None),
            ("", None),
            (",", None),
            ("x", None),
        ] {
            assert_eq!(number(text), expected, "{text}");
        }
    }

    #[test]
    fn a_time_is_read_to_the_nanosecond() {
        for (text, unit, expected) in [
            ("0.05", TimeUnit::S, Some(50_000_000)),
            ("0,05", TimeUnit::S, Some(50_000_000)),
            (
                "1700000000.123456789",
                TimeUnit::S,
                Some(1_700_000_000_123_456_789),
            ),
            (
                "1700000000.1234567895",
                TimeUnit::S,
                Some(1_700_000_000_123_456_790),
            ),
            ("-1.5", TimeUnit::Ms, Some(-1_500_000)),
            ("7", TimeUnit::Ns, Some(7)),
            ("2.5e-3", TimeUnit::S, Some(2_500_000)),
            ("2,5e-3", TimeUnit::S, Some(2_500_000)),
            ("1e300", TimeUnit::S, None),
            ("99999999999999999999", TimeUnit::Ns, None),
            ("noon", TimeUnit::S, None),
            ("", TimeUnit::S, None),
            ("nan", TimeUnit::S, None),
        ] {
            assert_eq!(nanoseconds(text, unit), expected, "{text}");
        }
    }

    #[test]
    fn a_date_is_read_with_and_without_its_zone() {
        let expected = 1_700_000_000_123_456_789;
        for text in [
            "2023-11-14T22:13:20.123456789Z",
            "2023-11-14 22:13:20.123456789",
            "2023-11-14T22:13:20,123456789",
            "2023-11-14T23:13:20.123456789+01:00",
            "2023-11-14 22:13:20.123456789+0000",
        ] {
            assert_eq!(nanoseconds(text, TimeUnit::S), Some(expected), "{text}");
        }
        assert_eq!(date("00:01:02.5"), Some(62_500_000_000));
        for text in [
            "2023-11-14",
            "25:00:00",
            "9999-12-31T23:59:59Z",
            "noon:",
            ":",
        ] {
            assert_eq!(date(text), None, "{text}");
        }
    }
}
