//! The options of a fit.

use planesman_fit::FitOptions;
use planesman_vehicle::six_dof::EditableFile;

use crate::error::SixDofError;
use crate::signals::SIGNALS;

planesman_text::choices! {
    /// The signals whose errors are minimised.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Cost {
        #[default]
        All = "all": "All signals",
        Velocities = "velocities": "Velocities alone; each window begins at its recorded pose, and outliers count less",
    }
}

/// Axes and unit of angles of a recorded motion; odometry has those of REP 103.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Axes {
    /// Whether y points to port or west and z up, instead of starboard or east and down.
    pub left_up: bool,
    /// Whether angles and angular rates are in degrees.
    pub degrees: bool,
}

/// The options of [`fit_six_dof`](crate::fit_six_dof).
#[derive(Clone, Debug)]
pub struct SixDofOptions {
    /// The recording, with the windows used and the definition of a gap.
    pub data: FitOptions,
    /// `NAME=SIGNAL`, where the name is that of an input of the vehicle or one of [`SIGNALS`].
    pub signals: Vec<String>,
    /// The initial vehicle: a built-in one or a file.
    pub like: String,
    /// Inputs of the vehicle that are not recorded and assumed to be 0.
    pub zero: Vec<String>,
    /// Numbers or groups that are not changed.
    pub fixed: Vec<String>,
    /// Numbers or groups to estimate, or `all`; empty for those that are not 0, without the group `body`.
    pub free: Vec<String>,
    /// The relative prior standard deviation of each number.
    pub prior: f64,
    /// A number is determined if half of its 95 % interval is at most this share of its value.
    pub bound: f64,
    /// Signals with a constant error to be estimated.
    pub bias: Vec<String>,
    /// The longest time that the motion is simulated from one initial state \[s\].
    pub horizon: f64,
    /// The time over which predictions from measured states are judged \[s\]; half and twice as long ones are computed too.
    pub predict: f64,
    /// The signals whose errors are minimised.
    pub cost: Cost,
    /// The delays of the inputs to estimate.
    pub delay: Delay,
    /// The axes and the unit of angles of the recorded motion.
    pub axes: Axes,
    /// A signal that is 0 where samples are not to be used.
    pub mask: Option<String>,
}

impl Default for SixDofOptions {
    fn default() -> Self {
        Self {
            data: FitOptions::default(),
            signals: Vec::new(),
            like: String::new(),
            zero: Vec::new(),
            fixed: Vec::new(),
            free: Vec::new(),
            prior: 0.5,
            bound: 0.5,
            bias: ["u", "v", "w", "p", "q", "r"].map(str::to_owned).into(),
            horizon: 30.0,
            predict: 10.0,
            cost: Cost::All,
            delay: Delay::None,
            axes: Axes::default(),
            mask: None,
        }
    }
}

planesman_text::choices! {
    /// The delays of the inputs that are estimated.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Delay {
        #[default]
        None = "none": "Each input acts at once",
        Common = "common": "One delay of all inputs",
        Each = "each": "One delay of each input",
        Automatic = "automatic": "One of each of up to six inputs, else one of all",
    }
}

/// Up to so many inputs have a delay each, unless one is asked for.
const FEW_INPUTS: usize = 6;

impl Delay {
    /// The number of delays to estimate for so many inputs.
    pub(crate) const fn count(self, inputs: usize) -> usize {
        match self {
            Self::None => 0,
            Self::Automatic if inputs <= FEW_INPUTS => inputs,
            Self::Common | Self::Automatic => 1,
            Self::Each => inputs,
        }
    }
}

impl SixDofOptions {
    /// The recorded signals with a constant error to estimate.
    pub(crate) fn biased(&self, channels: &[usize]) -> Result<Vec<usize>, SixDofError> {
        let names = || SIGNALS.iter().map(|it| it.0);
        let mut biased = Vec::new();
        for name in &self.bias {
            let place = names().position(|it| it == name);
            let place = place.ok_or_else(|| SixDofError::no_number("bias", name, names()))?;
            biased.extend(channels.contains(&place).then_some(place));
        }
        Ok(biased)
    }

    /// Options for the record of a real vehicle that is hardly like the initial one: all numbers but thrust, whose scale is that of the masses,
    /// with wide priors; velocities over 4 s, outliers that count less, delays of the inputs.
    #[must_use]
    pub fn of_a_real_vehicle() -> Self {
        Self {
            free: vec!["all".to_owned()],
            fixed: vec!["thrust".to_owned()],
            prior: 3.0,
            bias: Vec::new(),
            horizon: 4.0,
            cost: Cost::Velocities,
            delay: Delay::Automatic,
            ..Self::default()
        }
    }

    /// The indices of the numbers to estimate.
    pub(crate) fn sought(&self, file: &EditableFile) -> Result<Vec<usize>, SixDofError> {
        let names = || file.numbers().iter().map(|it| it.name.as_str());
        let named = |option, words: &[String]| {
            let each = words.iter().map(|word| {
                let found = file.named(word);
                found.ok_or_else(|| SixDofError::no_number(option, word, names()))
            });
            Ok::<_, SixDofError>(each.collect::<Result<Vec<_>, _>>()?.concat())
        };
        let (free, fixed) = (named("free", &self.free)?, named("fixed", &self.fixed)?);
        let is_sought = |place: &usize| match self.free.is_empty() {
            true => file.numbers()[*place].is_sought_by_default() && !fixed.contains(place),
            false => free.contains(place) && !fixed.contains(place),
        };
        let sought: Vec<usize> = (0..file.numbers().len()).filter(is_sought).collect();
        match sought.is_empty() {
            true => Err(SixDofError::NothingSought),
            false => Ok(sought),
        }
    }
}
