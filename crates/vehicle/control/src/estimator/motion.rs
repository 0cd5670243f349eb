//! The measured and the estimated motion in the vertical plane.

/// The readings of the instruments at one stamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Measurement {
    /// The reading of the rate gyro, rad/s, positive bow up.
    pub pitch_rate: f64,
    /// The reading of the depth cell, m, positive down; `None` beyond the cell's range.
    pub depth: Option<f64>,
    /// The speed through the water, m/s.
    pub speed: f64,
}

/// The estimate used for feedback.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Estimate {
    /// rad, positive bow up
    pub pitch: f64,
    /// rad/s, positive bow up
    pub pitch_rate: f64,
    /// m, positive down
    pub depth: f64,
    /// m/s, positive down
    pub depth_rate: f64,
    /// The gyro's zero, rad/s; 0 if it is not estimated.
    pub gyro_bias: f64,
}
