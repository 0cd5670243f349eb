//! Reasons why no vehicle can be fitted.

use planesman_fit::FitError;
use planesman_text::{option, setting};
use planesman_vehicle::six_dof::FileError;

/// Reasons why no vehicle can be fitted.
#[derive(Debug, thiserror::Error)]
pub enum SixDofError {
    /// The vehicle file is invalid.
    #[error(transparent)]
    Vehicle(#[from] FileError),
    /// Conflicting options, or data that cannot be read.
    #[error(transparent)]
    Data(#[from] FitError),
    /// A word that matches no number of the vehicle.
    #[error("{}: no such name; known: {names}", setting(option, word))]
    NoNumber {
        /// The option.
        option: &'static str,
        /// The word.
        word: String,
        /// The known names.
        names: String,
    },
    /// No number is left to estimate.
    #[error(
        "no number is estimated: {} excludes all numbers, or {} names only numbers that are 0",
        option("fixed"),
        option("free")
    )]
    NothingSought,
    /// The recording has no signal of the motion.
    #[error(
        "no signals of the motion were found ({}). Name the signals with {}; planesman sysid topics lists them", .0, setting("signal", "u=SIGNAL"))]
    NoMotion(String),
    /// Several topics have odometry, and no topic is called odom.
    #[error(
        "several topics have odometry ({}). Name the signals with {}", .0, setting("signal", "u=TOPIC:twist.twist.linear.x"))]
    Odometry(String),
    /// Angles that cannot be in rad.
    #[error("{} is larger than a whole turn. If the angles are in degrees, give {}", .0, option("degrees"))]
    Degrees(&'static str),
    /// Hardly more samples than unknowns.
    #[error(
        "{samples} samples for {unknown} unknowns, including initial states, are too few. Record for longer, or estimate fewer numbers with {}",
        setting("free", "NAME,...")
    )]
    FewSamples {
        /// Number of samples of all signals.
        samples: usize,
        /// Unknowns.
        unknown: usize,
    },
    /// The recording contradicts itself, and the search has no finite start.
    #[error("the recording contradicts itself: {}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Contradictory(Vec<crate::kinematics::Contradiction>),
    /// The search has no finite start.
    #[error(
        "the motion of '{}' diverges within a window of the recording. Check the signals and their signs, or make {} shorter", .0, option("horizon"))]
    Diverges(String),
}

impl SixDofError {
    pub(crate) fn no_number<'a>(
        option: &'static str,
        word: &str,
        names: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        Self::NoNumber {
            option,
            word: word.to_owned(),
            names: names.into_iter().collect::<Vec<_>>().join(", "),
        }
    }
}
