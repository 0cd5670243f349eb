//! The actuator's own clock: valve cycles at f_c, counted exactly.
//!
//! The digital hydraulic actuator runs free of the control computer's sampling (Section II.B);
//! a tick need not be a whole number of cycles. Cycle n begins n/f_c after the start. With f_c
//! in whole millihertz that is a rational number of nanoseconds, compared in whole numbers, so
//! that the phase never drifts and the same instant always falls in the same cycle.

/// Counts valve cycles against a clock in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CycleClock {
    millihertz: u32,
    cycle: u64,
}

/// Nanoseconds in 1000 s, the period of a millihertz.
const NANOS_PER_MILLIHERTZ: i128 = 1_000_000_000_000;

impl CycleClock {
    /// A clock at the start of cycle 0.
    #[must_use]
    pub(crate) fn new(millihertz: u32) -> Self {
        Self {
            millihertz,
            cycle: 0,
        }
    }

    /// T, s.
    #[must_use]
    pub(crate) fn period(&self) -> f64 {
        1000.0 / f64::from(self.millihertz)
    }

    /// The number of the present cycle.
    #[must_use]
    pub(crate) fn cycle(&self) -> u64 {
        self.cycle
    }

    /// Moves on to the next cycle.
    pub(crate) fn next(&mut self) {
        self.cycle += 1;
    }

    /// Whether the present cycle ends before the instant `nanos` after the start; a cycle that
    /// ends exactly there has not ended before it.
    #[must_use]
    #[inline]
    pub(crate) fn ends_before(&self, nanos: i64) -> bool {
        self.past_its_begin(nanos) > NANOS_PER_MILLIHERTZ
    }

    /// Time from the present cycle's begin to the instant `nanos` after the start, s, within
    /// [0, T].
    #[must_use]
    #[inline]
    pub(crate) fn time_in_cycle(&self, nanos: i64) -> f64 {
        let past = self.past_its_begin(nanos);
        if past >= NANOS_PER_MILLIHERTZ {
            self.period()
        } else {
            // Below 1e12: no need of a wide number.
            past.max(0) as i64 as f64 / (1e9 * f64::from(self.millihertz))
        }
    }

    /// From the cycle's begin to the instant, in nanoseconds times millihertz.
    #[inline]
    fn past_its_begin(&self, nanos: i64) -> i128 {
        i128::from(nanos) * i128::from(self.millihertz)
            - i128::from(self.cycle) * NANOS_PER_MILLIHERTZ
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_cycles_of_80_hz_fill_a_control_sample() {
        let mut clock = CycleClock::new(80_000);
        let mut cycles = 0;
        while clock.ends_before(50_000_000) {
            clock.next();
            cycles += 1;
        }
        assert_eq!(cycles, 3);
        assert_eq!(clock.time_in_cycle(50_000_000), clock.period());
        assert!(clock.ends_before(50_000_001));
    }

    #[test]
    fn after_a_year_of_cycles_at_82_5_hz_the_phase_is_exact() {
        let mut clock = CycleClock::new(82_500);
        // 165 cycles of 82.5 Hz are 2 s.
        let years = 365 * 86_400;
        clock.cycle = 165 * years / 2;
        let nanos = years as i64 * 1_000_000_000;
        assert_eq!(clock.time_in_cycle(nanos), 0.0);
        assert_eq!(clock.time_in_cycle(nanos + 6_000_000), 0.006);
        assert!(clock.ends_before(nanos + 12_121_213));
        assert!(!clock.ends_before(nanos + 12_121_212));
    }
}
