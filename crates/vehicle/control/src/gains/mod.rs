//! Gains that follow the vehicle.
//!
//! The gains of program T6 (Brunner, NPS thesis, 1988, App. C) suit one speed only: with depth gain `Kpz` alone the loop is unstable above
//! a critical speed (p. 20; 2.27 ft/s with the report's damping). Its depth loop is
//!
//! ```text
//! s^3 + B' s^2 + (k' + m + Kdz k' U) s + Kpz k' U       k' = Kpy k,   B' = b + Kr k
//! ```
//! with the vehicle's `k = K/J`, `b = B/J`, `m = Me/J`. As the vehicle changes, the roots of this polynomial stay where the fixed gains
//! place them at the reference speed, except for a factor by which stronger planes make the loop faster (and for `m`, for which no gain is
//! changed):
//!
//! - `pitch_model`: `k`, `b`, `m` over speed, also from an identified model.
//! - `schedule`: gains for such a model and speed.
//! - `trust`, `distrust`: conditions on an identified model, and the reasons to reject one.
//! - `adaptive`: the schedule on the model that `sysid` identifies, as long as that model can be trusted.
//! - `from_file`: the schedule on a model file.
//! - `follower`: the gains at a tick.

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
