//! Where a margin, a quantity with its rate, falls below zero: how events are located.

/// How exactly a zero is found: Newton's last step relative to the stretch searched. Its square
/// is what then remains of the margin.
const NEWTON_STEP: f64 = 1e-9;

/// Where a margin that falls at `low` and rises at `high` turns, by halving.
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

/// Where a margin falls below zero between `low`, where it has not, and `high`, where it has:
/// Newton's method, kept within the bracket by halving.
#[must_use]
pub fn first_below_zero(low: f64, high: f64, margin: impl Fn(f64) -> (f64, f64)) -> f64 {
    below_zero_near(0.5 * (low + high), low, high, margin)
}

/// The same, where it is likely to be near `t`.
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
