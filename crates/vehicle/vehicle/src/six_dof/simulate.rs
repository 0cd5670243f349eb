//! Integration of the equations with a fixed step, or to a given accuracy.

use planesman_linear::{DORMAND_PRINCE_NODES, dormand_prince_step, runge_kutta_step};

use super::equations::{FixedTerms, State};
use super::lanes::Real;
use super::rotation::normalised;
use super::vehicle::Vehicle;
use super::water::{Sea, Water};

/// A step of `dt` \[s\] with the classical Runge-Kutta method, for one vehicle or several lanes; inputs and water are constant. Afterwards
/// the quaternion is scaled to length 1.
#[inline(always)]
#[must_use]
pub fn runge_kutta<T: Real>(
    vehicle: &Vehicle,
    state: &State<T>,
    inputs: &[T],
    water: &Water<T>,
    dt: f64,
) -> State<T> {
    runge_kutta_under(vehicle, state, &vehicle.held(inputs), water, dt)
}

/// One Runge-Kutta step with prepared inputs.
#[inline(always)]
pub(super) fn runge_kutta_under<T: Real>(
    vehicle: &Vehicle,
    state: &State<T>,
    held: &FixedTerms<'_, T>,
    water: &Water<T>,
    dt: f64,
) -> State<T> {
    let row = runge_kutta_step(&state.row(), dt, [&(); 3], |(), row| {
        vehicle.derivative_under(&State::of_row(*row), held, water)
    });
    let after = State::of_row(row);
    State {
        attitude: normalised(after.attitude),
        ..after
    }
}

/// Accuracy of the integration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accurate {
    /// Error of a step relative to each number's size.
    pub relative: f64,
    /// Error of a step for small numbers \[m, m/s, rad/s\].
    pub absolute: f64,
}

impl Default for Accurate {
    fn default() -> Self {
        Self {
            relative: 1e-9,
            absolute: 1e-9,
        }
    }
}

/// The motion is not finite, or the required step is shorter than the time's resolution.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the motion diverges at {time} s")]
pub struct Diverged {
    /// When \[s\].
    pub time: f64,
}

/// A vehicle in the sea, integrated to an accuracy with the eighth-order method of Dormand and Prince; the error controls the step.
#[derive(Clone, Debug)]
pub struct Simulation<'a> {
    vehicle: &'a Vehicle,
    sea: &'a Sea,
    accuracy: Accurate,
    /// The time \[s\].
    pub time: f64,
    /// State at that time.
    pub state: State,
    step: f64,
}

/// Longest step \[s\].
const LONGEST: f64 = 1.0;

impl<'a> Simulation<'a> {
    /// Creates a simulation that starts from a state at time 0.
    #[must_use]
    pub fn new(vehicle: &'a Vehicle, sea: &'a Sea, state: State, accuracy: Accurate) -> Self {
        Self {
            vehicle,
            sea,
            accuracy,
            time: 0.0,
            state,
            step: 0.01,
        }
    }

    /// Advances to a time \[s\] with constant inputs.
    ///
    /// # Errors
    /// [`Diverged`], if the motion does not stay finite.
    pub fn advance(&mut self, until: f64, inputs: &[f64]) -> Result<(), Diverged> {
        self.advance_under(until, |_, _| inputs)
    }

    /// Advances to a time \[s\] with inputs that are a smooth function of time and state.
    ///
    /// # Errors
    /// [`Diverged`], if the motion does not stay finite.
    pub fn advance_under<I: AsRef<[f64]>>(
        &mut self,
        until: f64,
        inputs: impl Fn(f64, &State) -> I,
    ) -> Result<(), Diverged> {
        while self.time < until {
            let left = until - self.time;
            // The last step ends on the time; none is left that is a trifle of it.
            let h = match self.step {
                step if step >= left => left,
                step if 2.0 * step >= left => left / 2.0,
                step => step,
            };
            let row = self.state.row();
            let times = DORMAND_PRINCE_NODES.map(|node| self.time + node * h);
            let (after, error) = dormand_prince_step(&row, h, &times, |time, row| {
                let state = State::of_row(*row);
                let over_ground = super::rotation::to_fixed(
                    &super::rotation::matrix(state.attitude),
                    [state.velocity[0], state.velocity[1], state.velocity[2]],
                );
                let water = self.sea.at(state.position, over_ground, *time);
                self.vehicle
                    .derivative(&state, inputs(*time, &state).as_ref(), &water)
            });
            let mut squares = 0.0;
            for i in 0..row.len() {
                let size = row[i].abs().max(after[i].abs());
                let allowed = self.accuracy.absolute + self.accuracy.relative * size;
                squares += (error[i] / allowed) * (error[i] / allowed);
            }
            let excess = (squares / row.len() as f64).sqrt();
            let is_accepted = excess.is_finite() && excess <= 1.0;
            if is_accepted {
                self.time = if h == left { until } else { self.time + h };
                let after = State::of_row(after);
                self.state = State {
                    attitude: normalised(after.attitude),
                    ..after
                };
            }
            let factor = match excess.is_finite() {
                true => (0.9 * libm::pow(excess.max(1e-12), -0.125)).clamp(0.2, 5.0),
                false => 0.1,
            };
            // A step that the time's end cut short says nothing against the longer one.
            let least = if is_accepted { self.step } else { 0.0 };
            self.step = match h < least && factor >= 1.0 {
                true => least,
                false => (h * factor).min(LONGEST),
            };
            if !is_accepted && self.step < 1e-12 * (1.0 + self.time) {
                return Err(Diverged { time: self.time });
            }
        }
        Ok(())
    }
}
