//! Way-depths: depth setpoints over time, or over the distance travelled.
//!
//! A schedule is an increasing list of times since the run began, or of distances along the initial heading since then, each with the depth
//! from there on. Before its first entry the parameter's setpoint applies.

use crate::error::ScheduleError;
use crate::manoeuvre::nanoseconds;

/// A sequence of depths.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Schedule {
    /// (nanoseconds since the run began, depth in m)
    OverTime(Vec<(i64, f64)>),
    /// (metres since the run began, depth in m)
    OverDistance(Vec<(f64, f64)>),
}

impl Default for Schedule {
    /// Says nothing.
    fn default() -> Self {
        Self::OverTime(Vec::new())
    }
}

impl Schedule {
    /// The schedule of `depths` (m, down) from `times` (s since the run began) on.
    ///
    /// # Errors
    /// [`ScheduleError`].
    pub(crate) fn over_time(times: &[f64], depths: &[f64]) -> Result<Self, ScheduleError> {
        check("time", "s", times, depths)?;
        let times: Vec<i64> = times.iter().map(|time| nanoseconds(*time)).collect();
        if let Some(pair) = times.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(ScheduleError::SameTime(pair[1] as f64 / 1e9));
        }
        let entries = times.into_iter().zip(depths.iter().copied());
        Ok(Self::OverTime(entries.collect()))
    }

    /// The schedule of `depths` (m, down) from `distances` (m along the initial heading since the run began) on.
    ///
    /// # Errors
    /// Like [`Schedule::over_time`].
    pub(crate) fn over_distance(distances: &[f64], depths: &[f64]) -> Result<Self, ScheduleError> {
        check("distance", "m", distances, depths)?;
        let entries = distances.iter().copied().zip(depths.iter().copied());
        Ok(Self::OverDistance(entries.collect()))
    }

    /// The scheduled depth, m, `elapsed` nanoseconds and `distance` metres after the run began; `None` before the first entry.
    #[must_use]
    pub(crate) fn depth(&self, elapsed: i64, distance: f64) -> Option<f64> {
        match self {
            Self::OverTime(entries) => begun(entries, elapsed),
            Self::OverDistance(entries) => begun(entries, distance),
        }
    }

    /// Every depth of the schedule, m.
    #[must_use]
    pub(crate) fn depths(&self) -> Vec<f64> {
        match self {
            Self::OverTime(entries) => entries.iter().map(|entry| entry.1).collect(),
            Self::OverDistance(entries) => entries.iter().map(|entry| entry.1).collect(),
        }
    }
}

/// The depth of the last entry that has begun.
fn begun<T: PartialOrd>(entries: &[(T, f64)], now: T) -> Option<f64> {
    let begun = entries.partition_point(|(from, _)| *from <= now);
    begun.checked_sub(1).map(|last| entries[last].1)
}

fn check(
    what: &'static str,
    unit: &'static str,
    beginnings: &[f64],
    depths: &[f64],
) -> Result<(), ScheduleError> {
    if beginnings.len() != depths.len() {
        return Err(ScheduleError::Lengths {
            what,
            beginnings: beginnings.len(),
            depths: depths.len(),
        });
    }
    if let Some(number) = beginnings.iter().chain(depths).find(|n| !n.is_finite()) {
        return Err(ScheduleError::NotFinite(*number));
    }
    if let Some(&beginning) = beginnings.iter().find(|begin| **begin < 0.0) {
        return Err(ScheduleError::Negative {
            what,
            beginning,
            unit,
        });
    }
    match beginnings.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(&[before, after]) => Err(ScheduleError::Order {
            what,
            unit,
            before,
            after,
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_depth_holds_from_its_time_to_the_next() {
        let schedule = Schedule::over_time(&[1.0, 3.0], &[0.5, 0.9]).unwrap();
        for (elapsed, depth) in [
            (0, None),
            (999_999_999, None),
            (1_000_000_000, Some(0.5)),
            (2_999_999_999, Some(0.5)),
            (3_000_000_000, Some(0.9)),
            (i64::MAX, Some(0.9)),
        ] {
            assert_eq!(schedule.depth(elapsed, 0.0), depth);
        }
    }

    #[test]
    fn over_distance_each_depth_holds_from_its_way_mark_to_the_next() {
        let schedule = Schedule::over_distance(&[0.0, 2.5], &[0.5, 0.9]).unwrap();
        for (distance, depth) in [
            (-0.1, None),
            (0.0, Some(0.5)),
            (2.4, Some(0.5)),
            (2.5, Some(0.9)),
        ] {
            assert_eq!(schedule.depth(i64::MAX, distance), depth);
        }
        assert_eq!(schedule.depths(), [0.5, 0.9]);
        assert!(Schedule::over_distance(&[2.0, 1.0], &[0.5, 0.9]).is_err());
    }

    #[test]
    fn an_empty_schedule_says_nothing() {
        assert_eq!(Schedule::default().depth(i64::MAX, 1e9), None);
    }

    #[test]
    fn a_schedule_that_makes_no_sense_is_refused_with_the_reason() {
        for (times, depths, reason) in [
            (vec![0.0, 1.0], vec![0.5], "2 times but 1 depths"),
            (
                vec![2.0, 1.0],
                vec![0.5, 0.9],
                "must be larger than the previous one",
            ),
            (
                vec![1.0, 1.0],
                vec![0.5, 0.9],
                "must be larger than the previous one",
            ),
            (
                vec![1.0, 1.0 + 1e-12],
                vec![0.5, 0.9],
                "must differ by at least a nanosecond",
            ),
            (vec![-1.0], vec![0.5], "negative"),
            (vec![f64::NAN], vec![0.5], "not finite"),
            (vec![1.0], vec![f64::INFINITY], "not finite"),
        ] {
            let refusal = Schedule::over_time(&times, &depths)
                .unwrap_err()
                .to_string();
            assert!(refusal.contains(reason), "{refusal}");
        }
    }
}
