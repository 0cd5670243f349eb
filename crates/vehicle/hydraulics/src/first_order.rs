//! A first-order actuator with a rate limit: a model of an analog servo, for comparison with the digital actuator.
//!
//! ```text
//! delta' = omega (delta_c - delta), held within -rate and +rate
//! ```
//!
//! The equation is solved in closed form between two changes of the command, so the result does not depend on the sampling. While |delta_c - delta| >
//! rate/omega the angle moves at the rate limit, then it approaches exponentially.

/// The law: the parameters `first_order.*`.
#[derive(Clone, Copy, Debug, PartialEq, planesman_parameters::Parameters)]
pub struct Lag {
    /// Bandwidth of the first-order model; its lag equals that of one volume of the actuator auv, T_v + T_f/2 +
    /// T/2 = 14.75 ms.
    #[parameter(default = 67.8, unit = "rad/s", range = 0.01..=1000.0)]
    pub omega: f64,
    /// Rate limit of the first-order model; slew rate of the actuator auv, 40 degrees per second.
    #[parameter(default = 0.698_131_700_797_731_8, unit = "rad/s", range = 1e-4..=100.0)]
    pub rate: f64,
}

/// The actuator; times in ns after the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FirstOrder {
    lag: Lag,
    target: f64,
    /// Angle, rad, at `since`, the time of the last change of law or target.
    from: f64,
    since: i64,
    /// Time up to which the actuator has been advanced.
    until: i64,
}

impl FirstOrder {
    /// Returns an actuator at rest with neutral planes.
    #[must_use]
    pub(crate) fn new(lag: Lag) -> Self {
        Self {
            lag,
            target: 0.0,
            from: 0.0,
            since: 0,
            until: 0,
        }
    }

    /// Runs to the instant `nanos` towards `target`, rad. An earlier instant has no effect.
    pub(crate) fn advance_to(&mut self, nanos: i64, target: f64, lag: Lag) {
        if nanos <= self.until {
            return;
        }
        if (target, lag) != (self.target, self.lag) {
            (self.from, _) = self.at(self.until);
            self.since = self.until;
            (self.target, self.lag) = (target, lag);
        }
        self.until = nanos;
    }

    /// Plane angle and its rate, rad and rad/s, at the instant `nanos`.
    #[must_use]
    pub(crate) fn at(&self, nanos: i64) -> (f64, f64) {
        let Lag { omega, rate } = self.lag;
        let t = (nanos - self.since).max(0) as f64 * 1e-9;
        let error = self.target - self.from;
        let even = ((error.abs() - rate / omega) / rate).max(0.0);
        if t < even {
            let rate = rate.copysign(error);
            return (self.from + rate * t, rate);
        }
        let left = error.abs().min(rate / omega).copysign(error) * libm::exp(-omega * (t - even));
        (self.target - left, omega * left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAG: Lag = Lag {
        omega: 20.0,
        rate: 0.7,
    };
    const MS: i64 = 1_000_000;

    #[test]
    fn a_small_step_is_a_first_order_lag_and_a_large_one_slews_first() {
        let mut small = FirstOrder::new(LAG);
        small.advance_to(50 * MS, 0.03, LAG);
        let (angle, rate) = small.at(50 * MS);
        assert!((angle - 0.03 * (1.0 - libm::exp(-1.0_f64))).abs() < 1e-15);
        assert!((rate - 20.0 * (0.03 - angle)).abs() < 1e-12);
        let mut large = FirstOrder::new(LAG);
        large.advance_to(500 * MS, -0.5, LAG);
        assert_eq!(large.at(500 * MS), (-0.35, -0.7));
        large.advance_to(3_000 * MS, -0.5, LAG);
        assert!((large.at(3_000 * MS).0 + 0.5).abs() < 1e-9);
    }

    #[test]
    fn the_angle_is_smooth_where_slewing_ends() {
        let mut servo = FirstOrder::new(LAG);
        servo.advance_to(3_000 * MS, 0.5, LAG);
        let mut before = servo.at(0);
        for ms in 1..3_000 {
            let now = servo.at(ms * MS);
            assert!(now.1 <= LAG.rate && now.1 <= before.1 + 1e-12);
            let mean = 0.5 * (now.1 + before.1);
            assert!((now.0 - before.0 - mean * 1e-3).abs() < 2e-6);
            before = now;
        }
    }

    #[test]
    fn it_is_the_same_however_often_it_is_looked_at() {
        let (mut often, mut seldom) = (FirstOrder::new(LAG), FirstOrder::new(LAG));
        for k in 0..40 {
            let target = 0.4 * libm::sin(k as f64);
            for part in 1..=5 {
                often.advance_to((k * 5 + part) * 10 * MS, target, LAG);
            }
            seldom.advance_to((k + 1) * 50 * MS, target, LAG);
            assert_eq!(often.at((k + 1) * 50 * MS), seldom.at((k + 1) * 50 * MS));
        }
    }
}
