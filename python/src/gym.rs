//! Environments for reinforcement learning that are stepped together.

use std::sync::{Mutex, PoisonError};

use planesman_gym::{Environments as Inner, Options, Outcome, Stepped};
use pyo3::prelude::*;

use crate::array::array;
use crate::error::raised;

/// Observations, rewards, outcomes.
type Arrays<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Environments of one task.
#[pyclass(frozen, module = "planesman._native")]
pub(crate) struct Environments {
    inner: Mutex<Inner>,
}

impl Environments {
    /// Calls `work` with the environments while the interpreter is released.
    fn with<T: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Inner) -> T + Send) -> T {
        py.detach(|| work(&mut self.inner.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

#[pymethods]
impl Environments {
    /// `options`: the options of the library as JSON.
    #[new]
    fn new(py: Python<'_>, options: &str, count: usize, seed: u64) -> PyResult<Self> {
        let options: Options = serde_json::from_str(options).map_err(raised)?;
        let inner = py.detach(|| Inner::new(&options, count, seed));
        Ok(Self {
            inner: Mutex::new(inner.map_err(raised)?),
        })
    }

    /// Name, unit, bound and standard deviation of each observed number.
    fn quantities(&self, py: Python<'_>) -> Vec<(&'static str, &'static str, f64, f64)> {
        let quantities = self.with(py, |it| it.task().quantities());
        let fields = quantities
            .iter()
            .map(|it| (it.name, it.unit, it.bound, it.deviation));
        fields.collect()
    }

    /// The name of each actuated quantity, and its values at the actions -1 and 1.
    fn actions(&self, py: Python<'_>) -> Vec<(String, [f64; 2])> {
        self.with(py, |it| it.actions().to_vec())
    }

    /// Starts episodes and returns their observations, one environment after the other.
    fn reset<'py>(&self, py: Python<'py>, seeds: Option<Vec<u64>>) -> PyResult<Bound<'py, PyAny>> {
        let seen = self.with(py, |it| it.reset(seeds.as_deref()));
        array(py, seen.map_err(raised)?)
    }

    /// One step with the actions (float32, one environment after the other). An outcome is 0 during an episode, 1 on success, 2 on failure, 3 after the time limit.
    fn step<'py>(&self, py: Python<'py>, actions: &[u8]) -> PyResult<Arrays<'py>> {
        let (each, _) = actions.as_chunks();
        let actions: Vec<f32> = each.iter().map(|it| f32::from_ne_bytes(*it)).collect();
        let Stepped {
            observations,
            rewards,
            outcomes,
        } = self.with(py, |it| it.step(&actions)).map_err(raised)?;
        let number = |outcome| match outcome {
            Outcome::Running => 0_u8,
            Outcome::Succeeded => 1,
            Outcome::Failed => 2,
            Outcome::TimeUp => 3,
        };
        let outcomes: Vec<u8> = outcomes.into_iter().map(number).collect();
        Ok((
            array(py, observations)?,
            array(py, rewards)?,
            array(py, outcomes)?,
        ))
    }

    /// The states, 13 numbers for each environment, one after the other.
    fn states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.with(py, |it| {
            let rows = (0..it.len()).flat_map(|k| it.state(k).row());
            rows.collect::<Vec<f64>>()
        });
        array(py, rows)
    }

    /// The factors on the coefficients of each environment's vehicle, one after the other.
    fn factors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.with(py, |it| {
            let rows = (0..it.len()).flat_map(|k| it.factors(k).iter().copied());
            rows.collect::<Vec<f64>>()
        });
        array(py, rows)
    }
}
