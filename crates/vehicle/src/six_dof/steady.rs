//! Steady turns: motions that go on unchanged in the body's axes, at one depth.

use nalgebra::{SMatrix, SVector};

use super::equations::State;
use super::rotation::{from_euler, matrix, to_fixed};
use super::vehicle::Vehicle;
use super::water::Water;

/// A steady turn at one depth: rates are those of turning about the vertical alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    /// u, v, w \[m/s\].
    pub velocity: [f64; 3],
    /// \[rad\]
    pub roll: f64,
    /// \[rad\]
    pub pitch: f64,
    /// Of the heading \[rad/s\].
    pub yaw_rate: f64,
    /// The input that holds the depth, in its unit.
    pub held: f64,
}

impl Turn {
    /// Its state, at the place 0 heading north.
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

/// The steady turn that Newton's method finds from `start` in still water, with `inputs` but number `holding`, which keeps the depth. `None` when
/// it does not converge. A vehicle may have several: the start chooses.
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
