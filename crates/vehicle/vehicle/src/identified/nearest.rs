//! The pitch equation that fits a transfer function best, with known heave, minimizes
//!
//! ```text
//! sum |G(z_i) - G_file(z_i)|^2 / (sigma_i^2 + (0.01 |G_file(z_i)|)^2)  ->  min       z_i = exp(j omega_i T)
//! ```
//! over the frequencies at which the file's response is certain; `sigma_i` is its standard deviation. (Indirect prediction error on
//! frequencies: Soderstrom, Stoica, Friedlander, *Automatica* 27, 1991.)

use nalgebra::DVector;
use planesman_linear::{Complex, ComplexFunctions as _, DMatrix, StateSpace, polynomial};
use planesman_model_file::ModelFile;

use super::{
    error::{Error, FREQUENCIES, KNOWN, POOR},
    target::Target,
};
use crate::{
    Vehicle,
    linearised::{self, Output},
};

/// Lowest and highest compared frequency as shares of the Nyquist frequency `pi / T`: periods of 2000 and of 10 samples.
const COMPARED: [f64; 2] = [1e-3, 0.2];

/// Smallest number of known responses for three parameters.
const FEWEST: usize = 10;

/// Smallest relative standard deviation of a response.
const TRUEST: f64 = 0.01;

/// Largest number of iterations; every search has converged long before.
const ROUNDS: usize = 50;

/// Largest number of halvings of a step.
const HALVINGS: i32 = 20;

/// Relative change for a numerical slope.
const NUDGE: f64 = 1e-5;

/// `kappa`, `beta` and `mu`.
type Pitch = [f64; 3];

/// A known response of the file.
struct Response {
    /// `omega`, rad/s.
    frequency: f64,
    /// `z = exp(j omega T)`.
    z: Complex<f64>,
    value: Complex<f64>,
    /// `sigma`, standard deviation of real and imaginary part together.
    deviation: f64,
}

/// Responses of the file whose relative deviation is at most [`KNOWN`], with the slopes of `G = B/A`: `dG/da_i = -G z^(n-i) / A` and
/// `dG/db_j = z^(n-j) / A`.
fn known_responses(model: &ModelFile) -> Vec<Response> {
    let nyquist = std::f64::consts::PI / model.sample_time;
    let [lowest, highest] = COMPARED.map(|share| libm::log(share * nyquist));
    let n = model.order();
    let at = |i: usize| {
        let along = i as f64 / (FREQUENCIES - 1) as f64;
        let frequency = libm::exp(lowest + along * (highest - lowest));
        let z = (Complex::new(0.0, frequency * model.sample_time)).exp();
        let a = polynomial::evaluate(&model.den, z);
        let value = polynomial::evaluate(&model.num, z) / a;
        let power = |i: usize| z.powi((n - 1 - i) as i32) / a;
        let slopes: Vec<Complex<f64>> = (0..n)
            .map(|i| -value * power(i))
            .chain((0..n).map(power))
            .collect();
        let spread = |left: &Complex<f64>, row: &[f64]| -> f64 {
            let pairs = row.iter().zip(&slopes);
            pairs.map(|(p, right)| p * (left.conj() * right).re).sum()
        };
        let variance: f64 = slopes
            .iter()
            .zip(&model.covariance)
            .map(|(left, row)| spread(left, row))
            .sum();
        Response {
            frequency,
            z,
            value,
            deviation: variance.max(0.0).sqrt(),
        }
    };
    (0..FREQUENCIES)
        .map(at)
        .filter(|it| it.value.modulus() > 0.0 && it.deviation <= KNOWN * it.value.modulus())
        .collect()
}

/// The pitch equation that fits the file's transfer function best.
pub(super) fn nearest(
    base: &Vehicle,
    model: &ModelFile,
    output: Output,
    speed: f64,
) -> Result<Target, Error> {
    let known = known_responses(model);
    if known.len() < FEWEST {
        return Err(Error::Uncertain { known: known.len() });
    }
    let target = |pitch: Pitch| Target {
        speed,
        pitch,
        to_pitch: None,
        heave: None,
    };
    // The real and imaginary parts of what a vehicle is off, by response, each times a weight.
    let off = |pitch: Pitch, weight: fn(&Response) -> f64| -> Result<DVector<f64>, Error> {
        let vehicle = target(pitch).reached_from(base)?;
        let response =
            linearised::response(&vehicle.derivatives(speed), output).and_then(|it| {
                it.zero_order_hold(model.sample_time)?
                    .transfer_function(0, 0)
            })?;
        let parts = known.iter().flat_map(|it| {
            let off = (response.value_at(it.z) - it.value) * weight(it);
            [off.re, off.im]
        });
        Ok(DVector::from_iterator(2 * known.len(), parts))
    };
    let weighted = |pitch| {
        off(pitch, |it| {
            1.0 / libm::hypot(it.deviation, TRUEST * it.value.modulus())
        })
    };
    let start = first_guess(base, model, output, speed, &known)?;
    let pitch = least_squares(start, weighted)?;
    let relative = off(pitch, |it| 1.0 / it.value.modulus())?;
    let error = relative.norm() / (known.len() as f64).sqrt();
    if error.is_nan() || error > POOR {
        return Err(Error::Unlike {
            base: base.name.clone(),
            speed,
            error,
            frequencies: [known[0].frequency, known[known.len() - 1].frequency],
        });
    }
    Ok(target(pitch))
}

/// Start values: the pitch equation is linear in `kappa`, `beta` and `mu` if `q(s)`, and so `w(s)`, are known,
///
/// ```text
/// s q - nu w = kappa - beta q - mu q / s        w = ((a_wq + a_wtheta / s) q + epsilon) / (s - a_ww)
/// ```
/// with `q(s)` from the sampled response, divided by the hold `(1 - exp(-s T)) / (s T)`.
fn first_guess(
    base: &Vehicle,
    model: &ModelFile,
    output: Output,
    speed: f64,
    known: &[Response],
) -> Result<Pitch, Error> {
    let StateSpace { a, b, .. } = linearised::state_space(base, speed)?;
    let mut rows = Vec::with_capacity(6 * known.len());
    let mut right = Vec::with_capacity(2 * known.len());
    for it in known {
        let s = Complex::new(0.0, it.frequency);
        let hold = (1.0 - it.z.inv()) / (s * model.sample_time);
        let per_rate = if output == Output::Pitch {
            s
        } else {
            1.0.into()
        };
        let q = it.value / hold * per_rate;
        let w = ((a[(0, 1)] + a[(0, 2)] / s) * q + b[(0, 0)]) / (s - a[(0, 0)]);
        let scale = (s * q).modulus();
        let row = [1.0.into(), -q, -q / s].map(|it: Complex<f64>| it / scale);
        let sum = (s * q - a[(1, 0)] * w) / scale;
        rows.extend(row.map(|it| it.re));
        rows.extend(row.map(|it| it.im));
        right.extend([sum.re, sum.im]);
    }
    let rows = DMatrix::from_row_slice(right.len(), 3, &rows);
    solved(rows, &DVector::from_vec(right))
}

/// Least squares of `errors` from `start` on by Gauss-Newton steps, each halved until it decreases the sum. This search is separate from the search
/// in `planesman_identification`: this crate does not depend on identification, here the error may be undefined, and derivatives are differences.
fn least_squares(
    start: Pitch,
    errors: impl Fn(Pitch) -> Result<DVector<f64>, Error>,
) -> Result<Pitch, Error> {
    let mut x = start;
    let mut at = errors(x)?;
    for _ in 0..ROUNDS {
        let mut slopes = DMatrix::zeros(at.len(), 3);
        for i in 0..3 {
            let by = NUDGE * x[i].abs().max(NUDGE);
            let moved = |by: f64| {
                let mut x = x;
                x[i] += by;
                errors(x)
            };
            slopes.set_column(i, &((moved(by)? - moved(-by)?) / (2.0 * by)));
        }
        let step = solved(slopes, &at)?;
        let better = (0..HALVINGS).find_map(|halved| {
            let share = 0.5_f64.powi(halved);
            let there = [0, 1, 2].map(|i| x[i] - share * step[i]);
            let errors = errors(there).ok()?;
            (errors.norm() < at.norm()).then_some((there, errors))
        });
        match better {
            Some(found) => (x, at) = found,
            None => break,
        }
    }
    Ok(x)
}

/// Least-squares solution of `rows x = right`; values that are not finite are refused, since the decomposition would not end.
fn solved(rows: DMatrix<f64>, right: &DVector<f64>) -> Result<Pitch, Error> {
    if !rows.iter().chain(right).all(|it| it.is_finite()) {
        return Err(Error::Undetermined);
    }
    let solution = rows
        .svd(true, true)
        .solve(right, f64::EPSILON)
        .map_err(|_| Error::Undetermined)?;
    let found = [solution[0], solution[1], solution[2]];
    let finite = found.iter().all(|it| it.is_finite());
    finite.then_some(found).ok_or(Error::Undetermined)
}
