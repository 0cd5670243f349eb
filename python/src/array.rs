//! Numbers as numpy arrays, moved instead of copied.
//!
//! The numbers reach numpy by its array interface, so that this crate needs neither numpy's headers nor the crate
//! `numpy`. The crate `numpy` changes the features of nalgebra's dependencies, so that a wheel would rebuild nearly everything that the release
//! build has built (times in CONTRIBUTING.md).

use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An element type of arrays.
pub(crate) trait Number: Send + Sync + 'static {
    /// The name of the type in numpy, without the byte order.
    const KIND: &'static str;
}

impl Number for f64 {
    const KIND: &'static str = "f8";
}

impl Number for f32 {
    const KIND: &'static str = "f4";
}

impl Number for u8 {
    const KIND: &'static str = "u1";
}

impl Number for i64 {
    const KIND: &'static str = "i8";
}

/// Real and imaginary part.
impl Number for [f64; 2] {
    const KIND: &'static str = "c16";
}

/// Owner of the numbers of an array. The array keeps the owner alive, and Python may change the numbers.
#[pyclass(frozen, module = "planesman._native")]
struct Owner {
    _numbers: Box<dyn Send + Sync>,
    address: usize,
    length: usize,
    kind: &'static str,
}

#[pymethods]
impl Owner {
    /// <https://numpy.org/doc/stable/reference/arrays.interface.html>
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let order = if cfg!(target_endian = "big") {
            ">"
        } else {
            "<"
        };
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("typestr", format!("{order}{}", self.kind))?;
        interface.set_item("shape", (self.length,))?;
        interface.set_item("data", (self.address, false))?;
        Ok(interface)
    }
}

/// Turns the numbers into a numpy array of one dimension.
pub(crate) fn array<N: Number>(py: Python<'_>, mut numbers: Vec<N>) -> PyResult<Bound<'_, PyAny>> {
    let owner = Owner {
        address: numbers.as_mut_ptr().expose_provenance(),
        length: numbers.len(),
        kind: N::KIND,
        _numbers: Box::new(numbers),
    };
    py.import("numpy")?
        .call_method1("asarray", (Bound::new(py, owner)?,))
}

/// Reads the numbers of a float64 array from its bytes (`tobytes`).
pub(crate) fn numbers(bytes: &[u8]) -> Vec<f64> {
    let (each, _) = bytes.as_chunks();
    each.iter().map(|it| f64::from_ne_bytes(*it)).collect()
}
