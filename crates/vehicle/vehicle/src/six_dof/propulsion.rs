//! Propellers and thrusters: force and moment from rotation or command, and commands from a force.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::lanes::{Real, Six, Three, cross, of, scaled, six};

/// A propulsor of the vehicle.
#[derive(Clone, Debug, PartialEq)]
pub enum Propulsor {
    /// A propeller at constant speed, as in Prestero 2001: force along x \[N\] and moment about x \[N m\].
    Constant {
        /// `X_prop` \[N\]
        force: f64,
        /// `K_prop` \[N m\]
        moment: f64,
    },
    /// A force \[N\] or moment \[N m\] that is an input, within limits.
    Force {
        /// Index of the input.
        input: usize,
        /// Smallest and largest force or moment.
        limits: [f64; 2],
        /// Force and moment about the origin per unit of the input: `(1, 0, 0, 0, 0, 0)` for a force along x.
        wrench: Six<f64>,
    },
    /// A propeller with its open-water characteristics.
    Propeller {
        /// Index of the input that is its rotation \[rad/s\].
        input: usize,
        /// The propeller.
        propeller: Propeller,
    },
    /// A thruster with its own position.
    Thruster {
        /// Index of the input that is its command, -1 to 1.
        input: usize,
        /// The thruster.
        thruster: Thruster,
    },
}

/// A propeller on the axis, with thrust and torque linear in the advance ratio `J = V_a/(n D)`.
///
/// ```text
/// V_a = (1 - wake) u     T = rho D^4 (K_T0 n^2 + K_T1 n V_a/D)     Q = rho D^5 (K_Q0 n^2 + K_Q1 n V_a/D)     n in 1/s
/// X = (1 - deduction) T     K = -hand Q     astern T = rho D^4 K_T0 n|n|, Q likewise
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Propeller {
    /// Density of the water \[kg/m^3\].
    pub density: f64,
    /// `D` \[m\]
    pub diameter: f64,
    /// `K_T0`, `K_T1`.
    pub thrust: [f64; 2],
    /// `K_Q0`, `K_Q1`.
    pub torque: [f64; 2],
    /// Wake fraction.
    pub wake: f64,
    /// Thrust deduction.
    pub deduction: f64,
    /// 1 for a right-handed propeller, whose torque rolls the hull to port in forward thrust; -1 for a left-handed one.
    pub hand: f64,
    /// Rotation at full thrust \[rad/s\]; `None` if the source does not state it.
    pub full_rotation: Option<f64>,
}

impl Propeller {
    /// Force along x \[N\] and moment about x \[N m\], for a speed through the water \[m/s\] and a rotation \[rad/s\].
    #[inline(always)]
    #[must_use]
    pub fn force<T: Real>(&self, speed: T, rotation: T) -> (T, T) {
        let d = self.diameter;
        let n = rotation * T::of(1.0 / TAU);
        let advance = speed * T::of((1.0 - self.wake) / d);
        let ahead = n.map(|n| n.max(0.0));
        let scaled = |[k0, k1]: [f64; 2], unit: f64| {
            T::of(unit) * (T::of(k0) * n * n.abs() + T::of(k1) * ahead * advance)
        };
        let disc = self.density * d * d * d * d;
        let (thrust, torque) = (scaled(self.thrust, disc), scaled(self.torque, disc * d));
        let reaction = T::of(-self.hand) * torque;
        (T::of(1.0 - self.deduction) * thrust, reaction)
    }
}

/// A thruster, with thrust as a polynomial in odd powers of the command.
#[derive(Clone, Debug, PartialEq)]
pub struct Thruster {
    /// Position from the origin \[m\].
    pub position: Three<f64>,
    /// Unit vector of positive thrust.
    pub direction: Three<f64>,
    /// Coefficients of thrust \[N\] for the command to the powers 1, 3, 5, ...
    pub curve: Vec<f64>,
    /// Largest command without thrust.
    pub dead_zone: f64,
    /// Time constant of its response to the command \[s\]; 0: no lag. Ticks of the loop include the lag; a simulation with constant inputs
    /// uses the final command.
    pub lag: f64,
}

impl Thruster {
    /// Thrust \[N\] at a command, -1 to 1.
    #[inline(always)]
    #[must_use]
    pub fn thrust<T: Real>(&self, command: T) -> T {
        let zone = self.dead_zone;
        let command = command.map(|c| match c.abs() <= zone {
            true => 0.0,
            false => c.clamp(-1.0, 1.0),
        });
        let square = command * command;
        let mut sum = T::of(0.0);
        for power in self.curve.iter().rev() {
            sum = sum * square + T::of(*power);
        }
        sum * command
    }

    /// Force and moment about the origin per newton of thrust.
    #[must_use]
    pub fn wrench(&self) -> Six<f64> {
        six(self.direction, cross(self.position, self.direction))
    }
}

/// Number of points of [`Inverse`] for the command range from 0 to 1.
const POINTS: usize = 256;

/// The command as a function of thrust: thrust \[N\] at commands from 0 up to the maximum of thrust, 256 points for the range 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Inverse(Vec<f64>);

impl Inverse {
    /// Of a thruster.
    #[must_use]
    pub fn new(thruster: &Thruster) -> Self {
        let all: Vec<f64> = (0..=POINTS)
            .map(|k| thruster.thrust(k as f64 / POINTS as f64))
            .collect();
        let rising = all.windows(2).take_while(|pair| pair[1] >= pair[0]).count();
        Self(all[..=rising].to_vec())
    }

    /// Command for a thrust \[N\], by linear interpolation; the largest command if the thrust is too large.
    #[must_use]
    pub fn command(&self, thrust: f64) -> f64 {
        let size = thrust.abs();
        let above = self.0.partition_point(|point| *point < size);
        let (Some(low), Some(high)) = (self.0.get(above.wrapping_sub(1)), self.0.get(above)) else {
            let end = if above == 0 { 0 } else { self.0.len() - 1 };
            return (end as f64 / POINTS as f64).copysign(thrust);
        };
        let place = (above - 1) as f64 + (size - low) / (high - low);
        (place / POINTS as f64).copysign(thrust)
    }

    /// Largest thrust \[N\].
    #[must_use]
    pub fn most(&self) -> f64 {
        self.0.last().copied().unwrap_or(0.0)
    }
}

impl Propulsor {
    /// Whether the propulsor's force depends on the velocity.
    pub(super) fn feels_flow(&self) -> bool {
        matches!(self, Self::Propeller { .. })
    }

    #[inline(always)]
    pub(super) fn force<T: Real>(&self, nu: &Six<T>, inputs: &[T]) -> Six<T> {
        let zero = T::of(0.0);
        let along = |force, moment| [force, zero, zero, moment, zero, zero];
        match self {
            Self::Constant { force, moment } => along(T::of(*force), T::of(*moment)),
            Self::Force {
                input,
                limits: [least, most],
                wrench,
            } => scaled(inputs[*input].map(|f| f.clamp(*least, *most)), of(wrench)),
            Self::Propeller { input, propeller } => {
                let (force, moment) = propeller.force(nu[0], inputs[*input]);
                along(force, moment)
            }
            Self::Thruster { input, thruster } => {
                scaled(thruster.thrust(inputs[*input]), of(&thruster.wrench()))
            }
        }
    }
}

/// Position and direction of a force from its wrench per unit; `None` for a moment. The position is the nearest to the origin on its line.
pub(super) fn line_of_force(wrench: &Six<f64>) -> Option<(Three<f64>, Three<f64>)> {
    let [x, y, z, k, m, n] = *wrench;
    let force = [x, y, z];
    (force != [0.0; 3]).then(|| (cross(force, [k, m, n]), force))
}

/// The thrusters cannot produce all wanted forces and moments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the thrusters act in only {rank} of {wanted} directions")]
pub struct Underactuated {
    /// Rank of the matrix of their forces and moments.
    pub rank: usize,
    /// Required rank.
    pub wanted: usize,
}

/// Allocation of a force and moment to the thrusters with the smallest sum of squares: `T = pinv(B) tau`.
#[derive(Clone, Debug)]
pub struct Allocation {
    inverse: DMatrix<f64>,
    /// Indices of the requested components among the six.
    rows: Vec<usize>,
}

impl Allocation {
    /// Creates the allocation for thrusters whose forces and moments have rank 6.
    ///
    /// # Errors
    /// [`Underactuated`], if their rank is smaller.
    pub fn new(thrusters: &[&Thruster]) -> Result<Self, Underactuated> {
        Self::of_rows(thrusters, &[0, 1, 2, 3, 4, 5])
    }

    /// Allocates only some of the six components; the other components are not controlled.
    ///
    /// # Errors
    /// [`Underactuated`], if the rank is less than the number of these components.
    pub fn of_rows(thrusters: &[&Thruster], rows: &[usize]) -> Result<Self, Underactuated> {
        let wanted = rows.len();
        let columns: Vec<Six<f64>> = thrusters.iter().map(|t| t.wrench()).collect();
        if columns.is_empty() {
            return Err(Underactuated { rank: 0, wanted });
        }
        let b = DMatrix::from_fn(wanted, columns.len(), |i, j| columns[j][rows[i]]);
        let of = b.svd(true, true);
        let largest = of.singular_values.iter().copied().fold(0.0, f64::max);
        let tolerance = 1e-9 * largest;
        let rank = of.rank(tolerance);
        let inverse = of.pseudo_inverse(tolerance).ok().filter(|_| rank == wanted);
        inverse
            .map(|inverse| Self {
                inverse,
                rows: rows.to_vec(),
            })
            .ok_or(Underactuated { rank, wanted })
    }

    /// Thrusts \[N\] for a requested force and moment.
    #[must_use]
    pub fn thrusts(&self, wanted: &Six<f64>) -> Vec<f64> {
        let wanted = DMatrix::from_fn(self.rows.len(), 1, |i, _| wanted[self.rows[i]]);
        (&self.inverse * wanted).iter().copied().collect()
    }

    /// The thrusts, all scaled down by one factor if a thrust would exceed `most` \[N\], and that factor; the direction of the force is kept.
    #[must_use]
    pub fn within(&self, wanted: &Six<f64>, most: f64) -> (Vec<f64>, f64) {
        let thrusts = self.thrusts(wanted);
        let largest = thrusts.iter().map(|t| t.abs()).fold(0.0, f64::max);
        let share = if largest > most { most / largest } else { 1.0 };
        (thrusts.iter().map(|t| t * share).collect(), share)
    }
}
