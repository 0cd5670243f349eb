//! Detects the limit cycle of a quantized actuator from its decisions.
//!
//! In every limit cycle of such an actuator the sign valve alternates. A cycle is the time from one change to "+" to the next. The amplitude is half
//! of the planes' range in this time, sampled at the beginning of the valve cycles. The last complete cycle is reported until the present one has
//! lasted twice as long; then the limit cycle has ended.

/// Frequency and amplitude of a limit cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// Hz.
    pub frequency: f64,
    /// Half of peak to peak, rad.
    pub amplitude: f64,
}

/// The watch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LimitCycle {
    sign: i8,
    /// Valve cycle of the last change to "+".
    turned: Option<u64>,
    /// Range of the planes since then, rad.
    low: f64,
    high: f64,
    /// Last complete cycle: its valve cycles, and its amplitude.
    last: Option<(u64, f64)>,
}

impl LimitCycle {
    /// Returns a detector without data, the sign pulse positive.
    #[must_use]
    pub(crate) fn new() -> Self {
        Self {
            sign: 1,
            turned: None,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            last: None,
        }
    }

    /// Adds the sign pulse of valve cycle `cycle`, and the plane angle, rad, at its begin.
    pub(crate) fn observe(&mut self, cycle: u64, sign: i8, angle: f64) {
        self.low = self.low.min(angle);
        self.high = self.high.max(angle);
        if sign > self.sign {
            self.last = self
                .turned
                .map(|turned| (cycle - turned, 0.5 * (self.high - self.low)));
            self.turned = Some(cycle);
            (self.low, self.high) = (angle, angle);
        }
        self.sign = sign;
    }

    /// The limit cycle at valve cycle `cycle`, with cycles of `period` s; `None` if there is no limit cycle.
    #[must_use]
    pub(crate) fn oscillation(&self, cycle: u64, period: f64) -> Option<Oscillation> {
        let (length, amplitude) = self.last?;
        let age = cycle.saturating_sub(self.turned?);
        (age <= 2 * length).then(|| Oscillation {
            frequency: 1.0 / (length as f64 * period),
            amplitude,
        })
    }
}

impl Default for LimitCycle {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_turns_make_a_cycle_and_silence_ends_it() {
        let mut watch = LimitCycle::new();
        let signs = [1, -1, -1, 1, 1, 1, -1, 1];
        let mut seen = Vec::new();
        for (cycle, sign) in signs.into_iter().enumerate() {
            watch.observe(cycle as u64, sign, cycle as f64);
            seen.push(watch.oscillation(cycle as u64, 0.5));
        }
        assert!(seen[..7].iter().all(Option::is_none));
        // From the turn at 3 to the one at 7.
        let cycle = Oscillation {
            frequency: 0.5,
            amplitude: 2.0,
        };
        assert_eq!(seen[7], Some(cycle));
        assert_eq!(watch.oscillation(7 + 8, 0.5), Some(cycle));
        assert_eq!(watch.oscillation(7 + 9, 0.5), None);
    }
}
