//! The native half of the Python package `planesman`, which is in `planesman/` beside it and is what people import.
//!
//! Functions here take what the libraries take, so that names, defaults, units, checks and errors are those of the program; the Python
//! half gives them types and docstrings.
//!
//! - `data`: signals and fields of a bag, table or log.
//! - `flight`: scenarios, and their flight in this process.
//! - `gym`: environments for reinforcement learning.
//! - `model`: identification, model files, a vehicle's transfer functions.
//! - `options`: keywords as the options of fits and of their data.
//! - `sweep`: the cases of a sweep, part by part.
//! - `listing`: parameters of the nodes, numbers of the reports.
//! - `array`: numbers as numpy arrays.
//! - `error`: errors as Python's exceptions; work that Ctrl-C ends.
//!
//! The interpreter is released during all work, and asked for Ctrl-C meanwhile. Arrays that go out are moved; those that
//! come in are copied, since others may change them meanwhile.

mod array;
mod data;
mod error;
mod flight;
mod gym;
mod listing;
mod model;
mod options;
mod sweep;

/// The native half of planesman.
#[pyo3::pymodule]
mod _native {
    /// Messages name options as Python's keywords.
    #[pymodule_init]
    fn init(_module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        planesman_text::use_wording(planesman_text::Wording::Python);
        Ok(())
    }

    #[pymodule_export]
    use crate::data::{fields, is_data, samples};
    #[pymodule_export]
    use crate::error::PlanesmanError;
    #[pymodule_export]
    use crate::flight::{Loop, fly, scenario, states};
    #[pymodule_export]
    use crate::gym::Environments;
    #[pymodule_export]
    use crate::listing::{parameter_file, parameters};
    #[pymodule_export]
    use crate::model::{
        fit, fit_equations, fit_options, fit_several, read_model, response, transfer_function,
        write_model,
    };
    #[pymodule_export]
    use crate::sweep::Sweep;
}
