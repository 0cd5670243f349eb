//! Identifies models from data: the computations of `planesman sysid` as a library, without command line and output.
//!
//! ```text
//! FitOptions     -> fit     -> FitResult     CompareOptions -> compare -> Comparison
//! SamplesOptions -> samples -> every sample  DataOptions    -> survey  -> Survey
//! ```
//! - [`FitOptions`], [`DataOptions`]: plain values with defaults. [`fit`] refuses conflicting options ([`FitError`]).
//! - [`FitData`]: the data of a fit, read once for several models.
//! - [`FitResult`]: the model with its verdict. [`model_file`]: the model as a file that other programs load. [`Simulated`]: the model
//!   simulated on its data.
//! - [`fit_continuous`]: a transfer function in s, fitted at the original stamps.
//! - [`fit_equations`]: user-defined state equations, fitted at the original stamps.
//! - [`fit_several`], [`compare_several`]: the same for several inputs and outputs.
//! - [`Comparison`], [`Compared`]: model files from any source, validated on data.
//! - [`declaration`]: the options, each declared once for the library and its front ends.
//! - [`rules`]: the allowed values of options.
//!
//! Each function reports to a [`Progress`](planesman_parallel::Progress), which may be `()`, and can be cancelled at its stop points
//! ([`until_stopped`](planesman_parallel::until_stopped)).
//!
//! ```
//! use planesman_fit::{DataOptions, FitOptions, SignalOptions, StructureOptions, fit};
//! // y[k] = 0.9 y[k-1] + 0.2 u[k-1], a sample every 0.1 s.
//! let u: Vec<f64> = (0..400).map(|k| f64::from(u8::from(k / 15 % 2 == 0)) + 0.1 * f64::from(k).sin()).collect();
//! let mut y = vec![0.0];
//! for k in 1..400 {
//!     y.push(0.9 * y[k - 1] + 0.2 * u[k - 1]);
//! }
//! let mut data = DataOptions::columns(vec![("u".to_owned(), u), ("y".to_owned(), y)]);
//! data.sample_time = Some(0.1);
//! let options = FitOptions {
//!     signals: SignalOptions { data, input: "u".to_owned(), output: "y".to_owned(), ..Default::default() },
//!     structure: StructureOptions { order: Some(1), ..Default::default() },
//!     ..Default::default()
//! };
//! let found = fit(&options, &())?;
//! assert!((found.analysis.model().a[0] + 0.9).abs() < 1e-6);
//! # Ok::<(), planesman_fit::FitError>(())
//! ```

mod compare;
mod continuous;
mod data;
pub mod declaration;
mod equations;
mod error;
mod fit;
pub mod model_file;
mod options;
mod record;
mod response;
pub mod rules;
mod samples;
mod several;
mod simulated;
mod stamped;
mod steps_in_words;
mod suggestion;
mod survey;
mod trial;

pub use compare::{
    CompareOptions, Compared, Comparison, Response, compare, frequency_response,
    frequency_responses,
};
pub use continuous::{ContinuousResult, fit_continuous};
pub use data::{Columns, DataOptions, Sources};
pub use equations::{EquationsResult, fit_equations};
pub use error::FitError;
pub use fit::{FitData, FitResult, fit};
pub use options::{
    FitOptions, GridOptions, KnownVehicle, MethodChoice, PreparationOptions, RecursionOptions,
    SignalOptions, StructureOptions, Validation, VehicleOptions,
};
pub use planesman_equations::EquationsFile;
pub use planesman_signals::is_data;
pub use samples::{SamplesOptions, samples};
pub use several::{
    SeveralCompared, SeveralComparison, SeveralResult, compare_several, fit_several,
};
pub use simulated::Simulated;
pub use stamped::StampedRuns;
pub use survey::{FieldSurvey, SPARKS, Survey, TopicSurvey, survey};
pub use trial::{Trial, compared, order, ranked};
