//! A cell of a table: a number, or nothing.

use crate::time_unit::TimeUnit;
use crate::unit_name::is_unit;

/// The longest unit after a number, bytes.
const LONGEST_UNIT: usize = 16;

/// Words for a missing number in loggers and pandas.
const MISSING: [&str; 14] = [
    "",
    "-",
    "--",
    "null",
    "none",
    "na",
    "n/a",
    "#n/a",
    "nil",
    "?",
    "-nan",
    "nan(ind)",
    "-nan(ind)",
    "missing",
];

/// Whether a cell means that the number is missing.
pub(crate) fn is_missing(cell: &str) -> bool {
    MISSING.iter().any(|it| it.eq_ignore_ascii_case(cell))
}

/// The number in a cell. A single comma is a decimal comma: cells separated by commas contain no commas. If thousands are grouped, the last separator
/// is the decimal one. `true` and `on` are 1, `false` and `off` 0.
pub(crate) fn number(cell: &str) -> Option<f64> {
    if let Ok(number) = cell.parse() {
        return Some(number);
    }
    // What is written with digits begins with no letter.
    match cell.bytes().next()? {
        b't' | b'T' | b'f' | b'F' | b'o' | b'O' | b'y' | b'Y' | b'n' | b'N' => truth(cell),
        b'0'..=b'9' | b'+' | b'-' | b'.' | b',' => written(cell),
        _ => None,
    }
}

/// A number followed by a known unit: `19.95 °C`, `20%`. Without a blank between them, letters that may be hexadecimal digits (`1A`) are a
/// unit only after a fraction.
pub(crate) fn quantity(cell: &str) -> Option<(f64, &str)> {
    if !cell.starts_with(|it: char| it.is_ascii_digit() || "+-.,".contains(it)) {
        return None;
    }
    let is_of_number = |it: char| it.is_ascii_digit() || "+-., eE'".contains(it);
    let (amount, unit) = cell.split_at(cell.find(|it| !is_of_number(it))?);
    let (bare, word) = (amount.trim_end(), unit.trim());
    let is_parted = bare.len() < amount.len() || unit.starts_with(char::is_whitespace);
    let is_hex = || word.bytes().all(|it| it.is_ascii_hexdigit()) && !bare.contains(['.', ',']);
    // `69h` may be hexadecimal too.
    let may_be_hex = || !is_parted && (is_hex() || word == "h");
    let is_known = word.starts_with(|it: char| !it.is_ascii()) || (is_unit(word) && !may_be_hex());
    let is_word = (word.chars().any(char::is_alphabetic) || word.contains(['%', '°']))
        && !word.contains(['(', '[']);
    // `1/5` and `03/12/2024` have none.
    let has_digits_behind = word
        .split('/')
        .skip(1)
        .any(|it| it.starts_with(|it: char| it.is_ascii_digit()));
    let is_its = is_known && is_word && !has_digits_behind && word.len() <= LONGEST_UNIT;
    is_its.then_some((number(bare)?, word))
}

/// The number in a cell, with or without a unit.
pub(crate) fn value(cell: &str) -> Option<f64> {
    number(cell).or_else(|| Some(quantity(cell)?.0))
}

fn truth(cell: &str) -> Option<f64> {
    let is_one_of = |words: [&str; 3]| words.iter().any(|it| it.eq_ignore_ascii_case(cell));
    match is_one_of(["true", "on", "yes"]) {
        true => Some(1.0),
        false => is_one_of(["false", "off", "no"]).then_some(0.0),
    }
}

/// A number with a decimal comma, grouped thousands, or Fortran's exponent (`1.5D-03`).
fn written(cell: &str) -> Option<f64> {
    let (mantissa, exponent) = match cell.split_once(['e', 'E', 'd', 'D']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
        None => (cell, 0),
    };
    let (whole, part) = match mantissa.rsplit_once([',', '.']) {
        Some(parts) => parts,
        None => (mantissa, ""),
    };
    let digits = |text: &str| text.bytes().all(|it| it.is_ascii_digit());
    let unsigned = whole.strip_prefix(['+', '-']).unwrap_or(whole);
    let (sign, grouped) = (&whole[..whole.len() - unsigned.len()], unsigned);
    let decimal = mantissa.as_bytes().get(whole.len()).copied();
    let groups: Vec<&str> = grouped.split([',', '.', '\'', ' ']).collect();
    let is_grouped = || {
        let group = grouped.bytes().find(|it| !it.is_ascii_digit());
        let is_one_sign = grouped
            .bytes()
            .all(|it| it.is_ascii_digit() || Some(it) == group);
        (1..=3).contains(&groups[0].len())
            && groups[1..].iter().all(|it| it.len() == 3)
            && is_one_sign
            && {
                // 1.234.567 and 1,234,567 have no decimal sign.
                group != decimal || part.len() == 3
            }
    };
    let is_plain =
        groups.iter().all(|it| digits(it)) && digits(part) && (groups.len() == 1 || is_grouped());
    (is_plain && mantissa.bytes().any(|it| it.is_ascii_digit())).then_some(())?;
    let all_of_groups =
        groups.len() > 1 && grouped.as_bytes().get(groups[0].len()).copied() == decimal;
    let point = if all_of_groups { "" } else { "." };
    format!("{sign}{}{point}{part}e{exponent}", groups.concat())
        .parse()
        .ok()
}

/// A decimal number of time units in nanoseconds, exact if it is written with digits and a point; 64-bit floating point cannot represent
/// the nanoseconds of a date.
pub(crate) fn decimal(text: &str, unit: TimeUnit) -> Option<i64> {
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
    let rounded = part
        .as_bytes()
        .get(places)
        .is_some_and(|digit| *digit >= b'5');
    let padded = part.bytes().chain(std::iter::repeat(b'0')).take(places);
    let nanoseconds = whole.bytes().chain(padded).try_fold(0_i64, |sum, digit| {
        sum.checked_mul(10)?.checked_add(i64::from(digit - b'0'))
    })?;
    let nanoseconds = nanoseconds.checked_add(i64::from(rounded))?;
    Some(if negative { -nanoseconds } else { nanoseconds })
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
            ("1.234,5", Some(1234.5)),
            ("-1,234,567.25", Some(-1_234_567.25)),
            ("1'234.5", Some(1234.5)),
            ("1 234,5", Some(1234.5)),
            ("1,234,567", Some(1_234_567.0)),
            ("12.34,5", None),
            ("1.234.5", None),
            ("1.5D-03", Some(1.5e-3)),
            ("2d2", Some(200.0)),
            ("TRUE", Some(1.0)),
            ("off", Some(0.0)),
            ("1,e2", Some(100.0)),
            ("e5", None),
            ("-", None),
            ("1-2", None),
            ("2026-11-24", None),
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
    fn a_number_may_have_a_unit_behind_it() {
        for (text, expected) in [
            ("20%", Some((20.0, "%"))),
            ("19.95 °C", Some((19.95, "°C"))),
            ("19,95\u{a0}°C", Some((19.95, "°C"))),
            ("11.9V", Some((11.9, "V"))),
            ("-1.5 m/s^2", Some((-1.5, "m/s^2"))),
            ("1.2e3 rpm", Some((1200.0, "rpm"))),
            ("3 knots", Some((3.0, "knots"))),
            ("1.5A", Some((1.5, "A"))),
            // May be hexadecimal.
            ("1A", None),
            ("5C", None),
            ("0x1A", None),
            ("12:30 PM", None),
            ("3 of 4", None),
            ("12 Main Street", None),
            ("10:00:00.000 -> 20", None),
            ("x 5", None),
            ("914018\t1", None),
            ("%", None),
            ("5", None),
        ] {
            assert_eq!(quantity(text), expected, "{text}");
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
            assert_eq!(decimal(text, unit), expected, "{text}");
        }
    }
}
