//! The linear trend of a signal.

/// The straight line with the best least-squares fit to values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightLine {
    /// The value in the middle, equal to the mean.
    pub mean: f64,
    /// Slope of the line per sample.
    pub slope: f64,
    /// The share of the values' variation about their mean that the line explains, 0 to 1.
    pub share: f64,
}

impl StraightLine {
    /// Fits a line by least squares.
    #[must_use]
    pub fn nearest_to(values: &[f64]) -> Self {
        let count = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / count;
        let middle = 0.5 * (count - 1.0);
        let (mut product, mut square, mut variation) = (0.0, 0.0, 0.0);
        for (k, value) in values.iter().enumerate() {
            let (from_middle, from_mean) = (k as f64 - middle, value - mean);
            product += from_middle * from_mean;
            square += from_middle * from_middle;
            variation += from_mean * from_mean;
        }
        let share = product * product / (square * variation);
        Self {
            mean,
            slope: if square > 0.0 { product / square } else { 0.0 },
            share: if share.is_finite() { share } else { 0.0 },
        }
    }
}
