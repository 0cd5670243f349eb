//! Finds the time of a table, and its format.

use csv::ByteRecord;
use planesman_text::shown;

use super::{CsvSource, TableTime, Time};
use crate::csv_cell::{is_missing, number, value};
use crate::csv_time::{self, Order, TimeFormat};
use crate::error::{Result, SourceError};
use crate::time_unit::{self, JudgedUnit, Known, TimeUnit};
use crate::unit_name::with_unit;

/// Names of a time in two columns: of the whole seconds, after the last separator of a longer name, and of the fraction.
const SECONDS: [&str; 4] = ["sec", "secs", "seconds", "s"];

const PARTS: [(&str, TimeUnit); 14] = [
    ("nanosec", TimeUnit::Ns),
    ("nanosecs", TimeUnit::Ns),
    ("nanoseconds", TimeUnit::Ns),
    ("nsec", TimeUnit::Ns),
    ("nsecs", TimeUnit::Ns),
    ("ns", TimeUnit::Ns),
    ("microseconds", TimeUnit::Us),
    ("microsec", TimeUnit::Us),
    ("usec", TimeUnit::Us),
    ("us", TimeUnit::Us),
    ("milliseconds", TimeUnit::Ms),
    ("millisec", TimeUnit::Ms),
    ("msec", TimeUnit::Ms),
    ("ms", TimeUnit::Ms),
];

/// Names of a column that counts the rows; an empty name counts too.
const COUNTS: [&str; 14] = [
    "",
    "index",
    "row",
    "sample",
    "samples",
    "n",
    "no",
    "nr",
    "num",
    "#",
    "id",
    "seq",
    "count",
    "unnamed: 0",
];

/// Names of a column that counts the cycles of a loop or the frames of a camera.
const LOOPS: [&str; 7] = [
    "loopiteration",
    "iteration",
    "iter",
    "frame",
    "frame_number",
    "frameid",
    "packet",
];

/// The whole seconds of dates from 1980 to 2096.
const EPOCH: std::ops::Range<f64> = 315e6..4e9;

impl CsvSource {
    pub(super) fn find_time(&self, asked: &TableTime, start: &[Vec<String>]) -> Result<Time> {
        if let Some(seconds) = asked.sample_time {
            // As the grid of that rate has it: then every row lies on an instant.
            return Ok(Time::Rows(1e9 / (1.0 / seconds)));
        }
        if self.form.serial.has_stamps && asked.column.is_none() {
            return Ok(Time::Named(0));
        }
        if let (true, None, Some(step)) = (
            self.form.heading.has_interval(),
            &asked.column,
            self.form.heading.interval,
        ) {
            return Ok(Time::Rows(step));
        }
        let columns = &self.form.columns;
        if let Some(name) = &asked.column {
            let two = name.split_once('+').filter(|_| !columns.contains(name));
            let places = self.places();
            let place = |name: &str| self.place(&places, name.trim());
            return Ok(match two {
                None => Time::Named(place(name)?),
                Some((first, second)) => {
                    let (first, second) = (place(first)?, place(second)?);
                    let is_date = csv_time::is_day(cell(start, first));
                    let unit = part(&columns[second]).map_or(TimeUnit::Ns, |it| it.1);
                    match is_date {
                        true => Time::Dated(first, second),
                        false => Time::Parts(first, second, unit),
                    }
                }
            });
        }
        let plain: Vec<&str> = columns.iter().map(|it| with_unit(it).0).collect();
        let find = |name: &str| plain.iter().position(|it| it.eq_ignore_ascii_case(name));
        // A column that is empty is no time, whatever its name.
        let is_empty = |at: usize| {
            let is_missing = |row: &Vec<String>| row.get(at).is_none_or(|it| is_missing(it));
            !start.is_empty() && start.iter().all(is_missing)
        };
        let with_cells = columns.iter().enumerate();
        let names: Vec<&str> = with_cells
            .map(|(at, name)| if is_empty(at) { "" } else { name })
            .collect();
        let named = time_unit::column(names.into_iter());
        let parts = || {
            let mut pairs = columns.windows(2).enumerate();
            pairs.find_map(|(at, pair)| {
                let (before, unit) = part(&pair[1])?;
                let is_it = |name: &str| pair[0].eq_ignore_ascii_case(&format!("{before}{name}"));
                SECONDS
                    .iter()
                    .any(|it| is_it(it))
                    .then_some(Time::Parts(at, at + 1, unit))
            })
        };
        Ok(match named {
            Some(place)
                if find("date").is_some_and(|it| csv_time::is_day(cell(start, it)))
                    && csv_time::date(cell(start, place), Order::default())
                        .is_some_and(|it| it < csv_time::DAY) =>
            {
                Time::Dated(find("date").unwrap_or(place), place)
            }
            Some(place) => match parts() {
                Some(Time::Parts(first, second, unit)) if first == place || second == place => {
                    Time::Parts(first, second, unit)
                }
                _ => Time::Named(place),
            },
            None => parts()
                .or_else(|| self.dates_in(start))
                .unwrap_or_else(|| self.found_in(start)),
        })
    }

    /// The first column with a date and a time of day in every cell.
    fn dates_in(&self, start: &[Vec<String>]) -> Option<Time> {
        let is_date = |cell: &str| {
            let date = |order| csv_time::date(cell, order).is_some_and(|it| it > csv_time::DAY);
            date(Order::MonthFirst) || date(Order::DayFirst)
        };
        let are_dates = |at: &usize| {
            start
                .iter()
                .all(|row| row.get(*at).is_some_and(|it| is_date(it)))
        };
        let place = (0..self.form.columns.len()).find(are_dates);
        place.filter(|_| !start.is_empty()).map(Time::Named)
    }

    /// A time that no name reveals: an epoch with its nanoseconds in the first two columns, or a first column that rises.
    fn found_in(&self, start: &[Vec<String>]) -> Time {
        let whole = |row: &Vec<String>, at: usize| {
            let number = row.get(at).and_then(|it| it.parse::<f64>().ok());
            number.filter(|it| it.fract() == 0.0)
        };
        let is_epoch = |row: &Vec<String>| {
            let (seconds, parts) = (whole(row, 0), whole(row, 1));
            seconds.is_some_and(|it| EPOCH.contains(&it))
                && parts.is_some_and(|it| (0.0..1e9).contains(&it))
        };
        // A second number of 1000 and less is none of nanoseconds: one row in a million has it.
        let is_small = |row: &Vec<String>| whole(row, 1).is_some_and(|it| it <= 1000.0);
        if !start.is_empty() && start.iter().all(is_epoch) && !start.iter().skip(1).all(is_small) {
            return Time::Parts(0, 1, TimeUnit::Ns);
        }
        let is_text = |at: usize| {
            let mut cells = start.iter().filter_map(|row| row.get(at));
            cells.all(|it| value(it).is_none() && !csv_time::is_time(it))
        };
        let has_text = (1..self.form.columns.len()).any(is_text);
        let stamp = |order| {
            let written = TimeFormat {
                unit: TimeUnit::Ms,
                order,
            };
            let stamps = start
                .iter()
                .map(move |row| written.nanoseconds(row.first()?));
            let rises = |(a, b): (Option<i64>, Option<i64>)| a.is_some() && a < b;
            let pairs = || stamps.clone().zip(stamps.clone().skip(1));
            // In a long table several rows may have one time.
            let stands = |(a, b): (Option<i64>, Option<i64>)| a.is_some() && a == b;
            let is_long = || has_text && 4 * pairs().filter(|it| rises(*it)).count() > start.len();
            pairs().all(rises) || (is_long() && pairs().all(|it| rises(it) || stands(it)))
        };
        if start.len() < 2 || !(stamp(Order::MonthFirst) || stamp(Order::DayFirst)) {
            return Time::Unknown;
        }
        let name = &self.form.columns[0];
        let is_named = COUNTS.iter().any(|it| it.eq_ignore_ascii_case(name));
        let mut counts = start
            .windows(2)
            .map(|it| Some(whole(&it[1], 0)? - whole(&it[0], 0)?));
        let begins = start.first().and_then(|row| whole(row, 0));
        let from_start = begins == Some(0.0) || begins == Some(1.0);
        // A loop of which every so many are logged counts in steps of so many.
        let is_loop = LOOPS.iter().any(|it| it.eq_ignore_ascii_case(name));
        let first = counts.next().flatten();
        let is_count = match is_loop {
            true => first.is_some(),
            false => (is_named || !self.form.has_names) && from_start && first == Some(1.0),
        };
        match is_count && counts.all(|it| it == first) {
            true => Time::Counted,
            false => Time::Rising,
        }
    }

    /// Finds the format of the time: the requested unit, or the unit in the column's name; the unit in which the first number is a present date;
    /// days; the order of day and month.
    pub(super) fn find_written(&mut self, asked: &TableTime, start: &[Vec<String>]) -> Result<()> {
        let (Some(column), false) = (self.time_column(), matches!(self.time, Time::Parts(..)))
        else {
            if asked.sample_time.is_none() && self.form.heading.has_interval() {
                self.written_told = ", the Delta_X in its heading".to_owned();
            }
            return Ok(());
        };
        let name = self.form.columns[column].clone();
        let first = cell(start, column);
        if csv_time::day_and_month(&self.dated(first, start)).is_some() {
            let (order, told) = self.find_order(column)?;
            let unit = asked.unit.unwrap_or_default();
            self.written = TimeFormat { unit, order };
            self.written_told = told;
            return Ok(());
        }
        let named = asked.unit.or(time_unit::named(&name).1);
        let is_blackbox = || name == "time" && self.form.columns[0] == "loopIteration";
        let judged = match named {
            Some(unit) => JudgedUnit::from(unit),
            None if is_blackbox() => JudgedUnit {
                unit: TimeUnit::Us,
                known: Known::Surely("as written by blackbox_decode"),
            },
            None if name.eq_ignore_ascii_case("seconds") => TimeUnit::S.into(),
            None => {
                let numbers = start.iter().filter_map(|row| number(row.get(column)?));
                match numbers.collect::<Vec<f64>>() {
                    // Dates have no unit.
                    numbers if numbers.is_empty() => TimeUnit::S.into(),
                    numbers => time_unit::judged(&numbers),
                }
            }
        };
        self.written.unit = judged.unit;
        self.known = judged.known;
        self.written_told = judged.told();
        Ok(())
    }

    /// The cell of the time; if the date has a separate column, followed by the time of day.
    fn dated(&self, first: &str, start: &[Vec<String>]) -> String {
        match self.time {
            Time::Dated(_, time) => format!("{first} {}", cell(start, time)),
            _ => first.to_owned(),
        }
    }

    /// The order of day and month in the dates of that column, from all its rows. If both are possible, the order in which no two rows are half a day
    /// apart.
    fn find_order(&self, column: usize) -> Result<(Order, String)> {
        let mut reader = self.reader()?;
        let mut row = ByteRecord::new();
        let (mut days, mut months) = (0, 0);
        let mut leaps = [0_u64; 2];
        let mut last = [None; 2];
        let mut first = None;
        while reader.read(&mut row)? {
            let text = |at: usize| {
                std::str::from_utf8(row.get(at).unwrap_or_default()).unwrap_or_default()
            };
            let text = match self.time {
                Time::Dated(_, time) => format!("{} {}", text(column), text(time)),
                _ => text(column).to_owned(),
            };
            let Some((one, other)) = csv_time::day_and_month(&text) else {
                continue;
            };
            (days, months) = (days.max(one), months.max(other));
            for (k, order) in [Order::DayFirst, Order::MonthFirst].into_iter().enumerate() {
                let stamp = csv_time::date(&text, order);
                let leap = |last: i64, next: i64| last.abs_diff(next) > csv_time::DAY as u64 / 2;
                leaps[k] += u64::from(
                    last[k]
                        .zip(stamp)
                        .is_some_and(|(last, next)| leap(last, next)),
                );
                last[k] = stamp.or(last[k]);
            }
            first.get_or_insert(text);
        }
        let told = |order: &str| format!(", dates read as {order}");
        Ok(match (days > 12, months > 12) {
            (true, false) => (Order::DayFirst, told("day/month/year")),
            (false, true) => (Order::MonthFirst, told("month/day/year")),
            // On one day it is the same.
            (false, false) if leaps == [0, 0] => (Order::MonthFirst, String::new()),
            (false, false) if leaps[0] == 0 => (
                Order::DayFirst,
                told("day/month/year: read as month/day/year the rows would jump in time"),
            ),
            (false, false) if leaps[1] == 0 => (
                Order::MonthFirst,
                told("month/day/year: read as day/month/year the rows would jump in time"),
            ),
            _ => {
                return Err(SourceError::Data(format!(
                    "{}: '{}' in '{}' may be day/month or month/day, and the other rows do not show which. Write the dates as 2026-11-24 12:00:00",
                    self.path.display(),
                    shown(first.unwrap_or_default()),
                    self.form.columns[column]
                )));
            }
        })
    }
}

/// A cell of the first row.
fn cell(start: &[Vec<String>], column: usize) -> &str {
    start
        .first()
        .and_then(|row| row.get(column))
        .map_or("", String::as_str)
}

/// The name of the fraction of seconds without its last word, and the unit: `header.stamp.` for `header.stamp.nanosec`.
fn part(name: &str) -> Option<(&str, TimeUnit)> {
    let start = name.rfind(['.', '_', '/', ' ']).map_or(0, |it| it + 1);
    let word = name[start..].trim_matches(['[', ']', '(', ')']);
    let (_, unit) = PARTS.iter().find(|it| it.0.eq_ignore_ascii_case(word))?;
    Some((&name[..start], *unit))
}
