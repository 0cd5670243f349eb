//! Steady turns: motions that are constant in body axes, at constant depth.

use nalgebra::{DMatrix, SMatrix, SVector};
use planesman_linear::poles::eigenvalues;

use std::f64::consts::FRAC_PI_2;

use super::equations::State;
use super::rotation::{from_euler, matrix, to_fixed};
use super::vehicle::Vehicle;
use super::water::Water;

/// A steady turn at constant depth; the body rotates about the vertical only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// u, v, w \[m/s\].
    pub velocity: [f64; 3],
    /// \[rad\]
    pub roll: f64,
    /// \[rad\]
    pub pitch: f64,
    /// Rate of the heading \[rad/s\].
    pub yaw_rate: f64,
    /// Input that holds the depth, in its unit.
    pub held: f64,
}

impl Turn {
    /// The turn's state, at position 0 and heading north.
    #[must_use]
    pub fn state(&self) -> State {
        let [u, v, w] = self.velocity;
        let attitude = from_euler([self.roll, self.pitch, 0.0]);
        let down = matrix(attitude)[2];
        let [p, q, r] = down.map(|d| d * self.yaw_rate);
        State {
            position: [0.0; 3],
            attitude,
            velocity: [u, v, w, p, q, r],
        }
    }

    fn of(x: &SVector<f64, 7>) -> Self {
        Self {
            velocity: [x[0], x[1], x[2]],
            roll: x[3],
            pitch: x[4],
            yaw_rate: x[5],
            held: x[6],
        }
    }
}

/// Surge velocities \[m/s\] and heading rates \[rad/s\] at which searches begin.
const SPEEDS: [f64; 4] = [0.5, 1.0, 1.5, 2.5];
const YAW_RATES: [f64; 9] = [-0.4, -0.2, -0.1, -0.02, 0.0, 0.02, 0.1, 0.2, 0.4];

/// The steady turns that Newton's method finds from a grid of starts and from `start`, each once, in order of increasing rate. Inverted
/// turns are excluded.
#[must_use]
pub fn steady_turns(vehicle: &Vehicle, inputs: &[f64], holding: usize, start: Turn) -> Vec<Turn> {
    let grid = SPEEDS.iter().flat_map(|speed| {
        YAW_RATES.map(|yaw_rate| Turn {
            velocity: [*speed, 0.0, 0.0],
            roll: 0.0,
            pitch: 0.0,
            yaw_rate,
            held: 0.0,
        })
    });
    let mut turns: Vec<Turn> = Vec::new();
    for start in std::iter::once(start).chain(grid) {
        let Some(turn) = steady_turn(vehicle, inputs, holding, start) else {
            continue;
        };
        let upright = turn.roll.abs() < FRAC_PI_2 && turn.pitch.abs() < FRAC_PI_2;
        let row = turn.state().velocity;
        let is_known = turns.iter().any(|known| {
            let other = known.state().velocity;
            row.iter().zip(other).all(|(x, y)| (x - y).abs() < 1e-6)
        });
        if upright && !is_known {
            turns.push(turn);
        }
    }
    turns.sort_by(|a, b| a.yaw_rate.abs().total_cmp(&b.yaw_rate.abs()));
    turns
}

/// Growth rate of the fastest-growing small deviation from a steady turn with constant inputs \[1/s\]; the turn is stable if this rate is negative.
/// Depth, position and heading are excluded, because the motion does not depend on them. `None` if the linearised motion is not finite.
#[must_use]
pub fn growth(vehicle: &Vehicle, inputs: &[f64], holding: usize, turn: &Turn) -> Option<f64> {
    let mut inputs = inputs.to_vec();
    inputs[holding] = turn.held;
    // Velocities, roll and pitch; their rates by Euler's angles (Fossen 2011, eq. 2.28).
    let rates = |x: &SVector<f64, 8>| -> SVector<f64, 8> {
        let (roll, pitch) = (x[6], x[7]);
        let state = State {
            position: [0.0; 3],
            attitude: from_euler([roll, pitch, 0.0]),
            velocity: std::array::from_fn(|i| x[i]),
        };
        let a = vehicle.acceleration(&state, &inputs, &Water::at_rest());
        let (sin, cos) = libm::sincos(roll);
        let turning = x[4] * sin + x[5] * cos;
        let rolling = x[3] + turning * libm::tan(pitch);
        let pitching = x[4] * cos - x[5] * sin;
        SVector::from([a[0], a[1], a[2], a[3], a[4], a[5], rolling, pitching])
    };
    let [u, v, w, p, q, r] = turn.state().velocity;
    let x = SVector::from([u, v, w, p, q, r, turn.roll, turn.pitch]);
    let h = 1e-6;
    let slopes = DMatrix::from_fn(8, 8, |i, j| {
        let (mut above, mut below) = (x, x);
        above[j] += h;
        below[j] -= h;
        (rates(&above)[i] - rates(&below)[i]) / (2.0 * h)
    });
    let found = eigenvalues(&slopes).ok()?;
    found.into_iter().map(|it| it.re).max_by(f64::total_cmp)
}

/// The steady turn that Newton's method finds from `start` in still water, with `inputs`, except that input `holding` is chosen to keep the
/// depth. `None` if it does not converge. A vehicle may have several turns; the result depends on the start.
#[must_use]
pub fn steady_turn(vehicle: &Vehicle, inputs: &[f64], holding: usize, start: Turn) -> Option<Turn> {
    let residual = |x: &SVector<f64, 7>| -> SVector<f64, 7> {
        let turn = Turn::of(x);
        let state = turn.state();
        let mut inputs = inputs.to_vec();
        inputs[holding] = turn.held;
        let a = vehicle.acceleration(&state, &inputs, &Water::at_rest());
        let sinking = to_fixed(&matrix(state.attitude), turn.velocity)[2];
        SVector::from([a[0], a[1], a[2], a[3], a[4], a[5], sinking])
    };
    let [u, v, w] = start.velocity;
    let mut x = SVector::from([u, v, w, start.roll, start.pitch, start.yaw_rate, start.held]);
    for _ in 0..50 {
        let now = residual(&x);
        let mut slopes = SMatrix::<f64, 7, 7>::zeros();
        for j in 0..7 {
            let h = 1e-6 * x[j].abs().max(0.1);
            let (mut above, mut below) = (x, x);
            above[j] += h;
            below[j] -= h;
            slopes.set_column(j, &((residual(&above) - residual(&below)) / (2.0 * h)));
        }
        let step = slopes.lu().solve(&now)?;
        // Far from the turn a whole step may go anywhere.
        let scale = (0.2 / step.amax()).min(1.0);
        x -= step * scale;
        if step.amax() < 1e-13 {
            break;
        }
    }
    let within = residual(&x).amax() < 1e-9;
    within.then(|| Turn::of(&x))
}
