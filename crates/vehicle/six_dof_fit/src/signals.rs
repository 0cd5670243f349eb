//! The signals of a vehicle's motion.

use std::f64::consts::TAU;
use std::ops::Range;

/// The signals of a vehicle's motion that may be measured: name and unit.
pub const SIGNALS: [(&str, &str); 12] = [
    ("north", "m"),
    ("east", "m"),
    ("depth", "m"),
    ("roll", "rad"),
    ("pitch", "rad"),
    ("yaw", "rad"),
    ("u", "m/s"),
    ("v", "m/s"),
    ("w", "m/s"),
    ("p", "rad/s"),
    ("q", "rad/s"),
    ("r", "rad/s"),
];

/// Indices of the angles among the signals.
const ANGLES: Range<usize> = 3..6;

/// `a - b` of a signal; for angles the shorter way.
pub(crate) fn apart(channel: usize, a: f64, b: f64) -> f64 {
    let turns = match ANGLES.contains(&channel) {
        true => ((a - b) / TAU).round(),
        false => 0.0,
    };
    a - b - TAU * turns
}
