//! Identification in a closed loop by two stages (Van den Hof and Schrama, *Automatica* 29, 1993).
//!
//! Feedback brings the output's noise into the input, which biases methods that assume the two to be independent. The reference has no such
//! noise. First the part of the input that the reference causes is estimated by least squares on the reference's past,
//! ```text
//! u = S r + v,   S = s0 + s1 q^-1 + ... + sL q^-L,   u_r = S r
//! ```
//! then the plant from `u_r` to the output. L is doubled as long as Akaike's criterion falls: a term too many adds little variance, a term
//! too few leaves a part of the input to the noise. The alternative is the direct method: a method with a noise model on the original input
//! and output.

use super::estimate::Estimate;
use super::estimator::{Estimator, Recursive};
use super::least_squares::LeastSquares;
use crate::error::{IdentificationError, Result};
use crate::structure::{Problem, Structure};
use planesman_record::{Run, filter};

/// Minimum and maximum number of terms in the first stage.
const TERMS: std::ops::RangeInclusive<usize> = 8..=256;

/// Minimum number of rows in the first stage for each term.
const ROWS_PER_TERM: usize = 5;

/// An estimator applied to the effect of references.
#[derive(Debug)]
pub struct TwoStages<'a> {
    /// The estimator of the second stage.
    pub second: &'a dyn Estimator,
    /// The reference of each record, over the same intervals as the inputs; for a record that is the first part of another, it may be
    /// longer.
    pub references: Vec<&'a [f64]>,
}

impl TwoStages<'_> {
    /// The part of each record's input that its reference causes.
    ///
    /// # Errors
    /// [`IdentificationError`], if a reference is shorter than its record, or determines nothing.
    pub fn noise_free_inputs(&self, problem: &Problem<'_>) -> Result<Vec<Vec<f64>>> {
        if self.references.len() != problem.runs.len() {
            return Err(IdentificationError::Record(
                "every record needs a reference".to_owned(),
            ));
        }
        let ahead = self
            .references
            .iter()
            .zip(&problem.runs)
            .map(|(reference, run)| shifted(reference, run.inputs.len()))
            .collect::<Result<Vec<_>>>()?;
        let runs = ahead.iter().zip(&problem.runs).map(|(ahead, run)| Run {
            inputs: ahead,
            outputs: run.inputs,
            ..Run::default()
        });
        let whole = Problem {
            structure: Structure::of_order(0),
            sample_time: problem.sample_time,
            runs: runs.collect(),
        };
        let response = response(whole.part().unwrap_or(whole))?;
        let caused = ahead.iter().zip(&problem.runs).map(|(ahead, run)| {
            // The reference is taken to have stood before the record as it begins.
            let before = ahead.first().map(|r| vec![*r; response.len()]);
            let all = [before.unwrap_or_default(), ahead.clone()].concat();
            let mut caused = filter(&response, &[1.0], &all).split_off(response.len());
            let apart = run.inputs.iter().zip(&caused).map(|(u, caused)| u - caused);
            let level = apart.sum::<f64>() / run.inputs.len().max(1) as f64;
            caused.iter_mut().for_each(|u| *u += level);
            caused
        });
        Ok(caused.collect())
    }

    fn fit_plant_on_noise_free_input<T>(
        &self,
        problem: &Problem<'_>,
        estimate: impl FnOnce(&Problem<'_>) -> Result<T>,
    ) -> Result<T> {
        let caused = self.noise_free_inputs(problem)?;
        let runs = caused.iter().zip(&problem.runs).map(|(caused, run)| Run {
            inputs: caused,
            ..*run
        });
        estimate(&Problem {
            runs: runs.collect(),
            ..problem.clone()
        })
    }
}

impl Estimator for TwoStages<'_> {
    fn fit(&self, problem: &Problem<'_>) -> Result<Estimate> {
        self.fit_plant_on_noise_free_input(problem, |problem| self.second.fit(problem))
    }

    fn learner(&self, problem: &Problem<'_>) -> Result<Box<dyn Recursive>> {
        self.fit_plant_on_noise_free_input(problem, |problem| self.second.learner(problem))
    }
}

/// The input responds to the reference at once: S includes the current sample. Shifted by one sample, S becomes a model with a delay of one sample.
fn shifted(reference: &[f64], count: usize) -> Result<Vec<f64>> {
    if reference.len() < count {
        return Err(IdentificationError::Record(format!(
            "the reference has {} samples, but the input has {count}",
            reference.len()
        )));
    }
    let mut ahead = reference.get(1..count).unwrap_or_default().to_vec();
    ahead.extend(reference[..count].last());
    Ok(ahead)
}

/// `0, s0 ... sL` of `u = S r`, with the reference one sample ahead.
fn response(mut problem: Problem<'_>) -> Result<Vec<f64>> {
    let rows: usize = problem.runs.iter().map(|run| run.outputs.len()).sum();
    let mut best: Option<(f64, Estimate)> = None;
    let mut terms = *TERMS.start();
    while terms <= *TERMS.end() && terms * ROWS_PER_TERM <= rows {
        problem.structure.numerator = terms;
        let found = LeastSquares
            .fit(&problem)
            .map_err(|reason| IdentificationError::FirstStage(Box::new(reason)))?;
        let criterion = akaike(&found);
        if best.as_ref().is_some_and(|(least, _)| *least <= criterion) {
            break;
        }
        best = Some((criterion, found));
        terms *= 2;
    }
    let (_, found) = best.ok_or(IdentificationError::Undetermined(
        "the records are too short for two stages",
    ))?;
    let mut response = vec![0.0];
    response.extend(&found.theta.as_slice()[found.layout.b(0)]);
    Ok(response)
}

/// `N ln V + 2 p` for each row.
fn akaike(found: &Estimate) -> f64 {
    let residuals = || found.residuals.iter().flatten();
    let rows = residuals().count() as f64;
    let mean = residuals().map(|e| e * e).sum::<f64>() / rows;
    libm::log(mean.max(f64::MIN_POSITIVE)) + 2.0 * found.theta.len() as f64 / rows
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimators::OutputError;
    use planesman_record::noise;

    /// y = 0.2 q^-1 / (1 - 0.9 q^-1) u + v, u = r - 2 y, v strong and slow.
    fn closed_loop(seed: u32) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let (r, e) = (noise(seed, 4000), noise(seed + 77, 4000));
        let (mut u, mut y) = (Vec::<f64>::new(), Vec::<f64>::new());
        let (mut x, mut v) = (0.0, 0.0);
        for k in 0..r.len() {
            x = 0.9 * x + u.last().map_or(0.0, |u| 0.2 * u);
            v = 0.8 * v + e[k];
            y.push(x + v);
            u.push(r[k] - 2.0 * y[k]);
        }
        (r, u, y)
    }

    /// Mean and standard deviation of `a1` and `b1` over records with noises of their own.
    fn estimates(find: impl Fn(&[f64], &Problem<'_>) -> Estimate) -> [(f64, f64); 2] {
        const RECORDS: u32 = 8;
        let found: Vec<Estimate> = (0..RECORDS)
            .map(|seed| {
                let (r, u, y) = closed_loop(1 + 1000 * seed);
                let run = Run {
                    inputs: &u,
                    outputs: &y,
                    ..Run::default()
                };
                find(
                    &r,
                    &Problem::new(Structure::of_order(1), 0.1, vec![run]).unwrap(),
                )
            })
            .collect();
        [0, 1].map(|i| {
            let values: Vec<f64> = found.iter().map(|it| it.theta[i]).collect();
            let mean = values.iter().sum::<f64>() / f64::from(RECORDS);
            (mean, crate::structure::variance(&values).sqrt())
        })
    }

    #[test]
    fn noise_that_went_round_the_loop_misleads_the_direct_way_and_not_the_two_stages() {
        let staged = estimates(|r, problem| {
            let two = TwoStages {
                second: &OutputError,
                references: vec![r],
            };
            two.fit(problem).unwrap()
        });
        let direct = estimates(|_, problem| OutputError.fit(problem).unwrap());
        println!("staged {staged:?}, direct {direct:?}");
        for (i, truth) in [-0.9, 0.2].into_iter().enumerate() {
            // The mean of 8 is within four of its standard deviations of the truth; the direct way's is far off.
            let off =
                |(mean, deviation): (f64, f64)| (mean - truth).abs() / (deviation / 8_f64.sqrt());
            assert!(off(staged[i]) < 4.0, "{i}: {staged:?}");
            assert!(off(direct[i]) > 6.0, "{i}: {direct:?}");
        }
    }

    #[test]
    fn a_reference_of_another_length_is_refused() {
        let (r, u, y) = closed_loop(5);
        let run = Run {
            inputs: &u,
            outputs: &y,
            ..Run::default()
        };
        let problem = Problem::new(Structure::of_order(1), 0.1, vec![run]).unwrap();
        for references in [vec![&r[..99]], vec![]] {
            let two = TwoStages {
                second: &OutputError,
                references,
            };
            assert!(two.fit(&problem).is_err());
        }
    }
}
