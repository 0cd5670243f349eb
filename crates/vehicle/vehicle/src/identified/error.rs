//! Errors in the construction of a vehicle from an identified model.

/// Number of compared frequencies, evenly spaced in their logarithm.
pub(super) const FREQUENCIES: usize = 60;

/// Largest relative standard deviation of a response that counts as known.
pub(super) const KNOWN: f64 = 0.25;

/// Largest root mean square of the relative error at which the vehicle is accepted.
pub(super) const POOR: f64 = 0.2;

/// Reason why no vehicle can be made from an identified model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The model's signals are not dive planes and pitch or pitch rate.
    #[error(
        "the model is from '{input}' to '{output}', but a vehicle needs plane_motion:dive_planes \
         (rad) to state:pitch_rate (rad/s) or state:pitch (rad)"
    )]
    Signals {
        /// Its input.
        input: String,
        /// Its output.
        output: String,
    },
    /// The file does not give the speed of the experiment.
    #[error(transparent)]
    Speed(#[from] planesman_model_file::Refusal),
    /// The model is certain at too few frequencies.
    #[error(
        "the model's response is known to {:.0} % at only {known} of {FREQUENCIES} frequencies", 100.0 * KNOWN
    )]
    Uncertain {
        /// Number of frequencies with a known response.
        known: usize,
    },
    /// The model's response does not determine a pitch equation.
    #[error("the model's response does not determine a pitch equation")]
    Undetermined,
    /// The nearest vehicle differs too much from the model.
    #[error(
        "no vehicle with the heave of '{base}' fits the model: at {speed} m/s the nearest such vehicle differs by {:.0} % (root mean square, {:.2} to {:.1} rad/s); the limit is {:.0} %",
        100.0 * error, frequencies[0], frequencies[1], 100.0 * POOR
    )]
    Unlike {
        /// Name of the base vehicle.
        base: String,
        /// Speed of the model, m/s.
        speed: f64,
        /// Root mean square of the relative error.
        error: f64,
        /// Lowest and highest compared frequency, rad/s.
        frequencies: [f64; 2],
    },
    /// No coefficients give the model's pitch equation.
    #[error(
        "no coefficients of vehicle '{base}' give this pitch equation for level flight at {speed} m/s"
    )]
    Unreachable {
        /// Name of the base vehicle.
        base: String,
        /// Speed of the model, m/s.
        speed: f64,
    },
    /// A coefficient would make the vehicle unstable.
    #[error("{coefficient} is negative: the vehicle would {consequence}")]
    Unstable {
        /// Its symbol.
        coefficient: &'static str,
        /// The resulting motion.
        consequence: &'static str,
    },
    /// The vehicle's numbers overflow.
    #[error(transparent)]
    Linear(#[from] planesman_linear::Error),
}
