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
//! - `pitch_model`: `k`, `b`, `m` over the speed, also from an identified model.
//! - `schedule`: gains for such a model and speed.
//! - `trust`, `distrust`: conditions on an identified model, and why one is not used.
//! - `adaptive`: the schedule on what `sysid` identifies, as far as that can be trusted.
//! - `from_file`: the schedule on what it has identified before, from a model file.
//! - `follower`: the gains in force at a tick.

mod adaptive;
mod distrust;
mod follower;
mod from_file;
mod pitch_model;
mod schedule;
mod trust;

pub use distrust::{Distrust, FileError};
pub use follower::{Follower, Rules, Source};
pub use from_file::FromFile;
pub use pitch_model::{FIRST_PAIR, PitchModel, SpeedLaw, is_of_pitch};
#[cfg(test)]
pub(crate) use schedule::tests::T6;
pub use schedule::{LoopGains, Schedule};
pub use trust::Trust;
