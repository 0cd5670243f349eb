//! Continuous systems with a sampled command, exact at the ticks.
//!
//! A command `u_k` is given at every tick `k T` and held until the next. The actuated quantity follows each change in the same way: `s(t)` is its
//! value at time `t` after a unit step of the command at a tick, from 0 to 1. The system `x' = A x + B s` is then, at the ticks,
//!
//! ```text
//! x_(k+1) = Ad x_k + sum_j G_j (u_(k-j) - u_(k-j-1)),   Ad = exp(A T)
//! G_j = integral over the tick j of exp(A ((j+1) T - t)) B s(t) dt
//! ```
//! For `s = 1` this is the zero-order hold (Franklin, Powell and Workman, *Digital Control of Dynamic Systems*, ch. 4). For `s` linear between
//! knots, each integral is a matrix exponential (Van Loan, *IEEE Trans. Automatic Control* 23, 1978).

use crate::{exponential as matrix_exponential, polar};
use std::f64::consts::PI;

use nalgebra::{Complex, DMatrix};

use crate::{Error, StateSpace, error::finite};

/// An immediate step: the zero-order hold.
pub const AT_ONCE: [(f64, f64); 2] = [(0.0, 0.0), (0.0, 1.0)];

/// Times closer than this count as equal, s.
const INSTANT: f64 = 1e-12;

/// A continuous system with one input, as a discrete system from its sampled command: `x_(k+1) = A x_k + sum_j B_j u_(k-j)`, `y_k = C x_k`.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampled {
    a: DMatrix<f64>,
    /// `B_0`, `B_1`, ...: input vectors of the present and of past commands.
    inputs: Vec<DMatrix<f64>>,
    c: DMatrix<f64>,
    tick: f64,
}

impl Sampled {
    /// The system with ticks of `tick` \[s\]. `motion`: the step response `s` as knots (time \[s\], value) in ascending time, linear in between,
    /// beginning with the value 0; two knots at one time are a step. After the last knot `s` is 1.
    ///
    /// # Errors
    /// [`Error::Shape`] for a system with several inputs or direct feedthrough, [`Error::NotPositive`] for `tick`, [`Error::NotFinite`].
    pub fn new(system: &StateSpace, motion: &[(f64, f64)], tick: f64) -> Result<Self, Error> {
        if system.b.ncols() != 1 || system.d.iter().any(|d| *d != 0.0) {
            return Err(Error::Shape {
                what: "a sampled system",
                found: format!("{} inputs, or direct feedthrough", system.b.ncols()),
                expected: "one input without direct feedthrough".to_owned(),
            });
        }
        let held = system.zero_order_hold(tick)?;
        let n = system.a.nrows();
        // The input and its slope as states of their own.
        let mut ramp = DMatrix::zeros(n + 2, n + 2);
        ramp.view_mut((0, 0), (n, n)).copy_from(&system.a);
        ramp.view_mut((0, n), (n, 1)).copy_from(&system.b);
        ramp[(n, n + 1)] = 1.0;
        let mut exponential = (0.0, DMatrix::identity(n + 2, n + 2));
        let last = motion.last().map_or(0.0, |knot| knot.0);
        let ticks = ((last - INSTANT) / tick).ceil().max(0.0) as usize;
        let mut x = DMatrix::zeros(n, 1);
        let mut steps = Vec::with_capacity(ticks + 1);
        for j in 0..ticks {
            let (begin, end) = (j as f64 * tick, (j + 1) as f64 * tick);
            let free = &held.a * &x;
            let mut from = begin;
            while end - from > INSTANT {
                let next = motion.iter().map(|knot| knot.0);
                let until = next.filter(|t| *t > from + INSTANT).fold(end, f64::min);
                let (low, high) = (after(motion, from), before(motion, until));
                if (exponential.0 - (until - from)).abs() > INSTANT {
                    exponential = (until - from, matrix_exponential(&(&ramp * (until - from))));
                }
                let mut state = DMatrix::zeros(n + 2, 1);
                state.view_mut((0, 0), (n, 1)).copy_from(&x);
                state[n] = low;
                state[n + 1] = (high - low) / (until - from);
                x = (&exponential.1 * state).rows(0, n).into_owned();
                from = until;
            }
            steps.push(&x - free);
        }
        steps.push(held.b);
        let inputs: Vec<_> = (0..steps.len())
            .map(|j| match j {
                0 => steps[0].clone(),
                _ => &steps[j] - &steps[j - 1],
            })
            .collect();
        for input in &inputs {
            finite("the sampled input", input)?;
        }
        Ok(Self {
            a: held.a,
            inputs,
            c: system.c.clone(),
            tick,
        })
    }

    /// Sampling interval `T` \[s\].
    #[must_use]
    pub fn tick(&self) -> f64 {
        self.tick
    }

    /// Nyquist frequency `pi / T` \[rad/s\].
    #[must_use]
    pub fn nyquist(&self) -> f64 {
        PI / self.tick
    }

    /// Frequency response from the command to the outputs at `z = exp(j w T)`, `w` in rad/s. `None` at a pole.
    #[must_use]
    pub fn at(&self, frequency: f64) -> Option<DMatrix<Complex<f64>>> {
        let n = self.a.nrows();
        let z = polar(1.0, frequency * self.tick);
        let complex = |m: &DMatrix<f64>| m.map(|it| Complex::new(it, 0.0));
        let mut driven = DMatrix::from_element(n, 1, Complex::new(0.0, 0.0));
        // Horner's rule in 1/z.
        for input in self.inputs.iter().rev() {
            driven = driven / z + complex(input);
        }
        let resolvent = DMatrix::identity(n, n) * z - complex(&self.a);
        Some(complex(&self.c) * resolvent.lu().solve(&driven)?)
    }

    /// Discrete state space with the state `x`, followed by past commands, latest first.
    #[must_use]
    pub fn state_space(&self) -> StateSpace {
        let (n, past) = (self.a.nrows(), self.inputs.len() - 1);
        let size = n + past;
        let mut a = DMatrix::zeros(size, size);
        a.view_mut((0, 0), (n, n)).copy_from(&self.a);
        for (j, input) in self.inputs[1..].iter().enumerate() {
            a.view_mut((0, n + j), (n, 1)).copy_from(input);
            if j > 0 {
                a[(n + j, n + j - 1)] = 1.0;
            }
        }
        let mut b = DMatrix::zeros(size, 1);
        b.view_mut((0, 0), (n, 1)).copy_from(&self.inputs[0]);
        if past > 0 {
            b[n] = 1.0;
        }
        let outputs = self.c.nrows();
        let mut c = DMatrix::zeros(outputs, size);
        c.view_mut((0, 0), (outputs, n)).copy_from(&self.c);
        StateSpace {
            a,
            b,
            c,
            d: DMatrix::zeros(outputs, 1),
        }
    }
}

/// `s` just after a time, s.
fn after(motion: &[(f64, f64)], time: f64) -> f64 {
    let next = motion.partition_point(|knot| knot.0 <= time + INSTANT);
    between(motion, next, time)
}

/// `s` just before a time, s.
fn before(motion: &[(f64, f64)], time: f64) -> f64 {
    let next = motion.partition_point(|knot| knot.0 < time - INSTANT);
    between(motion, next, time)
}

/// `s` at a time on the line to the knot `next`.
fn between(motion: &[(f64, f64)], next: usize, time: f64) -> f64 {
    match (next.checked_sub(1).map(|i| motion[i]), motion.get(next)) {
        (Some((from, low)), Some((to, high))) if *to > from => {
            low + (high - low) * ((time - from) / (to - from)).clamp(0.0, 1.0)
        }
        (Some((_, low)), Some(_)) => low,
        (None, _) => 0.0,
        (Some(_), None) => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ComplexFunctions as _;

    fn integrator() -> StateSpace {
        let one = DMatrix::from_element(1, 1, 1.0);
        let none = DMatrix::zeros(1, 1);
        StateSpace::new(none.clone(), one.clone(), one, none).unwrap()
    }

    fn inputs(motion: &[(f64, f64)]) -> Vec<f64> {
        let sampled = Sampled::new(&integrator(), motion, 0.5).unwrap();
        sampled.inputs.iter().map(|input| input[0]).collect()
    }

    #[track_caller]
    fn near(found: &[f64], expected: &[f64]) {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (a, b) in found.iter().zip(expected) {
            assert!((a - b).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn an_integrator_gathers_each_command_for_as_long_as_it_acts() {
        near(&inputs(&AT_ONCE), &[0.5]);
        // 0.2 s late, and one tick and 0.2 s late.
        near(&inputs(&[(0.2, 0.0), (0.2, 1.0)]), &[0.3, 0.2]);
        near(&inputs(&[(0.7, 0.0), (0.7, 1.0)]), &[0.0, 0.3, 0.2]);
        // A ramp over the tick, and one over two.
        near(&inputs(&[(0.0, 0.0), (0.5, 1.0)]), &[0.25, 0.25]);
        near(&inputs(&[(0.0, 0.0), (1.0, 1.0)]), &[0.125, 0.25, 0.125]);
    }

    #[test]
    fn the_state_space_has_the_frequency_response() {
        let sampled = Sampled::new(&integrator(), &[(0.1, 0.0), (0.9, 1.0)], 0.5).unwrap();
        let open = sampled.state_space().transfer_function(0, 0).unwrap();
        for frequency in [0.1, 1.0, sampled.nyquist()] {
            let z = polar(1.0, frequency * 0.5);
            let found = sampled.at(frequency).unwrap()[(0, 0)];
            assert!((found - open.value_at(z)).modulus() < 1e-12 * found.modulus());
        }
    }

    #[test]
    fn a_system_that_its_input_reaches_at_once_is_refused() {
        let mut direct = integrator();
        direct.d[(0, 0)] = 1.0;
        assert!(Sampled::new(&direct, &AT_ONCE, 0.5).is_err());
        assert!(Sampled::new(&integrator(), &AT_ONCE, 0.0).is_err());
    }
}
