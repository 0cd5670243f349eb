//! Why there is no vehicle.

use planesman_fit::FitError;
use planesman_vehicle::six_dof::FileError;

/// Why there is no vehicle.
#[derive(Debug, thiserror::Error)]
pub enum SixDofError {
    /// A vehicle that is refused.
    #[error(transparent)]
    Vehicle(#[from] FileError),
    /// Options that do not go together, data that cannot be read.
    #[error(transparent)]
    Data(#[from] FitError),
    /// A word that names nothing of a vehicle.
    #[error("--{option} {word}: it names none of {names}")]
    NoNumber {
        /// The option.
        option: &'static str,
        /// The word.
        word: String,
        /// What there is.
        names: String,
    },
    /// Every number stays.
    #[error("no number is sought: --fixed takes all of them, or --free names numbers that are 0")]
    NothingSought,
    /// A recording without motion.
    #[error(
        "no signal of the motion is found ({0}): name them, --signal u=SIGNAL; planesman sysid topics lists the signals"
    )]
    NoMotion(String),
    /// Several topics of odometry, none of which is called odom.
    #[error(
        "several topics have odometry ({0}): name the signals, --signal u=TOPIC:twist.twist.linear.x"
    )]
    Odometry(String),
    /// Angles that are none in rad.
    #[error("{0}: beyond a whole turn; angles are in rad, convert degrees first")]
    Degrees(&'static str),
    /// Hardly more samples than unknowns.
    #[error(
        "{samples} samples for {unknown} unknowns, initial states among them: record longer, or seek fewer numbers, --free NAME,..."
    )]
    FewSamples {
        /// Samples of all signals.
        samples: usize,
        /// Unknowns.
        unknown: usize,
    },
    /// A search without a finite start.
    #[error(
        "the motion of '{0}' does not stay finite over a window of the recording: look at its signals and their signs, or make --horizon shorter"
    )]
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
