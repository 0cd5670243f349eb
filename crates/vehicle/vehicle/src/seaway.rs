//! Waves: a heave force and a pitch moment with a narrow-band spectrum.
//!
//! White noise `n` passes through a lightly damped oscillator, the shaping filter
//!
//! ```text
//! x'' + 2 zeta omega x' + omega^2 x = n        F = sigma_F x' / omega        M = sigma_M x
//! ```
//!
//! where `x` has the standard deviation 1. The spectrum peaks at `omega = 2 pi / T`; a smaller `zeta` makes the peak narrower. `x'/omega` also has
//! the standard deviation 1, and a phase of a quarter wave relative to `x`. Heave force and pitch moment on a slender hull have this phase: one is
//! largest on the slope of the wave, the other between slopes. Waves decay with depth as `exp(-k z)` with `k = omega^2 / g` (deep water).
//!
//! The filter advances by ticks, exactly: its state after a tick is normal with the mean `Phi x` and the covariance `P - Phi P Phi^T`,
//! where `P` is the stationary covariance. So the standard deviations do not depend on the tick. Force and moment are constant during a
//! tick. The random numbers depend only on the seed and the number of ticks.

use planesman_linear::{DMatrix, Error, StateSpace};
use rand_pcg::{Pcg64, rand_core::SeedableRng};

use crate::dynamics::GeneralisedForce;
use crate::standard_normal;

/// Parameters of the waves, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seaway {
    /// `sigma_F` \[N\], standard deviation of the heave force at the surface.
    pub force: f64,
    /// `sigma_M` \[N m\], standard deviation of the pitch moment at the surface.
    pub moment: f64,
    /// `T` \[s\], period of the spectrum's peak.
    pub period: f64,
    /// `zeta`.
    pub damping: f64,
}

/// The shaping filter over one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapingFilter {
    /// `Phi`, transition matrix of the state `(x, x'/omega)`.
    transition: [[f64; 2]; 2],
    /// Lower triangular factor of the covariance added by a tick.
    noise: [[f64; 2]; 2],
}

/// State of the waves: the filter's state, and the source of its noise.
#[derive(Clone, Debug)]
pub struct Waves {
    state: [f64; 2],
    numbers: Pcg64,
}

impl Seaway {
    /// Whether there are no waves.
    #[must_use]
    pub fn is_calm(&self) -> bool {
        self.force == 0.0 && self.moment == 0.0
    }

    fn frequency(&self) -> f64 {
        std::f64::consts::TAU / self.period
    }

    /// Shaping filter over a tick of `dt` \[s\].
    ///
    /// # Errors
    /// If the numbers are not finite or `dt` is not positive.
    pub fn filter(&self, dt: f64) -> Result<ShapingFilter, Error> {
        let omega = self.frequency();
        // Of (x, x'/omega): the stationary covariance is then the unit matrix.
        let a = [0.0, omega, -omega, -2.0 * self.damping * omega];
        let held = StateSpace::new(
            DMatrix::from_row_slice(2, 2, &a),
            DMatrix::zeros(2, 1),
            DMatrix::identity(2, 2),
            DMatrix::zeros(2, 1),
        )?
        .zero_order_hold(dt)?;
        let phi = held.a;
        let q = DMatrix::identity(2, 2) - &phi * phi.transpose();
        // Cholesky by hand: an undamped filter adds nothing, and rounding must not make it NaN.
        let l00 = q[(0, 0)].max(0.0).sqrt();
        let l10 = if l00 > 0.0 { q[(1, 0)] / l00 } else { 0.0 };
        let l11 = (q[(1, 1)] - l10 * l10).max(0.0).sqrt();
        Ok(ShapingFilter {
            transition: [[phi[(0, 0)], phi[(0, 1)]], [phi[(1, 0)], phi[(1, 1)]]],
            noise: [[l00, 0.0], [l10, l11]],
        })
    }

    /// Force and moment of the waves at a depth \[m\], with `gravity` \[m/s^2\].
    #[must_use]
    pub fn load(&self, waves: &Waves, depth: f64, gravity: f64) -> GeneralisedForce {
        let omega = self.frequency();
        let reach = libm::exp(-omega * omega / gravity * depth.max(0.0));
        let [x, rate] = waves.state;
        GeneralisedForce {
            heave: reach * self.force * rate,
            pitch: reach * self.moment * x,
        }
    }
}

impl Waves {
    /// Returns the waves of a seed in their stationary state.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        // Another stream than the sensors', which are seeded with the same number.
        let mut numbers = Pcg64::seed_from_u64(!seed);
        Self {
            state: std::array::from_fn(|_| standard_normal(&mut numbers)),
            numbers,
        }
    }

    /// A tick on.
    pub fn advance(&mut self, filter: &ShapingFilter) {
        let n: [f64; 2] = std::array::from_fn(|_| standard_normal(&mut self.numbers));
        let [x, v] = self.state;
        self.state = std::array::from_fn(|i| {
            let ([a, b], [c, d]) = (filter.transition[i], filter.noise[i]);
            a * x + b * v + c * n[0] + d * n[1]
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SWELL: Seaway = Seaway {
        force: 0.5,
        moment: 0.1,
        period: 4.0,
        damping: 0.1,
    };

    fn forces(seed: u64, dt: f64, count: u32) -> Vec<GeneralisedForce> {
        let filter = SWELL.filter(dt).expect("a filter");
        let mut waves = Waves::new(seed);
        (0..count)
            .map(|_| {
                waves.advance(&filter);
                SWELL.load(&waves, 0.0, 9.81)
            })
            .collect()
    }

    fn deviation(values: impl Iterator<Item = f64>, count: u32) -> f64 {
        (values.map(|v| v * v).sum::<f64>() / f64::from(count)).sqrt()
    }

    #[test]
    fn the_deviations_are_those_asked_for_whatever_the_tick() {
        for dt in [0.02, 0.3] {
            let count = 200_000;
            let loads = forces(1, dt, count);
            let force = deviation(loads.iter().map(|l| l.heave), count);
            let moment = deviation(loads.iter().map(|l| l.pitch), count);
            assert!((force / 0.5 - 1.0).abs() < 0.05, "{dt}: {force}");
            assert!((moment / 0.1 - 1.0).abs() < 0.05, "{dt}: {moment}");
        }
    }

    #[test]
    fn the_force_has_the_period_of_the_peak() {
        let dt = 0.05;
        let loads = forces(3, dt, 80_000);
        let crossings = loads
            .windows(2)
            .filter(|pair| pair[0].pitch < 0.0 && pair[1].pitch >= 0.0)
            .count();
        let period = 80_000.0 * dt / crossings as f64;
        assert!((period - 4.0).abs() < 0.4, "{period}");
    }

    #[test]
    fn waves_die_out_with_depth() {
        let waves = Waves::new(1);
        let (top, below) = (SWELL.load(&waves, 0.0, 9.81), SWELL.load(&waves, 3.0, 9.81));
        let k = SWELL.frequency().powi(2) / 9.81;
        assert!((below.heave / top.heave - libm::exp(-3.0 * k)).abs() < 1e-12);
    }

    #[test]
    fn a_seed_gives_the_same_waves_and_another_gives_others() {
        assert_eq!(forces(7, 0.05, 50), forces(7, 0.05, 50));
        assert_ne!(forces(7, 0.05, 50), forces(8, 0.05, 50));
    }
}
