//! Errors of linear algebra.

/// The reason why a linear system or polynomial could not be built or solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// An empty list or matrix.
    #[error("{what} is empty")]
    Empty {
        /// Name of the list or matrix.
        what: &'static str,
    },
    /// A NaN or an infinity in the input or the result.
    #[error("{what} contains a number that is not finite")]
    NotFinite {
        /// Name of the list, matrix or number.
        what: &'static str,
    },
    /// The coefficient of the highest power is zero.
    #[error("the leading coefficient of {what} is zero")]
    LeadingZero {
        /// Name of the polynomial.
        what: &'static str,
    },
    /// Incompatible sizes.
    #[error("{what} is {found}, {expected} is needed")]
    Shape {
        /// Name of the list or matrix.
        what: &'static str,
        /// The size found.
        found: String,
        /// The required size.
        expected: String,
    },
    /// A number that must be positive.
    #[error("{what} must be above zero, but is {value}")]
    NotPositive {
        /// Name of the number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A numerator of higher degree than the denominator, for which the output would need future inputs.
    #[error(
        "the numerator's degree {numerator} is higher than the denominator's degree {denominator}"
    )]
    Improper {
        /// Degree of the numerator.
        numerator: usize,
        /// Degree of the denominator.
        denominator: usize,
    },
    /// A pole at the point of the steady-state gain.
    #[error("there is no steady-state gain: the system integrates a constant input")]
    NoSteadyGain,
    /// The eigenvalue iteration did not end.
    #[error("the eigenvalues of a {size} x {size} matrix did not converge")]
    NoConvergence {
        /// Number of the matrix's rows.
        size: usize,
    },
}

/// Checks that all numbers are finite.
pub(crate) fn finite<'a>(
    what: &'static str,
    numbers: impl IntoIterator<Item = &'a f64>,
) -> Result<(), Error> {
    if numbers.into_iter().all(|x| x.is_finite()) {
        Ok(())
    } else {
        Err(Error::NotFinite { what })
    }
}
