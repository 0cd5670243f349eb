//! Numbers of one vehicle, or of several side by side; the equations are written once for both.
//!
//! Every operation acts on each lane separately, in the written order. So a vehicle's numbers are bit-identical alone and in any lane of a vector of
//! any width.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A number, or one number for each of several vehicles.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Mul<f64, Output = Self>
    + Neg<Output = Self>
    + AddAssign
{
    /// Puts one number into every lane.
    fn of(x: f64) -> Self;

    /// Applies a function to each lane.
    #[must_use]
    fn map(self, f: impl Fn(f64) -> f64) -> Self;

    /// Applies a function of two arguments to each lane.
    #[must_use]
    fn with(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self;

    /// Smallest value of all lanes.
    #[must_use]
    fn least(self) -> f64;

    /// `|x|`
    #[inline(always)]
    #[must_use]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }

    /// The square root.
    #[inline(always)]
    #[must_use]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        f(self)
    }

    #[inline(always)]
    fn with(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        f(self, other)
    }

    #[inline(always)]
    fn least(self) -> f64 {
        self
    }
}

/// A number for each of `N` vehicles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes<const N: usize>(pub [f64; N]);

impl<const N: usize> Real for Lanes<N> {
    #[inline(always)]
    fn of(x: f64) -> Self {
        Self([x; N])
    }

    #[inline(always)]
    fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        for x in &mut self.0 {
            *x = f(*x);
        }
        self
    }

    #[inline(always)]
    fn with(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        for (x, y) in out.0.iter_mut().zip(other.0) {
            *x = f(*x, y);
        }
        out
    }

    #[inline(always)]
    fn least(self) -> f64 {
        self.0.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// Implements an operator of two numbers, lane by lane.
macro_rules! operator {
    ($trait:ident, $name:ident, $op:tt) => {
        impl<const N: usize> $trait for Lanes<N> {
            type Output = Self;

            #[inline(always)]
            fn $name(mut self, other: Self) -> Self {
                for (x, y) in self.0.iter_mut().zip(other.0) {
                    *x $op y;
                }
                self
            }
        }
    };
}
operator!(Add, add, +=);
operator!(Sub, sub, -=);
operator!(Mul, mul, *=);
operator!(Div, div, /=);

impl<const N: usize> Mul<f64> for Lanes<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.map(|x| x * other)
    }
}

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

impl<const N: usize> AddAssign for Lanes<N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

// Loops here, not `array::map` or `from_fn`: those stay calls of a function that copies all lanes.

/// A vector with three components.
pub type Three<T> = [T; 3];
/// A velocity, or a force and moment: three components along the axes, and three about the axes.
pub type Six<T> = [T; 6];

/// `a x b`
#[inline(always)]
pub(super) fn cross<T: Real>(a: Three<T>, b: Three<T>) -> Three<T> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// `a . b`
#[inline(always)]
pub(super) fn dot<T: Real>(a: Three<T>, b: Three<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a + b`
#[inline(always)]
pub(super) fn sum<T: Real, const N: usize>(mut a: [T; N], b: [T; N]) -> [T; N] {
    for i in 0..N {
        a[i] += b[i];
    }
    a
}

/// `a - b`
#[inline(always)]
pub(super) fn difference<T: Real, const N: usize>(mut a: [T; N], b: [T; N]) -> [T; N] {
    for i in 0..N {
        a[i] = a[i] - b[i];
    }
    a
}

/// `s a`
#[inline(always)]
pub(super) fn scaled<T: Real, const N: usize>(s: T, mut a: [T; N]) -> [T; N] {
    for x in &mut a {
        *x = s * *x;
    }
    a
}

/// A constant vector in every lane.
#[inline(always)]
pub(super) fn of<T: Real, const N: usize>(a: &[f64; N]) -> [T; N] {
    let mut all = [T::of(0.0); N];
    for i in 0..N {
        all[i] = T::of(a[i]);
    }
    all
}

/// Product of a matrix and a vector. Most entries of a vehicle's matrices are 0 and are skipped.
#[inline(always)]
pub(super) fn product<T: Real, const N: usize>(matrix: &[[f64; N]; N], x: &[T; N]) -> [T; N] {
    let mut rows = [T::of(0.0); N];
    for i in 0..N {
        for j in 0..N {
            if matrix[i][j] != 0.0 {
                rows[i] += T::of(matrix[i][j]) * x[j];
            }
        }
    }
    rows
}

/// Joins force and moment.
#[inline(always)]
pub(super) fn six<T: Real>(force: Three<T>, moment: Three<T>) -> Six<T> {
    let ([x, y, z], [k, m, n]) = (force, moment);
    [x, y, z, k, m, n]
}

/// Splits into force and moment.
#[inline(always)]
pub(super) fn halves<T: Real>([x, y, z, k, m, n]: Six<T>) -> (Three<T>, Three<T>) {
    ([x, y, z], [k, m, n])
}
