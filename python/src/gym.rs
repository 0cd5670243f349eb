//! Environments for reinforcement learning, stepped together.

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
    /// Works on them with the interpreter released.
    fn with<T: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Inner) -> T + Send) -> T {
        py.detach(|| work(&mut self.inner.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

#[pymethods]
impl Environments {
    /// `options` are those of the library, as JSON.
    #[new]
    fn new(py: Python<'_>, options: &str, count: usize, seed: u64) -> PyResult<Self> {
        let options: Options = serde_json::from_str(options).map_err(raised)?;
        let inner = py.detach(|| Inner::new(&options, count, seed));
        Ok(Self {
            inner: Mutex::new(inner.map_err(raised)?),
        })
    }

    /// Name, unit, bound and deviation of each number that is observed.
    fn quantities(&self, py: Python<'_>) -> Vec<(&'static str, &'static str, f64, f64)> {
        let quantities = self.with(py, |it| it.task().quantities());
        let fields = quantities
            .iter()
            .map(|it| (it.name, it.unit, it.bound, it.deviation));
        fields.collect()
    }

    /// Name of what each action moves, and its value at -1 and at 1.
    fn actions(&self, py: Python<'_>) -> Vec<(String, [f64; 2])> {
        self.with(py, |it| it.actions().to_vec())
    }

    /// Begins episodes; the observations, one after the other.
    fn reset<'py>(&self, py: Python<'py>, seeds: Option<Vec<u64>>) -> PyResult<Bound<'py, PyAny>> {
        let seen = self.with(py, |it| it.reset(seeds.as_deref()));
        array(py, seen.map_err(raised)?)
    }

    /// A step by the actions, float32 one after the other. An outcome is 0 while the episode goes on, 1 on success, 2 on failure, 3 when its time is up.
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

    /// The states, 13 numbers each, one after the other.
    fn states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.with(py, |it| {
            let rows = (0..it.len()).flat_map(|k| it.state(k).row());
            rows.collect::<Vec<f64>>()
        });
        array(py, rows)
    }

    /// The factors of each one's vehicle, one after the other.
    fn factors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = self.with(py, |it| {
            let rows = (0..it.len()).flat_map(|k| it.factors(k).iter().copied());
            rows.collect::<Vec<f64>>()
        });
        array(py, rows)
    }
}
