//! Saturation and rate limits: the symmetric limits on the pitch command (±45°) and the dive planes (±30°) of Brunner (NPS thesis, 1988,
//! ch. II.B), and the bound that keeps every intermediate term finite.
//!
//! Program T6 (App. C) has no limiter although its 5 ft step starts with a pitch command of 71.6° and a plane command of 50.1°; the thesis
//! states the limits in its text. The plane limit acts on the sum of all terms, like the mechanical stop.

/// The largest magnitude of a term within the loops, in any unit. The limit is far beyond any vehicle, and small enough that sums of terms stay
/// finite.
const LARGEST_TERM: f64 = 1e300;

/// Limits a term of a control law to finite values: products and differences of finite numbers can overflow, and an infinite term would
/// leave the node or give NaN.
#[must_use]
pub(crate) fn bounded(term: f64) -> f64 {
    term.clamp(-LARGEST_TERM, LARGEST_TERM)
}

/// A symmetric limit, `[-bound, bound]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    bound: f64,
}

/// The bound is not positive and finite.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a limit of ±{0} refused: it must be positive")]
pub struct LimitError(pub f64);

/// A value after a [`Limit`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limited {
    /// The value after the limit, in the unit of the limited quantity.
    pub value: f64,
    /// Whether the value is at the limit.
    pub at_limit: bool,
}

impl Limit {
    /// The limit `±bound`, in the unit of the limited quantity.
    ///
    /// # Errors
    /// [`LimitError`], if the bound is not positive and finite.
    pub fn new(bound: f64) -> Result<Self, LimitError> {
        if bound.is_finite() && bound > 0.0 {
            Ok(Self { bound })
        } else {
            Err(LimitError(bound))
        }
    }

    /// The bound, in the unit of the limited quantity.
    #[must_use]
    pub fn bound(&self) -> f64 {
        self.bound
    }

    /// `value`, limited to the bound.
    #[must_use]
    pub fn apply(&self, value: f64) -> Limited {
        Limited {
            value: value.clamp(-self.bound, self.bound),
            at_limit: value.abs() >= self.bound,
        }
    }
}

/// Moves from `from` towards `to`, by at most `rate` per second for `dt` seconds; a `rate` of 0 means no limit.
#[must_use]
pub(crate) fn slewed(from: f64, to: f64, rate: f64, dt: f64) -> f64 {
    if rate == 0.0 {
        return to;
    }
    let reach = bounded(rate * dt);
    to.clamp(bounded(from - reach), bounded(from + reach))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_passes_what_is_inside_and_stops_what_is_beyond() {
        let limit = Limit::new(0.5).unwrap();
        for (value, limited_value, at_limit) in [
            (0.2, 0.2, false),
            (-0.49, -0.49, false),
            (0.5, 0.5, true),
            (7.0, 0.5, true),
            (-7.0, -0.5, true),
            (f64::INFINITY, 0.5, true),
        ] {
            let limited = limit.apply(value);
            assert_eq!((limited.value, limited.at_limit), (limited_value, at_limit));
        }
    }

    #[test]
    fn a_limit_is_positive() {
        for bound in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Limit::new(bound).is_err());
        }
    }

    #[test]
    fn a_slewed_value_arrives_at_its_rate_and_stays() {
        assert_eq!(slewed(0.0, 1.0, 2.0, 0.25), 0.5);
        assert_eq!(slewed(0.0, -1.0, 2.0, 0.25), -0.5);
        assert_eq!(slewed(0.9, 1.0, 2.0, 0.25), 1.0);
        assert_eq!(slewed(0.0, 1.0, 0.0, 0.25), 1.0, "no limit");
        assert_eq!(slewed(0.0, 1.0, 2.0, 0.0), 0.0, "no time");
    }

    #[test]
    fn the_largest_terms_add_up_to_a_number() {
        let term = bounded(f64::MAX * f64::MAX);
        assert!((term + term + term).is_finite());
        assert_eq!(bounded(-f64::INFINITY), -term);
    }
}
