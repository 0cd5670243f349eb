//! The regression of a discrete transfer function, row by row.
//!
//! The equation-error model of order n (Brunner, NPS thesis, 1988, ch. V):
//! ```text
//! y_k = -a1 y_(k-1) - ... - an y_(k-n) + b1 u_(k-1) + ... + bn u_(k-n)
//!                                      + c1 m_(k-1) + ... + cn m_(k-n) + bias
//! ```
//! is linear in its parameters: `y_k = phi_k . theta` with
//! ```text
//! phi_k = [-y_(k-1) ... -y_(k-n), u_(k-1) ... u_(k-n), m_(k-1) ... m_(k-n), 1]
//! theta = [a1 ... an, b1 ... bn, c1 ... cn, bias]
//! ```
//! u is the input's mean over a sampling interval and m its first moment (see [`Input`]); the c and bias columns are optional.
//!
//! Rows begin where a complete history exists, at k = n. The thesis requires runs that begin at zero "for best data correlation" (ch. V.F); with
//! complete histories a record may begin in motion.

use planesman_record::Input;

/// The columns of the regression.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// `n`, the order: at least 1.
    pub order: usize,
    /// Whether first moments are regressors.
    pub moment: bool,
    /// Whether a constant is a regressor.
    pub bias: bool,
}

impl Shape {
    /// The number of parameters: n a's, n b's, n c's if they are estimated, and the bias if it is estimated.
    #[must_use]
    pub fn parameters(&self) -> usize {
        self.order * (2 + usize::from(self.moment)) + usize::from(self.bias)
    }
}

/// The last n outputs and inputs, from which the next row is made.
#[derive(Clone, Debug)]
struct History {
    shape: Shape,
    /// Past outputs, newest first, in the order of the row.
    outputs: Vec<f64>,
    inputs: Vec<Input>,
    row: Vec<f64>,
}

impl History {
    /// An empty history.
    fn new(shape: Shape) -> Self {
        Self {
            shape,
            outputs: Vec::with_capacity(shape.order + 1),
            inputs: Vec::with_capacity(shape.order + 1),
            row: Vec::with_capacity(shape.parameters()),
        }
    }

    /// Clears the history and begins with `output`, without a known earlier input.
    fn begin(&mut self, output: f64) {
        self.outputs.clear();
        self.inputs.clear();
        self.outputs.push(output);
    }

    /// Takes the output and the input over the interval that ended with it. Returns the row phi for the regression of `output`, once the earlier
    /// history has n samples.
    fn push(&mut self, input: Input, output: f64) -> Option<&[f64]> {
        let n = self.shape.order;
        self.inputs.insert(0, input);
        self.inputs.truncate(n);
        let complete = self.outputs.len() == n && self.inputs.len() == n;
        if complete {
            self.row.clear();
            self.row.extend(self.outputs.iter().map(|y| -y));
            self.row.extend(self.inputs.iter().map(|u| u.mean));
            if self.shape.moment {
                self.row.extend(self.inputs.iter().map(|u| u.moment));
            }
            if self.shape.bias {
                self.row.push(1.0);
            }
        }
        self.outputs.insert(0, output);
        self.outputs.truncate(n);
        complete.then_some(self.row.as_slice())
    }
}

/// Every row of a record with its output: `inputs[k]` acts over the interval that begins with `outputs[k]`.
#[must_use]
pub fn rows(shape: Shape, inputs: &[Input], outputs: &[f64]) -> Vec<(Vec<f64>, f64)> {
    let mut history = History::new(shape);
    let mut rows = Vec::new();
    for (k, output) in outputs.iter().enumerate() {
        match k.checked_sub(1).and_then(|before| inputs.get(before)) {
            None => history.begin(*output),
            Some(input) => {
                if let Some(row) = history.push(*input, *output) {
                    rows.push((row.to_vec(), *output));
                }
            }
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_made_of_the_last_outputs_inputs_and_moments() {
        let shape = Shape {
            order: 2,
            moment: true,
            bias: true,
        };
        let inputs: Vec<Input> = [10.0, 20.0, 30.0]
            .iter()
            .map(|u| Input {
                mean: *u,
                moment: u / 100.0,
            })
            .collect();
        let rows = rows(shape, &inputs, &[1.0, 2.0, 3.0, 4.0]);
        assert_eq!(
            rows,
            vec![
                (vec![-2.0, -1.0, 20.0, 10.0, 0.2, 0.1, 1.0], 3.0),
                (vec![-3.0, -2.0, 30.0, 20.0, 0.3, 0.2, 1.0], 4.0),
            ]
        );
        assert_eq!(rows[0].0.len(), shape.parameters());
    }

    #[test]
    fn beginning_again_needs_a_whole_history_again() {
        let shape = Shape {
            order: 2,
            moment: false,
            bias: false,
        };
        let mut history = History::new(shape);
        history.begin(1.0);
        assert_eq!(history.push(Input::held(0.0), 2.0), None);
        assert!(history.push(Input::held(0.0), 3.0).is_some());
        history.begin(4.0);
        assert_eq!(history.push(Input::held(0.0), 5.0), None);
        assert!(history.push(Input::held(0.0), 6.0).is_some());
    }
}
