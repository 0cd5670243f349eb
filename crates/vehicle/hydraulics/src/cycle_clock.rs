//! The actuator's own clock: valve cycles at f_c, counted exactly.
//!
//! The digital hydraulic actuator runs independently of the control computer's sampling (Section II.B); a tick need not be a whole number
//! of cycles. Cycle n begins n/f_c after the start. With f_c in whole millihertz this is a rational number of nanoseconds. Comparison in
//! whole numbers keeps the phase exact, and the same instant always falls in the same cycle. The beginning of a cycle is computed once with wide
//! integers; instants are compared with it in narrow integers.

/// Counts valve cycles against a clock in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CycleClock {
    millihertz: u32,
    cycle: u64,
    /// Begin of the cycle: whole nanoseconds, and the remainder in units of 1/`millihertz` ns.
    begin: i64,
    rest: i64,
}

/// Nanoseconds in 1000 s, the period of a millihertz.
const NANOS_PER_MILLIHERTZ: i64 = 1_000_000_000_000;

impl CycleClock {
    /// A clock at the start of cycle 0.
    #[must_use]
    pub(crate) fn new(millihertz: u32) -> Self {
        Self::in_cycle(0, millihertz)
    }

    /// A clock at the start of a cycle.
    fn in_cycle(cycle: u64, millihertz: u32) -> Self {
        let parts = i128::from(cycle) * i128::from(NANOS_PER_MILLIHERTZ);
        let per_nano = i128::from(millihertz);
        Self {
            millihertz,
            cycle,
            begin: i64::try_from(parts / per_nano).unwrap_or(i64::MAX),
            rest: (parts % per_nano) as i64,
        }
    }

    /// T, s.
    #[must_use]
    pub(crate) fn period(&self) -> f64 {
        1000.0 / f64::from(self.millihertz)
    }

    /// Number of the present cycle.
    #[must_use]
    pub(crate) fn cycle(&self) -> u64 {
        self.cycle
    }

    /// Moves on to the next cycle.
    pub(crate) fn next(&mut self) {
        *self = Self::in_cycle(self.cycle + 1, self.millihertz);
    }

    /// Whether the present cycle ends before the instant `nanos` after the start; a cycle that ends exactly at `nanos` does not.
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
            past.max(0) as f64 / (1e9 * f64::from(self.millihertz))
        }
    }

    /// Time from the cycle's begin to the instant, in nanoseconds times millihertz: exact if it is near.
    #[inline]
    fn past_its_begin(&self, nanos: i64) -> i64 {
        let whole = nanos.saturating_sub(self.begin);
        whole
            .saturating_mul(i64::from(self.millihertz))
            .saturating_sub(self.rest)
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
        // 165 cycles of 82.5 Hz are 2 s.
        let years = 365 * 86_400;
        let clock = CycleClock::in_cycle(165 * years / 2, 82_500);
        let nanos = years as i64 * 1_000_000_000;
        assert_eq!(clock.time_in_cycle(nanos), 0.0);
        assert_eq!(clock.time_in_cycle(nanos + 6_000_000), 0.006);
        assert!(clock.ends_before(nanos + 12_121_213));
        assert!(!clock.ends_before(nanos + 12_121_212));
    }
}
