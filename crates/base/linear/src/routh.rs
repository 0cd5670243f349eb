//! Routh's criterion: number of roots of a polynomial in the right half plane, from its coefficients (Gantmacher, *The Theory of Matrices*,
//! vol. 2, ch. XV).
//!
//! ```text
//! s^n      a_0  a_2  a_4 ...
//! s^(n-1)  a_1  a_3  a_5 ...        each further row from the two above it:
//! s^(n-2)  b_1  b_2  ...            b_i = (a_1 a_(2i) - a_0 a_(2i+1)) / a_1
//! ```
//! The number of roots in the right half plane is the number of sign changes in the first column. A zero in that column means roots on the
//! imaginary axis or symmetric about 0; the scheme ends there.

use crate::{Error, polynomial::check};

/// The first column of Routh's scheme.
#[derive(Clone, Debug, PartialEq)]
pub struct RouthColumn {
    /// The first column, down to its last row or to the first zero, where the scheme ends.
    pub first: Vec<f64>,
    /// Whether the scheme is complete, without a zero before its end.
    pub complete: bool,
}

impl RouthColumn {
    /// Scheme of a polynomial, highest power first.
    ///
    /// # Errors
    /// [`Error::Empty`], [`Error::NotFinite`] or [`Error::LeadingZero`].
    pub fn of(coefficients: &[f64]) -> Result<Self, Error> {
        check("the polynomial", coefficients)?;
        let row = |from: usize| coefficients[from..].iter().step_by(2).copied();
        let (mut above, mut row): (Vec<f64>, Vec<f64>) = if coefficients.len() > 1 {
            (row(0).collect(), row(1).collect())
        } else {
            (row(0).collect(), Vec::new())
        };
        let mut first = vec![above[0]];
        for _ in 1..coefficients.len() {
            if row[0] == 0.0 {
                return Ok(Self {
                    first,
                    complete: false,
                });
            }
            first.push(row[0]);
            let next = (1..above.len())
                .map(|i| above[i] - above[0] * row.get(i).copied().unwrap_or(0.0) / row[0])
                .collect();
            above = std::mem::replace(&mut row, next);
        }
        Ok(Self {
            first,
            complete: true,
        })
    }

    /// Number of roots in the right half plane; `None` if the scheme ended early.
    #[must_use]
    pub fn unstable_roots(&self) -> Option<usize> {
        let changes = self.first.windows(2).filter(|pair| pair[0] * pair[1] < 0.0);
        self.complete.then(|| changes.count())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Complex, polynomial};

    #[test]
    fn the_sign_changes_are_the_roots_right_of_the_axis() {
        let real = |x: f64| Complex::new(x, 0.0);
        for roots in [
            vec![real(-1.0), real(-2.0), real(-3.0)],
            vec![real(1.0), real(-2.0), real(3.0), real(-4.0)],
            vec![Complex::new(0.3, 2.0), Complex::new(0.3, -2.0), real(-1.0)],
        ] {
            let expected = roots.iter().filter(|s| s.re > 0.0).count();
            let column = RouthColumn::of(&polynomial::from_roots(&roots).unwrap()).unwrap();
            assert_eq!(column.unstable_roots(), Some(expected), "{column:?}");
        }
    }

    #[test]
    fn roots_on_the_axis_end_the_scheme() {
        let column = RouthColumn::of(&[1.0, 1.0, 4.0, 4.0]).unwrap();
        assert_eq!(column.unstable_roots(), None);
        assert_eq!(RouthColumn::of(&[2.0]).unwrap().unstable_roots(), Some(0));
    }
}
