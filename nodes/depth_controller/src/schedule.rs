//! Depth setpoints over time.
//!
//! A schedule is a list of times since the run began, increasing, and the depth that
//! holds from each on. Before its first time it says nothing, and the standing setpoint
//! holds.

use crate::manoeuvre::nanoseconds;

/// Depths that follow each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schedule {
    /// (nanoseconds since the run began, depth in m)
    entries: Vec<(i64, f64)>,
}

impl Schedule {
    /// The schedule that asks for `depths` (m, down) from `times` (s since the run began) on.
    ///
    /// # Errors
    /// A sentence, when the lists differ in length, a number is not finite, a time is
    /// negative, or the times do not increase.
    pub fn new(times: &[f64], depths: &[f64]) -> Result<Self, String> {
        if times.len() != depths.len() {
            return Err(format!(
                "schedule refused: {} times but {} depths",
                times.len(),
                depths.len()
            ));
        }
        if let Some(number) = times.iter().chain(depths).find(|n| !n.is_finite()) {
            return Err(format!("schedule refused: {number} is not finite"));
        }
        if let Some(time) = times.iter().find(|t| **t < 0.0) {
            return Err(format!("schedule refused: the time {time} s is negative"));
        }
        let entries: Vec<(i64, f64)> = times
            .iter()
            .map(|time| nanoseconds(*time))
            .zip(depths.iter().copied())
            .collect();
        if let Some(pair) = entries.windows(2).find(|pair| pair[0].0 >= pair[1].0) {
            return Err(format!(
                "schedule refused: its times must increase, {} s is followed by {} s",
                pair[0].0 as f64 / 1e9,
                pair[1].0 as f64 / 1e9
            ));
        }
        Ok(Self { entries })
    }

    /// The depth in force, m, `elapsed` nanoseconds after the run began; `None` before
    /// the first time.
    #[must_use]
    pub fn depth(&self, elapsed: i64) -> Option<f64> {
        let begun = self.entries.partition_point(|(time, _)| *time <= elapsed);
        begun.checked_sub(1).map(|last| self.entries[last].1)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn each_depth_holds_from_its_time_to_the_next() {
        let schedule = Schedule::new(&[1.0, 3.0], &[0.5, 0.9]).unwrap();
        for (elapsed, depth) in [
            (0, None),
            (999_999_999, None),
            (1_000_000_000, Some(0.5)),
            (2_999_999_999, Some(0.5)),
            (3_000_000_000, Some(0.9)),
            (i64::MAX, Some(0.9)),
        ] {
            assert_eq!(schedule.depth(elapsed), depth);
        }
    }

    #[test]
    fn an_empty_schedule_says_nothing() {
        assert_eq!(Schedule::default().depth(i64::MAX), None);
    }

    #[test]
    fn a_schedule_that_makes_no_sense_is_refused_with_the_reason() {
        for (times, depths, reason) in [
            (vec![0.0, 1.0], vec![0.5], "2 times but 1 depths"),
            (vec![2.0, 1.0], vec![0.5, 0.9], "must increase"),
            (vec![1.0, 1.0], vec![0.5, 0.9], "must increase"),
            (vec![-1.0], vec![0.5], "negative"),
            (vec![f64::NAN], vec![0.5], "not finite"),
            (vec![1.0], vec![f64::INFINITY], "not finite"),
        ] {
            let refusal = Schedule::new(&times, &depths).unwrap_err();
            assert!(refusal.contains(reason), "{refusal}");
        }
    }
}
