//! Headings of LabVIEW's measurements (`.lvm`). Headings give the interval of rows without a time, and a file may have several headings, each with
//! rows below it.

use crate::csv_cell::number;
use crate::csv_time::{self, Order};

/// The assumed time between two parts with unknown distance, ns, and in intervals.
const PAUSE: f64 = 1e9;
const PAUSE_INTERVALS: f64 = 10.0;

/// The information of a heading about the rows below it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Heading {
    is_measurement: bool,
    has_times: bool,
    /// The interval of every column, ns; `None` if they differ, or are not times.
    pub(crate) interval: Option<f64>,
    date: String,
    time: String,
    /// Offset from the heading's time to the first row, ns.
    offset: f64,
}

impl Heading {
    /// Takes a line before the rows; returns whether it is the last of a heading.
    pub(crate) fn take<'a>(&mut self, mut cells: impl Iterator<Item = &'a str>) -> bool {
        let key = cells.next().unwrap_or_default();
        let cells: Vec<&str> = cells.filter(|it| !it.is_empty()).collect();
        let first = cells.first().copied().unwrap_or_default();
        match key {
            "LabVIEW Measurement" => self.is_measurement = true,
            "X_Columns" => self.has_times = !first.eq_ignore_ascii_case("no"),
            "X_Dimension" if cells.iter().any(|it| *it != "Time") => self.has_times = true,
            "Delta_X" => {
                let is_same = cells.iter().all(|it| *it == first);
                let seconds = number(first).filter(|it| is_same && *it > 0.0);
                self.interval = seconds.map(|it| it * 1e9);
            }
            "Date" => first.clone_into(&mut self.date),
            "Time" => first.clone_into(&mut self.time),
            "X0" => self.offset = number(first).unwrap_or_default() * 1e9,
            _ => {}
        }
        key == "***End_of_Header***"
    }

    /// Whether the rows below have an interval, but no times.
    pub(crate) fn has_interval(&self) -> bool {
        self.is_measurement && !self.has_times && self.interval.is_some()
    }

    /// The time of the first row, ns since 1970.
    fn begin(&self) -> Option<i64> {
        let text = format!("{} {}", self.date, self.time);
        let begin = csv_time::date(&text, Order::MonthFirst)?;
        begin.checked_add(self.offset as i64)
    }

    /// The time at which the heading's rows begin, ns, if the rows of the `first` heading begin at 0 and the last row before was at `last`.
    pub(crate) fn begins(&self, first: &Self, last: i64) -> i64 {
        let known = (self.begin().zip(first.begin())).map(|(own, first)| own.saturating_sub(first));
        let interval = self.interval.unwrap_or_default();
        // Written when the measurement began, it may be the same in each.
        let pause = PAUSE.max(PAUSE_INTERVALS * interval) as i64;
        known
            .filter(|it| *it > last)
            .unwrap_or_else(|| last.saturating_add(pause))
    }
}
