//! Propellers and thrusters: force and moment from rotation or command, and the way back, from force to commands.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::lanes::{Real, Six, Three, cross, of, scaled, six};

/// What drives the vehicle.
#[derive(Clone, Debug, PartialEq)]
pub enum Propulsor {
    /// A propeller that always turns alike, as Prestero 2001 has it: force along x \[N\] and moment about x \[N m\].
    Constant {
        /// `X_prop` \[N\]
        force: f64,
        /// `K_prop` \[N m\]
        moment: f64,
    },
    /// A force along x that is an input \[N\], within limits.
    Force {
        /// Which input it is.
        input: usize,
        /// Least and most \[N\].
        limits: [f64; 2],
    },
    /// A propeller by its open-water characteristics.
    Propeller {
        /// Which input its rotation is \[rad/s\].
        input: usize,
        /// The propeller.
        propeller: Propeller,
    },
    /// A thruster at a place of its own.
    Thruster {
        /// Which input its command is, -1 to 1.
        input: usize,
        /// The thruster.
        thruster: Thruster,
    },
}

/// A propeller on the axis: thrust and torque linear in the advance ratio `J = V_a/(n D)`.
///
/// ```text
/// V_a = (1 - wake) u     T = rho D^4 (K_T0 n^2 + K_T1 n V_a/D)     Q = rho D^5 (K_Q0 n^2 + K_Q1 n V_a/D)     n in 1/s
/// X = (1 - deduction) T     K = -hand Q     astern T = rho D^4 K_T0 n|n|, Q likewise
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Propeller {
    /// Of the water \[kg/m^3\].
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
    /// 1 for a right-handed propeller, whose torque rolls the hull to port when it drives ahead; -1 for a left-handed one.
    pub hand: f64,
    /// The rotation \[rad/s\] that a share of thrust is of, where the source has one.
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

/// A thruster: its thrust is a polynomial in odd powers of the command.
#[derive(Clone, Debug, PartialEq)]
pub struct Thruster {
    /// From the origin \[m\].
    pub position: Three<f64>,
    /// Where positive thrust pushes; of length 1.
    pub direction: Three<f64>,
    /// Thrust \[N\] per command to the powers 1, 3, 5, ...
    pub curve: Vec<f64>,
    /// Commands up to this size give no thrust.
    pub dead_zone: f64,
    /// Time constant with which it follows its command \[s\]; 0: at once. Ticks of the loop have it; a simulation with held inputs has the command that
    /// is reached.
    pub lag: f64,
}

impl Thruster {
    /// The thrust \[N\] at a command, -1 to 1.
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

/// Points of [`Inverse`] to a whole command.
const POINTS: usize = 256;

/// From a thrust back to the command: the thrust \[N\] at commands from 0 up to where it is the most, 256 to a whole command.
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

    /// The command that gives a thrust \[N\], by lines between the points; the most where it would take more.
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

    /// The most thrust \[N\].
    #[must_use]
    pub fn most(&self) -> f64 {
        self.0.last().copied().unwrap_or(0.0)
    }
}

impl Propulsor {
    /// Whether its force depends on the velocity too.
    pub(super) fn feels_flow(&self) -> bool {
        matches!(self, Self::Propeller { .. })
    }

    #[inline(always)]
    pub(super) fn force<T: Real>(&self, nu: &Six<T>, inputs: &[T]) -> Six<T> {
        let zero = T::of(0.0);
        let along = |force, moment| [force, zero, zero, moment, zero, zero];
        match self {
            Self::Constant { force, moment } => along(T::of(*force), T::of(*moment)),
            Self::Force { input, limits } => {
                let [least, most] = *limits;
                along(inputs[*input].map(|f| f.clamp(least, most)), zero)
            }
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

/// Why thrusters cannot be allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the thrusters push in {rank} of {wanted} directions only")]
pub struct Underactuated {
    /// The rank of the matrix of their forces and moments.
    pub rank: usize,
    /// The rank that is wanted.
    pub wanted: usize,
}

/// From a wanted force and moment to the thrusts that give it with the least sum of squares: `T = pinv(B) tau`.
#[derive(Clone, Debug)]
pub struct Allocation {
    inverse: DMatrix<f64>,
    /// Which of the six are wanted.
    rows: Vec<usize>,
}

impl Allocation {
    /// Of thrusters whose forces and moments together have rank 6.
    ///
    /// # Errors
    /// [`Underactuated`] when they have not.
    pub fn new(thrusters: &[&Thruster]) -> Result<Self, Underactuated> {
        Self::of_rows(thrusters, &[0, 1, 2, 3, 4, 5])
    }

    /// The same of some of the six alone, the others as they come.
    ///
    /// # Errors
    /// [`Underactuated`] when the rank is less than these.
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

    /// The thrusts \[N\] for a wanted force and moment.
    #[must_use]
    pub fn thrusts(&self, wanted: &Six<f64>) -> Vec<f64> {
        let wanted = DMatrix::from_fn(self.rows.len(), 1, |i, _| wanted[self.rows[i]]);
        (&self.inverse * wanted).iter().copied().collect()
    }

    /// The same, all made smaller alike where one would pass its most \[N\], and the share of the force that is given: its direction is kept.
    #[must_use]
    pub fn within(&self, wanted: &Six<f64>, most: f64) -> (Vec<f64>, f64) {
        let thrusts = self.thrusts(wanted);
        let largest = thrusts.iter().map(|t| t.abs()).fold(0.0, f64::max);
        let share = if largest > most { most / largest } else { 1.0 };
        (thrusts.iter().map(|t| t * share).collect(), share)
    }
}
