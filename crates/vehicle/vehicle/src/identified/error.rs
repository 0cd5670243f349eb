//! Why no vehicle is made of an identified model.

/// Frequencies that are compared, evenly spaced in their logarithm.
pub(super) const FREQUENCIES: usize = 60;

/// The largest relative standard deviation of a response that counts as known.
pub(super) const KNOWN: f64 = 0.25;

/// The largest root mean square of the relative error at which a vehicle still is the model's.
pub(super) const POOR: f64 = 0.2;

/// Why no vehicle is made of an identified model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The model is of other signals than dive planes and pitch or pitch rate.
    #[error(
        "it goes from '{input}' to '{output}'; a vehicle is made of a model from plane_motion:dive_planes \
         (rad) to state:pitch_rate (rad/s) or state:pitch (rad)"
    )]
    Signals {
        /// Its input.
        input: String,
        /// Its output.
        output: String,
    },
    /// The file does not state the speed it was identified at.
    #[error(transparent)]
    Speed(#[from] planesman_model_file::Refusal),
    /// Too few frequencies at which the model is certain.
    #[error(
        "it knows its own response to {:.0} % at {known} of {FREQUENCIES} frequencies only", 100.0 * KNOWN
    )]
    Uncertain {
        /// The frequencies at which it is.
        known: usize,
    },
    /// The model's response determines no pitch equation.
    #[error("its response determines no pitch equation")]
    Undetermined,
    /// The nearest vehicle is not like the model.
    #[error(
        "no vehicle with the heave of '{base}' is like it: at {speed} m/s the nearest is off by {:.0} % \
         (root mean square, {:.2} to {:.1} rad/s), {:.0} % are taken",
        100.0 * error, frequencies[0], frequencies[1], 100.0 * POOR
    )]
    Unlike {
        /// The base vehicle.
        base: String,
        /// The model's speed, m/s.
        speed: f64,
        /// The root mean square of the relative error.
        error: f64,
        /// The lowest and highest frequency compared, rad/s.
        frequencies: [f64; 2],
    },
    /// No coefficients give the model's pitch equation.
    #[error(
        "no coefficients of vehicle '{base}' give this pitch equation about level flight at {speed} m/s"
    )]
    Unreachable {
        /// The base vehicle.
        base: String,
        /// The model's speed, m/s.
        speed: f64,
    },
    /// A coefficient would make the vehicle unstable by itself.
    #[error("{coefficient} is below zero: the vehicle would {consequence}")]
    Unstable {
        /// Its symbol.
        coefficient: &'static str,
        /// The motion that would follow.
        consequence: &'static str,
    },
    /// The vehicle's numbers overflow.
    #[error(transparent)]
    Linear(#[from] planesman_linear::Error),
}
