//! The tasks: initial state, observations, reward, and end of an episode.

use std::f64::consts::{PI, TAU};

use planesman_vehicle::six_dof::{State, rotation};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::Rng as _;
use serde::Deserialize;

/// The task of an episode.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Task {
    /// Reach a depth and keep it.
    Depth,
    /// Reach a heading and keep it.
    Heading,
    /// Enter a dock in the direction in which the dock points.
    Docking,
    /// Keep a place and heading in a current.
    Station,
}

/// End of an environment's step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// The episode continues.
    #[default]
    Running,
    /// The goal is reached.
    Succeeded,
    /// The goal can no longer be reached.
    Failed,
    /// The time is over.
    TimeUp,
}

/// The common initial conditions of all episodes, and the time of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conditions {
    /// Speed through the water \[m/s\]; 0 for a vehicle that hovers.
    pub(crate) speed: f64,
    /// Least and largest speed of the current \[m/s\].
    pub(crate) current: [f64; 2],
    /// \[s\]
    pub(crate) step: f64,
}

/// An observed quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The largest value that is observed.
    pub bound: f64,
    /// For a sensor: standard deviation of its noise, and of its bias, which is drawn for each episode.
    pub deviation: f64,
}

const fn quantity(name: &'static str, unit: &'static str, bound: f64, deviation: f64) -> Quantity {
    Quantity {
        name,
        unit,
        bound,
        deviation,
    }
}

/// Maximum number of quantities in an observation.
pub(crate) const MOST: usize = 12;

const HEADING_ERROR: Quantity = quantity("heading_error", "rad", PI, 0.01);
const ROLL: Quantity = quantity("roll", "rad", PI, 0.005);
const PITCH: Quantity = quantity("pitch", "rad", PI / 2.0, 0.005);
const SURGE: Quantity = quantity("surge", "m/s", 10.0, 0.01);
const SWAY: Quantity = quantity("sway", "m/s", 10.0, 0.01);
const HEAVE: Quantity = quantity("heave", "m/s", 10.0, 0.01);
const ROLL_RATE: Quantity = quantity("roll_rate", "rad/s", 10.0, 0.002);
const PITCH_RATE: Quantity = quantity("pitch_rate", "rad/s", 10.0, 0.002);
const YAW_RATE: Quantity = quantity("yaw_rate", "rad/s", 10.0, 0.002);
const DEPTH_ERROR: Quantity = quantity("depth_error", "m", 50.0, 0.02);
const DEPTH_RATE: Quantity = quantity("depth_rate", "m/s", 5.0, 0.02);

const DEPTH: [Quantity; 4] = [DEPTH_ERROR, DEPTH_RATE, PITCH, PITCH_RATE];
const HEADING: [Quantity; 4] = [HEADING_ERROR, YAW_RATE, SWAY, ROLL];
/// The place of the dock, in the dock's axes.
const DOCKING: [Quantity; MOST] = [
    quantity("ahead", "m", 200.0, 0.1),
    quantity("starboard", "m", 200.0, 0.1),
    quantity("below", "m", 200.0, 0.02),
    HEADING_ERROR,
    ROLL,
    PITCH,
    SURGE,
    SWAY,
    HEAVE,
    ROLL_RATE,
    PITCH_RATE,
    YAW_RATE,
];

/// The position of an episode's target, and its direction. North and east of the target are 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub(crate) depth: f64,
    pub(crate) heading: f64,
}

/// An episode's beginning.
pub(crate) struct Start {
    pub(crate) state: State,
    pub(crate) target: Target,
    /// North, east, down \[m/s\].
    pub(crate) current: [f64; 3],
}

/// The depth of targets \[m\], far from the surface.
const DEPTH_OF_TARGETS: f64 = 20.0;
/// Radius of the dock's mouth \[m\], and the largest angle at which a vehicle can enter \[rad\].
const MOUTH: f64 = 0.5;
const STEEPEST: f64 = 0.35;
/// The largest speed in the dock's mouth for a vehicle that hovers \[m/s\].
const GENTLE: f64 = 0.5;
/// Final reward in the dock, and penalty outside \[m\].
const PRIZE: f64 = 10.0;
/// At a larger distance from its target a vehicle has failed \[m\].
const LOST: f64 = 50.0;

/// A number from a uniform distribution.
pub(crate) fn uniform(random: &mut Pcg64, [least, most]: [f64; 2]) -> f64 {
    let share = (random.next_u64() >> 11) as f64 * (0.5_f64).powi(53);
    least + share * (most - least)
}

fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

impl Task {
    /// The observed quantities, in order.
    #[must_use]
    pub fn quantities(self) -> &'static [Quantity] {
        match self {
            Self::Depth => &DEPTH,
            Self::Heading => &HEADING,
            Self::Docking | Self::Station => &DOCKING,
        }
    }

    /// Duration of an episode \[s\].
    pub(crate) fn duration(self) -> f64 {
        match self {
            Self::Depth => 40.0,
            Self::Heading => 20.0,
            Self::Docking | Self::Station => 60.0,
        }
    }

    /// Least and largest speed of the current \[m/s\], for a vehicle with an initial speed.
    pub(crate) fn current(self, speed: f64) -> [f64; 2] {
        match self {
            Self::Depth | Self::Heading => [0.0, 0.3],
            Self::Docking => [0.0, 0.1],
            // A vehicle that steers by fins needs water that streams past them.
            Self::Station if speed > 0.0 => [0.8, 1.2],
            Self::Station => [0.0, 0.3],
        }
    }

    /// Draws an episode.
    pub(crate) fn begin(self, conditions: &Conditions, random: &mut Pcg64) -> Start {
        let cruises = conditions.speed > 0.0;
        let mut draw = |size: f64| uniform(random, [-size, size]);
        let mut target = Target {
            depth: DEPTH_OF_TARGETS,
            heading: 0.0,
        };
        let mut position = [0.0, 0.0, DEPTH_OF_TARGETS];
        let mut angles = [0.0, draw(0.1), 0.0];
        match self {
            Self::Depth => {
                position[2] += draw(if cruises { 5.0 } else { 2.0 });
                angles[2] = draw(PI);
            }
            Self::Heading => {
                angles[2] = draw(PI);
                target.heading = wrapped(angles[2] + draw(PI / 2.0));
            }
            Self::Docking if cruises => {
                position = [-30.0 + draw(10.0), draw(4.0), DEPTH_OF_TARGETS + draw(2.0)];
                angles[2] = draw(0.2);
            }
            Self::Docking => {
                position = [-6.0 + draw(2.0), draw(2.0), DEPTH_OF_TARGETS + draw(1.0)];
                angles[2] = draw(0.5);
            }
            Self::Station => {
                for (k, size) in [(0, 2.0), (1, 2.0), (2, 1.0)] {
                    position[k] += draw(size);
                }
                angles[2] = draw(if cruises { 0.2 } else { 0.5 });
            }
        }
        let toward = match self {
            // It meets the stream bow on.
            Self::Station if cruises => PI + draw(0.2),
            _ => draw(PI),
        };
        let (east, north) = libm::sincos(toward);
        let speed = uniform(random, conditions.current);
        let current = [north * speed, east * speed, 0.0];
        let attitude = rotation::from_euler(angles);
        let [mut u, mut v, mut w] = [0.0; 3];
        if self != Self::Station {
            // Carried by the stream.
            [u, v, w] = rotation::to_body(&rotation::matrix(attitude), current);
            u += conditions.speed;
        }
        Start {
            state: State {
                position,
                attitude,
                velocity: [u, v, w, 0.0, 0.0, 0.0],
            },
            target,
            current,
        }
    }

    /// The observed values, in the order of [`Task::quantities`].
    pub(crate) fn numbers(self, state: &State, target: Target) -> [f64; MOST] {
        let r = rotation::matrix(state.attitude);
        let [roll, pitch, yaw] = rotation::euler(state.attitude);
        let [u, v, w, p, q, yaw_rate] = state.velocity;
        let heading_error = wrapped(target.heading - yaw);
        let [x, y, z] = state.position;
        let below = target.depth - z;
        let mut numbers = [0.0; MOST];
        match self {
            Self::Depth => {
                let sinking = rotation::to_fixed(&r, [u, v, w])[2];
                numbers[..4].copy_from_slice(&[below, sinking, pitch, q]);
            }
            Self::Heading => {
                numbers[..4].copy_from_slice(&[heading_error, yaw_rate, v, roll]);
            }
            Self::Docking | Self::Station => {
                // The dock's axes, which point north; those of the vehicle's heading.
                let (sin, cos) = match self {
                    Self::Station => libm::sincos(yaw),
                    _ => (0.0, 1.0),
                };
                let (ahead, starboard) = (-x * cos - y * sin, x * sin - y * cos);
                numbers = [
                    ahead,
                    starboard,
                    below,
                    heading_error,
                    roll,
                    pitch,
                    u,
                    v,
                    w,
                    p,
                    q,
                    yaw_rate,
                ];
            }
        }
        numbers
    }

    /// The reward of a step from `before` to `after`, and the outcome if the episode ends. `effort` is the mean of the squared actions.
    ///
    /// All tasks except docking give the reward `step / (1 + cost)`: at most the time step, and a part of it even far from the target. Docking
    /// rewards each metre of approach.
    pub(crate) fn judge(
        self,
        conditions: &Conditions,
        before: &[f64; MOST],
        after: &[f64; MOST],
        effort: f64,
    ) -> (f64, Outcome) {
        let share = |error: f64, size: f64| (error / size) * (error / size);
        let distance = |of: &[f64; MOST]| (of[0] * of[0] + of[1] * of[1] + of[2] * of[2]).sqrt();
        let earned = |cost: f64| conditions.step / (1.0 + cost + 0.1 * effort);
        let within = |is_within: bool| match is_within {
            true => Outcome::Running,
            false => Outcome::Failed,
        };
        match self {
            Self::Depth => (earned(share(after[0], 0.5)), within(after[0].abs() < LOST)),
            Self::Heading => (earned(share(after[0], 0.1)), Outcome::Running),
            Self::Station => {
                let off = distance(after);
                (
                    earned(share(off, 0.5) + share(after[3], 0.3)),
                    within(off < LOST),
                )
            }
            Self::Docking => {
                let nearer = distance(before) - distance(after);
                let outcome = match after {
                    [ahead, ..] if *ahead > 0.0 => within(distance(after) < LOST),
                    [_, starboard, below, heading, _, pitch, u, v, w, ..] => {
                        let speed = (u * u + v * v + w * w).sqrt();
                        let is_taken = starboard * starboard + below * below < MOUTH * MOUTH
                            && heading.abs() < STEEPEST
                            && pitch.abs() < STEEPEST
                            && (conditions.speed > 0.0 || speed < GENTLE);
                        match is_taken {
                            true => Outcome::Succeeded,
                            false => Outcome::Failed,
                        }
                    }
                };
                let prize = match outcome {
                    Outcome::Succeeded => PRIZE,
                    Outcome::Failed => -PRIZE,
                    Outcome::Running | Outcome::TimeUp => 0.0,
                };
                (nearer + prize, outcome)
            }
        }
    }
}
