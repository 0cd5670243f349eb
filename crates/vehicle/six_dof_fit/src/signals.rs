//! The signals of a vehicle's motion.

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
