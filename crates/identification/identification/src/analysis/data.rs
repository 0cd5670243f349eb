//! The data as used for a fit: in a closed loop, with the part of the input that the reference causes.

use std::borrow::Cow;

use planesman_record::Record;

use super::Options;
use super::curve::problem;
use crate::error::Result;
use crate::estimators::{LeastSquares, Method, TwoStages};
use crate::structure::{Problem, Structure};
use crate::validation::identifiability::{Following, following};

/// A record with the choices that follow from the options.
pub(super) struct Data<'a> {
    pub(super) record: &'a Record,
    /// The record with the structure given by the options, before a search.
    pub(super) problem: Problem<'a>,
    /// The reference of each run; empty in open loop.
    pub(super) references: Vec<&'a [f64]>,
    /// The part of each input that its reference causes; empty in open loop, and for a method that uses the references directly.
    caused: Vec<Vec<f64>>,
    /// Whether the input of the longest run follows its output.
    pub(super) following: Following,
}

impl<'a> Data<'a> {
    pub(super) fn of(record: &'a Record, options: &Options) -> Result<Self> {
        let problem = problem(record, &options.structure(options.order.unwrap_or(2)))?;
        let references = references(record);
        let caused = match references.is_empty() || options.method == Method::Frf {
            true => Vec::new(),
            false => noise_free_inputs(&problem, references.clone())?,
        };
        let mut data = Self {
            record,
            problem,
            references,
            caused,
            following: Following::No,
        };
        let second = data.on_noise_free_inputs(&data.problem);
        data.following = following(&second.runs[data.longest()]);
        Ok(data)
    }

    pub(super) fn is_in_a_loop(&self) -> bool {
        !self.references.is_empty()
    }

    /// The name of an input.
    pub(super) fn name(&self, input: usize) -> Option<String> {
        self.record.inputs.get(input).cloned()
    }

    /// The number of the longest run.
    pub(super) fn longest(&self) -> usize {
        let runs = &self.problem.runs;
        let length = |r: &usize| runs[*r].outputs.len();
        (0..runs.len()).max_by_key(length).unwrap_or_default()
    }

    /// A problem of these runs, with the input replaced by the part caused by the reference, if there is a reference.
    pub(super) fn on_noise_free_inputs<'b>(&'b self, problem: &Problem<'b>) -> Problem<'b> {
        let mut second = problem.clone();
        for (run, caused) in second.runs.iter_mut().zip(&self.caused) {
            run.inputs = caused;
        }
        second
    }
}

/// The second input of each used segment.
fn references(record: &Record) -> Vec<&[f64]> {
    let second = |number: usize| Some(record.segments[number].inputs.get(1)?.as_slice());
    record.used().into_iter().filter_map(second).collect()
}

fn noise_free_inputs(problem: &Problem<'_>, references: Vec<&[f64]>) -> Result<Vec<Vec<f64>>> {
    let staged = TwoStages {
        second: &LeastSquares,
        references,
    };
    staged.noise_free_inputs(problem)
}

/// A record whose second input is the reference of a loop; returns the part of the first input caused by the reference.
pub(super) fn caused_by_reference(record: &Record) -> Result<Cow<'_, Record>> {
    let numbers = record.used();
    let references = references(record);
    if references.len() < numbers.len() || record.runs().is_none() {
        return Ok(Cow::Borrowed(record));
    }
    let caused = noise_free_inputs(&problem(record, &Structure::of_order(1))?, references)?;
    let mut record = record.clone();
    for (number, caused) in numbers.into_iter().zip(caused) {
        record.segments[number].inputs[0] = caused;
    }
    Ok(Cow::Owned(record))
}
