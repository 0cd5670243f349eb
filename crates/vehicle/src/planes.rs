//! The plane angle over a tick: evenly spaced samples, linear between them.

/// The most samples taken for one tick: one every 50 us of the usual 0.05 s.
const MOST_SAMPLES: usize = 1000;

/// The largest plane angle taken \[rad\]: a right angle. Actuators stop well before.
const LARGEST_ANGLE: f64 = std::f64::consts::FRAC_PI_2;

/// Why a plane motion was not taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// Fewer than two samples do not span a tick.
    #[error(
        "plane motion of {found} samples refused: at least 2 and at most {MOST_SAMPLES} are taken"
    )]
    Samples {
        /// Their number.
        found: usize,
    },
    /// The samples do not span the tick.
    #[error("plane motion over {found} ns refused: a tick is {tick} ns")]
    Duration {
        /// The motion's duration \[ns\].
        found: i64,
        /// The tick \[ns\].
        tick: i64,
    },
    /// An angle no plane has.
    #[error("plane angle {value} rad (sample {index}) refused: it must lie in [-pi/2, pi/2]")]
    Angle {
        /// Which sample, from 0.
        index: usize,
        /// Its value.
        value: f64,
    },
}

/// The plane angle `delta(t)` \[rad\], positive dive, from the start of a tick.
#[derive(Clone, Copy, Debug)]
pub struct PlanePath<'a> {
    samples: &'a [f64],
    /// Samples per second.
    rate: f64,
}

impl<'a> PlanePath<'a> {
    /// The path through `samples`, the first at the start of the tick and the last at its end.
    /// Both durations are in nanoseconds and are to be the same.
    ///
    /// # Errors
    /// [`MotionError`].
    pub fn new(samples: &'a [f64], duration: i64, tick: i64) -> Result<Self, MotionError> {
        let found = samples.len();
        if !(2..=MOST_SAMPLES).contains(&found) {
            return Err(MotionError::Samples { found });
        }
        if duration != tick {
            return Err(MotionError::Duration {
                found: duration,
                tick,
            });
        }
        // Written so that NaN is refused too.
        let refused = |value: &f64| !(-LARGEST_ANGLE..=LARGEST_ANGLE).contains(value);
        if let Some(index) = samples.iter().position(refused) {
            let value = samples[index];
            return Err(MotionError::Angle { index, value });
        }
        Ok(Self {
            samples,
            rate: (found - 1) as f64 / (tick as f64 * 1e-9),
        })
    }

    /// The planes held at neutral.
    pub const NEUTRAL: PlanePath<'static> = PlanePath {
        samples: &[0.0],
        rate: 0.0,
    };

    /// One angle, held.
    #[must_use]
    pub fn held(angle: &'a f64) -> Self {
        Self {
            samples: std::slice::from_ref(angle),
            rate: 0.0,
        }
    }

    /// The angle \[rad\] at `t` \[s\] from the start of the tick; before it the first, after its
    /// end the last.
    #[inline]
    #[must_use]
    pub fn at(&self, t: f64) -> f64 {
        let last = self.samples.len() - 1;
        let position = (t * self.rate).clamp(0.0, last as f64);
        let before = position as usize;
        if before == last {
            return self.samples[last];
        }
        let share = position - before as f64;
        self.samples[before] + share * (self.samples[before + 1] - self.samples[before])
    }

    /// The angle \[rad\] at the end of the tick.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.samples[self.samples.len() - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TICK: i64 = 50_000_000;

    #[test]
    fn between_samples_the_angle_is_linear() {
        let samples = [0.0, 0.1, -0.1];
        let path = PlanePath::new(&samples, TICK, TICK).expect("taken");
        for (t, angle) in [
            (-1.0, 0.0),
            (0.0, 0.0),
            (0.0125, 0.05),
            (0.025, 0.1),
            (0.0375, 0.0),
            (0.05, -0.1),
            (1.0, -0.1),
        ] {
            assert!((path.at(t) - angle).abs() < 1e-15, "at {t}");
        }
        assert_eq!(path.end(), -0.1);
    }

    #[test]
    fn a_held_angle_is_the_same_throughout() {
        let path = PlanePath::held(&0.2);
        assert_eq!((path.at(0.0), path.at(0.03), path.end()), (0.2, 0.2, 0.2));
    }

    #[test]
    fn a_motion_that_is_no_tick_s_is_refused() {
        assert_eq!(
            PlanePath::new(&[0.0], TICK, TICK).err(),
            Some(MotionError::Samples { found: 1 })
        );
        assert!(PlanePath::new(&[0.0; MOST_SAMPLES + 1], TICK, TICK).is_err());
        assert!(PlanePath::new(&[0.0, f64::NAN], TICK, TICK).is_err());
        assert!(PlanePath::new(&[2.0, 0.0], TICK, TICK).is_err());
        let refusal = PlanePath::new(&[0.0, 0.0], 1, TICK).expect_err("too short");
        assert_eq!(
            refusal.to_string(),
            "plane motion over 1 ns refused: a tick is 50000000 ns"
        );
    }
}
