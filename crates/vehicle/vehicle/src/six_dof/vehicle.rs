//! A vehicle with six degrees of freedom: its checked numbers.

use super::coefficients::Term;
use super::damping::{CrossFlow, Damping};
use super::fins::Fin;
use super::hull::Hull;
use super::inertia::{self, Matrix6, RigidBody};
use super::lanes::Three;
use super::propulsion::{Propulsor, Thruster};
use super::water::GRAVITY;

/// A vehicle, in SI units, with axes forward, starboard, keel from an origin fixed in the body.
#[derive(Clone, Debug, PartialEq)]
pub struct Vehicle {
    pub(super) parts: Parts,
    pub(super) inverse_inertia: Matrix6,
}

/// The numbers of a vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts {
    /// Its name.
    pub name: String,
    /// Names of its inputs, in order.
    pub inputs: Vec<String>,
    /// The rigid body.
    pub body: RigidBody,
    /// `W` \[N\]
    pub weight: f64,
    /// `B` \[N\]
    pub buoyancy: f64,
    /// Centre of buoyancy from the origin \[m\].
    pub centre_of_buoyancy: Three<f64>,
    /// `M_A`, symmetric; positive for resistance to acceleration.
    pub added_mass: Matrix6,
    /// Damping matrices.
    pub damping: Damping,
    /// Cross-flow drag by strips.
    pub cross_flow: Vec<CrossFlow>,
    /// Coefficients beyond added mass.
    pub terms: Vec<Term>,
    /// Fins in the flow at their own position.
    pub fins: Vec<Fin>,
    /// Propellers and thrusters.
    pub propulsors: Vec<Propulsor>,
    /// Dimensions of the hull.
    pub hull: Hull,
}

impl Parts {
    /// The thrusters, each with the index of its command input.
    pub fn thrusters(&self) -> impl Iterator<Item = (usize, &Thruster)> {
        self.propulsors.iter().filter_map(|one| match one {
            Propulsor::Thruster { input, thruster } => Some((*input, thruster)),
            _ => None,
        })
    }
}

/// Reason why a vehicle is not physical.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{entry}: {reason}")]
pub struct Unphysical {
    /// Entry of the file.
    pub entry: String,
    /// Value and rule.
    pub reason: String,
}

impl Unphysical {
    pub(super) fn new(entry: impl Into<String>, reason: impl Into<String>) -> Self {
        Self {
            entry: entry.into(),
            reason: reason.into(),
        }
    }
}

/// Largest distance of a centre from the origin, in edge lengths of a cube of the displaced water; a hull of 30 diameters is 8 of these
/// long.
const FARTHEST: f64 = 10.0;

impl Vehicle {
    /// Creates a vehicle from its numbers.
    ///
    /// # Errors
    /// [`Unphysical`], if a number is not finite or not positive where required, if the inertia is not symmetric and positive definite, or
    /// if linear damping adds energy.
    pub fn new(parts: Parts) -> Result<Self, Unphysical> {
        parts.check_sizes()?;
        let inverse_inertia = parts.inverse_inertia()?;
        parts.check_damping()?;
        if let Some(term) = parts.terms.iter().find(|term| !term.value.is_finite()) {
            return refused("coefficients", format!("{} is not finite", term.value));
        }
        Ok(Self {
            parts,
            inverse_inertia,
        })
    }

    /// The numbers of the vehicle.
    #[must_use]
    pub fn parts(&self) -> &Parts {
        &self.parts
    }
}

fn refused<T>(entry: &str, reason: impl Into<String>) -> Result<T, Unphysical> {
    Err(Unphysical::new(entry, reason))
}

impl Parts {
    /// Checks weights, positions and hull dimensions.
    fn check_sizes(&self) -> Result<(), Unphysical> {
        for (entry, value) in [
            ("mass", self.body.mass),
            ("weight", self.weight),
            ("buoyancy", self.buoyancy),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return refused(entry, format!("{value} is not positive"));
            }
        }
        let farthest = FARTHEST * libm::cbrt(self.buoyancy / (1000.0 * GRAVITY));
        for (entry, place) in [
            ("centre_of_gravity", self.body.centre_of_gravity),
            ("centre_of_buoyancy", self.centre_of_buoyancy),
        ] {
            if !place.iter().all(|x| x.abs() <= farthest) {
                let reason = format!(
                    "{place:?} m refused: it is too far from the origin for this buoyancy; the limit is {farthest:.1} m"
                );
                return refused(entry, reason);
            }
        }
        let edge = Hull::of_buoyancy(self.buoyancy).length;
        for (entry, extent) in [
            ("hull.length", self.hull.length),
            ("hull.width", self.hull.width),
            ("hull.height", self.hull.height),
        ] {
            if !(edge / 20.0..=edge * 20.0).contains(&extent) {
                let reason = format!(
                    "{extent} m refused: it must be from 1/20 to 20 times {edge:.3} m, the edge of a cube of the displaced water"
                );
                return refused(entry, reason);
            }
        }
        Ok(())
    }

    /// Inverse of the inertia of body and water; each of the two is checked.
    fn inverse_inertia(&self) -> Result<Matrix6, Unphysical> {
        symmetric("added_mass", &self.added_mass)?;
        if let Some(i) = (0..6).find(|i| self.added_mass[*i][*i] < 0.0) {
            let reason = format!(
                "{} refused as diagonal entry {}: it must not be below 0; published derivatives, such as X_udot, have the opposite sign",
                self.added_mass[i][i],
                i + 1
            );
            return refused("added_mass", reason);
        }
        let rigid = self.body.matrix();
        symmetric("inertia", &rigid)?;
        if inertia::inverse(&rigid).is_none() {
            let reason =
                "not physical: with mass and centre of gravity it is not positive definite";
            return refused("inertia", reason);
        }
        let body = &self.body;
        let about_gravity = inertia::about_origin(body.inertia, -body.mass, body.centre_of_gravity);
        let principal =
            nalgebra::Matrix3::from_fn(|i, j| about_gravity[i][j]).symmetric_eigenvalues();
        let (largest, sum) = (principal.max(), principal.sum());
        if principal.min() <= 0.0 || 2.0 * largest > sum * (1.0 + 1e-6) {
            let about: Vec<String> = principal.iter().map(|x| format!("{x:.4}")).collect();
            let reason = format!(
                "the principal moments {} kg m^2 about the centre of gravity are not physical: each must be positive, and at most the sum of the others",
                about.join(", ")
            );
            return refused("inertia", reason);
        }
        let inverse = inertia::inverse(&inertia::added(&rigid, &self.added_mass));
        let reason = "with the body's inertia it is not positive definite";
        inverse.ok_or_else(|| Unphysical::new("added_mass", reason))
    }

    /// Checks that damping does not add energy.
    fn check_damping(&self) -> Result<(), Unphysical> {
        let linear = &self.damping.linear;
        let symmetrical: Matrix6 =
            std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (linear[i][j] + linear[j][i])));
        let least = least_eigenvalue(&symmetrical);
        if let Some(least) = least.filter(|least| *least < -1e-9 * norm(linear)) {
            let reason = format!(
                "it adds energy: the smallest eigenvalue of its symmetric part is {least:.3e}"
            );
            return refused("linear_damping", reason);
        }
        for (i, row) in self.damping.quadratic.iter().enumerate() {
            if row.iter().any(|x| !x.is_finite()) || row[i] < 0.0 {
                let reason = format!("row {}: {row:?} adds energy or is not finite", i + 1);
                return refused("quadratic_damping", reason);
            }
        }
        Ok(())
    }
}

/// Refuses a matrix that is not symmetric.
fn symmetric(entry: &str, a: &Matrix6) -> Result<(), Unphysical> {
    for i in 0..6 {
        for j in 0..6 {
            let (one, other) = (a[i][j], a[j][i]);
            let is_same = (one - other).abs() <= 1e-9 * norm(a);
            if !is_same {
                let reason = format!(
                    "not symmetric: {one} in row {}, column {}, but {other} in the mirrored entry",
                    i + 1,
                    j + 1
                );
                return Err(Unphysical::new(entry, reason));
            }
        }
    }
    Ok(())
}

fn norm(a: &Matrix6) -> f64 {
    a.iter().flatten().map(|x| x.abs()).fold(0.0, f64::max)
}

/// Smallest eigenvalue; `None` if an entry is not finite.
fn least_eigenvalue(a: &Matrix6) -> Option<f64> {
    if a.iter().flatten().any(|x| !x.is_finite()) {
        return Some(f64::NEG_INFINITY);
    }
    let matrix = nalgebra::SMatrix::<f64, 6, 6>::from_fn(|i, j| a[i][j]);
    Some(matrix.symmetric_eigenvalues().min())
}
