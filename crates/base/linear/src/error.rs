//! Errors of the linear algebra.

/// Why a linear system or polynomial could not be built or solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// There is nothing to work on.
    #[error("{what} is empty")]
    Empty {
        /// The list or matrix.
        what: &'static str,
    },
    /// A NaN or an infinity, given or arrived at.
    #[error("{what} holds a number that is not finite")]
    NotFinite {
        /// The list, matrix or number.
        what: &'static str,
    },
    /// The coefficient of the highest power is zero, so the degree is not what it seems.
    #[error("the leading coefficient of {what} is zero")]
    LeadingZero {
        /// The polynomial.
        what: &'static str,
    },
    /// Sizes that do not belong together.
    #[error("{what} is {found}, {expected} is needed")]
    Shape {
        /// The list or matrix.
        what: &'static str,
        /// The size found.
        found: String,
        /// The size that fits the rest.
        expected: String,
    },
    /// A number that must be above zero.
    #[error("{what} must be above zero, {value} is not")]
    NotPositive {
        /// The number's name.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A numerator of higher degree than the denominator: the output would need future inputs.
    #[error("the numerator's degree {numerator} is above the denominator's {denominator}")]
    Improper {
        /// The numerator's degree.
        numerator: usize,
        /// The denominator's degree.
        denominator: usize,
    },
    /// The system has a pole exactly where its gain is asked for.
    #[error("there is no steady-state gain: the system integrates a constant input")]
    NoSteadyGain,
    /// The eigenvalue iteration did not end.
    #[error("the eigenvalues of a {size} x {size} matrix did not converge")]
    NoConvergence {
        /// The matrix' rows.
        size: usize,
    },
}

/// Refuses numbers that are not finite.
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
