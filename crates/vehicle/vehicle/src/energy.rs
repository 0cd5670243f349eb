//! Upper bound of a vehicle's kinetic energy in heave and pitch in still water.
//!
//! ```text
//! T  = (m - Z_wdot) w^2 / 2 - Z_qdot w q + (I_y - M_qdot) q^2 / 2         (with M_wdot = Z_qdot)
//! T' = Z_w w^2 + (Z_q + m U + M_w) w q + M_q q^2
//!      + Z_ww |w|^3 + Z_qq w q|q| + M_ww w|w| q + M_qq |q|^3 + Z w + M q
//! ```
//!
//! Along a direction `w = r cos, q = r sin` the bound is `T' <= (F + A r + B r^2) r`. The cross terms, and force `Z` and moment `M` of
//! planes, weight and waves, have the most unfavourable signs. With drag, `B < 0`, the energy decreases beyond the positive root. The
//! largest energy at such a root, over all directions, cannot be exceeded from below.

use crate::{dynamics::State, vehicle::Derivatives};

/// Number of directions of (w, q) within a right angle.
const DIRECTIONS: u32 = 256;

impl Derivatives {
    /// `T` \[J\].
    #[must_use]
    pub fn kinetic_energy(
        &self,
        State {
            heave: w,
            pitch_rate: q,
            ..
        }: &State,
    ) -> f64 {
        0.5 * (self.heave_inertia * w * w + self.pitch_inertia * q * q)
            - 0.5 * (self.z_q_dot + self.m_w_dot) * w * q
    }

    /// Kinetic energy \[J\] above which the energy always decreases, for a force \[N\] and moment \[N m\] of at most these sizes; infinite if the
    /// model has no such bound.
    #[must_use]
    pub fn most_kinetic_energy(&self, force: f64, moment: f64) -> f64 {
        if self.z_q_dot != self.m_w_dot {
            return f64::INFINITY;
        }
        let cross = (self.z_q_plus_m_u + self.m_w).abs();
        let most = |i: u32| {
            let angle = std::f64::consts::FRAC_PI_2 * f64::from(i) / f64::from(DIRECTIONS);
            let (q, w) = libm::sincos(angle);
            let f = force * w + moment * q;
            let a = self.z_w * w * w + cross * w * q + self.m_q * q * q;
            let b = self.z_ww * w * w * w
                + self.z_qq.abs() * w * q * q
                + self.m_ww.abs() * w * w * q
                + self.m_qq * q * q * q;
            // The positive root of f + a r + b r^2; where a < 0 in the form without cancellation.
            let root = (a * a - 4.0 * b * f).sqrt();
            let r = match () {
                () if b > 0.0 => f64::INFINITY,
                () if a > 0.0 => (a + root) / (-2.0 * b),
                () if f > 0.0 => 2.0 * f / (root - a),
                () => 0.0,
            };
            let energy = |heave| {
                self.kinetic_energy(&State {
                    heave,
                    pitch_rate: q,
                    ..State::default()
                })
            };
            // Heave and pitch of the same sign, and of opposite signs.
            r * r * energy(w).max(energy(-w))
        };
        (0..=DIRECTIONS).map(most).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Angle, PitchDamping, Restoring, Variant, vehicle_file};

    fn with_drag(vehicle: &crate::Vehicle, speed: f64) -> Derivatives {
        let damping = PitchDamping::Quadratic { viscous: 0.5685 };
        let variant = Variant {
            damping,
            restoring_moment: false,
            ..Variant::default()
        };
        let d = variant.apply(vehicle.derivatives(speed));
        Derivatives {
            excess_weight: 0.0,
            ..d
        }
    }

    /// The power of all loads \[W\], of Newton's equations as `dynamics` has them: `T'` = (w', q') times inertia times (w, q).
    fn power(d: &Derivatives, w: f64, q: f64, force: f64, moment: f64) -> f64 {
        let load = d.hull_force(w, q, Angle::new(0.0), Restoring::Sine);
        // What turns the velocity does no work: m U q of the centripetal term does, since U is held.
        (load.heave + force) * w + (load.pitch + moment) * q
    }

    #[test]
    fn beyond_the_bound_the_energy_falls_in_every_direction_and_at_it_not_yet() {
        for (vehicle, speeds) in [
            (vehicle_file::brunner(), [0.3, 1.5, 5.0]),
            (vehicle_file::remus_100(), [0.5, 1.5, 3.0]),
        ] {
            for speed in speeds {
                let d = with_drag(&vehicle, speed);
                for (force, moment) in [(0.0, 0.0), (0.3, 0.2), (20.0, 40.0)] {
                    let bound = d.most_kinetic_energy(force, moment);
                    if !bound.is_finite() {
                        continue;
                    }
                    let mut last = 0.0_f64;
                    for i in 0..3600 {
                        let angle = f64::from(i) * std::f64::consts::TAU / 3600.0;
                        let (q, w) = libm::sincos(angle);
                        let unit = d.kinetic_energy(&State {
                            heave: w,
                            pitch_rate: q,
                            ..State::default()
                        });
                        let signs = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
                        let gains = |energy: f64| {
                            let r = (energy / unit).sqrt();
                            signs
                                .iter()
                                .any(|(f, m)| power(&d, r * w, r * q, f * force, m * moment) > 0.0)
                        };
                        for share in [1.01, 2.0, 10.0, 1e4] {
                            assert!(
                                !gains(share * bound + 1e-9),
                                "{} {speed} {force}: {angle}",
                                vehicle.name
                            );
                        }
                        last = last.max(f64::from(u8::from(gains(0.98 * bound))));
                    }
                    // Brunner's cross terms are all there is: the bound is the least one.
                    if vehicle.name.starts_with("brunner") && moment > 0.0 {
                        assert_eq!(last, 1.0, "{speed} {force}");
                    }
                }
            }
        }
    }

    #[test]
    fn without_drag_there_is_no_bound_once_lift_feeds_the_motion() {
        let d = vehicle_file::brunner().derivatives(1.5);
        let free = Derivatives {
            m_q: 0.0,
            m_qq: 0.0,
            ..d
        };
        assert_eq!(free.most_kinetic_energy(0.1, 0.1), f64::INFINITY);
    }
}
