//! Location of events: finds where a margin, a quantity with its rate, falls below zero.

/// Tolerance of a zero: Newton's last step relative to the search interval. The remaining margin is of the order of its square.
const NEWTON_STEP: f64 = 1e-9;

/// Minimum of a margin that falls at `low` and rises at `high`, by bisection.
#[must_use]
pub fn lowest_point(mut low: f64, mut high: f64, margin: impl Fn(f64) -> (f64, f64)) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if margin(middle).1 < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

/// First zero of a margin that is positive at `low` and negative at `high`: Newton's method, kept within the bracket by bisection.
#[must_use]
pub fn first_below_zero(low: f64, high: f64, margin: impl Fn(f64) -> (f64, f64)) -> f64 {
    below_zero_near(0.5 * (low + high), low, high, margin)
}

/// Like [`first_below_zero`], for a zero that is probably near `t`.
#[must_use]
pub fn below_zero_near(
    mut t: f64,
    mut low: f64,
    mut high: f64,
    margin: impl Fn(f64) -> (f64, f64),
) -> f64 {
    let close_enough = NEWTON_STEP * (high - low);
    while high - low > close_enough {
        let (value, rate) = margin(t);
        if value < 0.0 {
            high = t;
        } else {
            low = t;
        }
        let newton = t - value / rate;
        if (newton - t).abs() <= close_enough {
            return newton.clamp(low, high);
        }
        t = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_falling_margin_is_followed_to_its_zero_and_one_that_turns_to_its_lowest_point() {
        let cosine = |t: f64| (libm::cos(t), -libm::sin(t));
        let zero = first_below_zero(0.0, 3.0, cosine);
        assert!((zero - std::f64::consts::FRAC_PI_2).abs() < 1e-15, "{zero}");
        let lowest = lowest_point(1.0, 5.0, cosine);
        assert!((lowest - std::f64::consts::PI).abs() < 1e-15, "{lowest}");
    }
}
