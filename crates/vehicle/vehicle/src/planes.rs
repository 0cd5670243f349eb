//! Plane angle over a tick: evenly spaced samples with linear interpolation.

/// Largest number of samples in one tick: one every 50 us of the usual 0.05 s.
const MOST_SAMPLES: usize = 1000;

/// Largest allowed plane angle \[rad\]: a right angle. Actuators have smaller limits.
const LARGEST_ANGLE: f64 = std::f64::consts::FRAC_PI_2;

/// Reason why a plane motion is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotionError {
    /// The number of samples is not allowed; two samples are needed to span a tick.
    #[error("plane motion of {found} samples refused: 2 to {MOST_SAMPLES} samples are allowed")]
    Samples {
        /// Their number.
        found: usize,
    },
    /// The samples do not span the tick.
    #[error("plane motion over {found} ns refused: the tick is {tick} ns")]
    Duration {
        /// Duration of the motion \[ns\].
        found: i64,
        /// Length of the tick \[ns\].
        tick: i64,
    },
    /// The angle exceeds its limit.
    #[error("plane angle {value} rad (sample {index}) refused: it must lie in [-pi/2, pi/2]")]
    Angle {
        /// Index of the sample, from 0.
        index: usize,
        /// Its value.
        value: f64,
    },
}

/// Plane angle `delta(t)` \[rad\], positive to dive, from the start of a tick.
#[derive(Clone, Copy, Debug)]
pub struct PlanePath<'a> {
    samples: &'a [f64],
    /// Samples per second.
    rate: f64,
}

impl<'a> PlanePath<'a> {
    /// Path through `samples`; the first is at the start of the tick, the last at its end. Both durations are in nanoseconds and must be
    /// equal.
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

    /// Planes held at neutral.
    pub const NEUTRAL: PlanePath<'static> = PlanePath {
        samples: &[0.0],
        rate: 0.0,
    };

    /// A constant angle.
    #[must_use]
    pub fn held(angle: &'a f64) -> Self {
        Self {
            samples: std::slice::from_ref(angle),
            rate: 0.0,
        }
    }

    /// Largest magnitude of the angle \[rad\].
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.samples.iter().fold(0.0, |most, it| it.abs().max(most))
    }

    /// Angle \[rad\] at `t` \[s\] from the start of the tick; constant before the start and after the end.
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

    /// Angles \[rad\] over a step from `start` \[s\] with length `h` \[s\], at shares of the step.
    ///
    /// On a straight part of the path they are its own angles. Across corners, these values come from the cubic with the same moments over the step:
    /// the integrals of `delta t^n` with `n` up to 3. An angle enters the accelerations linearly, so these moments determine the state at the step's
    /// end, except for the product of four of the vehicle's rates. The step therefore need not end at a corner. For a step of zero length they are
    /// the angle at its start.
    pub(crate) fn over<const N: usize>(&self, start: f64, h: f64, shares: &[f64; N]) -> [f64; N] {
        let first = self.at(start);
        let last = self.samples.len() - 1;
        if last == 0 || h == 0.0 {
            return [first; N];
        }
        let rise = |i: usize| {
            if i < last {
                self.samples[i + 1] - self.samples[i]
            } else {
                0.0
            }
        };
        let (begin, length) = (start * self.rate, h * self.rate);
        let before = (begin as usize).min(last);
        let slope = rise(before) * length;
        let mut angles = shares.map(|share| first + share * slope);
        // By corners: what (s - a)+ is in Legendre polynomials over s in [-1, 1].
        let mut legendre = [0.0; 4];
        let mut rise_before = rise(before);
        for i in before + 1..=last {
            let rise_after = rise(i);
            let corner = rise_after - rise_before;
            rise_before = rise_after;
            if corner == 0.0 {
                continue;
            }
            let a = 2.0 * (i as f64 - begin) / length - 1.0;
            if a >= 1.0 {
                break;
            }
            let to_the_end = (1.0 - a) * (1.0 - a);
            let both_ends = to_the_end * (1.0 + a) * (1.0 + a);
            legendre[0] += corner * 4.0 * to_the_end;
            legendre[1] += corner * 4.0 * to_the_end * (2.0 + a);
            legendre[2] += corner * 5.0 * both_ends;
            legendre[3] += corner * 7.0 * both_ends * a;
        }
        if legendre == [0.0; 4] {
            return angles;
        }
        let [c0, c1, c2, c3] = legendre.map(|c| c * length / 32.0);
        for (angle, share) in angles.iter_mut().zip(shares) {
            let s = 2.0 * share - 1.0;
            let (p2, p3) = (1.5 * s * s - 0.5, (2.5 * s * s - 1.5) * s);
            *angle += c0 + c1 * s + c2 * p2 + c3 * p3;
        }
        angles
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
    fn over_a_step_the_path_is_itself_where_it_is_straight_and_has_its_moments_across_corners() {
        let samples = [0.0, 0.1, -0.1, -0.1, 0.3, 0.2];
        let path = PlanePath::new(&samples, TICK, TICK).expect("taken");
        // Nine points of Newton and Cotes, exact up to the ninth power.
        let shares: [f64; 9] = std::array::from_fn(|i| i as f64 / 8.0);
        let weights = [
            989.0, 5888.0, -928.0, 10496.0, -4540.0, 10496.0, -928.0, 5888.0, 989.0,
        ];
        for angle in path.over(0.022, 0.006, &shares) {
            assert!((angle + 0.1).abs() < 1e-15);
        }
        assert_eq!(path.over(0.05, 0.01, &shares), [0.2; 9]);
        assert_eq!(path.over(0.01, 0.0, &shares), [0.1; 9]);
        assert_eq!(PlanePath::held(&0.2).over(0.01, 0.04, &shares), [0.2; 9]);
        for (start, h) in [(0.0, 0.05), (0.01, 0.02), (0.013, 0.031), (0.04, 0.03)] {
            let angles = path.over(start, h, &shares);
            for power in 0..4 {
                let found: f64 = (0..9)
                    .map(|i| angles[i] * shares[i].powi(power) * weights[i] / 28350.0)
                    .sum();
                // Narrow trapezes.
                let parts = 100_000;
                let at = |k: i32| {
                    let share = f64::from(k) / f64::from(parts);
                    path.at(start + share * h) * share.powi(power)
                };
                let sum: f64 = (0..parts).map(|k| 0.5 * (at(k) + at(k + 1))).sum();
                let exact = sum / f64::from(parts);
                assert!(
                    (found - exact).abs() < 1e-10,
                    "{start} {h} {power}: {found} is not {exact}"
                );
            }
        }
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
            "plane motion over 1 ns refused: the tick is 50000000 ns"
        );
    }
}
