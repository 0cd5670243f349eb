//! The estimate in a message.

use nalgebra::{DMatrix, DVector};
use planesman_identification::Layout;
use planesman_identification::Structure;
use planesman_identification::estimators::{Error, Estimate};
use planesman_msgs::planesman_msgs::msg::ModelEstimate;

/// The estimate in a message; `None` if its covariance does not match its coefficients.
#[must_use]
pub fn estimate_of(model: &ModelEstimate) -> Option<Estimate> {
    let n = model.a.len();
    let width = model.covariance.len().isqrt();
    let sound = width * width == model.covariance.len() && width >= 2 * n && model.b.len() == n;
    if n == 0 || !sound {
        return None;
    }
    let all = DMatrix::from_row_slice(width, width, &model.covariance);
    Some(Estimate {
        error: Error::Equation,
        layout: Layout {
            structure: Structure::of_order(n).without_offset(),
            runs: 1,
        },
        sample_time: model.sample_time,
        theta: DVector::from_iterator(2 * n, model.a.iter().chain(&model.b).copied()),
        covariance: all.view((0, 0), (2 * n, 2 * n)).into_owned(),
        noise_variance: model.noise_variance,
        noise_model: Vec::new(),
        factor: None,
        noise_denominator: Vec::new(),
        input_level: 0.0,
        residuals: Vec::new(),
        output_curve: None,
        physical: None,
        process: None,
        frequency: None,
    })
}
