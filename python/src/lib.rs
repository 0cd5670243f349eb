//! The native half of the Python package `planesman`. Users import the Python part, in the folder `planesman/` next to this one.
//!
//! The functions have the options of the Rust libraries, so that names, defaults, units, checks and errors equal those of the program; the Python
//! part adds types and docstrings.
//!
//! - `data`: signals and fields of a bag, table or log.
//! - `flight`: scenarios, and their simulation in this process.
//! - `gym`: environments for reinforcement learning.
//! - `model`: identification, model files, transfer functions of vehicles.
//! - `options`: keyword arguments as options of fits and of their data.
//! - `sweep`: the cases of a sweep, part by part.
//! - `listing`: parameters of the nodes, numbers of the reports.
//! - `array`: numbers as numpy arrays.
//! - `error`: errors as Python exceptions; work that Ctrl-C can stop.
//!
//! The interpreter is released during all work, while Ctrl-C is checked. Returned arrays are moved; arrays from Python
//! are copied, since other threads may change them during the work.

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
    /// Sets the wording of messages: options are named as Python keywords.
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
