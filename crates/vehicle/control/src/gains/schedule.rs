//! Gains for a speed and a model of the vehicle in pitch.
//!
//! ```text
//! sigma = sqrt(k / k_0), not below 1    how much faster the loops may be than at the reference speed
//!
//! Kpy = sigma^2 k'_0 / k                k'_0 = Kpy_0 k_0
//! Kr  = (sigma B'_0 - b) / k            B'_0 = b_0 + Kr_0 k_0; not below 0
//! Kpz = sigma Kpz_0 U_0 / U
//! Kdz = Kdz_0 U_0 / U
//! ```
//! Index 0 means the fixed gains at the reference speed, on the model there. In the loop's polynomial these give the reference's poles
//! times `sigma`. If the planes are stronger, as at a higher speed in water, the loop is faster with the same plane angles (`Kpy` and `Kpz`
//! unchanged, `Kr` and `Kdz` with `1 / U`). If the planes are weaker, larger angles keep the loop as fast. Below the lowest speed of the schedule
//! planes and pitch have too little effect to use higher gains.

use super::pitch_model::{PitchModel, SpeedLaw};

/// The speed, m/s, above which the gains no longer change: faster than any vehicle, and low enough that all powers of the speed are finite.
const HIGHEST_SPEED: f64 = 1e3;

/// The gains of the depth and pitch loops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopGains {
    /// `Kpz`, rad/m.
    pub depth_p: f64,
    /// `Kdz`, rad s/m.
    pub depth_d: f64,
    /// `Kpy`.
    pub pitch_p: f64,
    /// `Kr`, s.
    pub pitch_rate: f64,
}

impl LoopGains {
    /// Combines the four gains one by one with another four.
    #[must_use]
    pub fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            depth_p: f(self.depth_p, other.depth_p),
            depth_d: f(self.depth_d, other.depth_d),
            pitch_p: f(self.pitch_p, other.pitch_p),
            pitch_rate: f(self.pitch_rate, other.pitch_rate),
        }
    }
}

/// The fixed gains with their speed and vehicle model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// The gains at the reference speed.
    pub reference: LoopGains,
    /// The vehicle over speed.
    pub law: SpeedLaw,
    /// The speed below which the gains no longer change, m/s.
    pub lowest_speed: f64,
}

impl Schedule {
    /// The gains at a speed (m/s) on the schedule's own model.
    #[must_use]
    pub fn at(&self, speed: f64) -> LoopGains {
        let speed = self.scheduled(speed);
        self.on(&self.law.at(speed), speed)
    }

    /// The speed used for the gains, m/s, limited to a plausible range.
    #[must_use]
    pub fn scheduled(&self, speed: f64) -> f64 {
        speed.max(self.lowest_speed).min(HIGHEST_SPEED)
    }

    /// The gains at a speed (m/s) for a vehicle with this model.
    #[must_use]
    pub fn on(&self, model: &PitchModel, speed: f64) -> LoopGains {
        let there = self.law.model;
        let slower = self.law.reference_speed / self.scheduled(speed);
        let damping = there.damping + self.reference.pitch_rate * there.plane;
        let stronger = model.plane / there.plane;
        let sigma = stronger.sqrt().max(1.0);
        LoopGains {
            depth_p: self.reference.depth_p * sigma * slower,
            depth_d: self.reference.depth_d * slower,
            pitch_p: self.reference.pitch_p * sigma * sigma / stronger,
            pitch_rate: ((sigma * damping - model.damping) / model.plane).max(0.0),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::design::dive_loop::{DiveLoop, DivePlant, Memory, Path};

    /// Program T6 in feet, a plane moment that grows with speed as water makes it.
    pub(crate) const T6: Schedule = Schedule {
        reference: LoopGains {
            depth_p: 0.25,
            depth_d: 0.6,
            pitch_p: 0.7,
            pitch_rate: 2.0,
        },
        law: SpeedLaw {
            model: PitchModel {
                plane: 0.14 / 0.6,
                damping: 0.06 / 0.6,
                restoring: 0.0,
            },
            reference_speed: 1.0,
            plane_exponent: 2.0,
            damping_exponent: 1.0,
        },
        lowest_speed: 0.1,
    };

    fn design(model: &PitchModel, gains: &LoopGains, speed: f64) -> DiveLoop {
        DiveLoop {
            plant: DivePlant::of_pitch(model, speed).expect("finite"),
            gains: *gains,
            memory: Memory::default(),
            path: Path::default(),
        }
    }

    fn is_stable(design: &DiveLoop) -> bool {
        design.margins().expect("finite").is_stable()
    }

    #[test]
    fn at_the_reference_speed_the_scheduled_gains_are_the_fixed_ones() {
        let gains = T6.at(1.0);
        let off = gains.zip(T6.reference, |a, b| (a - b).abs());
        assert!(off.depth_p + off.depth_d + off.pitch_p + off.pitch_rate < 1e-15);
    }

    #[test]
    fn below_the_reference_speed_the_poles_stay_and_above_it_they_grow_with_the_speed() {
        let at = |speed: f64| {
            let dive = design(&T6.law.at(speed), &T6.at(speed), speed);
            dive.closed_loop().expect("finite").den
        };
        for (speed, faster) in [(0.5, 1.0), (2.0, 2.0), (3.0, 3.0)] {
            for (power, (there, here)) in at(1.0).iter().zip(at(speed)).enumerate() {
                let expected = there * f64::powi(faster, power as i32);
                assert!((expected - here).abs() < 1e-12 * expected.abs(), "{speed}");
            }
        }
    }

    #[test]
    fn in_water_a_faster_vehicle_needs_no_larger_plane_angles() {
        let gains = T6.at(3.0);
        assert!((gains.pitch_p / T6.reference.pitch_p - 1.0).abs() < 1e-12);
        assert!((gains.depth_p / T6.reference.depth_p - 1.0).abs() < 1e-12);
        assert!((gains.pitch_rate / T6.reference.pitch_rate - 1.0 / 3.0).abs() < 1e-12);
        assert!((gains.depth_d / T6.reference.depth_d - 1.0 / 3.0).abs() < 1e-12);
    }

    /// The report's thesis (p. 20): its own plant, whose plane moment does not know the speed.
    #[test]
    fn at_three_feet_per_second_without_derivative_only_the_schedule_is_stable() {
        let mut schedule = T6;
        schedule.reference.depth_d = 0.0;
        (schedule.law.plane_exponent, schedule.law.damping_exponent) = (0.0, 0.0);
        let model = schedule.law.at(3.0);
        assert!(is_stable(&design(&model, &schedule.reference, 1.0)));
        assert!(!is_stable(&design(&model, &schedule.reference, 3.0)));
        assert!(is_stable(&design(&model, &schedule.at(3.0), 3.0)));
    }

    #[test]
    fn a_vehicle_that_is_damped_enough_by_itself_gets_no_negative_rate_gain() {
        let damped = PitchModel {
            damping: 9.0,
            ..T6.law.model
        };
        assert_eq!(T6.on(&damped, 1.0).pitch_rate, 0.0);
    }

    #[test]
    fn at_rest_and_at_any_speed_the_gains_stay_finite() {
        assert_eq!(T6.at(0.0), T6.at(0.1));
        assert!(T6.at(0.0).pitch_p.is_finite());
        assert!(T6.at(f64::MAX).pitch_p.is_finite());
    }
}
