//! Stamps and durations as whole nanoseconds.

use crate::builtin_interfaces::msg::{Duration, Time};

const NANOS_PER_SECOND: i64 = 1_000_000_000;

/// Seconds, rounded down, and the remaining nanoseconds; clamped to the range of `sec`.
fn split(nanos: i64) -> (i32, u32) {
    let sec = nanos.div_euclid(NANOS_PER_SECOND);
    let nanosec = nanos.rem_euclid(NANOS_PER_SECOND);
    match i32::try_from(sec) {
        // The remainder is in [0, 1e9), which u32 holds.
        Ok(sec) => (sec, nanosec as u32),
        Err(_) if sec < 0 => (i32::MIN, 0),
        Err(_) => (i32::MAX, NANOS_PER_SECOND as u32 - 1),
    }
}

fn join(sec: i32, nanosec: u32) -> i64 {
    i64::from(sec) * NANOS_PER_SECOND + i64::from(nanosec)
}

impl Time {
    /// The time `nanos` nanoseconds after the epoch, clamped to the range of `sec`.
    #[must_use]
    pub fn from_nanos(nanos: i64) -> Self {
        let (sec, nanosec) = split(nanos);
        Self { sec, nanosec }
    }

    /// Nanoseconds since the epoch.
    #[must_use]
    pub fn nanos(&self) -> i64 {
        join(self.sec, self.nanosec)
    }
}

impl Duration {
    /// The duration of `nanos` nanoseconds, clamped to the range of `sec`.
    #[must_use]
    pub fn from_nanos(nanos: i64) -> Self {
        let (sec, nanosec) = split(nanos);
        Self { sec, nanosec }
    }

    /// The duration in nanoseconds.
    #[must_use]
    pub fn nanos(&self) -> i64 {
        join(self.sec, self.nanosec)
    }
}
