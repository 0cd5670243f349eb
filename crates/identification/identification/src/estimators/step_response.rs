//! A step response directly from the data: a finite impulse response by least squares, integrated.
//!
//! ```text
//! y_k = g0 u_k + g1 u_(k-1) + ... + gL u_(k-L) + constant + e_k        s_k = g0 + ... + gk
//! ```
//! without bias if the noise is independent of the input, whatever its colour (Ljung 1999, sec. 4.2 and 6.1). A long response is assumed
//! constant over blocks of equal length, which keeps the unknowns few and accurate; s is then linear between the blocks' ends. No
//! assumption is made about order, delay or the time before the record: rows begin where all L past inputs are known.

use nalgebra::{DMatrix, DVector};

use super::levenberg_marquardt::Linearised;
use super::rows::{freedom, parts};
use super::simulator::coloured_factor;
use crate::batch::Triangle;
use crate::error::{IdentificationError, Result};
use crate::structure::Problem;
use planesman_record::Run;

/// Maximum number of blocks, and minimum number of rows for each.
const BLOCKS: usize = 60;
const ROWS_PER_BLOCK: usize = 10;

/// The output's change after a unit step of the input, without a model.
#[derive(Clone, Debug, PartialEq)]
pub struct StepResponse {
    /// For each block the samples from the step to its end, the response there, and its standard deviation, output unit per input unit.
    pub points: Vec<(usize, f64, f64)>,
}

impl StepResponse {
    /// Estimates the response from the runs of a problem (not from its structure), over `length` samples from the step on. Runs of at most `length`
    /// samples are ignored.
    ///
    /// # Errors
    /// [`IdentificationError`], if the runs are too short for the length, or do not determine the response.
    pub fn new(problem: &Problem<'_>, length: usize) -> Result<Self> {
        let part = problem.part();
        let runs = &part.as_ref().unwrap_or(problem).runs;
        let runs: Vec<&Run<'_>> = (runs.iter())
            .filter(|run| run.outputs.len() > length)
            .collect();
        let rows: usize = runs.iter().map(|run| run.outputs.len() - length).sum();
        let most = BLOCKS.min(rows / ROWS_PER_BLOCK);
        if length == 0 || most == 0 {
            return Err(IdentificationError::Record(format!(
                "{rows} rows of the regression do not determine a response of {length} samples"
            )));
        }
        let width = length.div_ceil(most);
        let blocks = length / width;
        let mut phi = DMatrix::zeros(rows, blocks + runs.len());
        let mut outputs = DVector::zeros(rows);
        let mut row = 0;
        for (r, run) in runs.iter().enumerate() {
            // About its mean: the sums lose nothing of a small change to a large level.
            let level = run.inputs.iter().sum::<f64>() / run.inputs.len() as f64;
            let mut sums = vec![0.0];
            for input in run.inputs {
                sums.push(sums[sums.len() - 1] + input - level);
            }
            for k in length..run.outputs.len() {
                for block in 0..blocks {
                    let newest = k + 1 - block * width;
                    phi[(row, block)] = sums[newest] - sums[newest - width];
                }
                phi[(row, blocks + r)] = 1.0;
                outputs[row] = run.outputs[k];
                row += 1;
            }
        }
        let triangle = Triangle::new(&phi, &outputs)?;
        let theta = triangle.solution()?;
        let variance = triangle.cost / freedom(triangle.rows, theta.len())?;
        let errors = outputs - &phi * &theta;
        let lengths = runs.iter().map(|run| run.outputs.len() - length);
        let residuals = parts(errors.as_slice(), lengths);
        let at = Linearised {
            errors,
            slopes: phi,
        };
        let factor = coloured_factor(&at, &residuals, variance)?;
        let ends = (1..=blocks).map(|count| {
            let value = theta.rows(0, count).sum();
            let deviation = factor.rows(0, count).row_sum().norm();
            let size = width as f64;
            (count * width - 1, size * value, size * deviation)
        });
        Ok(Self {
            points: ends.collect(),
        })
    }
}
