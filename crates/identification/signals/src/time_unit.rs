//! The unit of a column of times: from its name, the size of its numbers, or the steps between them.

use std::ops::Range;

use crate::quantile::median;

/// Present days counted from 1900 (Excel) and from the year 0 (MATLAB), with the day number of 1970-01-01.
const DAYS: [(Range<f64>, f64); 2] = [
    (20_000.0..90_000.0, 25_569.0),
    (700_000.0..800_000.0, 719_529.0),
];

planesman_text::choices! {
    /// The unit of a CSV file's time.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum TimeUnit {
        #[default]
        S = "s": "Seconds",
        Ms = "ms": "Milliseconds",
        Us = "us": "Microseconds",
        Ns = "ns": "Nanoseconds",
        Min = "min": "Minutes",
        H = "h": "Hours",
        D = "d": "Days",
    }
}

impl TimeUnit {
    /// The unit with this name, for example at the end of a column's name.
    #[must_use]
    pub fn named(text: &str) -> Option<Self> {
        Some(match text {
            "s" | "sec" | "secs" | "second" | "seconds" => Self::S,
            "ms" | "msec" | "msecs" | "millis" | "milliseconds" => Self::Ms,
            "us" | "usec" | "usecs" | "micros" | "\u{b5}s" | "\u{3bc}s" | "microseconds" => {
                Self::Us
            }
            "ns" | "nsec" | "nanosec" | "nsecs" | "nanoseconds" => Self::Ns,
            "min" | "mins" | "minute" | "minutes" => Self::Min,
            "h" | "hr" | "hrs" | "hour" | "hours" => Self::H,
            "d" | "day" | "days" => Self::D,
            _ => return None,
        })
    }

    /// Decimal places to nanoseconds: of this unit, or of a second.
    #[must_use]
    pub(crate) fn places(self) -> u32 {
        match self {
            Self::S | Self::Min | Self::H | Self::D => 9,
            Self::Ms => 6,
            Self::Us => 3,
            Self::Ns => 0,
        }
    }

    /// Converts a number in this unit to ns; `None` beyond 64 bits. Days are counted from 1970, after conversion from Excel's 1900 or
    /// MATLAB's year 0.
    #[must_use]
    pub fn in_nanoseconds(self, number: f64) -> Option<i64> {
        let origin = DAYS.iter().find(|(days, _)| days.contains(&number));
        let origin = origin.filter(|_| self == Self::D).map_or(0.0, |it| it.1);
        let nanoseconds = (number - origin) * self.nanoseconds() as f64;
        let fits = nanoseconds.abs() < i64::MAX as f64;
        fits.then_some(nanoseconds.round() as i64)
    }

    /// Nanoseconds per unit.
    pub(crate) fn nanoseconds(self) -> i64 {
        let seconds = match self {
            Self::Min => 60,
            Self::H => 3600,
            Self::D => 86_400,
            _ => 1,
        };
        seconds * 10_i64.pow(self.places())
    }
}

/// Usual names of the time, without their unit.
pub(crate) const NAMES: [&str; 22] = [
    "time",
    "t",
    "stamp",
    "timestamp",
    "_time",
    "__time",
    "datetime",
    "date_time",
    "elapsed",
    "seconds",
    "timestamp_sample",
    "rosbagTimestamp",
    "time_boot",
    "x_value",
    "last_changed",
    "last_updated",
    "date/time",
    "zeit",
    "temps",
    "tiempo",
    "tempo",
    "tijd",
];

/// Number of values examined.
pub(crate) const LOOKED_AT: usize = 500;

/// Whole numbers whose usual step is at least this are not seconds, unless all are whole minutes.
const NO_SECONDS: f64 = 1000.0;

/// Whole numbers with a usual step of at least this may be milliseconds.
const MILLISECONDS: f64 = 10.0;

/// A first number above this limit, four months in seconds, is not in seconds; if the steps are also above this limit, it is in microseconds.
const RUNNING: f64 = 1e7;
const FAST: f64 = 100.0;

/// Times with at least these steps are clearly in microseconds, or in nanoseconds.
const MICROSECONDS: (f64, f64) = (5e3, 2e5);
const NANOSECONDS: f64 = 2e6;

/// The unit of times, and how it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct JudgedUnit {
    pub(crate) unit: TimeUnit,
    pub(crate) known: Known,
}

/// Certainty of a unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Known {
    /// The user or the column's name gave the unit.
    #[default]
    Named,
    /// Only this unit fits.
    Surely(&'static str),
    /// It is likely.
    Likely(&'static str),
    /// Seconds, the default.
    Assumed,
}

impl From<TimeUnit> for JudgedUnit {
    fn from(unit: TimeUnit) -> Self {
        Self {
            unit,
            known: Known::Named,
        }
    }
}

impl JudgedUnit {
    /// The unit, and how it is known, to be printed after the column's name; empty for seconds.
    pub(crate) fn told(&self) -> String {
        let unit = self.unit.name();
        match self.known {
            _ if self.unit == TimeUnit::S => String::new(),
            Known::Named | Known::Assumed => format!(", in {unit}"),
            Known::Surely(how) | Known::Likely(how) => format!(", in {unit}, {how}"),
        }
    }
}

/// The column of the times, by its name; a unit of time alone is such a name.
pub(crate) fn column<'a>(columns: impl Iterator<Item = &'a str> + Clone) -> Option<usize> {
    let named = |name: &str| {
        let is_it =
            |it: &str| it.eq_ignore_ascii_case(name) || named(it).0.eq_ignore_ascii_case(name);
        columns.clone().position(is_it)
    };
    let is_unit = |it: &str| self::named(it).0.is_empty() && self::named(it).1.is_some();
    let by_name = NAMES.iter().find_map(|name| named(name));
    by_name.or_else(|| columns.clone().position(is_unit))
}

/// Whether a name is that of a time, in contrast to that of a unit.
pub(crate) fn is_name(column: &str) -> bool {
    let is_it = |it: &str| {
        [column, named(column).0]
            .iter()
            .any(|name| name.eq_ignore_ascii_case(it))
    };
    column.eq_ignore_ascii_case("date") || NAMES.iter().any(|it| *it != "seconds" && is_it(it))
}

/// The unit that a name ends in, and the name before: `t_ms`, `time [ms]`, `Time (s)`, `time/ms`, `TimeUS`, `micros`.
pub(crate) fn named(column: &str) -> (&str, Option<TimeUnit>) {
    let column = column.trim().trim_end_matches([']', ')']);
    let unit = |text: &str| TimeUnit::named(&text.trim().to_ascii_lowercase());
    let parted = column.rfind(['[', '(', '/', '_', ' ']).and_then(|at| {
        let (name, ending) = (&column[..at], &column[at + 1..]);
        Some((name.trim_end(), Some(unit(ending)?)))
    });
    let camel = || {
        // A capital behind a small letter begins the unit.
        let bytes = column.as_bytes();
        let at = (1..bytes.len())
            .rev()
            .find(|at| bytes[*at].is_ascii_uppercase() && bytes[at - 1].is_ascii_lowercase())?;
        Some((&column[..at], Some(unit(&column[at..])?)))
    };
    // One letter alone is a time, a height or a distance.
    let alone = || Some(("", Some(unit(column).filter(|_| column.len() > 4)?)));
    let found = parted.or_else(camel).or_else(alone);
    found.unwrap_or((column, None))
}

/// The unit of a column whose name gives no unit, from its first numbers.
pub(crate) fn judged(numbers: &[f64]) -> JudgedUnit {
    let is = |unit, known| JudgedUnit { unit, known };
    let assumed = is(TimeUnit::S, Known::Assumed);
    let Some(first) = numbers.first() else {
        return assumed;
    };
    // From 2001 to 2286.
    let dates = [
        (TimeUnit::S, 1e9),
        (TimeUnit::Ms, 1e12),
        (TimeUnit::Us, 1e15),
        (TimeUnit::Ns, 1e18),
    ];
    let is_date = |least: f64| (least..10.0 * least).contains(first);
    if let Some((unit, _)) = dates.into_iter().find(|(_, least)| is_date(*least)) {
        return is(unit, Known::Surely("by their size"));
    }
    let Some(step) = usual_step(numbers) else {
        return assumed;
    };
    let is_whole = numbers.iter().all(|it| it.fract() == 0.0);
    if !is_whole {
        let are_days = step < 0.01 && DAYS.iter().any(|(days, _)| days.contains(first));
        return match are_days {
            true => is(TimeUnit::D, Known::Surely("by their size")),
            false => assumed,
        };
    }
    let are_minutes = numbers.iter().all(|it| it % 60.0 == 0.0);
    if (MILLISECONDS..NO_SECONDS).contains(&step) && !are_minutes {
        return match step {
            _ if *first < RUNNING => is(
                TimeUnit::S,
                Known::Likely("although milliseconds can have such steps"),
            ),
            step if step < FAST => is(TimeUnit::Ms, Known::Likely("by their size")),
            _ => is(TimeUnit::Us, Known::Likely("by their size")),
        };
    }
    if step < NO_SECONDS || are_minutes {
        return assumed;
    }
    let by_step = "by their steps";
    match step {
        step if step >= NANOSECONDS => is(TimeUnit::Ns, Known::Surely(by_step)),
        step if (MICROSECONDS.0..=MICROSECONDS.1).contains(&step) => {
            is(TimeUnit::Us, Known::Surely(by_step))
        }
        _ => is(TimeUnit::Us, Known::Likely(by_step)),
    }
}

/// The median of the forward steps.
fn usual_step(numbers: &[f64]) -> Option<f64> {
    let mut steps: Vec<f64> = numbers.windows(2).map(|it| it[1] - it[0]).collect();
    steps.retain(|step| *step > 0.0);
    (!steps.is_empty()).then(|| median(&mut steps))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_ends_in_its_unit() {
        for (column, name, unit) in [
            ("t_ms", "t", Some(TimeUnit::Ms)),
            ("time [s]", "time", Some(TimeUnit::S)),
            ("Time (min)", "Time", Some(TimeUnit::Min)),
            ("time/ms", "time", Some(TimeUnit::Ms)),
            ("TimeUS", "Time", Some(TimeUnit::Us)),
            ("time_usec", "time", Some(TimeUnit::Us)),
            ("micros", "", Some(TimeUnit::Us)),
            ("timestamp", "timestamp", None),
            ("h", "h", None),
            ("Depth", "Depth", None),
            ("", "", None),
        ] {
            assert_eq!(named(column), (name, unit), "{column}");
        }
    }

    #[test]
    fn a_unit_is_judged_by_size_and_steps() {
        let times = |first: f64, step: f64| -> Vec<f64> {
            (0..100).map(|k| first + step * f64::from(k)).collect()
        };
        for (first, step, unit, known) in [
            (1.7e9, 0.05, TimeUnit::S, Known::Surely("by their size")),
            (1.7e15, 5e4, TimeUnit::Us, Known::Surely("by their size")),
            (
                13_550_000.0,
                5e4,
                TimeUnit::Us,
                Known::Surely("by their steps"),
            ),
            (7.0, 5e7, TimeUnit::Ns, Known::Surely("by their steps")),
            (0.0, 1000.0, TimeUnit::Us, Known::Likely("by their steps")),
            (0.0, 3600.0, TimeUnit::S, Known::Assumed),
            (
                46_350.5,
                0.05 / 86_400.0,
                TimeUnit::D,
                Known::Surely("by their size"),
            ),
            (
                740_000.25,
                0.1 / 86_400.0,
                TimeUnit::D,
                Known::Surely("by their size"),
            ),
            (0.0, 0.05, TimeUnit::S, Known::Assumed),
            (0.0, 60.0, TimeUnit::S, Known::Assumed),
            (0.0, 9.0, TimeUnit::S, Known::Assumed),
            (4e7, 500.0, TimeUnit::Us, Known::Likely("by their size")),
            (4e7, 20.0, TimeUnit::Ms, Known::Likely("by their size")),
            (
                0.0,
                50.0,
                TimeUnit::S,
                Known::Likely("although milliseconds can have such steps"),
            ),
        ] {
            let judged = judged(&times(first, step));
            assert_eq!((judged.unit, judged.known), (unit, known), "{first} {step}");
        }
    }

    #[test]
    fn days_are_counted_from_1970() {
        // 2026-11-24 12:00: openpyxl's to_excel, and datenum(2026, 11, 24, 12, 0, 0).
        for number in [46_350.5, 740_310.5] {
            let noon = TimeUnit::D.in_nanoseconds(number);
            assert_eq!(noon, Some(1_795_521_600_000_000_000));
        }
        assert_eq!(TimeUnit::D.in_nanoseconds(1.5), Some(129_600_000_000_000));
        assert_eq!(TimeUnit::D.in_nanoseconds(1e300), None);
        assert_eq!(TimeUnit::D.in_nanoseconds(f64::NAN), None);
    }
}
