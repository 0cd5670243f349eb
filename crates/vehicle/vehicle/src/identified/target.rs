//! The base vehicle with changed coefficients, so that its linearised equations equal the given equations.

use planesman_model_file::{Heave, Physical};

use super::error::Error;
use crate::{Vehicle, dynamics::GeneralisedForce, pitch, vehicle::Derivatives};

/// Difference of accelerations (1/s^2, 1/s) below which they count as equal.
const CLOSE: f64 = 1e-11;

/// Largest number of iterations.
const ROUNDS: usize = 50;

/// The pitch and heave equations that the vehicle must have.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    /// m/s
    pub(super) speed: f64,
    /// `kappa`, `beta` and `mu`.
    pub(super) pitch: [f64; 3],
    /// `nu`, 1/(m s); `None`: from the base's coefficients.
    pub(super) to_pitch: Option<f64>,
    /// Likewise.
    pub(super) heave: Option<Heave>,
}

impl Target {
    pub(super) fn of(physical: &Physical, speed: f64) -> Self {
        Self {
            speed,
            pitch: [physical.kappa, physical.beta, physical.mu],
            to_pitch: Some(physical.heave.map_or(0.0, |heave| heave.to_pitch)),
            heave: physical.heave,
        }
    }

    /// Changes the base's coefficients until its accelerations match; the missing accelerations are converted to loads with the inertia. On an even
    /// keel the result is exact; if level flight changes with the coefficients, a few iterations are needed.
    pub(super) fn reached_from(&self, base: &Vehicle) -> Result<Vehicle, Error> {
        let u = self.speed;
        let (m0, l) = (base.reference_mass, base.reference_length);
        let [kappa, beta, mu] = self.pitch;
        let mut found = base.clone();
        for _ in 0..ROUNDS {
            let d = found.derivatives(u);
            let now = pitch::coefficients(&d)?;
            let [
                kappa_now,
                beta_now,
                mu_now,
                nu_now,
                zeta_now,
                eta_now,
                epsilon_now,
            ] = now;
            let pitch = [
                self.to_pitch.map_or(0.0, |nu| nu - nu_now),
                beta_now - beta,
                mu_now - mu,
                kappa - kappa_now,
            ];
            let heave = self.heave.map(|it| {
                [
                    zeta_now - it.damping,
                    it.from_rate - eta_now,
                    it.from_input - epsilon_now,
                ]
            });
            let lacking = pitch.iter().chain(heave.iter().flatten());
            if lacking.fold(0.0, |most: f64, it| most.max(it.abs())) < CLOSE {
                return Ok(found);
            }
            let load = |heave: Option<f64>, pitch: f64| needed(&d, heave, pitch);
            let by_w = load(heave.map(|it| it[0]), pitch[0]);
            let by_q = load(heave.map(|it| it[1]), pitch[1]);
            let by_theta = load(None, pitch[2]);
            let by_delta = load(heave.map(|it| it[2]), pitch[3]);
            let c = &mut found.coefficients;
            c.z_w += by_w.heave * l / (m0 * u);
            c.m_w += by_w.pitch / (m0 * u);
            c.z_q += by_q.heave / (m0 * u);
            c.m_q += by_q.pitch / (m0 * l * u);
            c.z_delta += by_delta.heave * l / (m0 * u * u);
            c.m_delta += by_delta.pitch / (m0 * u * u);
            found.restoring_arm -= by_theta.pitch / found.weight;
            if let Some(roll) = &mut found.roll {
                roll.restoring = found.weight * found.restoring_arm;
            }
        }
        Err(Error::Unreachable {
            base: base.name.clone(),
            speed: u,
        })
    }
}

/// Load for these additional accelerations; without `heave`, only a moment.
fn needed(d: &Derivatives, heave: Option<f64>, pitch: f64) -> GeneralisedForce {
    match heave {
        Some(heave) => GeneralisedForce {
            heave: d.heave_inertia * heave - d.z_q_dot * pitch,
            pitch: d.pitch_inertia * pitch - d.m_w_dot * heave,
        },
        None => {
            let unit = GeneralisedForce {
                heave: 0.0,
                pitch: 1.0,
            };
            let (_, per_moment) = d.inverse_inertia().accelerations(unit);
            GeneralisedForce {
                heave: 0.0,
                pitch: pitch / per_moment,
            }
        }
    }
}
