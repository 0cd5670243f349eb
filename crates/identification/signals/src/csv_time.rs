//! Parses times as people and programs write them: a date with a time of day, a time of day, a duration with its unit.

use jiff::civil;
use jiff::tz::TimeZone;

use crate::csv_cell::{decimal, number};
use crate::time_unit::TimeUnit;

/// The accepted formats, for error messages.
pub(crate) const FORMS: &str = "2026-11-24 12:00:00.050, 2026-11-24T12:00:00.050Z, 2026/11/24 12:00:00.050, 24.11.2026 12:00:00,050, \
     11/24/2026 12:00:00.050 PM, 24-Nov-2026 12:00:00.050, 12:00:00.050, 0.05 sec";

const HOUR: i64 = 3_600_000_000_000;
pub(crate) const DAY: i64 = 24 * HOUR;

/// The order of day and month in `11/12/2026`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Order {
    DayFirst,
    #[default]
    MonthFirst,
}

/// The format of a column's times: numbers in this unit, or dates with this order of day and month.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct TimeFormat {
    pub(crate) unit: TimeUnit,
    pub(crate) order: Order,
}

impl TimeFormat {
    /// The time in a cell, ns since 1970 or since the beginning of the count.
    pub(crate) fn nanoseconds(self, cell: &str) -> Option<i64> {
        decimal(cell, self.unit)
            .or_else(|| date(cell, self.order))
            .or_else(|| duration(cell))
    }
}

/// Whether a cell is a time other than a plain number.
pub(crate) fn is_time(cell: &str) -> bool {
    let date = |order| date(cell, order).is_some();
    date(Order::MonthFirst) || date(Order::DayFirst) || duration(cell).is_some()
}

/// Whether a cell is a day, without a time.
pub(crate) fn is_day(cell: &str) -> bool {
    let at_noon = format!("{cell} 12:00");
    !cell.contains(':')
        && !cell.is_empty()
        && (date(&at_noon, Order::MonthFirst).is_some_and(|it| it > DAY)
            || date(&at_noon, Order::DayFirst).is_some_and(|it| it > DAY))
}

/// `0.05 sec`.
fn duration(cell: &str) -> Option<i64> {
    let end = cell.find(|it: char| it.is_alphabetic() && !matches!(it, 'e' | 'E'))?;
    let (amount, unit) = (number(cell[..end].trim())?, cell[end..].trim());
    let all = amount * TimeUnit::named(unit)?.nanoseconds() as f64;
    (all.abs() < i64::MAX as f64).then_some(all.round() as i64)
}

/// A date with a time of day, or a time of day, ns; UTC unless a zone is written.
pub(crate) fn date(cell: &str, order: Order) -> Option<i64> {
    let parts = Parts::of(cell)?;
    let date = match &parts.date {
        Day::None => 0,
        Day::Count(days) => days.checked_mul(DAY)?,
        Day::TimeFormat(text) => {
            let (year, month, day) = calendar(text, order)?;
            let date = civil::Date::new(year, month, day).ok()?;
            let midnight = TimeZone::UTC.to_timestamp(date.to_datetime(civil::Time::midnight()));
            midnight.ok()?.as_second().checked_mul(1_000_000_000)?
        }
    };
    // Hours beyond a day are those of a stopwatch.
    let is_clock = parts.time < DAY + 1_000_000_000;
    (is_clock || parts.date == Day::None).then(|| date.checked_add(parts.time))?
}

/// The first two numbers of a date, each of which may be the day.
pub(crate) fn day_and_month(cell: &str) -> Option<(u32, u32)> {
    let parts = Parts::of(cell)?;
    let Day::TimeFormat(text) = &parts.date else {
        return None;
    };
    let numbers: Vec<&str> = text.split(['/', '-']).map(str::trim).collect();
    match numbers[..] {
        [first, second, year] if first.len() < 3 && matches!(year.len(), 2 | 4) => {
            Some((first.parse().ok()?, second.parse().ok()?))
        }
        _ => None,
    }
}

#[derive(Clone, Debug, PartialEq)]
enum Day {
    None,
    /// Days of a duration.
    Count(i64),
    TimeFormat(String),
}

/// The parts of a cell.
struct Parts {
    date: Day,
    /// Time of day, ns, minus the zone's offset.
    time: i64,
}

impl Parts {
    fn of(cell: &str) -> Option<Self> {
        let text = cell.trim_matches([' ', '"', '\'', '[', ']']);
        let Some(colon) = text.find(':') else {
            return Self::compact(text);
        };
        let is_digit = |it: &u8| it.is_ascii_digit();
        let bytes = text.as_bytes();
        let hours = bytes[..colon]
            .iter()
            .rev()
            .take_while(|it| is_digit(it))
            .count();
        let start = colon - hours;
        let rest = bytes[colon..].iter();
        let end = colon
            + rest
                .take_while(|it| is_digit(it) || matches!(**it, b':' | b'.' | b','))
                .count();
        let mut time = clock(&text[start..end])?;
        let mut behind = text[end..].trim();
        let (half, word) = half(behind);
        if let Some(afternoon) = half {
            time += match (time / HOUR, afternoon) {
                (12, false) => -12 * HOUR,
                (0..12, true) => 12 * HOUR,
                _ => 0,
            };
            behind = behind[word..].trim();
        }
        let (zone, behind) = zone(behind)?;
        let before = text[..start]
            .trim_end_matches(['T', 't', ' ', ',', '_', ';'])
            .trim();
        let date = match (before, behind) {
            ("", "") => Day::None,
            (before, "") => match before.split_once(' ') {
                Some((count, "day" | "days")) => {
                    Day::Count(count.parse().ok().filter(|it| *it >= 0)?)
                }
                _ => Day::TimeFormat(before.to_owned()),
            },
            ("", behind) => Day::TimeFormat(behind.to_owned()),
            (before, year) => Day::TimeFormat(format!("{before} {year}")),
        };
        Some(Self {
            date,
            time: time - zone,
        })
    }

    /// `20261124T120000.050`.
    fn compact(text: &str) -> Option<Self> {
        let (date, time) = text.split_once(['T', '_', ' '])?;
        let time = time.strip_suffix('Z').unwrap_or(time);
        let digits = |text: &str| text.bytes().all(|it| it.is_ascii_digit());
        let whole = time.split(['.', ',']).next()?;
        let is_it = date.len() == 8 && digits(date) && whole.len() == 6 && digits(whole);
        is_it.then_some(())?;
        let time = format!("{}:{}:{}", &time[..2], &time[2..4], &time[4..]);
        Some(Self {
            date: Day::TimeFormat(format!("{}-{}-{}", &date[..4], &date[4..6], &date[6..])),
            time: clock(&time)?,
        })
    }
}

/// `12:00`, `12:00:00.050`, `12:00:00:050`, `00:01.5` in minutes; ns.
fn clock(text: &str) -> Option<i64> {
    let mut parts: Vec<&str> = text.split(':').collect();
    let mut fraction = "";
    if let Some((whole, part)) = parts.last()?.split_once(['.', ',']) {
        *parts.last_mut()? = whole;
        fraction = part;
        // A comma that ends the time is none of its own.
        if parts.len() == 2 {
            parts.insert(0, "0");
        }
    } else if parts.len() == 4 {
        fraction = parts.pop()?;
        (fraction.len() == 3).then_some(())?;
    }
    let of = |at: usize| match parts.get(at) {
        Some(text) if text.len() <= 6 => text.parse::<u32>().ok().map(i64::from),
        Some(_) => None,
        None => Some(0),
    };
    let (hours, minutes, seconds) = (of(0)?, of(1)?, of(2)?);
    let is_time = (2..=3).contains(&parts.len()) && minutes < 60 && seconds <= 60;
    is_time.then_some(())?;
    let digits = fraction.get(..fraction.len().min(9))?;
    let part = match digits {
        "" => 0,
        digits => format!("{digits:0<9}").parse::<u32>().ok()?,
    };
    let is_fraction = fraction.bytes().all(|it| it.is_ascii_digit());
    is_fraction.then_some(((hours * 60 + minutes) * 60 + seconds) * 1_000_000_000 + i64::from(part))
}

/// Whether the text begins with AM or PM, and the length of that mark.
fn half(text: &str) -> (Option<bool>, usize) {
    for (mark, afternoon) in [("a.m.", false), ("p.m.", true), ("am", false), ("pm", true)] {
        let is_it = text
            .get(..mark.len())
            .is_some_and(|it| it.eq_ignore_ascii_case(mark));
        if is_it {
            return (Some(afternoon), mark.len());
        }
    }
    (None, 0)
}

/// The offset of the zone at the beginning of the text, ns, and the rest.
fn zone(text: &str) -> Option<(i64, &str)> {
    for name in ["Z", "UTC", "GMT"] {
        if let Some(rest) = text.strip_prefix(name) {
            return Some((0, rest.trim_start()));
        }
    }
    let (sign, rest) = match text.as_bytes().first() {
        Some(b'+') => (1, &text[1..]),
        Some(b'-') => (-1, &text[1..]),
        _ => return Some((0, text)),
    };
    let (zone, behind) = rest.split_once(' ').unwrap_or((rest, ""));
    let digits: String = zone.split(':').collect();
    let number: i64 = digits.parse().ok()?;
    let minutes = match digits.len() {
        1 | 2 => number * 60,
        4 => number / 100 * 60 + number % 100,
        _ => return None,
    };
    Some((sign * minutes * 60_000_000_000, behind.trim()))
}

/// Months by their first letters, in English and German.
const MONTHS: [(&str, i8); 18] = [
    ("jan", 1),
    ("feb", 2),
    ("mar", 3),
    ("mär", 3),
    ("mrz", 3),
    ("apr", 4),
    ("may", 5),
    ("mai", 5),
    ("jun", 6),
    ("jul", 7),
    ("aug", 8),
    ("sep", 9),
    ("oct", 10),
    ("okt", 10),
    ("nov", 11),
    ("dec", 12),
    ("dez", 12),
    ("jän", 1),
];

const WEEKDAYS: [&str; 14] = [
    "mon", "tue", "wed", "thu", "fri", "sat", "sun", "mo", "di", "mi", "do", "fr", "sa", "so",
];

/// Year, month and day.
fn calendar(text: &str, order: Order) -> Option<(i16, i8, i8)> {
    let lower = text.to_lowercase();
    let parts = lower.split(|it: char| !it.is_alphanumeric());
    let parts: Vec<&str> = parts
        .filter(|it| !it.is_empty() && !WEEKDAYS.contains(it))
        .collect();
    let [first, second, third] = parts[..] else {
        return None;
    };
    let month = |text: &str| {
        let is_it = |(name, _): &&(&str, i8)| text.starts_with(name);
        MONTHS.iter().find(is_it).map(|it| it.1)
    };
    let year = |text: &str| match text.len() {
        4 => text.parse::<i16>().ok(),
        2 => text.parse::<i16>().ok().map(|it| it + 2000),
        _ => None,
    };
    if let Some(month) = month(second) {
        // 24-Nov-2026, 2026-Nov-24
        return match first.len() {
            4 => Some((year(first)?, month, third.parse().ok()?)),
            _ => Some((year(third)?, month, first.parse().ok()?)),
        };
    }
    if let Some(month) = month(first) {
        return Some((year(third)?, month, second.parse().ok()?));
    }
    if first.len() == 4 {
        return Some((year(first)?, second.parse().ok()?, third.parse().ok()?));
    }
    let (first, second) = (first.parse().ok()?, second.parse().ok()?);
    let is_dotted = text.contains('.');
    // 26-11-24 may be of two years.
    (third.len() == 4 || is_dotted || text.contains('/')).then_some(())?;
    match is_dotted || order == Order::DayFirst {
        true => Some((year(third)?, second, first)),
        false => Some((year(third)?, first, second)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_date_is_read_however_it_is_written() {
        // 2026-11-24 12:00:00.05 UTC, by `date -d ... +%s`.
        let expected = 1_795_521_600_050_000_000;
        for text in [
            "2026-11-24T12:00:00.05Z",
            "2026-11-24 12:00:00.050",
            "2026-11-24T12:00:00,05",
            "2026-11-24T13:00:00.05+01:00",
            "2026-11-24 13:00:00.05+0100",
            "2026-11-24 13:00:00.05+01",
            "2026-11-24 05:30:00.05 -0630",
            "2026-11-24 12:00:00.05 UTC",
            "2026/11/24 12:00:00.050",
            "2026/11/24, 12:00:00:050",
            "24.11.2026 12:00:00,05",
            "24.11.26 12:00:00,05",
            " 11/24/2026 12:00:00.050 ",
            "11/24/2026 12:00:00.050 PM",
            "11/24/2026, 12:00:00.050 p.m.",
            "11/24/26 12:00:00.050",
            "24-Nov-2026 12:00:00.050",
            "24-Nov-26 12:00:00.050",
            "24 November 2026 12:00:00.050",
            "Nov 24, 2026 12:00:00.050 PM",
            "Tue Nov 24 12:00:00.05 2026",
            "Tue Nov 24 12:00:00.05 UTC 2026",
            "12:00:00.05 24.11.2026",
            "20261124T120000.050",
            "20261124T120000.05Z",
        ] {
            assert_eq!(date(text, Order::MonthFirst), Some(expected), "{text}");
        }
        assert_eq!(
            date("24/11/2026 12:00:00.05", Order::DayFirst),
            Some(expected)
        );
        assert_eq!(date("24/11/2026 12:00:00.05", Order::MonthFirst), None);
        assert_eq!(day_and_month("24/11/2026 12:00"), Some((24, 11)));
        assert_eq!(day_and_month("24.11.2026 12:00"), None);
        assert_eq!(day_and_month("2026/11/24 12:00"), None);
    }

    #[test]
    fn a_time_of_day_has_noon_and_midnight_and_a_stopwatch_runs_on() {
        let second = 1_000_000_000;
        for (text, expected) in [
            ("00:01:02.5", 62 * second + second / 2),
            ("12:30", 45_000 * second),
            ("12:00:00 AM", 0),
            ("12:00:00 PM", 43_200 * second),
            ("1:02:03.5 PM", 46_923 * second + second / 2),
            ("01:02.5", 62 * second + second / 2),
            ("25:00:00", 90_000 * second),
            ("0 days 00:00:00.050000", second / 20),
            ("1 days 00:00:01", 86_401 * second),
        ] {
            assert_eq!(date(text, Order::MonthFirst), Some(expected), "{text}");
        }
        for (text, expected) in [
            ("0.05 sec", second / 20),
            ("50 ms", second / 20),
            ("1.5 min", 90 * second),
            ("2e0 s", 2 * second),
        ] {
            assert_eq!(duration(text), Some(expected), "{text}");
        }
        for text in [
            "2026-11-24",
            "t:",
            "noon:",
            ":",
            "1:",
            ":1",
            "::",
            "12:60:00",
            "12:00:61",
            "9999-12-31T23:59:59Z",
            "32.01.2026 00:00",
            "26-11-24 12:00:00",
            "2026-11-24 25:00:00",
            "12:00:00 XM",
            "12:00:00.x",
            "ä:1",
            "1:1é",
            "+1:2:3:4:5",
        ] {
            assert_eq!(date(text, Order::MonthFirst), None, "{text}");
        }
    }
}
