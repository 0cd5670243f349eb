//! Gains that follow the vehicle.
//!
//! The gains of program T6 (Brunner, NPS thesis, 1988, App. C) are right for one speed: with depth
//! gain `Kpz` alone the loop is unstable above a critical speed (p. 20; 2.27 ft/s with the report's
//! damping). Its depth loop is
//!
//! ```text
//! s^3 + B' s^2 + (k' + m + Kdz k' U) s + Kpz k' U       k' = Kpy k,   B' = b + Kr k
//! ```
//! with the vehicle's `k = K/J`, `b = B/J`, `m = Me/J`. What is held here as the vehicle changes are this
//! polynomial's roots as the fixed gains place them at the reference speed, but for a factor by which
//! stronger planes make the loop faster (and for `m`, which no gain is changed for):
//!
//! - [`pitch_model`]: `k`, `b`, `m`, and how they go with the speed; from an identified model too.
//! - [`schedule`]: gains for such a model and speed.
//! - [`adaptive`]: the schedule on what `sysid` identifies, as far as that can be trusted.
//! - [`follower`]: the gains in force at a tick.

pub mod adaptive;
pub mod follower;
pub mod pitch_model;
pub mod schedule;

pub use adaptive::{Adaptive, Trust};
pub use follower::{Follower, Rules};
pub use pitch_model::{PitchModel, SpeedLaw};
pub use schedule::{LoopGains, Schedule};

/// Where the loops take their gains from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The parameters, whatever the speed.
    Fixed,
    /// The schedule on the parameters' model of the vehicle.
    Scheduled,
    /// The schedule on the identified model.
    Adaptive,
}

impl Source {
    /// The names, as the parameter takes them.
    pub const NAMES: &'static [&'static str] = &["fixed", "scheduled", "adaptive"];

    /// The source of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        [Self::Fixed, Self::Scheduled, Self::Adaptive]
            .into_iter()
            .zip(Self::NAMES)
            .find_map(|(source, known)| (*known == name).then_some(source))
    }
}
